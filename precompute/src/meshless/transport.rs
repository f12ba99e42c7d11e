//! The single-bounce operator by receiver-centric adaptive refinement (meshless paper, 3.1, Fig. 5 and appendix).
//!
//! Level by level, each receiver gathers the links from all senders with one set of hemisphere rays (Eq. 16). It subtracts its
//! parents' contribution (Eq. 17) and keeps significant links. Its children are examined if any link is kept.
//!
//! Departures from the paper:
//!
//! * Links do not contain reflectance (see [`lapidary_core::meshless::Transport`]). So `ε` is compared with the link of
//!   a sender of reflectance 0.38, `0.38 ‖T_ij‖ / π`, whatever the current colors of the scene.
//! * Receivers that no coarser one reaches always gather.
//! * Coarse receivers have smaller thresholds, and links to coarse senders are merged rather than dropped (see
//!   [`refine::Criterion`]).
//! * Rays are uniform over the hemisphere. With cosine-distributed rays, the estimate of the tangential parts of vector
//!   irradiance has no finite variance.
//! * Rays are stratified as a Fibonacci lattice, rotated and shifted at random per receiver, so that parents and
//!   children do not repeat each other's error.

pub mod gather;
pub mod recompute;
mod refine;
pub mod steps;

use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
};
use gather::{Gatherer, Row};
use lapidary_core::{
    dataset::{MeshlessReport, MeshlessSettings},
    meshless::{Basis, Transport},
    surfel::Surface,
};
use rayon::prelude::*;
use refine::{Criterion, children_of};
use steps::{Forget, KeepsRows};

/// Receivers between two checks for cancellation.
const RECEIVERS_PER_STEP: usize = 1024;

/// Computes the operator of a basis on its surface. The result does not depend on threads or time.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn transport_operator(
    surface: &dyn Surface,
    basis: &Basis,
    settings: &MeshlessSettings,
    observer: &dyn Observer,
) -> Result<(Transport, MeshlessReport), BakeError> {
    resumable_operator(surface, basis, settings, &Forget, observer)
}

/// [`transport_operator`] with resumption: steps held by `kept` are not recomputed. On the finest level, steps that belong
/// elsewhere have no links.
pub fn resumable_operator(
    surface: &dyn Surface,
    basis: &Basis,
    settings: &MeshlessSettings,
    kept: &dyn KeepsRows,
    observer: &dyn Observer,
) -> Result<(Transport, MeshlessReport), BakeError> {
    let gatherer = Gatherer::new(surface, basis, settings.rays);
    let criterion = Criterion::new(basis, settings.epsilon);
    let mut rows: Vec<Row> = vec![Row::new(); basis.len()];
    let mut report = MeshlessReport { senders: basis.senders().len(), ..Default::default() };
    let mut receivers: Vec<usize> = basis.level(0).collect();
    let mut steps_done = 0;
    for level in 0..basis.levels() {
        for step in receivers.chunks(RECEIVERS_PER_STEP) {
            cancelled(observer)?;
            if level + 1 == basis.levels() && !kept.has(steps_done) {
                steps_done += 1;
                continue;
            }
            let make = || {
                let gather = |scratch: &mut _, &receiver: &usize| {
                    let (mut row, is_root) = gatherer.gather(scratch, receiver, level, &rows);
                    criterion.prune(&mut row, is_root, level);
                    row
                };
                step.par_iter().map_init(|| gatherer.scratch(), gather).collect()
            };
            let found = steps::kept_or_made(kept, steps_done, step.len(), basis.senders().len(), make)?;
            steps_done += 1;
            step.iter().zip(found).for_each(|(&receiver, row)| rows[receiver] = row);
            observer.event(Event::Advanced { done: step.last().map_or(0, |&r| r as u64) });
        }
        report.functions.push(basis.level(level).len());
        report.gathered.push(receivers.len());
        report.links_of_level.push(receivers.iter().map(|&r| rows[r].len()).sum());
        receivers = children_of(basis, level, &rows);
    }
    let transport = Transport::from_rows(&rows, basis.senders().len());
    report.rays_traced = (report.gathered.iter().sum::<usize>() * settings.rays) as u64;
    report.links = transport.packed().len();
    report.share = transport.share();
    report.bytes_links = transport.bytes();
    report.bytes_points = basis.bytes();
    Ok((transport, report))
}

#[cfg(test)]
mod tests;
