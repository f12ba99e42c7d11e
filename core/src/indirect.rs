//! The second source mode of a dataset: surface samples as lights (paper, 4.1), and cuts of what each vertex sees of them.
//!
//! A source is a small disc of surface; its light is its radiosity, so that one merge at a pixel gathers a bounce. The
//! value of a vertex's cut at a node is the mean over the node's sources of the solid angle that the vertex sees of each,
//! zero where it is hidden (`<V G>` of the paper, 3).

use crate::{cut::packed::PackedCuts, surfel::Surfel};
use glam::{Vec2, Vec3};
use std::{f32::consts::PI, sync::LazyLock};

/// A surface sample that sends light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Where it is.
    pub surfel: Surfel,
    /// Area in m² that it stands for.
    pub area: f32,
}

impl Source {
    /// Solid angle in steradians that the source fills seen from a place `from`, in front of it and with nothing between;
    /// 0 from behind.
    ///
    /// `A cos θ / (d² + A / 2π)`: right from afar, and a hemisphere at most from near by.
    #[inline(always)]
    pub fn solid_angle_from(&self, from: Vec3) -> f32 {
        let to_place = from - self.surfel.position;
        let distance_sq = to_place.length_squared();
        let height = to_place.dot(self.surfel.normal);
        if !(height > 0.0 && self.area > 0.0) {
            return 0.0;
        }
        let cosine = height / distance_sq.sqrt();
        self.area * cosine / (distance_sq + self.area * (1.0 / LARGEST_SOLID_ANGLE))
    }

    /// Radius in metres of a disc of its area.
    pub fn radius(&self) -> f32 {
        (self.area * (1.0 / PI)).sqrt()
    }

    /// Mean solid angle in steradians over the points of a disc that receives. From afar it is that seen from the disc's
    /// centre; near by the parts of both count one by one, lest a floor seen edge on from the foot of a wall vanish.
    pub fn mean_solid_angle(&self, receiver: &Receiver) -> f32 {
        let Surfel { position, normal, .. } = self.surfel;
        let radius = self.radius();
        if position.distance(receiver.position) > NEAR * (radius + receiver.radius) {
            return self.solid_angle_from(receiver.position);
        }
        let (sent, received) = (Disc::new(position, normal, radius), receiver.disc());
        let from = |part: usize| {
            let from = received.at(DISC_PARTS[part]);
            // The parts of either disc meet the other's in another order.
            let offset = DISC_PARTS[(27 * part + 5) % PARTS].perp();
            let is_above = |at: &Vec3| (at - from).dot(receiver.normal) > 0.0;
            // A source's area lies all on the side that is seen, though its disc may reach into the receiver.
            let position = Some(sent.at(offset)).filter(is_above).unwrap_or(sent.at(-offset));
            let surfel = Surfel { position, ..self.surfel };
            Source { surfel, area: self.area / PARTS as f32 }.solid_angle_from(from)
        };
        (0..PARTS).map(from).sum()
    }
}

/// A disc of surface that receives light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Its centre.
    pub position: Vec3,
    /// Unit normal on the side that receives.
    pub normal: Vec3,
    /// Radius in metres.
    pub radius: f32,
}

impl Receiver {
    fn disc(&self) -> Disc {
        Disc::new(self.position, self.normal, self.radius)
    }
}

/// Discs are near each other within so many times the sum of their radii.
const NEAR: f32 = 3.0;
/// Parts of a disc that is near.
const PARTS: usize = 64;

/// Vogel's spiral: points that fill the unit disc evenly.
static DISC_PARTS: LazyLock<[Vec2; PARTS]> = LazyLock::new(|| {
    let golden_angle = PI * (3.0 - 5.0_f32.sqrt());
    std::array::from_fn(|i| ((i as f32 + 0.5) / PARTS as f32).sqrt() * Vec2::from_angle(golden_angle * i as f32))
});

struct Disc {
    center: Vec3,
    axes: [Vec3; 2],
}

impl Disc {
    fn new(center: Vec3, normal: Vec3, radius: f32) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        Self { center, axes: [u * radius, v * radius] }
    }

    fn at(&self, place: Vec2) -> Vec3 {
        self.center + self.axes[0] * place.x + self.axes[1] * place.y
    }
}

/// Sources, what vertices see of them, and what they see of the environment.
#[derive(Clone, Debug)]
pub struct IndirectBake {
    /// `2^H` sources in the order of the leaves of their complete binary tree.
    pub sources: Vec<Source>,
    /// One cut a vertex over the sources; values are coded by [`solid_angle_code`].
    pub cuts: PackedCuts,
    /// One cut a source over the dataset's light tree: its visibility of the environment.
    pub environment_cuts: PackedCuts,
}

/// Largest solid angle that a source can fill, in steradians: a hemisphere.
pub const LARGEST_SOLID_ANGLE: f32 = 2.0 * std::f32::consts::PI;
/// Binary orders of magnitude that the code spans; what is smaller counts as hidden.
const ORDERS: f32 = 30.0;
const CODES: f32 = 4094.0;

