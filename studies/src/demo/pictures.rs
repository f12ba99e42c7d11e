//! Pictures of the still life: from a look to files and figures.

use crate::{args::DeviceArgs, bundled::Environments, export::settings};
use anyhow::Result;
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_interchange::image;
use lapidary_render::{FinishedPicture, Illumination, LitScene, Look, RenderStats, Renderer, View};
use serde::Serialize;
use serde_json::{Map, Value};
use std::{path::Path, sync::Arc};

/// Names of the pictures' files without their extensions.
pub const NAMES: [&str; 9] = [
    "hero",
    "environment-*",
    "rotation-*",
    "material-*",
    "cut-*",
    "reference-samples",
    "reference-path",
    "detail-once",
    "detail-refine",
];

/// A rendered picture.
#[derive(Clone, Debug, Serialize)]
pub struct Picture {
    /// Short description.
    pub title: String,
    /// File in the report's folder, as displayed.
    pub png: String,
    /// File in the report's folder, scene-linear.
    pub exr: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Other settings of the picture.
    pub settings: Map<String, Value>,
    /// The complete look.
    #[serde(skip)]
    pub look: Look,
    /// Render statistics; `None` for references.
    pub stats: Option<RenderStats>,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// The baked still life on a renderer, with environments and an output folder.
pub struct StillLife<'a> {
    pub scene: LitScene,
    environments: &'a Environments,
    pub out: &'a Path,
}

impl<'a> StillLife<'a> {
    /// Gives the dataset to the renderer on the CPU.
    ///
    /// # Errors
    /// None on this machine's cores.
    pub fn new(dataset: &Arc<Dataset>, environments: &'a Environments, out: &'a Path) -> Result<Self> {
        let scene = LitScene::new(DeviceArgs::CPU.open()?, dataset.clone().into())?;
        Ok(Self { scene, environments, out })
    }

    fn dataset(&self) -> &Dataset {
        &self.scene.baked().dataset
    }

    /// The scene as baked, seen by one of its cameras under one of the environments.
    pub fn look(&self, camera: &str, environment: &str, size: [u32; 2]) -> Look {
        let scene = &self.dataset().scene;
        let camera = scene.cameras.iter().find(|c| c.name == camera);
        let camera = camera.expect("pictures are planned with the cameras of the still life").clone();
        let environment = self.environments.get(environment).clone().into();
        Look::under_environment(
            scene,
            View::new(camera, size),
            Illumination { environment, rotation: 0.0, intensity: 1.0, sun: None },
        )
    }

    /// A ray tracer for a look.
    pub fn renderer(&self, look: &Look) -> Renderer {
        look.renderer(self.scene.baked())
    }

    /// Renders with cuts and writes the files.
    ///
    /// # Errors
    /// An unwritable folder.
    pub fn render(&mut self, name: &str, title: &str, look: &Look) -> Result<(Picture, Image)> {
        // Times of pictures under the same light are compared, so each picture computes its light.
        self.scene.forget_light();
        let FinishedPicture { image, stats, .. } = self.scene.show_whole(look)?;
        let picture = self.keep(name, title, look, &image, stats.seconds)?;
        Ok((Picture { stats: Some(stats), ..picture }, image))
    }

    /// Writes the files of a picture that took `seconds`.
    ///
    /// # Errors
    /// An unwritable folder.
    pub fn keep(&self, name: &str, title: &str, look: &Look, image: &Image, seconds: f64) -> Result<Picture> {
        let [png, exr] = ["png", "exr"].map(|extension| format!("{name}.{extension}"));
        image::write(image, &self.out.join(&png))?;
        image::write(image, &self.out.join(&exr))?;
        let (size, settings) = (look.view.size, settings(look, self.dataset()));
        Ok(Picture { title: title.into(), png, exr, size, settings, look: look.clone(), stats: None, seconds })
    }
}
