//! Bounced light, brought up to date step by step: a moved light casts rays for that light only, an edited material none.

use super::{RenderRequest, station};
use lapidary_core::lights::Light;
use lapidary_render::{Baked, SourceLighting, SourceRig};
use std::sync::Arc;

/// The surface samples of a dataset, and what they were lit with last.
pub struct Bounce {
    rig: SourceRig,
    appearance_revision: Option<u64>,
    light_revision: Option<u64>,
    lights: Option<Arc<[Light]>>,
    lighting: Option<Arc<SourceLighting>>,
}

impl Bounce {
    /// Of a dataset, in the dark; `None` if it has no surface samples.
    pub fn new(baked: &Baked) -> Option<Self> {
        let rig = SourceRig::new(baked)?;
        Some(Self { rig, appearance_revision: None, light_revision: None, lights: None, lighting: None })
    }

    /// What the samples send under the request's lights and materials and under the environment's light.
    pub fn lighting(&mut self, request: &RenderRequest, environment: &station::Light) -> Arc<SourceLighting> {
        if self.appearance_revision != Some(request.appearance_revision) {
            self.rig.set_appearance(&request.appearance);
            (self.appearance_revision, self.lighting) = (Some(request.appearance_revision), None);
        }
        if self.light_revision != Some(environment.revision) {
            self.rig.set_environment(Some(&environment.lighting));
            (self.light_revision, self.lighting) = (Some(environment.revision), None);
        }
        if !self.lights.as_ref().is_some_and(|lights| Arc::ptr_eq(lights, &request.lights)) {
            self.rig.set_lights(&request.lights);
            (self.lights, self.lighting) = (Some(request.lights.clone()), None);
        }
        let known = self.lighting.take().filter(|lighting| lighting.max_nodes == request.illum_cut);
        let lighting = known.unwrap_or_else(|| self.rig.lighting(request.illum_cut).into());
        self.lighting.insert(lighting).clone()
    }
}
