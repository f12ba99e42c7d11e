//! How rows are laid out: their labels beside or above the controls, and the button that restores the default.

use super::{Edited, GROUP, LEAST_SLIDER, NUMBER_WIDTH};
use egui::{Align, Button, Id, Label, Layout, Rect, Response, RichText, Sense, Ui, UiBuilder, pos2, vec2};

/// Width of the labels of all rows in points, so that controls align.
const LABEL_WIDTH: f32 = 84.0;
/// Width of the reset button in points, kept free if there is none.
pub(super) const RESET_WIDTH: f32 = 20.0;

/// Name of a row's controls for screen readers.
#[derive(Clone, Debug)]
pub struct RowName {
    /// The name, with the group's.
    pub full: String,
    /// The visible label, if it alone is the name.
    label: Option<Id>,
}

impl RowName {
    /// Gives the row's name to its main control.
    pub fn of(&self, control: Response) -> Response {
        match self.label {
            Some(label) => control.labelled_by(label),
            None => control.accessible_name(self.full.as_str()),
        }
    }
}

/// Least width of a slider and its number in points.
fn least_controls(ui: &Ui) -> f32 {
    LEAST_SLIDER + ui.spacing().item_spacing.x + NUMBER_WIDTH
}

/// Width for controls beside the label in a row `total` points wide.
fn room_beside_label(ui: &Ui, total: f32) -> f32 {
    total - LABEL_WIDTH - RESET_WIDTH - 2.0 * ui.spacing().item_spacing.x
}

/// Indent of controls in rows with a label, in points: 0 where labels stand above.
pub(super) fn indent(ui: &Ui) -> f32 {
    let is_beside = room_beside_label(ui, ui.available_width()) >= least_controls(ui);
    if is_beside { LABEL_WIDTH + ui.spacing().item_spacing.x } else { 0.0 }
}

pub(super) fn full_name(ui: &Ui, label: &str) -> Option<String> {
    let group = ui.stack().iter().find_map(|s| s.tags().get_downcast::<String>(GROUP))?;
    Some(format!("{group} {}", label.to_lowercase()))
}

/// Lays a row out: label, `body`, and a reset button where the value `differs` from its default. The last argument of `body` is
/// whether to reset, by the button or a double click on the label.
pub fn row(
    ui: &mut Ui,
    label: &str,
    help: &str,
    differs: bool,
    body: impl FnOnce(&mut Ui, &RowName, bool) -> Edited,
) -> Edited {
    row_of(ui, least_controls(ui), label, help, differs, body)
}

/// A [`row`] whose `body` has a least width in points.
pub fn row_of(
    ui: &mut Ui,
    least: f32,
    label: &str,
    help: &str,
    differs: bool,
    body: impl FnOnce(&mut Ui, &RowName, bool) -> Edited,
) -> Edited {
    let (total, height, gap) = (ui.available_width(), ui.spacing().interact_size.y, ui.spacing().item_spacing.x);
    let beside = room_beside_label(ui, total);
    if beside >= least {
        let contents = |ui: &mut Ui| {
            let shown = cell(ui, LABEL_WIDTH, height, |ui| row_label(ui, label, help));
            controls(ui, [total, beside], &shown, label, differs, body)
        };
        return ui.horizontal(contents).inner;
    }
    let shown = row_label(ui, label, help);
    ui.horizontal(|ui| controls(ui, [total, total - RESET_WIDTH - gap], &shown, label, differs, body)).inner
}

fn row_label(ui: &mut Ui, label: &str, help: &str) -> Response {
    let shown = ui.add(Label::new(label).truncate().selectable(false).sense(Sense::click()));
    shown.on_hover_text(help).on_disabled_hover_text(help)
}

/// The controls of a row `total` points wide; `body` gets `width` of them.
fn controls(
    ui: &mut Ui,
    [total, width]: [f32; 2],
    shown: &Response,
    label: &str,
    differs: bool,
    body: impl FnOnce(&mut Ui, &RowName, bool) -> Edited,
) -> Edited {
    let height = ui.spacing().interact_size.y;
    let centred = Layout::left_to_right(Align::Center);
    let name = match full_name(ui, label) {
        Some(full) => RowName { full, label: None },
        None => RowName { full: label.to_owned(), label: Some(shown.id) },
    };
    let reset_at = ui.max_rect().left() + total - RESET_WIDTH;
    let reset = Rect::from_min_size(pos2(reset_at, ui.max_rect().top()), vec2(RESET_WIDTH, height));
    let mut reset_ui = ui.new_child(UiBuilder::new().max_rect(reset).layout(centred).id_salt("reset"));
    let asked = differs && (reset_button(&mut reset_ui, &name.full) || shown.double_clicked());
    cell(ui, width.max(40.0), height, |ui| body(ui, &name, asked))
}

/// A part of a row of fixed width.
pub(super) fn cell<R>(ui: &mut Ui, width: f32, height: f32, body: impl FnOnce(&mut Ui) -> R) -> R {
    let layout = Layout::left_to_right(Align::Center);
    ui.allocate_ui_with_layout(vec2(width, height), layout, |ui| {
        ui.set_min_width(width);
        ui.set_max_width(width);
        body(ui)
    })
    .inner
}

fn reset_button(ui: &mut Ui, name: &str) -> bool {
    let button = Button::new(RichText::new("↺").monospace().weak()).frame(false);
    let name = format!("Reset {name}");
    ui.add(button).on_hover_text("Reset to default (or double-click the name)").accessible_name(name).clicked()
}
