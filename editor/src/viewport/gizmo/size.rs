//! Scale handle of an object: a square at the end of a line from its center.

use super::{
    handles::{AXIS, Handle, REACH, distance_to_segment},
    projection::Projection,
};
use egui::{Color32, Painter, Pos2, Rect, Stroke, StrokeKind, Vec2, vec2};
use glam::Vec3;
use std::f32::consts::FRAC_1_SQRT_2;

/// Half the side of the square in points.
const HALF: f32 = 5.0;
/// Least factor of a drag.
const LEAST_FACTOR: f32 = 0.01;
/// Direction of the square from the center: up and to the right, as far out as the tips of arrows.
const OUT: Vec2 = vec2(FRAC_1_SQRT_2, -FRAC_1_SQRT_2);

/// The projected handle.
pub struct SizeHandle {
    center: Pos2,
}

impl SizeHandle {
    /// The handle at a position; `None` behind the eye.
    pub fn of(center: Vec3, projection: &Projection) -> Option<Self> {
        Some(Self { center: projection.point(center)? })
    }

    fn tip(&self) -> Pos2 {
        self.center + AXIS * OUT
    }

    /// The handle, if the pointer is on it.
    pub fn at(&self, pointer: Pos2) -> Option<Handle> {
        let near = distance_to_segment(pointer, self.center, self.tip()) <= REACH;
        let clear = self.center.distance(pointer) > 2.0 * REACH;
        (near && clear).then_some(Handle::Size)
    }

    /// The factor of a drag, above 0: the pointer's distance from the center over that at the start.
    pub fn factor(&self, grabbed: Pos2, pointer: Pos2) -> f32 {
        ((pointer - self.center).dot(OUT) / (grabbed - self.center).dot(OUT)).max(LEAST_FACTOR)
    }

    /// Draws the handle, `hot` brighter.
    pub fn paint(&self, painter: &Painter, hot: Option<Handle>, accent: Color32) {
        let color = if hot == Some(Handle::Size) { Color32::WHITE } else { accent };
        let dark = Color32::from_black_alpha(110);
        for stroke in [Stroke::new(4.0, dark), Stroke::new(2.0, color)] {
            painter.line_segment([self.center, self.tip()], stroke);
        }
        let square = Rect::from_center_size(self.tip(), Vec2::splat(2.0 * HALF));
        painter.rect_filled(square, 0.0, color);
        painter.rect_stroke(square, 0.0, Stroke::new(1.0, dark), StrokeKind::Outside);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn twice_as_far_out_is_twice_as_large() {
        let handle = SizeHandle { center: pos2(100.0, 200.0) };
        let grabbed = handle.tip();
        assert_eq!(handle.at(grabbed), Some(Handle::Size));
        assert_eq!(handle.at(handle.center), None, "the centre is for clicks");
        let factor = |out: f32| handle.factor(grabbed, handle.center + out * AXIS * OUT);
        assert!([0.5, 1.0, 2.0].iter().all(|&out| (factor(out) - out).abs() < 1e-5));
        assert_eq!(factor(-3.0), LEAST_FACTOR, "beyond the centre");
        let beside = handle.factor(grabbed, grabbed + 30.0 * OUT.rot90());
        assert!((beside - 1.0).abs() < 1e-5, "negative control: across the line: {beside}");
    }
}
