//! The bake at work, and how the last one ended.

use crate::{
    jobs::bake::{BakeProgress, BakeRun},
    panels::bake::{BakeStatus, Draft, Pace, line},
};
use lapidary_core::dataset::BakeParts;
use lapidary_precompute::{Leftover, Phase, ResolvedBake};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, mpsc::Receiver},
    time::{Duration, Instant, SystemTime},
};

/// The bake at work, or how the last one ended.
#[derive(Default)]
pub struct Baking {
    pub(in crate::app) run: Option<Run>,
    pub(in crate::app) ended: Option<Ended>,
    /// Held by the bake at work, also by one that was left and has not noticed yet.
    pub(in crate::app) turn: Arc<Mutex<()>>,
    /// A kept bake that is being written to where the user wants it.
    pub(in crate::app) written: Option<Receiver<Result<PathBuf, String>>>,
    /// What an interrupted bake left, and when it was read.
    pub(in crate::app) leftover: Option<(Looked, Leftover)>,
    /// A bake is to begin for a ground that was asked for, once the one at work has ended.
    pub(in crate::app) wants_ground: bool,
    /// The bake at work was cancelled for a ground, and another is to follow whatever is chosen by then.
    pub(in crate::app) begins_anew: bool,
}

/// The inputs that decide what an interrupted bake left, small enough to compare every frame.
#[derive(PartialEq)]
pub struct Looked {
    pub(in crate::app) output: PathBuf,
    pub(in crate::app) scene_hash: String,
    pub(in crate::app) settings: ResolvedBake,
    /// When the folder was last written to.
    pub(in crate::app) written: SystemTime,
}

/// A bake at work.
pub struct Run {
    pub(in crate::app) job: BakeRun,
    pub(in crate::app) mode: BakeParts,
    /// Where it goes.
    pub(in crate::app) output: PathBuf,
    pub(in crate::app) since: Instant,
    pub(in crate::app) phase: Option<Phase>,
    pub(in crate::app) phase_since: Instant,
    /// How long it had waited for others when the phase began.
    pub(in crate::app) waited_before: Duration,
    /// How fast the phase goes.
    pub(in crate::app) pace: Pace,
    pub(in crate::app) cancelling: bool,
    /// A draft of it is shown.
    pub(in crate::app) draft_shown: bool,
    /// It is of a scene on a ground.
    pub(in crate::app) has_ground: bool,
    /// It began without being asked for.
    pub(in crate::app) by_itself: bool,
}

/// What the picture is rendered by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The scene without shadows.
    Unshadowed,
    /// A draft of a bake.
    Draft,
    /// A bake.
    Whole,
}

/// How a bake ended that has no result.
pub enum Ended {
    /// It can be resumed.
    Cancelled,
    /// Why.
    Failed(String),
}

impl Baking {
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
    pub fn words(&self, seen: Seen) -> Option<&'static str> {
        match (seen, self.run.is_some()) {
            (Seen::Unshadowed, true) => Some("No shadows yet; baking"),
            (Seen::Unshadowed, false) => Some("No shadows yet"),
            (Seen::Draft, true) => Some("Draft; full bake running"),
            (Seen::Draft, false) => Some("Draft"),
            (Seen::Whole, true) => Some("Baking"),
            (Seen::Whole, false) => None,
        }
    }

    /// Stops what is at work, and forgets how the last one ended: another scene was opened.
    pub fn clear(&mut self) {
        *self = Self { turn: self.turn.clone(), ..Self::default() };
    }
}

impl Run {
    /// Takes note of how far it is.
    pub(in crate::app) fn follow(&mut self) {
        let BakeProgress { phase, done, .. } = self.job.progress();
        if phase != self.phase {
            (self.phase, self.phase_since, self.waited_before) = (phase, Instant::now(), self.job.waited());
            self.pace = Pace::default();
        }
        self.pace.note(self.phase_secs(), done);
    }

    /// Seconds that it has worked on the present phase.
    fn phase_secs(&self) -> f64 {
        let waited = self.job.waited().saturating_sub(self.waited_before);
        self.phase_since.elapsed().saturating_sub(waited).as_secs_f64()
    }

    /// How far it is, as the panel shows it.
    pub(in crate::app) fn status(&self) -> BakeStatus {
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
            cancelling: self.cancelling,
            elapsed_secs: self.since.elapsed().as_secs_f64(),
            left_secs: self.pace.left(done, total),
        }
    }
}
