//! The panels around the viewport. They read the document and return their requests as actions.

pub mod bake;
pub mod comparison;
mod entries;
pub mod environment;
pub mod explain;
pub mod ladder;
pub mod lights;
pub mod material;
pub mod scene;
pub mod timeline;
pub mod units;
pub mod view;
pub mod widgets;

use crate::{actions::Action, document::Edit};
use widgets::Edited;

/// Shows `row` on a copy of `value`. If it changed the copy, asks for the `edit`; if the gesture ended, says so.
fn edit_row<T: Clone>(
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
