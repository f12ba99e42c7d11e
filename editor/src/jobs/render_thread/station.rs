//! The renderer and what it holds: brought up to date step by step, so that an edit redoes only what it changed.

use super::{
    Factory, Outbox, RenderEvent, RenderRequest,
    changes::{same_dataset, same_light},
};
use lapidary_core::dataset::Dataset;
use lapidary_render::{Backend, BackendError, Illumination, LightRig, SceneLighting};
use std::sync::Arc;

/// The renderer, its scene and its light.
pub struct Station {
    factory: Factory,
    backend: Option<Box<dyn Backend>>,
    dataset: Option<Arc<Dataset>>,
    appearance_revision: Option<u64>,
    light: Option<Light>,
    /// Counts the lights that were made, for the window to see that one is new.
    light_revision: u64,
    rig: Option<(usize, LightRig)>,
}

/// The light that the renderer has, and what it was made from.
#[derive(Clone)]
pub struct Light {
    illumination: Illumination,
    illum_cut: u32,
    /// The scene under it.
    pub lighting: Arc<SceneLighting>,
    /// See [`super::RenderedFrame::light_revision`].
    pub revision: u64,
}

impl Station {
    /// Without a renderer yet.
    pub fn new(factory: Factory) -> Self {
        Self {
            factory,
            backend: None,
            dataset: None,
            appearance_revision: None,
            light: None,
            light_revision: 0,
            rig: None,
        }
    }

    /// Gives up the renderer; the next use makes another.
    pub fn reset(&mut self) {
        (self.backend, self.dataset, self.appearance_revision, self.light) = (None, None, None, None);
    }

    /// The renderer.
    pub fn backend(&mut self) -> Result<&mut dyn Backend, BackendError> {
        let backend = match self.backend.take() {
            Some(backend) => backend,
            None => (self.factory)()?,
        };
        Ok(&mut **self.backend.insert(backend))
    }

    /// The light of the scene, if there is a scene.
    pub fn light(&self) -> Option<&Light> {
        self.light.as_ref()
    }

    /// Gives the renderer scene, appearance and light of a request, as far as it does not have them. Returns whether it
    /// got another scene.
    pub fn update(&mut self, request: &RenderRequest, outbox: &Outbox) -> Result<bool, BackendError> {
        let Some(dataset) = &request.dataset else { return Ok(false) };
        let new_scene = !same_dataset(self.dataset.as_ref(), Some(dataset));
        if new_scene {
            self.backend()?.set_scene(dataset)?;
            self.dataset = Some(dataset.clone());
            (self.appearance_revision, self.light) = (None, None);
        }
        if self.appearance_revision != Some(request.appearance_revision) {
            let remarks = self.backend()?.set_appearance(&request.appearance)?;
            remarks.into_iter().for_each(|remark| outbox.event(RenderEvent::Remark(remark)));
            self.appearance_revision = Some(request.appearance_revision);
        }
        let same = |l: &Light| same_light(&l.illumination, &request.illumination) && l.illum_cut == request.illum_cut;
        if !self.light.as_ref().is_some_and(same) {
            self.set_light(dataset, request)?;
        }
        Ok(new_scene)
    }

    fn set_light(&mut self, dataset: &Dataset, request: &RenderRequest) -> Result<(), BackendError> {
        let lights = dataset.tree.len();
        let kept = self.rig.take().filter(|(of, _)| *of == lights);
        let (_, rig) = self.rig.insert(kept.unwrap_or_else(|| (lights, LightRig::new(lights))));
        let lighting = Arc::new(rig.lighting(&dataset.tree, &request.illumination, request.illum_cut));
        self.backend()?.set_light(&request.illumination, &lighting)?;
        self.light_revision += 1;
        self.light = Some(Light {
            illumination: request.illumination.clone(),
            illum_cut: request.illum_cut,
            lighting,
            revision: self.light_revision,
        });
        Ok(())
    }
}
