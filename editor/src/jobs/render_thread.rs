//! The thread that renders the viewport. The latest request wins. Its picture is shown as soon as the coarsest lattice of its
//! first sample is there, then with each finer one, and then sample by sample. If the camera moves and the frame time does
//! not suffice for the rays of all pixels, a smaller picture comes first. Nothing is rendered when nothing has changed.

mod sketching;
mod stage;
mod worker;

use glam::Vec2;
use lapidary_core::{dataset::Dataset, image::Image};
use lapidary_render::{
    BackendFactory, Baked, EnvironmentLight, ImplicitDetail, LocalLighting, Look, PictureStats, Redo, Tier,
};
use lapidary_studies::jobs::{Wake, spawn};
use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering::SeqCst},
        mpsc::{Receiver, Sender, channel},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

/// Everything that decides the picture. Copying it copies no texels and no maps.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// The scene, compared by pointer; `None` while nothing is open.
    pub baked: Option<Baked>,
    /// The look at the size of the full picture; its environment is compared by pointer.
    pub look: Look,
    /// Whether the user is editing, as in a drag: slow invisible work is left out.
    pub moving: bool,
    /// Whether an object may be posed next.
    pub may_pose: bool,
    /// Milliseconds until a change is visible.
    pub frame_budget_ms: f32,
    /// Position of the pointer, 0 to 1 from the upper left corner of the picture, where refinement begins.
    pub pointer: Option<Vec2>,
}

impl RenderRequest {
    /// The work that a renderer of this request repeats for `new`.
    pub fn redo(&self, new: &Self) -> Redo {
        if Baked::are_same(self.baked.as_ref(), new.baked.as_ref()) {
            Redo::between(&self.look, &new.look)
        } else {
            Redo::ALL
        }
    }

    /// Whether both ask for the same picture, made in the same way.
    pub fn is_same(&self, other: &Self) -> bool {
        self.redo(other) == Redo::NOTHING
            && (self.moving, self.may_pose) == (other.moving, other.may_pose)
            && self.frame_budget_ms == other.frame_budget_ms
    }
}

/// A picture to show.
#[derive(Clone, Debug)]
pub struct RenderedFrame {
    /// The shown scene.
    pub dataset: Arc<Dataset>,
    /// Pixels from [`lapidary_render::Backend::display`].
    pub pixels: Vec<[u8; 4]>,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Method of its light.
    pub tier: Tier,
    /// Detail of posed objects' light, if any.
    pub detail: Option<ImplicitDetail>,
    /// Whether it has the requested size, not a reduced one.
    pub full_size: bool,
    /// Samples per pixel so far; 0 while the first one is interpolated between lattice pixels.
    pub samples: u32,
    /// Samples per pixel when it is done.
    pub of_samples: u32,
    /// Work done for it.
    pub stats: PictureStats,
    /// Milliseconds of rendering.
    pub millis: f64,
    /// Light of the environment in it.
    pub lighting: Arc<EnvironmentLight>,
    /// Changes whenever `lighting` does.
    pub light_revision: u64,
    /// Local lights and bounced light in it.
    pub local: LocalLighting,
    /// Name of the renderer.
    pub backend: String,
}

/// A full picture, scene-linear.
#[derive(Clone, Debug)]
pub struct LinearPicture {
    /// Radiance, or the quantity of the view mode; not exposed.
    pub image: Image,
    /// Coverage of each pixel by surfaces, 0 to 1.
    pub coverage: Vec<f32>,
}

/// A message for the user, or a picture for a file.
#[derive(Clone, Debug)]
pub enum RenderEvent {
    /// A reduction to fit a limit, or a restart of the renderer.
    Remark(String),
    /// Why there is no picture.
    Failed(String),
    /// The answer to [`RenderThread::read_picture`].
    Picture {
        /// Identifier of the request.
        id: u64,
        /// The picture, or why there is none.
        result: Result<LinearPicture, String>,
    },
}

/// Messages from the window.
enum Message {
    Request(Box<RenderRequest>),
    ReadPicture(u64),
    Reload,
}

