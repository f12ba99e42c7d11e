//! Icons of lights: a lamp in the color of its light, and the shape of its emission.

use super::projection::Projection;
use crate::widgets::display_color;
use egui::{Align2, Color32, FontId, Painter, Pos2, Stroke, Vec2, vec2};
use glam::Vec3;
use lapidary_core::lights::{Emission, Light, RectangleShape};
use std::f32::consts::TAU;

/// Radius of a lamp in points, and largest distance of a click.
const LAMP: f32 = 5.0;
pub const REACH: f32 = 11.0;
/// Length in points of the shapes of unselected lights, and least length for a selected light.
const SHORT: f32 = 42.0;
const ROUND: u32 = 40;
/// Widest drawn cone: the base of a wider one would be far away.
const WIDEST_CONE_DEGREES: f32 = 80.0;

/// Drawing of a light.
pub struct Icon<'a> {
    /// The painter.
    pub painter: &'a Painter,
    /// The projection.
    pub projection: &'a Projection,
    /// Color of the selection.
    pub accent: Color32,
    /// Whether the light is selected.
    pub selected: bool,
    /// Whether the pointer is on the light.
    pub hot: bool,
    /// Whether only lamps are drawn, since there are many lights.
    pub plain: bool,
}

impl Icon<'_> {
    /// Draws `light`, unless it is behind the eye.
    pub fn paint(&self, light: &Light) {
        let (Some(at), Some(scale)) =
            (self.projection.point(light.position), self.projection.metres_per_point(light.position))
        else {
            return;
        };
        if self.plain && !self.selected && !self.hot {
            return self.lamp(at, light);
        }
        let forward = light.forward().unwrap_or(Vec3::NEG_Y);
        match light.emission {
            Emission::Point => self.rays(at),
            Emission::Spot { cone_degrees, penumbra_degrees } => {
                let length = if self.selected { light.position.distance(light.target) } else { SHORT * scale };
                self.cone(light.position, forward, length, [cone_degrees, cone_degrees - penumbra_degrees]);
            }
            Emission::Directional { .. } => self.beams(light.position, forward, scale),
            Emission::Rectangle { .. } => self.panel(light, forward, scale),
        }
        if self.selected && light.emission.is_aimed() {
            self.dashes(light.position, light.target);
        }
        self.lamp(at, light);
    }

    fn color(&self) -> Color32 {
        if self.selected || self.hot { self.accent } else { Color32::from_gray(215) }
    }

    /// A line with a dark edge, visible on any picture.
    fn line(&self, a: Vec3, b: Vec3) {
        if let Some(seen) = self.projection.segment(a, b) {
            self.painter.line_segment(seen, Stroke::new(3.0, Color32::from_black_alpha(90)));
            self.painter.line_segment(seen, Stroke::new(1.2, self.color()));
        }
    }

    fn loop_of(&self, corners: &[Vec3]) {
        for (i, &corner) in corners.iter().enumerate() {
            self.line(corner, corners[(i + 1) % corners.len()]);
        }
    }

    fn dashes(&self, from: Vec3, to: Vec3) {
        if let Some(seen) = self.projection.segment(from, to) {
            let stroke = Stroke::new(1.0, self.color().gamma_multiply(0.8));
            self.painter.extend(egui::Shape::dashed_line(&seen, stroke, 5.0, 4.0));
        }
    }

    fn rays(&self, at: Pos2) {
        for i in 0..8 {
            let out = Vec2::angled(i as f32 / 8.0 * TAU);
            let ray = [at + (LAMP + 2.5) * out, at + (LAMP + 6.5) * out];
            self.painter.line_segment(ray, Stroke::new(3.0, Color32::from_black_alpha(90)));
            self.painter.line_segment(ray, Stroke::new(1.2, self.color()));
        }
    }

    /// The cone, and the inner cone where the light begins to fall off.
    fn cone(&self, apex: Vec3, axis: Vec3, length: f32, [edge, core]: [f32; 2]) {
        let base = |degrees: f32| {
            let radius = length * degrees.min(WIDEST_CONE_DEGREES).to_radians().tan();
            circle(apex + length * axis, axis, radius)
        };
        let rim = base(edge);
        self.loop_of(&rim);
        for corner in rim.iter().step_by((ROUND / 4) as usize) {
            self.line(apex, *corner);
        }
        if self.selected && core > 0.0 && core < edge {
            let inner = base(core);
            inner.chunks(2).for_each(|dash| self.line(dash[0], dash[1]));
        }
    }

    /// Three parallel arrows.
    fn beams(&self, at: Vec3, forward: Vec3, scale: f32) {
        for around in circle(at, forward, 9.0 * scale).into_iter().step_by((ROUND / 4) as usize) {
            self.line(around, around + SHORT * scale * forward);
        }
        let tip = at + (SHORT + 12.0) * scale * forward;
        self.line(at, tip);
        for around in circle(tip - 9.0 * scale * forward, forward, 4.0 * scale).into_iter().step_by(10) {
            self.line(tip, around);
        }
    }

    /// The outline in its true size, and the side that shines.
    fn panel(&self, light: &Light, forward: Vec3, scale: f32) {
        let Some(shape) = RectangleShape::of(light) else { return };
        let corners = shape.corners();
        self.loop_of(&corners);
        self.line(light.position, light.position + 0.6 * SHORT * scale * forward);
        for corner in corners {
            self.line(corner, corner + 0.2 * SHORT * scale * forward);
        }
    }

    fn lamp(&self, at: Pos2, light: &Light) {
        let fill = if light.enabled { display_color(light.intensity) } else { Color32::from_gray(70) };
        self.painter.circle(at, LAMP, fill, Stroke::new(1.5, Color32::from_black_alpha(200)));
        if !light.enabled {
            let across = vec2(LAMP, LAMP);
            self.painter.line_segment([at - across, at + across], Stroke::new(1.5, Color32::from_gray(215)));
        }
        if self.hot || self.selected {
            let below = at + vec2(0.0, 16.0);
            for (offset, color) in [(vec2(1.0, 1.0), Color32::from_black_alpha(200)), (Vec2::ZERO, Color32::WHITE)] {
                let font = FontId::proportional(11.0);
                self.painter.text(below + offset, Align2::CENTER_TOP, &light.name, font, color);
            }
        }
    }
}

fn circle(center: Vec3, normal: Vec3, radius: f32) -> Vec<Vec3> {
    let (u, v) = normal.any_orthonormal_pair();
    let at = |i: u32| {
        let (sin, cos) = (i as f32 / ROUND as f32 * TAU).sin_cos();
        center + radius * (cos * u + sin * v)
    };
    (0..ROUND).map(at).collect()
}
