//! Light of a tree's nodes as pixels merge it. Leaves are samples of the environment or surface sources.

use super::{
    node_row::{NodeExtent, NodeRow},
    sent::SentByDirection,
};
use lapidary_core::{
    color::luminance,
    cut::{
        illumination::{IlluminationCriterion, intensity_cut},
        lit::{CutValues, DEFAULT_TAU, LitCuts},
    },
    light_tree::NodeLight,
};
use rayon::prelude::*;
use std::sync::Arc;

/// A tree of lights `L` under one illumination.
#[derive(Clone, Debug)]
pub struct TreeLight<L> {
    /// Leaf data that the merge needs.
    pub lights: L,
    /// Radiance, places and spreads by heap index.
    pub nodes: NodeLight,
    /// Packed illumination cut.
    pub cut: Vec<u16>,
    /// Most nodes allowed in the illumination cut.
    pub max_nodes: u32,
    /// The vertices' lit cuts.
    pub lit: LitCuts,
    /// Place, spread and radiance of each node side by side, for pixels.
    pub(crate) rows: Vec<NodeRow>,
    /// Radius of each node, a half-angle in radians or in meters, and its brightness.
    pub(crate) extents: Vec<NodeExtent>,
    /// What its nodes send by direction, if they are surfaces that do.
    pub(crate) sent: Option<Arc<SentByDirection>>,
}

impl<L> TreeLight<L> {
    /// Light on nodes with these radii, with an illumination cut of at most `max_nodes` nodes. Vertex cuts hold `values`.
    pub(super) fn of(lights: L, nodes: NodeLight, radii: &[f32], values: CutValues, max_nodes: u32) -> Self {
        let criterion = IlluminationCriterion::with_budget(max_nodes);
        let luminances = nodes.radiance.iter().map(|&radiance| luminance(radiance));
        Self {
            cut: intensity_cut(&nodes.intensity, &nodes.intensity_sq, criterion),
            lit: LitCuts::new(values, luminances, DEFAULT_TAU),
            rows: NodeRow::of_all(&nodes.place, &nodes.spread, &nodes.radiance),
            extents: NodeExtent::of_all(radii, &nodes.intensity, &nodes.intensity_sq),
            lights,
            nodes,
            max_nodes,
            sent: None,
        }
    }

    /// Leaves of the tree.
    pub fn leaves(&self) -> usize {
        self.nodes.radiance.len() / 2
    }

    /// Height of the tree.
    pub fn height(&self) -> u32 {
        self.leaves().ilog2()
    }

    /// The same light by direction. Nodes count as bright as they are toward any.
    pub(crate) fn with_sent(mut self, sent: Option<Arc<SentByDirection>>) -> Self {
        if let Some(sent) = &sent {
            let brighten = |(node, extent): (usize, &mut NodeExtent)| extent.brightness *= sent.largest(node).max(1.0);
            self.extents.par_iter_mut().enumerate().skip(1).for_each(brighten);
        }
        Self { sent, ..self }
    }

    /// The same light with lit cuts of another `tau`; see [`LitCuts`].
    pub fn with_tau(self, tau: f32) -> Self {
        Self { lit: self.lit.with_tau(tau), ..self }
    }
}
