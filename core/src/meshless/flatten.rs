//! A solution at fixed points, by weights computed once ("flattening" of the meshless paper, 4.1).
//!
//! The points are the vertices of a mesh for display, or the sources whose cuts gather the last bounce.

use super::{basis::Basis, transport::Transport};
use crate::{sparse::SparseRows, transport::Coefficient};
use glam::Vec3;
use rayon::prelude::*;

/// Values of all linked functions at fixed points.
#[derive(Clone, Debug)]
pub struct Flattening {
    weights: SparseRows,
}

impl Flattening {
    /// Weights for points given by position and unit normal. Only functions with links count; the others carry no light.
    pub fn new(basis: &Basis, transport: &Transport, points: &[(Vec3, Vec3)]) -> Self {
        Self::of_levels(basis, transport, basis.levels(), points)
    }

    /// [`Self::new`] from the first `levels` levels only.
    pub fn of_levels(basis: &Basis, transport: &Transport, levels: usize, points: &[(Vec3, Vec3)]) -> Self {
        let linked = transport.linked();
        let weights = SparseRows::build(points.len(), |row, out| {
            let ((position, normal), first) = (points[row], out.len());
            (0..levels).for_each(|level| basis.values(level, position, normal, out));
            let mut kept = first;
            for k in first..out.len() {
                if linked[out[k].0 as usize] {
                    out[kept] = out[k];
                    kept += 1;
                }
            }
            out.truncate(kept);
        });
        Self { weights }
    }

    /// The function with these coefficients at all points.
    pub fn apply<T: Coefficient>(&self, coefficients: &[T]) -> Vec<T> {
        let row = |row: usize| self.weights.product(row, coefficients);
        (0..self.weights.len()).into_par_iter().with_min_len(512).map(row).collect()
    }

    /// Number of weights.
    pub fn weights(&self) -> usize {
        (0..self.weights.len()).map(|row| self.weights.row(row).len()).sum()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        self.weights.bytes()
    }
}
