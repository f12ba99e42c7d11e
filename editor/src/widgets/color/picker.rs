//! The picker of a color: a field and a slider, hue, saturation and value as numbers, colors used before, and the eyedropper.

use super::eyedropper;
use crate::widgets::{Typing, outline, typed};
use egui::{
    Button, Color32, DragValue, Grid, Id, Mesh, Popup, PopupCloseBehavior, Rect, Response, Role, Sense, Shape, Stroke,
    StrokeKind, Ui, Vec2, WidgetInfo,
    ecolor::{hsv_from_rgb, rgb_from_hsv},
    vec2,
};
use glam::Vec3;
use lapidary_core::color::{codes_from_linear, linear_from_srgb, srgb_from_linear};

/// Size of the field in points, and height of the bar of hues.
const FIELD: Vec2 = vec2(230.0, 150.0);
const HUES: f32 = 16.0;
/// Steps of a gradient.
const STEPS: u32 = 16;
/// Most colors that are remembered, and the side of each in points.
const RECENT: usize = 12;
const CHIP: f32 = 16.0;

/// A button of a size in the color, which opens the picker. Its response says whether the color changed.
pub fn picker_button(ui: &mut Ui, color: &mut Vec3, size: egui::Vec2) -> Response {
    let (rect, mut response) = ui.allocate_exact_size(size, Sense::click());
    let shown = color32(*color);
    response.widget_info(|| WidgetInfo::new(Role::ColorWell));
    ui.painter().rect(rect, 2.0, shown, outline(ui), StrokeKind::Inside);
    let id = response.id.with("picker");
    let before = *color;
    let popup = Popup::from_toggle_button_response(&response).id(id);
    popup.close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        contents(ui, id, color);
    });
    if let Some(picked) = eyedropper::picked(ui.ctx(), id) {
        *color = picked;
    }
    if *color != before {
        response.mark_changed();
    }
    response
}

fn contents(ui: &mut Ui, id: Id, color: &mut Vec3) {
    let mut hsv = kept(ui, id, *color);
    let before = hsv;
    field(ui, &mut hsv);
    hue_bar(ui, &mut hsv);
    numbers(ui, &mut hsv);
    if hsv != before {
        *color = linear_of_hsv(hsv);
    }
    ui.data_mut(|data| data.insert_temp(id, (hsv, *color)));
    let help = "Click anywhere in the window to take the color there, as it is displayed";
    if ui.add(Button::new("Eyedropper")).on_hover_text(help).clicked() {
        eyedropper::begin(ui.ctx(), id);
        ui.close();
    }
    recent_chips(ui, color);
}

/// Hue, saturation and value of the color; what a gray or black lacks is that of the last frame.
fn kept(ui: &Ui, id: Id, color: Vec3) -> [f32; 3] {
    let kept = ui.data(|data| data.get_temp::<([f32; 3], Vec3)>(id)).filter(|(_, of)| *of == color);
    kept.map_or_else(|| hsv_of(color), |(hsv, _)| hsv)
}

/// The field of saturation, to the right, and value, upward.
fn field(ui: &mut Ui, hsv: &mut [f32; 3]) {
    let (rect, response) = ui.allocate_exact_size(FIELD, Sense::click_and_drag());
    if let Some(at) = response.interact_pointer_pos() {
        let share = ((at - rect.min) / rect.size()).clamp(Vec2::ZERO, Vec2::splat(1.0));
        (hsv[1], hsv[2]) = (share.x, 1.0 - share.y);
    }
    let hue = hsv[0];
    gradient(ui, rect, [STEPS, STEPS], |share| [hue, share.x, 1.0 - share.y]);
    let at = rect.lerp_inside(vec2(hsv[1], 1.0 - hsv[2]));
    let ring = if hsv[2] > 0.6 { Color32::BLACK } else { Color32::WHITE };
    ui.painter().circle(at, 6.0, color32(linear_of_hsv(*hsv)), Stroke::new(1.5, ring));
}

