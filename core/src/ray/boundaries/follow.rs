//! Probing, and following of the boundaries between probes.

use super::graph::{Graph, Touching};
use crate::simd::{Kernel, Lanes};

/// Visibility of a group, before and while it is traced.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Known {
    /// Unknown: its block has no probe.
    Nothing,
    /// Its probe is blocked.
    Blocked,
    /// Its probe is unblocked.
    Seen,
    Traced,
}

/// State of all groups of a graph.
#[derive(Default)]
pub(super) struct State {
    /// Per group, the requested lanes.
    pub wanted: Vec<u8>,
    /// Per block, the result of its probe.
    pub predicted: Vec<Known>,
    /// Per group, the known visibility.
    known: Vec<Known>,
    /// Per group, the unblocked lanes.
    pub open: Vec<u8>,
    /// Groups to trace.
    front: Vec<u32>,
}

impl State {
    /// Puts groups between seen and blocked blocks, and blocks without a probe, on the front.
    fn start(&mut self, graph: &Graph) {
        self.known.clear();
        self.known.extend((0..graph.groups.len()).map(|group| self.predicted[group / graph.block]));
        self.open.clear();
        for (index, group) in graph.groups.iter().enumerate() {
            let (wanted, known) = (self.wanted[index], self.known[index]);
            let differs = |other: &Touching| {
                self.wanted[other.group as usize] != 0 && self.known[other.group as usize] != Known::Seen
            };
            let is_front = match known {
                Known::Nothing => true,
                // One side of a boundary is enough: following leads to the other.
                Known::Seen => group.touching.iter().any(differs),
                Known::Blocked | Known::Traced => false,
            };
            self.open.push(if known == Known::Seen { wanted } else { 0 });
            if is_front && wanted != 0 {
                self.front.push(index as u32);
            }
        }
    }

    /// Records the result of a group, and puts touching groups that are expected to differ on the front.
    fn found(&mut self, graph: &Graph, index: usize, open: u8) {
        (self.open[index], self.known[index]) = (open, Known::Traced);
        for other in &graph.groups[index].touching {
            let (lanes, at) = (other.lanes & self.wanted[index], other.group as usize);
            let differs = match self.known[at] {
                Known::Seen => open & lanes != lanes,
                Known::Blocked => open & lanes != 0,
                Known::Nothing | Known::Traced => false,
            };
            if differs && self.wanted[at] != 0 {
                self.front.push(other.group);
            }
        }
    }

    /// Records the probe result of the next block, if it has one.
    pub fn predict(&mut self, is_open: Option<bool>) {
        let known = |open| if open { Known::Seen } else { Known::Blocked };
        self.predicted.push(is_open.map_or(Known::Nothing, known));
    }
}

/// Determines which rays are unblocked.
pub(super) trait Rays {
    /// Fills `wanted` and `predicted` of a state. Returns the number of probes.
    fn probe<L: Lanes>(&mut self, state: &mut State) -> u64;

    /// The unblocked rays of `active` in a group, one bit each.
    fn open<L: Lanes>(&mut self, group: usize, active: u8) -> u8;
}

/// Probes, and follows the boundaries between probes. Returns the number of rays requested.
pub(super) struct Follow<'a, R> {
    pub graph: &'a Graph,
    pub rays: R,
    pub state: &'a mut State,
}

impl<R: Rays> Kernel for Follow<'_, R> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        let Self { graph, mut rays, state } = self;
        state.wanted.clear();
        state.predicted.clear();
        let mut count = rays.probe::<L>(state);
        state.start(graph);
        while let Some(index) = state.front.pop() {
            let index = index as usize;
            if state.known[index] != Known::Traced {
                let wanted = state.wanted[index];
                count += u64::from(wanted.count_ones());
                let open = rays.open::<L>(index, wanted);
                state.found(graph, index, open);
            }
        }
        count
    }
}
