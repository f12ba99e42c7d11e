//! The loop of the thread: take the newest request, do one step of rendering, repeat.

mod refining;
mod telling;

use super::{
    LinearPicture, Message, Outbox, RenderEvent, RenderRequest, RenderedFrame,
    sketching::{SketchPace, Sketching},
    stage::{COMPILER_SILENCE, PictureStage, Restarts},
};
use crate::{control_names::remedy_control, jobs::budget::Pace};
use glam::Vec2;
use lapidary_core::{camera::Camera, scene::pose::Poses};
use lapidary_render::{
    Backend, BackendError, BackendFactory, Baked, CPU, CpuBackend, LitScene, Look, PictureStats, Redo, View,
};
use lapidary_studies::jobs::panic_text;
use std::{
    ops::Range,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::SeqCst},
        mpsc::{Receiver, RecvTimeoutError, TryRecvError},
    },
    time::{Duration, Instant},
};

/// Delay until the full picture continues after other work.
const HELD_WAIT: Duration = Duration::from_millis(100);

/// Share of the frame time for the coarsest lattice and its display. The rest is for finer ones.
const FIRST_SHARE: f32 = 0.9;

/// Delay until a pose is lit more finely.
const FINER_WAIT: Duration = Duration::from_millis(50);

/// Least share of the frame time for the picture, however long its light takes. The light of posed objects is as fine as fits the
/// rest.
const PICTURE_SHARE: f32 = 0.4;

/// Share of the frame time for pixels that resemble no lattice pixel.
const HOLES_SHARE: f32 = 0.1;

/// The picture being rendered.
struct Begun {
    size: [u32; 2],
    full_size: bool,
    of_samples: u32,
    /// Samples complete in all rows.
    complete: u32,
    millis: f64,
    /// Its first sample.
    sketching: Sketching,
    /// Pixels shaded at the last fill.
    holes: u32,
    /// Whether nothing is kept of the picture before.
    is_anew: bool,
}

impl Begun {
    /// Spacing of a lattice in pixels of the full picture.
    fn apart(&self, stride: u32, full: [u32; 2]) -> f32 {
        stride as f32 * full[0] as f32 / self.size[0].max(1) as f32
    }
}

fn millis_since(start: Instant) -> f64 {
    1e3 * start.elapsed().as_secs_f64()
}

/// Flags shared by thread and window.
pub struct Shared {
    /// Whether other work needs the cores.
    pub held: Arc<AtomicBool>,
    /// Whether one sample per pixel is enough for now.
    pub is_preview: Arc<AtomicBool>,
    /// Whether the thread has work that waits for nothing.
    pub works: Arc<AtomicBool>,
    /// Whether the next picture has waited for shaders for a while.
    pub compiles: Arc<AtomicBool>,
}

/// The graphics adapter, as far as pictures have come from it.
enum Adapter {
    /// There was no picture yet.
    Unknown,
    /// The renderer is on this one, or there is none.
    Used(Option<String>),
    /// It had no room for this scene: the CPU has that.
    Refused(Baked),
    /// It had no room for a picture of this size.
    TooLarge([u32; 2]),
    /// It failed: the CPU has all.
    GivenUp,
    /// It was one of these, and is tried again.
    Retried,
}

impl Adapter {
    /// Whether another scene or size is worth a try.
    fn is_worth_a_try(&self, baked: &Baked, size: [u32; 2]) -> bool {
        match self {
            Self::Refused(refused) => !refused.is_same(baked),
            Self::TooLarge(too_large) => *too_large != size,
            _ => false,
        }
    }
}

