//! Bakes on a worker: progress, cancellation, resuming from a checkpoint, and a draft shown meanwhile. Commands bake on their own
//! thread; both give the same [`BakeJob`] to [`bake`].

mod draft;
mod pace;
#[cfg(test)]
mod tests;

pub use draft::{draft_is_sooner, first_draft};

use super::{
    Wake, guarded,
    guest::{Door, lower_priority},
    spawn,
};
use lapidary_core::{dataset::Dataset, output::OutputError, scene::Scene, threads::on_threads};
use lapidary_precompute::{
    BakeError, BakeJob, CheckpointError, Event, Observer, Phase, Setting, bake, resolve, update, update_file,
};
use lapidary_render::Baked;
use pace::PhasePace;
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    time::{Duration, Instant},
};
use tempfile::TempDir;

/// A requested bake.
#[derive(Clone, Debug)]
pub struct BakeTask {
    /// The imported scene. The baking thread copies it, not the window's thread.
    pub scene: Arc<Scene>,
    /// Settings and output path.
    pub job: BakeJob,
    /// Bakes a draft first, unless the job is a draft or resumes from a checkpoint.
    pub progressive: bool,
    /// Starts afresh if the checkpoint has another scene or other settings.
    pub or_afresh: bool,
    /// Held during work: a cancelled bake ends before the next begins, which may write the same files.
    pub turn: Arc<Mutex<()>>,
    /// Folder in which the draft is written and then removed.
    pub cache: PathBuf,
    /// User-visible name of a setting.
    pub name_of: fn(Setting) -> &'static str,
}

/// A requested update of a bake after an edit; see [`update`].
#[derive(Clone, Debug)]
pub struct UpdateTask {
    /// The bake before the edit.
    pub before: Baked,
    /// Its scene after the edit.
    pub scene: Scene,
    /// Where the result is written, if anywhere.
    pub output: Option<PathBuf>,
    /// As in [`BakeTask::turn`].
    pub turn: Arc<Mutex<()>>,
    /// User-visible name of a setting.
    pub name_of: fn(Setting) -> &'static str,
}

/// Progress of a bake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeProgress {
    /// Whether the draft is baking.
    pub draft: bool,
    /// The current phase, once started.
    pub phase: Option<Phase>,
    /// The unit of `done` and `total`.
    pub unit: &'static str,
    /// Completed units.
    pub done: u64,
    /// Total units of the phase, 0 if unknown.
    pub total: u64,
}

impl BakeProgress {
    /// Completed share of the phase, if its length is known.
    pub fn fraction(&self) -> Option<f32> {
        (self.total > 0).then(|| (self.done as f64 / self.total as f64).min(1.0) as f32)
    }
}

/// Events of a bake. The last three end it.
#[derive(Clone, Debug)]
pub enum BakeMessage {
    /// Something was repaired or left out.
    Warning(String),
    /// A first dataset to show.
    Draft(Baked),
    /// The dataset, already written.
    Done(Baked),
    /// It was cancelled; its checkpoint stays.
    Cancelled,
    /// Reason why there is no dataset.
    Failed(String),
}

/// A running bake. Dropping it cancels.
pub struct BakeRun {
    messages: Receiver<BakeMessage>,
    progress: Arc<Mutex<BakeProgress>>,
    cancel: Arc<AtomicBool>,
    door: Door,
    since: Instant,
    pace: PhasePace,
}

impl BakeRun {
    /// Starts a bake.
    pub fn start(task: BakeTask, wake: Wake) -> Self {
        Self::start_with(task, wake, Arc::default())
    }

    /// Starts an update.
    pub fn update(task: UpdateTask, wake: Wake) -> Self {
        Self::start_job(task.name_of, wake, Arc::default(), move |teller| run_update(task, teller))
    }

    fn start_with(task: BakeTask, wake: Wake, cancel: Arc<AtomicBool>) -> Self {
        Self::start_job(task.name_of, wake, cancel, move |teller| run(task, teller))
    }

    fn start_job(
        name_of: fn(Setting) -> &'static str,
        wake: Wake,
        cancel: Arc<AtomicBool>,
        work: impl FnOnce(&Teller) -> BakeMessage + Send + 'static,
    ) -> Self {
        let (sender, messages) = channel();
        let progress: Arc<Mutex<BakeProgress>> = Arc::default();
        let door = Door::default();
        let teller = Teller {
            sender,
            progress: progress.clone(),
            cancel: cancel.clone(),
            door: door.clone(),
            wake,
            woken: Arc::default(),
            draft: false,
            name_of,
        };
        spawn("bake", move || {
            lower_priority();
            let end = guarded("the bake", || Ok(work(&teller))).unwrap_or_else(BakeMessage::Failed);
            teller.tell(end);
        });
        Self { messages, progress, cancel, door, since: Instant::now(), pace: PhasePace::default() }
    }

    /// Events since the last call. Each call also measures the pace, unless other work wants the cores.
    pub fn messages(&mut self, is_disturbed: bool) -> Vec<BakeMessage> {
        self.pace.follow(self.progress(), self.door.waited(), is_disturbed);
        self.messages.try_iter().collect()
    }

