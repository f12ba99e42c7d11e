//! The environment's light: radiance of the tree's nodes and the illumination cut, which an edit of the environment
//! recomputes.

use crate::light::{
    brightness,
    mirrored_map::MirroredMap,
    node_row::{NodeExtent, NodeRow},
};
use glam::{Quat, Vec3};
use lapidary_core::{
    color::luminance,
    cut::{
        illumination::{IlluminationCriterion, intensity_cut},
        lit::{CutValues, DEFAULT_TAU, LitCuts},
    },
    environment::{Environment, Sun, SunSettings},
    light_tree::{EnvironmentSampler, GridEnergy, LightTree, Lighting},
    lights::{Emission, Light},
};
use std::sync::Arc;

/// A distant light.
#[derive(Clone, Debug)]
pub struct Illumination {
    /// The map.
    pub environment: Arc<Environment>,
    /// Rotation of the map in radians, counter-clockwise seen from +Y.
    pub rotation: f32,
    /// Scales radiance.
    pub intensity: f32,
    /// What of the map becomes suns, with shadows of their own; `None` leaves all of it to the light samples.
    pub sun: Option<SunSettings>,
}

impl Illumination {
    /// Whether both give the same light; maps are compared by address.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.environment, &other.environment)
            && (self.rotation, self.intensity, self.sun) == (other.rotation, other.intensity, other.sun)
    }

    /// The suns of the map, as it is turned and scaled.
    pub fn suns(&self) -> Vec<Light> {
        let found = self.sun.map(|settings| self.environment.suns(settings));
        let turn = Quat::from_rotation_y(self.rotation);
        let light = |sun: &Sun| Light {
            name: "Sun".into(),
            enabled: true,
            emission: Emission::Directional { angle_degrees: sun.angle.to_degrees() },
            position: turn * sun.direction,
            target: Vec3::ZERO,
            intensity: self.intensity * sun.irradiance,
        };
        found.iter().flat_map(|found| &found.suns).map(light).filter(Light::shines).collect()
    }

    /// The map that light samples stand for: without its suns.
    pub fn sampled(&self) -> Arc<Environment> {
        let rest = self.sun.and_then(|settings| self.environment.suns(settings).rest.clone());
        rest.unwrap_or_else(|| self.environment.clone())
    }
}

/// A light tree under one illumination.
#[derive(Clone, Debug)]
pub struct SceneLighting {
    /// Radiance, directions and spreads by heap index.
    pub nodes: Lighting,
    /// Half-angles in radians of the cones of the nodes' directions, by heap index.
    pub radii: Arc<[f32]>,
    /// Packed illumination cut.
    pub cut: Vec<u16>,
    /// The vertices' lit cuts.
    pub lit: LitCuts,
    /// How bright each node is somewhere, over the mean of the whole tree; at least 1.
    pub brightness: Vec<f32>,
    /// Direction, inverse concentration and radiance of each node side by side, for pixels.
    pub(crate) rows: Vec<NodeRow>,
    /// Radius and brightness side by side.
    pub(crate) extents: Vec<NodeExtent>,
    /// The map that the leaves are samples of, for sharp lobes.
    pub mirrored: Option<MirroredMap>,
    /// Most nodes that the illumination cut was allowed.
    pub max_nodes: u32,
    /// Solid angle of one leaf in steradians.
    pub leaf_solid_angle: f32,
}

impl SceneLighting {
    /// The same light for a scene of which some vertices have other visibility cuts.
    pub fn with_replaced_cuts(&self, is_replaced: &[bool]) -> Self {
        Self { lit: self.lit.with_replaced(is_replaced), ..self.clone() }
    }

    /// Computes means up the tree from `leaf_radiance` (one value per leaf in tree order) and an illumination cut of at
    /// most `illum_cut` nodes.
    pub fn new(tree: &LightTree, leaf_radiance: &[Vec3], illum_cut: u32) -> Self {
        Self::with_radii(tree, tree.radii().into(), leaf_radiance, illum_cut)
    }

    fn with_radii(tree: &LightTree, radii: Arc<[f32]>, leaf_radiance: &[Vec3], illum_cut: u32) -> Self {
        let nodes = Lighting::new(tree, leaf_radiance);
        let means: Vec<f32> = nodes.radiance.iter().map(|&l| luminance(l)).collect();
        let cut = intensity_cut(&means, &nodes.luminance_sq, IlluminationCriterion::with_budget(illum_cut));
        let lit = LitCuts::new(CutValues::Visibility, means.iter().copied(), DEFAULT_TAU);
        let brightness = brightness(&means, &nodes.luminance_sq);
        let rows = NodeRow::of_all(&nodes.direction, &nodes.inv_kappa, &nodes.radiance);
        let extents = NodeExtent::of_all(&radii, &brightness);
        let leaf_solid_angle = tree.leaf_solid_angle();
        let mirrored = None;
        Self { nodes, radii, cut, lit, brightness, rows, extents, mirrored, max_nodes: illum_cut, leaf_solid_angle }
    }

    /// The same light with lit cuts of another `tau`, see [`LitCuts`].
    pub fn with_tau(self, tau: f32) -> Self {
        Self { lit: self.lit.with_tau(tau), ..self }
    }
}

/// Lights a tree repeatedly, and keeps what does not depend on rotation and intensity.
pub struct LightRig {
    tree: LightTree,
    radii: Arc<[f32]>,
    sampler: EnvironmentSampler,
    resampled: Option<(Arc<Environment>, GridEnergy)>,
}

impl LightRig {
    /// For a tree; some tenths of a second for 32,768 samples.
    pub fn new(tree: &LightTree) -> Self {
        let sampler = EnvironmentSampler::new(tree.len());
        Self { tree: tree.clone(), radii: tree.radii().into(), sampler, resampled: None }
    }

    /// Lights the tree by `light`, with an illumination cut of at most `illum_cut` nodes.
    pub fn lighting(&mut self, light: &Illumination, illum_cut: u32) -> SceneLighting {
        let sampled = light.sampled();
        let known = self.resampled.take().filter(|(e, _)| Arc::ptr_eq(e, &sampled));
        let resample = || (sampled.clone(), self.sampler.grid_energy(&sampled));
        let (_, energy) = self.resampled.insert(known.unwrap_or_else(resample));
        let leaves = self.sampler.leaf_radiance(&self.tree, energy, light.rotation, light.intensity);
        SceneLighting {
            mirrored: Some(MirroredMap::new(&sampled, light.rotation, light.intensity)),
            ..SceneLighting::with_radii(&self.tree, self.radii.clone(), &leaves, illum_cut)
        }
    }
}

#[cfg(test)]
mod tests;
