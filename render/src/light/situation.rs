//! The light sources of a scene, and the part of them that an edit changes. [`Redo::between`](crate::Redo::between) finds the
//! changes once; every rig and solver receives both.

use super::environment::EnvironmentLight;
use crate::{appearance::Appearance, baked::Baked, device::Compute};
use glam::Vec3;
use lapidary_core::{
    cut::lit::DEFAULT_TAU,
    lights::{Emission, Light},
    scene::pose::Poses,
};
use std::{ops::BitOr, sync::Arc};

/// Everything that lights a scene. A copy shares everything but the poses.
#[derive(Clone, Debug)]
pub struct Situation {
    /// The posed scene with its rays.
    pub scene: Baked,
    /// Objects away from their baked place.
    pub poses: Poses,
    /// Materials and textures, one for each material of the scene.
    pub appearance: Arc<Appearance>,
    /// The environment without its suns.
    pub environment: Option<Arc<EnvironmentLight>>,
    /// Suns of the environment.
    pub suns: Arc<[Light]>,
    /// Local lights.
    pub lights: Arc<[Light]>,
    /// How cuts gather bounced light.
    pub gathering: Gathering,
    /// Position of the eye in meters, toward which glossy surfaces of a posed scene reflect.
    pub eye: Vec3,
    /// Where solvers may compute.
    pub compute: Compute,
}

/// How cuts gather light from the solvers' trees; cuts over the environment use the same settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathering {
    /// Most nodes in an illumination cut.
    pub illum_cut: u32,
    /// Threshold of lit cuts; see [`SourceLighting::with_tau`](crate::SourceLighting::with_tau).
    pub tau: f32,
}

impl Situation {
    /// A scene as baked, without light.
    pub fn unlit(baked: &Baked) -> Self {
        Self {
            scene: baked.clone(),
            poses: Poses::default(),
            appearance: Appearance::of(&baked.dataset.scene).into(),
            environment: None,
            suns: Arc::default(),
            lights: Arc::default(),
            gathering: Gathering { illum_cut: 1, tau: DEFAULT_TAU },
            eye: Vec3::ZERO,
            compute: Compute::Cores,
        }
    }

    /// Lights that bounce. A sun is reduced to its center, because the points it lights are too far apart for its penumbra.
    pub fn bouncing(&self) -> Vec<Light> {
        let middle = |sun: &Light| Light { emission: Emission::PARALLEL, ..sun.clone() };
        self.lights.iter().cloned().chain(self.suns.iter().map(middle)).collect()
    }
}

/// Parts of a [`Situation`] that differ from the previous one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// The scene's vertices and rays.
    pub poses: bool,
    /// Materials and textures.
    pub appearance: bool,
    /// The environment and its suns.
    pub environment: bool,
    /// Local lights.
    pub lights: bool,
    /// How cuts gather.
    pub gathering: bool,
    /// The eye, while something is posed.
    pub eye: bool,
}

impl Changes {
    /// Everything, as after opening a scene.
    pub const ALL: Self =
        Self { poses: true, appearance: true, environment: true, lights: true, gathering: true, eye: true };
    /// Nothing.
    pub const NONE: Self =
        Self { poses: false, appearance: false, environment: false, lights: false, gathering: false, eye: false };

    /// Whether anything has changed.
    pub fn any(self) -> bool {
        self != Self::NONE
    }

    /// Whether surfaces of the scene as baked receive or send other light.
    pub fn relight(self) -> bool {
        self.appearance || self.environment || self.lights
    }
}

impl BitOr for Changes {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self {
            poses: self.poses || other.poses,
            appearance: self.appearance || other.appearance,
            environment: self.environment || other.environment,
            lights: self.lights || other.lights,
            gathering: self.gathering || other.gathering,
            eye: self.eye || other.eye,
        }
    }
}

/// State that depends on the lighting. It takes a situation and its changes since the last one.
pub trait Relight {
    /// Recomputes what the changes make stale.
    fn update(&mut self, situation: &Situation, changes: Changes);
}

/// State that is lit on use, with the changes recorded until then.
pub struct Pending<L> {
    lit: L,
    changes: Changes,
}

impl<L: Relight> Pending<L> {
    /// Wraps unlit state.
    pub fn new(lit: L) -> Self {
        Self { lit, changes: Changes::ALL }
    }

    /// Records changes.
    pub fn note(&mut self, changes: Changes) {
        self.changes = self.changes | changes;
    }

    /// The state before the recorded changes.
    pub fn before(&self) -> &L {
        &self.lit
    }

    /// Applies the recorded changes.
    pub fn lit(&mut self, situation: &Situation) -> &mut L {
        let changes = std::mem::take(&mut self.changes);
        if changes.any() {
            self.lit.update(situation, changes);
        }
        &mut self.lit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::linked_floor_and_wall;

    struct Log(Vec<Changes>);

    impl Relight for Log {
        fn update(&mut self, _: &Situation, changes: Changes) {
            self.0.push(changes);
        }
    }

    #[test]
    fn what_is_lit_takes_all_changes_since_it_was_used_and_each_once() {
        let situation = Situation::unlit(&linked_floor_and_wall().into());
        let [lights, poses] = [Changes { lights: true, ..Changes::NONE }, Changes { poses: true, ..Changes::NONE }];
        let mut pending = Pending::new(Log(Vec::new()));
        assert_eq!(pending.lit(&situation).0, [Changes::ALL], "everything is new the first time");
        pending.note(Changes::NONE);
        assert_eq!(pending.lit(&situation).0.len(), 1, "nothing has changed");
        pending.note(lights);
        pending.note(poses);
        assert_eq!(pending.lit(&situation).0[1..], [Changes { lights: true, poses: true, ..Changes::NONE }]);
        assert_eq!(pending.lit(&situation).0.len(), 2);
    }
}
