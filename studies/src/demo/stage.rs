//! Taking pictures of a dataset: settings in, files and figures out.

use super::data::Environments;
use anyhow::Result;
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_render::{BrdfSampling, Illumination, RenderStats, Renderer, View};
use serde::Serialize;
use std::{path::Path, sync::Arc};

/// What decides a picture.
#[derive(Clone, Debug, Serialize)]
pub struct PictureSettings {
    /// Name of the camera.
    pub camera: &'static str,
    /// Vertical field of view, if not that of the camera.
    pub fov_degrees: Option<f32>,
    /// Name of the environment.
    pub environment: String,
    /// Turn of the environment.
    pub rotation_degrees: f32,
    /// Most nodes of the illumination cut.
    pub illum_cut: u32,
    /// Whether the BRDF is refined during the merge, or sampled once a node.
    pub refine: bool,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub aa: u32,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            camera: "main",
            fov_degrees: None,
            environment: "sun-and-sky".into(),
            rotation_degrees: 0.0,
            illum_cut: 256,
            refine: true,
            size: [400, 300],
            aa: 2,
        }
    }
}

/// A picture that was taken.
#[derive(Clone, Debug, Serialize)]
pub struct Picture {
    /// What it shows, in a few words.
    pub title: String,
    /// File in the report's folder, as displayed.
    pub png: String,
    /// File in the report's folder, scene-linear.
    pub exr: String,
    /// What decided it.
    pub settings: PictureSettings,
    /// How it was made; nothing for references.
    pub stats: Option<RenderStats>,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// A dataset, lights and a folder for pictures.
pub struct Stage<'a> {
    pub renderer: Renderer,
    pub environments: &'a Environments,
    pub out: &'a Path,
}

impl<'a> Stage<'a> {
    pub fn new(dataset: &Arc<Dataset>, environments: &'a Environments, out: &'a Path) -> Self {
        Self { renderer: Renderer::new(dataset.clone()), environments, out }
    }

    pub fn view(&self, settings: &PictureSettings) -> View {
        let camera = self.renderer.dataset().scene.cameras.iter().find(|c| c.name == settings.camera);
        let mut camera = camera.expect("pictures are planned with the cameras of the still life").clone();
        camera.fov_y = settings.fov_degrees.map_or(camera.fov_y, f32::to_radians);
        View { aa: settings.aa, ..View::new(camera, settings.size) }
    }

    pub fn light(&self, settings: &PictureSettings) -> Illumination {
        Illumination {
            environment: self.environments.get(&settings.environment).clone().into(),
            rotation: settings.rotation_degrees.to_radians(),
            intensity: 1.0,
        }
    }

    /// Renders with cuts and writes the files.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn render(&self, name: &str, title: &str, settings: PictureSettings) -> Result<(Picture, Image)> {
        let sampling = if settings.refine { BrdfSampling::Refine } else { BrdfSampling::Once };
        let (view, light) = (self.view(&settings), self.light(&settings));
        let (image, stats) = self.renderer.render(&view, &light, settings.illum_cut, sampling);
        let seconds = stats.seconds;
        let picture = self.keep(name, title, settings, &image, seconds)?;
        Ok((Picture { stats: Some(stats), ..picture }, image))
    }

    /// Writes the files of a picture that took `seconds`.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn keep(
        &self,
        name: &str,
        title: &str,
        settings: PictureSettings,
        image: &Image,
        seconds: f64,
    ) -> Result<Picture> {
        let [png, exr] = ["png", "exr"].map(|extension| format!("{name}.{extension}"));
        image.write(&self.out.join(&png))?;
        image.write(&self.out.join(&exr))?;
        Ok(Picture { title: title.into(), png, exr, settings, stats: None, seconds })
    }
}
