//! Explains pixels of the live picture and splits its error by cause, on their own threads.

use super::{Wake, guarded, shared_progress::SharedProgress, spawn};
use anyhow::Result;
use lapidary_core::image::Region;
use lapidary_precompute::VertexSampler;
use lapidary_render::{Baked, CutMap, ErrorSplit, GatheredLight, Look, PixelExplanation, Progress, SplitJob};
use std::sync::{
    Arc,
    mpsc::{Receiver, Sender, channel},
};

/// Width in pixels of the map of directions.
const MAP_WIDTH: u32 = 512;
/// Light paths per pixel, rounded up to whole patterns of the pixel's samples.
const SPLIT_SPP: u32 = 256;

/// A picture to explain.
#[derive(Clone)]
pub struct ExplainedPicture {
    /// The scene.
    pub baked: Baked,
    /// The look of the picture.
    pub look: Look,
    /// The light to explain, as in the picture.
    pub gathered: GatheredLight,
}

impl ExplainedPicture {
    fn explain(&self, pixel: [u32; 2]) -> Result<ExplainedPixel> {
        let (renderer, light) = (self.look.renderer(&self.baked), self.gathered.light());
        let mut explanation = renderer.explain(&self.look.view, pixel, light, self.look.sampling)?;
        renderer.explain_suns(&mut explanation, &self.look.illumination);
        let map = renderer.cut_map(&explanation, light, MAP_WIDTH).into();
        Ok(ExplainedPixel { explanation, map })
    }

    fn split(&self, region: Region, progress: &dyn Progress) -> Result<Option<ErrorSplit>> {
        let renderer = self.look.renderer(&self.baked);
        let sampler = VertexSampler::new(&self.baked.dataset, renderer.intersector());
        let trace = |vertex: u32, visible: &mut [u8]| sampler.sample(vertex, visible);
        let job = SplitJob {
            view: &self.look.view,
            region,
            light: self.gathered.light(),
            sampling: self.look.sampling,
            illumination: &self.look.illumination,
            lights: &self.look.lights,
            spp: SPLIT_SPP,
            trace_vertex: Some(&trace),
        };
        Ok(renderer.split_error(&job, progress)?)
    }
}

/// Explanation of a pixel.
pub struct ExplainedPixel {
    /// Its cuts and nodes.
    pub explanation: PixelExplanation,
    /// Its merged cut on the map of directions.
    pub map: Arc<CutMap>,
}

/// A running job; dropping it cancels.
pub struct ExplainJob<T> {
    answer: Receiver<Result<T, String>>,
    progress: Arc<SharedProgress>,
}

impl ExplainJob<ExplainedPixel> {
    /// Explains a pixel.
    pub fn pixel(picture: ExplainedPicture, pixel: [u32; 2], wake: Wake) -> Self {
        Self::start(wake, move |_| picture.explain(pixel))
    }
}

impl ExplainJob<Option<ErrorSplit>> {
    /// Splits the error of a region; `None` if cancelled.
    pub fn split(picture: ExplainedPicture, region: Region, wake: Wake) -> Self {
        Self::start(wake, move |progress| picture.split(region, progress))
    }
}

impl<T: Send + 'static> ExplainJob<T> {
    fn start(wake: Wake, work: impl FnOnce(&SharedProgress) -> Result<T> + Send + 'static) -> Self {
        let (sender, answer): (Sender<Result<T, String>>, _) = channel();
        let progress = Arc::new(SharedProgress::new(wake));
        let theirs = progress.clone();
        spawn("explain", move || {
            // The receiver is gone if the window is closed.
            let _ = sender.send(guarded("the explanation", || work(&theirs)));
            theirs.wake();
        });
        Self { answer, progress }
    }

    /// The answer, once.
    pub fn answer(&self) -> Option<Result<T, String>> {
        self.answer.try_recv().ok()
    }

    /// Completed share, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.progress.share()
    }
}

impl<T> Drop for ExplainJob<T> {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}
