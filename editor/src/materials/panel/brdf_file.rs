//! The row of a BRDF file.

use super::maps::dropped_on;
use crate::{
    actions::{Action, MaterialAction},
    widgets::wide_row,
};
use egui::{Button, Label, RichText, Ui};
use lapidary_core::material::Material;

/// Height of the row in points.
const HEIGHT: f32 = 16.0;

/// Shows the file of the material's BRDF, and the button that loads another.
pub fn show(ui: &mut Ui, index: usize, material: &Material, actions: &mut Vec<Action>) {
    let file = material.file.as_ref();
    let named = |ui: &mut Ui| {
        let (shown, full) = match file {
            Some(file) if file.content.is_some() => (RichText::new(file.name()), file.path.display().to_string()),
            Some(file) => {
                let why = format!(
                    "Cannot read this file, so the material is magenta. Load it again.\n{}",
                    file.path.display()
                );
                (RichText::new(file.name()).color(ui.visuals().warn_fg_color), why)
            }
            None => (RichText::new("No file").weak(), "Without a file the material is magenta.".to_owned()),
        };
        ui.add(Label::new(shown).truncate()).on_hover_text(full);
    };
    let choose = |ui: &mut Ui| {
        let verb = if file.is_some() { "Swap" } else { "Load" };
        let button = Button::new(format!("{verb}…")).small().min_size([ui.available_width(), 0.0].into());
        let hint = "Choose a BRDF file, or drop one on this row.";
        if ui.add(button).on_hover_text(hint).accessible_name(format!("{verb} BRDF")).clicked() {
            actions.push(Action::Material(MaterialAction::LoadBrdf { material: index, path: None }));
        }
    };
    let row = wide_row(ui, HEIGHT, named, choose, |_| {}).response;
    if let Some(path) = dropped_on(ui, row.rect) {
        actions.push(Action::Material(MaterialAction::LoadBrdf { material: index, path: Some(path) }));
    }
}
