//! The running bake, and how the last one ended.

use super::panel::{BakeStatus, Draft, line};
use crate::workspace::BakeStage;
use lapidary_core::{dataset::BakeParts, ground::Ground, scene::pose::Poses};
use lapidary_precompute::{BakeJob, Leftover, Phase, ResolvedBake};
use lapidary_render::Baked;
use lapidary_studies::jobs::{
    Wake,
    bake::{BakeProgress, BakeRun, BakeTask},
};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, mpsc::Receiver},
    time::SystemTime,
};

/// The running bake, or how the last one ended.
#[derive(Default)]
pub struct Baking {
    pub run: Option<Run>,
    pub ended: Option<Ended>,
    /// Held by the running bake, and by an abandoned one until it stops.
    pub turn: Arc<Mutex<()>>,
    /// Poses for which an update ended without a result; it is not tried again by itself.
    pub refused: Option<Poses>,
    /// The whole bake of which the shown one is an update. The next update is one of it too, so that changes do not add up, and
    /// the way back leads to it.
    pub whole: Option<Baked>,
    /// The shown bake is an update that is in no file.
    pub is_unwritten: bool,
    /// A kept bake that is being written where the user wants it.
    pub written: Option<Receiver<Result<PathBuf, String>>>,
    /// The remains of an interrupted bake, and the inputs for which they were read.
    pub leftover: Option<(Looked, Leftover)>,
    /// A bake for a requested ground begins once the running one has ended.
    pub wants_ground: bool,
    /// The user's bake, which begins once the running one has ended.
    pub again: Option<BakeOrder>,
    /// The running bake was canceled for a ground; another follows, with or without a ground.
    pub begins_anew: bool,
}

/// Inputs that decide the remains of an interrupted bake, small enough to compare every frame.
#[derive(PartialEq)]
pub struct Looked {
    pub output: PathBuf,
    pub scene_hash: String,
    pub settings: ResolvedBake,
    /// When the folder was last written to.
    pub written: SystemTime,
}

/// A running bake.
pub struct Run {
    pub job: BakeRun,
    pub mode: BakeParts,
    /// Its output.
    pub output: PathBuf,
    /// A draft of it is shown.
    pub draft_shown: bool,
    /// Its scene has a ground.
    pub has_ground: bool,
    /// Who asked for it.
    pub asked_by: Asker,
    /// The poses of an update; `None` for a whole bake.
    pub of_poses: Option<Poses>,
    /// Another move has overtaken the update.
    pub is_overtaken: bool,
    /// What it bakes; `None` for an update.
    pub content: Option<(String, ResolvedBake)>,
}

/// Who asks for a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asker {
    /// The user; a checkpoint of other settings stops the bake.
    User,
    /// Nobody: it begins automatically, and replaces a checkpoint of other settings.
    Nobody,
}

/// Where a bake begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// At its first phase; a checkpoint is discarded.
    Beginning,
    /// At the checkpoint of an interrupted bake.
    Checkpoint,
}

/// Order for a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeOrder {
    /// Who asks for it.
    pub asked_by: Asker,
    /// Where it begins.
    pub from: From,
    /// Whether a draft is baked and shown first.
    pub draft_first: bool,
}

/// How a bake without a result ended.
pub enum Ended {
    /// It can be resumed.
    Cancelled,
    /// Why.
    Failed(String),
}

impl Baking {
    /// Begins a bake.
    pub fn begin(&mut self, task: BakeTask, order: BakeOrder, content: Option<(String, ResolvedBake)>, wake: Wake) {
        let BakeJob { settings, output, .. } = &task.job;
        let (mode, has_ground, output) = (settings.mode, settings.ground != Ground::Off, output.clone());
        let job = BakeRun::start(task, wake);
        let (asked_by, of_poses, is_overtaken) = (order.asked_by, None, false);
        self.run =
            Some(Run { job, mode, output, draft_shown: false, has_ground, asked_by, of_poses, is_overtaken, content });
        self.ended = None;
    }

    /// Holds the running bake, or lets it continue.
    pub fn hold(&self, hold: bool) {
        self.run.iter().for_each(|run| run.job.hold(hold));
    }

    /// Progress of the running bake.
    pub fn progress(&self) -> Option<BakeProgress> {
        self.run.as_ref().map(|run| run.job.progress())
    }

    /// Whether cuts are baked anew where an edit reaches.
    pub fn is_updating(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.of_poses.is_some())
    }

    /// One line about the running bake: its phase, its progress and what follows.
    pub fn line(&self) -> Option<String> {
        line(&self.run.as_ref()?.status())
    }

    /// A short note over the picture about its bake.
    pub fn words(&self, seen: BakeStage, shown: BakeParts) -> Option<&'static str> {
        match (seen, self.run.is_some()) {
            // Local lights have their shadows without a bake.
            (BakeStage::Unshadowed, true) if !shown.environment() => Some("No bounced light yet; baking"),
            (BakeStage::Unshadowed, false) if !shown.environment() => Some("No bounced light yet"),
            (BakeStage::Unshadowed, true) => Some("No shadows yet; baking"),
            (BakeStage::Unshadowed, false) => Some("No shadows yet"),
            (BakeStage::Draft, true) => Some("Draft; full bake running"),
            (BakeStage::Draft, false) => Some("Draft"),
            (BakeStage::Whole, true) => Some("Baking"),
            (BakeStage::Whole, false) => None,
        }
    }

    /// Stops the running bake and forgets how the last one ended: another scene was opened.
    pub fn clear(&mut self) {
        *self = Self { turn: self.turn.clone(), ..Self::default() };
    }
}

impl Run {
    /// Whether its result is written to a file. An update that nobody asked for stays in memory.
    pub fn is_kept(&self) -> bool {
        self.asked_by == Asker::User || self.of_poses.is_none()
    }

    /// Status of the running bake for the panel.
    pub fn status(&self) -> BakeStatus {
        let BakeProgress { draft, phase, unit, done, total } = self.job.progress();
        let draft = match (draft, self.draft_shown) {
            (true, _) => Draft::UnderWay,
            (false, true) => Draft::Shown,
            (false, false) => Draft::None,
        };
        BakeStatus::Running {
            mode: self.mode,
            draft,
            phase: phase.unwrap_or(Phase::Import),
            done,
            total,
            unit,
            cancelling: self.job.is_cancelling(),
            elapsed_secs: self.job.elapsed_secs(),
            left_secs: self.job.left_secs(),
        }
    }
}
