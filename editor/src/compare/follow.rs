//! Follows the picture: the comparison restarts for another picture, and measures again when only the display changes.

use super::{panel::KindChoice, state::Comparison};
use crate::{
    actions::CompareAction,
    looks::{Maps, PictureOfDocument},
    picture::Picture,
    workspace::Workspace,
};
use egui::Context;
use lapidary_studies::jobs::comparison::{ComparisonEvent, OtherLook};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

impl Comparison {
    /// Performs an action.
    pub fn perform(&mut self, work: &mut Workspace, picture: &Picture, action: CompareAction) {
        match action {
            CompareAction::Toggle => self.toggle(work, picture),
            CompareAction::Reference(Some(path)) => self.choose_reference(path),
            CompareAction::Pause(paused) => self.pause(paused),
            // The path is asked for first, and looks need the picture.
            CompareAction::Reference(None) | CompareAction::Look(_) => {}
        }
    }

    /// Compares the picture requested last, once nothing moves.
    pub fn follow(&mut self, work: &Workspace, picture: &Picture) {
        let panel = &self.panel;
        if !panel.open || work.scene.rendered().is_none() {
            return self.end();
        }
        let Some(picture) = picture.requests.last_sent().cloned() else { return };
        let moving = picture.moving;
        let Some(request) = panel.request(picture.baked, picture.look) else { return self.end() };
        if moving && !self.jobs().tracing.is_current(&request) {
            // Rays for the previous picture would only slow down the next one, for which it is no reference.
            self.jobs().tracing.stop();
            return self.forget();
        }
        if self.jobs().tracing.request(request) {
            self.forget();
        }
        self.measure(work.document.view.post, work.viewport_size);
    }

    /// Takes results of the comparison's threads.
    pub fn collect(&mut self, work: &mut Workspace, ctx: &Context) {
        let Some(jobs) = &mut self.jobs else { return };
        let (traced, measured) = (jobs.tracing.events(), jobs.measuring.events());
        for event in traced {
            self.pictures += 1;
            match event {
                ComparisonEvent::Test(test) => self.test = Some(test),
                ComparisonEvent::Reference(reference) => self.reference = Some(reference),
                ComparisonEvent::Failed(text) => self.trace_problem = Some(text),
                ComparisonEvent::Remark(text) => work.messages.warning(text),
            }
        }
        let generation = self.generation;
        let current = measured.into_iter().filter(|(of, _)| *of == generation);
        current.for_each(|(_, event)| self.take_measured(ctx, event));
    }

    /// Begins or ends the comparison; there must be a picture to begin it.
    fn toggle(&mut self, work: &mut Workspace, picture: &Picture) {
        if !self.panel.open && !picture.can_be_compared(work) {
            work.messages.warning("There is no picture to compare; open and bake a scene first");
            return;
        }
        let panel = &mut self.panel;
        (panel.open, panel.tool) = (!panel.open, None);
    }

    /// Compares with a look from now on, made by this picture of it.
    pub fn compare_with_look(&mut self, name: &str, picture: PictureOfDocument) {
        self.looks_asked += 1;
        let made = Mutex::new(None);
        // It is made once, also when the camera moves.
        let make = move || {
            let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
            let look = made.take().map_or_else(|| picture.look(&mut Maps::default()), Ok)?;
            Ok(made.insert(look).clone())
        };
        let look = OtherLook { number: self.looks_asked, make: Arc::new(make) };
        let panel = &mut self.panel;
        // Both are by cuts, and as fast as the live picture.
        (panel.open, panel.kind, panel.scale) = (true, KindChoice::Look, 1);
        panel.look = Some((name.into(), look));
        self.end();
    }

    /// Compares with a picture file from now on.
    fn choose_reference(&mut self, path: PathBuf) {
        let panel = &mut self.panel;
        (panel.open, panel.kind, panel.file) = (true, KindChoice::File, Some(path));
        // The same file may have been written again.
        self.end();
    }
}
