//! Poses of the selected objects, relative to the scene file.

use super::SceneContext;
use crate::{
    actions::{Action, PoseAction},
    document::Edit,
    viewport::{
        gizmo::{Movable, Pivot, Subject, Tool},
        object_menu,
    },
    widgets::{
        Edited, Number, edit_row,
        entries::{Decades, combo_row, decades_row, point_row, turns_row},
        note, section, slider_row,
    },
};
use egui::{Button, Ui};
use lapidary_core::scene::pose::{MOST_SCALE, Pose};

/// Shows the pose of the active object, and edits it together with all selected objects.
pub fn show(ui: &mut Ui, pivot: &mut Pivot, context: &SceneContext, actions: &mut Vec<Action>) {
    if context.posable.is_empty() {
        locked_note(ui, context, actions);
        return;
    }
    section(ui, "Pose", true, |ui| {
        own_pivot(ui, context, actions);
        if context.posable.len() > 1 {
            pivot_row(ui, pivot, context.posable.len());
        }
        hinge_row(ui, *pivot, context, actions);
        rows(ui, *pivot, context, actions);
        reset_button(ui, context, actions);
    });
}

/// Says that a locked object cannot be posed.
fn locked_note(ui: &mut Ui, context: &SceneContext, actions: &mut Vec<Action>) {
    let locked = context.selected_object.filter(|&object| context.document.handling_of(object).locked);
    let Some(object) = locked else { return };
    section(ui, "Pose", true, |ui| {
        note(ui, "This object is locked: clicks in the picture go through it, and it keeps its pose");
        if ui.button("Unlock").clicked() {
            actions.extend(object_menu::lock(context.document, &[object], false));
        }
    });
}

/// The pivot placed on the active object.
fn own_pivot(ui: &mut Ui, context: &SceneContext, actions: &mut Vec<Action>) {
    let Some(&Subject { object, .. }) = context.posable.first() else { return };
    let pivot = context.document.handling_of(object).pivot;
    ui.horizontal_wrapped(|ui| {
        let place = ui.add(Button::new("Place pivot").selected(context.placing_pivot));
        let help =
            "Click an edge in the picture to turn the object about it, as a lid about its hinge, or any other point";
        if place.on_hover_text(help).clicked() {
            actions.push(Action::Pose(PoseAction::AskForPivot));
        }
        if ui.add_enabled(pivot.is_some(), Button::new("Pivot to center")).clicked() {
            actions.extend(object_menu::pivot_to_center(context.document, &[object]));
        }
    });
}

/// The pivot of several objects.
fn pivot_row(ui: &mut Ui, pivot: &mut Pivot, selected: usize) {
    let help = "Point about which the selected objects turn and scale.";
    // The pivot is state of the interface, without undo.
    let _ = combo_row(ui, "Pivot", help, pivot, &Pivot::CHOICES);
    note(ui, &format!("Values of the object selected last; all {selected} follow"));
}

fn reset_button(ui: &mut Ui, context: &SceneContext, actions: &mut Vec<Action>) {
    let objects: Vec<u32> = context.posable.iter().map(|subject| subject.object).collect();
    let edit = object_menu::as_in_file(context.document, &objects);
    let reset = ui.add_enabled(edit.changes(context.document), Button::new("Reset pose"));
    if reset.on_hover_text("Restore the poses that the scene file gives all selected objects").clicked() {
        actions.extend([Action::Edit { edit, label: "Reset pose of" }, Action::EndGesture]);
    }
}

fn rows(ui: &mut Ui, pivot: Pivot, context: &SceneContext, actions: &mut Vec<Action>) {
    let mut row = |tool: Tool, add: &mut dyn FnMut(&mut Ui, &mut Pose) -> Edited| {
        pose_row(tool, pivot, context, actions, |pose| add(ui, pose));
    };
    let help = "Offset from the position in the scene file, in meters.";
    row(Tool::Move, &mut |ui, pose| point_row(ui, "Move", help, &mut pose.translate));
    let help = "Rotation about the pivot in degrees: first about X, then Y, then Z.";
    row(Tool::Turn, &mut |ui, pose| turns_row(ui, "Turn", help, &mut pose.rotate_degrees));
    let range = f64::from(1.0 / MOST_SCALE)..=f64::from(MOST_SCALE);
    let scale = Decades::count("Scale", "Scale about the pivot; 1 is the size in the scene file.", range, 1.0);
    row(Tool::Scale, &mut |ui, pose| decades_row(ui, &Decades { decimals: 3, ..scale.clone() }, &mut pose.scale));
}

/// The angle by which the active object is open about its hinge, if it has one.
fn hinge_row(ui: &mut Ui, pivot: Pivot, context: &SceneContext, actions: &mut Vec<Action>) {
    let own = context.posable.first().and_then(|active| active.hinge);
    let Some(hinge) = own.filter(|_| pivot != Pivot::Selection) else { return };
    let angle = Number::new("Hinge", "Turn about the hinge in degrees; 0 as in the scene file.", -180.0..=180.0, 0.0);
    let angle = angle.unit("°", 1);
    pose_row(Tool::Turn, pivot, context, actions, |pose| {
        let before = pose.degrees_about(hinge);
        let mut degrees = before;
        let edited = slider_row(ui, &angle, &mut degrees);
        *pose = pose.turned_about(hinge, degrees - before);
        edited
    });
}

/// One row with a number of the active object's pose. The tool applies its change to all.
fn pose_row(
    tool: Tool,
    pivot: Pivot,
    context: &SceneContext,
    actions: &mut Vec<Action>,
    add: impl FnOnce(&mut Pose) -> Edited,
) {
    let Some((&active, others)) = context.posable.split_first() else { return };
    let movable = Movable { active, others: others.to_vec(), pivot, tool };
    let poses = &context.document.poses;
    edit_row(actions, tool.verb(), &movable.poses(poses), Edit::Poses, |all| {
        let mut typed = poses.of(active.object);
        let mut edited = add(&mut typed);
        if edited.changed {
            *all = movable.typed(poses, typed);
            edited.changed = all.values().all(|pose| pose.validate("").is_ok());
        }
        edited
    });
}