/// The state of the thread.
pub struct Worker {
    inbox: Receiver<Message>,
    outbox: Outbox,
    shared: Shared,
    factory: BackendFactory,
    adapter: Adapter,
    /// The scene on its renderer, once there is one.
    scene: Option<LitScene>,
    /// Revisions of the environment's light from renderers given up since.
    lights_before: u64,
    wanted: Option<Arc<RenderRequest>>,
    stage: PictureStage,
    begun: Option<Begun>,
    /// Camera, full size and poses of the last picture begun, for which first hits are known.
    seen_from: Option<(Camera, [u32; 2], Poses)>,
    /// Whether the picture replaces one of another bake, which stays on the screen until this has a full sample.
    replaces: bool,
    /// The rest of the frame time after its light, in milliseconds.
    budget_ms: f32,
    /// Spacing of the last lattice shown of the present look, in pixels of the full picture.
    shown_apart: Option<f32>,
    /// Speed of first samples.
    sketch_pace: SketchPace,
    /// Speed of the last bands, for their height: rows of sky are faster than others.
    band_pace: Pace,
    /// The shaders must be reloaded.
    reload_wanted: bool,
    /// The picture must be displayed again.
    redisplay: bool,
    /// Requests that wait for the full picture.
    reads: Vec<u64>,
    restarts: Restarts,
    /// Since when pictures have waited for shaders; newer requests wait for them, too.
    compiles_since: Option<Instant>,
    /// Statistics of the last picture read back, which takes too long while something moves.
    stats: PictureStats,
    /// The last failure, which is not reported again until there was a picture.
    reported: Option<String>,
}

impl Worker {
    /// With nothing to do yet.
    pub fn new(factory: BackendFactory, inbox: Receiver<Message>, outbox: Outbox, shared: Shared) -> Self {
        Self {
            inbox,
            outbox,
            shared,
            factory,
            adapter: Adapter::Unknown,
            scene: None,
            lights_before: 0,
            wanted: None,
            stage: PictureStage::Rest,
            begun: None,
            seen_from: None,
            replaces: false,
            budget_ms: 0.0,
            shown_apart: None,
            sketch_pace: SketchPace::default(),
            band_pace: Pace::default(),
            reload_wanted: false,
            redisplay: false,
            reads: Vec::new(),
            restarts: Restarts::default(),
            compiles_since: None,
            stats: PictureStats::default(),
            reported: None,
        }
    }

    /// Works until the window is gone.
    pub fn run(mut self) {
        while self.receive() {
            match catch_unwind(AssertUnwindSafe(|| self.step())) {
                Ok(Ok(())) => {}
                Ok(Err(error)) => self.failed(error),
                Err(panic) => {
                    self.reset();
                    let reason = panic_text(&*panic);
                    self.give_up(format!(
                        "the renderer failed because of a bug in Lapidary ({reason}); change something to try again, and \
                         please report it"
                    ));
                }
            }
        }
    }

    /// Takes all messages, waiting for one if there is nothing else to do. Returns whether to continue.
    fn receive(&mut self) -> bool {
        if self.is_urgent() {
            return true;
        }
        let patience = self.patience();
        self.shared.works.store(patience == Some(Duration::ZERO), SeqCst);
        self.tell_compiles();
        let first = match patience {
            None => self.inbox.recv().map_err(RecvTimeoutError::from),
            Some(patience) => self.inbox.recv_timeout(patience),
        };
        let mut newest = None;
        let mut next = match first {
            Ok(message) => Some(message),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return false,
        };
        while let Some(message) = next {
            match message {
                Message::Request(request) => newest = Some(request),
                Message::ReadPicture(id) => self.reads.push(id),
                Message::Reload => self.reload_wanted = true,
            }
            next = match self.inbox.try_recv() {
                Ok(message) => Some(message),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => return false,
            };
        }
        if let Some(request) = newest {
            self.accept(*request);
        }
        true
    }

    /// Whether a picture must be shown before newer requests are taken: a stream of requests would never show one otherwise.
    fn is_urgent(&self) -> bool {
        self.stage == PictureStage::Sketch && self.shown_apart.is_none() && !self.replaces
    }

    fn patience(&self) -> Option<Duration> {
        if self.stage == PictureStage::Rest && self.may_be_finer() {
            let goes_on = !self.must_wait() && self.scene.as_ref().is_some_and(LitScene::is_unsolved);
            return Some(if goes_on { Duration::ZERO } else { FINER_WAIT });
        }
        if self.stage == PictureStage::Rest && !self.reads.is_empty() {
            return Some(Duration::ZERO);
        }
        if self.waits() {
            return Some(HELD_WAIT);
        }
        self.stage.patience(Instant::now())
    }

