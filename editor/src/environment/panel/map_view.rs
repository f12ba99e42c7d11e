//! The map as a wide picture, rotated like the light: world directions keep their position, the map moves.

use super::{EnvironmentContext, overlay, thumbnail, wrapped};
use crate::{
    actions::Action,
    document::{Edit, EnvironmentSettings},
    widgets::check_box,
};
use egui::{
    Align2, Color32, ColorImage, CursorIcon, DragValue, FontId, Painter, Rect, Response, Role, Sense, TextureHandle,
    TextureOptions, TextureWrapMode, Ui, WidgetInfo, pos2, vec2,
};
use lapidary_core::environment::Environment;
use overlay::{Mark, Overlay};
use std::{
    f32::consts::TAU,
    sync::{
        Arc,
        mpsc::{Receiver, channel},
    },
};

/// Pixels of the picture.
const PICTURE: [usize; 2] = [512, 256];
/// Deepest subtrees that have a color of their own.
const DEEPEST_SUBTREE: u32 = 8;

/// State of the picture between frames.
#[derive(Default)]
pub struct MapView {
    picture: Option<Picture>,
    overlay: Overlay,
}

/// A map's picture, made on a thread, since a large map has a hundred million numbers.
struct Picture {
    environment: Arc<Environment>,
    made: Receiver<ColorImage>,
    texture: Option<TextureHandle>,
}

impl Picture {
    fn new(ui: &Ui, environment: &Arc<Environment>) -> Self {
        let (sender, made) = channel();
        let (context, map) = (ui.ctx().clone(), environment.clone());
        std::thread::spawn(move || {
            // Fails only if another map was chosen meanwhile.
            if sender.send(thumbnail(&map, PICTURE)).is_ok() {
                context.request_repaint();
            }
        });
        Self { environment: environment.clone(), made, texture: None }
    }

    fn texture(&mut self, ui: &Ui) -> Option<&TextureHandle> {
        if let Ok(image) = self.made.try_recv() {
            let options = TextureOptions { wrap_mode: TextureWrapMode::Repeat, ..TextureOptions::LINEAR };
            self.texture = Some(ui.ctx().load_texture("environment", image, options));
        }
        self.texture.as_ref()
    }
}

