//! Icons of the strips, drawn because the toolkit's font lacks them.

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Vec2, vec2};

/// Side of an icon in points.
const SIDE: f32 = 18.0;

/// An icon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    /// Objects in a list.
    Scene,
    /// A picture before another.
    Looks,
    /// Pictures to choose from.
    Library,
    /// A ball with a highlight.
    Material,
    /// A globe.
    Environment,
    /// A bulb.
    Lights,
    /// An eye.
    View,
    /// A cube with its edges.
    Bake,
}

/// Paints an icon in the middle of `rect`.
pub fn paint(painter: &Painter, rect: Rect, icon: Icon, color: Color32) {
    let pen = Pen { painter, place: Rect::from_center_size(rect.center(), Vec2::splat(SIDE)), color };
    match icon {
        Icon::Scene => pen.list(),
        Icon::Looks => pen.looks(),
        Icon::Library => pen.pictures(),
        Icon::Material => pen.ball(),
        Icon::Environment => pen.globe(),
        Icon::Lights => pen.bulb(),
        Icon::View => pen.eye(),
        Icon::Bake => pen.cube(),
    }
}

/// Draws in shares of the icon's square, 0 to 1.
struct Pen<'a> {
    painter: &'a Painter,
    place: Rect,
    color: Color32,
}

impl Pen<'_> {
    fn at(&self, x: f32, y: f32) -> Pos2 {
        self.place.lerp_inside(vec2(x, y))
    }

    fn stroke(&self) -> Stroke {
        Stroke::new(1.3, self.color)
    }

    fn line(&self, points: &[[f32; 2]]) {
        self.painter.add(Shape::line(points.iter().map(|&[x, y]| self.at(x, y)).collect(), self.stroke()));
    }

    fn circle(&self, [x, y]: [f32; 2], radius: f32) {
        self.painter.circle_stroke(self.at(x, y), radius * SIDE, self.stroke());
    }

    fn disc(&self, [x, y]: [f32; 2], radius: f32) {
        self.painter.circle_filled(self.at(x, y), radius * SIDE, self.color);
    }

    /// An ellipse, or the part of it between two angles in turns.
    fn ellipse(&self, [x, y]: [f32; 2], [across, down]: [f32; 2], turns: [f32; 2]) {
        let at = |i: u8| {
            let angle = std::f32::consts::TAU * (turns[0] + (turns[1] - turns[0]) * f32::from(i) / 24.0);
            [x + across * angle.cos(), y + down * angle.sin()]
        };
        self.line(&(0..=24).map(at).collect::<Vec<_>>());
    }

    fn list(&self) {
        for (i, indent) in [0.0, 0.2, 0.2].into_iter().enumerate() {
            let y = 0.2 + 0.3 * i as f32;
            self.disc([0.1 + indent, y], 0.07);
            self.line(&[[0.27 + indent, y], [0.95, y]]);
        }
    }

    fn pictures(&self) {
        for (x, y) in [(0.05, 0.05), (0.55, 0.05), (0.05, 0.55), (0.55, 0.55)] {
            let square = Rect::from_two_pos(self.at(x, y), self.at(x + 0.4, y + 0.4));
            self.painter.rect_stroke(square, 1.0, self.stroke(), StrokeKind::Inside);
        }
    }

    fn looks(&self) {
        self.line(&[[0.3, 0.3], [0.3, 0.08], [0.95, 0.08], [0.95, 0.65], [0.72, 0.65]]);
        let front = Rect::from_two_pos(self.at(0.05, 0.35), self.at(0.7, 0.92));
        self.painter.rect_stroke(front, 1.0, self.stroke(), StrokeKind::Inside);
    }

    fn ball(&self) {
        self.circle([0.5, 0.5], 0.44);
        self.disc([0.36, 0.34], 0.09);
        self.ellipse([0.5, 0.5], [0.27, 0.27], [0.05, 0.25]);
    }

    fn globe(&self) {
        self.circle([0.5, 0.5], 0.44);
        self.ellipse([0.5, 0.5], [0.18, 0.44], [0.0, 1.0]);
        self.line(&[[0.06, 0.5], [0.94, 0.5]]);
    }

    fn bulb(&self) {
        self.ellipse([0.5, 0.38], [0.3, 0.3], [0.35, 1.15]);
        self.line(&[[0.32, 0.62], [0.36, 0.76], [0.64, 0.76], [0.68, 0.62]]);
        self.line(&[[0.4, 0.92], [0.6, 0.92]]);
    }

    fn eye(&self) {
        let lid = |up: f32| {
            let at = |i: u8| {
                let x = f32::from(i) / 8.0 - 1.0;
                [0.5 + 0.46 * x, 0.5 - 0.3 * up * (1.0 - x * x)]
            };
            self.line(&(0..=16).map(at).collect::<Vec<_>>());
        };
        lid(1.0);
        lid(-1.0);
        self.disc([0.5, 0.5], 0.13);
    }

    fn cube(&self) {
        self.line(&[[0.5, 0.05], [0.9, 0.27], [0.9, 0.73], [0.5, 0.95], [0.1, 0.73], [0.1, 0.27], [0.5, 0.05]]);
        self.line(&[[0.1, 0.27], [0.5, 0.49], [0.9, 0.27]]);
        self.line(&[[0.5, 0.49], [0.5, 0.95]]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn icons_stay_in_their_square() {
        let all = [
            Icon::Scene,
            Icon::Looks,
            Icon::Library,
            Icon::Material,
            Icon::Environment,
            Icon::Lights,
            Icon::View,
            Icon::Bake,
        ];
        let place = Rect::from_min_size(pos2(10.0, 10.0), Vec2::splat(SIDE));
        for icon in all {
            let mut harness = egui_kittest::Harness::new_ui(|ui| paint(ui.painter(), place, icon, Color32::RED));
            harness.step();
            let red = |shape: &Shape| match shape {
                Shape::Path(path) => path.stroke.color == egui::epaint::ColorMode::Solid(Color32::RED),
                Shape::Circle(circle) => circle.fill == Color32::RED || circle.stroke.color == Color32::RED,
                Shape::Rect(rect) => rect.stroke.color == Color32::RED,
                _ => false,
            };
            let shapes: Vec<_> = harness.output().shapes.iter().filter(|s| red(&s.shape)).collect();
            assert!(!shapes.is_empty(), "{icon:?}");
            let bounds = shapes.iter().fold(Rect::NOTHING, |all, s| all | s.shape.visual_bounding_rect());
            assert!(place.expand(1.5).contains_rect(bounds), "{icon:?}: {bounds}");
        }
    }
}
