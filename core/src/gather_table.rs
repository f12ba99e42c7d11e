//! Rays of receivers, kept with the senders that they meet: light that bounces again is then gathered without rays.
//!
//! After a move only those rays are traced again whose end the move can change, see [`Moved`].

use crate::{bounds::Bounds, sphere::frame_around};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3};
use std::f32::consts::TAU;

/// The end of a ray, in 8 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GatherHit {
    /// The sender that stands for the place of the hit, [`GatherHit::MISS`], or [`GatherHit::DARK`] and an object.
    pub sender: u32,
    /// Length of the ray in meters; infinite without a hit.
    pub distance: f32,
}

impl GatherHit {
    /// The sender of a ray that meets nothing and sees the sky.
    pub const MISS: u32 = u32::MAX;
    /// Added to the index of an object whose surface sends no light, as the back of a one-sided one.
    pub const DARK: u32 = 1 << 31;

    /// The end of a ray that sees the sky.
    pub const OPEN: Self = Self { sender: Self::MISS, distance: f32::INFINITY };

    /// A ray that ends at a surface of an object that sends nothing.
    pub fn dark(object: u32, distance: f32) -> Self {
        Self { sender: Self::DARK | object, distance }
    }

    /// The sender, if the ray ends at one.
    pub fn lit(self) -> Option<u32> {
        (self.sender < Self::DARK).then_some(self.sender)
    }
}

/// Directions of the rays of all receivers: one set, turned about each receiver's normal (meshless radiosity, 4.2).
#[derive(Clone, Debug)]
pub struct RayFan {
    /// Unit vectors of the hemisphere around +Z, neighbors one after another.
    directions: Vec<Vec3>,
}

impl RayFan {
    /// A fan of `rays` directions of equal solid angle; rounded up to eights.
    pub fn new(rays: usize) -> Self {
        let count = rays.max(1).next_multiple_of(8);
        let all: Vec<Vec3> = (0..count).map(|i| lattice_direction(i, count)).collect();
        let order = crate::ray::spatial_order(&all);
        Self { directions: order.into_iter().map(|i| all[i as usize]).collect() }
    }

    /// The directions before they are turned.
    pub fn directions(&self) -> &[Vec3] {
        &self.directions
    }

    /// Solid angle of a direction in steradians.
    pub fn solid_angle(&self) -> f32 {
        TAU / self.directions.len() as f32
    }

    /// From the fan to the world, for a receiver with a unit normal. Equal numbers give equal turns.
    pub fn frame(receiver: u32, normal: Vec3) -> Mat3 {
        let turn = TAU * fastrand::Rng::with_seed(u64::from(receiver)).f32();
        frame_around(normal) * Mat3::from_rotation_z(turn)
    }
}

/// The `i`-th of `n` directions of equal solid angle around +Z.
fn lattice_direction(i: usize, n: usize) -> Vec3 {
    crate::sphere::lattice_direction(i, n, 0.0, 0.5)
}

/// The rays of some receivers. Receivers that were never asked for have none, and those for which there was no room.
#[derive(Clone, Debug)]
pub struct GatherTable {
    rows: Vec<Option<Box<[GatherHit]>>>,
    bytes: u64,
    most_bytes: u64,
}

impl GatherTable {
    /// A table for a number of receivers, without rays; it keeps at most `most_bytes` of them.
    pub fn new(receivers: usize, most_bytes: u64) -> Self {
        Self { rows: vec![None; receivers], bytes: 0, most_bytes }
    }

    /// The rays of a receiver, if they are kept.
    pub fn row(&self, receiver: u32) -> Option<&[GatherHit]> {
        self.rows[receiver as usize].as_deref()
    }

    /// Keeps the rays of a receiver that has none, if there is room.
    pub fn keep(&mut self, receiver: u32, hits: Box<[GatherHit]>) {
        let bytes = self.bytes + size_of_val::<[GatherHit]>(&hits) as u64;
        if bytes <= self.most_bytes {
            self.bytes = bytes;
            self.rows[receiver as usize] = Some(hits);
        }
    }

    /// The rays of a receiver, to change some of them.
    ///
    /// # Panics
    /// If they are not kept.
    pub fn row_mut(&mut self, receiver: u32) -> &mut [GatherHit] {
        self.rows[receiver as usize].as_mut().expect("its rays are kept")
    }

    /// Bytes of the rays.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// What a move changes of rays.
pub struct Moved<'a> {
    /// The object of a sender.
    pub object_of: &'a (dyn Fn(u32) -> u32 + Sync),
    /// Whether an object moved.
    pub is_moved: &'a (dyn Fn(u32) -> bool + Sync),
    /// Boxes around the objects where they are now.
    pub boxes: &'a [Bounds],
}

impl Moved<'_> {
    /// Whether a ray has to be traced again: it ended on a moved object, or an object may now be before its end. What an object left
    /// needs nothing more: a ray that passed the old place without a hit is not changed by its absence.
    pub fn changes(&self, origin: Vec3, direction: Vec3, end: &GatherHit) -> bool {
        let object = match end.sender {
            GatherHit::MISS => None,
            dark if dark >= GatherHit::DARK => Some(dark - GatherHit::DARK),
            sender => Some((self.object_of)(sender)),
        };
        object.is_some_and(|object| (self.is_moved)(object))
            || self.boxes.iter().any(|b| b.meets_ray(origin, direction, end.distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_integrates_vector_irradiance_and_is_turned_by_the_number_of_its_receiver() {
        let fan = RayFan::new(512);
        let normal = Vec3::new(0.6, 0.0, 0.8);
        for receiver in 0..20 {
            let frame = RayFan::frame(receiver, normal);
            let sum: Vec3 = fan.directions().iter().map(|d| frame * *d * fan.solid_angle()).sum();
            assert!((sum - std::f32::consts::PI * normal).length() < 0.02, "{sum}");
        }
        assert_eq!(RayFan::frame(3, normal), RayFan::frame(3, normal));
        assert!(RayFan::frame(3, normal) != RayFan::frame(4, normal), "negative control");
        assert_eq!(RayFan::new(3).directions().len(), 8);
    }

    #[test]
    fn rays_are_changed_by_what_they_met_and_by_what_is_now_in_their_way() {
        let block = Bounds { min: Vec3::new(2.0, -1.0, -1.0), max: Vec3::new(3.0, 1.0, 1.0) };
        let moved = Moved { object_of: &|sender| sender / 7, is_moved: &|object| object == 1, boxes: &[block] };
        let along = |sender: u32, distance: f32| moved.changes(Vec3::ZERO, Vec3::X, &GatherHit { sender, distance });
        assert!(along(7, 1.0), "it was on the object");
        assert!(!along(6, 1.0), "before the box");
        assert!(along(6, 2.5) && along(6, 9.0) && moved.changes(Vec3::ZERO, Vec3::X, &GatherHit::OPEN));
        assert!(!moved.changes(Vec3::ZERO, Vec3::Y, &GatherHit::OPEN));
        let dark = |object: u32| moved.changes(Vec3::ZERO, Vec3::X, &GatherHit::dark(object, 1.0));
        assert!(dark(1) && !dark(2), "the back of the object");
        assert!(moved.changes(Vec3::new(2.5, 0.0, 0.0), Vec3::Y, &GatherHit::OPEN), "from within");
    }
}
