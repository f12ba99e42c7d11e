//! A bake after an edit: cuts are baked anew where it reaches, by itself once a move is over, or when the user asks for a bake.

use super::{
    parts::described,
    state::{Asker, Baking, Run},
};
use crate::{
    control_names::control_name,
    workspace::{Workspace, Written},
};
use lapidary_core::{ground::Ground, scene::Scene};
use lapidary_render::Baked;
use lapidary_studies::jobs::bake::{BakeRun, UpdateTask};
use std::path::PathBuf;

impl Baking {
    /// Begins an update once a move is over, and ends one that another move has overtaken.
    pub fn follow_edits(&mut self, work: &mut Workspace, is_moving: bool) {
        let poses = &work.document.poses;
        let is_of_others =
            |run: &&mut Run| run.asked_by == Asker::Nobody && run.of_poses.as_ref().is_some_and(|of| of != poses);
        if let Some(run) = self.run.as_mut().filter(is_of_others)
            && !std::mem::replace(&mut run.is_overtaken, true)
        {
            run.job.cancel();
        }
        let is_idle = !is_moving && self.run.is_none() && self.refused.as_ref() != Some(&work.document.poses);
        if let Some(edited) = (is_idle && work.preferences.follows_edits).then(|| self.edited(work)).flatten() {
            self.begin_update(work, edited, None, Asker::Nobody);
        }
    }

    /// Begins an update in place of a whole bake, if the bake differs by an edit alone. Returns whether it did.
    pub(super) fn update_instead(&mut self, work: &mut Workspace, output: Option<&PathBuf>) -> bool {
        let Some((edited, output)) = self.edited(work).zip(output) else { return false };
        if self.run.is_none() && work.may_write(output, Written::Dataset) {
            self.begin_update(work, edited, Some(output.clone()), Asker::User);
        }
        true
    }

    fn begin_update(
        &mut self,
        work: &Workspace,
        (before, scene): (Baked, Scene),
        output: Option<PathBuf>,
        asked_by: Asker,
    ) {
        let settings = &before.dataset.settings;
        let (mode, has_ground) = (settings.mode, settings.ground != Ground::Off);
        let of_output = output.clone().unwrap_or_default();
        let task = UpdateTask { before: before.clone(), scene, output, turn: self.turn.clone(), name_of: control_name };
        let job = BakeRun::update(task, work.wake.clone());
        let of_poses = Some(work.document.poses.clone());
        let is_overtaken = false;
        self.run = Some(Run {
            job,
            mode,
            output: of_output,
            draft_shown: false,
            has_ground,
            asked_by,
            of_poses,
            is_overtaken,
            content: None,
        });
        (self.ended, self.whole) = (None, Some(before));
    }

    /// The whole bake behind the one on the screen, and its scene after the edits, if the screen's differs from the document by moved
    /// objects and opacities alone.
    fn edited(&self, work: &Workspace) -> Option<(Baked, Scene)> {
        let (document, scene) = (&work.document, &work.scene);
        let shown = scene.baked.as_ref().filter(|_| !scene.is_draft && scene.preview.is_none())?;
        let dataset = &shown.dataset;
        if document.poses == dataset.scene.placed_poses() && !document.lets_through_otherwise(&dataset.scene) {
            return None;
        }
        let is_of_file = scene.source.as_ref().is_none_or(|source| source.hash == dataset.scene_hash);
        let is_at_rest = document.clip_time.is_none() && dataset.scene.clip_time.is_none();
        if !is_of_file || !is_at_rest || described(&document.bake) != described(&dataset.settings) {
            return None;
        }
        let before = self.whole.as_ref().unwrap_or(shown);
        let mut edited = before.dataset.scene.clone();
        edited.place_again(&document.poses).ok()?;
        if document.lets_through_otherwise(&edited) {
            document.give_opacities(&mut edited);
        }
        Some((before.clone(), edited))
    }
}
