//! The reference beside or over the picture, and the map of errors.

use super::{gizmo::Projection, legend};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, StrokeKind, TextureId, Ui, Vec2, pos2, vec2};
use glam::Vec3;
use lapidary_core::camera::Camera;
use lapidary_render::compare::map::ErrorField;

const LINE: Stroke = Stroke { width: 1.5, color: Color32::from_gray(235) };
/// Distance of labels from edges and the line, and room in them.
const MARGIN: f32 = 10.0;
const PADDING: Vec2 = vec2(7.0, 3.0);
/// Half the size of the cross on a pixel in points.
const CROSS: f32 = 7.0;

/// How picture and reference are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompareView {
    /// The picture alone.
    Picture,
    /// The reference alone.
    Reference,
    /// The picture to the left of a line, the reference to the right.
    #[default]
    Swipe,
    /// Both whole.
    SideBySide,
    /// The map of errors.
    Difference,
}

impl CompareView {
    /// All views, each with its label and tooltip.
    pub const ALL: [(Self, &str, &str); 5] = [
        (Self::Picture, "A", "The picture with cuts"),
        (Self::Reference, "B", "The reference; hold R to see it for a moment in any view"),
        (Self::Swipe, "A | B", "Picture to the left of a draggable line, reference to the right"),
        (Self::SideBySide, "Side by side", "Both pictures in full"),
        (Self::Difference, "Difference", "Map of the differences"),
    ];
}

/// A node of the explained pixel with a position in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeMark {
    /// Middle of its sources, in meters.
    pub center: Vec3,
    /// Its contribution over the largest one.
    pub share: f32,
    /// Whether the pointer is on its row of the table.
    pub hovered: bool,
}

/// The shown comparison.
pub struct Compared<'a> {
    /// How both are shown.
    pub view: CompareView,
    /// Position of the line, as a share of the width.
    pub swipe: f32,
    /// The displayed reference, and its size in pixels.
    pub reference: Option<(TextureId, [u32; 2])>,
    /// The map of errors, and the shares of the picture that it covers.
    pub map: Option<(TextureId, [f32; 4])>,
    /// The error in the map.
    pub field: Option<&'a ErrorField>,
    /// Labels of picture and reference.
    pub labels: [String; 2],
    /// The measured region, in shares of the viewport.
    pub region: Option<[f32; 4]>,
    /// Color of its outline.
    pub accent: Color32,
    /// The middle of the explained pixel, in shares of the viewport.
    pub explained: Option<[f32; 2]>,
    /// The nodes from which its light comes.
    pub marks: Vec<NodeMark>,
}

/// Paints over the picture, which is painted already.
pub fn paint(ui: &Ui, rect: Rect, camera: &Camera, picture: Option<(TextureId, [u32; 2])>, compared: &Compared) {
    let painter = ui.painter_at(rect);
    match (compared.view, compared.reference) {
        (CompareView::Reference, Some(reference)) => {
            painter.rect_filled(rect, 0.0, Color32::BLACK);
            image(&painter, rect, reference);
            label(&painter, rect.center_top(), Align2::CENTER_TOP, &compared.labels[1]);
        }
        (CompareView::Swipe, Some(reference)) => swipe(&painter, rect, reference, compared),
        (CompareView::SideBySide, Some(reference)) => {
            painter.rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
            side_by_side(&painter, rect, [picture, Some(reference)], &compared.labels);
        }
        (CompareView::Difference, Some(_)) => difference(&painter, rect, compared),
        _ => label(&painter, rect.center_top(), Align2::CENTER_TOP, &compared.labels[0]),
    }
    if let Some(region) = compared.region.filter(|_| compared.view != CompareView::SideBySide) {
        let outline = Stroke::new(1.5, compared.accent);
        painter.rect_stroke(part_of(rect, region), 0.0, outline, StrokeKind::Outside);
    }
    if compared.view != CompareView::SideBySide {
        explained(&painter, rect, camera, compared);
    }
}

fn image(painter: &Painter, rect: Rect, (texture, size): (TextureId, [u32; 2])) {
    let all = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    painter.image(texture, placed(size, rect), all, Color32::WHITE);
}

