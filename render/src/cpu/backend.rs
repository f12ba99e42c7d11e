//! The renderer of the interactive view on the cores of this machine: [`Renderer`] in steps that can be stopped between.

use crate::{
    appearance::Appearance,
    backend::{Backend, BackendError, PictureStats},
    baked::Baked,
    cpu::picture::Picture,
    light::{
        components::Bounces,
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
    stale::{DirectStep, Part, Pixels, Stale, SummedLights},
    view::View,
    view_mode::ViewMode,
};
use lapidary_core::{image::Image, lights::Light};
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
    /// The local lights in its sums.
    lights: SummedLights,
    /// Samples that all pixels have of every part.
    complete: u32,
}

impl Begun {
    /// Whether an edit leaves nothing of the picture. The other modes do not show the parts of the light one by one.
    fn is_lost(&self, stale: &Stale) -> bool {
        self.view.mode != ViewMode::Shaded && stale.any()
    }

    /// Drops what edits have changed.
    fn forget(&mut self, stale: &Stale, step: DirectStep) {
        let picture = &mut self.picture;
        if step == DirectStep::MergeAndAdd {
            picture.merge_added();
        }
        for part in Part::ALL {
            picture.forget(part, stale.pixels(part).and(Pixels::all_if(step.forgets(part))));
        }
    }
}

impl CpuBackend {
    /// Without a scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// The light of a picture that sums these local lights.
    fn light<'a>(&'a self, lights: &'a SummedLights) -> PictureLight<'a> {
        let intersector = self.renderer.as_ref().map(|renderer| &*renderer.intersector);
        let shown = |lights: &'a Vec<Light>| Some(&**lights).filter(|lights| !lights.is_empty()).zip(intersector);
        PictureLight {
            environment: self.shown_environment().map(|(_, lighting)| &**lighting),
            sources: self.local.shown_indirect().map(|lighting| &**lighting),
            vertex_irradiance: self.local.shown_vertex_irradiance().map(|vertices| &**vertices),
            local: shown(&lights.direct),
            added: shown(&lights.added),
        }
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
        Ok(())
    }

    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError> {
        let Some(renderer) = &mut self.renderer else { return Ok(Vec::new()) };
        let (fitted, remarks) = appearance.fitted(&renderer.dataset.scene.materials);
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
        self.begun = None;
        self.resume(view, sampling, &Stale::ALL)
    }

    fn resume(&mut self, view: &View, sampling: BrdfSampling, stale: &Stale) -> Result<(), BackendError> {
        let keeps = |begun: &Begun| (&begun.view, begun.sampling) == (view, sampling) && !begun.is_lost(stale);
        let kept = self.begun.take().filter(keeps);
        let light = self.shown_environment().map(|(light, _)| light.clone());
        let backdrop = light.map_or_else(|| Backdrop::unlit(view), |light| Backdrop::new(view, &light, &mut self.blur));
        let mut lights = kept.as_ref().map(|begun| begun.lights.clone()).unwrap_or_default();
        let complete = kept.as_ref().is_some_and(|begun| begun.complete >= view.aa.max(1));
        let step = lights.update(self.local.shown_lights().unwrap_or_default(), complete);
        let parts = self.light(&lights).parts(view.mode);
        let picture = match kept {
            None => Picture::new(view.size, parts),
            Some(mut begun) => {
                begun.forget(stale, step);
                begun.picture.resume(parts);
                begun.picture
            }
        };
        self.begun = Some(Begun { view: view.clone(), sampling, backdrop, picture, lights, complete: 0 });
        Ok(())
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        let Some(mut begun) = self.begun.take() else { return Ok(()) };
        if let Some(renderer) = &self.renderer {
            let Begun { view, sampling, backdrop, picture, lights, complete } = &mut begun;
            let light = self.light(lights);
            let painter = || Painter::new(view.mode, &renderer.dataset, light, *sampling);
            // Without bounces no edit changes the light of other surfaces.
            let patches = Bounces::of(&renderer.dataset).any().then(|| renderer.patches());
            let sampler = PixelSampler::new(renderer, view, backdrop);
            if rows.end >= view.size[1] {
                *complete = sample + 1;
            }
            picture.add_rows(&sampler, painter, patches.as_deref(), sample, rows);
        }
        self.begun = Some(begun);
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
