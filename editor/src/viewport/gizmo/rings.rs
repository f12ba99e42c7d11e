//! Turn handles of an object: a ring about each axis of the world, or one about its hinge.

use super::{
    change::Axis,
    handles::{AXIS, COLORS, Constraint, Handle, LEAST_SEEN, REACH, distance_to_segment},
    projection::Projection,
};
use egui::{Color32, Painter, Pos2, Stroke};
use glam::Vec3;
use std::f32::consts::TAU;

/// Chords of a ring.
const CHORDS: usize = 64;
/// Depth behind the center to which a ring is drawn, in radii; a ring that faces the eye is drawn in full.
const BEHIND: f32 = 0.15;
/// Color of the ring about a hinge.
const HINGE_COLOR: Color32 = Color32::from_rgb(246, 190, 60);

/// The projected rings: the axis of each, and its chords in front of the center.
pub struct Rings(Vec<(Axis, Vec<[Pos2; 2]>)>);

impl Rings {
    /// The rings about axes through a position; `None` behind the eye.
    pub fn of(center: Vec3, axes: Vec<Axis>, projection: &Projection) -> Option<Self> {
        let radius = AXIS * projection.metres_per_point(center)?;
        let toward_eye = (projection.eye() - center).normalize_or(Vec3::Z);
        let chord = |axis: Axis, i: usize| {
            let ends = [i, i + 1].map(|i| on_ring(axis.direction(), i as f32 / CHORDS as f32 * TAU));
            let is_before = (ends[0] + ends[1]).dot(toward_eye) > -2.0 * BEHIND;
            is_before.then(|| projection.segment(center + radius * ends[0], center + radius * ends[1])).flatten()
        };
        let ring = |axis: Axis| (axis, (0..CHORDS).filter_map(|i| chord(axis, i)).collect());
        Some(Self(axes.into_iter().map(ring).collect()))
    }

    /// The ring under the pointer.
    pub fn at(&self, pointer: Pos2) -> Option<Handle> {
        let distance = |(ring, (_, chords)): (usize, &(Axis, Vec<[Pos2; 2]>))| {
            let distances = chords.iter().map(|[a, b]| distance_to_segment(pointer, *a, *b));
            (ring, distances.fold(f32::INFINITY, f32::min))
        };
        let nearest = self.0.iter().enumerate().map(distance).min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= REACH).map(|(ring, _)| Handle::Ring(ring))
    }

    /// Draws the rings, `hot` brighter.
    pub fn paint(&self, painter: &Painter, hot: Option<Handle>) {
        for (ring, (axis, chords)) in self.0.iter().enumerate() {
            let color = match axis {
                _ if hot == Some(Handle::Ring(ring)) => Color32::WHITE,
                Axis::World(axis) => COLORS[*axis],
                Axis::Hinge(_) => HINGE_COLOR,
            };
            for stroke in [Stroke::new(4.0, Color32::from_black_alpha(110)), Stroke::new(2.0, color)] {
                chords.iter().for_each(|chord| _ = painter.line_segment(*chord, stroke));
            }
        }
    }
}

/// The unit vector normal to an axis at an angle, counter-clockwise seen against the axis.
fn on_ring(axis: Vec3, radians: f32) -> Vec3 {
    let (sin, cos) = radians.sin_cos();
    let across = axis.any_orthonormal_vector();
    cos * across + sin * axis.cross(across)
}

/// A turn about an axis by a drag of a ring.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    axis: Vec3,
    center: Vec3,
    constraint: Constraint,
    /// For a ring seen edge on, the motion of its near side, in radians a meter.
    along: Option<Vec3>,
    grabbed: Vec3,
}

impl Sweep {
    /// Takes hold of the ring about an axis at the pointer.
    pub fn begun(axis: Axis, center: Vec3, projection: &Projection, pointer: Pos2) -> Option<Self> {
        let (axis, eye) = (axis.direction(), projection.eye());
        let toward_eye = (eye - center).normalize_or(Vec3::Z);
        let radius = AXIS * projection.metres_per_point(center)?;
        let is_open = axis.dot(toward_eye).abs() > LEAST_SEEN;
        let constraint = Constraint::Plane(if is_open { axis } else { toward_eye });
        let along = (!is_open).then(|| axis.cross(toward_eye).normalize_or_zero() / radius);
        let grabbed = constraint.meet(center, eye, projection.direction(pointer))?;
        Some(Self { axis, center, constraint, along, grabbed })
    }

