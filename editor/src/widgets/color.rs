//! A row that edits a scene-linear color, by a picker or as sRGB hex.

pub(super) mod eyedropper;
mod picker;

use super::{Edited, number_size, row, slider_width};
use crate::document::lights::color_and_intensity;
use egui::{Align2, Color32, FontSelection, TextEdit, TextStyle, Ui, vec2};
use glam::Vec3;
use lapidary_core::color::{codes_from_linear, linear_from_codes};

/// One row with a swatch that opens a picker, and the color as sRGB hex.
pub fn color_row(ui: &mut Ui, label: &str, help: &str, color: &mut Vec3, default: Vec3) -> Edited {
    let differs = color.distance(default) > 1e-5;
    row(ui, label, help, differs, |ui, name, reset| {
        if reset {
            *color = default;
            return Edited::at_once(true);
        }
        // As wide as a slider.
        let size = vec2(slider_width(ui), ui.spacing().interact_size.y);
        let swatch = name.of(picker::picker_button(ui, color, size)).on_hover_text(help);
        // The picker reports changes only; its gesture ends when the pointer is released, anywhere.
        let picked = Edited::until(ui, swatch.id, swatch.changed(), !ui.input(|i| i.pointer.any_down()));
        let edited = picked | hex_entry(ui, &name.full, color);
        if edited.ended {
            picker::remember(ui, *color);
        }
        edited
    })
}

/// The color as sRGB hex; typed text counts when the field is left, if it is a color.
fn hex_entry(ui: &mut Ui, name: &str, color: &mut Vec3) -> Edited {
    let id = ui.make_persistent_id(("hex", name));
    let shown = hex_from_linear(*color);
    let mut text = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| shown.clone());
    let entry = TextEdit::singleline(&mut text).id(id).font(FontSelection::from(TextStyle::Monospace));
    let entry = entry.align(Align2::LEFT_CENTER);
    let response =
        ui.add_sized(number_size(ui), entry).on_hover_text("sRGB, as #rrggbb").accessible_name(format!("{name} hex"));
    if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, text));
        return Edited::default();
    }
    ui.data_mut(|d| d.remove_temp::<String>(id));
    let typed = linear_from_hex(&text).filter(|_| response.lost_focus() && text != shown);
    if let Some(typed) = typed {
        *color = typed;
    }
    Edited::at_once(typed.is_some())
}

/// A scene-linear color as `#rrggbb`.
pub fn hex_from_linear(color: Vec3) -> String {
    let [r, g, b] = codes_from_linear(color);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The scene-linear color of `#rrggbb` or `rgb`.
pub fn linear_from_hex(text: &str) -> Option<Vec3> {
    let digits = text.trim().trim_start_matches('#');
    let digits = match digits.len() {
        3 => digits.chars().flat_map(|c| [c, c]).collect(),
        _ => digits.to_owned(),
    };
    if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let [_, codes @ ..] = u32::from_str_radix(&digits, 16).ok()?.to_be_bytes();
    Some(linear_from_codes(codes))
}

/// The color of a light for a display.
pub fn display_color(intensity: Vec3) -> Color32 {
    let (color, _) = color_and_intensity(intensity);
    let [r, g, b] = codes_from_linear(color);
    Color32::from_rgb(r, g, b)
}
