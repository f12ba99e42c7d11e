//! What is shown at every size of the illumination cut.

use crate::args::Shot;
use anyhow::Result;
use lapidary_core::{dataset::Dataset, lights::Light};
use lapidary_render::{Appearance, Baked, Components, Illumination, Look, Renderer, Solution, View};
use std::sync::Arc;

/// A scene, its look, its light and a view of it.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The baked scene.
    pub baked: Baked,
    /// Its materials.
    pub appearance: Appearance,
    /// Camera and picture size.
    pub view: View,
    /// The environment; black if there is none.
    pub light: Illumination,
    /// Local lights.
    pub lights: Arc<[Light]>,
    /// The parts of the light that are in the picture.
    pub components: Components,
    /// How bounced light is computed.
    pub solution: Solution,
}

impl Subject {
    /// What the options of a command ask for.
    ///
    /// # Errors
    /// Bounced light was asked for, and the dataset has none of that kind.
    pub fn of(shot: &Shot) -> Result<Self> {
        let (components, solution) = shot.local.bounces_of(&shot.dataset)?;
        Ok(Self {
            lights: shot.local.lights.clone().into(),
            components,
            solution,
            ..Self::new(shot.dataset.clone(), shot.view.clone(), shot.light.clone())
        })
    }

    /// A dataset as it looks in a picture, seen by `view`.
    pub fn of_look(look: &Look, baked: &Baked, view: View) -> Self {
        Self {
            baked: baked.clone(),
            appearance: look.appearance.clone(),
            view,
            light: look.light.clone(),
            lights: look.lights.clone(),
            components: look.components,
            solution: look.solution,
        }
    }

    /// A dataset as it was baked, under an environment alone.
    pub fn new(baked: impl Into<Baked>, view: View, light: Illumination) -> Self {
        let baked = baked.into();
        Self {
            appearance: Appearance::of(&baked.dataset.scene),
            baked,
            view,
            light,
            lights: Arc::default(),
            components: Components { environment: true, ..Components::NONE },
            solution: Solution::default(),
        }
    }

    /// The dataset.
    pub fn dataset(&self) -> &Dataset {
        &self.baked.dataset
    }

    /// What casts rays on the scene as it looks here.
    pub fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(self.baked.clone());
        renderer.set_appearance(self.appearance.fitted(&self.dataset().scene.materials).0);
        renderer
    }
}
