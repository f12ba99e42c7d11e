//! Changes of the document, as steps of undo.

use super::Workspace;
use crate::document::Edit;

impl Workspace {
    /// Changes the document; edits of one gesture are one step of undo.
    pub fn edit(&mut self, edit: Edit, label: &'static str) {
        let (before, is_look) = (self.material_of_selected_part(), matches!(edit, Edit::Look(_)));
        self.history.apply(&mut self.document, edit, label);
        if is_look {
            self.follow_selected_part(before);
        }
    }

    /// An edit that is a step of undo by itself.
    pub fn do_step(&mut self, edit: Edit, label: &'static str) {
        self.history.end_gesture();
        self.history.apply(&mut self.document, edit, label);
        self.history.end_gesture();
    }

    /// Undoes the last step.
    pub fn undo(&mut self) {
        let before = self.material_of_selected_part();
        if let Some(name) = self.history.undo(&mut self.document) {
            self.messages.remark(format!("Undone: {name}"));
            self.follow_selected_part(before);
        }
    }

    /// Repeats the step last undone.
    pub fn redo(&mut self) {
        let before = self.material_of_selected_part();
        if let Some(name) = self.history.redo(&mut self.document) {
            self.messages.remark(format!("Redone: {name}"));
            self.follow_selected_part(before);
        }
    }

    fn material_of_selected_part(&self) -> Option<usize> {
        self.selection.part.map(|part| self.document.material_of(part))
    }

    /// Selects the material of the selected part if it has changed, and none that is gone.
    fn follow_selected_part(&mut self, before: Option<usize>) {
        let now = self.material_of_selected_part();
        if now != before {
            self.selection.material = now;
        }
        self.selection.material = self.selection.material.filter(|&index| index < self.document.materials.len());
    }
}
