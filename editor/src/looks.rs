//! Looks: their tab in the window with small pictures of them, and files of them.

pub mod command;
mod panel;
mod picture;
mod thumbnails;

pub use panel::{LooksContext, LooksPanel, show};
pub use picture::{Maps, PictureOfDocument, file_names};

use crate::{
    actions::Action,
    document::{
        Document, Edit,
        looks::{LookPart, LookState, NamedLook},
    },
};

/// Puts a look of the document in place, or a part of it, as one step of undo.
pub fn show_look(document: &Document, look: usize, part: LookPart) -> Vec<Action> {
    let Some(look) = document.looks.get(look) else { return Vec::new() };
    step(Edit::Look(look.state.part(part).into()), "Look")
}

/// Adds a look of what the document shows.
pub fn add_look(document: &Document) -> Vec<Action> {
    let look = NamedLook { name: document.free_look_name(), state: LookState::of(document) };
    let looks = document.looks.iter().cloned().chain([look]).collect();
    step(Edit::Looks(looks), "Add look")
}

fn step(edit: Edit, label: &'static str) -> Vec<Action> {
    vec![Action::EndGesture, Action::Edit { edit, label }, Action::EndGesture]
}
