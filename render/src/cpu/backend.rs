//! The interactive renderer on this machine's cores: [`Renderer`] in interruptible steps.

use crate::{
    appearance::Appearance,
    backend::{Backend, PictureStats},
    baked::Baked,
    cpu::{
        picture::Picture,
        sketch::{Moved, Sketch},
    },
    device::DeviceCuts,
    error::BackendError,
    light::{
        environment::{EnvironmentLight, Illumination},
        implicit::PosedLighting,
        local::LocalLighting,
    },
    post::Post,
    renderer::Renderer,
    sampling::BrdfSampling,
    shade::{
        background::{Backdrop, BlurCache},
        direct::DirectLights,
        painter::{Painter, PictureLight},
        pixel_sampler::PixelSampler,
        seen_scene::SeenScene,
    },
    stale::{LightPart, Marks, Stale},
    summed::{DirectStep, Summed, SummedLights},
    view::View,
};
use lapidary_core::{dataset::Dataset, image::Image, lights::Light};
use std::{ops::Range, sync::Arc};

/// Name of the CPU renderer.
pub const CPU: &str = "cpu";

/// Shadow rays per pixel above which a remark warns of slow rendering.
const MANY_RAYS: u32 = 256;

/// Renders on all cores. Never fails.
#[derive(Default)]
pub struct CpuBackend {
    renderer: Option<Renderer>,
    /// The environment, for the cuts of the posed scene.
    light: Option<(Illumination, Arc<EnvironmentLight>)>,
    /// Its light as it was set.
    set_light: Option<Arc<EnvironmentLight>>,
    local: LocalLighting,
    /// The last remark about too many lights.
    remark: Option<String>,
    blur: BlurCache,
    pub(super) sketch: Sketch,
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

/// The current picture.
struct Begun {
    summed: Summed,
    backdrop: Backdrop,
    picture: Picture,
}

impl Begun {
    /// Drops results that edits made stale.
    fn forget(&mut self, stale: &Stale, step: DirectStep, mirrors: Marks) {
        let picture = &mut self.picture;
        if step == DirectStep::MergeAndAdd {
            picture.merge_added();
        }
        LightPart::ALL.into_iter().for_each(|part| picture.forget(part, step.forgets(stale, part, mirrors)));
    }
}

/// Lighting of a picture with these local lights.
fn light_of<'a>(
    renderer: Option<&'a Renderer>,
    environment: Option<&'a (Illumination, Arc<EnvironmentLight>)>,
    local: &'a LocalLighting,
    lights: &'a SummedLights,
    mirrored: Option<SeenScene<'a>>,
) -> PictureLight<'a> {
    let shown = |lights: &'a Vec<Light>| {
        let intersector = renderer.filter(|_| !lights.is_empty())?.intersector();
        Some(DirectLights { lights, intersector })
    };
    let posed = local.posed.as_deref().map(PosedLighting::known);
    PictureLight {
        environment: environment.map(|(_, lighting)| &***lighting),
        emission: local.components.direct,
        bounce: local.shown_bounce(),
        posed,
        posed_bounce: posed.filter(|_| local.components.indirect),
        local: shown(&lights.direct),
        added: shown(&lights.added),
        mirrored,
    }
}

/// A picture with its sampler and painter.
struct AtWork<'a> {
    picture: &'a mut Picture,
    sketch: &'a mut Sketch,
    sampler: PixelSampler<'a>,
    patches: Option<Arc<[u8]>>,
    /// Samples that all pixels have of every part.
    complete: &'a mut u32,
    light: PictureLight<'a>,
    dataset: &'a Dataset,
    sampling: BrdfSampling,
}

impl<'a> AtWork<'a> {
    /// Makes a painter for a thread.
    fn painter(&self) -> impl Fn() -> Painter<'a> + Sync + Send + use<'a> {
        let (view, dataset, light, sampling) = (self.sampler.view, self.dataset, self.light, self.sampling);
        move || Painter::new(view, dataset, light, sampling)
    }
}

impl CpuBackend {
    /// Creates a backend without a scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets the local lights and the picture.
    fn forget_local_light(&mut self) {
        (self.begun, self.local, self.remark) = (None, LocalLighting::default(), None);
    }

    /// Takes the environment's light as it was set, for cuts of which a pose replaced some.
    fn show_light(&mut self) {
        let (Some((_, shown)), Some(set)) = (&mut self.light, &self.set_light) else { return };
        let cuts = self.renderer.as_ref().map(|renderer| &renderer.dataset.cuts).filter(|cuts| cuts.has_replaced());
        *shown = cuts.map_or_else(|| set.clone(), |cuts| set.with_replaced_cuts(cuts).into());
    }

    /// The current picture with its sampler and painter.
    fn at_work(&mut self) -> Option<AtWork<'_>> {
        let (renderer, begun) = (self.renderer.as_ref()?, self.begun.as_mut()?);
        let Begun { summed: Summed { view, sampling, lights, complete }, backdrop, picture } = begun;
        let environment = self.light.as_ref().filter(|_| self.local.components.environment);
        let mirrored = SeenScene::in_mirrors(renderer, view, *sampling, backdrop);
        let light = light_of(Some(renderer), environment, &self.local, lights, mirrored);
        let sampler = PixelSampler::new(renderer, view, backdrop);
        // Without bounces no edit changes the light of other surfaces.
        let patches = renderer.dataset.has_bounces().then(|| renderer.patches());
        let (sketch, dataset, sampling) = (&mut self.sketch, &renderer.dataset, *sampling);
        Some(AtWork { picture, sketch, sampler, patches, complete, light, dataset, sampling })
    }

    /// The environment, if shown.
    fn shown_environment(&self) -> Option<&(Illumination, Arc<EnvironmentLight>)> {
        self.light.as_ref().filter(|_| self.local.components.environment)
    }
}

