//! The single-bounce operator by receiver-centric adaptive refinement (meshless paper, 3.1, Fig. 5 and appendix).
//!
//! Level by level, each receiver gathers the links from all senders with one set of hemisphere rays (Eq. 16), subtracts what
//! its parents already account for (Eq. 17), keeps what is significant, and has its children examined if anything was.
//!
//! Departures from the paper: reflectance is not inside (see [`lapidary_core::meshless::Transport`]), so `ε` is compared
//! with the link of a white sender, `‖T_ij‖ / π`. Rays are uniform over the hemisphere and not by cosine, whose estimate
//! of the tangential parts of vector irradiance has no finite variance; they are stratified as a Fibonacci lattice, turned
//! and shifted at random by receiver, so that parents and children do not repeat each other's error.

mod gather;
mod refine;

use crate::{BakeError, Event, Observer, Phase};
use gather::{Gatherer, Row};
use lapidary_core::{
    meshless::{Basis, Transport},
    surfel::Surface,
};
use rayon::prelude::*;
use refine::{Criterion, children_of};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Receivers between two looks at the observer.
const RECEIVERS_PER_STEP: usize = 1024;

/// What decides the operator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransportSettings {
    /// Rays of a gather, 1 or more; their number is what limits noise.
    pub rays: usize,
    /// Links are kept above this share of the irradiance of a white sender, 0 to 1; smaller is finer.
    pub epsilon: f32,
}

impl Default for TransportSettings {
    /// Those of the paper.
    fn default() -> Self {
        Self { rays: 512, epsilon: 0.025 }
    }
}

/// How the refinement went.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TransportReport {
    /// Functions of each level.
    pub functions: Vec<usize>,
    /// Functions of all levels that send.
    pub senders: usize,
    /// Receivers of each level that were gathered.
    pub gathered: Vec<usize>,
    /// Links kept of each level's receivers.
    pub links_of_level: Vec<usize>,
    /// Links kept.
    pub links: usize,
    /// Share of the product of senders and receivers.
    pub share: f64,
    /// Rays traced.
    pub rays: u64,
    /// Bytes of links.
    pub bytes_links: u64,
    /// Bytes of points.
    pub bytes_points: u64,
    /// Wall-clock seconds of the refinement.
    pub seconds: f64,
}

/// Computes the operator of a basis on its surface. The result depends on neither threads nor time.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn transport_operator(
    surface: &dyn Surface,
    basis: &Basis,
    settings: TransportSettings,
    observer: &dyn Observer,
) -> Result<(Transport, TransportReport), BakeError> {
    let start = Instant::now();
    observer.event(Event::Started { phase: Phase::Transport, total: basis.len() as u64, unit: "functions" });
    let gatherer = Gatherer::new(surface, basis, settings.rays);
    let criterion = Criterion::new(basis, settings.epsilon);
    let mut rows: Vec<Row> = vec![Row::new(); basis.len()];
    let mut report = TransportReport { senders: basis.senders().len(), ..Default::default() };
    let mut receivers: Vec<usize> = basis.level(0).collect();
    for level in 0..basis.levels() {
        for step in receivers.chunks(RECEIVERS_PER_STEP) {
            crate::bake::cancelled(observer)?;
            let gather = |scratch: &mut _, &receiver: &usize| {
                let mut row = gatherer.gather(scratch, receiver, level, &rows);
                criterion.prune(&mut row);
                row
            };
            let found: Vec<Row> = step.par_iter().map_init(|| gatherer.scratch(), gather).collect();
            step.iter().zip(found).for_each(|(&receiver, row)| rows[receiver] = row);
            observer.event(Event::Advanced { done: step.last().map_or(0, |&r| r as u64) });
        }
        report.functions.push(basis.level(level).len());
        report.gathered.push(receivers.len());
        report.links_of_level.push(receivers.iter().map(|&r| rows[r].len()).sum());
        receivers = children_of(basis, level, &rows);
    }
    let transport = Transport::from_rows(&rows, basis.senders().len());
    report.rays = (report.gathered.iter().sum::<usize>() * settings.rays) as u64;
    report.links = transport.packed().len();
    report.share = transport.share();
    report.bytes_links = transport.bytes();
    report.bytes_points = basis.bytes();
    report.seconds = start.elapsed().as_secs_f64();
    Ok((transport, report))
}

#[cfg(test)]
mod tests;
