//! All directions as a square: an octahedron unfolded around its +Z corner.
//!
//! Finding the cell of a direction takes one division and no functions, so all machines agree. Edges of the middle row
//! of cells lie on the horizon, in front and behind. [`Knots`] are values to interpolate: the edge of the square is shared with
//! itself, so there is no seam.

use crate::simd::{Lanes, Vec3x8};
use glam::{Vec2, Vec3};

/// Cells along an edge of the square; even, for the horizon.
pub const SIDE: usize = 48;
/// Number of cells.
pub const CELLS: usize = SIDE * SIDE;

/// Against a division by zero.
const LEAST_LENGTH: f32 = 1e-20;

/// The cell of a direction, row by row.
pub fn cell_of(direction: Vec3) -> usize {
    let place = place_of(direction);
    let cell = |at: f32| ((at * SIDE as f32) as usize).min(SIDE - 1);
    cell(place.y) * SIDE + cell(place.x)
}

/// The unit direction at the center of a cell.
pub fn direction_of(cell: usize) -> Vec3 {
    let middle = Vec2::new((cell % SIDE) as f32, (cell / SIDE) as f32) + 0.5;
    direction_at(middle / SIDE as f32)
}

/// The place of a direction, from (0, 0) to (1, 1); of zero the middle.
#[inline(always)]
fn place_of(direction: Vec3) -> Vec2 {
    let length = direction.x.abs() + direction.y.abs() + direction.z.abs();
    let p = direction.truncate() / length.max(LEAST_LENGTH);
    let place = if direction.z >= 0.0 { p } else { folded(p) };
    0.5 + 0.5 * place
}

/// The unit direction at a place.
fn direction_at(place: Vec2) -> Vec3 {
    let place = place * 2.0 - 1.0;
    let z = 1.0 - place.x.abs() - place.y.abs();
    let p = if z >= 0.0 { place } else { folded(place) };
    p.extend(z).normalize()
}

/// Values at the knots of a `side` x `side` grid over the square, edges included, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knots {
    /// Knots along an edge of the square, at least 2.
    pub side: usize,
}

impl Knots {
    /// Number of knots.
    pub const fn len(self) -> usize {
        self.side * self.side
    }

    /// Whether there are no knots.
    pub const fn is_empty(self) -> bool {
        self.side == 0
    }

    /// The unit direction of a knot.
    pub fn direction_of(self, knot: usize) -> Vec3 {
        direction_at(Vec2::new((knot % self.side) as f32, (knot / self.side) as f32) / (self.side - 1) as f32)
    }

    /// The knot nearest to a direction in the square.
    pub fn nearest(self, direction: Vec3) -> usize {
        let place = place_of(direction) * (self.side - 1) as f32 + 0.5;
        place.y as usize * self.side + place.x as usize
    }

    /// The four knots around a direction with their weights, for bilinear interpolation.
    #[inline(always)]
    pub fn around(self, direction: Vec3) -> [(usize, f32); 4] {
        let place = place_of(direction) * (self.side - 1) as f32;
        let corner = place.floor().clamp(Vec2::ZERO, Vec2::splat((self.side - 2) as f32));
        let (first, share) = (corner.y as usize * self.side + corner.x as usize, place - corner);
        let [left, right] = [1.0 - share.x, share.x];
        [
            (first, left * (1.0 - share.y)),
            (first + 1, right * (1.0 - share.y)),
            (first + self.side, left * share.y),
            (first + self.side + 1, right * share.y),
        ]
    }

    /// [`Self::around`] for eight directions.
    #[inline(always)]
    pub fn around_x8<L: Lanes>(self, direction: Vec3x8<L>) -> KnotsX8 {
        let (zero, one, half) = (L::splat(0.0), L::splat(1.0), L::splat(0.5));
        let Vec3x8 { x, y, z } = direction;
        let scale = one / (x.abs() + y.abs() + z.abs()).at_least(LEAST_LENGTH);
        let (x, y, is_front) = (x * scale, y * scale, z.simd_ge(zero));
        let signed = |of: L, value: L| of.simd_ge(zero).select(value, -value);
        let (folded_x, folded_y) = (signed(x, one - y.abs()), signed(y, one - x.abs()));
        let last = L::splat((self.side - 1) as f32);
        let across = ((half + half * is_front.select(x, folded_x)) * last).to_array();
        let along = ((half + half * is_front.select(y, folded_y)) * last).to_array();
        let mut knots = KnotsX8 { first: [0; 8], right: [0.0; 8], down: [0.0; 8] };
        for i in 0..8 {
            let corner = [across[i], along[i]].map(|place| (place as i32).clamp(0, self.side as i32 - 2));
            knots.first[i] = corner[1] as usize * self.side + corner[0] as usize;
            knots.right[i] = across[i] - corner[0] as f32;
            knots.down[i] = along[i] - corner[1] as f32;
        }
        knots
    }
}

