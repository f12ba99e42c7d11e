//! Views of a bake: all equally, or those that get most vertices.

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
    let present = "Puts most vertices where the camera looks now, for finer shadows and bounced light there.";
    let mut choices = vec![
        (Views::All, "All views", "Spreads vertices over all views equally."),
        (Views::Present, "This view", present),
    ];
    if !document.bookmarks.is_empty() {
        choices.push((
            Views::Bookmarked,
            "Bookmarked views",
            "Puts most vertices where the views of Scene > Cameras look.",
        ));
    }
    if chosen == Views::Others {
        let name = if document.bake.shots.len() == 1 { "Another view" } else { "Other views" };
        choices.push((Views::Others, name, "The view chosen earlier, or the views of the command line."));
    }
    if combo_row(ui, "Views", "Views that get most vertices.", &mut chosen, &choices).changed {
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
