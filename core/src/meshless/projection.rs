//! Coefficients of a function sampled at the points of the basis (meshless paper, 2.1 and 2.4).

use super::basis::Basis;
use crate::{sparse::SparseRows, transport::Coefficient};
use rayon::prelude::*;
use std::ops::Range;

/// The weights of the projection, computed once per basis.
#[derive(Clone, Debug)]
pub struct Projection {
    levels: Vec<Range<usize>>,
    /// For every function: the values at its point of all functions of coarser levels.
    coarser: SparseRows,
    /// For every function above the basis's finest level: its children, also those in a level after the last, and their
    /// shares, which sum to one. A share is also proportional to the area of the child, because points are denser at
    /// edges and on small objects. Averages over points alone would lose 2 to 5 % of the light in a furnished room.
    pub(super) children: SparseRows,
    /// Integrals of the functions over the surface, in units of a function of the basis's finest level.
    areas: Vec<f32>,
}

impl Projection {
    /// The projection for the first `levels` levels of a basis.
    pub fn new(basis: &Basis, levels: usize) -> Self {
        let level_of = |i: usize| (0..levels).find(|&l| basis.level(l).contains(&i)).unwrap_or(0);
        let coarser = SparseRows::build(basis.first_levels(levels).len(), |i, out| {
            let point = &basis.points()[i];
            (0..level_of(i)).for_each(|level| basis.values(level, point.position, point.normal, out));
        });
        let by_level: Vec<SparseRows> = (1..basis.levels()).map(|level| basis.children(level - 1)).collect();
        let mut areas = areas(basis, &by_level);
        let parents = basis.first_levels(levels.min(basis.levels() - 1));
        let children = SparseRows::build(parents.len(), |i, out| {
            let level = level_of(i);
            let row = by_level[level].row(i - basis.level(level).start);
            let part = |&(child, value): &(u32, f32)| (child, value * areas[child as usize]);
            let sum: f32 = row.iter().map(|c| part(c).1).sum();
            out.extend(row.iter().map(part).map(|(child, part)| (child, part / sum)));
        });
        areas.truncate(basis.first_levels(levels).len());
        Self { levels: (0..levels).map(|level| basis.level(level)).collect(), coarser, children, areas }
    }

    /// Coefficients from coarse to fine (meshless paper, Eq. 7): each is the residual of the sample at its point after
    /// all coarser levels.
    ///
    /// # Panics
    /// If there are fewer samples than functions.
    pub fn coarse_to_fine<T: Coefficient>(&self, samples: &[T]) -> Vec<T> {
        let mut coefficients = vec![T::ZERO; self.coarser.len()];
        for level in &self.levels {
            let (done, rest) = coefficients.split_at_mut(level.start);
            rest[..level.len()].par_iter_mut().enumerate().with_min_len(512).for_each(|(k, coefficient)| {
                let i = level.start + k;
                *coefficient = samples[i] - self.coarser.product(i, done);
            });
        }
        coefficients
    }

    /// [`Self::coarse_to_fine`] for samples first averaged from fine to coarse, so that each level carries the deviations from
    /// local averages ("pull-push", `P↑↓` of the meshless paper). A function without children keeps its sample.
    ///
    /// # Panics
    /// If there are fewer samples than functions.
    pub fn pull_push<T: Coefficient>(&self, samples: &[T]) -> Vec<T> {
        let mut averages = samples[..self.coarser.len()].to_vec();
        for level in self.levels.iter().rev().skip(1) {
            let (coarse, fine) = averages.split_at_mut(level.end);
            let child = |sum: T, &(child, share): &(u32, f32)| sum + fine[child as usize - level.end] * share;
            coarse[level.clone()].par_iter_mut().enumerate().with_min_len(256).for_each(|(k, average)| {
                let children = self.children.row(level.start + k);
                if !children.is_empty() {
                    *average = children.iter().fold(T::ZERO, child);
                }
            });
        }
        self.coarse_to_fine(&averages)
    }

    /// Integrals of the functions over the surface, in units of a function of the basis's finest level.
    pub(super) fn areas(&self) -> &[f32] {
        &self.areas
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        self.coarser.bytes() + self.children.bytes() + size_of_val(&self.areas[..]) as u64
    }
}

/// Integrals of all functions over the surface, in units of a function of the finest level.
fn areas(basis: &Basis, children: &[SparseRows]) -> Vec<f32> {
    let mut areas = vec![1.0; basis.len()];
    for (level, children) in children.iter().enumerate().rev() {
        for (row, i) in basis.level(level).enumerate().filter(|(row, _)| !children.row(*row).is_empty()) {
            areas[i] = children.product(row, &areas);
        }
    }
    areas
}
