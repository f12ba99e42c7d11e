//! Patterns in place of pictures: the menu of a map's row, and the controls of the pattern.

use super::{Changes, new_slot, target::Target};
use crate::{
    actions::Action,
    widgets::{Edited, Number, color_row, slider_row},
};
use egui::{Button, Context, TextureHandle, TextureOptions, Ui, containers::menu::MenuButton};
use glam::Vec3;
use lapidary_core::{
    brdf::{BrdfModel, Parameter},
    texture::{Pattern, Procedural, TextureSlot},
};

/// Side of a thumbnail in pixels.
const SIDE: u32 = 64;
/// Most thumbnails kept; a moving slider makes one in each frame.
const KEPT: usize = 16;

/// Thumbnails of the patterns shown last.
#[derive(Default)]
pub struct PatternThumbnails(Vec<(Procedural, TextureHandle)>);

impl PatternThumbnails {
    /// The thumbnail of `pattern`.
    pub fn of(&mut self, context: &Context, pattern: &Procedural) -> TextureHandle {
        if let Some((_, known)) = self.0.iter().find(|(known, _)| known == pattern) {
            return known.clone();
        }
        let picture = super::thumbnails::shrunk(&pattern.baked(SIDE));
        let handle = context.load_texture(pattern.pattern.label(), picture, TextureOptions::LINEAR);
        self.0.truncate(KEPT - 1);
        self.0.insert(0, (*pattern, handle.clone()));
        handle
    }
}

/// The button that opens the menu of images and patterns.
pub fn menu(ui: &mut Ui, target: Target, changes: &mut Changes, actions: &mut Vec<Action>) {
    let name = target.name();
    let (button, _) = MenuButton::from_button(Button::new("…").small()).ui(ui, |ui| {
        if ui.button("Image…").clicked() {
            target.load(None, actions);
        }
        // Patterns give no normals.
        if target.kind == "normal" {
            return;
        }
        for pattern in Pattern::ALL {
            if ui.button(pattern.label()).clicked() {
                choose(target, pattern, changes);
            }
        }
    });
    button.on_hover_text("Use an image or a procedural pattern").accessible_name(format!("Kinds of {name}"));
}

fn choose(target: Target, pattern: Pattern, changes: &mut Changes) {
    let old = changes.material.maps.get(target.kind).cloned();
    let slot = old.unwrap_or_else(|| new_slot(target.kind, 0));
    let procedural = Procedural { pattern, ..slot.procedural.unwrap_or_default() };
    changes.material.maps.set(target.kind, Some(TextureSlot { procedural: Some(procedural), ..slot }));
    changes.note("Pattern", Edited::at_once(true));
}

/// The rows of a pattern's values.
pub fn controls(ui: &mut Ui, kind: &'static str, pattern: &mut Procedural, changes: &mut Changes) {
    let is_color = BrdfModel::declared(kind).is_some_and(Parameter::is_color);
    let default = Procedural::default();
    let rows = [
        ("Low", "Value of the first square, of dark noise and of the start of the gradient.", default.low),
        ("High", "Value of the second square, of bright noise and of the end of the gradient.", default.high),
    ];
    for ((label, help, default), value) in rows.into_iter().zip([&mut pattern.low, &mut pattern.high]) {
        let edited = if is_color {
            color_row(ui, label, help, value, default)
        } else {
            let mut number = value.x;
            let edited = slider_row(ui, &Number::new(label, help, 0.0..=1.0, default.x), &mut number);
            if edited.changed {
                *value = Vec3::splat(number);
            }
            edited
        };
        changes.note("Pattern", edited);
    }
    if pattern.pattern == Pattern::Noise {
        let mut octaves = pattern.octaves as f32;
        let help = "Layers of noise, 1 to 8, each half as large and half as strong.";
        let row = Number::new("Octaves", help, 1.0..=Procedural::MOST_OCTAVES as f32, default.octaves as f32);
        let edited = slider_row(ui, &row.unit("", 0), &mut octaves);
        if edited.changed {
            pattern.octaves = octaves.round() as u32;
        }
        changes.note("Pattern", edited);
    }
}
