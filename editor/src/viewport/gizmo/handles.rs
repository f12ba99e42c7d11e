//! Move handles of the selected light or object: three axes, the planes between them, a disc for the plane of the view, and the
//! target of an aimed light.

use super::projection::Projection;
use egui::{Color32, Painter, Pos2, Shape, Stroke, Vec2, vec2};
use glam::Vec3;

/// Length of an axis in points, and start of its grabbable part.
pub const AXIS: f32 = 84.0;
const AXIS_FROM: f32 = 0.22;
/// Start and end of the square of a plane, in lengths of an axis.
const PLANE: [f32; 2] = [0.28, 0.46];
/// Radii of the disc in the middle and of the target in points.
const FREE_RADIUS: f32 = 9.0;
const TARGET_RADIUS: f32 = 8.0;
/// Largest distance of the pointer from a line, in points.
pub const REACH: f32 = 7.0;
/// Axes and planes foreshortened to less than this share cannot be dragged.
pub const LEAST_SEEN: f32 = 0.16;

/// The axes of the world and their colors.
pub const AXES: [Vec3; 3] = Vec3::AXES;
pub const COLORS: [Color32; 3] =
    [Color32::from_rgb(235, 87, 87), Color32::from_rgb(111, 191, 78), Color32::from_rgb(86, 146, 245)];

/// A handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Along X, Y or Z.
    Axis(usize),
    /// In the plane across X, Y or Z.
    Plane(usize),
    /// In the plane of the view.
    Free,
    /// The target of the light.
    Target,
    /// About an axis of turns, by its number.
    Ring(usize),
    /// Larger or smaller.
    Size,
}

impl Handle {
    /// The constraint of a drag, if it moves something.
    pub fn constraint(self, forward: Vec3) -> Option<Constraint> {
        match self {
            Self::Axis(axis) => Some(Constraint::Line(AXES[axis])),
            Self::Plane(axis) => Some(Constraint::Plane(AXES[axis])),
            Self::Free | Self::Target => Some(Constraint::Plane(forward)),
            Self::Ring(_) | Self::Size => None,
        }
    }

    /// Whether it lies on the middle of an object, so that clicks go through.
    pub fn is_for_clicks(self) -> bool {
        self == Self::Free
    }
}

/// The positions that a drag can reach, through its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constraint {
    /// Along a unit direction.
    Line(Vec3),
    /// Across a unit normal.
    Plane(Vec3),
}

impl Constraint {
    /// The position nearest to the pointer's ray; `None` if they hardly meet, or behind the eye.
    pub fn meet(self, through: Vec3, eye: Vec3, direction: Vec3) -> Option<Vec3> {
        let to_origin = through - eye;
        let place = match self {
            Self::Line(axis) => {
                let cos = axis.dot(direction);
                let sin_sq = 1.0 - cos * cos;
                if !(sin_sq > 1e-4) {
                    return None;
                }
                through + axis * ((cos * direction.dot(to_origin) - axis.dot(to_origin)) / sin_sq)
            }
            Self::Plane(normal) => {
                let cos = normal.dot(direction);
                if !(cos.abs() > 1e-3) {
                    return None;
                }
                eye + direction * (normal.dot(to_origin) / cos)
            }
        };
        let is_ahead = (place - eye).dot(direction) > 0.0;
        // Near the horizon of a plane, a point of the screen covers any distance.
        let is_near = place.distance(eye) < 1e3 * to_origin.length().max(1e-3);
        (is_ahead && is_near).then_some(place)
    }
}

/// The handles at a position, projected.
pub struct Handles {
    center: Pos2,
    axes: [Option<[Pos2; 2]>; 3],
    planes: [Option<[Pos2; 4]>; 3],
    target: Option<Pos2>,
}

