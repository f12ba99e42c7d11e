//! Assigns another material to the selected surface, or makes its own unique.

use super::MaterialContext;
use crate::actions::{Action, MaterialAction};
use egui::{Button, ComboBox, Ui};
use lapidary_core::parts::Part;

/// Width of the button beside the list in points.
const BUTTON_WIDTH: f32 = 100.0;

/// Shows the rows, if the selected surface can have another material.
pub fn show(ui: &mut Ui, context: &MaterialContext, actions: &mut Vec<Action>) {
    let Some(part) = context.part.filter(|part| context.ground != Some(part.material as usize)) else { return };
    ui.horizontal(|ui| {
        ui.label("Surface");
        ui.add(egui::Label::new(title(context, part)).truncate());
    });
    ui.horizontal(|ui| {
        uses(ui, context, part, actions);
        make_unique(ui, context, part, actions);
    });
}

/// The name of its object, with the file's material if the object has several parts.
fn title(context: &MaterialContext, part: Part) -> String {
    let document = context.document;
    let name = document.part_name(part);
    let is_one_of_several = context.parts.iter().filter(|other| other.object == part.object).count() > 1;
    if is_one_of_several { format!("{name}, {}", document.material_name(part.material as usize)) } else { name }
}

fn uses(ui: &mut Ui, context: &MaterialContext, part: Part, actions: &mut Vec<Action>) {
    let document = context.document;
    let current = document.material_of(part);
    let label = ui.label("Uses");
    let combo = ComboBox::from_id_salt("material of the surface").selected_text(document.material_name(current));
    let opened = combo.width(ui.available_width() - BUTTON_WIDTH).truncate().show_ui(ui, |ui| {
        for material in (0..document.materials.len()).filter(|&material| context.ground != Some(material)) {
            if ui.selectable_label(material == current, document.material_name(material)).clicked() {
                actions.push(Action::Material(MaterialAction::Assign { part, material }));
            }
        }
    });
    opened.response.labelled_by(label.id).on_hover_text("Give this surface another material. No bake is needed.");
}

fn make_unique(ui: &mut Ui, context: &MaterialContext, part: Part, actions: &mut Vec<Action>) {
    let material_of = |part: &Part| context.document.material_of(*part);
    let sharing = context.parts.iter().filter(|other| material_of(other) == material_of(&part)).count();
    let button = ui.add_enabled(sharing > 1, Button::new("Make unique"));
    let button =
        button.on_hover_text(format!("{sharing} surfaces have this material. Give this one a copy of its own."));
    if button.on_disabled_hover_text("No other surface has this material").clicked() {
        actions.push(Action::Material(MaterialAction::MakeUnique { part, material: None }));
    }
}
