//! A whole picture at once: camera rays, surface points, and the merge at every pixel.

use crate::{
    backend::PictureStats,
    cpu::picture::Picture,
    light::environment::{Illumination, SceneLighting},
    renderer::Renderer,
    shade::{
        background::{Backdrop, BlurCache},
        merge::BrdfSampling,
        painter::{Painter, PictureLight},
        pixel_sampler::PixelSampler,
    },
    view::View,
};
use lapidary_core::image::Image;
use serde::Serialize;
use std::time::Instant;

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

impl From<&RenderStats> for PictureStats {
    fn from(stats: &RenderStats) -> Self {
        let &RenderStats { pixels_shaded, mean_merged_nodes, mean_brdf_evaluations, .. } = stats;
        Self { pixels_shaded, mean_merged_nodes, mean_brdf_evaluations }
    }
}

impl Renderer {
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
        let sampler = PixelSampler::new(self, view, &backdrop);
        let light = PictureLight { environment: Some(lighting), ..Default::default() };
        let painter = || Painter::new(view.mode, &self.dataset, light, sampling);
        let mut picture = Picture::new(view.size);
        for sample in 0..view.aa.max(1) {
            picture.add_rows(&sampler, painter, sample, 0..view.size[1]);
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
}
