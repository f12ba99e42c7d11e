//! A row that edits the document, as a step of undo.

use super::Edited;
use crate::{actions::Action, document::Edit};

/// Shows `row` on a copy of `value`. If it changed the copy, requests the `edit`; if the gesture ended, reports that.
pub fn edit_row<T: Clone>(
    actions: &mut Vec<Action>,
    label: &'static str,
    value: &T,
    edit: impl FnOnce(T) -> Edit,
    row: impl FnOnce(&mut T) -> Edited,
) {
    let mut copy = value.clone();
    let edited = row(&mut copy);
    if edited.changed {
        actions.push(Action::Edit { edit: edit(copy), label });
    }
    if edited.ended {
        actions.push(Action::EndGesture);
    }
}
