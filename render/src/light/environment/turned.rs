//! Light of an environment that is computed at its first reader. A device computes what pictures show of it by kernels of its own, so
//! that a turned environment need not be lit on the cores.

use super::SceneLighting;
use crate::light::{mirrored_map::MirroredMap, situation::Gathering};
use glam::Vec3;
use lapidary_core::{
    environment::{Environment, Pyramid},
    light_tree::{EnvironmentSampler, GridEnergy, LightTree},
};
use std::{
    ops::Deref,
    sync::{Arc, OnceLock},
};

/// The light samples of a scene.
#[derive(Debug)]
pub struct LightSamples {
    /// Its leaves are the samples.
    pub tree: LightTree,
    pub sampler: EnvironmentSampler,
}

/// A map, resampled for light samples.
#[derive(Debug)]
pub struct SampledMap {
    /// The map itself, without its suns.
    pub environment: Arc<Environment>,
    pub energy: GridEnergy,
    is_black: bool,
}

impl SampledMap {
    pub fn new(environment: Arc<Environment>, sampler: &EnvironmentSampler) -> Self {
        let energy = sampler.grid_energy(&environment);
        let is_black = energy.cells().iter().all(|&cell| cell == Vec3::ZERO);
        Self { environment, energy, is_black }
    }
}

/// A rotated and scaled map over light samples: all that their light depends on.
#[derive(Clone, Debug)]
pub struct TurnedMap {
    pub samples: Arc<LightSamples>,
    pub map: Arc<SampledMap>,
    /// In radians, counter-clockwise seen from +Y.
    pub rotation: f32,
    /// Scales radiance.
    pub intensity: f32,
    pub gathering: Gathering,
}

impl TurnedMap {
    /// Computes the light.
    pub fn lighting(&self) -> SceneLighting {
        let (Self { map, rotation, intensity, .. }, LightSamples { tree, sampler }) = (self, &*self.samples);
        let leaves = sampler.leaf_radiance(tree, &map.energy, *rotation, *intensity);
        let mut lighting = SceneLighting::new(tree, &leaves, self.gathering.illum_cut);
        lighting.lights.mirrored = Some(MirroredMap::new(&map.environment, *rotation, *intensity));
        lighting.with_tau(self.gathering.tau)
    }
}

/// Light of an environment, computed at its first reader. Parallel loops are given the light itself: a thread that waits for it must not
/// be one of those that compute it.
#[derive(Debug)]
pub struct EnvironmentLight(Source);

#[derive(Debug)]
enum Source {
    Given(SceneLighting),
    Turned(TurnedMap, OnceLock<SceneLighting>),
}

impl EnvironmentLight {
    /// Light of a map, not computed yet.
    pub(crate) fn new(map: TurnedMap) -> Self {
        Self(Source::Turned(map, OnceLock::new()))
    }

    /// Whether any sample shines. Computes nothing.
    pub fn shines(&self) -> bool {
        match &self.0 {
            Source::Given(lighting) => lighting.nodes.radiance[1].max_element() > 0.0,
            Source::Turned(turned, _) => turned.intensity > 0.0 && !turned.map.is_black,
        }
    }

    /// The light, if it is computed already.
    pub fn computed(&self) -> Option<&SceneLighting> {
        match &self.0 {
            Source::Given(lighting) => Some(lighting),
            Source::Turned(_, lighting) => lighting.get(),
        }
    }

    /// Computes the light, unless that is done.
    pub fn compute(&self) -> &SceneLighting {
        match &self.0 {
            Source::Given(lighting) => lighting,
            Source::Turned(turned, lighting) => lighting.get_or_init(|| turned.lighting()),
        }
    }

    /// What it is computed from, unless it was given.
    pub(crate) fn turned(&self) -> Option<&TurnedMap> {
        match &self.0 {
            Source::Given(_) => None,
            Source::Turned(turned, _) => Some(turned),
        }
    }

    /// Levels of the map that sharp lobes read. Computes no light.
    pub(crate) fn pyramid(&self) -> Option<Arc<Pyramid>> {
        match &self.0 {
            Source::Given(lighting) => lighting.lights.mirrored.as_ref().map(|map| map.pyramid().clone()),
            Source::Turned(turned, _) => Some(turned.map.environment.pyramid()),
        }
    }
}

impl Deref for EnvironmentLight {
    type Target = SceneLighting;

    fn deref(&self) -> &SceneLighting {
        self.compute()
    }
}

impl From<SceneLighting> for Arc<EnvironmentLight> {
    fn from(lighting: SceneLighting) -> Self {
        Arc::new(EnvironmentLight(Source::Given(lighting)))
    }
}
