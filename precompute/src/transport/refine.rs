//! Which links are kept, and which receivers are examined next (meshless paper, Fig. 5).

use super::gather::Row;
use glam::Vec3;
use lapidary_core::meshless::{Basis, SparseRows};
use rayon::prelude::*;
use std::f32::consts::PI;

/// The paper's two criteria. Coarsest senders are judged by magnitude. Coefficients of finer ones are deviations from local
/// averages, so that neighbours with like links cancel: they are kept only where links also vary between neighbours.
pub struct Criterion {
    /// Least length of a vector, `π ε`: a hemisphere of unit radiance has the vector irradiance `π`.
    least: f32,
    /// First sender of the second level.
    finer: usize,
    /// Neighbours of the senders of each finer level, and the first of them.
    neighbours: Vec<(usize, SparseRows)>,
}

impl Criterion {
    pub fn new(basis: &Basis, epsilon: f32) -> Self {
        let levels = 1..basis.sender_levels();
        Self {
            least: PI * epsilon,
            finer: basis.level(0).end,
            neighbours: levels.map(|level| (basis.level(level).start, basis.neighbours(level))).collect(),
        }
    }

    /// Drops the links of a receiver that are not significant.
    pub fn prune(&self, row: &mut Row) {
        let kept = |link: &(u32, Vec3)| {
            link.1.length() > self.least && ((link.0 as usize) < self.finer || self.varies(row, link))
        };
        *row = row.iter().filter(|link| kept(link)).copied().collect();
    }

    /// Whether a link differs from that of any neighbour of its sender. Senders that are not in the row have a link of zero.
    fn varies(&self, row: &Row, &(sender, vector): &(u32, Vec3)) -> bool {
        let level = self.neighbours.iter().rev().find(|(first, _)| *first <= sender as usize);
        let Some((first, neighbours)) = level else { return true };
        let link = |sender: u32| match row.binary_search_by_key(&sender, |l| l.0) {
            Ok(at) => row[at].1,
            Err(_) => Vec3::ZERO,
        };
        let least_sq = self.least * self.least;
        neighbours.row(sender as usize - first).iter().any(|n| vector.distance_squared(link(n.0)) > least_sq)
    }
}

/// The receivers of the next level that lie under one of `level` with links, in ascending order.
pub fn children_of(basis: &Basis, level: usize, rows: &[Row]) -> Vec<usize> {
    if level + 1 == basis.levels() {
        return Vec::new();
    }
    let is_child = |&receiver: &usize| {
        let (point, mut parents) = (&basis.points()[receiver], Vec::new());
        basis.values(level, point.position, point.normal, &mut parents);
        parents.iter().any(|p| !rows[p.0 as usize].is_empty())
    };
    basis.level(level + 1).into_par_iter().filter(is_child).collect()
}
