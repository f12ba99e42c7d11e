//! A requested ground: shown at once without shadows, then baked.

use super::state::{Asker, BakeOrder, Baking, From};
use crate::workspace::Workspace;
use lapidary_core::ground::Ground;
use lapidary_render::Baked;

impl Baking {
    /// Shows a requested ground that the bake lacks: at once without shadows, then baked. Hides a ground that is no longer wanted,
    /// even if the bake has one.
    pub fn follow_ground(&mut self, work: &mut Workspace) {
        let ground = work.document.bake.ground;
        let Some(source) = work.scene.source.clone().filter(|_| !work.scene.show_stale) else { return };
        let suits = |baked: &Baked| ground == Ground::Off || baked.has_ground();
        let is_current = !work.scene.is_stale();
        if let Some(baked) = work.scene.baked.clone().filter(|baked| is_current && suits(baked)) {
            if work.scene.preview.is_some() {
                work.take_materials_of(&baked.dataset);
                work.scene.preview = None;
            }
            self.wants_ground = false;
            return self.bake_ground(work);
        }
        let is_lit_alike =
            |preview: &Baked| preview.dataset.settings.mode.environment() == work.document.bake.mode.environment();
        if !work.scene.preview.as_ref().is_some_and(|preview| suits(preview) && is_lit_alike(preview)) {
            let preview = source.unshadowed(&work.document.bake);
            work.take_materials_of(&preview.dataset);
            work.scene.preview = Some(preview);
            self.wants_ground = is_current && work.preferences.bakes_scenes;
        }
        self.bake_ground(work);
    }

    /// Begins a bake for a wanted ground. A running automatic bake without one is canceled first, and the next takes the settings
    /// chosen by then; a bake that the user asked for is finished first.
    fn bake_ground(&mut self, work: &mut Workspace) {
        let wants_ground = self.wants_ground && work.document.bake.ground != Ground::Off;
        match &self.run {
            Some(run) if run.has_ground => self.wants_ground = false,
            Some(run) if wants_ground && run.asked_by == Asker::Nobody && !run.job.is_cancelling() => {
                self.cancel();
                self.begins_anew = true;
            }
            None if wants_ground || self.begins_anew => {
                (self.wants_ground, self.begins_anew) = (false, false);
                self.bake(work, BakeOrder { asked_by: Asker::Nobody, from: From::Beginning, draft_first: true });
            }
            _ => {}
        }
    }
}