/// The first of the four knots around each of eight directions, and the weights of those beside and below it.
#[derive(Clone, Copy, Debug)]
pub struct KnotsX8 {
    /// Row by row.
    pub first: [usize; 8],
    /// From 0 to 1.
    pub right: [f32; 8],
    /// From 0 to 1.
    pub down: [f32; 8],
}

/// Maps a place of the square to its point in the lower half, and back.
fn folded(p: Vec2) -> Vec2 {
    let sign = |of: f32| if of >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;
    use wide::f32x8;

    #[test]
    fn cells_are_found_by_their_directions() {
        for cell in 0..CELLS {
            assert_eq!(cell_of(direction_of(cell)), cell);
            assert!(direction_of(cell).is_normalized());
        }
    }

    #[test]
    fn directions_lie_near_the_middle_of_their_cell_and_on_its_side_of_the_horizon() {
        for direction in fibonacci_directions(20_000) {
            let middle = direction_of(cell_of(direction));
            assert!(middle.dot(direction) > 0.995, "{direction}");
            assert_eq!(middle.y > 0.0, direction.y > 0.0, "{direction}");
        }
    }

    #[test]
    fn knots_interpolate_smoothly_also_across_the_edge_of_the_square() {
        let knots = Knots { side: 8 };
        let smooth = |direction: Vec3| 2.0 + direction.x + 0.5 * direction.y * direction.z;
        let values: Vec<f32> = (0..knots.len()).map(|knot| smooth(knots.direction_of(knot))).collect();
        let at = |direction: Vec3| -> f32 { knots.around(direction).iter().map(|&(knot, w)| w * values[knot]).sum() };
        for direction in fibonacci_directions(5000) {
            assert!((at(direction) - smooth(direction)).abs() < 0.12, "{direction}");
            let nearest = knots.direction_of(knots.nearest(direction));
            // Half a diagonal of the grid, in the middle of a face, where the square is stretched most.
            assert!(nearest.dot(direction) > 0.8, "{direction} {nearest}");
        }
        for eight in fibonacci_directions(4096).chunks_exact(8) {
            let found = knots.around_x8(Vec3x8::<f32x8>::from_array(eight.try_into().unwrap()));
            for (i, &direction) in eight.iter().enumerate() {
                let around = knots.around(direction);
                let share = [(1.0 - found.right[i]) * (1.0 - found.down[i]), found.right[i] * found.down[i]];
                assert_eq!(found.first[i], around[0].0);
                assert!((share[0] - around[0].1).abs() < 1e-5 && (share[1] - around[3].1).abs() < 1e-5, "{direction}");
            }
        }
        for knot in 0..knots.len() {
            assert!((at(knots.direction_of(knot)) - values[knot]).abs() < 1e-5);
            let nearest = values[knots.nearest(knots.direction_of(knot))];
            assert!((nearest - values[knot]).abs() < 1e-5, "knots of the edge come twice");
        }
        // Behind, across the folded edges.
        for (x, y) in [(0.3_f32, 0.0_f32), (0.0, 0.4), (0.1, 0.6), (-0.5, 0.0), (0.0, -0.2)] {
            let [one, other] = [1e-4_f32, -1e-4].map(|off| {
                let (x, y) = if x == 0.0 { (off, y) } else { (x, y + off) };
                at(Vec3::new(x, y, -(1.0 - x * x - y * y).sqrt()))
            });
            assert!((one - other).abs() < 2e-3, "{one} {other}");
        }
    }

    #[test]
    fn cells_are_of_similar_size() {
        let mut counts = [0_u32; CELLS];
        fibonacci_directions(CELLS * 100).into_iter().for_each(|direction| counts[cell_of(direction)] += 1);
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*least > 30 && *most < 250, "{least} to {most} in place of 100");
    }
}
