//! How far each solution of bounced light is from light paths.

pub mod light_paths;

use anyhow::Result;
use lapidary_core::image::Image;
use lapidary_render::{
    Baked, Components, CpuBackend, FinishedPicture, LitScene, Look, PathSettings, Progress, Renderer, Solution,
};
use light_paths::LightPaths;

/// Bounced light only: of what else is in a picture, other figures tell.
const INDIRECT: Components = Components { indirect: true, ..Components::NONE };

/// The bounced light of a scene, by one solution after another and by what they are held against.
pub struct BouncedLight {
    look: Look,
    scene: LitScene<CpuBackend>,
    /// Traces rays on the scene.
    pub renderer: Renderer,
}

impl BouncedLight {
    /// That of a look, whatever its components and solution.
    ///
    /// # Errors
    /// None on this machine's cores.
    pub fn new(baked: Baked, look: Look) -> Result<Self> {
        let renderer = look.renderer(&baked);
        let scene = LitScene::new(Box::new(CpuBackend::new()), baked)?;
        Ok(Self { look: Look { components: INDIRECT, ..look }, scene, renderer })
    }

    /// The picture by a solution. Its seconds are those of the picture alone, without its light.
    ///
    /// # Errors
    /// None on this machine's cores.
    pub fn picture(&mut self, solution: Solution) -> Result<FinishedPicture> {
        let look = Look { solution, ..self.look.clone() };
        // Light that is there already takes no part of the picture's time.
        self.scene.light(&look)?;
        Ok(self.scene.show_whole(&look)?)
    }

    /// The same light as in the last picture with a ray from every pixel to every source in place of the cuts, if it has sources.
    pub fn every_source(&self, progress: &dyn Progress) -> Option<Image> {
        let sources = self.scene.local().and_then(|local| local.sources())?;
        Some(self.renderer.sources_reference(&self.look.view, sources, progress))
    }

    /// `spp` light paths per pixel that are followed for a number of bounces.
    pub fn light_paths(&self, spp: u32, bounces: u32, progress: &dyn Progress) -> LightPaths {
        let settings = PathSettings { bounces, components: INDIRECT, ..PathSettings::direct(spp) };
        let Look { view, illumination, lights, .. } = &self.look;
        self.renderer.path_picture(view, illumination, lights, settings, progress).into()
    }
}
