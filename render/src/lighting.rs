//! The light of a picture: radiance of the tree's nodes and the illumination cut. What an environment edit redoes.

use crate::renderer::Illumination;
use glam::Vec3;
use lapidary_core::{
    cut::illumination::{IlluminationCriterion, illumination_cut},
    light_tree::{EnvironmentSampler, LightTree, Lighting},
};

/// A light tree under one illumination.
pub struct SceneLighting {
    /// Radiance, directions and spreads by heap index.
    pub nodes: Lighting,
    /// Tangent of half of each node's radius, by heap index: for the refinement criterion.
    pub tan_half_radius: Vec<f32>,
    /// Packed illumination cut.
    pub cut: Vec<u16>,
    /// Solid angle of one leaf in steradians.
    pub leaf_solid_angle: f32,
}

impl SceneLighting {
    /// Resamples the environment to the leaves of `tree` and selects an illumination cut of at most `illum_cut` nodes.
    pub fn new(sampler: &EnvironmentSampler, tree: &LightTree, light: &Illumination, illum_cut: u32) -> Self {
        let energy = sampler.grid_energy(&light.environment);
        let leaves: Vec<Vec3> = sampler.leaf_radiance(tree, &energy, light.rotation, light.intensity);
        let nodes = Lighting::new(tree, &leaves);
        let cut = illumination_cut(&nodes, IlluminationCriterion::with_budget(illum_cut));
        // A node wider than a hemisphere is split whatever the lobe; its tangent only has to be large.
        let tan_half_radius = nodes.radius.iter().map(|r| (0.5 * r.min(2.8)).tan()).collect();
        Self { nodes, tan_half_radius, cut, leaf_solid_angle: tree.leaf_solid_angle() }
    }
}
