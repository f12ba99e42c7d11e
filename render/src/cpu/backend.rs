//! The renderer of the interactive view on the cores of this machine: [`Renderer`] in steps that can be stopped between.

use crate::{
    appearance::Appearance,
    backend::{Backend, BackendError, PictureStats},
    baked::Baked,
    cpu::{picture::Picture, sketch::Sketch},
    light::{
        environment::{Illumination, SceneLighting},
        local::LocalLighting,
    },
    post::Post,
    renderer::Renderer,
    shade::{
        background::{Backdrop, BlurCache},
        merge::BrdfSampling,
        painter::{Painter, PictureLight},
        pixel_sampler::PixelSampler,
    },
    view::View,
};
use lapidary_core::{dataset::Dataset, image::Image, lights::Light};
use std::{ops::Range, sync::Arc};

/// Name of the renderer on the cores.
pub const CPU: &str = "cpu";

/// Shadow rays per pixel beyond which it is said that they take long.
const MANY_RAYS: u32 = 256;

/// Renders on all cores. Never fails.
#[derive(Default)]
pub struct CpuBackend {
    renderer: Option<Renderer>,
    light: Option<(Illumination, Arc<SceneLighting>)>,
    local: LocalLighting,
    /// The last remark on too many lights.
    remark: Option<String>,
    blur: BlurCache,
    sketch: Sketch,
    begun: Option<Begun>,
}

/// Remark on lights that make pictures slow.
fn remark_on_rays(lights: &[Light]) -> Option<String> {
    let shining: Vec<&Light> = lights.iter().filter(|light| light.shines()).collect();
    let rays: u32 = shining.iter().map(|light| light.samples_wanted()).sum();
    (rays > MANY_RAYS).then(|| {
        format!(
            "{} local lights take up to {rays} shadow rays per pixel, which is slow on the CPU; switch some off",
            shining.len()
        )
    })
}

/// The picture that was begun.
struct Begun {
    view: View,
    sampling: BrdfSampling,
    backdrop: Backdrop,
    picture: Picture,
}

/// A picture with what samples and paints its pixels.
struct AtWork<'a> {
    picture: &'a mut Picture,
    sketch: &'a mut Sketch,
    sampler: PixelSampler<'a>,
    light: PictureLight<'a>,
    dataset: &'a Dataset,
    sampling: BrdfSampling,
}

impl<'a> AtWork<'a> {
    /// Makes a painter for a thread.
    fn painter(&self) -> impl Fn() -> Painter<'a> + Sync + Send + use<'a> {
        let (mode, dataset, light, sampling) = (self.sampler.view.mode, self.dataset, self.light, self.sampling);
        move || Painter::new(mode, dataset, light, sampling)
    }
}

impl CpuBackend {
    /// Without a scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// The picture that was begun, with what samples and paints its pixels.
    fn at_work(&mut self) -> Option<AtWork<'_>> {
        let (renderer, Begun { view, sampling, backdrop, picture }) = (self.renderer.as_ref()?, self.begun.as_mut()?);
        let environment = self.light.as_ref().filter(|_| self.local.components.environment);
        let light = PictureLight {
            environment: environment.map(|(_, lighting)| &**lighting),
            sources: self.local.shown_indirect().map(|lighting| &**lighting),
            vertex_irradiance: self.local.shown_vertex_irradiance().map(|vertices| &**vertices),
            local: self.local.shown_lights().map(|lights| (lights, &*renderer.intersector)),
        };
        let (sampler, sketch) = (PixelSampler::new(renderer, view, backdrop), &mut self.sketch);
        Some(AtWork { picture, sketch, sampler, light, dataset: &renderer.dataset, sampling: *sampling })
    }

    /// The environment if it is shown.
    fn shown_environment(&self) -> Option<&(Illumination, Arc<SceneLighting>)> {
        self.light.as_ref().filter(|_| self.local.components.environment)
    }
}

impl Backend for CpuBackend {
    fn name(&self) -> String {
        CPU.into()
    }

    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError> {
        self.renderer = Some(Renderer::new(baked.clone()));
        (self.light, self.begun, self.local) = (None, None, LocalLighting::default());
        self.remark = None;
        self.sketch.forget();
        Ok(())
    }

    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError> {
        let Some(renderer) = &mut self.renderer else { return Ok(Vec::new()) };
        let (fitted, remarks) = appearance.fitted(&renderer.dataset.scene.materials);
        self.sketch.set_appearance(&renderer.appearance, &fitted);
        renderer.set_appearance(fitted);
        Ok(remarks)
    }

    fn set_light(&mut self, light: &Illumination, lighting: &Arc<SceneLighting>) -> Result<Vec<String>, BackendError> {
        self.light = Some((light.clone(), lighting.clone()));
        Ok(Vec::new())
    }

    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError> {
        self.local = lighting.clone();
        let remark = self.local.shown_lights().and_then(remark_on_rays);
        let before = std::mem::replace(&mut self.remark, remark.clone());
        Ok(remark.filter(|_| before != self.remark).into_iter().collect())
    }

    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        let light = self.shown_environment().map(|(light, _)| light.clone());
        let backdrop = light.map_or_else(|| Backdrop::unlit(view), |light| Backdrop::new(view, &light, &mut self.blur));
        self.begun = Some(Begun { view: view.clone(), sampling, backdrop, picture: Picture::new(view) });
        self.sketch.begin(&view.camera, view.size);
        Ok(())
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        let Some(work) = self.at_work() else { return Ok(()) };
        let painter = work.painter();
        work.picture.add_rows(&work.sampler, painter, sample, rows);
        Ok(())
    }

    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError> {
        let Some(work) = self.at_work() else { return Ok(()) };
        let painter = work.painter();
        work.sketch.add_tiles(work.picture, &work.sampler, painter, stride, tiles);
        Ok(())
    }

    fn fill(&mut self, most_shaded: u32) -> Result<(), BackendError> {
        let Some(work) = self.at_work() else { return Ok(()) };
        let painter = work.painter();
        work.sketch.fill(work.picture, &work.sampler, painter, most_shaded as usize);
        Ok(())
    }

    fn display(&mut self, post: &Post, _samples: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        let Some(Begun { view, picture, .. }) = &self.begun else { return Ok(Vec::new()) };
        let illum_cut = self.light.as_ref().map_or(0, |(_, lighting)| lighting.max_nodes);
        Ok(picture.display(view, post, view.mode.count_top(illum_cut)))
    }

    fn read(&mut self, _samples: u32) -> Result<(Image, Vec<f32>), BackendError> {
        let nothing = || (Image { size: [0, 0], pixels: Vec::new() }, Vec::new());
        Ok(self.begun.as_ref().map_or_else(nothing, |begun| begun.picture.read()))
    }

    fn stats(&mut self) -> Result<PictureStats, BackendError> {
        Ok(self.begun.as_ref().map_or_else(PictureStats::default, |begun| begun.picture.stats()))
    }
}

#[cfg(test)]
mod tests;
