//! The light of a picture: radiance of the tree's nodes and the illumination cut. What an environment edit redoes.

use crate::renderer::Illumination;
use glam::Vec3;
use lapidary_core::{
    cut::illumination::{IlluminationCriterion, illumination_cut},
    environment::Environment,
    light_tree::{EnvironmentSampler, GridEnergy, LightTree, Lighting},
};
use std::sync::Arc;

/// A light tree under one illumination.
#[derive(Clone, Debug)]
pub struct SceneLighting {
    /// Radiance, directions and spreads by heap index.
    pub nodes: Lighting,
    /// Tangent of half of each node's radius, by heap index: for the refinement criterion.
    pub tan_half_radius: Vec<f32>,
    /// Packed illumination cut.
    pub cut: Vec<u16>,
    /// Most nodes that the illumination cut was allowed.
    pub max_nodes: u32,
    /// Solid angle of one leaf in steradians.
    pub leaf_solid_angle: f32,
}

impl SceneLighting {
    /// Means up the tree of `leaf_radiance` (one a leaf in tree order) and an illumination cut of at most `illum_cut` nodes.
    pub fn new(tree: &LightTree, leaf_radiance: &[Vec3], illum_cut: u32) -> Self {
        let nodes = Lighting::new(tree, leaf_radiance);
        let cut = illumination_cut(&nodes, IlluminationCriterion::with_budget(illum_cut));
        // A node wider than a hemisphere is split whatever the lobe; its tangent only has to be large.
        let tan_half_radius = nodes.radius.iter().map(|r| (0.5 * r.min(2.8)).tan()).collect();
        Self { nodes, tan_half_radius, cut, max_nodes: illum_cut, leaf_solid_angle: tree.leaf_solid_angle() }
    }
}

/// Lights a tree again and again: what does not depend on rotation and intensity is kept.
pub struct LightRig {
    sampler: EnvironmentSampler,
    resampled: Option<(Arc<Environment>, GridEnergy)>,
}

impl LightRig {
    /// For trees of `lights` samples; some tenths of a second for 32,768.
    pub fn new(lights: usize) -> Self {
        Self { sampler: EnvironmentSampler::new(lights), resampled: None }
    }

    /// Lights `tree` by `light`, with an illumination cut of at most `illum_cut` nodes.
    pub fn lighting(&mut self, tree: &LightTree, light: &Illumination, illum_cut: u32) -> SceneLighting {
        let known = self.resampled.take().filter(|(e, _)| Arc::ptr_eq(e, &light.environment));
        let resample = || (light.environment.clone(), self.sampler.grid_energy(&light.environment));
        let (_, energy) = self.resampled.insert(known.unwrap_or_else(resample));
        let leaves = self.sampler.leaf_radiance(tree, energy, light.rotation, light.intensity);
        SceneLighting::new(tree, &leaves, illum_cut)
    }
}
