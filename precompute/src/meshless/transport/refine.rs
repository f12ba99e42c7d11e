//! Selection of kept links and of receivers for the next level (meshless paper, Fig. 5).

use super::gather::Row;
use glam::Vec3;
use lapidary_core::{
    meshless::{Basis, Projection},
    sparse::SparseRows,
    surfel::Surfel,
};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Reflectance at which the paper's threshold about equals ours: the paper's links contain the scene's reflectance, ours do not.
const TYPICAL_REFLECTANCE: f32 = 0.38;
/// Receivers of this level and finer ones have the full threshold. The threshold of each coarser level is a fixed fraction of the
/// next level's.
const FULL_THRESHOLD_LEVEL: usize = 3;
const THRESHOLD_FALLOFF: f32 = 0.18;
/// Largest sum of dropped links, as a share of the threshold, where no coarser receiver carries the rest.
const ROOT_THRESHOLD_SHARE: f32 = 0.1;

/// The paper's criteria, with a rule that preserves the energy of dropped links.
///
/// Coarsest senders carry values, and so do finer ones that no coarser one reaches: both are roots. Links to many distant roots may
/// each be below the threshold and yet together carry most of the light. So a receiver visits its roots along a space-filling curve
/// and sums links until the sum exceeds the threshold. The largest of these links is kept and stands for all of them. The last sum
/// goes to the last kept link. It is dropped only if no link was kept: uniform light is right within the threshold.
///
/// The coefficients of all other senders are deviations from local averages, so neighbors with similar links cancel. Such links are
/// kept if they exceed the threshold and also vary between neighbors, as in the paper.
///
/// A level has about four times as many receivers as the one before, and all of them repeat its error. Dropped links
/// are more often positive than negative: deviations are positive where light falls, and rays hit such surfaces more
/// often than those in the shadow beneath. So the threshold falls by a factor of [`THRESHOLD_FALLOFF`] with each level
/// above [`FULL_THRESHOLD_LEVEL`]. The measure is one bounce of a spot in a furnished room (6 levels, 4 of them
/// senders), relative to a gather from the same senders. It has 0.90 of the light if the threshold falls by a factor of
/// 0.63 from the finest level on, and 0.97 if by a quarter with full thresholds a fifth smaller. It has 0.986 with this
/// rule. The number of links is about the same in all three.
pub struct Criterion {
    /// Smallest length of a vector, `π ε / TYPICAL_REFLECTANCE`: a hemisphere of unit radiance has the vector irradiance `π`.
    least: f32,
    /// Whether each sender carries values rather than deviations: a constant function needs exactly these.
    roots: Vec<bool>,
    /// Neighbors of the senders of each level, and the first of them.
    neighbours: Vec<(usize, SparseRows)>,
    /// Position of each sender along the curve.
    order: Vec<u32>,
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
            order: curve_ranks(basis.sender_points()),
        }
    }

    /// Drops insignificant links of a receiver of `level`. `is_root` means that no coarser receiver reaches it.
    pub fn prune(&self, row: &mut Row, is_root: bool, level: usize) {
        let least = self.least * THRESHOLD_FALLOFF.powi(FULL_THRESHOLD_LEVEL.saturating_sub(level) as i32);
        let (roots, others): (Row, Row) = row.iter().partition(|link| self.roots[link.0 as usize]);
        let bound = if is_root { least.min(ROOT_THRESHOLD_SHARE * self.least) } else { least };
        let mut kept = self.merge(roots, bound);
        let varies = |link: &(u32, Vec3)| link.1.length() > least && self.varies(row, link, least);
        kept.extend(others.into_iter().filter(varies));
        kept.sort_unstable_by_key(|link| link.0);
        *row = kept;
    }

    /// Sums links along the curve. Each sum longer than `bound` goes to the sender of its largest link, and the rest to the last of
    /// these.
    fn merge(&self, mut links: Row, bound: f32) -> Row {
        links.sort_unstable_by_key(|link| (self.order[link.0 as usize], link.0));
        let mut kept = Row::new();
        let (mut sum, mut largest) = (Vec3::ZERO, (0, Vec3::ZERO));
        for link in links {
            sum += link.1;
            if link.1.length_squared() >= largest.1.length_squared() {
                largest = link;
            }
            if sum.length() > bound {
                kept.push((largest.0, sum));
                (sum, largest) = (Vec3::ZERO, (0, Vec3::ZERO));
            }
        }
        // The rest is close to the last one along the curve.
        if let Some(last) = kept.last_mut() {
            last.1 += sum;
        }
        kept
    }

    /// Whether a link differs by `least` from that of any neighbor of its sender. A sender that is not in the row has
    /// a link of zero.
    fn varies(&self, row: &Row, &(sender, vector): &(u32, Vec3), least: f32) -> bool {
        let level = self.neighbours.iter().rev().find(|(first, _)| *first <= sender as usize);
        let Some((first, neighbours)) = level else { return true };
        let link = |sender: u32| match row.binary_search_by_key(&sender, |l| l.0) {
            Ok(at) => row[at].1,
            Err(_) => Vec3::ZERO,
        };
        let least_sq = least * least;
        neighbours.row(sender as usize - first).iter().any(|n| vector.distance_squared(link(n.0)) > least_sq)
    }
}

/// Receivers of the next level to examine, in ascending order.
pub fn children_of(basis: &Basis, level: usize, rows: &[Row]) -> Vec<usize> {
    if level + 1 == basis.levels() {
        return Vec::new();
    }
    let is_child = |&receiver: &usize| is_examined(basis, receiver, level + 1, rows);
    basis.level(level + 1).into_par_iter().filter(is_child).collect()
}

/// Whether a receiver is a child of one with links in the previous level, or has no parent.
pub fn is_examined(basis: &Basis, receiver: usize, level: usize, rows: &[Row]) -> bool {
    let Some(coarser) = level.checked_sub(1) else { return true };
    let (point, mut parents) = (&basis.points()[receiver], Vec::new());
    basis.values(coarser, point.position, point.normal, &mut parents);
    parents.is_empty() || parents.iter().any(|p| !rows[p.0 as usize].is_empty())
}

/// Rank of each point along a Z-curve through the cube around all points.
fn curve_ranks(points: &[Surfel]) -> Vec<u32> {
    const STEPS: u32 = 1 << 10;
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (min, max) = points.iter().fold(none, |(min, max), p| (min.min(p.position), max.max(p.position)));
    let scale = (STEPS - 1) as f32 / (max - min).max_element().max(f32::MIN_POSITIVE);
    let spread = |v: f32| (0..STEPS.ilog2()).fold(0, |place, bit| place | ((v as u32 >> bit & 1) << (3 * bit)));
    let place = |p: &Surfel| {
        let cell = (p.position - min) * scale;
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    points.iter().map(place).collect()
}
