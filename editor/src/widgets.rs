//! Common rows of all inspectors: a label with an explanation, the control, and a button that restores the default. They stand in
//! columns: labels, sliders, numbers, reset buttons. Only the column of sliders grows with the panel. In a narrow panel labels
//! stand above their controls.
//!
//! Every row reports whether its value changed and whether the gesture that changes it has ended, because a drag over
//! many frames is one step of undo. Every control carries the row's name for screen readers, and tests find it by that.

mod color;
mod edit_row;
pub mod entries;
mod eye;
mod layers;
mod layout;
mod texture;
mod typed;
pub mod units;

pub use color::{color_row, display_color};
pub use edit_row::edit_row;
pub use eye::{eye, padlock};
pub use layers::Layers;
pub use layout::{RowName, row, row_of};
pub use texture::texture_of;
pub use typed::{Typing, typed};

use egui::{
    CollapsingHeader, DragValue, Id, InnerResponse, Label, Response, RichText, Slider, Stroke, TextStyle, Ui,
    UiBuilder, UiStackInfo, Vec2, WidgetText, vec2,
};
use layout::{RESET_WIDTH, cell, full_name, indent};
use std::ops::{BitOr, BitOrAssign, RangeInclusive};

/// Width of the column of numbers in points.
const NUMBER_WIDTH: f32 = 72.0;
/// Least width of a slider in points.
const LEAST_SLIDER: f32 = 24.0;
/// Speed factor of a slider while Shift is held.
const FINE: f32 = 0.1;

/// Change of a value in this frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[must_use]
pub struct Edited {
    /// Whether it has another value now.
    pub changed: bool,
    /// Whether the drag stopped, the field lost the focus, or a click set the value: the next change is another step of undo.
    pub ended: bool,
}

impl Edited {
    /// A change that is complete at once, as by a click.
    pub fn at_once(changed: bool) -> Self {
        Self { changed, ended: changed }
    }

    /// The edit by a slider or number entry. A gesture that changed nothing does not end either.
    pub fn by(ui: &Ui, response: &Response) -> Self {
        let over = response.drag_stopped() || response.lost_focus() || !(response.dragged() || response.has_focus());
        Self::until(ui, response.id, response.changed(), over)
    }

    /// Remembers a change under `id` until the gesture is `over`.
    fn until(ui: &Ui, id: Id, changed: bool, over: bool) -> Self {
        let id = id.with("gesture");
        let under_way = changed || ui.data(|d| d.get_temp(id)).unwrap_or(false);
        ui.data_mut(|d| d.insert_temp(id, under_way && !over));
        Self { changed, ended: under_way && over }
    }
}

impl BitOr for Edited {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self { changed: self.changed | other.changed, ended: self.ended | other.ended }
    }
}

impl BitOrAssign for Edited {
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

/// A number that a row edits.
#[derive(Clone, Debug)]
pub struct Number<'a> {
    /// The parameter's name.
    pub label: &'a str,
    /// Its effect, range and unit.
    pub help: &'a str,
    /// Range of the slider.
    pub range: RangeInclusive<f32>,
    /// Range of typed values.
    pub entry: RangeInclusive<f32>,
    /// Value after a reset.
    pub default: f32,
    /// Unit after the number, with its space: " mm".
    pub unit: &'a str,
    /// Digits after the point.
    pub decimals: usize,
    /// Why it cannot be edited now.
    pub disabled: Option<&'a str>,
}

impl<'a> Number<'a> {
    /// A number without unit, typed in the slider's range, with two digits after the point.
    pub fn new(label: &'a str, help: &'a str, range: RangeInclusive<f32>, default: f32) -> Self {
        Self { label, help, entry: range.clone(), range, default, unit: "", decimals: 2, disabled: None }
    }

    /// With a unit and this many digits.
    pub fn unit(self, unit: &'a str, decimals: usize) -> Self {
        Self { unit, decimals, ..self }
    }

    /// With a range of typed values beyond the slider's.
    pub fn entry(self, entry: RangeInclusive<f32>) -> Self {
        Self { entry, ..self }
    }

    /// Grayed out, for a reason.
    pub fn disabled(self, reason: Option<&'a str>) -> Self {
        Self { disabled: reason, ..self }
    }

    fn differs(&self, value: f32) -> bool {
        (value - self.default).abs() > 0.5 * 0.1_f32.powi(self.decimals as i32 + 2)
    }
}

/// One row with a slider and a number entry.
pub fn slider_row(ui: &mut Ui, number: &Number, value: &mut f32) -> Edited {
    let enabled = number.disabled.is_none();
    let help = number.disabled.map_or(number.help.to_owned(), |reason| format!("{}\n\n{reason}", number.help));
    ui.add_enabled_ui(enabled, |ui| {
        row(ui, number.label, &help, number.differs(*value), |ui, name, reset| {
            if reset {
                *value = number.default;
                return Edited::at_once(true);
            }
            ui.spacing_mut().slider_width = slider_width(ui);
            let slider = name.of(fine_slider(ui, number, value));
            let slid = Edited::by(ui, &slider);
            let entry = number_entry(ui, number, value).accessible_name(format!("{} value", name.full));
            slid | Edited::by(ui, &entry)
        })
    })
    .inner
}

/// A slider that moves slowly from the present value while Shift is held.
fn fine_slider(ui: &mut Ui, number: &Number, value: &mut f32) -> Response {
    let before = *value;
    let slider = Slider::new(value, number.range.clone()).show_value(false).clamping(egui::SliderClamping::Edits);
    let mut response = ui.add(slider);
    if response.is_pointer_button_down_on() && ui.input(|i| i.modifiers.shift) {
        let span = number.range.end() - number.range.start();
        let moved = response.drag_delta().x / response.rect.width().max(1.0) * span * FINE;
        *value = (before + moved).clamp(*number.entry.start(), *number.entry.end());
    }
    if *value == before {
        response.flags.remove(egui::response::Flags::CHANGED);
    } else {
        response.mark_changed();
    }
    response
}

