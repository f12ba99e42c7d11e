//! Rows for special values: ranges over decades, counts, optional limits, long lists of choices, points.

use super::{Edited, RowName, Typing, check_box, note, number_size, row, row_of, slider_width, typed, units::grouped};
use egui::{
    Align, ComboBox, DragValue, Layout, Response, Slider, TextStyle, TextWrapMode, Ui, WidgetText, emath::Numeric, vec2,
};
use glam::Vec3;
use lapidary_core::texture::ColorSpace;
use std::ops::RangeInclusive;

/// Numbers from this value on have no decimals.
const LARGE: f64 = 1e5;
/// Points between several numbers in a row, and padding on both sides of each.
const CLOSE: f32 = 2.0;
/// The longest coordinate or turn that fits a row with several numbers.
const LONG_NUMBER: &str = "-00.000";

/// A number with a logarithmic slider; a whole number if it has no decimals.
#[derive(Clone, Debug)]
pub struct Decades<'a> {
    /// The parameter's name.
    pub label: &'a str,
    /// Its effect, range and unit.
    pub help: &'a str,
    /// Range of slider and typed values.
    pub range: RangeInclusive<f64>,
    /// Value after a reset.
    pub default: f64,
    /// Unit after the number, with its space.
    pub unit: &'a str,
    /// Digits after the point.
    pub decimals: usize,
    /// The value in other terms, shown under it.
    pub note: Option<String>,
}

impl<'a> Decades<'a> {
    /// A whole number without a unit.
    pub fn count(label: &'a str, help: &'a str, range: RangeInclusive<f64>, default: f64) -> Self {
        Self { label, help, range, default, unit: "", decimals: 0, note: None }
    }

    fn entry(&self, ui: &mut Ui, name: &RowName, number: &mut f64) -> Response {
        ui.style_mut().drag_value_text_style = TextStyle::Monospace;
        // Only the whole part of large numbers fits the column.
        let decimals = if number.abs() < LARGE { self.decimals } else { 0 };
        let entry = DragValue::new(number)
            .range(self.range.clone())
            .clamp_existing_to_range(false)
            .speed(if self.decimals == 0 { 1.0 } else { 0.02 })
            .fixed_decimals(decimals)
            .suffix(self.unit)
            .min_size(number_size(ui))
            .update_while_editing(false);
        let typing = Typing { unit: self.unit, range: Some(self.range.clone()), size: None };
        typed(ui, entry, &typing).accessible_name(format!("{} value", name.full))
    }

    fn slider(&self, ui: &mut Ui, number: &mut f64) -> Response {
        let smallest = if self.decimals == 0 { 1.0 } else { 0.01 };
        let slider = Slider::new(number, self.range.clone()).logarithmic(true).smallest_positive(smallest);
        let slider = slider.show_value(false).clamping(egui::SliderClamping::Edits);
        ui.add(if self.decimals == 0 { slider.integer() } else { slider })
    }
}

/// One row with a logarithmic slider and a number entry.
pub fn decades_row<T: Numeric>(ui: &mut Ui, decades: &Decades, value: &mut T) -> Edited {
    let mut number = value.to_f64();
    let differs = (number - decades.default).abs() > 1e-6 * decades.default.abs();
    let edited = row(ui, decades.label, decades.help, differs, |ui, name, reset| {
        if reset {
            number = decades.default;
            return Edited::at_once(true);
        }
        let before = number;
        ui.spacing_mut().slider_width = slider_width(ui);
        let slider = name.of(decades.slider(ui, &mut number));
        let entry = decades.entry(ui, name, &mut number);
        let ended = Edited::by(ui, &slider).ended | Edited::by(ui, &entry).ended;
        Edited { changed: number != before, ended }
    });
    if let Some(text) = &decades.note {
        note(ui, text);
    }
    if edited.changed {
        *value = T::from_f64(number);
    }
    edited
}

/// One row with a check box that sets a number, and the number; its note says what holds without one. Ticking it sets the default.
pub fn limit_row<T: Numeric>(ui: &mut Ui, decades: &Decades, value: &mut Option<T>) -> Edited {
    row(ui, decades.label, decades.help, false, |ui, name, _| {
        let mut on = value.is_some();
        let ticked = name.of(check_box(ui, &mut on, "")).on_hover_text(decades.help).changed();
        if ticked {
            *value = on.then(|| T::from_f64(decades.default));
        }
        let Some(limit) = value else {
            ui.weak(decades.note.as_deref().unwrap_or("no limit"));
            return Edited::at_once(ticked);
        };
        ui.add_space(slider_width(ui));
        let (mut number, before) = (limit.to_f64(), limit.to_f64());
        let entry = decades.entry(ui, name, &mut number);
        *limit = T::from_f64(number);
        Edited::at_once(ticked) | Edited { changed: number != before, ended: Edited::by(ui, &entry).ended }
    })
}

