//! Follows the picture: the comparison restarts for another picture, and measures again when only the display changes.

use super::{
    panel::KindChoice,
    state::{Comparison, Followed},
};
use crate::{
    actions::CompareAction,
    document::looks::LookState,
    looks::{Maps, PictureOfDocument},
    picture::Picture,
    workspace::Workspace,
};
use anyhow::Result;
use egui::Context;
use lapidary_core::scene::pose::Poses;
use lapidary_render::{Baked, Look};
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
            CompareAction::Look(look) => self.choose_look(work, look),
            // The path is asked for first.
            CompareAction::Reference(None) => {}
        }
    }

    /// Compares the picture requested last, once nothing moves.
    pub fn follow(&mut self, work: &Workspace, picture: &Picture) {
        self.follow_look(work);
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

    /// Compares with a look of the document from now on.
    fn choose_look(&mut self, work: &Workspace, look: usize) {
        let Some(look) = work.document.looks.get(look) else { return };
        let panel = &mut self.panel;
        (panel.open, panel.kind, panel.look) = (true, KindChoice::Look, Some((look.name.clone(), None)));
        self.end();
    }

    /// Takes the chosen look as it is now, of the shown bake. One that is gone is compared with no more.
    fn follow_look(&mut self, work: &Workspace) {
        let panel = &mut self.panel;
        let Some((name, made)) = panel.look.as_mut().filter(|_| panel.kind == KindChoice::Look) else { return };
        let Some((look, baked)) = work.document.look(name).zip(work.scene.rendered()) else {
            (panel.kind, panel.look) = (KindChoice::default(), None);
            return;
        };
        let is_it = |known: &Followed| known.state == look.state && known.baked.is_same(baked);
        if made.is_some() && self.followed.as_ref().is_some_and(is_it) {
            return;
        }
        self.looks_asked += 1;
        *made = Some(OtherLook { number: self.looks_asked, make: made_once(work, baked, &look.state) });
        self.followed = Some(Followed { state: look.state.clone(), baked: baked.clone() });
    }

    /// Compares with a picture file from now on.
    fn choose_reference(&mut self, path: PathBuf) {
        let panel = &mut self.panel;
        (panel.open, panel.kind, panel.file) = (true, KindChoice::File, Some(path));
        // The same file may have been written again.
        self.end();
    }
}

/// Makes what renderers show of a look when it is first asked for, and keeps it, also when the camera moves.
fn made_once(work: &Workspace, baked: &Baked, look: &LookState) -> Arc<dyn Fn() -> Result<Look> + Send + Sync> {
    // View and poses are those of the picture.
    let (poses, size) = (Poses::default(), work.viewport_size);
    let shown = PictureOfDocument { document: work.document.clone(), baked: baked.clone(), poses, size, aa: None };
    let (picture, made) = (shown.with_look(look), Mutex::new(None));
    Arc::new(move || {
        let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
        let look = made.take().map_or_else(|| picture.look(&mut Maps::default()), Ok)?;
        Ok(made.insert(look).clone())
    })
}
