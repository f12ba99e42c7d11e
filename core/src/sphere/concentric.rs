//! The hemisphere as a square: cells of equal cosine weight (Shirley and Chiu, *A Low Distortion Map Between Disk and
//! Square*, 1997).
//!
//! A direction of the hemisphere around +Z projects to a point of the unit disc. The disc maps to the unit square with
//! areas in proportion. So each cell of an `n` x `n` grid holds `π / n²` of the integral of the cosine. The edge of the
//! square is the horizon.
//!
//! The inverse uses a polynomial arctangent, for equal bits on all machines.

use glam::{UVec2, Vec2, Vec3};
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4};

/// The point of the unit disc for a point of the square from (0, 0) to (1, 1).
pub fn disc_from_square(square: Vec2) -> Vec2 {
    let p = 2.0 * square - 1.0;
    if p == Vec2::ZERO {
        p
    } else if p.x.abs() >= p.y.abs() {
        p.x * Vec2::from_angle(FRAC_PI_4 * p.y / p.x)
    } else {
        p.y * Vec2::from_angle(FRAC_PI_2 - FRAC_PI_4 * p.x / p.y)
    }
}

/// The point of the square from (0, 0) to (1, 1) for a point of the unit disc.
#[inline(always)]
pub fn square_from_disc(disc: Vec2) -> Vec2 {
    let (x, y) = (disc.x.abs(), disc.y.abs());
    let (long, short) = if x >= y { (x, y) } else { (y, x) };
    let radius = (x * x + y * y).sqrt();
    let turn = if long > 0.0 { radius * 2.0 * FRAC_2_PI * atan_of_unit(short / long) } else { 0.0 };
    let p = if x >= y { Vec2::new(radius, turn) } else { Vec2::new(turn, radius) };
    0.5 + 0.5 * Vec2::new(p.x.copysign(disc.x), p.y.copysign(disc.y))
}

/// The arctangent of a number from 0 to 1 (Abramowitz and Stegun, 4.4.49: to 2e-8, less than rounding).
#[inline(always)]
fn atan_of_unit(t: f32) -> f32 {
    const COEFFICIENTS: [f32; 8] = [
        0.002_866_225_7,
        -0.016_165_736_7,
        0.042_909_613_8,
        -0.075_289_640_0,
        0.106_562_639_3,
        -0.142_088_994_4,
        0.199_935_508_5,
        -0.333_331_452_8,
    ];
    let t_sq = t * t;
    t + t * t_sq * COEFFICIENTS.iter().fold(0.0, |sum, c| sum * t_sq + c)
}

/// The hemisphere around +Z in `side` x `side` cells of equal cosine weight, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HemisphereCells {
    /// Cells along an edge of the square.
    pub side: usize,
}

impl HemisphereCells {
    /// Number of cells.
    pub const fn len(self) -> usize {
        self.side * self.side
    }

    /// Whether there are no cells.
    pub const fn is_empty(self) -> bool {
        self.side == 0
    }

    /// The integral of the cosine over each cell, in steradians.
    pub fn weight(self) -> f32 {
        std::f32::consts::PI / self.len() as f32
    }

    /// The cell of a unit direction with z ≥ 0.
    pub fn cell_of(self, direction: Vec3) -> usize {
        let p = square_from_disc(direction.truncate()) * self.side as f32;
        let UVec2 { x, y } = p.as_uvec2().min(UVec2::splat(self.side as u32 - 1));
        y as usize * self.side + x as usize
    }

    /// The unit direction at the center of a cell.
    pub fn direction_of(self, cell: usize) -> Vec3 {
        self.direction_within(cell, Vec2::splat(0.5))
    }

    /// The unit direction at a place within a cell, from (0, 0) to (1, 1). Uniform places give cosine-distributed directions.
    pub fn direction_within(self, cell: usize, place: Vec2) -> Vec3 {
        let corner = Vec2::new((cell % self.side) as f32, (cell / self.side) as f32);
        let disc = disc_from_square((corner + place) / self.side as f32);
        disc.extend((1.0 - disc.length_squared()).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::cosine_direction;

    #[test]
    fn square_and_disc_are_inverse() {
        let mut rng = fastrand::Rng::with_seed(1);
        for _ in 0..10_000 {
            let square = Vec2::new(rng.f32(), rng.f32());
            let disc = disc_from_square(square);
            assert!(disc.length() <= 1.0 + 1e-6);
            assert!(square_from_disc(disc).distance(square) < 4e-6, "{square}");
        }
        assert_eq!(square_from_disc(Vec2::ZERO), Vec2::splat(0.5));
        assert_eq!(disc_from_square(Vec2::splat(0.5)), Vec2::ZERO);
    }

    #[test]
    fn the_edge_of_the_square_is_the_horizon() {
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            for edge in [Vec2::new(0.0, t), Vec2::new(1.0, t), Vec2::new(t, 0.0), Vec2::new(t, 1.0)] {
                assert!((disc_from_square(edge).length() - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn cells_hold_equal_shares_of_the_cosine() {
        let cells = HemisphereCells { side: 10 };
        let share = |direction: fn(f32, f32) -> Vec3| {
            let mut count = vec![0_u32; cells.len()];
            let n = 640;
            for i in 0..n * n {
                let place = [(i / n) as f32, (i % n) as f32].map(|x| (x + 0.5) / n as f32);
                count[cells.cell_of(direction(place[0], place[1]))] += 1;
            }
            let mean = (n * n) as f32 / cells.len() as f32;
            count.into_iter().map(|c| (c as f32 / mean - 1.0).abs()).fold(0.0, f32::max)
        };
        let of_cosine = share(cosine_direction);
        assert!(of_cosine < 0.02, "{of_cosine}");
        let of_solid_angle = share(|u, v| {
            let (z, (sin, cos)) = (u, (std::f32::consts::TAU * v).sin_cos());
            (Vec2::new(cos, sin) * (1.0 - z * z).sqrt()).extend(z)
        });
        assert!(of_solid_angle > 0.5, "negative control: solid angles differ, {of_solid_angle}");
    }

    #[test]
    fn a_direction_within_a_cell_lies_in_it() {
        let cells = HemisphereCells { side: 20 };
        for cell in 0..cells.len() {
            for place in [Vec2::splat(0.5), Vec2::new(0.05, 0.95), Vec2::new(0.9, 0.1)] {
                let direction = cells.direction_within(cell, place);
                assert!((direction.length() - 1.0).abs() < 1e-6 && direction.z >= 0.0);
                assert_eq!(cells.cell_of(direction), cell);
            }
        }
        assert!((cells.weight() * 400.0 - std::f32::consts::PI).abs() < 1e-6);
    }
}