impl Backend for CpuBackend {
    fn name(&self) -> String {
        CPU.into()
    }

    fn set_scene(&mut self, baked: &Baked) -> Result<(), BackendError> {
        self.renderer = Some(Renderer::new(baked.clone()));
        (self.light, self.set_light) = (None, None);
        self.forget_local_light();
        self.sketch.forget();
        Ok(())
    }

    fn pose(&mut self, posed: &Baked, _: Option<&DeviceCuts>) -> Result<(), BackendError> {
        if let Some(renderer) = self.renderer.take() {
            self.sketch.pose(&Moved::between(&renderer.dataset.scene.mesh, &posed.dataset.scene.mesh));
            self.renderer = Some(renderer.posed(posed.clone()));
        }
        self.show_light();
        self.forget_local_light();
        Ok(())
    }

    fn set_appearance(&mut self, appearance: &Appearance) -> Result<Vec<String>, BackendError> {
        let Some(renderer) = &mut self.renderer else { return Ok(Vec::new()) };
        let (fitted, remarks) = appearance.fitted(&renderer.dataset.scene.materials);
        match renderer.appearance.opacities() == fitted.opacities() {
            true => self.sketch.set_appearance(&renderer.appearance, &fitted),
            // Pixels see other surfaces now.
            false => self.sketch.forget(),
        }
        renderer.set_appearance(fitted);
        Ok(remarks)
    }

    fn set_light(
        &mut self,
        light: &Illumination,
        lighting: &Arc<EnvironmentLight>,
    ) -> Result<Vec<String>, BackendError> {
        self.light = Some((light.clone(), lighting.clone()));
        self.set_light = Some(lighting.clone());
        self.show_light();
        Ok(Vec::new())
    }

    fn set_local_lighting(&mut self, lighting: &LocalLighting) -> Result<Vec<String>, BackendError> {
        self.local = lighting.clone();
        let remark = remark_on_rays(&self.local.shown_lights());
        let before = std::mem::replace(&mut self.remark, remark.clone());
        Ok(remark.filter(|_| before != self.remark).into_iter().collect())
    }

    fn begin(&mut self, view: &View, sampling: BrdfSampling) -> Result<(), BackendError> {
        self.begun = None;
        self.resume(view, sampling, &Stale::ALL)
    }

    fn resume(&mut self, view: &View, sampling: BrdfSampling, stale: &Stale) -> Result<(), BackendError> {
        let lights = self.local.shown_lights();
        let (kept, last) = match self.begun.take() {
            Some(begun) if begun.summed.stays(view, sampling, stale) => (Some(begun), None),
            begun => (None, begun.filter(|begun| begun.summed.has_light_of(view, sampling, stale, &lights))),
        };
        let light = self.light.as_ref().map(|(light, _)| light);
        let backdrop = Backdrop::new(view, light, self.local.components.environment, &mut self.blur);
        let mut summed = Summed::new(view, sampling);
        let known = kept.as_ref().map(|begun| &begun.summed);
        summed.lights = known.map(|summed| summed.lights.clone()).unwrap_or_default();
        let step = summed.lights.update(&lights, known.is_some_and(Summed::is_complete));
        let renderer = self.renderer.as_ref();
        let scene = renderer.and_then(|renderer| SeenScene::in_mirrors(renderer, view, sampling, &backdrop));
        let parts = light_of(renderer, self.shown_environment(), &self.local, &summed.lights, scene).parts(view.mode);
        let mirrors = renderer.map(|renderer| renderer.mirrors).unwrap_or_default();
        self.sketch.begin(&view.camera, view.size, last.as_ref().map(|begun| &begun.picture));
        let picture = match kept {
            None => Picture::new(view.size, parts, last.map(|begun| begun.picture)),
            Some(mut begun) => {
                begun.forget(stale, step, mirrors);
                begun.picture.resume(parts);
                begun.picture
            }
        };
        self.begun = Some(Begun { summed, backdrop, picture });
        Ok(())
    }

    fn render_rows(&mut self, sample: u32, rows: Range<u32>) -> Result<(), BackendError> {
        let Some(work) = self.at_work() else { return Ok(()) };
        let painter = work.painter();
        if rows.end >= work.sampler.view.size[1] {
            *work.complete = sample + 1;
        }
        work.picture.add_rows(&work.sampler, painter, work.patches.as_deref(), sample, rows);
        Ok(())
    }

    fn sketch(&mut self, stride: u32, tiles: &[u32]) -> Result<(), BackendError> {
        let Some(work) = self.at_work() else { return Ok(()) };
        let (painter, patches) = (work.painter(), work.patches.as_deref());
        work.sketch.add_tiles(work.picture, &work.sampler, painter, patches, stride, tiles);
        if work.sketch.is_complete() {
            *work.complete = 1;
            work.sketch.forget_last();
        }
        Ok(())
    }

    fn fill(&mut self, most_shaded: u32) -> Result<u32, BackendError> {
        let Some(work) = self.at_work() else { return Ok(0) };
        let (painter, patches) = (work.painter(), work.patches.as_deref());
        Ok(work.sketch.fill(work.picture, &work.sampler, painter, patches, most_shaded))
    }

    fn display(&mut self, post: &Post, _samples: u32) -> Result<Vec<[u8; 4]>, BackendError> {
        let Some(Begun { summed: Summed { view, sampling, .. }, picture, .. }) = &self.begun else {
            return Ok(Vec::new());
        };
        let illum_cut = self.light.as_ref().map_or(0, |(_, lighting)| lighting.max_nodes);
        Ok(picture.display(view, post, view.mode.count_top(*sampling, illum_cut)))
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
