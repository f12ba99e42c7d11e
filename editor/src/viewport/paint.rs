//! Paints the picture and the text over it.

use super::{Behind, Faded, ViewportContext, ViewportState};
use egui::{
    Align2, Color32, ColorImage, FontId, Label, Rect, Stroke, StrokeKind, TextStyle, TextureHandle, TextureOptions, Ui,
    Vec2, pos2, vec2,
};

/// Side of a square of the checkerboard in points.
const SQUARE: f32 = 12.0;

/// Distance of text from the edges of the picture, and margin around it.
const MARGIN: f32 = 12.0;
const PADDING: Vec2 = vec2(8.0, 4.0);

/// Paints the picture, or a plain background if there is none yet.
pub fn picture(ui: &Ui, rect: Rect, state: &mut ViewportState, context: &ViewportContext) {
    let painter = ui.painter_at(rect);
    let picture = context.picture.filter(|_| context.placeholder.is_none());
    let (place, part) = placed(context.picture_size, rect);
    // Nothing is painted under a picture: where graphics are emulated, each layer takes time from the renderer.
    if picture.is_none() || !place.contains_rect(rect) {
        painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
    }
    let Some(picture) = picture else { return };
    match context.behind {
        Behind::Nothing => {}
        Behind::Checker => {
            let checker = state.checker.get_or_insert_with(|| checker_texture(ui));
            let uv = Rect::from_min_size(pos2(0.0, 0.0), rect.size() / (2.0 * SQUARE));
            painter.image(checker.id(), rect, uv, Color32::WHITE);
        }
        Behind::Plate(texture, uv) => _ = painter.image(texture, rect, uv, Color32::WHITE),
    }
    painter.image(picture, place, part, Color32::WHITE);
    if let Some(Faded { texture, size, opacity }) = context.faded {
        let (place, part) = placed(size, rect);
        painter.image(texture, place, part, Color32::WHITE.gamma_multiply(opacity));
    }
}

/// Rectangle of a picture in a viewport whose shape may have changed, and its visible part in texture coordinates. The field of
/// view is vertical, so the picture is as high as the viewport, and everything in it is where the next picture will have it. If it
/// is too narrow, the background shows beside it.
fn placed(picture: [u32; 2], rect: Rect) -> (Rect, Rect) {
    let size = vec2(picture[0] as f32, picture[1] as f32);
    let scale = rect.height() / size.y;
    // A coarser picture is too narrow by less than a texel, by rounding, which is no gap.
    let is_narrow = (size.x + 1.0) * scale < rect.width();
    let place = if is_narrow { Rect::from_center_size(rect.center(), scale * size) } else { rect };
    let share = place.size() / (scale.max(place.width() / size.x) * size);
    let share = if share.is_finite() { share } else { Vec2::splat(1.0) };
    (place, Rect::from_center_size(pos2(0.5, 0.5), share))
}

fn checker_texture(ui: &Ui) -> TextureHandle {
    let [dark, light] = [Color32::from_gray(96), Color32::from_gray(128)];
    let image = ColorImage::new([2, 2], vec![dark, light, light, dark]);
    ui.ctx().load_texture("checkerboard", image, TextureOptions::NEAREST_REPEAT)
}

/// Badges: the running work, and whether the bake is out of date.
pub fn badges(ui: &mut Ui, rect: Rect, context: &ViewportContext) {
    if context.stale {
        let warning = ui.visuals().warn_fg_color;
        badge(ui, rect, Align2::LEFT_TOP, "Bake is out of date", warning);
    }
    if let Some(busy) = context.busy {
        badge(ui, rect, Align2::LEFT_BOTTOM, busy, Color32::from_gray(235));
    }
}

fn badge(ui: &mut Ui, rect: Rect, align: Align2, text: &str, color: Color32) {
    let galley = ui.painter().layout_no_wrap(text.into(), TextStyle::Small.resolve(ui.style()), color);
    let outer = align.align_size_within_rect(galley.size() + 2.0 * PADDING, rect.shrink(MARGIN));
    ui.painter_at(rect).rect_filled(outer, 4.0, Color32::from_black_alpha(150));
    ui.put(outer.shrink2(PADDING), Label::new(galley).selectable(false));
}

/// Shows a text in place of a picture.
pub fn placeholder(ui: &mut Ui, rect: Rect, text: &str) {
    let color = ui.visuals().weak_text_color();
    let body = TextStyle::Body.resolve(ui.style());
    let galley = ui.painter().layout(text.into(), body, color, (rect.width() - 2.0 * MARGIN).max(1.0));
    let place = Align2::CENTER_CENTER.align_size_within_rect(galley.size(), rect);
    ui.put(place, Label::new(galley).selectable(false));
}

/// Hints at dropping while files hover over the window.
pub fn drop_hint(ui: &mut Ui, rect: Rect, accent: Color32) {
    if ui.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, Color32::from_black_alpha(120));
    painter.rect_stroke(rect.shrink(2.0), 0.0, Stroke::new(2.0, accent), StrokeKind::Inside);
    painter.text(rect.center(), Align2::CENTER_CENTER, "Drop to open", FontId::proportional(18.0), Color32::WHITE);
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));

    /// Width by height of a texel on the screen.
    fn texel_aspect(picture: [u32; 2], rect: Rect) -> f32 {
        let (place, uv) = placed(picture, rect);
        (place.width() / (uv.width() * picture[0] as f32)) / (place.height() / (uv.height() * picture[1] as f32))
    }

    #[test]
    fn a_picture_is_as_high_as_the_viewport_and_never_stretched() {
        let rect = Rect::from_min_size(pos2(20.0, 10.0), vec2(800.0, 600.0));
        assert_eq!(placed([800, 600], rect), (rect, ALL));
        for picture in [[400, 300], [800, 100], [33, 600], [266, 200], [1, 1]] {
            assert!((texel_aspect(picture, rect) - 1.0).abs() < 1e-4, "{picture:?}");
            let (place, uv) = placed(picture, rect);
            assert!(rect.contains_rect(place) && ALL.expand(1e-6).contains_rect(uv), "{picture:?}: {place} {uv}");
        }
        let (place, uv) = placed([1600, 600], rect);
        assert!(place == rect && uv.width() == 0.5 && uv.height() == 1.0, "wider: cut at the sides");
        let (place, uv) = placed([400, 600], rect);
        assert!(place.width() == 400.0 && place.center() == rect.center() && uv == ALL, "narrower: ground beside it");
        assert_eq!(placed([266, 200], rect).0, rect, "narrower by rounding: no gap");
        assert!(
            placed([0, 0], rect).1.is_finite()
                && placed([4, 4], Rect::from_min_size(rect.min, Vec2::ZERO)).1.is_finite()
        );
    }
}