fn hue_bar(ui: &mut Ui, hsv: &mut [f32; 3]) {
    let (rect, response) = ui.allocate_exact_size(vec2(FIELD.x, HUES), Sense::click_and_drag());
    if let Some(at) = response.interact_pointer_pos() {
        hsv[0] = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
    }
    gradient(ui, rect, [6 * STEPS / 2, 1], |share| [share.x, 1.0, 1.0]);
    let x = rect.lerp_inside(vec2(hsv[0], 0.0)).x;
    let mark = Rect::from_x_y_ranges(x - 2.0..=x + 2.0, rect.y_range());
    ui.painter().rect_stroke(mark, 1.0, Stroke::new(1.5, Color32::WHITE), StrokeKind::Outside);
}

/// Paints colors by their place, in shares of the rectangle.
fn gradient(ui: &Ui, rect: Rect, [columns, rows]: [u32; 2], hsv: impl Fn(Vec2) -> [f32; 3]) {
    let mut mesh = Mesh::default();
    for y in 0..=rows {
        for x in 0..=columns {
            let share = vec2(x as f32 / columns as f32, y as f32 / rows as f32);
            mesh.colored_vertex(rect.lerp_inside(share), color32(linear_of_hsv(hsv(share))));
        }
    }
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let [a, below] = [y * (columns + 1) + x, (y + 1) * (columns + 1) + x];
        mesh.add_triangle(a, a + 1, below);
        mesh.add_triangle(a + 1, below + 1, below);
    }
    ui.painter().add(Shape::mesh(mesh));
}

/// The numbers, of the color as displayed.
fn numbers(ui: &mut Ui, hsv: &mut [f32; 3]) {
    Grid::new("hue, saturation, value").num_columns(6).show(ui, |ui| {
        let entries: [(_, _, f64, _); 3] =
            [("H", "Hue", 360.0, "°"), ("S", "Saturation", 100.0, " %"), ("V", "Value", 100.0, " %")];
        for ((label, name, most, unit), part) in entries.into_iter().zip(hsv) {
            ui.label(label);
            let mut number = most * f64::from(*part);
            let entry = DragValue::new(&mut number).range(0.0..=most).suffix(unit).max_decimals(1).speed(0.005 * most);
            let typing = Typing { unit, range: Some(0.0..=most), size: None };
            if typed(ui, entry, &typing).accessible_name(name).changed() {
                *part = (number / most) as f32;
            }
        }
    });
}

/// Hue, saturation and value of a scene-linear color as sRGB, each 0 to 1.
pub fn hsv_of(color: Vec3) -> [f32; 3] {
    let (h, s, v) = hsv_from_rgb(color.clamp(Vec3::ZERO, Vec3::ONE).map(srgb_from_linear).to_array());
    [h, s, v]
}

/// The scene-linear color of a hue, saturation and value in sRGB, each 0 to 1.
pub fn linear_of_hsv([h, s, v]: [f32; 3]) -> Vec3 {
    Vec3::from_array(rgb_from_hsv((h, s, v))).map(linear_from_srgb)
}

fn recent_chips(ui: &mut Ui, color: &mut Vec3) {
    let recent = recent(ui);
    if recent.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 4.0);
        for other in recent {
            let (rect, chip) = ui.allocate_exact_size(vec2(CHIP, CHIP), Sense::click());
            let name = super::hex_from_linear(other);
            chip.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Recent {name}")));
            ui.painter().rect(rect, 2.0, color32(other), outline(ui), StrokeKind::Inside);
            if chip.on_hover_text(name).clicked() {
                *color = other;
            }
        }
    });
}

fn color32(color: Vec3) -> Color32 {
    let [r, g, b] = codes_from_linear(color);
    Color32::from_rgb(r, g, b)
}

fn recent_id() -> Id {
    Id::unique("recent colors")
}

/// Colors used before, the last first.
fn recent(ui: &Ui) -> Vec<Vec3> {
    ui.data(|data| data.get_temp(recent_id())).unwrap_or_default()
}

/// Remembers a color that was chosen.
pub fn remember(ui: &Ui, color: Vec3) {
    let mut colors = recent(ui);
    colors.retain(|other| codes_from_linear(*other) != codes_from_linear(color));
    colors.insert(0, color);
    colors.truncate(RECENT);
    ui.data_mut(|data| data.insert_temp(recent_id(), colors));
}
