//! Which links are kept, and which receivers are examined next (meshless paper, Fig. 5).

use super::gather::Row;
use glam::Vec3;
use lapidary_core::meshless::{Basis, Projection, SparseRows};
use rayon::prelude::*;
use std::f32::consts::PI;

/// The paper's links hold the reflectance of the scene, ours do not; its threshold means about this much.
const TYPICAL_REFLECTANCE: f32 = 0.5;
/// How much of the threshold the sum of dropped links may reach.
const PART_OF_SUM: f32 = 0.1;

/// The paper's two criteria, and a third.
///
/// Coarsest senders are judged by magnitude, and so are finer ones in places that no coarser one reaches: both are roots.
/// The coefficients of all others are deviations from local averages, so that neighbours with like links cancel: they are
/// kept only where links also vary between neighbours.
///
/// Links to far roots are each below the threshold where there are more of them than its inverse, and together they are
/// most of the light. So receivers that no coarser one reaches, and which hold values and not differences, drop their
/// smallest links only while the sum of these is a small part of the threshold.
pub struct Criterion {
    /// Least length of a vector, `π ε / TYPICAL_REFLECTANCE`: a hemisphere of unit radiance has the vector irradiance `π`.
    least: f32,
    /// Which senders carry values and not deviations: those that a constant function needs.
    roots: Vec<bool>,
    /// Neighbours of the senders of each level, and the first of them.
    neighbours: Vec<(usize, SparseRows)>,
}

impl Criterion {
    pub fn new(basis: &Basis, epsilon: f32) -> Self {
        let ones = vec![1.0_f32; basis.senders().len()];
        let constant = Projection::new(basis, basis.sender_levels()).coarse_to_fine(&ones);
        let levels = 0..basis.sender_levels();
        Self {
            least: PI * epsilon / TYPICAL_REFLECTANCE,
            roots: constant.into_iter().map(|c| c > 0.5).collect(),
            neighbours: levels.map(|level| (basis.level(level).start, basis.neighbours(level))).collect(),
        }
    }

    /// Drops the links of a receiver that are not significant. `is_root` tells that no coarser receiver reaches it.
    pub fn prune(&self, row: &mut Row, is_root: bool) {
        let (mut kept, others): (Row, Row) = row.iter().partition(|link| self.roots[link.0 as usize]);
        if is_root {
            self.drop_small_sum(&mut kept);
        } else {
            kept.retain(|link| link.1.length() > self.least);
        }
        let varies = |link: &(u32, Vec3)| link.1.length() > self.least && self.varies(row, link);
        kept.extend(others.into_iter().filter(varies));
        kept.sort_unstable_by_key(|link| link.0);
        *row = kept;
    }

    /// Drops the smallest links, as many as together make no difference.
    fn drop_small_sum(&self, links: &mut Row) {
        links.sort_by(|a, b| a.1.length_squared().total_cmp(&b.1.length_squared()));
        let mut sum = Vec3::ZERO;
        let small = |link: &&(u32, Vec3)| {
            sum += link.1;
            sum.length() <= PART_OF_SUM * self.least
        };
        let dropped = links.iter().take_while(small).count();
        links.drain(..dropped);
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

/// The receivers of the next level that lie under one of `level` with links, or under none at all, in ascending order.
pub fn children_of(basis: &Basis, level: usize, rows: &[Row]) -> Vec<usize> {
    if level + 1 == basis.levels() {
        return Vec::new();
    }
    let is_child = |&receiver: &usize| {
        let (point, mut parents) = (&basis.points()[receiver], Vec::new());
        basis.values(level, point.position, point.normal, &mut parents);
        parents.is_empty() || parents.iter().any(|p| !rows[p.0 as usize].is_empty())
    };
    basis.level(level + 1).into_par_iter().filter(is_child).collect()
}