impl Handles {
    /// The handles of a position and its target; `None` behind the eye.
    pub fn of(place: Vec3, target: Option<Vec3>, projection: &Projection) -> Option<Self> {
        let center = projection.point(place)?;
        let length = AXIS * projection.metres_per_point(place)?;
        let at = |offset: Vec3| projection.point(place + length * offset);
        let toward_eye = (projection.eye() - place).normalize_or(Vec3::Z);
        let axis = |i: usize| {
            let tips = [at(AXIS_FROM * AXES[i])?, at(AXES[i])?];
            (AXES[i].cross(toward_eye).length() > LEAST_SEEN).then_some(tips)
        };
        let plane = |i: usize| {
            let (u, v) = (AXES[(i + 1) % 3], AXES[(i + 2) % 3]);
            let [near, far] = PLANE;
            let corner = |a: f32, b: f32| at(a * u + b * v);
            let corners = [corner(near, near)?, corner(far, near)?, corner(far, far)?, corner(near, far)?];
            (AXES[i].dot(toward_eye).abs() > LEAST_SEEN).then_some(corners)
        };
        let target = target.and_then(|target| projection.point(target));
        Some(Self { center, axes: [0, 1, 2].map(axis), planes: [0, 1, 2].map(plane), target })
    }

    /// The handle under the pointer.
    pub fn at(&self, pointer: Pos2) -> Option<Handle> {
        if self.center.distance(pointer) <= FREE_RADIUS {
            return Some(Handle::Free);
        }
        if self.target.is_some_and(|target| target.distance(pointer) <= TARGET_RADIUS + 2.0) {
            return Some(Handle::Target);
        }
        let in_plane = |i: &usize| self.planes[*i].is_some_and(|corners| contains(&corners, pointer));
        if let Some(i) = (0..3).find(in_plane) {
            return Some(Handle::Plane(i));
        }
        let distance = |i: usize| self.axes[i].map(|[a, b]| (i, distance_to_segment(pointer, a, b)));
        let nearest = (0..3).filter_map(distance).min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= REACH).map(|(i, _)| Handle::Axis(i))
    }

    /// Draws the handles, `hot` brighter.
    pub fn paint(&self, painter: &Painter, hot: Option<Handle>, accent: Color32) {
        let tint = |handle: Handle, color: Color32| if hot == Some(handle) { Color32::WHITE } else { color };
        for (i, corners) in self.planes.iter().enumerate() {
            let Some(corners) = corners else { continue };
            let color = tint(Handle::Plane(i), COLORS[i]);
            let stroke = Stroke::new(1.0, color);
            painter.add(Shape::convex_polygon(corners.to_vec(), color.gamma_multiply(0.35), stroke));
        }
        for (i, ends) in self.axes.iter().enumerate() {
            if let Some(ends) = ends {
                arrow(painter, *ends, tint(Handle::Axis(i), COLORS[i]));
            }
        }
        let free = tint(Handle::Free, accent);
        painter.circle_stroke(self.center, FREE_RADIUS, Stroke::new(3.5, Color32::from_black_alpha(110)));
        painter.circle_stroke(self.center, FREE_RADIUS, Stroke::new(1.5, free));
        if let Some(target) = self.target {
            cross_hairs(painter, target, tint(Handle::Target, accent));
        }
    }
}

fn arrow(painter: &Painter, [from, to]: [Pos2; 2], color: Color32) {
    painter.line_segment([from, to], Stroke::new(4.0, Color32::from_black_alpha(110)));
    painter.line_segment([from, to], Stroke::new(2.0, color));
    let along = (to - from).normalized();
    let across = along.rot90();
    let head = vec![to + 9.0 * along, to + 4.5 * across, to - 4.5 * across];
    painter.add(Shape::convex_polygon(head, color, Stroke::new(1.0, Color32::from_black_alpha(110))));
}

