//! Direct light of local lights by shadow rays at every pixel, without cuts.

use crate::{
    light::environment::Illumination,
    renderer::Renderer,
    shade::{
        background::{Backdrop, BlurCache},
        direct::{DirectLights, pixel_shift},
        pixel_sampler::PixelSampler,
        surface::SurfacePoint,
    },
    view::View,
};
use glam::Vec3;
use lapidary_core::{image::Image, lights::Light};
use rayon::prelude::*;

impl Renderer {
    /// Direct light of local lights alone, on black; black outside the view's region.
    pub fn direct_light(&self, view: &View, lights: &[Light]) -> Image {
        self.direct_light_before(None, view, lights)
    }

    /// [`Self::direct_light`] on a ground that catches an environment.
    pub(super) fn direct_light_before(&self, behind: Option<&Illumination>, view: &View, lights: &[Light]) -> Image {
        let view = &View { hides_background: true, ..view.clone() };
        let backdrop = Backdrop::new(view, behind, false, &mut BlurCache::default());
        let sampler = PixelSampler::new(self, view, &backdrop);
        let lights = DirectLights { lights, intersector: self.intersector() }.shader();
        let samples = view.aa.max(1);
        let pixel = |x: u32, y: u32| {
            let one = |i: u32| {
                let shade = |p: &SurfacePoint| lights.reflected(p, pixel_shift(x, y, i));
                sampler.sample(x, y, i as usize, shade)
            };
            (0..samples).map(one).sum::<Vec3>() / samples as f32
        };
        let [width, height] = view.size;
        let rows = (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| (x, y)));
        let in_region = |x, y| if sampler.columns(y).contains(&x) { pixel(x, y) } else { Vec3::ZERO };
        Image { size: view.size, pixels: rows.map(|(x, y)| in_region(x, y)).collect() }
    }
}
