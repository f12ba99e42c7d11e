//! Bounding boxes of the selection, drawn over the picture briefly after the selection changes.

use super::gizmo::Projection;
use egui::{Color32, Painter, Pos2, Rect, Stroke};
use glam::Vec3;
use lapidary_core::{bounds::Bounds, camera::Camera};

/// Seconds of the box at full strength, and of its fade.
const HOLD_SECS: f64 = 1.0;
const FADE_SECS: f64 = 0.35;

/// When the selection last changed.
#[derive(Clone, Debug, Default)]
pub struct Flash {
    objects: Vec<u32>,
    since: f64,
}

/// Opacity of the box, and time of the next paint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glow {
    /// 0 to 1.
    pub opacity: f32,
    /// Seconds until it changes; `None` if it stays.
    pub next_secs: Option<f32>,
}

impl Flash {
    /// Follows the selection; `now` is in seconds.
    pub fn update(&mut self, objects: &[u32], now: f64) -> Glow {
        if self.objects != objects {
            *self = Self { objects: objects.to_vec(), since: now };
        }
        let age = now - self.since;
        let fading = (1.0 - (age - HOLD_SECS) / FADE_SECS).clamp(0.0, 1.0) as f32;
        match objects {
            [_, ..] if age < HOLD_SECS => Glow { opacity: 1.0, next_secs: Some((HOLD_SECS - age) as f32) },
            [_, ..] if fading > 0.0 => Glow { opacity: fading, next_secs: Some(0.0) },
            _ => Glow { opacity: 0.0, next_secs: None },
        }
    }
}

/// Draws the box as `camera` sees it in `rect`.
pub fn paint(painter: &Painter, rect: Rect, camera: &Camera, bounds: Bounds, color: Color32) {
    for edge in edges(camera, bounds, rect) {
        painter.line_segment(edge, Stroke::new(3.0, Color32::from_black_alpha(color.a() / 3)));
        painter.line_segment(edge, Stroke::new(1.5, color));
    }
}

/// The edges of the box in front of the eye, in points.
fn edges(camera: &Camera, bounds: Bounds, rect: Rect) -> Vec<[Pos2; 2]> {
    let projection = Projection::new(camera, rect);
    let corner = |index: usize| {
        let pick = |axis: usize| if index >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let pairs = (0..8).flat_map(|a| (0..3).filter(move |axis| a >> axis & 1 == 0).map(move |axis| (a, a | 1 << axis)));
    pairs.filter_map(|(a, b)| projection.segment(corner(a), corner(b))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;

    const UNIT: Bounds = Bounds { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) };

    fn rect() -> Rect {
        Rect::from_min_size(Pos2::new(10.0, 20.0), vec2(400.0, 300.0))
    }

    #[test]
    fn a_box_before_the_eye_has_twelve_edges_around_the_centre() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 90.0);
        let edges = edges(&camera, UNIT, rect());
        assert_eq!(edges.len(), 12);
        let (width, height) = (0.5 / 2.5 * 150.0, 0.5 / 3.5 * 150.0);
        let reaches = |side: f32| edges.iter().flatten().any(|p| ((p.x - 210.0) - side).abs() < 1e-2);
        assert!(reaches(width) && reaches(-width) && reaches(height));
        assert!(edges.iter().flatten().all(|p| rect().contains(*p)));
    }

    #[test]
    fn edges_behind_the_eye_are_cut_or_dropped() {
        let inside = Camera::look_at(Vec3::new(0.1, 0.0, 0.0), Vec3::NEG_Z, 90.0);
        let cut = edges(&inside, UNIT, rect());
        assert_eq!(cut.len(), 8, "four ahead and four cut");
        assert!(cut.iter().flatten().all(|p| p.x.is_finite() && p.y.is_finite()));
        let past = Camera::look_at(Vec3::new(0.0, 0.0, -3.0), Vec3::new(0.0, 0.0, -5.0), 90.0);
        assert_eq!(edges(&past, UNIT, rect()).len(), 0);
    }

    #[test]
    fn it_holds_fades_and_then_asks_for_nothing() {
        let mut flash = Flash::default();
        assert_eq!(flash.update(&[], 5.0), Glow { opacity: 0.0, next_secs: None });
        assert_eq!(flash.update(&[2], 6.0), Glow { opacity: 1.0, next_secs: Some(1.0) });
        let fading = flash.update(&[2], 7.2);
        assert!(fading.opacity > 0.0 && fading.opacity < 1.0 && fading.next_secs == Some(0.0));
        assert_eq!(flash.update(&[2], 8.0), Glow { opacity: 0.0, next_secs: None });
        assert_eq!(flash.update(&[3, 2], 9.0).opacity, 1.0, "another selection starts again");
        assert_eq!(flash.update(&[], 9.1).opacity, 0.0);
    }
}
