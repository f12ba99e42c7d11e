//! Errors of each solution of bounced light against light paths.

pub mod light_paths;
pub mod resolve;

use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{
    Baked, Components, CpuBackend, FinishedPicture, LitScene, Look, PathSettings, Progress, Renderer, Solution,
};
use light_paths::LightPaths;

/// Bounced light only; other studies measure the rest of a picture.
const INDIRECT: Components = Components { indirect: true, ..Components::NONE };

/// Bounced light of a scene by each solution and by the references.
pub struct BouncedLight {
    look: Look,
    scene: LitScene<CpuBackend>,
    /// Traces rays through the scene.
    pub renderer: Renderer,
}

impl BouncedLight {
    /// Prepares a look's bounced light, whatever its components and solution.
    ///
    /// # Errors
    /// None on this machine's cores.
    pub fn new(baked: Baked, look: Look) -> Result<Self> {
        let renderer = look.renderer(&baked);
        let scene = LitScene::new(Box::new(CpuBackend::new()), baked)?;
        Ok(Self { look: Look { components: INDIRECT, ..look }, scene, renderer })
    }

    /// The picture by a solution. Its seconds exclude the preparation of the light.
    ///
    /// # Errors
    /// None on this machine's cores.
    pub fn picture(&mut self, solution: Solution) -> Result<FinishedPicture> {
        let look = Look { solution, ..self.look.clone() };
        // Compute the light first, so that the picture's time excludes it.
        self.scene.light(&look)?;
        Ok(self.scene.show_whole(&look)?)
    }

    /// The light of the last picture with a ray from every pixel to every source instead of cuts, if it has sources.
    pub fn every_source(&self, progress: &dyn Progress) -> Option<Image> {
        let sources = self.scene.local().and_then(|local| local.sources())?;
        Some(self.renderer.sources_reference(&self.look.view, sources, progress))
    }

    /// `spp` light paths per pixel with up to `bounces` bounces.
    pub fn light_paths(&self, spp: u32, bounces: u32, progress: &dyn Progress) -> LightPaths {
        let settings = PathSettings { bounces, components: INDIRECT, ..PathSettings::direct(spp) };
        let Look { view, illumination, lights, .. } = &self.look;
        self.renderer.path_picture(view, illumination, lights, settings, progress).into()
    }
}