/// One row with a drop-down list: each choice a value, its name and its tooltip.
pub fn combo_row<T: PartialEq + Copy>(
    ui: &mut Ui,
    label: &str,
    help: &str,
    value: &mut T,
    choices: &[(T, &str, &str)],
) -> Edited {
    row_of(ui, list_width(ui, choices), label, help, false, |ui, name, _| {
        let before = *value;
        let current = choices.iter().find(|c| c.0 == before).map_or("", |c| c.1);
        let list = ComboBox::from_id_salt(label).selected_text(current).width(ui.available_width()).truncate();
        let list = list.show_ui(ui, |ui| {
            for &(choice, name, meaning) in choices {
                ui.selectable_value(value, choice, name).on_hover_text(meaning);
            }
        });
        name.of(list.response).on_hover_text(help);
        Edited::at_once(*value != before)
    })
}

/// Color spaces that can be given to a picture, whatever its file says.
pub const GIVEN_SPACES: [(ColorSpace, &str, &str); 4] = [
    (ColorSpace::AcesCg, "ACEScg", "Linear, with the primaries AP1 of ACES, whatever the file says."),
    (ColorSpace::Aces2065, "ACES2065-1", "Linear, with the primaries AP0 of ACES, whatever the file says."),
    (ColorSpace::Rec2020, "Linear Rec. 2020", "Linear, with the primaries of Rec. 2020, whatever the file says."),
    (ColorSpace::P3, "Linear P3", "Linear, with the primaries P3 and the white D65, whatever the file says."),
];

/// A number from a list that also has the present one.
pub fn count_row(
    ui: &mut Ui,
    label: &str,
    help: &str,
    counts: impl Iterator<Item = usize>,
    value: &mut usize,
) -> Edited {
    let mut counts: Vec<usize> = counts.collect();
    if !counts.contains(value) {
        counts.push(*value);
    }
    let names: Vec<String> = counts.iter().map(|&n| grouped(n as u64)).collect();
    let choices: Vec<(usize, &str, &str)> =
        counts.iter().zip(&names).map(|(&n, name)| (n, name.as_str(), "")).collect();
    combo_row(ui, label, help, value, &choices)
}

/// Least width of a list in points that truncates none of its choices.
fn list_width<T>(ui: &Ui, choices: &[(T, &str, &str)]) -> f32 {
    let widest = choices.iter().map(|choice| text_width(ui, choice.1, TextStyle::Button)).fold(0.0, f32::max);
    let spacing = ui.spacing();
    widest + 2.0 * spacing.button_padding.x + spacing.icon_spacing + spacing.icon_width
}

fn text_width(ui: &Ui, text: &str, style: TextStyle) -> f32 {
    WidgetText::from(text).into_galley(ui, Some(TextWrapMode::Extend), f32::INFINITY, style).size().x.ceil()
}

/// One row with the coordinates of a point in meters.
pub fn point_row(ui: &mut Ui, label: &str, help: &str, point: &mut Vec3) -> Edited {
    axes_row(ui, label, help, point, ["m", "m"], 0.01)
}

/// One row with turns about the axes in degrees.
pub fn turns_row(ui: &mut Ui, label: &str, help: &str, degrees: &mut Vec3) -> Edited {
    axes_row(ui, label, help, degrees, ["°", "degrees"], 0.5)
}

/// One row with a number for each axis, which changes by `speed` per point of a drag. In a narrow panel they stand below one
/// another.
fn axes_row(ui: &mut Ui, label: &str, help: &str, numbers: &mut Vec3, [unit, words]: [&str; 2], speed: f64) -> Edited {
    let number = text_width(ui, LONG_NUMBER, TextStyle::Monospace) + 2.0 * CLOSE;
    let least = 3.0 * number + 2.0 * CLOSE;
    row_of(ui, least, label, help, false, |ui, name, _| {
        ui.style_mut().drag_value_text_style = TextStyle::Monospace;
        ui.style_mut().spacing.item_spacing = egui::Vec2::splat(CLOSE);
        ui.spacing_mut().button_padding.x = CLOSE;
        let room = ui.available_width();
        let (width, layout) = match room >= least {
            true => ((room - 2.0 * CLOSE) / 3.0, Layout::left_to_right(Align::Center)),
            false => (room, Layout::top_down(Align::LEFT)),
        };
        let entries = |ui: &mut Ui| {
            let mut edited = Edited::default();
            for (number, axis) in numbers.as_mut().iter_mut().zip(["X", "Y", "Z"]) {
                let entry = DragValue::new(number).speed(speed).max_decimals(3).update_while_editing(false);
                let size = vec2(width, ui.spacing().interact_size.y);
                let entry = typed(ui, entry, &Typing { unit, range: None, size: Some(size) });
                edited |= Edited::by(ui, &entry);
                entry.accessible_name(format!("{} {axis}", name.full)).on_hover_text(format!("{axis}, {words}"));
            }
            edited
        };
        ui.with_layout(layout, entries).inner
    })
}