    /// The angle from the start of the drag, counter-clockwise seen against the axis, -π to π unless the ring is seen edge on.
    pub fn radians(&self, projection: &Projection, pointer: Pos2) -> Option<f32> {
        let now = self.constraint.meet(self.center, projection.eye(), projection.direction(pointer))?;
        Some(match self.along {
            Some(along) => (now - self.grabbed).dot(along),
            None => angle_about(self.axis, self.grabbed - self.center, now - self.center),
        })
    }
}

/// The angle about an axis from one direction normal to it to another.
fn angle_about(axis: Vec3, from: Vec3, to: Vec3) -> f32 {
    axis.dot(from.cross(to)).atan2(from.dot(to))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Rect, pos2, vec2};
    use lapidary_core::camera::Camera;
    use std::f32::consts::FRAC_PI_2;

    const CENTER: Vec3 = Vec3::new(0.3, -0.2, 0.1);

    fn seen_from(eye: Vec3) -> (Projection, Rings, f32) {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 600.0));
        let projection = Projection::new(&Camera::look_at(CENTER + eye, CENTER, 40.0), rect);
        let rings = Rings::of(CENTER, Axis::OF_WORLD.into(), &projection).unwrap();
        let radius = AXIS * projection.metres_per_point(CENTER).unwrap();
        (projection, rings, radius)
    }

    #[test]
    fn each_ring_is_found_on_its_near_side_only() {
        let (projection, rings, radius) = seen_from(Vec3::new(2.0, 1.5, 3.0));
        let at = |offset: Vec3| rings.at(projection.point(CENTER + radius * offset.normalize()).unwrap());
        assert_eq!(at(Vec3::new(0.0, 0.3, 1.0)), Some(Handle::Ring(0)));
        assert_eq!(at(Vec3::new(1.0, 0.0, 0.6)), Some(Handle::Ring(1)));
        assert_eq!(at(Vec3::new(1.0, 0.5, 0.0)), Some(Handle::Ring(2)));
        assert_eq!(at(Vec3::new(-1.0, 0.0, -0.6)), None, "negative control: behind the centre");
        assert_eq!(rings.at(projection.point(CENTER).unwrap()), None);
    }

    #[test]
    fn a_quarter_turn_on_a_ring_is_ninety_degrees() {
        let (projection, _, radius) = seen_from(Vec3::new(2.0, 1.5, 3.0));
        for axis in Axis::OF_WORLD.into_iter().chain([Axis::Hinge(Vec3::new(0.6, 0.8, 0.0))]) {
            let on_ring = |radians: f32| on_ring(axis.direction(), radians);
            let at = |radians: f32| projection.point(CENTER + radius * on_ring(radians)).unwrap();
            let sweep = Sweep::begun(axis, CENTER, &projection, at(0.2)).unwrap();
            let turned = |radians: f32| sweep.radians(&projection, at(0.2 + radians)).unwrap();
            assert!((turned(FRAC_PI_2) - FRAC_PI_2).abs() < 1e-3, "{axis:?}: {}", turned(FRAC_PI_2));
            assert!((turned(-FRAC_PI_2) + FRAC_PI_2).abs() < 1e-3, "negative control: the other way round");
            assert!(turned(0.0).abs() < 1e-4);
        }
    }

    #[test]
    fn the_near_side_of_a_ring_that_is_seen_edge_on_follows_the_pointer() {
        let (projection, rings, radius) = seen_from(Vec3::new(0.0, 0.0, 4.0));
        let middle = projection.point(CENTER).unwrap();
        assert_eq!(rings.at(middle + vec2(40.0, 0.0)), Some(Handle::Ring(1)));
        let sweep = Sweep::begun(Axis::World(1), CENTER, &projection, middle).unwrap();
        // Seen from above, counter-clockwise takes the side toward the eye to the right.
        let right = projection.point(CENTER + radius * Vec3::X).unwrap();
        let turned = sweep.radians(&projection, right).unwrap();
        assert!((turned - 1.0).abs() < 1e-3, "a radius is a radian: {turned}");
        let above = projection.point(CENTER + radius * Vec3::Y).unwrap();
        assert!(sweep.radians(&projection, above).unwrap().abs() < 1e-3, "negative control: along the axis");
    }
}