    /// Whether the full picture waits for other work.
    fn waits(&self) -> bool {
        let has_shown = match self.stage {
            PictureStage::Full { .. } | PictureStage::Settle { .. } => true,
            PictureStage::Sketch => self.shown_apart.is_some(),
            PictureStage::Rest | PictureStage::Begin | PictureStage::Compile => false,
        };
        let is_preview = self.shared.is_preview.load(SeqCst) && self.reads.is_empty();
        let is_enough = matches!(self.stage, PictureStage::Full { .. }) && is_preview;
        has_shown && (self.shared.held.load(SeqCst) || is_enough)
    }

    /// Rebuilds the renderer's shaders; the previous ones stay if that fails.
    fn reload(&mut self) {
        if matches!(self.adapter, Adapter::GivenUp) {
            self.reset();
            self.adapter = Adapter::Retried;
        }
        // A renderer created later reads them then.
        let reloaded = self.scene.as_mut().map_or(Ok(()), |scene| scene.backend().reload());
        self.begun = None;
        self.stage = PictureStage::Begin;
        self.outbox.event(match reloaded {
            Ok(()) => RenderEvent::Remark("shaders reloaded".into()),
            Err(error) => RenderEvent::Remark(format!("shaders not reloaded: {error}")),
        });
    }

    /// Starts the work for a new request.
    fn accept(&mut self, request: RenderRequest) {
        let redo = self.wanted.as_ref().map_or(Redo::ALL, |wanted| wanted.redo(&request));
        if redo.renders() {
            (self.stage, self.shown_apart) = (PictureStage::Begin, None);
        } else if redo.display {
            self.post_changed();
        }
        self.wanted = Some(request.into());
    }

    fn post_changed(&mut self) {
        // A picture not shown yet will have the new curve.
        self.redisplay = self.stage != PictureStage::Begin
            && self.begun.as_ref().is_some_and(|begun| begun.complete > 0 || begun.sketching.is_shown());
    }

    /// Does one step, not much longer than a band of rows.
    fn step(&mut self) -> Result<(), BackendError> {
        if std::mem::take(&mut self.reload_wanted) {
            self.reload();
        }
        let Some(request) = self.wanted.clone() else { return self.answer_reads() };
        if std::mem::take(&mut self.redisplay) {
            self.publish(&request)?;
        }
        if request.may_pose && self.begun.as_ref().is_some_and(|begun| begun.complete > 0) {
            self.scene.as_mut().map(LitScene::prepare_to_drag);
        }
        if self.refine(&request)? {
            return Ok(());
        }
        match self.stage {
            PictureStage::Rest if self.may_be_finer() && !self.must_wait() => Ok(()),
            PictureStage::Rest => self.answer_reads(),
            PictureStage::Begin => self.begin_any(&request),
            _ if self.waits() => Ok(()),
            PictureStage::Settle { .. } if self.stage.settled(Instant::now()) => {
                self.begin(&request, request.look.view.size, true)
            }
            PictureStage::Settle { .. } => Ok(()),
            PictureStage::Compile => self.wait_for_shaders(),
            PictureStage::Sketch => self.sketch(&request),
            PictureStage::Full { sample, row } => self.band(&request, sample, row),
        }
    }

    /// Begins a picture: full size if first hits are unchanged or another bake replaces the picture, else as large as fits the
    /// frame time.
    fn begin_any(&mut self, request: &RenderRequest) -> Result<(), BackendError> {
        self.begun = None;
        self.replaces = false;
        let start = Instant::now();
        let is_prepared = self.scene.as_mut().is_some_and(LitScene::is_prepared_to_drag);
        if let Some(baked) = &request.baked {
            self.light(baked, &request.look)?;
        }
        let (budget, millis) = (request.frame_budget_ms, millis_since(start));
        self.budget_ms = (budget - millis as f32).max(PICTURE_SHARE * budget);
        if is_prepared && self.seen_from.as_ref().is_some_and(|(_, _, poses)| *poses != request.look.poses) {
            let budget = f64::from((1.0 - PICTURE_SHARE) * budget);
            self.scene.iter_mut().for_each(|scene| scene.adapt(millis, budget));
        }
        let full = request.look.view.size;
        if request.baked.is_none() || full.contains(&0) {
            self.stage = PictureStage::Rest;
            return Ok(());
        }
        let from = (request.look.view.camera.clone(), full, request.look.poses.clone());
        let before = self.seen_from.replace(from.clone());
        // A new bake of moved objects has them in place, so poses relative to the bake change although nothing moves.
        let is_in_place = |before: &(Camera, [u32; 2], Poses)| before.2 == from.2 || self.replaces && !request.moving;
        let stays = before.is_some_and(|before| (&before.0, before.1) == (&from.0, from.1) && is_in_place(&before));
        self.replaces &= stays;
        let pixels = full.map(u64::from).iter().product();
        let is_full = stays || self.sketch_pace.shows_whole(pixels, self.budget_ms);
        let size = if is_full { full } else { self.sketch_pace.reduced_size(full, FIRST_SHARE * self.budget_ms) };
        self.begin(request, size, !stays)
    }

