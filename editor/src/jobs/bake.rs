//! Bakes on a worker: progress, cancellation, resuming from a checkpoint, and a draft to show meanwhile.

use super::guest::{Door, lower_priority};
use crate::panels::bake::control_name;
use lapidary_core::{
    cut::{CutCriterion, SourceCriterion},
    dataset::{BakeSettings, Dataset, IndirectSettings, MeshlessSettings},
    output::OutputError,
    scene::Scene,
    threads::on_threads,
};
use lapidary_precompute::{
    BakeError, BakeJob, CheckpointError, Event, Observer, Phase, Preset, bake, resolve, with_room,
};
use lapidary_render::Baked;
use lapidary_studies::jobs::{Wake, guarded, spawn};
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

/// A bake of the window.
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
        };
        spawn("bake", move || {
            lower_priority();
            let end = guarded("the bake", || Ok(run(task, &teller))).unwrap_or_else(BakeMessage::Failed);
            teller.tell(end);
        });
        Self { messages, progress, cancel, door }
    }

    /// Events since the last call.
    pub fn messages(&mut self) -> Vec<BakeMessage> {
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

    /// How long it has waited.
    pub fn waited(&self) -> Duration {
        self.door.waited()
    }

    /// Asks it to stop; [`BakeMessage::Cancelled`] follows when it has.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
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
                return self.tell(BakeMessage::Warning(message.text(control_name)));
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

/// Settings of the first bake that is shown. It has the same components and viewpoint, is coarser than a draft, because
/// the user waits for it, and in nothing finer than the bake asked for. What is sharp in the light of an environment are suns,
/// which have shadows without a bake; for the rest few lights and evenly spread vertices do. The mesh has `mesh_vertices`.
pub fn first_draft(wanted: &BakeSettings, mesh_vertices: usize) -> BakeSettings {
    let draft = Preset::Draft.settings();
    let lights = (draft.lights / 16).min(wanted.lights);
    // A quarter of the lights at half the sigma is the same error in solid angle.
    let as_fine_as = |other: &BakeSettings| other.criterion.sigma * (lights as f32 / other.lights as f32).sqrt();
    let sigma = as_fine_as(&draft).max(as_fine_as(wanted));
    let criterion = CutCriterion { sigma, max_nodes: wanted.criterion.max_nodes, ..draft.criterion };
    let most = Some(with_room(15_000, mesh_vertices));
    // A mesh that is to stay as it is does so in the draft.
    let max_vertices = most.min(wanted.max_vertices);
    let (indirect, meshless) = (draft_of_sources(&wanted.indirect), draft_of_basis(&wanted.meshless));
    let pilot_clusters = wanted.pilot_clusters.min(64);
    BakeSettings {
        mode: wanted.mode,
        ground: wanted.ground,
        shots: wanted.shots.clone(),
        lights,
        pilot_clusters,
        criterion,
        max_vertices,
        even_vertices: true,
        indirect,
        meshless,
        ..draft
    }
}

fn draft_of_sources(wanted: &IndirectSettings) -> IndirectSettings {
    let draft = Preset::Draft.settings().indirect;
    let sources = (draft.sources / 4).min(wanted.sources);
    let sigma = draft.criterion.sigma.max(wanted.criterion.sigma * (sources as f32 / wanted.sources as f32).sqrt());
    IndirectSettings { sources, criterion: SourceCriterion { sigma, ..draft.criterion }, viewpoint: wanted.viewpoint }
}

fn draft_of_basis(wanted: &MeshlessSettings) -> MeshlessSettings {
    let (levels, sender_levels) = (wanted.levels.min(3), wanted.sender_levels.min(3));
    let (rays, epsilon) = (wanted.rays.min(128), wanted.epsilon.max(MeshlessSettings::default().epsilon));
    MeshlessSettings { levels, sender_levels, rays, epsilon, coarse_radius: wanted.coarse_radius }
}

/// Whether a draft is ready sooner than the bake itself.
pub fn draft_is_sooner(wanted: &BakeSettings) -> bool {
    let (draft, mode) = (first_draft(wanted, 0), wanted.mode);
    let (few, many) = (draft.meshless, wanted.meshless);
    (mode.environment() && draft.lights < wanted.lights)
        || (mode.sources() && draft.indirect.sources < wanted.indirect.sources)
        || (mode.meshless() && (few.levels < many.levels || few.rays < many.rays))
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
            Err(error) => teller.tell(BakeMessage::Warning(format!("there is no draft: {}", error.text(control_name)))),
        }
    }
    match on_threads(cores, || bake_whole(task, teller)) {
        Ok(dataset) => BakeMessage::Done(Baked::from(dataset)),
        Err(BakeError::Cancelled) => BakeMessage::Cancelled,
        Err(error) => BakeMessage::Failed(error.text(control_name)),
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

#[cfg(test)]
mod tests;
