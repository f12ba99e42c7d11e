//! The ladder of cut sizes: started on request, shown in its own window; one click chooses a size, or lit cuts.

use super::{
    panel::{self, LadderResult},
    state::LadderWindow,
};
use crate::{
    actions::{Action, LadderAction},
    document::{Edit, ViewSettings},
    picture::Picture,
    workspace::Workspace,
};
use egui::{Context, Window};
use lapidary_studies::{jobs::ladder::LadderJob, ladder::Cuts};

impl LadderWindow {
    /// Performs an action.
    pub fn perform(&mut self, work: &mut Workspace, picture: &Picture, action: LadderAction) {
        match action {
            LadderAction::Start => self.start(work, picture),
            LadderAction::UseCuts(cuts) => use_cuts(work, cuts),
        }
    }

    /// Starts the ladder for the shown picture.
    fn start(&mut self, work: &mut Workspace, picture: &Picture) {
        let Some(asked) = picture.asked(work).cloned() else {
            work.messages.warning("There is no picture to try cut sizes on; open and bake a scene first");
            return;
        };
        let job = LadderJob::start(work.factory.clone(), asked.baked, asked.look, work.wake.clone());
        *self = Self { job: Some(job), result: LadderResult::default(), open: true };
    }

    /// Takes results. Closing the window ends the work.
    pub fn collect(&mut self, ctx: &Context) {
        let events = self.job.as_ref().map(LadderJob::events).unwrap_or_default();
        events.into_iter().for_each(|event| self.take(ctx, event));
        if !self.open {
            *self = Self::default();
        }
    }

    /// Shows the window, if it is open.
    pub fn show(&mut self, ctx: &Context, work: &Workspace, actions: &mut Vec<Action>) {
        if !self.open {
            return;
        }
        self.result.progress = self.job.as_ref().map(LadderJob::progress);
        let current = work.document.view.cuts();
        let shown = Window::new("Which cut size is enough?")
            .open(&mut self.open)
            .default_size(panel::SIZE)
            .min_width(panel::LEAST_WIDTH);
        shown.show(ctx, |ui| panel::show(ui, &self.result, current, actions));
    }

    /// Number of pictures with figures, once it has ended.
    #[cfg(test)]
    pub fn figures(&self) -> usize {
        let with_figures = self.result.tiles.iter().filter(|tile| tile.figures.is_some());
        if self.job.is_some() { 0 } else { with_figures.count() }
    }
}

/// Uses other cuts, as a step of undo, so that the viewport shows the chosen picture.
fn use_cuts(work: &mut Workspace, cuts: Cuts) {
    let before = work.document.view.clone();
    let settings = ViewSettings {
        sampling: cuts.sampling(),
        illum_cut: cuts.size().unwrap_or(before.illum_cut),
        tau: cuts.tau().unwrap_or(before.tau),
        ..before
    };
    work.do_step(Edit::View(settings), if cuts.size().is_some() { "Light cut" } else { "Lit cuts" });
}
