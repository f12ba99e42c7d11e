//! Where the selected objects are, relative to where their file has them.

use super::SceneContext;
use crate::{
    actions::Action,
    document::Edit,
    panels::{
        edit_row,
        entries::{Decades, combo_row, decades_row, point_row, turns_row},
        widgets::{Edited, note, section},
    },
    viewport::gizmo::Pivot,
};
use egui::Ui;
use lapidary_core::scene::pose::{MOST_SCALE, Pose};

/// Shows the pose of the active object, and what is common to all that are selected; a ground has none.
pub fn show(ui: &mut Ui, pivot: &mut Pivot, context: &SceneContext, actions: &mut Vec<Action>) {
    let ground = context.dataset.and_then(|dataset| dataset.scene.mesh.ground_object());
    let objects = context.document.objects.len();
    let can_be_posed = |object: &u32| (*object as usize) < objects && Some(*object) != ground;
    let Some(active) = context.selected_object.filter(can_be_posed) else { return };
    let others = context.other_objects.iter().copied().filter(can_be_posed);
    let selected: Vec<u32> = [active].into_iter().chain(others).collect();
    section(ui, "Pose", true, |ui| {
        if selected.len() > 1 {
            pivot_row(ui, pivot, selected.len());
        }
        rows(ui, active, &context.document.poses.of(active), actions);
        reset_button(ui, &selected, context, actions);
    });
}

/// A choice of what several objects turn and scale about.
fn pivot_row(ui: &mut Ui, pivot: &mut Pivot, selected: usize) {
    let help = "What the handles turn and scale the selected objects about.";
    // The interface keeps it, and no step of undo.
    let _ = combo_row(ui, "Pivot", help, pivot, &Pivot::CHOICES);
    note(ui, &format!("Handles move all {selected} objects; the numbers are of the one selected last"));
}

fn reset_button(ui: &mut Ui, selected: &[u32], context: &SceneContext, actions: &mut Vec<Action>) {
    let edit = Edit::Poses(selected.iter().map(|&object| (object, Pose::AS_BAKED)).collect());
    let reset = ui.add_enabled(edit.changes(context.document), egui::Button::new("Reset pose"));
    if reset.on_hover_text("Puts all selected objects back to where their file has them").clicked() {
        actions.extend([Action::Edit { edit, label: "Reset pose" }, Action::EndGesture]);
    }
}

fn rows(ui: &mut Ui, object: u32, pose: &Pose, actions: &mut Vec<Action>) {
    let mut row = |label, add: &mut dyn FnMut(&mut Ui, &mut Pose) -> Edited| {
        edit_row(
            actions,
            label,
            pose,
            |pose| Edit::pose(object, pose),
            |pose| {
                let mut edited = add(ui, pose);
                edited.changed &= pose.validate("").is_ok();
                edited
            },
        );
    };
    let help = "How far the object is from where its file has it, in meters.";
    row("Move object", &mut |ui, pose| point_row(ui, "Move", help, &mut pose.translate));
    let help = "Turns about the object's center, in degrees: first about X, then Y, then Z.";
    row("Turn object", &mut |ui, pose| turns_row(ui, "Turn", help, &mut pose.rotate_degrees));
    let range = f64::from(1.0 / MOST_SCALE)..=f64::from(MOST_SCALE);
    let scale = Decades::count("Scale", "Size about the object's center; 1 is as in the file.", range, 1.0);
    row("Scale object", &mut |ui, pose| decades_row(ui, &Decades { decimals: 3, ..scale.clone() }, &mut pose.scale));
}
