//! All links to one receiver from one set of rays (meshless paper, Eq. 16 and 17).

use glam::Vec3;
use lapidary_core::{
    meshless::Basis,
    ray::{in_eights, spatial_order},
    sphere::{frame_around, lattice_direction},
    surfel::Surface,
};
use std::f32::consts::TAU;

/// Senders of a receiver in ascending order, and the vector irradiance from each.
pub type Row = Vec<(u32, Vec3)>;

/// Scene and basis for gathering.
pub struct Gatherer<'a> {
    surface: &'a dyn Surface,
    basis: &'a Basis,
    /// A receiver's ray indices, ordered so that neighbors in direction are consecutive.
    rays: Vec<usize>,
    offset: f32,
}

/// Buffers of one thread.
pub struct Scratch {
    /// Vector irradiance from each sender; zero between gathers.
    sums: Vec<Vec3>,
    touched: Vec<bool>,
    /// Senders with nonzero sums.
    senders: Vec<u32>,
    values: Vec<(u32, f32)>,
}

impl Scratch {
    #[inline(always)]
    fn add(&mut self, sender: u32, vector: Vec3) {
        let k = sender as usize;
        if !self.touched[k] {
            self.touched[k] = true;
            self.senders.push(sender);
        }
        self.sums[k] += vector;
    }

    /// Returns all sums by sender and resets them.
    fn take(&mut self) -> Row {
        self.senders.sort_unstable();
        let row = self.senders.iter().map(|&sender| (sender, self.sums[sender as usize])).collect();
        for &sender in &self.senders {
            self.sums[sender as usize] = Vec3::ZERO;
            self.touched[sender as usize] = false;
        }
        self.senders.clear();
        row
    }
}

impl<'a> Gatherer<'a> {
    pub fn new(surface: &'a dyn Surface, basis: &'a Basis, rays: usize) -> Self {
        let rays = rays.max(1);
        let directions: Vec<Vec3> = (0..rays).map(|ray| lattice_direction(ray, rays, 0.0, 0.5)).collect();
        let order = spatial_order(&directions).into_iter().map(|ray| ray as usize);
        Self { surface, basis, rays: order.collect(), offset: surface.offset() }
    }

    pub fn scratch(&self) -> Scratch {
        let senders = self.basis.senders().len();
        Scratch {
            sums: vec![Vec3::ZERO; senders],
            touched: vec![false; senders],
            senders: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Links to a receiver of `level`, given the rows of all coarser ones, and whether no coarser one reaches it.
    pub fn gather(&self, scratch: &mut Scratch, receiver: usize, level: usize, rows: &[Row]) -> (Row, bool) {
        self.gather_rays(scratch, receiver);
        let parents = self.subtract_parents(scratch, receiver, level, rows);
        (scratch.take(), parents == 0)
    }

    fn gather_rays(&self, scratch: &mut Scratch, receiver: usize) {
        let point = &self.basis.points()[receiver];
        let (frame, origin) = (frame_around(point.normal), point.position + point.normal * self.offset);
        let mut random = fastrand::Rng::with_seed(receiver as u64);
        let (turn, shift) = (random.f32(), random.f32());
        let count = self.rays.len();
        let directions = in_eights(self.rays.iter().map(|&ray| frame * lattice_direction(ray, count, turn, shift)));
        let hits = self.surface.first_hits(origin, &directions);
        for (&direction, hit) in directions.as_flattened().iter().zip(hits.as_flattened()).take(count) {
            let Some(hit) = hit else { continue };
            scratch.values.clear();
            for level in 0..self.basis.sender_levels() {
                self.basis.values(level, hit.position, hit.normal, &mut scratch.values);
            }
            for k in 0..scratch.values.len() {
                let (sender, value) = scratch.values[k];
                scratch.add(sender, direction * (value * TAU / count as f32));
            }
        }
    }

    /// Subtracts the contribution of all parents at the receiver's point. Returns the number of parents.
    fn subtract_parents(&self, scratch: &mut Scratch, receiver: usize, level: usize, rows: &[Row]) -> usize {
        let point = &self.basis.points()[receiver];
        let mut parents = Vec::new();
        (0..level).for_each(|coarser| self.basis.values(coarser, point.position, point.normal, &mut parents));
        for &(parent, value) in &parents {
            for &(sender, vector) in &rows[parent as usize] {
                scratch.add(sender, vector * -value);
            }
        }
        parents.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    #[test]
    fn the_lattice_integrates_vector_irradiance() {
        let mut random = fastrand::Rng::with_seed(9);
        for _ in 0..20 {
            let (turn, shift) = (random.f32(), random.f32());
            let all = (0..512).map(|i| lattice_direction(i, 512, turn, shift));
            let sum = all.map(|d| d * TAU / 512.0).sum::<Vec3>();
            assert!(sum.abs_diff_eq(Vec3::Z * PI, 0.02), "{sum}");
        }
    }
}