/// The number beside a slider. Figures are monospaced, so that they do not jitter in a drag.
fn number_entry(ui: &mut Ui, number: &Number, value: &mut f32) -> Response {
    ui.style_mut().drag_value_text_style = TextStyle::Monospace;
    let span = number.range.end() - number.range.start();
    let entry = DragValue::new(value)
        .range(number.entry.clone())
        .clamp_existing_to_range(false)
        .speed(span / 300.0)
        .fixed_decimals(number.decimals)
        .suffix(number.unit)
        .min_size(number_size(ui))
        .update_while_editing(false);
    let [low, high] = [number.entry.start(), number.entry.end()].map(|&bound| f64::from(bound));
    typed(ui, entry, &Typing { unit: number.unit, range: Some(low..=high), size: None })
}

/// Width in points of the column of sliders: the rest beside the column of numbers.
pub fn slider_width(ui: &Ui) -> f32 {
    (ui.available_width() - NUMBER_WIDTH - ui.spacing().item_spacing.x).max(LEAST_SLIDER)
}

/// Size in points of a control in the column of numbers.
pub fn number_size(ui: &Ui) -> Vec2 {
    vec2(NUMBER_WIDTH, ui.spacing().interact_size.y)
}

/// Small text under a row, where its slider begins.
pub fn note(ui: &mut Ui, text: &str) {
    let left = ui.cursor().left() + indent(ui);
    let place = ui.available_rect_before_wrap().with_min_x(left);
    ui.scope_builder(UiBuilder::new().max_rect(place), |ui| {
        ui.add(Label::new(RichText::new(text).weak().small()).wrap());
    });
}

/// A row without a label: `name` takes the columns of labels and sliders, `action` the column of numbers, and `remove` the column
/// of reset buttons.
pub fn wide_row<R>(
    ui: &mut Ui,
    height: f32,
    name: impl FnOnce(&mut Ui),
    action: impl FnOnce(&mut Ui),
    remove: impl FnOnce(&mut Ui) -> R,
) -> InnerResponse<R> {
    ui.horizontal(|ui| {
        let taken = NUMBER_WIDTH + RESET_WIDTH + 2.0 * ui.spacing().item_spacing.x;
        cell(ui, (ui.available_width() - taken).max(40.0), height, name);
        cell(ui, NUMBER_WIDTH, height, action);
        cell(ui, RESET_WIDTH, height, remove)
    })
}

/// One row with a few choices side by side: each a value, its name and its tooltip.
pub fn choice_row<T: PartialEq + Copy>(
    ui: &mut Ui,
    label: &str,
    help: &str,
    value: &mut T,
    choices: &[(T, &str, &str)],
) -> Edited {
    row(ui, label, help, false, |ui, row, _| {
        let before = *value;
        for &(choice, name, meaning) in choices {
            let button = ui.selectable_value(value, choice, name).on_hover_text(meaning);
            button.accessible_name(format!("{}: {name}", row.full));
        }
        Edited::at_once(*value != before)
    })
}

/// Text that can be selected and copied, unlike other labels: an error, a path, a figure.
pub fn copyable(ui: &mut Ui, text: impl Into<WidgetText>) -> Response {
    ui.add(Label::new(text).selectable(true))
}

/// A check box with an outline: its fill alone hardly differs from the panel.
pub fn check_box(ui: &mut Ui, value: &mut bool, label: &str) -> Response {
    ui.scope(|ui| {
        let outline = outline(ui);
        let visuals = ui.visuals_mut();
        let well = visuals.text_edit_bg_color();
        for state in [&mut visuals.widgets.inactive, &mut visuals.widgets.hovered, &mut visuals.widgets.active] {
            (state.bg_fill, state.bg_stroke) = (well, outline);
        }
        ui.checkbox(value, label)
    })
    .inner
}

/// Outline of small controls on any panel, with the contrast of its weak text.
pub fn outline(ui: &Ui) -> Stroke {
    Stroke::new(1.0, ui.visuals().weak_text_color())
}

/// One row with a check box, its name beside it.
pub fn check_row(ui: &mut Ui, label: &str, help: &str, value: &mut bool) -> Edited {
    ui.horizontal(|ui| {
        ui.add_space(indent(ui));
        let full = full_name(ui, label).unwrap_or_else(|| label.to_owned());
        Edited::at_once(check_box(ui, value, label).on_hover_text(help).accessible_name(full).changed())
    })
    .inner
}

/// A folding part of an inspector, without a box around it.
pub fn section<R>(ui: &mut Ui, title: &str, open: bool, body: impl FnOnce(&mut Ui) -> R) -> Option<R> {
    ui.add_space(4.0);
    let header = CollapsingHeader::new(RichText::new(title).strong()).id_salt(title).default_open(open);
    header.show_unindented(ui, body).body_returned
}

/// Rows of one of several similar things: its name precedes the rows' names for screen readers.
pub fn group<R>(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui) -> R) -> R {
    let info = UiStackInfo::default().with_tag_value(GROUP, name.to_owned());
    ui.scope_builder(UiBuilder::new().id_salt(name).ui_stack_info(info), body).inner
}

/// The tag of a [`group`]'s name.
const GROUP: &str = "group of rows";

#[cfg(test)]
mod tests;
