//! The thread that makes what the live picture is compared with: the same picture with cuts in the reference's size, and then
//! the reference, better and better. Whatever the picture depends on begins it anew; exposure does not.

mod control;
mod worker;

use super::{Wake, spawn};
use control::Control;
use lapidary_core::image::{Image, Region};
use lapidary_render::{BackendFactory, Baked, Look, PictureStats, Redo};
use std::{
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{Receiver, Sender, channel},
    },
};

/// What is taken for the truth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReferenceKind {
    /// All light samples, with visibility traced at the pixel: shows what the cuts lose.
    Samples,
    /// Light paths: the whole error, and some noise.
    Paths {
        /// Paths a pixel.
        spp: u32,
    },
    /// A picture of another renderer.
    File(PathBuf),
}

/// What is to be compared.
#[derive(Clone, Debug)]
pub struct ComparisonRequest {
    /// The scene of the live picture; `None` while nothing is open.
    pub baked: Option<Baked>,
    /// The look of the live picture, in its size.
    pub look: Look,
    /// With what.
    pub kind: ReferenceKind,
    /// The comparison has one pixel for so many of the live picture along each axis; a file has its own size.
    pub scale: u32,
    /// The only part that is traced, in pixels of the comparison.
    pub region: Option<Region>,
}

impl ComparisonRequest {
    /// Width and height of the comparison in pixels, unless it is with a file.
    pub fn size(&self) -> [u32; 2] {
        self.look.view.size.map(|side| side.div_ceil(self.scale.max(1)))
    }

    /// Whether pictures made for `other` are those of `self`.
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
    /// How much of each pixel is covered by surfaces, 0 to 1.
    pub coverage: Vec<f32>,
    /// Luminance of the error that is expected of the environment's light, where it is gathered by cuts
    /// ([`lapidary_render::PredictedError::expected`]).
    pub predicted: Option<Image>,
    /// Work done for it.
    pub stats: PictureStats,
    /// Milliseconds of rendering.
    pub millis: f64,
}

/// The reference as far as it is.
#[derive(Clone, Debug)]
pub struct ReferencePicture {
    /// Scene-linear.
    pub image: Arc<Image>,
    /// See [`lapidary_render::Preview::step`].
    pub step: u32,
    /// Relative RMSE by noise, where it is known.
    pub noise: Option<f64>,
    /// Whether it gets no better.
    pub finished: bool,
    /// Seconds of tracing.
    pub seconds: f64,
}

/// What has happened.
#[derive(Clone, Debug)]
pub enum ComparisonEvent {
    /// The picture with cuts is there.
    Test(Arc<TestPicture>),
    /// The reference, or a better one.
    Reference(ReferencePicture),
    /// There is no comparison, and why.
    Failed(String),
    /// What had to be done to make something fit.
    Remark(String),
}

/// The window's end of the thread.
pub struct ComparisonThread {
    requests: Option<Sender<(u64, Box<ComparisonRequest>)>>,
    events: Receiver<(u64, ComparisonEvent)>,
    control: Arc<Control>,
    last: Option<Box<ComparisonRequest>>,
}

impl ComparisonThread {
    /// Starts the thread. Its renderer is made when there is something to compare.
    pub fn start(factory: BackendFactory, wake: Wake) -> Self {
        let (requests, inbox) = channel();
        let (sender, events) = channel();
        let control = Arc::new(Control::default());
        let outbox = worker::Outbox { events: sender, wake };
        let shared = control.clone();
        spawn("comparison", move || worker::Worker::new(factory, shared, outbox).run(&inbox));
        Self { requests: Some(requests), events, control, last: None }
    }

    /// Asks for a comparison. Returns whether one begins: it is another than before.
    pub fn request(&mut self, request: ComparisonRequest) -> bool {
        if self.is_current(&request) {
            return false;
        }
        let request = Box::new(request);
        self.last = Some(request.clone());
        let number = self.control.begin();
        if let Some(requests) = &self.requests {
            // The thread only ends when it is told to.
            let _ = requests.send((number, request));
        }
        true
    }

    /// Whether a request would begin nothing.
    pub fn is_current(&self, request: &ComparisonRequest) -> bool {
        self.last.as_ref().is_some_and(|last| request.is_same(last))
    }

    /// Gives up what is being traced. The next request begins anew.
    pub fn stop(&mut self) {
        self.last = None;
        self.control.begin();
    }

    /// Stops for a while, within a pass, or goes on.
    pub fn pause(&self, paused: bool) {
        self.control.pause(paused);
    }

    /// Whether it was told to pause.
    pub fn is_paused(&self) -> bool {
        self.control.is_paused()
    }

    /// Gives the cores to other work, within a pass, or goes on.
    pub fn hold(&self, held: bool) {
        self.control.hold(held);
    }

    /// Whether it gives the cores to other work.
    pub fn is_held(&self) -> bool {
        self.control.is_held()
    }

    /// Share of the reference that is done, 0 to 1.
    pub fn progress(&self) -> f32 {
        self.control.progress()
    }

    /// What happened since the last call to what was asked for last.
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
