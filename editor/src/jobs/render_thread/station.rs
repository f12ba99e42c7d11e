//! The renderer and what it holds: brought up to date step by step, so that an edit redoes only what it changed.

use super::{Factory, RenderRequest, changes::same_dataset};
use lapidary_render::{
    Backend, BackendError, Baked, Illumination, LightRig, LocalLighting, LocalRig, SceneLighting, same_light,
};
use std::sync::Arc;

/// The renderer, its scene and its light.
pub struct Station {
    factory: Factory,
    backend: Option<Box<dyn Backend>>,
    baked: Option<Baked>,
    appearance_revision: Option<u64>,
    light: Option<Light>,
    /// Counts the lights that were made, for the window to see that one is new.
    light_revision: u64,
    rig: Option<LightRig>,
    local_rig: Option<LocalRig>,
    local: Option<LocalLighting>,
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
            baked: None,
            appearance_revision: None,
            light: None,
            light_revision: 0,
            rig: None,
            local_rig: None,
            local: None,
        }
    }

    /// Gives up the renderer; the next use makes another.
    pub fn reset(&mut self) {
        (self.backend, self.baked) = (None, None);
        self.forget_edits();
    }

    /// Everything beside the scene is to be given to the renderer again.
    fn forget_edits(&mut self) {
        (self.appearance_revision, self.light, self.local) = (None, None, None);
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

    /// Local lights and bounced light of the scene, if there is a scene.
    pub fn local(&self) -> Option<&LocalLighting> {
        self.local.as_ref()
    }

    /// Gives the renderer scene, appearance and light of a request, as far as it does not have them. Returns whether it
    /// got another scene. What had to be done to make something fit goes to `remark`.
    pub fn update(&mut self, request: &RenderRequest, remark: &dyn Fn(String)) -> Result<bool, BackendError> {
        let Some(baked) = &request.baked else { return Ok(false) };
        let new_scene = !same_dataset(self.baked.as_ref(), Some(baked));
        if new_scene {
            self.set_scene(baked)?;
        }
        if self.appearance_revision != Some(request.appearance_revision) {
            let remarks = self.backend()?.set_appearance(&request.look.appearance)?;
            remarks.into_iter().for_each(remark);
            if let Some(rig) = &mut self.local_rig {
                rig.set_appearance(&request.look.appearance);
            }
            self.appearance_revision = Some(request.appearance_revision);
        }
        let same =
            |l: &Light| same_light(&l.illumination, &request.look.light) && l.illum_cut == request.look.illum_cut;
        if !self.light.as_ref().is_some_and(same) {
            self.set_light(request, remark)?;
        }
        self.set_local_lighting(request, remark)?;
        Ok(new_scene)
    }

    /// The light rig is made beside the scene: each takes as long as the other.
    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError> {
        self.backend()?;
        let tree = &baked.dataset.tree;
        std::thread::scope(|threads| {
            let rig = threads.spawn(|| LightRig::new(tree));
            self.backend()?.set_scene(baked)?;
            let rig = rig.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            self.rig = Some(rig);
            Ok(())
        })?;
        self.baked = Some(baked.clone());
        self.local_rig = Some(LocalRig::new(baked));
        self.forget_edits();
        Ok(())
    }

    fn set_light(&mut self, request: &RenderRequest, remark: &dyn Fn(String)) -> Result<(), BackendError> {
        let Some(rig) = &mut self.rig else { return Ok(()) };
        let lighting = Arc::new(rig.lighting(&request.look.light, request.look.illum_cut));
        let remarks = self.backend()?.set_light(&request.look.light, &lighting)?;
        remarks.into_iter().for_each(remark);
        self.light_revision += 1;
        self.light = Some(Light {
            illumination: request.look.light.clone(),
            illum_cut: request.look.illum_cut,
            lighting,
            revision: self.light_revision,
        });
        Ok(())
    }

    /// Local lights, what bounces, and which parts are shown. Bounced light that is not shown is not computed.
    fn set_local_lighting(&mut self, request: &RenderRequest, remark: &dyn Fn(String)) -> Result<(), BackendError> {
        let Some(rig) = &mut self.local_rig else { return Ok(()) };
        rig.set_environment(self.light.as_ref().map(|light| &light.lighting));
        rig.set_lights(&request.look.lights);
        let local = rig.lighting(request.look.components, request.look.solution, request.look.illum_cut);
        if self.local.as_ref().is_some_and(|known| known.is_same(&local)) {
            return Ok(());
        }
        let remarks = self.backend()?.set_local_lighting(&local)?;
        remarks.into_iter().for_each(remark);
        self.local = Some(local);
        Ok(())
    }
}
