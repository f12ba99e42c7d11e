//! Which views a bake is for: all alike, or those that most vertices are meant for.

use crate::{
    actions::{Action, BakeAction},
    document::Document,
    widgets::entries::combo_row,
};
use egui::Ui;
use lapidary_core::camera::Camera;

/// A choice of views.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Views {
    All,
    Present,
    Bookmarked,
    Others,
}

/// The choice.
pub fn show(ui: &mut Ui, document: &Document, actions: &mut Vec<Action>) {
    let mut chosen = chosen(document);
    let present = "Most vertices go where the camera looks now: shadows and bounced light are finer there. Other views get the rest.";
    let mut choices =
        vec![(Views::All, "All views", "All views get vertices alike."), (Views::Present, "This view", present)];
    if !document.bookmarks.is_empty() {
        choices.push((
            Views::Bookmarked,
            "Bookmarked views",
            "Most vertices go where the views of Scene > Cameras look.",
        ));
    }
    if chosen == Views::Others {
        let name = if document.bake.shots.len() == 1 { "Another view" } else { "Other views" };
        choices.push((
            Views::Others,
            name,
            "The camera as it was when this was chosen, or the views given on the command line.",
        ));
    }
    if combo_row(ui, "For", "Which views the bake is for.", &mut chosen, &choices).changed {
        match chosen {
            Views::All => actions.push(Action::Bake(BakeAction::ForViews(Vec::new()))),
            Views::Present => actions.push(Action::Bake(BakeAction::ForViews(vec![document.camera.clone()]))),
            Views::Bookmarked => actions.push(Action::Bake(BakeAction::ForViews(document.bookmarks.clone()))),
            Views::Others => {}
        }
    }
}

fn chosen(document: &Document) -> Views {
    let are_of = |cameras: &[Camera]| document.bake.shots.iter().map(|shot| &shot.camera).eq(cameras);
    match document.bake.shots.len() {
        0 => Views::All,
        _ if are_of(std::slice::from_ref(&document.camera)) => Views::Present,
        _ if are_of(&document.bookmarks) => Views::Bookmarked,
        _ => Views::Others,
    }
}
