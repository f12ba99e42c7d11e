//! Probes, and follows the boundaries between them.

use super::graph::{Graph, Touching};
use crate::simd::{Kernel, Lanes};

/// What is known of a group, before and while it is traced.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Known {
    /// Nothing: its block has no probe.
    Nothing,
    /// Its probe meets something.
    Blocked,
    /// Its probe meets nothing.
    Seen,
    Traced,
}

/// What is known of all groups of a graph.
#[derive(Default)]
pub(super) struct State {
    /// Per group, the lanes that are asked for.
    pub wanted: Vec<u8>,
    /// Per block, what its probe says.
    pub predicted: Vec<Known>,
    /// Per group.
    known: Vec<Known>,
    /// Per group, the lanes that meet nothing.
    pub open: Vec<u8>,
    /// Groups to trace.
    front: Vec<u32>,
}

impl State {
    /// Puts what is between a seen and a blocked block to the front, and what no probe tells of.
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
                // Of both sides of a boundary one is enough: it is followed to the other where it runs there.
                Known::Seen => group.touching.iter().any(differs),
                Known::Blocked | Known::Traced => false,
            };
            self.open.push(if known == Known::Seen { wanted } else { 0 });
            if is_front && wanted != 0 {
                self.front.push(index as u32);
            }
        }
    }

    /// Takes what was found in a group, and puts those that touch it and are expected to differ to the front.
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

    /// Takes what the probe of the next block says, if it has one.
    pub fn predict(&mut self, is_open: Option<bool>) {
        let known = |open| if open { Known::Seen } else { Known::Blocked };
        self.predicted.push(is_open.map_or(Known::Nothing, known));
    }
}

/// Tells which rays meet nothing.
pub(super) trait Rays {
    /// Fills `wanted` and `predicted` of a state. Returns the number of probes.
    fn probe<L: Lanes>(&mut self, state: &mut State) -> u64;

    /// Of the rays `active` of a group, one bit each, those that meet nothing.
    fn open<L: Lanes>(&mut self, group: usize, active: u8) -> u8;
}

/// Probes, and follows the boundaries between them. Gives the number of rays asked for.
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
