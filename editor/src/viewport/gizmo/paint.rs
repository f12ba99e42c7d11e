//! Paints lamps, handles and their hints over the picture.

use super::{Gizmo, Hot, View, ViewportContext, drag::Drag, icons::Icon};
use egui::{Align2, Color32, FontId, Painter, Rect, Ui, vec2};

/// More lights than this are drawn as lamps only.
const MOST_SHAPES: usize = 100;

/// Draws all lights, and the handles of the selection.
pub fn paint(ui: &Ui, rect: Rect, gizmo: &Gizmo, context: &ViewportContext) {
    let (painter, view) = (ui.painter_at(rect), View::new(ui, rect, context));
    // The accent of the panels is hardly visible on a dark picture.
    let accent = context.accent.lerp_to_gamma(Color32::WHITE, 0.45);
    if context.shows_lights {
        paint_lights(&painter, &view, gizmo, accent);
    }
    let hot = gizmo.hot.and_then(|hot| if let Hot::Handle(handle) = hot { Some(handle) } else { None });
    if let Some(handles) = view.handles() {
        handles.paint(&painter, hot, accent);
    }
    if let Some(place) = gizmo.pivot {
        place.paint(&painter, &view, accent);
    }
    if let Some(text) = words(&view, gizmo, hot.is_some()) {
        banner(&painter, rect, text);
    }
}

fn paint_lights(painter: &Painter, view: &View, gizmo: &Gizmo, accent: Color32) {
    let lights = &view.context.document.lights;
    for (index, light) in lights.iter().enumerate() {
        let (selected, hot) = (view.context.selected_light == Some(index), gizmo.hot == Some(Hot::Light(index)));
        let plain = lights.len() > MOST_SHAPES;
        Icon { painter, projection: &view.projection, accent, selected, hot, plain }.paint(light);
    }
}

/// Text on the running drag, or a hint on the hovered handle.
fn words(view: &View, gizmo: &Gizmo, is_hot: bool) -> Option<String> {
    if let Some(click) = view.context.click_for {
        return Some(click.words().into());
    }
    let hint = view.context.movable.as_ref().filter(|_| is_hot && view.light().is_none())?.hint(view);
    match gizmo.drag.as_ref().and_then(Drag::words) {
        Some(done) => Some(format!("{done} ({hint}, Esc: cancel)")),
        None => Some(hint),
    }
}

fn banner(painter: &Painter, rect: Rect, text: String) {
    let at = rect.center_top() + vec2(0.0, 16.0);
    let text = painter.layout_no_wrap(text, FontId::proportional(13.0), Color32::WHITE);
    let outer = Align2::CENTER_TOP.anchor_size(at, text.size() + vec2(16.0, 8.0));
    painter.rect_filled(outer, 4.0, Color32::from_black_alpha(170));
    painter.galley(outer.min + vec2(8.0, 4.0), text, Color32::WHITE);
}
