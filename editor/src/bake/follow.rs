//! A running bake: its messages, its result on the screen, and its status.

use super::{
    begin::{STARTS_AGAIN, UNDER_WAY},
    kept::{keep_draft, note_bake},
    panel::BakeStatus,
    stale::stale_now,
    state::{Baking, Ended, Run},
};
use crate::workspace::Workspace;
use lapidary_precompute::Leftover;
use lapidary_render::Baked;
use lapidary_studies::jobs::bake::BakeMessage;

impl Baking {
    pub fn cancel(&self) {
        self.run.iter().for_each(|run| run.job.cancel());
    }

    /// Cancels the bake, and starts no other for the ground.
    pub fn cancel_for_good(&mut self) {
        (self.wants_ground, self.begins_anew, self.again) = (false, false, None);
        self.cancel();
    }

    /// Takes messages of the bake, which may be disturbed by other work.
    pub fn collect(&mut self, work: &mut Workspace, is_disturbed: bool) {
        self.collect_written(work);
        self.collect_run(work, is_disturbed);
        if let Some(order) = self.again.filter(|_| self.run.is_none()) {
            self.again = None;
            self.bake(work, order);
        }
    }

    fn collect_run(&mut self, work: &mut Workspace, is_disturbed: bool) {
        let Some(run) = &mut self.run else { return };
        let messages = run.job.messages(is_disturbed);
        for message in messages {
            match message {
                BakeMessage::Warning(text) => work.messages.warning(text),
                BakeMessage::Draft(baked) => {
                    self.run.iter_mut().for_each(|run| run.draft_shown = true);
                    keep_draft(work, &baked.dataset);
                    show_baked(work, baked, true);
                }
                BakeMessage::Done(baked) => {
                    withdraw_notes(work);
                    let run = self.run.take();
                    if run.as_ref().is_none_or(|run| run.of_poses.is_none()) {
                        self.whole = None;
                    }
                    let kept = run.filter(Run::is_kept);
                    (self.is_unwritten, self.refused) = (kept.is_none(), None);
                    if let Some(run) = kept {
                        note_bake(work, &run, baked.dataset.report.vertices);
                    }
                    show_baked(work, baked, false);
                }
                BakeMessage::Cancelled if self.run.as_ref().is_some_and(|run| run.is_overtaken) => self.run = None,
                BakeMessage::Cancelled if self.run.as_ref().is_some_and(|run| !run.is_kept()) => {
                    self.refused = self.run.take().and_then(|run| run.of_poses);
                }
                BakeMessage::Cancelled => self.end(work, Ended::Cancelled),
                BakeMessage::Failed(error) => {
                    work.messages.error(format!("The bake failed: {error}"));
                    self.end(work, Ended::Failed(error));
                }
            }
        }
    }

    fn end(&mut self, work: &mut Workspace, ended: Ended) {
        self.refused = self.run.take().and_then(|run| run.of_poses);
        withdraw_notes(work);
        self.ended = Some(ended);
    }

    /// Status for the bake panel.
    pub fn status(&mut self, work: &Workspace) -> BakeStatus {
        if let Some(run) = &self.run {
            return run.status();
        }
        let leftover = self.leftover(work);
        match (&self.ended, &work.scene.baked) {
            (Some(Ended::Cancelled), _) => BakeStatus::Cancelled { leftover },
            (Some(Ended::Failed(message)), _) => BakeStatus::Failed { message: message.clone(), leftover },
            (None, Some(_)) => {
                let reasons = stale_now(work);
                if reasons.is_empty() { BakeStatus::UpToDate } else { BakeStatus::Stale { reasons } }
            }
            (None, None) if leftover != Leftover::Nothing => BakeStatus::Cancelled { leftover },
            (None, None) => BakeStatus::None,
        }
    }
}

/// What was said of the running bake is over.
fn withdraw_notes(work: &mut Workspace) {
    work.messages.withdraw(UNDER_WAY);
    work.messages.withdraw(STARTS_AGAIN);
}

/// Renders another bake of the scene. Materials that were edited stay.
fn show_baked(work: &mut Workspace, baked: Baked, is_draft: bool) {
    // The scene may have changed during its bake.
    let changed = work.scene.source.as_ref().filter(|source| source.hash != baked.dataset.scene_hash);
    let preview = changed.map(|source| source.unshadowed(&work.document.bake));
    work.take_materials_of(&preview.as_ref().unwrap_or(&baked).dataset);
    // The picture needs the hierarchies at once, at full priority.
    baked.begin();
    (work.scene.baked, work.scene.preview) = (Some(baked), preview);
    (work.scene.is_draft, work.scene.show_stale) = (is_draft, false);
}
