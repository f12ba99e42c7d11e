//! Local lights and bounced light of a dataset, prepared again and again: what an edit does not change is kept.

use crate::{
    Appearance, Baked, Components, LocalLighting, SceneLighting,
    indirect::{SourceLighting, SourceRig},
};
use lapidary_core::lights::Light;
use std::sync::Arc;

/// Makes the [`LocalLighting`] of a picture.
pub struct LocalRig {
    lights: Arc<[Light]>,
    environment: Option<Arc<SceneLighting>>,
    /// `None` for a dataset without sources.
    sources: Option<SourceRig>,
    /// What was gathered last and the size of its illumination cut; `None` after anything has changed.
    gathered: Option<(u32, Arc<SourceLighting>)>,
}

impl LocalRig {
    /// For a dataset that looks as it was baked, in the dark.
    pub fn new(baked: &Baked) -> Self {
        Self { lights: Arc::default(), environment: None, sources: SourceRig::new(baked), gathered: None }
    }

    /// Gives the scene other materials.
    pub fn set_appearance(&mut self, appearance: &Appearance) {
        if let Some(sources) = &mut self.sources {
            sources.set_appearance(appearance);
        }
        self.gathered = None;
    }

    /// Shines local lights; only those that are not as before cast rays, and none until bounced light is asked for.
    pub fn set_lights(&mut self, lights: &Arc<[Light]>) {
        if !Arc::ptr_eq(&self.lights, lights) {
            self.lights = lights.clone();
            self.gathered = None;
        }
    }

    /// Shines the environment, or none.
    pub fn set_environment(&mut self, lighting: Option<&Arc<SceneLighting>>) {
        let same = match (&self.environment, lighting) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if !same {
            self.environment = lighting.cloned();
            if let Some(sources) = &mut self.sources {
                sources.set_environment(lighting.map(|lighting| &**lighting));
            }
            self.gathered = None;
        }
    }

    /// What lights a picture that shows `components`, with an illumination cut of the sources of at most `illum_cut`
    /// nodes.
    pub fn lighting(&mut self, components: Components, illum_cut: u32) -> LocalLighting {
        let indirect = if components.indirect { self.gather(illum_cut) } else { None };
        LocalLighting { lights: self.lights.clone(), indirect, components }
    }

    fn gather(&mut self, illum_cut: u32) -> Option<Arc<SourceLighting>> {
        if self.gathered.as_ref().is_none_or(|(of, _)| *of != illum_cut) {
            let sources = self.sources.as_mut()?;
            sources.set_lights(&self.lights);
            self.gathered = Some((illum_cut, sources.lighting(illum_cut).into()));
        }
        self.gathered.as_ref().map(|(_, lighting)| lighting.clone())
    }
}