/// Shows the picture with its marks and overlays.
pub fn show(ui: &mut Ui, state: &mut MapView, context: &EnvironmentContext, actions: &mut Vec<Action>) {
    let light = &context.document.environment;
    let width = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(vec2(width, 0.5 * width), Sense::drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Environment map"));
    let response = response.on_hover_cursor(CursorIcon::ResizeHorizontal);
    drag(&response, light, actions);
    let painter = ui.painter_at(rect);
    draw_map(ui, state, context, &painter, rect);
    let hovered = draw_overlay(&mut state.overlay, context, &painter, rect, &response);
    draw_compass(&painter, rect);
    if let Some(mark) = hovered {
        response.on_hover_text_at_pointer(mark_text(&mark));
    }
    choices(ui, &mut state.overlay, context);
}

/// Rotates the map with the pointer; a drag across the picture is one whole turn.
fn drag(response: &Response, light: &EnvironmentSettings, actions: &mut Vec<Action>) {
    let moved = response.drag_delta().x / response.rect.width().max(1.0);
    if response.dragged() && moved != 0.0 {
        let rotation_degrees = wrapped(light.rotation_degrees - 360.0 * moved);
        let edit = Edit::Environment(EnvironmentSettings { rotation_degrees, ..light.clone() });
        actions.push(Action::Edit { edit, label: "Rotation" });
    }
    if response.drag_stopped() {
        actions.push(Action::EndGesture);
    }
}

fn draw_map(ui: &Ui, state: &mut MapView, context: &EnvironmentContext, painter: &Painter, rect: Rect) {
    painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    let Some(environment) = context.environment else { return };
    let known = state.picture.take().filter(|p| Arc::ptr_eq(&p.environment, environment));
    let picture = state.picture.insert(known.unwrap_or_else(|| Picture::new(ui, environment)));
    if let Some(texture) = picture.texture(ui) {
        let left = map_left(context.document.environment.rotation());
        let uv = Rect::from_min_max(pos2(left, 0.0), pos2(left + 1.0, 1.0));
        painter.image(texture.id(), rect, uv, Color32::WHITE);
    }
}

/// Position in the map, 0 to 1, of the left edge of the picture when the map is turned by `rotation` radians: longitude `phi` in
/// the world is `phi - rotation` in the map, and `u = 1/2 - phi / 2π`.
fn map_left(rotation: f32) -> f32 {
    (rotation / TAU).rem_euclid(1.0)
}

fn draw_overlay(
    overlay: &mut Overlay,
    context: &EnvironmentContext,
    painter: &Painter,
    rect: Rect,
    response: &Response,
) -> Option<Mark> {
    let tree = context.tree?;
    if overlay.samples {
        overlay.draw_samples(painter, rect, tree, context.light_revision);
    }
    let lighting = context.lighting.filter(|_| overlay.cut)?;
    let pointer = response.hover_pos().filter(|_| !response.dragged());
    let hovered = overlay.draw_cut(painter, rect, lighting, context.light_revision, pointer)?;
    overlay::draw_leaves(painter, rect, tree, hovered.leaves.clone());
    Some(hovered)
}

/// Names of the axes along the lower edge, placed by `uv_from_direction`.
fn draw_compass(painter: &Painter, rect: Rect) {
    let font = FontId::proportional(11.0);
    let axes = [
        (0.0, "-Z", Align2::LEFT_BOTTOM),
        (0.25, "+X", Align2::CENTER_BOTTOM),
        (0.5, "+Z", Align2::CENTER_BOTTOM),
        (0.75, "-X", Align2::CENTER_BOTTOM),
        (1.0, "-Z", Align2::RIGHT_BOTTOM),
    ];
    for (u, name, align) in axes {
        let at = pos2(rect.left() + u * rect.width(), rect.bottom() - 2.0);
        painter.text(at + vec2(1.0, 1.0), align, name, font.clone(), Color32::from_black_alpha(200));
        painter.text(at, align, name, font.clone(), Color32::from_white_alpha(220));
    }
}

/// Tooltip of a node.
fn mark_text(mark: &Mark) -> String {
    let leaves = mark.leaves.len();
    let [r, g, b] = mark.radiance.to_array();
    format!(
        "Depth {}, {leaves} {}, {:.4} sr\nMean radiance {r:.3}, {g:.3}, {b:.3}",
        mark.depth,
        if leaves == 1 { "light" } else { "lights" },
        mark.solid_angle
    )
}

fn choices(ui: &mut Ui, overlay: &mut Overlay, context: &EnvironmentContext) {
    ui.add_enabled_ui(context.tree.is_some(), |ui| {
        ui.horizontal(|ui| {
            let missing = "Available after a bake.";
            let samples = check_box(ui, &mut overlay.samples, "Light samples").on_disabled_hover_text(missing);
            samples.on_hover_text("The leaves of the light tree, colored by subtree.");
            let deepest = context.tree.map_or(DEEPEST_SUBTREE, |t| t.height().min(DEEPEST_SUBTREE));
            // Always there, so that nothing moves when the samples are shown.
            let depth = DragValue::new(&mut overlay.subtree_depth).range(0..=deepest).speed(0.05);
            let depth = ui.add_enabled(overlay.samples, depth).accessible_name("Subtree depth");
            let help = "Depth of the subtrees whose samples share a color.";
            depth.on_hover_text(help).on_disabled_hover_text(help);
            let cut = check_box(ui, &mut overlay.cut, "Light cut").on_disabled_hover_text(missing);
            let merged = if context.document.view.cuts().size().is_some() {
                "The picture merges it with the vertices' cuts."
            } else {
                "The picture uses lit cuts instead."
            };
            cut.on_hover_text(format!(
                "The nodes of the illumination cut, sized by solid angle and shaded by light. {merged}"
            ));
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};
    use lapidary_core::environment::{direction_from_uv, uv_from_direction};

    #[test]
    fn the_picture_turns_as_the_light_does() {
        for (degrees, u) in [(0.0, 0.3), (90.0, 0.1), (-130.0, 0.77)] {
            let rotation = f32::to_radians(degrees);
            let world = direction_from_uv(glam::Vec2::new(u, 0.4));
            let in_map = uv_from_direction(Quat::from_rotation_y(-rotation) * world).x;
            let shown = (map_left(rotation) + u).rem_euclid(1.0);
            assert!((shown - in_map).abs() < 1e-5, "{degrees}: {shown} for {in_map}");
        }
        // Counter-clockwise from above: +Z comes to +X, a quarter to the left.
        let in_map = map_left(90_f32.to_radians()) + uv_from_direction(Vec3::X).x;
        assert!((in_map - 0.5).abs() < 1e-6);
    }
}
