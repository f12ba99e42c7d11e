//! The thread that renders the comparison for the live picture: the same picture with cuts at the reference's size, then an
//! improving reference. Any change of the picture's inputs restarts it; exposure does not.

mod control;
mod worker;

use super::{Wake, spawn};
use anyhow::Result;
use control::Control;
use lapidary_core::image::{Image, Region};
use lapidary_render::{BackendFactory, Baked, Look, PictureStats, Redo};
use std::{
    fmt,
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};

/// Kind of reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReferenceKind {
    /// All light samples, with visibility traced at the pixel: shows the error of the cuts.
    Samples,
    /// Light paths: show the whole error, with some noise.
    Paths {
        /// Paths per pixel.
        spp: u32,
    },
    /// A picture of another renderer.
    File(PathBuf),
    /// The same view in another look, by cuts.
    Look(OtherLook),
}

/// Another look of the same scene, which the thread makes, since that may read files.
#[derive(Clone)]
pub struct OtherLook {
    /// Tells it from others.
    pub number: u64,
    /// Makes it.
    pub make: Arc<dyn Fn() -> Result<Look> + Send + Sync>,
}

impl fmt::Debug for OtherLook {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("OtherLook").field(&self.number).finish()
    }
}

impl PartialEq for OtherLook {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

impl Eq for OtherLook {}

impl ReferenceKind {
    /// Whether rays trace it through the centers of pixels. Others are filtered, like the live picture.
    pub fn is_traced(&self) -> bool {
        matches!(self, Self::Samples | Self::Paths { .. })
    }
}

/// A requested comparison.
#[derive(Clone, Debug)]
pub struct ComparisonRequest {
    /// The scene of the live picture; `None` if none is open.
    pub baked: Option<Baked>,
    /// The look of the live picture, at its size.
    pub look: Look,
    /// Kind of reference.
    pub kind: ReferenceKind,
    /// Live pixels per comparison pixel along each axis; a file keeps its own size.
    pub scale: u32,
    /// The only region to trace, in comparison pixels.
    pub region: Option<Region>,
}

impl ComparisonRequest {
    /// Width and height of the comparison in pixels, except with a file.
    pub fn size(&self) -> [u32; 2] {
        self.look.view.size.map(|side| side.div_ceil(self.scale.max(1)))
    }

    /// Whether pictures made for `other` are valid for `self`.
    fn is_same(&self, other: &Self) -> bool {
        self.kind == other.kind
            && self.scale == other.scale
            && self.region == other.region
            && Baked::are_same(self.baked.as_ref(), other.baked.as_ref())
            && !Redo::between(&other.look, &self.look).renders()
    }
}

/// The picture with cuts.
#[derive(Clone, Debug)]
pub struct TestPicture {
    /// Scene-linear.
    pub image: Image,
    /// Surface coverage of each pixel, 0 to 1.
    pub coverage: Vec<f32>,
    /// Expected luminance error of the environment's light, if cuts gather it ([`lapidary_render::PredictedError::expected`]).
    pub predicted: Option<Image>,
    /// Work for the picture.
    pub stats: PictureStats,
    /// Milliseconds of rendering.
    pub millis: f64,
}

/// The reference so far.
#[derive(Clone, Debug)]
pub struct ReferencePicture {
    /// Scene-linear.
    pub image: Arc<Image>,
    /// See [`lapidary_render::Preview::step`].
    pub step: u32,
    /// Relative RMSE by noise, if known.
    pub noise: Option<f64>,
    /// Whether it is final.
    pub finished: bool,
    /// Seconds of tracing.
    pub seconds: f64,
}

/// An event of the comparison.
#[derive(Clone, Debug)]
pub enum ComparisonEvent {
    /// The picture with cuts is ready.
    Test(Arc<TestPicture>),
    /// The reference, or an improved one.
    Reference(ReferencePicture),
    /// The reason why there is no comparison.
    Failed(String),
    /// An adjustment made to fit limits.
    Remark(String),
}

/// The window's handle of the thread.
pub struct ComparisonThread {
    requests: Option<Sender<(u64, Box<ComparisonRequest>)>>,
    events: Receiver<(u64, ComparisonEvent)>,
    control: Arc<Control>,
    last: Option<Box<ComparisonRequest>>,
}

impl ComparisonThread {
    /// Starts the thread. Its renderer is created at the first comparison.
    pub fn start(factory: BackendFactory, wake: Wake) -> Self {
        let (requests, inbox) = channel();
        let (sender, events) = channel();
        let control = Arc::new(Control::default());
        let outbox = worker::Outbox { events: sender, wake };
        let shared = control.clone();
        spawn("comparison", move || worker::Worker::new(factory, shared, outbox).run(&inbox));
        Self { requests: Some(requests), events, control, last: None }
    }

    /// Requests a comparison. Returns whether a new one starts.
    pub fn request(&mut self, request: ComparisonRequest) -> bool {
        if self.is_current(&request) {
            return false;
        }
        let request = Box::new(request);
        self.last = Some(request.clone());
        let number = self.control.begin();
        if let Some(requests) = &self.requests {
            // The thread only ends with this handle.
            let _ = requests.send((number, request));
        }
        true
    }

    /// Whether a request equals the current comparison.
    pub fn is_current(&self, request: &ComparisonRequest) -> bool {
        self.last.as_ref().is_some_and(|last| request.is_same(last))
    }

    /// Abandons the current tracing. The next request starts anew.
    pub fn stop(&mut self) {
        self.last = None;
        self.control.begin();
    }

    /// Pauses, even within a pass, or resumes.
    pub fn pause(&self, paused: bool) {
        self.control.pause(paused);
    }

    /// Whether it is paused.
    pub fn is_paused(&self) -> bool {
        self.control.is_paused()
    }

    /// Yields the cores to other work, even within a pass, or resumes.
    pub fn hold(&self, held: bool) {
        self.control.hold(held);
    }

    /// Whether it yields the cores.
    pub fn is_held(&self) -> bool {
        self.control.is_held()
    }

    /// Completed share of the reference, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.control.progress()
    }

    /// New events of the latest request since the last call.
    pub fn events(&mut self) -> Vec<ComparisonEvent> {
        let wanted = self.control.wanted();
        self.events.try_iter().filter(|(number, _)| *number == wanted).map(|(_, event)| event).collect()
    }
}

impl Drop for ComparisonThread {
    /// Ends the thread within a row of pixels.
    fn drop(&mut self) {
        self.requests = None;
        self.control.begin();
    }
}

#[cfg(test)]
mod tests;