    /// Computes some tiles of the first sample, and shows it when due.
    fn sketch(&mut self, request: &RenderRequest) -> Result<(), BackendError> {
        let (Some(begun), Some(scene)) = (&mut self.begun, &mut self.scene) else { return Ok(()) };
        let sketching = &mut begun.sketching;
        let (stride, tiles) = sketching.next(&self.sketch_pace, self.budget_ms);
        let (count, start) = (tiles.len(), Instant::now());
        scene.sketch(stride, tiles)?;
        let millis = millis_since(start);
        begun.millis += millis;
        sketching.advance(count, &mut self.sketch_pace, millis);
        if sketching.is_complete() {
            return self.sketch_complete(request);
        }
        let is_due = sketching.is_due(&self.sketch_pace, self.budget_ms);
        // Never shows a coarser picture of the same look than before.
        let apart = begun.sketching.stride().map(|stride| begun.apart(stride, request.look.view.size));
        if is_due && !self.replaces && apart.is_some_and(|apart| self.shown_apart.is_none_or(|shown| apart <= shown)) {
            self.show_sketch(request)?;
            self.shown_apart = apart;
        }
        Ok(())
    }

    /// Shows the first sample as far as it is.
    fn show_sketch(&mut self, request: &RenderRequest) -> Result<(), BackendError> {
        let start = Instant::now();
        self.publish(request)?;
        let Some(begun) = &mut self.begun else { return Ok(()) };
        self.sketch_pace.shown(begun.sketching.pixels(), begun.holes, millis_since(start));
        begun.sketching.set_shown();
        if !begun.full_size {
            self.stage = PictureStage::Settle { since: Instant::now() };
        }
        Ok(())
    }

    fn sketch_complete(&mut self, request: &RenderRequest) -> Result<(), BackendError> {
        let complete = self.sample_complete(request)?;
        let Some(begun) = &mut self.begun else { return Ok(()) };
        begun.sketching.set_shown();
        self.shown_apart = Some(begun.apart(1, request.look.view.size));
        self.band_pace.measured(begun.sketching.pixels(), begun.millis);
        if begun.is_anew && begun.full_size {
            self.sketch_pace.whole_done(begun.sketching.pixels(), begun.millis);
        }
        self.stage = match begun.full_size {
            _ if complete => PictureStage::Rest,
            true => PictureStage::Full { sample: 1, row: 0 },
            false => PictureStage::Settle { since: Instant::now() },
        };
        Ok(())
    }

    /// Updates scene, materials and light of the renderer where they have changed.
    fn light(&mut self, baked: &Baked, look: &Look) -> Result<(), BackendError> {
        if self.adapter.is_worth_a_try(baked, look.view.size) {
            self.reset();
            self.adapter = Adapter::Retried;
        }
        let scene = match &mut self.scene {
            Some(scene) => {
                let is_rebaked = scene.baked().dataset.scene_hash == baked.dataset.scene_hash;
                if scene.set_scene(baked)? {
                    (self.sketch_pace, self.band_pace) = Default::default();
                    self.seen_from.take_if(|_| !is_rebaked);
                    self.replaces = self.seen_from.is_some();
                }
                scene
            }
            None => {
                let renderer = self.renderer()?;
                self.scene.insert(LitScene::new(renderer, baked.clone())?.keep_unseen_changes())
            }
        };
        scene.light_soon(look)?;
        scene.remarks().into_iter().for_each(|remark| self.outbox.event(RenderEvent::Remark(remark)));
        Ok(())
    }

