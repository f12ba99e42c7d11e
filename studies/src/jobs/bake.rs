//! Bakes on a worker: progress, cancellation, resuming from a checkpoint, and a draft to show meanwhile. Commands bake on
//! their own thread instead; both give the same [`BakeJob`] to [`bake`].

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
use lapidary_precompute::{BakeError, BakeJob, CheckpointError, Event, Observer, Phase, Setting, bake, resolve};
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

/// A bake that is asked for.
#[derive(Clone, Debug)]
pub struct BakeTask {
    /// As imported. Copied by the thread that bakes, not by the window's.
    pub scene: Arc<Scene>,
    /// Settings and where the dataset goes.
    pub job: BakeJob,
    /// Bakes a draft first, unless the job is one or goes on from a checkpoint.
    pub progressive: bool,
    /// Begins afresh if the checkpoint to go on from is of another scene or other settings.
    pub or_afresh: bool,
    /// Held while it works: a cancelled bake ends before the next begins, which may write the same files.
    pub turn: Arc<Mutex<()>>,
    /// Folder in which the draft is written and removed again.
    pub cache: PathBuf,
    /// What the user calls a setting.
    pub name_of: fn(Setting) -> &'static str,
}

/// How far a bake is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeProgress {
    /// Whether it is at the draft.
    pub draft: bool,
    /// The phase, once there is one.
    pub phase: Option<Phase>,
    /// The unit of `done` and `total`.
    pub unit: &'static str,
    /// Units that are complete.
    pub done: u64,
    /// All units of the phase, 0 if unknown.
    pub total: u64,
}

impl BakeProgress {
    /// Share of the phase that is complete, if its length is known.
    pub fn fraction(&self) -> Option<f32> {
        (self.total > 0).then(|| (self.done as f64 / self.total as f64).min(1.0) as f32)
    }
}

/// Events of a bake. The last three end it.
#[derive(Clone, Debug)]
pub enum BakeMessage {
    /// Something was repaired or left out.
    Warning(String),
    /// A first dataset to look at.
    Draft(Baked),
    /// The dataset, which was also written.
    Done(Baked),
    /// It was cancelled; its checkpoint stays.
    Cancelled,
    /// Why there is no dataset.
    Failed(String),
}

/// A bake at work. Dropping it cancels.
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

    fn start_with(task: BakeTask, wake: Wake, cancel: Arc<AtomicBool>) -> Self {
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
            name_of: task.name_of,
        };
        spawn("bake", move || {
            lower_priority();
            let end = guarded("the bake", || Ok(run(task, &teller))).unwrap_or_else(BakeMessage::Failed);
            teller.tell(end);
        });
        Self { messages, progress, cancel, door, since: Instant::now(), pace: PhasePace::default() }
    }

    /// Events since the last call. Each call also measures the pace.
    pub fn messages(&mut self) -> Vec<BakeMessage> {
        self.pace.follow(self.progress(), self.door.waited());
        self.messages.try_iter().collect()
    }

    /// How far it is.
    pub fn progress(&self) -> BakeProgress {
        *self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes it wait, or go on.
    pub fn hold(&self, hold: bool) {
        self.door.hold(hold);
    }

    /// Seconds since it began.
    pub fn elapsed_secs(&self) -> f64 {
        self.since.elapsed().as_secs_f64()
    }

    /// Seconds that the present phase will still take, if that is known.
    pub fn left_secs(&self) -> Option<f64> {
        let BakeProgress { done, total, .. } = self.progress();
        self.pace.left(done, total)
    }

    /// Asks it to stop; [`BakeMessage::Cancelled`] follows when it has.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop, and may not have noticed yet.
    pub fn is_cancelling(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

impl Drop for BakeRun {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Tells the window what the bake says.
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
        // Nobody is left to tell if the window is gone.
        let _ = self.sender.send(message);
        (self.wake)();
    }

    /// Shows progress. A window that is drawn for each point takes a core.
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

/// The draft, if one is wanted, and then the bake itself.
fn run(task: BakeTask, teller: &Teller) -> BakeMessage {
    // A bake that failed badly has left its turn as well.
    let turn = task.turn.clone();
    let _turn = turn.lock().unwrap_or_else(PoisonError::into_inner);
    // All of them: the picture comes first.
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
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
    match on_threads(cores, || bake_whole(task, teller)) {
        Ok(dataset) => BakeMessage::Done(Baked::from(dataset)),
        Err(BakeError::Cancelled) => BakeMessage::Cancelled,
        Err(error) => BakeMessage::Failed(error.text(teller.name_of)),
    }
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

/// A folder in the cache for the draft, which is removed with all it holds. Its name is random, and nothing was there.
fn scratch(cache: &Path) -> Result<TempDir, OutputError> {
    let made =
        std::fs::create_dir_all(cache).and_then(|()| tempfile::Builder::new().prefix("draft-").tempdir_in(cache));
    made.map_err(|source| OutputError::Folder { folder: cache.into(), source })
}