/// A solid angle in 12 bits: 0 for none, else logarithmic, in steps of half a percent.
pub fn solid_angle_code(steradians: f32) -> u16 {
    if !(steradians > LARGEST_SOLID_ANGLE * (-ORDERS).exp2()) {
        return 0;
    }
    let orders = (steradians / LARGEST_SOLID_ANGLE).min(1.0).log2() + ORDERS;
    1 + (orders * (CODES / ORDERS) + 0.5) as u16
}

/// The solid angle in steradians of a code.
#[inline(always)]
pub fn solid_angle(code: u16) -> f32 {
    if code == 0 { 0.0 } else { LARGEST_SOLID_ANGLE * (f32::from(code - 1) * (ORDERS / CODES) - ORDERS).exp2() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solid_angles_keep_half_a_percent() {
        assert_eq!((solid_angle_code(0.0), solid_angle_code(f32::NAN), solid_angle(0)), (0, 0, 0.0));
        assert_eq!(solid_angle_code(100.0), 4095, "no code leaves the 12 bits");
        let mut x = 1.1e-8;
        while x < LARGEST_SOLID_ANGLE {
            assert!((solid_angle(solid_angle_code(x)) / x - 1.0).abs() < 2.7e-3, "{x}");
            x *= 1.07;
        }
    }

    #[test]
    fn solid_angles_are_near_those_of_discs_at_any_distance() {
        let disc = Source {
            surfel: Surfel { position: Vec3::new(1.0, 2.0, 3.0), normal: Vec3::Y, place: Default::default() },
            area: 0.25 * std::f32::consts::PI,
        };
        let radius = 0.5_f32;
        for distance in [1e-4_f32, 0.1, 0.3, 0.5, 1.0, 3.0, 30.0] {
            let exact = LARGEST_SOLID_ANGLE * (1.0 - distance / distance.hypot(radius));
            let found = disc.solid_angle_from(disc.surfel.position + Vec3::Y * distance);
            let bound = if distance > 2.0 { 0.02 } else { 0.3 };
            assert!((found / exact - 1.0).abs() < bound, "{found} for {exact} at {distance}");
            assert!(found <= LARGEST_SOLID_ANGLE);
        }
        let far = disc.solid_angle_from(disc.surfel.position + Vec3::new(30.0, 30.0, 0.0));
        assert!((far / (disc.area * 0.5_f32.sqrt() / 1800.0) - 1.0).abs() < 1e-3, "from the side");
        assert_eq!(disc.solid_angle_from(disc.surfel.position - Vec3::Y), 0.0, "from behind");
        assert_eq!(disc.solid_angle_from(disc.surfel.position), 0.0);
        assert_eq!(Source { area: 0.0, ..disc }.solid_angle_from(Vec3::splat(9.0)), 0.0, "no area");
    }

    /// A floor of discs at the points of a grid, x from 0, that stands for the half plane at the foot of a wall.
    fn floor_at_the_foot_of_a_wall(cell: f32) -> Vec<Source> {
        let at = |i: i32| (i as f32 + 0.5) * cell;
        let place = |(x, z): (i32, i32)| Surfel {
            position: Vec3::new(at(x), 0.0, at(z)),
            normal: Vec3::Y,
            place: Default::default(),
        };
        let places = (0..100).flat_map(|x| (-100..100).map(move |z| (x, z)));
        places.map(|p| Source { surfel: place(p), area: cell * cell }).collect()
    }

    #[test]
    fn a_strip_of_wall_sees_the_floor_at_its_foot() {
        let cell = 0.1;
        let floor = floor_at_the_foot_of_a_wall(cell);
        let receiver = Receiver { position: Vec3::new(0.0, 0.4 * cell, 0.0), normal: Vec3::X, radius: 0.35 * cell };
        let mean: f32 = floor.iter().map(|s| s.mean_solid_angle(&receiver)).sum();
        // A quarter of the sphere; the floor ends at a distance of 10.
        assert!((mean / PI - 1.0).abs() < 0.15, "{mean}");
        let foot = Vec3::new(0.0, 0.02 * cell, 0.0);
        let from_foot: f32 = floor.iter().map(|s| s.solid_angle_from(foot)).sum();
        assert!(from_foot < 0.3 * PI, "negative control: from a point it is lost, {from_foot}");
    }

    #[test]
    fn discs_that_are_far_apart_see_each_other_as_points_do() {
        let source = Source { area: 0.01, ..floor_at_the_foot_of_a_wall(0.1)[100] };
        let position = source.surfel.position + Vec3::new(0.3, 0.8, 0.4);
        let seen = |radius| source.mean_solid_angle(&Receiver { position, normal: Vec3::NEG_Y, radius });
        let point = source.solid_angle_from(position);
        assert_eq!(seen(0.1), point);
        assert!((seen(0.4) / point - 1.0).abs() < 0.2 && seen(0.4) != point, "{} {point}", seen(0.4));
    }
}