/// The rectangle of a picture of another shape, as high as the viewport, since the field of view is vertical.
fn placed([width, height]: [u32; 2], rect: Rect) -> Rect {
    let width = rect.height() * width as f32 / height.max(1) as f32;
    Rect::from_center_size(rect.center(), vec2(width, rect.height()))
}

fn swipe(painter: &Painter, rect: Rect, reference: (TextureId, [u32; 2]), compared: &Compared) {
    let x = line_at(rect, compared.swipe);
    let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
    let clipped = painter.with_clip_rect(right);
    clipped.rect_filled(right, 0.0, Color32::BLACK);
    image(&clipped, rect, reference);
    painter.vline(x, rect.y_range(), LINE);
    painter.circle_filled(pos2(x, rect.center().y), 4.0, LINE.color);
    label(painter, pos2(x - MARGIN, rect.top()), Align2::RIGHT_TOP, &compared.labels[0]);
    label(painter, pos2(x + MARGIN, rect.top()), Align2::LEFT_TOP, &compared.labels[1]);
}

fn side_by_side(painter: &Painter, rect: Rect, shown: [Option<(TextureId, [u32; 2])>; 2], labels: &[String; 2]) {
    let (left, right) = rect.split_left_right_at_fraction(0.5);
    for ((half, picture), text) in [left, right].into_iter().zip(shown).zip(labels) {
        if let Some((texture, size)) = picture {
            let size = vec2(size[0] as f32, size[1] as f32);
            let fitted = size * (half.size() / size).min_elem();
            let place = Align2::CENTER_CENTER.align_size_within_rect(fitted, half);
            painter.image(texture, place, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
        }
        label(painter, half.center_top(), Align2::CENTER_TOP, text);
    }
    painter.vline(rect.center().x, rect.y_range(), LINE);
}

fn difference(painter: &Painter, rect: Rect, compared: &Compared) {
    let (Some((texture, part)), Some(field)) = (compared.map, compared.field) else { return };
    let Some((_, size)) = compared.reference else { return };
    painter.rect_filled(rect, 0.0, Color32::from_black_alpha(170));
    let uv = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
    painter.image(texture, part_of(placed(size, rect), part), uv, Color32::WHITE);
    legend::errors(painter, rect, field);
    label(painter, rect.center_top(), Align2::CENTER_TOP, &format!("{}; {}", compared.labels[0], compared.labels[1]));
}

/// A cross at the explained pixel, and discs where its light comes from, larger for more light.
fn explained(painter: &Painter, rect: Rect, camera: &Camera, compared: &Compared) {
    let projection = Projection::new(camera, rect);
    for mark in &compared.marks {
        let Some(at) = projection.point(mark.center) else { continue };
        let color = if mark.hovered { Color32::WHITE } else { compared.accent };
        painter.circle(at, 2.0 + 7.0 * mark.share.sqrt(), color.gamma_multiply(0.35), Stroke::new(1.0, color));
    }
    if let Some([x, y]) = compared.explained {
        let at = rect.min + vec2(x, y) * rect.size();
        for (width, color) in [(3.0, Color32::BLACK), (1.0, Color32::WHITE)] {
            painter.hline(at.x - CROSS..=at.x + CROSS, at.y, Stroke::new(width, color));
            painter.vline(at.x, at.y - CROSS..=at.y + CROSS, Stroke::new(width, color));
        }
    }
}

/// The part of a rectangle at these shares of its width and height: left, top, right, bottom.
pub fn part_of(rect: Rect, [left, top, right, bottom]: [f32; 4]) -> Rect {
    let at = |x: f32, y: f32| rect.min + vec2(x, y) * rect.size();
    Rect::from_min_max(at(left, top), at(right, bottom))
}

/// The position of the line between both.
pub fn line_at(rect: Rect, share: f32) -> f32 {
    rect.left() + share.clamp(0.0, 1.0) * rect.width()
}

/// Text on a dark background, at a distance from an edge of the picture.
fn label(painter: &Painter, at: Pos2, align: Align2, text: &str) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), Color32::from_gray(235));
    let ground = align.anchor_size(at + vec2(0.0, MARGIN), galley.size() + 2.0 * PADDING);
    painter.rect_filled(ground, 4.0, Color32::from_black_alpha(150));
    painter.galley(ground.min + PADDING, galley, Color32::WHITE);
}
