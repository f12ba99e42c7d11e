//! Direct transport between the patches of a scene: the matrix of one bounce (wavelet paper, 4.3).
//!
//! Both ends of a pair of patches are halved while the kernel varies (4.3.2). What is left are pairs of nodes of almost constant
//! transport, and one Haar transform for each of the four squares makes coefficients of them: the paper's bottom-up integration
//! (4.3.1) of all links of a pair of patches at once. So no link is met twice.
//!
//! Departures: directions are as fine as the BRDF at once, since the paper refines them by the BRDF alone, and all samples of
//! a pair of nodes serve all cells of directions. Pairs that touch get Lambert's form factor in place of the mean of a singular
//! kernel; samples tell how much of it is blocked, and from where it comes. Both ends of what is left are made finer by form factors.

use super::{
    form_factor,
    oracle::{KernelSample, Pair, deviation},
};
use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    ray::Intersector,
    wavelet::{
        operator::{Operator, RadianceBasis, RadianceFunction, TransportCoefficient},
        patch::Patch,
        reflecting::ReflectingPatch,
        square::{Function, Node, transform, transform_products},
    },
};
use rayon::prelude::*;
use std::{
    collections::BTreeMap,
    f32::consts::PI,
    sync::atomic::{AtomicU64, Ordering},
};

/// Thresholds of direct transport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransportSettings {
    /// Largest variation of the kernel times the area of a part of the receiver (ε_r of the paper).
    pub receiver_threshold: f32,
    /// The same for the sender (ε_s): receivers are finer.
    pub sender_threshold: f32,
    /// Halvings of a patch at most.
    pub levels: u32,
    /// Blocks and coefficients of one bounce up to this are left out.
    pub least: f32,
    /// Coefficients of each power in the series of bounces up to this are left out (τ).
    pub compression: f32,
}

impl TransportSettings {
    /// In a room with a box 25 cm above its floor, all bounces are right to 1 % at each face. Locally one bounce is off by 5 %.
    pub const DEFAULT: Self =
        Self { receiver_threshold: 0.005, sender_threshold: 0.02, levels: 5, least: 1e-6, compression: 1e-5 };

    /// The default, compressed by another threshold (τ). One bounce is ten times as fine.
    pub fn compressed(compression: f32) -> Self {
        Self { least: 0.1 * compression, compression, ..Self::DEFAULT }
    }

    fn keeps(&self, coefficient: Vec3) -> bool {
        coefficient.abs().max_element() > self.least
    }
}

impl Default for TransportSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Halvings of receiver and sender beyond their refinement, by form factors without rays.
const FINER: [u32; 2] = [2, 1];

/// Parts of the transport between two patches that are almost constant: nodes of the receiver's places and directions, and of the
/// sender's places; with the coefficient between their smooth functions. For each function of the sender's directions.
type Blocks = BTreeMap<Function, Vec<([Node; 3], Vec3)>>;

/// The matrix of one bounce between the patches that are shown, and its functions.
///
/// # Errors
/// [`BakeError::Cancelled`].
pub fn direct_transport(
    patches: &[ReflectingPatch],
    is_shown: &(impl Fn(&Patch) -> bool + Sync),
    rays: &Intersector,
    offset: f32,
    settings: &TransportSettings,
    observer: &dyn Observer,
) -> Result<(RadianceBasis, Operator), BakeError> {
    let (pairs, made) = (patches.len() * patches.len(), AtomicU64::new(0));
    let of_pair = |index: usize| {
        cancelled(observer)?;
        let ends = [index / patches.len(), index % patches.len()];
        let takes_part = ends.iter().all(|&end| is_shown(&patches[end].patch));
        let coefficients = match takes_part {
            true => direct_transport_between(patches, index, rays, offset, settings),
            false => Vec::new(),
        };
        observer.event(Event::Advanced { done: made.fetch_add(1, Ordering::Relaxed) + 1 });
        Ok(coefficients)
    };
    let of_pairs: Vec<Vec<_>> = (0..pairs).into_par_iter().map(of_pair).collect::<Result<_, BakeError>>()?;
    Ok(Operator::of(of_pairs.concat()))
}