    /// Current progress.
    pub fn progress(&self) -> BakeProgress {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Pauses or resumes it.
    pub fn hold(&self, hold: bool) {
        self.door.hold(hold);
    }

    /// Seconds since the start.
    pub fn elapsed_secs(&self) -> f64 {
        self.since.elapsed().as_secs_f64()
    }

    /// Estimated seconds left in the phase, if known.
    pub fn left_secs(&self) -> Option<f64> {
        let BakeProgress { done, total, .. } = self.progress();
        self.pace.left(done, total)
    }

    /// Asks it to stop; [`BakeMessage::Cancelled`] follows when it has.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Whether a stop was requested; it may still be running.
    pub fn is_cancelling(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl Drop for BakeRun {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Sends the bake's messages to the window.
#[derive(Clone)]
struct Teller {
    sender: Sender<BakeMessage>,
    progress: Arc<Mutex<BakeProgress>>,
    cancel: Arc<AtomicBool>,
    door: Door,
    wake: Wake,
    /// When progress last woke the window.
    woken: Arc<Mutex<Option<Instant>>>,
    draft: bool,
    name_of: fn(Setting) -> &'static str,
}

impl Teller {
    fn tell(&self, message: BakeMessage) {
        // The receiver is gone if the window is closed.
        let _ = self.sender.send(message);
        (self.wake)();
    }

    /// Shows progress, but rarely: redrawing the window for each point takes a core.
    fn wake_now_and_then(&self) {
        const BETWEEN: Duration = Duration::from_millis(250);
        let mut woken = self.woken.lock().unwrap_or_else(PoisonError::into_inner);
        if woken.is_none_or(|at| at.elapsed() >= BETWEEN) {
            *woken = Some(Instant::now());
            drop(woken);
            (self.wake)();
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl Observer for Teller {
    fn event(&self, event: Event) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::Started { phase, total, unit } => {
                *progress = BakeProgress { draft: self.draft, phase: Some(phase), unit, done: 0, total };
            }
            Event::Advanced { done } => {
                // Threads may report out of order.
                progress.done = progress.done.max(done);
                drop(progress);
                self.wake_now_and_then();
                return self.door.pass(|| self.is_cancelled());
            }
            Event::Warning { message } => {
                drop(progress);
                return self.tell(BakeMessage::Warning(message.text(self.name_of)));
            }
        }
        drop(progress);
        (self.wake)();
    }

    fn cancelled(&self) -> bool {
        self.door.pass(|| self.is_cancelled());
        self.is_cancelled()
    }
}

/// All cores: the picture has priority.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The message that ends a bake.
fn ended(result: Result<Dataset, BakeError>, teller: &Teller) -> BakeMessage {
    match result {
        Ok(dataset) => BakeMessage::Done(Baked::from(dataset)),
        Err(BakeError::Cancelled) => BakeMessage::Cancelled,
        Err(error) => BakeMessage::Failed(error.text(teller.name_of)),
    }
}

/// Bakes anew where the edit reaches.
fn run_update(task: UpdateTask, teller: &Teller) -> BakeMessage {
    let UpdateTask { before, scene, output, turn, .. } = task;
    let _turn = turn.lock().unwrap_or_else(PoisonError::into_inner);
    let updated = on_threads(cores(), || match output {
        Some(output) => update_file(&before.dataset, scene, &output, teller),
        None => update(&before.dataset, scene, teller),
    });
    ended(updated, teller)
}

/// Bakes the draft, if wanted, and then the dataset.
fn run(task: BakeTask, teller: &Teller) -> BakeMessage {
    // A panicked bake has released its turn too.
    let turn = task.turn.clone();
    let _turn = turn.lock().unwrap_or_else(PoisonError::into_inner);
    let cores = cores();
    let draft_settings = first_draft(&task.job.settings, task.scene.mesh.positions.len());
    if task.progressive && !task.job.resume && *task.job.settings != draft_settings {
        let teller_of_draft = Teller { draft: true, ..teller.clone() };
        let draft = || {
            let folder = scratch(&task.cache)?;
            let (settings, output) = (resolve(draft_settings)?, folder.path().join("draft.cuts"));
            bake((*task.scene).clone(), &BakeJob { settings, output, ..task.job.clone() }, &teller_of_draft)
        };
        match on_threads(cores, draft) {
            Ok(dataset) => teller.tell(BakeMessage::Draft(Baked::from(dataset))),
            Err(BakeError::Cancelled) => return BakeMessage::Cancelled,
            Err(error) => {
                teller.tell(BakeMessage::Warning(format!("there is no draft: {}", error.text(teller.name_of))))
            }
        }
    }
    ended(on_threads(cores, || bake_whole(task, teller)), teller)
}

fn bake_whole(task: BakeTask, teller: &Teller) -> Result<Dataset, BakeError> {
    match bake((*task.scene).clone(), &task.job, teller) {
        Err(BakeError::Checkpoint(CheckpointError::Mismatch { .. } | CheckpointError::Damaged { .. }))
            if task.or_afresh =>
        {
            bake(Arc::unwrap_or_clone(task.scene), &BakeJob { resume: false, ..task.job }, teller)
        }
        result => result,
    }
}

/// A folder in the cache for the draft, removed with its contents. Its name is random and new.
fn scratch(cache: &Path) -> Result<TempDir, OutputError> {
    let made =
        std::fs::create_dir_all(cache).and_then(|()| tempfile::Builder::new().prefix("draft-").tempdir_in(cache));
    made.map_err(|source| OutputError::Folder { folder: cache.into(), source })
}
