//! The picker of a color: a field and a slider, hue, saturation and value as numbers, colors used before, and the eyedropper.

use super::eyedropper;
use crate::widgets::{Typing, outline, typed};
use egui::{
    Button, Color32, DragValue, Grid, Id, Popup, PopupCloseBehavior, Response, Role, Sense, StrokeKind, Ui, WidgetInfo,
    color_picker::{Alpha, color_picker_hsva_2d},
    ecolor::{Hsva, hsv_from_rgb, rgb_from_hsv},
    vec2,
};
use glam::Vec3;
use lapidary_core::color::{codes_from_linear, linear_from_srgb, srgb_from_linear};

/// Length of the picker's sliders in points.
const SLIDER: f32 = 220.0;
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
    Popup::menu(&response).id(id).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
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
    ui.spacing_mut().slider_width = SLIDER;
    let mut hsva = kept_hue(ui, id, *color);
    if color_picker_hsva_2d(ui, &mut hsva, Alpha::Opaque) {
        *color = Vec3::from_array(hsva.to_rgb());
    }
    ui.data_mut(|data| data.insert_temp(id, (hsva, *color)));
    numbers(ui, color);
    ui.horizontal(|ui| {
        let help = "Click anywhere in the window to take the color there, as it is displayed";
        if ui.add(Button::new("Eyedropper")).on_hover_text(help).clicked() {
            eyedropper::begin(ui.ctx(), id);
            ui.close();
        }
    });
    recent_chips(ui, color);
}

/// The color with the hue of the last frame, which grays have none of.
fn kept_hue(ui: &Ui, id: Id, color: Vec3) -> Hsva {
    let kept = ui.data(|data| data.get_temp::<(Hsva, Vec3)>(id)).filter(|(_, of)| *of == color);
    let [r, g, b] = color.to_array();
    kept.map_or_else(|| Hsva::from_rgb([r, g, b]), |(hsva, _)| hsva)
}

/// Hue, saturation and value of the color as displayed.
fn numbers(ui: &mut Ui, color: &mut Vec3) {
    let [h, s, v] = hsv_of(*color);
    let mut shown = [360.0 * h, 100.0 * s, 100.0 * v];
    let before = shown;
    Grid::new("hue, saturation, value").num_columns(6).show(ui, |ui| {
        let entries: [(_, _, f64, _); 3] =
            [("H", "Hue", 360.0, "°"), ("S", "Saturation", 100.0, " %"), ("V", "Value", 100.0, " %")];
        for ((label, name, most, unit), number) in entries.into_iter().zip(&mut shown) {
            ui.label(label);
            let entry = DragValue::new(number).range(0.0..=most).suffix(unit).max_decimals(1).speed(0.005 * most);
            let typing = Typing { unit, range: Some(0.0..=most), size: None };
            typed(ui, entry, &typing).accessible_name(name);
        }
    });
    if shown != before {
        *color = linear_of_hsv([shown[0] / 360.0, shown[1] / 100.0, shown[2] / 100.0]);
    }
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
