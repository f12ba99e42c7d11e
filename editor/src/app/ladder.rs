//! The ladder of cuts in the window: climbed on request, shown in its own window; one click chooses a size, or lit cuts.

use super::state::{EditorState, ladder::LadderWindow};
use crate::{
    actions::Action,
    document::{Edit, ViewSettings},
    panels::ladder::{self, LadderResult},
};
use egui::{Context, Window};
use lapidary_studies::{jobs::ladder::LadderJob, ladder::Cuts};

impl EditorState {
    /// Begins to climb for the picture that is shown.
    pub(super) fn start_ladder(&mut self) {
        let Some(picture) = self.requests.last_sent().filter(|_| self.can_compare()).cloned() else {
            self.work.messages.warning("There is no picture to try cut sizes on; open and bake a scene first");
            return;
        };
        let job = LadderJob::start(self.work.factory.clone(), picture.baked, picture.look, self.work.wake.clone());
        self.ladder = LadderWindow { job: Some(job), result: LadderResult::default(), open: true };
        self.hold_for_ladder();
    }

    /// While the ladder is climbed, comparison and full picture leave the cores to it, because the user waits for it
    /// and it measures times.
    fn hold_for_ladder(&self) {
        let climbing = self.ladder.is_climbing();
        self.render.hold(climbing);
        self.comparison.hold(climbing);
    }

    /// Other cuts, as a step of undo: then the viewport shows the picture that was chosen.
    pub(super) fn use_cuts(&mut self, cuts: Cuts) {
        let before = self.work.document.view.clone();
        let settings = ViewSettings {
            sampling: cuts.sampling(),
            illum_cut: cuts.size().unwrap_or(before.illum_cut),
            tau: cuts.tau().unwrap_or(before.tau),
            ..before
        };
        self.work.do_step(Edit::View(settings), if cuts.size().is_some() { "Light cut" } else { "Lit cuts" });
    }

    /// Takes what was found, and shows it. Closing the window ends the work.
    pub(super) fn show_ladder(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let window = &mut self.ladder;
        let events = window.job.as_ref().map(LadderJob::events).unwrap_or_default();
        events.into_iter().for_each(|event| window.take(ctx, event));
        if !window.open {
            *window = LadderWindow::default();
        }
        self.hold_for_ladder();
        let window = &mut self.ladder;
        if !window.open {
            return;
        }
        window.result.progress = window.job.as_ref().map(LadderJob::progress);
        let current = self.work.document.view.cuts();
        let shown = Window::new("Which cut size is enough?")
            .open(&mut window.open)
            .default_size(ladder::SIZE)
            .min_width(ladder::LEAST_WIDTH);
        shown.show(ctx, |ui| ladder::show(ui, &window.result, current, actions));
    }

    /// How many pictures have figures, once it has ended.
    #[cfg(test)]
    pub(super) fn ladder_figures(&self) -> usize {
        if self.ladder.job.is_some() {
            return 0;
        }
        self.ladder.result.tiles.iter().filter(|tile| tile.figures.is_some()).count()
    }
}
