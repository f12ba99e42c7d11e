//! Where the selected object is, relative to where its file has it.

use super::SceneContext;
use crate::{
    actions::Action,
    document::Edit,
    panels::{
        edit_row,
        entries::{Decades, decades_row, point_row, turns_row},
        widgets::{Edited, section},
    },
};
use egui::Ui;
use lapidary_core::scene::pose::{MOST_SCALE, Pose};

/// Shows the pose of the selected object; a ground has none.
pub fn show(ui: &mut Ui, context: &SceneContext, actions: &mut Vec<Action>) {
    let ground = context.dataset.and_then(|dataset| dataset.scene.mesh.ground_object());
    let objects = context.document.objects.len();
    let Some(object) = context.selected_object.filter(|&o| (o as usize) < objects && Some(o) != ground) else { return };
    let pose = context.document.poses.of(object);
    section(ui, "Pose", true, |ui| {
        rows(ui, object, &pose, actions);
        let reset = ui.add_enabled(pose != Pose::AS_BAKED, egui::Button::new("Reset pose"));
        if reset.on_hover_text("Puts the object back to where its file has it").clicked() {
            let edit = Edit::Pose { object, pose: Pose::AS_BAKED };
            actions.extend([Action::Edit { edit, label: "Reset pose" }, Action::EndGesture]);
        }
    });
}

fn rows(ui: &mut Ui, object: u32, pose: &Pose, actions: &mut Vec<Action>) {
    let mut row = |label, add: &mut dyn FnMut(&mut Ui, &mut Pose) -> Edited| {
        edit_row(
            actions,
            label,
            pose,
            |pose| Edit::Pose { object, pose },
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