/// Transport of one bounce between two patches. The index of a pair is that of the receiver times the number of patches, plus that of
/// the sender.
pub(crate) fn direct_transport_between(
    patches: &[ReflectingPatch],
    index: usize,
    rays: &Intersector,
    offset: f32,
    settings: &TransportSettings,
) -> Vec<TransportCoefficient> {
    let [receiver, sender] = [index / patches.len(), index % patches.len()];
    let pair = Pair { receiver: &patches[receiver], sender: &patches[sender], rays, offset, seed: index as u32 };
    let refining = Refining { pair, settings };
    let mut blocks = Blocks::new();
    refining.refine([Node::ROOT; 2], &mut blocks);
    let coefficients = blocks.into_iter().flat_map(|(from_angle, blocks)| {
        transform_products(&blocks).into_iter().map(move |([space, angle, from_space], value)| TransportCoefficient {
            receiver: RadianceFunction { patch: receiver as u32, space, angle },
            sender: RadianceFunction { patch: sender as u32, space: from_space, angle: from_angle },
            value,
        })
    });
    coefficients.filter(|term| settings.keeps(term.value)).collect()
}

/// The refinement of a pair of patches.
struct Refining<'a> {
    pair: Pair<'a>,
    settings: &'a TransportSettings,
}

impl Refining<'_> {
    /// Halves both nodes as long as the kernel varies, and adds what is left to `blocks`.
    fn refine(&self, [receiver, sender]: [Node; 2], blocks: &mut Blocks) {
        let samples = self.pair.samples(receiver, sender);
        let is_seen = samples.iter().any(KernelSample::is_seen);
        let is_whole = receiver == Node::ROOT && sender == Node::ROOT;
        let is_facing = samples.iter().any(|sample| sample.unblocked > 0.0);
        if !is_facing || !is_seen && !is_whole {
            return;
        }
        let varies = deviation(&samples, self.pair.sender.cells.len());
        let exceeds = |node: Node, patch: &Patch, threshold: f32| {
            // Few samples of a whole patch may miss an opening.
            let is_coarse = varies * area(patch, node) > threshold || !is_seen;
            is_coarse && node.level() < self.settings.levels
        };
        let splits = [
            exceeds(receiver, &self.pair.receiver.patch, self.settings.receiver_threshold),
            exceeds(sender, &self.pair.sender.patch, self.settings.sender_threshold),
        ];
        if splits == [false; 2] {
            return self.add(&samples, [receiver, sender], blocks);
        }
        let parts = |node: Node, splits: bool| if splits { node.children().to_vec() } else { vec![node] };
        for part in parts(receiver, splits[0]) {
            parts(sender, splits[1]).into_iter().for_each(|from| self.refine([part, from], blocks));
        }
    }

    /// Adds the blocks of two nodes: one for each cell in which light arrives and each in which the sender got it.
    fn add(&self, samples: &[KernelSample], [receiver, sender]: [Node; 2], blocks: &mut Blocks) {
        let Pair { receiver: to, sender: from, .. } = self.pair;
        let unblocked: f32 = samples.iter().map(|sample| sample.unblocked).sum();
        let mean = self.mean_form_factor(samples, sender) * PI / area(&from.patch, sender);
        // Norms of the smooth functions, times the areas and weights of the nodes.
        let norm = (area(&to.patch, receiver) * area(&from.patch, sender)).sqrt() * to.cells.side as f32
            / from.cells.side as f32;
        let share = mean * norm / unblocked;
        let (receivers, senders) = (self.finer_receivers(receiver, sender), self.finer_senders(receiver, sender));
        for (arrives, reflected) in self.arriving(samples) {
            let mut of_cells: Vec<_> = from.angles().zip(reflected.into_iter().map(|sum| sum * share)).collect();
            transform(&mut of_cells, |function, value| {
                let ends = receivers.iter().flat_map(|to| senders.iter().map(move |from| (to, from)));
                for (&(receiver, to), &(sender, from)) in ends {
                    if self.settings.keeps(value * (to * from)) {
                        blocks.entry(function).or_default().push(([receiver, arrives, sender], value * (to * from)));
                    }
                }
            });
        }
    }

    /// Halvings of both ends beyond refinement. A receiver with directions has none: its cells are those of the samples of the block.
    fn finer_halvings(&self) -> [u32; 2] {
        if self.pair.receiver.cells.len() == 1 { FINER } else { [0; 2] }
    }

    /// Receivers finer than a block, with their shares of its coefficient.
    fn finer_receivers(&self, receiver: Node, sender: Node) -> Vec<(Node, f32)> {
        let Pair { receiver: to, sender: from, .. } = self.pair;
        let halvings = self.finer_halvings()[0].min(self.settings.levels - receiver.level());
        finer(&to.patch, receiver, &corners(&from.patch, sender), halvings)
    }

    /// The same of senders.
    fn finer_senders(&self, receiver: Node, sender: Node) -> Vec<(Node, f32)> {
        let Pair { receiver: to, sender: from, .. } = self.pair;
        let halvings = self.finer_halvings()[1].min(self.settings.levels - sender.level());
        finer(&from.patch, sender, &corners(&to.patch, receiver), halvings)
    }

    /// For each of the receiver's cells of directions that light arrives in, the kernel by cells of the sender, summed over samples.
    fn arriving(&self, samples: &[KernelSample]) -> BTreeMap<Node, Vec<Vec3>> {
        let level = self.pair.receiver.angle_level();
        let mut sums = BTreeMap::new();
        for sample in samples.iter().filter(|sample| sample.is_seen()) {
            let sum =
                sums.entry(Node::at(level, sample.arrives)).or_insert_with(|| vec![Vec3::ZERO; sample.reflected.len()]);
            sum.iter_mut().zip(&sample.reflected).for_each(|(sum, reflected)| *sum += *reflected * sample.unblocked);
        }
        sums
    }

    /// Mean form factor of a part of the sender from the sampled points of the receiver.
    fn mean_form_factor(&self, samples: &[KernelSample], sender: Node) -> f32 {
        let (to, corners) = (&self.pair.receiver, corners(&self.pair.sender.patch, sender));
        // Seen from behind, it sends nothing.
        let of_sample =
            |sample: &KernelSample| form_factor::from_point(sample.at, to.patch.normal(), &corners).max(0.0);
        samples.iter().map(of_sample).sum::<f32>() / samples.len() as f32
    }
}

