//! The menu of the selected objects, in the list and over the picture.

use crate::{
    actions::{Action, CameraAction, PoseAction},
    document::{Document, Edit},
};
use egui::{Button, Ui};
use lapidary_core::scene::pose::Pose;

/// Shows the menu of objects that can be posed, unless they are locked: the active one first. Without any it is that of the scene.
pub fn show(ui: &mut Ui, document: &Document, objects: &[u32], actions: &mut Vec<Action>) {
    let mut entry = |ui: &mut Ui, label: &str, is_enabled: bool, asked: &dyn Fn() -> Vec<Action>| {
        if ui.add_enabled(is_enabled, Button::new(label)).clicked() {
            actions.extend(asked());
            ui.close();
        }
    };
    let Some(&active) = objects.first() else {
        entry(ui, "Frame all", true, &|| vec![Action::Camera(CameraAction::FrameAll)]);
        let hidden: Vec<u32> = document.poses.hidden().collect();
        entry(ui, "Show all objects", !hidden.is_empty(), &|| step(document.hiding(hidden.clone(), false), "Show"));
        return;
    };
    match objects.len() {
        1 => ui.strong(document.object_name(active)),
        count => ui.strong(format!("{count} objects")),
    };
    ui.separator();
    let (is_hidden, handling) = (document.poses.of(active).hidden, document.handling_of(active));
    entry(ui, "Frame", true, &|| vec![Action::Camera(CameraAction::FrameSelection)]);
    let label = if is_hidden { "Show" } else { "Hide" };
    entry(ui, label, true, &|| step(document.hiding(objects.to_vec(), !is_hidden), label));
    entry(ui, "Isolate, or end it", true, &|| vec![Action::Pose(PoseAction::Isolate(objects.to_vec()))]);
    entry(ui, if handling.locked { "Unlock" } else { "Lock" }, true, &|| lock(document, objects, !handling.locked));
    ui.separator();
    entry(ui, "Place pivot by click", !handling.locked, &|| vec![Action::Pose(PoseAction::AskForPivot)]);
    entry(ui, "Pivot to center", handling.pivot.is_some(), &|| pivot_to_center(document, objects));
    let reset = as_in_file(document, objects);
    entry(ui, "Reset pose", !handling.locked && reset.changes(document), &|| step(reset.clone(), "Reset pose of"));
}

/// Locks objects or unlocks them, as one step of undo.
pub fn lock(document: &Document, objects: &[u32], locked: bool) -> Vec<Action> {
    let handling = document.with_handling(objects.iter().copied(), |handling| handling.locked = locked);
    step(Edit::Handling(handling), if locked { "Lock" } else { "Unlock" })
}

/// Takes away the pivots placed on objects.
pub fn pivot_to_center(document: &Document, objects: &[u32]) -> Vec<Action> {
    let handling = document.with_handling(objects.iter().copied(), |handling| handling.pivot = None);
    step(Edit::Handling(handling), "Pivot to center")
}

/// The poses of the scene file for objects, which stay hidden or shown.
pub fn as_in_file(document: &Document, objects: &[u32]) -> Edit {
    let pose = |object: u32| Pose { hidden: document.poses.of(object).hidden, ..Pose::AS_BAKED };
    Edit::Poses(objects.iter().map(|&object| (object, pose(object))).collect())
}

fn step(edit: Edit, label: &'static str) -> Vec<Action> {
    vec![Action::Edit { edit, label }, Action::EndGesture]
}
