//! Which links are kept, and which receivers are examined next (meshless paper, Fig. 5).

use super::gather::Row;
use glam::Vec3;
use lapidary_core::{
    meshless::{Basis, Projection, SparseRows},
    surfel::Surfel,
};
use rayon::prelude::*;
use std::f32::consts::PI;

/// The paper's links hold the reflectance of the scene, ours do not; its threshold means about this much.
const TYPICAL_REFLECTANCE: f32 = 0.38;
/// Receivers of this level and finer ones have the full threshold, each coarser level so much of that of the next.
const FULL_THRESHOLD_LEVEL: usize = 3;
const OF_NEXT_THRESHOLD: f32 = 0.18;
/// The most of the threshold that the sum of dropped links may reach where no coarser receiver holds the rest.
const PART_OF_ROOTS: f32 = 0.1;

/// The paper's criteria, and what keeps the energy of what they drop.
///
/// Coarsest senders carry values, and so do finer ones in places that no coarser one reaches: both are roots. Links to far
/// roots are each below the threshold where there are more of them than its inverse, and together they are most of the
/// light. So a receiver walks its roots along a curve through space and sums links until the sum is above the threshold:
/// the largest of these links is kept and stands for all of them. The last sum goes to the last link that was kept, and is
/// dropped only where none was: uniform light is right within the threshold.
///
/// The coefficients of all other senders are deviations from local averages, so that neighbours with like links cancel:
/// they are kept where they are above the threshold and also vary between neighbours, as in the paper.
///
/// A level has about four times as many receivers as the one before, which all repeat its error, and what is dropped is more
/// often light than not: deviations are positive where light falls, and that is what rays find more often than what lies in
/// the shadow beneath. So the threshold falls by [`OF_NEXT_THRESHOLD`] with each level above [`FULL_THRESHOLD_LEVEL`]. One bounce of a
/// spot in a furnished room (6 levels, 4 of them send) has 0.90 of the light of a gather from the same senders if it falls by 0.63
/// from the finest level on, 0.97 if by a quarter and full ones are less by a fifth, and 0.986 with this, at about as many links each.
pub struct Criterion {
    /// Least length of a vector, `π ε / TYPICAL_REFLECTANCE`: a hemisphere of unit radiance has the vector irradiance `π`.
    least: f32,
    /// Which senders carry values and not deviations: those that a constant function needs.
    roots: Vec<bool>,
    /// Neighbours of the senders of each level, and the first of them.
    neighbours: Vec<(usize, SparseRows)>,
    /// Places of the senders along the curve.
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
            order: curve_places(basis.sender_points()),
        }
    }

    /// Drops the links of a receiver of `level` that are not significant. `is_root` tells that no coarser receiver reaches
    /// it.
    pub fn prune(&self, row: &mut Row, is_root: bool, level: usize) {
        let least = self.least * OF_NEXT_THRESHOLD.powi(FULL_THRESHOLD_LEVEL.saturating_sub(level) as i32);
        let (roots, others): (Row, Row) = row.iter().partition(|link| self.roots[link.0 as usize]);
        let bound = if is_root { least.min(PART_OF_ROOTS * self.least) } else { least };
        let mut kept = self.merge(roots, bound);
        let varies = |link: &(u32, Vec3)| link.1.length() > least && self.varies(row, link, least);
        kept.extend(others.into_iter().filter(varies));
        kept.sort_unstable_by_key(|link| link.0);
        *row = kept;
    }

    /// Sums links along the curve; each sum longer than `bound` goes to the sender of its largest link, the rest to the last of these.
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
        // The rest is near the last one on the curve.
        if let Some(last) = kept.last_mut() {
            last.1 += sum;
        }
        kept
    }

    /// Whether a link differs by `least` from that of any neighbour of its sender. Senders that are not in the row have a link of zero.
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

/// The receivers of the next level that are examined, in ascending order.
pub fn children_of(basis: &Basis, level: usize, rows: &[Row]) -> Vec<usize> {
    if level + 1 == basis.levels() {
        return Vec::new();
    }
    let is_child = |&receiver: &usize| is_examined(basis, receiver, level + 1, rows);
    basis.level(level + 1).into_par_iter().filter(is_child).collect()
}

/// Whether a receiver lies under one of the level before with links, or under none at all.
pub fn is_examined(basis: &Basis, receiver: usize, level: usize, rows: &[Row]) -> bool {
    let Some(coarser) = level.checked_sub(1) else { return true };
    let (point, mut parents) = (&basis.points()[receiver], Vec::new());
    basis.values(coarser, point.position, point.normal, &mut parents);
    parents.is_empty() || parents.iter().any(|p| !rows[p.0 as usize].is_empty())
}

/// Places of points along a Z-curve through the cube around them.
fn curve_places(points: &[Surfel]) -> Vec<u32> {
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
