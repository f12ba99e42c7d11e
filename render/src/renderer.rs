//! The CPU renderer: camera rays, surface points, and the merge at every pixel.

use crate::{
    appearance::Appearance,
    backend::PictureStats,
    background::{Backdrop, BlurCache},
    baked::Baked,
    frame::Frame,
    lighting::{LightRig, SceneLighting},
    painter::{Painter, PictureLight},
    picture::Picture,
    surface::Surfaces,
    view::View,
};
use lapidary_core::{dataset::Dataset, environment::Environment, image::Image, ray::Intersector};
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
    /// Distance in metres that shadow rays start off a surface, at most.
    largest_offset: f32,
    /// Made at the first use: the references by paths do without.
    rig: OnceLock<Mutex<LightRig>>,
}

impl Renderer {
    /// Builds what rays need, unless that has been done; seconds for a million triangles. The scene looks as the
    /// dataset has it.
    pub fn new(baked: impl Into<Baked>) -> Self {
        let baked = baked.into();
        let intersector = baked.intersector();
        let dataset = baked.dataset;
        let appearance = Appearance::of(&dataset.scene);
        let largest_offset = 2e-4 * dataset.scene.mesh.bounds().diagonal();
        Self { dataset, appearance, intersector, largest_offset, rig: OnceLock::new() }
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

    /// Looks up points of the scene as it looks now.
    pub(crate) fn surfaces(&self) -> Surfaces<'_> {
        Surfaces::new(&self.dataset, &self.appearance, &self.intersector, self.largest_offset)
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
        let backdrop = Backdrop::new(view, light, &mut BlurCache::default());
        let frame = Frame::new(self, view, &backdrop);
        let light = PictureLight { environment: Some(lighting), ..Default::default() };
        let painter = || Painter::new(view.mode, &self.dataset, light, sampling);
        let mut picture = Picture::new(view.size);
        for sample in 0..view.aa.max(1) {
            picture.add_rows(&frame, painter, sample, 0..view.size[1]);
        }
        let PictureStats { pixels_shaded, mean_merged_nodes, mean_brdf_evaluations } = picture.stats();
        let seconds = start.elapsed().as_secs_f64();
        let stats = RenderStats {
            backend: "cpu".into(),
            adapter: None,
            seconds,
            pixels_shaded,
            mean_merged_nodes,
            mean_brdf_evaluations,
        };
        (picture.read().0, stats)
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

#[cfg(test)]
pub(crate) mod tests;
