//! Rays that follow a move of objects.

use super::Radiosity;
use crate::{
    bounds::Bounds,
    gather_table::{GatherHit, Moved},
    meshless::object_bases::Carrier,
};
use glam::Vec3;
use rayon::prelude::*;

/// Ends of rays that were traced again, by eights with the number of their first ray.
type RenewedEights = Vec<(usize, [GatherHit; 8])>;

impl Radiosity {
    /// Traces again what a move of objects changes, by eights as they were traced first. `surface` is the moved one, `boxes` are around
    /// the moved objects now, and `left` are those that they left. Returns the number of rays.
    pub fn follow(
        &mut self,
        surface: &dyn Carrier,
        is_moved: &(dyn Fn(u32) -> bool + Sync),
        boxes: &[Bounds],
        left: &[Bounds],
    ) -> u64 {
        self.look_again(surface, is_moved, &[boxes, left].concat());
        let moved = Moved { object_of: &|sender| self.bases.owners()[sender as usize].object, is_moved, boxes };
        let receivers: Vec<u32> = self.table.receivers().collect();
        let renewed: Vec<(u32, RenewedEights)> =
            receivers.into_par_iter().map(|function| (function, self.renewed(surface, function, &moved))).collect();
        let mut rays = 0;
        for (function, eights) in renewed {
            let row = self.table.row_mut(function);
            rays += 8 * eights.len() as u64;
            eights.into_iter().for_each(|(first, hits)| row[first..first + 8].copy_from_slice(&hits));
        }
        rays
    }

    /// Looks again whether functions are covered, where a move can change it.
    fn look_again(&mut self, surface: &dyn Carrier, is_moved: &(dyn Fn(u32) -> bool + Sync), boxes: &[Bounds]) {
        let reach = self.bases.radii()[self.bases.levels() - 1] + surface.offset();
        let boxes: Vec<Bounds> = boxes.iter().map(|b| b.grown(reach)).collect();
        let owners = self.bases.owners();
        let again = |(function, &known): (usize, &bool)| {
            let place = || surface.now(&self.bases.points()[function]).position;
            let changes = is_moved(owners[function].object) || boxes.iter().any(|b| b.contains(place()));
            if changes { self.is_covered(surface, function as u32) } else { known }
        };
        self.covered = self.covered.par_iter().enumerate().map(again).collect();
    }

    /// The eights of a function's rays that a move changes, by their first ray.
    fn renewed(&self, surface: &dyn Carrier, function: u32, moved: &Moved) -> RenewedEights {
        let fan = self.placed(surface, function);
        let itself = (moved.is_moved)((moved.object_of)(function));
        let row = self.table.row(function).expect("its rays were traced");
        let (ends, directions) = (row.as_chunks::<8>().0, self.fan.directions().as_chunks::<8>().0);
        let stale: Vec<(usize, [Vec3; 8])> = directions
            .iter()
            .zip(ends)
            .enumerate()
            .map(|(i, (eight, ends))| (i, fan.directions(eight), ends))
            .filter(|(_, eight, ends)| {
                itself || eight.iter().zip(*ends).any(|(&direction, end)| moved.changes(fan.origin, direction, end))
            })
            .map(|(i, eight, _)| (8 * i, eight))
            .collect();
        let eights: Vec<[Vec3; 8]> = stale.iter().map(|(_, eight)| *eight).collect();
        let hits: Vec<GatherHit> = self.hits(surface, fan.origin, &eights).collect();
        stale.into_iter().zip(hits.as_chunks::<8>().0).map(|((first, _), hits)| (first, *hits)).collect()
    }
}
