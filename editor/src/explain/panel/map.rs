//! The merged cut as a latitude-longitude picture, beside the result of rays.

use egui::{Color32, ColorImage, Rect, Role, Sense, Stroke, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2};
use lapidary_core::{color::codes, environment::uv_from_direction, image::Image};
use lapidary_render::{CutMap, ExplainedNode, compare::tonemap};
use std::sync::Arc;

/// Radius of the mark of a node in points.
const MARK: f32 = 5.0;

/// The shown picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapPicture {
    /// Clusters with their mean light.
    #[default]
    Cut,
    /// The light that rays find.
    Traced,
    /// Interpolated against traced visibility.
    Visibility,
}

/// The picture drawn last.
#[derive(Default)]
pub struct MapView {
    /// The chosen picture.
    pub picture: MapPicture,
    drawn: Option<(Arc<CutMap>, MapPicture, TextureHandle)>,
}

impl MapView {
    /// Shows the choice and the picture, with a mark at the hovered node.
    pub fn show(&mut self, ui: &mut Ui, map: &Arc<CutMap>, hovered: Option<&ExplainedNode>) {
        if map.visibility.is_none() && self.picture == MapPicture::Visibility {
            self.picture = MapPicture::Cut;
        }
        self.choices(ui, map.visibility.is_some());
        let width = ui.available_width();
        let (rect, response) = ui.allocate_exact_size(vec2(width, 0.5 * width), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Merged cut on the map of directions"));
        let texture = self.texture(ui, map);
        let painter = ui.painter_at(rect);
        painter.image(texture.id(), rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        if let Some(node) = hovered {
            let uv = uv_from_direction(node.direction);
            let at = rect.min + vec2(uv.x, uv.y) * rect.size();
            painter.circle_stroke(at, MARK, Stroke::new(3.0, Color32::BLACK));
            painter.circle_stroke(at, MARK, Stroke::new(1.0, Color32::WHITE));
        }
    }

    fn choices(&mut self, ui: &mut Ui, has_visibility: bool) {
        ui.horizontal(|ui| {
            let mut choice = |picture, name, help, enabled| {
                ui.add_enabled_ui(enabled, |ui| {
                    ui.selectable_value(&mut self.picture, picture, name)
                        .on_hover_text(help)
                        .on_disabled_hover_text("For surface sources, visibility is part of the solid angle.");
                });
            };
            choice(MapPicture::Cut, "Cut", "The mean light of each cluster times its visibility.", true);
            choice(MapPicture::Traced, "Rays", "The light found by rays from the pixel.", true);
            let help = "Red: the cuts let blocked light through. Blue: the cuts block visible light.";
            choice(MapPicture::Visibility, "Difference", help, has_visibility);
        });
    }

    fn texture(&mut self, ui: &Ui, map: &Arc<CutMap>) -> &TextureHandle {
        let picture = self.picture;
        let known = self.drawn.take().filter(|(of, shown, _)| Arc::ptr_eq(of, map) && *shown == picture);
        let draw = || {
            let image = color_image(&pixels(map, picture));
            (map.clone(), picture, ui.ctx().load_texture("merged cut", image, TextureOptions::LINEAR))
        };
        &self.drawn.insert(known.unwrap_or_else(draw)).2
    }
}

/// Linear values of the shown picture.
fn pixels(map: &CutMap, picture: MapPicture) -> Image {
    let exposure = map.exposure();
    match (picture, &map.visibility) {
        (MapPicture::Visibility, Some(visibility)) => visibility.clone(),
        (MapPicture::Traced, _) => map.traced.scaled(exposure),
        _ => map.with_borders(exposure),
    }
}

fn color_image(image: &Image) -> ColorImage {
    let pixels = tonemap::display(image).pixels.into_iter().map(codes).map(|[r, g, b]| Color32::from_rgb(r, g, b));
    ColorImage::new([image.width(), image.height()], pixels.collect())
}
