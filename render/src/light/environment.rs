//! Light of the environment: node radiance on its tree and the illumination cut. An edit of the environment recomputes both.

mod turned;

pub use turned::EnvironmentLight;
pub(crate) use turned::{LightSamples, SampledMap, TurnedMap};

use crate::light::{mirrored_map::MirroredMap, situation::Gathering, tree_light::TreeLight};
use glam::{Quat, Vec3};
use lapidary_core::{
    cut::{
        lit::{CutValues, DEFAULT_TAU},
        packed::PackedCuts,
    },
    environment::{Environment, Sun, SunSettings},
    light_tree::{EnvironmentSampler, LightTree, NodeLight},
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
    /// How suns are taken from the map, with shadows of their own; `None` leaves all light to the light samples.
    pub sun: Option<SunSettings>,
}

impl Illumination {
    /// Whether both give the same light; maps are compared by address.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.environment, &other.environment)
            && (self.rotation, self.intensity, self.sun) == (other.rotation, other.intensity, other.sun)
    }

    /// Suns of the rotated and scaled map.
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

    /// The map of the light samples: without its suns.
    pub fn sampled(&self) -> Arc<Environment> {
        let rest = self.sun.and_then(|settings| self.environment.suns(settings).rest.clone());
        rest.unwrap_or_else(|| self.environment.clone())
    }
}

/// The light of an environment's tree.
pub type SceneLighting = TreeLight<Distant>;

/// Samples of an environment.
#[derive(Clone, Debug)]
pub struct Distant {
    /// Solid angle of one sample in steradians.
    pub leaf_solid_angle: f32,
    /// The sampled map, for sharp lobes.
    pub mirrored: Option<MirroredMap>,
}

impl SceneLighting {
    /// Computes means up the tree from `leaf_radiance` (one value per leaf in tree order) and an illumination cut of at
    /// most `illum_cut` nodes.
    pub fn new(tree: &LightTree, leaf_radiance: &[Vec3], illum_cut: u32) -> Self {
        let lights = Distant { leaf_solid_angle: tree.leaf_solid_angle(), mirrored: None };
        Self::of(lights, NodeLight::distant(tree, leaf_radiance), tree.radii(), CutValues::Visibility, illum_cut)
    }

    /// The same light for a scene in which some of the vertices' cuts are replaced.
    pub fn with_replaced_cuts(&self, cuts: &PackedCuts) -> Self {
        Self { lit: self.lit.with_replaced(cuts), ..self.clone() }
    }
}

/// Lights a tree repeatedly and keeps results that do not depend on rotation and intensity.
pub struct LightRig {
    samples: Arc<LightSamples>,
    sampled: Option<Arc<SampledMap>>,
}

impl LightRig {
    /// Prepares a tree; takes some tenths of a second for 32,768 samples.
    pub fn new(tree: &LightTree) -> Self {
        let samples = LightSamples { tree: tree.clone(), sampler: EnvironmentSampler::new(tree.len()) };
        Self { samples: samples.into(), sampled: None }
    }

    /// Lights the tree by `light`, with an illumination cut of at most `illum_cut` nodes.
    pub fn lighting(&mut self, light: &Illumination, illum_cut: u32) -> SceneLighting {
        self.turned(light, Gathering { illum_cut, tau: DEFAULT_TAU }).lighting()
    }

    /// The same light for cuts that gather so, computed at its first reader.
    pub(crate) fn light(&mut self, light: &Illumination, gathering: Gathering) -> EnvironmentLight {
        EnvironmentLight::new(self.turned(light, gathering))
    }

    fn turned(&mut self, light: &Illumination, gathering: Gathering) -> TurnedMap {
        let environment = light.sampled();
        let known = self.sampled.take().filter(|map| Arc::ptr_eq(&map.environment, &environment));
        let resample = || SampledMap::new(environment, &self.samples.sampler).into();
        let map = self.sampled.insert(known.unwrap_or_else(resample)).clone();
        let (rotation, intensity) = (light.rotation, light.intensity);
        TurnedMap { samples: self.samples.clone(), map, rotation, intensity, gathering }
    }
}

#[cfg(test)]
mod tests;