    /// A new renderer, on the CPU where the adapter will not do.
    fn renderer(&mut self) -> Result<Box<dyn Backend>, BackendError> {
        if matches!(self.adapter, Adapter::Refused(_) | Adapter::TooLarge(_) | Adapter::GivenUp) {
            return Ok(Box::new(CpuBackend::new()));
        }
        let renderer = match (self.factory)() {
            Err(error) if matches!(self.adapter, Adapter::Retried) => {
                self.adapter = Adapter::GivenUp;
                self.outbox.event(RenderEvent::Remark(error.text(remedy_control)));
                return Ok(Box::new(CpuBackend::new()));
            }
            made => made?,
        };
        let name = renderer.name();
        self.adapter = Adapter::Used((name != CPU).then_some(name));
        Ok(renderer)
    }

    /// Gives up the renderer; the next picture makes another.
    fn reset(&mut self) {
        (self.sketch_pace, self.band_pace) = Default::default();
        (self.seen_from, self.shown_apart, self.compiles_since) = (None, None, None);
        self.lights_before += self.scene.take().map_or(0, |scene| scene.light_revision());
    }

    /// Renders a band of rows of the full picture.
    fn band(&mut self, request: &RenderRequest, sample: u32, row: u32) -> Result<(), BackendError> {
        let [width, height] = request.look.view.size;
        let end = row.saturating_add(self.band_pace.band_rows(width)).min(height);
        let millis = self.render(sample, row..end)?;
        self.band_pace.measured(u64::from(width) * u64::from(end - row), millis);
        if end < height {
            self.stage = PictureStage::Full { sample, row: end };
            return Ok(());
        }
        let complete = self.sample_complete(request)?;
        self.stage = if complete { PictureStage::Rest } else { PictureStage::Full { sample: sample + 1, row: 0 } };
        Ok(())
    }

    /// Begins a picture; `is_anew` tells that nothing is kept of the one before.
    fn begin(&mut self, request: &RenderRequest, size: [u32; 2], is_anew: bool) -> Result<(), BackendError> {
        let full_size = size == request.look.view.size;
        let aa = if full_size { request.look.view.aa.max(1) } else { 1 };
        self.begun = None;
        let view = View { size, aa, ..request.look.view.clone() };
        let Some(scene) = &mut self.scene else { return Ok(()) };
        scene.resume(&view, request.look.sampling)?;
        let sketching = Sketching::new(size, request.pointer.unwrap_or(Vec2::splat(0.5)));
        let shows_whole = full_size && self.sketch_pace.shows_whole(sketching.pixels(), self.budget_ms);
        let sketching = if shows_whole { sketching.whole() } else { sketching };
        let (complete, millis, holes) = (0, 0.0, 0);
        self.begun = Some(Begun { size, full_size, of_samples: aa, complete, millis, sketching, holes, is_anew });
        self.wait_for_shaders()
    }

    /// Goes on with the picture once its shaders are compiled.
    fn wait_for_shaders(&mut self) -> Result<(), BackendError> {
        let Some(scene) = &mut self.scene else { return Ok(()) };
        let is_ready = scene.is_ready()?;
        self.stage = if is_ready { PictureStage::Sketch } else { PictureStage::Compile };
        self.compiles_since = self.compiles_since.or_else(|| Some(Instant::now())).filter(|_| !is_ready);
        // The first picture after it is made without a look at messages.
        self.tell_compiles();
        Ok(())
    }

    /// Renders rows of a sample after the first, and returns the milliseconds taken.
    fn render(&mut self, sample: u32, rows: Range<u32>) -> Result<f64, BackendError> {
        let start = Instant::now();
        let Some(scene) = &mut self.scene else { return Ok(0.0) };
        scene.render_rows(sample, rows)?;
        let millis = millis_since(start);
        if let Some(begun) = &mut self.begun {
            begun.millis += millis;
        }
        Ok(millis)
    }

    /// Counts a sample, and shows the picture when it has all, or twice as many as the shown one. Returns whether it is the full
    /// picture and complete.
    fn sample_complete(&mut self, request: &RenderRequest) -> Result<bool, BackendError> {
        let Some(begun) = &mut self.begun else { return Ok(false) };
        begun.complete += 1;
        let all = begun.complete == begun.of_samples;
        let complete = begun.full_size && all;
        if all || begun.complete.is_power_of_two() {
            self.publish(request)?;
        }
        Ok(complete)
    }
}
