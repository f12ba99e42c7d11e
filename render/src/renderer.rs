//! The CPU renderer: camera rays, surface points, and the merge at every pixel.

use crate::{
    appearance::Appearance,
    background::{Backdrop, Sky},
    lighting::{LightRig, SceneLighting},
    shade::{Shader, Work},
    surface::{Seen, Surfaces},
    view::View,
};
use glam::{Vec2, Vec3};
use lapidary_core::{dataset::Dataset, environment::Environment, image::Image, ray::Intersector};
use rayon::prelude::*;
use serde::Serialize;
use std::{
    sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError},
    time::Instant,
};

pub use crate::shade::BrdfSampling;

/// A distant light.
#[derive(Clone, Debug)]
pub struct Illumination {
    /// The map.
    pub environment: Arc<Environment>,
    /// Turn of the map in radians, counter-clockwise seen from +Y.
    pub rotation: f32,
    /// Scales radiance.
    pub intensity: f32,
}

/// How a picture was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RenderStats {
    /// `cpu` or `gpu`.
    pub backend: String,
    /// Name of the graphics adapter.
    pub adapter: Option<String>,
    /// Wall-clock seconds for light, illumination cut and pixels.
    pub seconds: f64,
    /// Samples of pixels that show a surface.
    pub pixels_shaded: u64,
    /// Nodes of the merged cut, averaged over them.
    pub mean_merged_nodes: f64,
    /// BRDF evaluations, averaged over them.
    pub mean_brdf_evaluations: f64,
}

/// A dataset ready to be rendered.
pub struct Renderer {
    pub(crate) dataset: Arc<Dataset>,
    pub(crate) appearance: Appearance,
    pub(crate) intersector: Arc<Intersector>,
    /// Made at the first use: the references by paths do without.
    rig: OnceLock<Mutex<LightRig>>,
}

impl Renderer {
    /// Builds what rays need; seconds for a million triangles. The scene looks as the dataset has it.
    pub fn new(dataset: impl Into<Arc<Dataset>>) -> Self {
        let dataset = dataset.into();
        let intersector = Arc::new(Intersector::new(&dataset.scene.mesh));
        let appearance = Appearance::of(&dataset.scene);
        Self { dataset, appearance, intersector, rig: OnceLock::new() }
    }

    /// Gives the scene other materials; there must be as many.
    pub fn set_appearance(&mut self, appearance: Appearance) {
        assert_eq!(
            appearance.materials.len(),
            self.appearance.materials.len(),
            "one material for each index of the mesh"
        );
        self.appearance = appearance;
    }

    /// The dataset.
    pub fn dataset(&self) -> &Arc<Dataset> {
        &self.dataset
    }

    /// Casts rays on the mesh.
    pub fn intersector(&self) -> &Arc<Intersector> {
        &self.intersector
    }

    /// Renders with cuts, the illumination cut of at most `illum_cut` nodes.
    pub fn render(
        &self,
        view: &View,
        light: &Illumination,
        illum_cut: u32,
        sampling: BrdfSampling,
    ) -> (Image, RenderStats) {
        drop(self.rig());
        let start = Instant::now();
        let lighting = self.lighting(light, illum_cut);
        let (image, stats) = self.render_lit(view, light, &lighting, sampling);
        (image, RenderStats { seconds: start.elapsed().as_secs_f64(), ..stats })
    }

    /// Renders under a light that was prepared: `light` is only seen directly.
    pub fn render_lit(
        &self,
        view: &View,
        light: &Illumination,
        lighting: &SceneLighting,
        sampling: BrdfSampling,
    ) -> (Image, RenderStats) {
        let start = Instant::now();
        let cuts = &self.dataset.cuts;
        let height = self.dataset.tree.height();
        let frame = Frame::new(self, view, light);
        let shader = || (Shader::new(lighting, cuts, height, sampling), 0_u64);
        let rows = (0..view.size[1]).into_par_iter().map_init(shader, |(shader, _), y| {
            shader.work = Work::default();
            let mut shaded = 0;
            let row: Vec<Vec3> = (0..view.size[0])
                .map(|x| {
                    frame.pixel(x, y, |point| {
                        shaded += 1;
                        shader.shade(point)
                    })
                })
                .collect();
            (row, shader.work, shaded)
        });
        let rows: Vec<(Vec<Vec3>, Work, u64)> = rows.collect();
        let stats = stats(&rows, start.elapsed().as_secs_f64());
        let pixels = rows.into_iter().flat_map(|(row, _, _)| row).collect();
        (Image { size: view.size, pixels }, stats)
    }

    /// The tree under `light`, with an illumination cut of at most `illum_cut` nodes. A turned or scaled environment
    /// takes milliseconds, another one some more.
    pub fn lighting(&self, light: &Illumination, illum_cut: u32) -> SceneLighting {
        self.rig().lighting(light, illum_cut)
    }

    fn rig(&self) -> MutexGuard<'_, LightRig> {
        let rig = self.rig.get_or_init(|| Mutex::new(LightRig::new(&self.dataset.tree)));
        rig.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn stats(rows: &[(Vec<Vec3>, Work, u64)], seconds: f64) -> RenderStats {
    let pixels_shaded: u64 = rows.iter().map(|r| r.2).sum();
    let mean = |sum: u64| sum as f64 / pixels_shaded.max(1) as f64;
    RenderStats {
        backend: "cpu".into(),
        adapter: None,
        seconds,
        pixels_shaded,
        mean_merged_nodes: mean(rows.iter().map(|r| r.1.merged_nodes).sum()),
        mean_brdf_evaluations: mean(rows.iter().map(|r| r.1.brdf_evaluations).sum()),
    }
}

/// Pixel sampling that all renderers share.
pub(crate) struct Frame<'a> {
    view: &'a View,
    sky: Sky<'a>,
    backdrop: Backdrop<'a>,
    surfaces: Surfaces<'a>,
    offsets: Vec<Vec2>,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(renderer: &'a Renderer, view: &'a View, light: &'a Illumination) -> Self {
        let surfaces = Surfaces::new(&renderer.dataset, &renderer.appearance, &renderer.intersector);
        Self {
            view,
            sky: Sky::new(light),
            backdrop: Backdrop::new(view.background, light),
            surfaces,
            offsets: view.pixel_offsets(),
        }
    }

    /// The mean over the pixel's samples of `shade`, or of what is seen where there is no surface.
    pub(crate) fn pixel(&self, x: u32, y: u32, mut shade: impl FnMut(&crate::surface::SurfacePoint) -> Vec3) -> Vec3 {
        let sum: Vec3 = (0..self.offsets.len()).map(|i| self.sample(x, y, i, &mut shade)).sum();
        sum / self.offsets.len() as f32
    }

    /// One of the pixel's samples.
    pub(crate) fn sample(
        &self,
        x: u32,
        y: u32,
        sample: usize,
        mut shade: impl FnMut(&crate::surface::SurfacePoint) -> Vec3,
    ) -> Vec3 {
        let camera = &self.view.camera;
        let pixel = Vec2::new(x as f32, y as f32) + self.offsets[sample % self.offsets.len()];
        let direction = camera.direction_through(pixel, self.view.size);
        match self.surfaces.seen_along(camera.eye, direction) {
            Seen::Surface(point) => shade(&point),
            Seen::Back => Vec3::ZERO,
            Seen::Background => self.backdrop.radiance(direction),
        }
    }

    pub(crate) fn sky(&self) -> &Sky<'a> {
        &self.sky
    }
}

#[cfg(test)]
pub(crate) mod tests;
