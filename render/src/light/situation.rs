//! What lights a scene, and what of it an edit changes. [`Redo::between`](crate::Redo::between) finds the changes once; whatever is
//! lit takes both.

use super::environment::SceneLighting;
use crate::{appearance::Appearance, baked::Baked};
use lapidary_core::{
    cut::lit::DEFAULT_TAU,
    lights::{Emission, Light},
    scene::pose::Poses,
};
use std::{ops::BitOr, sync::Arc};

/// All that lights a scene. A copy shares everything but the poses.
#[derive(Clone, Debug)]
pub struct Situation {
    /// The scene as its objects are posed, with its rays.
    pub scene: Baked,
    /// Objects that are not where they were baked.
    pub poses: Poses,
    /// Materials and textures, one for each material of the scene.
    pub appearance: Arc<Appearance>,
    /// The environment without its suns.
    pub environment: Option<Arc<SceneLighting>>,
    /// Suns of the environment.
    pub suns: Arc<[Light]>,
    /// Local lights.
    pub lights: Arc<[Light]>,
    /// How cuts gather bounced light.
    pub gathering: Gathering,
}

/// How cuts gather light from the trees of solvers; the cuts over the environment are made alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathering {
    /// Most nodes of an illumination cut.
    pub illum_cut: u32,
    /// Of lit cuts, see [`SourceLighting::with_tau`](crate::SourceLighting::with_tau).
    pub tau: f32,
}

impl Situation {
    /// A scene as it was baked, without light.
    pub fn unlit(baked: &Baked) -> Self {
        Self {
            scene: baked.clone(),
            poses: Poses::default(),
            appearance: Appearance::of(&baked.dataset.scene).into(),
            environment: None,
            suns: Arc::default(),
            lights: Arc::default(),
            gathering: Gathering { illum_cut: 1, tau: DEFAULT_TAU },
        }
    }

    /// The lights that bounce: of a sun the middle, for its penumbra is lost between the points that it lights.
    pub fn bouncing(&self) -> Vec<Light> {
        let middle = |sun: &Light| Light { emission: Emission::PARALLEL, ..sun.clone() };
        self.lights.iter().cloned().chain(self.suns.iter().map(middle)).collect()
    }
}

/// Parts of a [`Situation`] that differ from before.
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
}

impl Changes {
    /// Everything, as after a scene was opened.
    pub const ALL: Self = Self { poses: true, appearance: true, environment: true, lights: true, gathering: true };
    /// Nothing.
    pub const NONE: Self =
        Self { poses: false, appearance: false, environment: false, lights: false, gathering: false };

    /// Whether anything has changed.
    pub fn any(self) -> bool {
        self != Self::NONE
    }

    /// Whether surfaces of the scene as it was baked receive or send other light.
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
        }
    }
}

/// What is lit: it takes a situation and what of it has changed since the last one.
pub trait Relight {
    /// Redoes what the changes make stale.
    fn update(&mut self, situation: &Situation, changes: Changes);
}

/// Something that is lit only when it is used, with the changes until then.
pub struct Pending<L> {
    lit: L,
    changes: Changes,
}

impl<L: Relight> Pending<L> {
    /// One that has not been lit.
    pub fn new(lit: L) -> Self {
        Self { lit, changes: Changes::ALL }
    }

    /// Notes changes.
    pub fn note(&mut self, changes: Changes) {
        self.changes = self.changes | changes;
    }

    /// As it was before these changes.
    pub fn before(&self) -> &L {
        &self.lit
    }

    /// Lights it.
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
        assert_eq!(pending.lit(&situation).0, [Changes::ALL], "the first time all is new");
        pending.note(Changes::NONE);
        assert_eq!(pending.lit(&situation).0.len(), 1, "nothing has changed");
        pending.note(lights);
        pending.note(poses);
        assert_eq!(pending.lit(&situation).0[1..], [Changes { lights: true, poses: true, ..Changes::NONE }]);
        assert_eq!(pending.lit(&situation).0.len(), 2);
    }
}
