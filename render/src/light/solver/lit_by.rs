//! What lights a scene, and who was told.

use super::{Gathering, Lit};
use crate::{
    appearance::Appearance,
    light::environment::{SceneLighting, is_same},
};
use lapidary_core::{cut::lit::DEFAULT_TAU, lights::Light, scene::pose::Poses};
use std::sync::Arc;

/// All that lights a scene. Parts are the same if they are one allocation.
#[derive(Clone)]
pub struct LitBy {
    pub poses: Arc<Poses>,
    pub appearance: Arc<Appearance>,
    pub lights: Arc<[Light]>,
    pub environment: Option<Arc<SceneLighting>>,
    pub gathering: Gathering,
}

impl LitBy {
    /// The materials of a bake, and no light.
    pub fn nothing(appearance: Appearance) -> Self {
        Self {
            poses: Arc::default(),
            appearance: appearance.into(),
            lights: Arc::default(),
            environment: None,
            gathering: Gathering { illum_cut: 1, tau: DEFAULT_TAU },
        }
    }
}

impl Lit for LitBy {
    fn set_poses(&mut self, poses: &Arc<Poses>) {
        self.poses = poses.clone();
    }

    fn set_appearance(&mut self, appearance: &Arc<Appearance>) {
        self.appearance = appearance.clone();
    }

    fn set_lights(&mut self, lights: &Arc<[Light]>) {
        self.lights = lights.clone();
    }

    fn set_environment(&mut self, environment: Option<&Arc<SceneLighting>>) {
        self.environment = environment.cloned();
    }

    fn set_gathering(&mut self, gathering: Gathering) {
        self.gathering = gathering;
    }
}

/// What is lit, with what it was told.
pub struct Told<L: ?Sized> {
    by: LitBy,
    lit: Box<L>,
}

impl<L: Lit + ?Sized> Told<L> {
    /// One that has the materials of the bake, and no light.
    pub fn new(lit: Box<L>, nothing: &LitBy) -> Self {
        Self { by: nothing.clone(), lit }
    }

    /// Tells it what is new, and returns it.
    pub fn tell(&mut self, by: &LitBy) -> &mut L {
        let Self { by: before, lit } = self;
        if !Arc::ptr_eq(&before.poses, &by.poses) {
            lit.set_poses(&by.poses);
        }
        if !Arc::ptr_eq(&before.appearance, &by.appearance) {
            lit.set_appearance(&by.appearance);
        }
        if !Arc::ptr_eq(&before.lights, &by.lights) {
            lit.set_lights(&by.lights);
        }
        if !is_same(before.environment.as_ref(), by.environment.as_ref()) {
            lit.set_environment(by.environment.as_ref());
        }
        if before.gathering != by.gathering {
            lit.set_gathering(by.gathering);
        }
        *before = by.clone();
        lit
    }
}
