//! The eye that switches a row of a list on and off, and the padlock of a locked one.

use egui::{Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, vec2};

/// Width of an eye in points.
const EYE: f32 = 17.0;

/// An open eye, or a closed one for a thing that is off. `verbs` tell what a click does while it is on, and while it is off.
pub fn eye(ui: &mut Ui, verbs: [&str; 2], name: &str, enabled: bool) -> Response {
    let (rect, eye) = ui.allocate_exact_size(vec2(EYE, ui.spacing().interact_size.y), Sense::click());
    let verb = verbs[usize::from(!enabled)];
    eye.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), format!("{verb} {name}")));
    paint_eye(ui, rect, enabled, eye.hovered());
    eye.on_hover_text(verb)
}

/// A closed padlock, which a click opens.
pub fn padlock(ui: &mut Ui, name: &str) -> Response {
    let (rect, lock) = ui.allocate_exact_size(vec2(EYE, ui.spacing().interact_size.y), Sense::click());
    lock.widget_info(|| WidgetInfo::labeled(Role::Button, ui.is_enabled(), format!("Unlock {name}")));
    let visuals = ui.visuals();
    let color = if lock.hovered() { visuals.strong_text_color() } else { visuals.text_color() };
    let center = rect.center() + vec2(0.0, 2.0);
    ui.painter().rect_filled(Rect::from_center_size(center, vec2(9.0, 7.0)), 1.5, color);
    let at = |i: u8| {
        let (sin, cos) = (std::f32::consts::PI * f32::from(i) / 12.0).sin_cos();
        center + vec2(2.8 * cos, -3.5 - 4.0 * sin)
    };
    ui.painter().add(Shape::line((0..=12).map(at).collect(), Stroke::new(1.3, color)));
    lock.on_hover_text("Unlock")
}

/// Paints the eye, which the toolkit's font lacks.
fn paint_eye(ui: &Ui, rect: Rect, open: bool, hovered: bool) {
    let visuals = ui.visuals();
    let color = if hovered || open { visuals.strong_text_color() } else { visuals.weak_text_color() };
    let lid = |up: f32| {
        let at = |i: u8| {
            let x = f32::from(i) / 8.0 - 1.0;
            rect.center() + 0.42 * EYE * vec2(x, -0.6 * up * (1.0 - x * x))
        };
        Shape::line((0..=16).map(at).collect(), Stroke::new(1.2, color))
    };
    ui.painter().add(lid(-1.0));
    if open {
        ui.painter().add(lid(1.0));
        ui.painter().circle_filled(rect.center(), 2.2, color);
    }
}