/// Finer parts of one end of a block, with their shares of its coefficient: by Lambert's form factors of the other end from their
/// middles, while what is blocked is alike everywhere. So light has no steps where rays saw none.
fn finer(patch: &Patch, node: Node, other: &[Vec3; 4], halvings: u32) -> Vec<(Node, f32)> {
    let parts = (0..halvings).fold(vec![node], |parts, _| parts.iter().flat_map(|part| part.children()).collect());
    let middle = |part: &Node| patch.point(part.point(Vec2::splat(0.5)));
    let seen = |part: &Node| form_factor::from_point(middle(part), patch.normal(), other).max(0.0);
    let form_factors: Vec<f32> = parts.iter().map(seen).collect();
    let mean = form_factors.iter().sum::<f32>() / parts.len() as f32;
    if mean <= 0.0 {
        return vec![(node, 1.0)];
    }
    // The smooth function of a part is higher than that of the whole.
    let of_part = 0.5_f32.powi(halvings as i32) / mean;
    parts.into_iter().zip(form_factors).map(|(part, seen)| (part, seen * of_part)).collect()
}

/// The corners of a node of a patch.
fn corners(patch: &Patch, node: Node) -> [Vec3; 4] {
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| patch.point(node.point(Vec2::new(x, y))))
}

/// Area of a node of a patch in m².
fn area(patch: &Patch, node: Node) -> f32 {
    patch.area * node.side() * node.side()
}

#[cfg(test)]
mod tests;
