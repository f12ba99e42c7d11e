//! Rays that follow moves of objects: a move only tells which rays it may change; they are traced again when their receiver gathers.
//! A device that traces rays traces all of such a receiver.

use super::Radiosity;
use crate::{
    bounds::Bounds,
    gather_table::{GatherHit, Moved},
    meshless::object_bases::Carrier,
};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The moves so far.
#[derive(Default)]
pub(super) struct Moves {
    count: u32,
    /// For each object that ever moved: the number of its last move, and the box around it now.
    objects: BTreeMap<u32, (u32, Bounds)>,
    /// For each function: the moves that its kept rays know.
    known: Vec<u32>,
    /// Rays that were traced again since the last move, because this or an earlier one changes them.
    traced_again: u64,
}

impl Moves {
    /// No moves of some functions.
    pub fn none(functions: usize) -> Self {
        Self { known: vec![0; functions], ..Self::default() }
    }
}

impl Radiosity {
    /// Takes a move: objects with the boxes around them now, and the boxes that they left. `surface` is the moved one.
    pub fn follow(&mut self, surface: &dyn Carrier, moved: &BTreeMap<u32, Bounds>, left: &[Bounds]) {
        self.moves.count += 1;
        self.moves.traced_again = 0;
        let count = self.moves.count;
        self.moves.objects.extend(moved.iter().map(|(&object, &bounds)| (object, (count, bounds))));
        self.device.iter_mut().for_each(|device| device.forget_rays());
        self.device_step += 1;
        self.look_again(surface, moved, left);
    }

    /// Kept rays that were traced again since the last move. A device traces all rays of a receiver again.
    pub fn traced_again(&self) -> u64 {
        self.moves.traced_again
    }

    /// Whether the rays of a function are kept and as they are now.
    pub(super) fn is_known(&self, function: u32) -> bool {
        self.table.row(function).is_some() && self.moves.known[function as usize] == self.moves.count
    }

    /// Keeps the rays of a function as they are now, if there is room.
    pub(super) fn know(&mut self, function: u32, rays: Renewed) {
        self.moves.known[function as usize] = self.moves.count;
        match rays {
            Renewed::Kept => {}
            Renewed::New(row) => self.table.keep(function, row),
            Renewed::Again(row, rays) => {
                self.moves.traced_again += rays;
                self.table.row_mut(function).copy_from_slice(&row);
            }
        }
    }

    /// The rays of a function as they are now; `traced` has them if a device traced them.
    pub(super) fn renewed(&self, surface: &dyn Carrier, function: u32, traced: Option<&[GatherHit]>) -> Renewed {
        match (self.table.row(function), traced) {
            (Some(_), _) if self.is_known(function) => Renewed::Kept,
            (Some(_), Some(traced)) => Renewed::Again(traced.into(), traced.len() as u64),
            (None, Some(traced)) => Renewed::New(traced.into()),
            (Some(row), None) => self.traced_where_changed(surface, function, row),
            (None, None) => Renewed::New(self.row(surface, function)),
        }
    }

    /// Traces again what moves changed since a row was traced, by eights as they were traced first.
    fn traced_where_changed(&self, surface: &dyn Carrier, function: u32, row: &[GatherHit]) -> Renewed {
        let known = self.moves.known[function as usize];
        let moved = self.moves.objects.values().filter(|(last, _)| *last > known);
        let boxes: Vec<Bounds> = moved.map(|(_, bounds)| *bounds).collect();
        let object_of = |sender: u32| self.bases.owners()[sender as usize].object;
        let is_moved = |object: u32| self.moves.objects.get(&object).is_some_and(|(last, _)| *last > known);
        let moved = Moved { object_of: &object_of, is_moved: &is_moved, boxes: &boxes };
        let (fan, itself) = (self.placed(surface, function), is_moved(object_of(function)));
        let is_stale = |eight: &[Vec3; 8], ends: &[GatherHit; 8]| {
            itself || eight.iter().zip(ends).any(|(&direction, end)| moved.changes(fan.origin, direction, end))
        };
        let (ends, directions) = (row.as_chunks::<8>().0, self.fan.directions().as_chunks::<8>().0);
        let all = directions.iter().zip(ends).enumerate().map(|(i, (eight, ends))| (i, fan.turned(eight), ends));
        let stale: Vec<(usize, [Vec3; 8])> =
            all.filter(|(_, eight, ends)| is_stale(eight, ends)).map(|(i, eight, _)| (8 * i, eight)).collect();
        if stale.is_empty() {
            return Renewed::Kept;
        }
        let eights: Vec<[Vec3; 8]> = stale.iter().map(|(_, eight)| *eight).collect();
        let hits: Vec<GatherHit> = self.hits(surface, fan.origin, &eights).collect();
        let mut renewed: Box<[GatherHit]> = row.into();
        for ((first, _), hits) in stale.iter().zip(hits.as_chunks::<8>().0) {
            renewed[*first..first + 8].copy_from_slice(hits);
        }
        Renewed::Again(renewed, hits.len() as u64)
    }

    /// Looks again whether functions are covered, where a move can change it.
    fn look_again(&mut self, surface: &dyn Carrier, moved: &BTreeMap<u32, Bounds>, left: &[Bounds]) {
        let reach = self.bases.radii()[self.bases.levels() - 1] + surface.offset();
        let boxes: Vec<Bounds> = moved.values().chain(left).map(|b| b.grown(reach)).collect();
        let owners = self.bases.owners();
        let again = |(function, &known): (usize, &bool)| {
            let is_near = || {
                let place = surface.now(&self.bases.points()[function]).position;
                boxes.iter().any(|b| b.contains(place))
            };
            let changes = moved.contains_key(&owners[function].object) || is_near();
            if changes { self.is_covered(surface, function as u32) } else { known }
        };
        self.covered = self.covered.par_iter().enumerate().map(again).collect();
    }
}

/// Rays of a function as they are now.
pub(super) enum Renewed {
    /// Those that are kept.
    Kept,
    New(Box<[GatherHit]>),
    /// With some that were traced again, and their number.
    Again(Box<[GatherHit]>, u64),
}

impl Renewed {
    /// The rays, where they are not those that are kept.
    pub fn row(&self) -> Option<&[GatherHit]> {
        match self {
            Self::Kept => None,
            Self::New(row) | Self::Again(row, _) => Some(row),
        }
    }
}
