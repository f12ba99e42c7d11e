//! Lit points that several solvers share, so that each ray is cast once.

use super::{Lit, LitBy, Told};
use crate::{
    appearance::Appearance,
    baked::Baked,
    light::{
        bounce::{MeshlessRig, SourceRig},
        environment::SceneLighting,
    },
};
use lapidary_core::lights::Light;
use std::sync::{Arc, Mutex, PoisonError};

/// What solvers stand on.
pub struct Rigs {
    /// The materials of the bake, and no light.
    pub nothing: LitBy,
    /// `None` for a dataset without sources.
    pub sources: Option<Shared<SourceRig>>,
    /// `None` for a dataset without a meshless basis.
    pub meshless: Option<Shared<MeshlessRig>>,
}

impl Rigs {
    /// Those of a dataset.
    pub fn new(baked: &Baked) -> Self {
        let nothing = LitBy::nothing(Appearance::of(&baked.dataset.scene));
        Self {
            sources: SourceRig::new(baked).map(|rig| Shared::new(rig, &nothing)),
            meshless: MeshlessRig::new(baked).map(|rig| Shared::new(rig, &nothing)),
            nothing,
        }
    }
}

/// A rig that several solvers light, one at a time.
pub struct Shared<R>(Arc<Mutex<Told<R>>>);

impl<R> Clone for Shared<R> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<R: Lit> Shared<R> {
    fn new(rig: R, nothing: &LitBy) -> Self {
        Self(Arc::new(Mutex::new(Told::new(Box::new(rig), nothing))))
    }

    /// Uses the rig in some light. It redoes what is not as another solver left it.
    pub fn lit<T>(&self, by: &LitBy, use_rig: impl FnOnce(&mut R) -> T) -> T {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        use_rig(told.tell(by))
    }
}

impl Lit for SourceRig {
    fn set_appearance(&mut self, appearance: &Arc<Appearance>) {
        SourceRig::set_appearance(self, appearance);
    }

    fn set_lights(&mut self, lights: &Arc<[Light]>) {
        SourceRig::set_lights(self, lights);
    }

    fn set_environment(&mut self, environment: Option<&Arc<SceneLighting>>) {
        SourceRig::set_environment(self, environment.map(|lighting| &**lighting));
    }
}

impl Lit for MeshlessRig {
    fn set_appearance(&mut self, appearance: &Arc<Appearance>) {
        MeshlessRig::set_appearance(self, appearance);
    }

    fn set_lights(&mut self, lights: &Arc<[Light]>) {
        MeshlessRig::set_lights(self, lights);
    }

    fn set_environment(&mut self, environment: Option<&Arc<SceneLighting>>) {
        MeshlessRig::set_environment(self, environment.map(|lighting| &**lighting));
    }
}
