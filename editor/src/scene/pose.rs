//! Poses of the selected objects, relative to the scene file.

use super::SceneContext;
use crate::{
    actions::Action,
    document::Edit,
    viewport::gizmo::{Movable, Pivot, Subject, Tool},
    widgets::{
        Edited, edit_row,
        entries::{Decades, combo_row, decades_row, point_row, turns_row},
        note, section,
    },
};
use egui::Ui;
use lapidary_core::scene::pose::{MOST_SCALE, Pose};

/// Shows the pose of the active object, and edits it together with all selected objects.
pub fn show(ui: &mut Ui, pivot: &mut Pivot, context: &SceneContext, actions: &mut Vec<Action>) {
    if context.posable.is_empty() {
        return;
    }
    section(ui, "Pose", true, |ui| {
        if context.posable.len() > 1 {
            pivot_row(ui, pivot, context.posable.len());
        }
        rows(ui, *pivot, context, actions);
        reset_button(ui, context, actions);
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
    let hidden = |object: u32| context.document.poses.of(object).hidden;
    let as_in_file = |&Subject { object, .. }: &Subject| (object, Pose { hidden: hidden(object), ..Pose::AS_BAKED });
    let edit = Edit::Poses(context.posable.iter().map(as_in_file).collect());
    let reset = ui.add_enabled(edit.changes(context.document), egui::Button::new("Reset pose"));
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
    let help = "Rotation about the object's center in degrees: first about X, then Y, then Z.";
    row(Tool::Turn, &mut |ui, pose| turns_row(ui, "Turn", help, &mut pose.rotate_degrees));
    let range = f64::from(1.0 / MOST_SCALE)..=f64::from(MOST_SCALE);
    let scale =
        Decades::count("Scale", "Scale about the object's center; 1 is the size in the scene file.", range, 1.0);
    row(Tool::Scale, &mut |ui, pose| decades_row(ui, &Decades { decimals: 3, ..scale.clone() }, &mut pose.scale));
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
