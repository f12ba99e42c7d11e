//! The comparison with a reference: it begins anew for another picture, and measures again when only the display
//! changes.

use super::state::{EditorState, pictures::Pictures};
use crate::panels::comparison::KindChoice;
use egui::Context;
use lapidary_studies::jobs::comparison::ComparisonEvent;
use std::path::PathBuf;

impl EditorState {
    /// Compares the picture that was asked for last, once nothing moves.
    pub(super) fn compare(&mut self) {
        let panel = &self.interface.comparison;
        if !panel.open || self.work.scene.rendered().is_none() {
            return self.comparison.end();
        }
        let Some(picture) = self.requests.last_sent().cloned() else { return };
        let moving = picture.moving;
        let Some(request) = panel.request(picture.baked, picture.look) else { return self.comparison.end() };
        if moving && !self.comparison.jobs().tracing.is_current(&request) {
            // Rays for the previous picture would only slow down the next one, for which it is no reference.
            self.comparison.jobs().tracing.stop();
            return self.comparison.forget();
        }
        if self.comparison.jobs().tracing.request(request) {
            self.comparison.forget();
        }
        self.comparison.measure(panel, self.work.document.view.post, self.work.viewport_size);
    }

    /// Takes what the comparison's threads have made.
    pub(super) fn collect_comparison(&mut self, ctx: &Context) {
        let Some(jobs) = &mut self.comparison.jobs else { return };
        let (traced, measured) = (jobs.tracing.events(), jobs.measuring.events());
        for event in traced {
            self.comparison.pictures += 1;
            match event {
                ComparisonEvent::Test(test) => self.comparison.test = Some(test),
                ComparisonEvent::Reference(reference) => self.comparison.reference = Some(reference),
                ComparisonEvent::Failed(text) => self.comparison.trace_problem = Some(text),
                ComparisonEvent::Remark(text) => self.work.messages.warning(text),
            }
        }
        let generation = self.comparison.generation;
        let current = measured.into_iter().filter(|(of, _)| *of == generation);
        current.for_each(|(_, event)| self.comparison.take_measured(ctx, event));
    }

    /// Begins or ends the comparison; there must be a picture to begin it.
    pub(super) fn toggle_comparison(&mut self) {
        if !self.interface.comparison.open && !self.can_compare() {
            self.work.messages.warning("There is no picture to compare; open and bake a scene first");
            return;
        }
        let panel = &mut self.interface.comparison;
        (panel.open, panel.tool) = (!panel.open, None);
    }

    /// Compares with a picture file from now on.
    pub(super) fn choose_reference(&mut self, path: PathBuf) {
        let panel = &mut self.interface.comparison;
        (panel.open, panel.kind, panel.file) = (true, KindChoice::File, Some(path));
        // The same file may have been written again.
        self.comparison.end();
    }

    /// Whether there is a picture to compare.
    pub(super) fn can_compare(&self) -> bool {
        self.work.scene.rendered().is_some() && Pictures::shown(&self.pictures).is_some()
    }
}
