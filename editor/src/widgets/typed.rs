//! Numbers that are dragged or typed: also as expressions, with a comma, and with units.

mod expression;

use egui::{Area, DragValue, Frame, Id, Order, Response, RichText, Stroke, StrokeKind, Ui, Vec2};
use expression::value_of;
use std::{cell::RefCell, ops::RangeInclusive};

/// Seconds for which a refused number is marked, with the reason.
const MARKED: f64 = 2.5;

/// How a number is typed.
#[derive(Clone, Debug, Default)]
pub struct Typing<'a> {
    /// The unit that a number without one has, as " m" or "°"; empty if it has none.
    pub unit: &'a str,
    /// What is taken; other numbers become the nearest of it, which is told.
    pub range: Option<RangeInclusive<f64>>,
    /// Least size of the field in points.
    pub size: Option<Vec2>,
}

/// Shows a number. A text that is none is refused, and a number out of range moved into it: both are marked in red, with the reason.
pub fn typed(ui: &mut Ui, entry: DragValue, typing: &Typing) -> Response {
    let told = RefCell::new(None);
    let parser = |text: &str| {
        let value = value_of(text, typing.unit);
        *told.borrow_mut() = match (&value, &typing.range) {
            (Err(reason), _) => Some(reason.clone()),
            (Ok(value), Some(range)) if !range.contains(value) => {
                Some(format!("{} to {}", short(*range.start()), short(*range.end())))
            }
            _ => None,
        };
        value.ok()
    };
    let entry = entry.custom_parser(parser);
    let response = match typing.size {
        Some(size) => ui.add_sized(size, entry),
        None => ui.add(entry),
    };
    mark(ui, &response, told.take());
    response
}

/// Marks a field for some seconds after it was told something.
fn mark(ui: &Ui, response: &Response, told: Option<String>) {
    let (id, now): (Id, f64) = (response.id.with("told"), ui.input(|input| input.time));
    if let Some(reason) = told {
        ui.data_mut(|data| data.insert_temp(id, (reason, now)));
    }
    let Some((reason, since)) = ui.data(|data| data.get_temp::<(String, f64)>(id)) else { return };
    let left = MARKED - (now - since);
    if left <= 0.0 {
        return ui.data_mut(|data| data.remove::<(String, f64)>(id));
    }
    ui.ctx().request_repaint_after_secs(left as f32);
    let color = ui.visuals().error_fg_color;
    ui.painter().rect_stroke(response.rect, 2.0, Stroke::new(1.5, color), StrokeKind::Outside);
    // It lies over the next row, and takes no clicks from it.
    let area = Area::new(id).order(Order::Tooltip).interactable(false).fixed_pos(response.rect.left_bottom());
    area.show(ui.ctx(), |ui| Frame::popup(ui.style()).show(ui, |ui| ui.label(RichText::new(reason).color(color))));
}

/// A bound with few digits.
fn short(bound: f64) -> String {
    let rounded = (bound * 1e6).round() / 1e6;
    format!("{rounded}")
}
