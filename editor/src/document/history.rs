//! Undo and redo: a list of edits, each of which holds the value that the document does not have now.

use super::{Document, Edit, objects::ObjectNumbers, parts::Renumbering};
use lapidary_core::material::Material;
use std::collections::VecDeque;

/// Most steps, more than anyone undoes by hand; the oldest is removed first. A step holds one value: some kB, or all looks.
const DEPTH: usize = 1000;

/// The edits of a document in their order, and where in it the document was saved.
///
/// Every state of the document has its own number, so a saved state that is lost with its redo branch is never confused with
/// another.
#[derive(Clone, Debug, Default)]
pub struct History {
    done: VecDeque<Step>,
    undone: Vec<Step>,
    /// The last step absorbs further edits of its kind.
    gesture_open: bool,
    state: u64,
    saved: Option<u64>,
    last_state: u64,
    revision: u64,
}

/// An edit, and the states of the document before and after it.
#[derive(Clone, Debug)]
struct Step {
    edit: Edit,
    label: &'static str,
    before: u64,
    after: u64,
}

impl Step {
    fn name(&self, document: &Document) -> String {
        self.edit.name(self.label, document)
    }
}

impl History {
    /// For a document that agrees with its file, or has no file and no changes.
    pub fn new() -> Self {
        Self { saved: Some(0), ..Self::default() }
    }

    /// For a document with unsaved changes, as after recovery.
    pub fn unsaved() -> Self {
        Self::default()
    }

    /// Performs an edit. It joins the last step if that has the same label and target and its gesture continues. An
    /// edit that changes nothing, or that names a missing material, is ignored.
    pub fn apply(&mut self, document: &mut Document, mut edit: Edit, label: &'static str) {
        if !edit.changes(document) {
            return;
        }
        let joins = self.joins(&edit, label);
        edit.swap(document);
        self.undone.clear();
        self.revision += 1;
        self.last_state += 1;
        let before = std::mem::replace(&mut self.state, self.last_state);
        if joins {
            self.extend_last_step(document);
        } else {
            self.push(Step { edit, label, before, after: self.state });
        }
    }

    fn joins(&self, edit: &Edit, label: &'static str) -> bool {
        let same = |step: &Step| step.label == label && step.edit.same_target(edit);
        self.gesture_open && self.done.back().is_some_and(same)
    }

    fn push(&mut self, step: Step) {
        self.gesture_open = true;
        self.done.push_back(step);
        if self.done.len() > DEPTH {
            self.done.pop_front();
        }
    }

    /// The last step keeps the value from before the gesture; a gesture that returns to it leaves no step.
    fn extend_last_step(&mut self, document: &Document) {
        let Some(step) = self.done.back_mut() else { return };
        step.after = self.state;
        if !step.edit.changes(document) {
            self.state = step.before;
            self.done.pop_back();
            self.gesture_open = false;
        }
    }

    /// Visits the materials of all steps, for files that are reloaded.
    pub fn visit_materials(&mut self, visit: &mut dyn FnMut(&mut Material)) {
        self.edits_mut().for_each(|edit| edit.visit_materials(visit));
    }

    /// Renumbers the materials that its steps name or hold, in a document whose materials are `now`.
    pub fn renumber_materials(&mut self, renumbering: &Renumbering, now: &[Material]) {
        self.edits_mut().for_each(|edit| edit.renumber_materials(renumbering, now));
    }

    /// Renumbers the objects that its steps name. Undo skips a step whose objects are all gone.
    pub fn renumber_objects(&mut self, numbers: &ObjectNumbers) {
        self.edits_mut().for_each(|edit| edit.renumber_objects(numbers));
    }

    fn edits_mut(&mut self) -> impl Iterator<Item = &mut Edit> {
        self.done.iter_mut().chain(&mut self.undone).map(|step| &mut step.edit)
    }

    /// The next edit begins a new step.
    pub fn end_gesture(&mut self) {
        self.gesture_open = false;
    }

    /// Takes back the last step. Returns its name.
    pub fn undo(&mut self, document: &mut Document) -> Option<String> {
        self.gesture_open = false;
        while let Some(mut step) = self.done.pop_back() {
            if swap(&mut step, document) {
                self.arrive_at(step.before);
                let name = step.name(document);
                self.undone.push(step);
                return Some(name);
            }
        }
        None
    }

    /// Does the last undone step again. Returns its name.
    pub fn redo(&mut self, document: &mut Document) -> Option<String> {
        self.gesture_open = false;
        while let Some(mut step) = self.undone.pop() {
            if swap(&mut step, document) {
                self.arrive_at(step.after);
                let name = step.name(document);
                self.done.push_back(step);
                return Some(name);
            }
        }
        None
    }

    fn arrive_at(&mut self, state: u64) {
        self.state = state;
        self.revision += 1;
    }

    /// Name of the edit that [`Self::undo`] would revert.
    pub fn undo_name(&self, document: &Document) -> Option<String> {
        self.done.back().map(|step| step.name(document))
    }

    /// Name of the edit that [`Self::redo`] would repeat.
    pub fn redo_name(&self, document: &Document) -> Option<String> {
        self.undone.last().map(|step| step.name(document))
    }

    /// The document was saved in its present state. Ends the gesture, so that undo can return to that state.
    pub fn mark_saved(&mut self) {
        self.gesture_open = false;
        self.saved = Some(self.state);
    }

    /// Whether the document is in another state than when it was saved.
    pub fn is_modified(&self) -> bool {
        self.saved != Some(self.state)
    }

    /// Another number after every change of the document.
    pub fn revision(&self) -> u64 {
        self.revision
    }
}

/// Swaps a step's value with the document's, unless the document was replaced by one without the step's target. Returns
/// whether it did.
fn swap(step: &mut Step, document: &mut Document) -> bool {
    let fits = step.edit.fits(document);
    if fits {
        step.edit.swap(document);
    }
    fits
}

#[cfg(test)]
mod tests;
