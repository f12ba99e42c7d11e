//! Explains pixels of the live picture, and splits its error by causes, on threads of their own.

use super::{Wake, guarded, hearing::Hearing, spawn};
use anyhow::Result;
use lapidary_core::{image::Region, lights::Light};
use lapidary_precompute::VertexSampler;
use lapidary_render::{
    Appearance, Baked, BrdfSampling, CutMap, ErrorSplit, GatheredLight, Illumination, PixelExplanation, Progress,
    Renderer, SplitJob, View,
};
use std::sync::{
    Arc,
    mpsc::{Receiver, Sender, channel},
};

/// Width in pixels of the map of directions.
const MAP_WIDTH: u32 = 512;
/// Light paths a pixel, rounded up to whole sets of the pixel's samples.
const SPLIT_SPP: u32 = 256;

/// A picture whose pixels are explained.
#[derive(Clone)]
pub struct ExplainSubject {
    /// The scene.
    pub baked: Baked,
    /// Its materials.
    pub appearance: Appearance,
    /// Camera, size and samples.
    pub view: View,
    /// How the BRDF is sampled.
    pub sampling: BrdfSampling,
    /// Which light, as the picture has it.
    pub lit: GatheredLight,
    /// The continuous environment.
    pub illumination: Illumination,
    /// Local lights, whose bounce the sources hold.
    pub lights: Arc<[Light]>,
}

impl ExplainSubject {
    fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(self.baked.clone());
        renderer.set_appearance(self.appearance.fitted(&self.baked.dataset.scene.materials).0);
        renderer
    }

    fn explain(&self, pixel: [u32; 2]) -> Result<Explained> {
        let (renderer, light) = (self.renderer(), self.lit.light());
        let explanation = renderer.explain(&self.view, pixel, light, self.sampling)?;
        let map = renderer.cut_map(&explanation, light, MAP_WIDTH).into();
        Ok(Explained { explanation, map })
    }

    fn split(&self, region: Region, progress: &dyn Progress) -> Result<Option<ErrorSplit>> {
        let renderer = self.renderer();
        let sampler = VertexSampler::new(&self.baked.dataset, renderer.intersector());
        let trace = |vertex: u32, visible: &mut [u8]| sampler.sample(vertex, visible);
        let job = SplitJob {
            view: &self.view,
            region,
            light: self.lit.light(),
            sampling: self.sampling,
            illumination: &self.illumination,
            lights: &self.lights,
            spp: SPLIT_SPP,
            trace_vertex: Some(&trace),
        };
        Ok(renderer.split_error(&job, progress)?)
    }
}

/// A pixel that was explained.
pub struct Explained {
    /// Its cuts and nodes.
    pub explanation: PixelExplanation,
    /// Its merged cut on the map of directions.
    pub map: Arc<CutMap>,
}

/// Work on its way; dropping it cancels.
pub struct ExplainJob<T> {
    answer: Receiver<Result<T, String>>,
    hearing: Arc<Hearing>,
}

impl ExplainJob<Explained> {
    /// Explains a pixel.
    pub fn pixel(subject: ExplainSubject, pixel: [u32; 2], wake: Wake) -> Self {
        Self::start(wake, move |_| subject.explain(pixel))
    }
}

impl ExplainJob<Option<ErrorSplit>> {
    /// Splits the error of a region; `None` if cancelled.
    pub fn split(subject: ExplainSubject, region: Region, wake: Wake) -> Self {
        Self::start(wake, move |hearing| subject.split(region, hearing))
    }
}

impl<T: Send + 'static> ExplainJob<T> {
    fn start(wake: Wake, work: impl FnOnce(&Hearing) -> Result<T> + Send + 'static) -> Self {
        let (sender, answer): (Sender<Result<T, String>>, _) = channel();
        let hearing = Arc::new(Hearing::new(wake));
        let theirs = hearing.clone();
        spawn("explain", move || {
            // Nobody is left to tell if the window is gone.
            let _ = sender.send(guarded("the explanation", || work(&theirs)));
            theirs.wake();
        });
        Self { answer, hearing }
    }

    /// The answer, once.
    pub fn answer(&self) -> Option<Result<T, String>> {
        self.answer.try_recv().ok()
    }

    /// Share that is done, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.hearing.share()
    }
}

impl<T> Drop for ExplainJob<T> {
    fn drop(&mut self) {
        self.hearing.cancel();
    }
}