fn cross_hairs(painter: &Painter, at: Pos2, color: Color32) {
    for stroke in [Stroke::new(3.5, Color32::from_black_alpha(110)), Stroke::new(1.5, color)] {
        painter.circle_stroke(at, TARGET_RADIUS, stroke);
        for across in [vec2(1.0, 0.0), vec2(0.0, 1.0)] {
            painter.line_segment([at - 4.0 * across, at + 4.0 * across], stroke);
        }
    }
}

fn contains(corners: &[Pos2; 4], p: Pos2) -> bool {
    let side = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        (b - a).rot90().dot(p - a)
    };
    let sides = [0, 1, 2, 3].map(side);
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// Points from `p` to the nearest point of a line.
pub fn distance_to_segment(p: Pos2, a: Pos2, b: Pos2) -> f32 {
    let along: Vec2 = b - a;
    let share = ((p - a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
    (a + share * along).distance(p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Rect, pos2};
    use lapidary_core::camera::Camera;

    fn seen(eye: Vec3) -> (Projection, Handles) {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 600.0));
        let projection = Projection::new(&Camera::look_at(eye, Vec3::ZERO, 40.0), rect);
        let handles = Handles::of(Vec3::ZERO, Some(Vec3::new(0.0, -1.0, 0.5)), &projection).unwrap();
        (projection, handles)
    }

    #[test]
    fn each_handle_is_found_where_it_is_seen() {
        let (projection, handles) = seen(Vec3::new(2.0, 1.5, 3.0));
        let length = AXIS * projection.metres_per_point(Vec3::ZERO).unwrap();
        let at = |offset: Vec3| handles.at(projection.point(length * offset).unwrap());
        assert_eq!(at(Vec3::ZERO), Some(Handle::Free));
        assert_eq!([at(0.8 * Vec3::X), at(0.8 * Vec3::Y), at(0.8 * Vec3::Z)], [0, 1, 2].map(|i| Some(Handle::Axis(i))));
        assert_eq!(at(Vec3::new(0.0, 0.37, 0.37)), Some(Handle::Plane(0)));
        assert_eq!(at(Vec3::new(0.37, 0.37, 0.0)), Some(Handle::Plane(2)));
        assert_eq!(handles.at(projection.point(Vec3::new(0.0, -1.0, 0.5)).unwrap()), Some(Handle::Target));
        assert_eq!(at(-0.8 * Vec3::X), None, "negative control");
    }

    #[test]
    fn what_is_seen_end_on_cannot_be_grabbed() {
        let (_, handles) = seen(Vec3::new(0.0, 0.0, 4.0));
        assert!(handles.axes[2].is_none() && handles.planes[0].is_none() && handles.planes[1].is_none());
        assert!(handles.axes[0].is_some() && handles.planes[2].is_some());
    }

    #[test]
    fn drags_stay_on_their_line_or_plane() {
        let (eye, through) = (Vec3::new(1.0, 2.0, 5.0), Vec3::new(0.2, 0.3, 0.4));
        let toward = |place: Vec3| (place - eye).normalize();
        let place = through + 1.7 * Vec3::Y;
        let met = Constraint::Line(Vec3::Y).meet(through, eye, toward(place)).unwrap();
        assert!(met.distance(place) < 1e-5);
        let beside = Constraint::Line(Vec3::Y).meet(through, eye, toward(place + 0.3 * Vec3::X)).unwrap();
        assert!((beside - through).cross(Vec3::Y).length() < 1e-5);
        let place = through + Vec3::new(1.0, 0.0, -2.0);
        assert!(Constraint::Plane(Vec3::Y).meet(through, eye, toward(place)).unwrap().distance(place) < 1e-5);
        assert_eq!(Constraint::Plane(Vec3::Y).meet(through, eye, Vec3::Y), None, "behind the eye");
        assert_eq!(Constraint::Plane(Vec3::Y).meet(through, eye, Vec3::NEG_Z), None, "along it");
        assert_eq!(Constraint::Line(Vec3::Z).meet(through, eye, Vec3::NEG_Z), None);
    }
}