/// Pictures and events for the window.
struct Outbox {
    /// Only the newest, since a hidden window collects none for a while.
    frame: Arc<Mutex<Option<RenderedFrame>>>,
    events: Sender<RenderEvent>,
    wake: Wake,
}

impl Outbox {
    fn frame(&self, frame: RenderedFrame) {
        *self.frame.lock().unwrap_or_else(PoisonError::into_inner) = Some(frame);
        (self.wake)();
    }

    fn event(&self, event: RenderEvent) {
        // Fails only if the window is gone.
        let _ = self.events.send(event);
        self.wake();
    }

    fn wake(&self) {
        (self.wake)();
    }
}

/// The window's end of the thread.
pub struct RenderThread {
    /// `None` once the thread was asked to end.
    messages: Option<Sender<Message>>,
    frame: Arc<Mutex<Option<RenderedFrame>>>,
    events: Receiver<RenderEvent>,
    held: Arc<AtomicBool>,
    is_preview: Arc<AtomicBool>,
    works: Arc<AtomicBool>,
    compiles: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl RenderThread {
    /// Starts the thread. The renderer is created with the first picture.
    pub fn start(factory: BackendFactory, wake: Wake) -> Self {
        let (messages, inbox) = channel();
        let (events_sender, events) = channel();
        let frame = Arc::new(Mutex::new(None));
        let outbox = Outbox { frame: frame.clone(), events: events_sender, wake };
        let held = Arc::new(AtomicBool::new(false));
        let works = Arc::new(AtomicBool::new(false));
        let is_preview = Arc::new(AtomicBool::new(false));
        let compiles = Arc::new(AtomicBool::new(false));
        let shared = worker::Shared {
            held: held.clone(),
            is_preview: is_preview.clone(),
            works: works.clone(),
            compiles: compiles.clone(),
        };
        let thread = spawn("render", move || worker::Worker::new(factory, inbox, outbox, shared).run());
        Self { messages: Some(messages), frame, events, held, is_preview, works, compiles, thread: Some(thread) }
    }

    /// Leaves the cores to other work: only the first coarse picture is made meanwhile, and the full one continues afterwards.
    pub fn hold(&self, held: bool) {
        self.held.store(held, SeqCst);
    }

    /// Makes further samples wait, because a better picture is on its way.
    pub fn set_preview(&self, is_preview: bool) {
        self.is_preview.store(is_preview, SeqCst);
    }

    /// Whether it is rendering, not waiting.
    pub fn works(&self) -> bool {
        self.works.load(SeqCst)
    }

    /// Whether the next picture has waited for shaders for a while.
    pub fn compiles(&self) -> bool {
        self.compiles.load(SeqCst)
    }

    /// Requests a picture; free if nothing has changed since the last request.
    pub fn request(&self, request: RenderRequest) {
        self.send(Message::Request(Box::new(request)));
    }

    /// Requests the full scene-linear picture once it is complete: see [`RenderEvent::Picture`].
    pub fn read_picture(&self, id: u64) {
        self.send(Message::ReadPicture(id));
    }

    /// Rebuilds the renderer's shaders after a change.
    pub fn reload(&self) {
        self.send(Message::Reload);
    }

    /// The newest picture not yet taken.
    pub fn frames(&mut self) -> Option<RenderedFrame> {
        self.frame.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Events since the last call.
    pub fn events(&mut self) -> Vec<RenderEvent> {
        self.events.try_iter().collect()
    }

    fn send(&self, message: Message) {
        if let Some(messages) = &self.messages {
            // The thread ends only when asked to.
            let _ = messages.send(message);
        }
    }
}

impl Drop for RenderThread {
    /// Lets the thread finish its band, so that no driver is at work when the process ends. A thread with a longer task
    /// is not waited for.
    fn drop(&mut self) {
        const PATIENCE: Duration = Duration::from_millis(500);
        self.messages = None;
        let start = Instant::now();
        while self.thread.as_ref().is_some_and(|t| !t.is_finished()) && start.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

#[cfg(test)]
mod tests;
