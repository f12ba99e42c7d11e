//! The bake at work, and how the last one ended.

use super::panel::{BakeStatus, Draft, line};
use crate::workspace::BakeStage;
use lapidary_core::{dataset::BakeParts, ground::Ground};
use lapidary_precompute::{BakeJob, Leftover, Phase, ResolvedBake};
use lapidary_studies::jobs::{
    Wake,
    bake::{BakeProgress, BakeRun, BakeTask},
};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, mpsc::Receiver},
    time::SystemTime,
};

/// The bake at work, or how the last one ended.
#[derive(Default)]
pub struct Baking {
    pub run: Option<Run>,
    pub ended: Option<Ended>,
    /// Held by the bake at work, also by one that was left and has not noticed yet.
    pub turn: Arc<Mutex<()>>,
    /// A kept bake that is being written to where the user wants it.
    pub written: Option<Receiver<Result<PathBuf, String>>>,
    /// What an interrupted bake left, and when it was read.
    pub leftover: Option<(Looked, Leftover)>,
    /// A bake is to begin for a ground that was asked for, once the one at work has ended.
    pub wants_ground: bool,
    /// The bake at work was cancelled for a ground, and another is to follow whatever is chosen by then.
    pub begins_anew: bool,
}

/// The inputs that decide what an interrupted bake left, small enough to compare every frame.
#[derive(PartialEq)]
pub struct Looked {
    pub output: PathBuf,
    pub scene_hash: String,
    pub settings: ResolvedBake,
    /// When the folder was last written to.
    pub written: SystemTime,
}

/// A bake at work.
pub struct Run {
    pub job: BakeRun,
    pub mode: BakeParts,
    /// Where it goes.
    pub output: PathBuf,
    /// A draft of it is shown.
    pub draft_shown: bool,
    /// It is of a scene on a ground.
    pub has_ground: bool,
    /// Who asked for it.
    pub asked_by: Asker,
}

/// Who asks for a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asker {
    /// The user, whose checkpoints of other settings are a reason to stop.
    User,
    /// Nobody: it begins by itself, and afresh where a checkpoint is of other settings.
    Nobody,
}

/// Where a bake begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// At its first phase; a checkpoint is discarded.
    Beginning,
    /// At the checkpoint that an interrupted one left.
    Checkpoint,
}

/// How a bake is to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeOrder {
    /// Who asks for it.
    pub asked_by: Asker,
    /// Where it begins.
    pub from: From,
    /// Whether a draft is baked first, to look at.
    pub draft_first: bool,
}

/// How a bake ended that has no result.
pub enum Ended {
    /// It can be resumed.
    Cancelled,
    /// Why.
    Failed(String),
}

impl Baking {
    /// Begins a bake.
    pub fn begin(&mut self, task: BakeTask, order: BakeOrder, wake: Wake) {
        let BakeJob { settings, output, .. } = &task.job;
        let (mode, has_ground, output) = (settings.mode, settings.ground != Ground::Off, output.clone());
        let job = BakeRun::start(task, wake);
        self.run = Some(Run { job, mode, output, draft_shown: false, has_ground, asked_by: order.asked_by });
        self.ended = None;
    }

    /// Makes the bake at work wait, or go on.
    pub fn hold(&self, hold: bool) {
        self.run.iter().for_each(|run| run.job.hold(hold));
    }

    /// How far the bake at work is.
    pub fn progress(&self) -> Option<BakeProgress> {
        self.run.as_ref().map(|run| run.job.progress())
    }

    /// One line about the bake at work: what it does, how far that is, and what comes.
    pub fn line(&self) -> Option<String> {
        line(&self.run.as_ref()?.status())
    }

    /// A few words, to lie over the picture, about what is seen and what comes.
    pub fn words(&self, seen: BakeStage) -> Option<&'static str> {
        match (seen, self.run.is_some()) {
            (BakeStage::Unshadowed, true) => Some("No shadows yet; baking"),
            (BakeStage::Unshadowed, false) => Some("No shadows yet"),
            (BakeStage::Draft, true) => Some("Draft; full bake running"),
            (BakeStage::Draft, false) => Some("Draft"),
            (BakeStage::Whole, true) => Some("Baking"),
            (BakeStage::Whole, false) => None,
        }
    }

    /// Stops what is at work, and forgets how the last one ended: another scene was opened.
    pub fn clear(&mut self) {
        *self = Self { turn: self.turn.clone(), ..Self::default() };
    }
}

impl Run {
    /// How far it is, as the panel shows it.
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
