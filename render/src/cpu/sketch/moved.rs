//! Pixels whose surface changes when objects are posed.

use glam::{Vec2, Vec3};
use lapidary_core::{
    bounds::Bounds,
    camera::{Camera, Projection},
    scene::Mesh,
};
use rayon::prelude::*;

/// Margin in pixels around an object's box: samples are not at pixel centers.
const MARGIN: f32 = 2.0;

/// Differences of two meshes with the same triangles.
pub struct Moved {
    is_moved: Vec<bool>,
    /// Boxes around the moved triangles of each object, at their current place.
    boxes: Vec<Bounds>,
}

impl Moved {
    /// Compares two poses of a scene.
    pub fn between(before: &Mesh, now: &Mesh) -> Self {
        let is_vertex_moved = |v: &u32| {
            let v = *v as usize;
            (before.positions[v], before.normals[v]) != (now.positions[v], now.normals[v])
        };
        let is_moved: Vec<bool> = now.triangles.par_iter().map(|corners| corners.iter().any(is_vertex_moved)).collect();
        let moved = (0..is_moved.len()).filter(|&triangle| is_moved[triangle]);
        let boxes = now.bounds_by(moved, |triangle| now.triangle_object[triangle]);
        Self { is_moved, boxes }
    }

    /// Whether a triangle has moved or is new.
    pub fn contains(&self, triangle: u32) -> bool {
        self.is_moved.get(triangle as usize).copied().unwrap_or(true)
    }

    /// Pixel rectangles (inclusive start, exclusive end in columns and rows) that contain all moved objects now.
    pub fn rectangles(&self, camera: &Camera, size: [u32; 2]) -> Vec<[[u32; 2]; 2]> {
        let projection = camera.projection(size);
        self.boxes.iter().map(|bounds| rectangle(&projection, bounds, size)).collect()
    }
}

/// Rectangle around a box; the whole picture if part of the box is beside or behind the eye.
fn rectangle(projection: &Projection, bounds: &Bounds, size: [u32; 2]) -> [[u32; 2]; 2] {
    let corner = |i: u32| {
        let pick = |bit: u32, axis: usize| if i >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        projection.pixel_of(Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
    };
    let corners: Option<Vec<(Vec2, f32)>> = (0..8).map(corner).collect();
    let Some(corners) = corners else { return [[0, 0], size] };
    let places = || corners.iter().map(|&(place, _)| place);
    let low = places().fold(Vec2::INFINITY, Vec2::min) - MARGIN;
    let high = places().fold(Vec2::NEG_INFINITY, Vec2::max) + MARGIN;
    // Conversions clamp: a box outside the picture gives an empty rectangle.
    let within = |place: Vec2| [(place.x as u32).min(size[0]), (place.y as u32).min(size[1])];
    [within(low), within(high.ceil())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::test_scenes::cubes;

    const SIZE: [u32; 2] = [200, 100];

    fn camera(distance: f32) -> Camera {
        Camera::look_at(Vec3::new(0.0, 0.0, distance), Vec3::ZERO, 40.0)
    }

    #[test]
    fn moved_triangles_lie_in_the_rectangle_of_their_object() {
        let before = cubes(3).mesh;
        let mut now = before.clone();
        let of_one = |t: &usize| before.triangle_object[*t] == 1;
        let vertices = (0..before.triangles.len()).filter(of_one).flat_map(|t| before.triangles[t]);
        let mut vertices: Vec<u32> = vertices.collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.iter().for_each(|&v| now.positions[v as usize] += Vec3::new(0.3, 0.1, 0.0));
        let moved = Moved::between(&before, &now);
        let objects =
            (0..now.triangles.len() as u32).filter(|&t| moved.contains(t)).map(|t| now.triangle_object[t as usize]);
        let objects: Vec<u32> = objects.collect();
        assert!(objects.len() == 12 && objects.iter().all(|&object| object == 1));
        let camera = camera(20.0);
        let [[[left, top], [right, bottom]]] = moved.rectangles(&camera, SIZE)[..] else { panic!("one object") };
        let projection = camera.projection(SIZE);
        let is_in = |v: u32| {
            let (place, _) = projection.pixel_of(now.positions[v as usize]).unwrap();
            let (x, y) = (place.x as u32, place.y as u32);
            (left..right).contains(&x) && (top..bottom).contains(&y)
        };
        assert!(vertices.iter().all(|&v| is_in(v)));
        assert!(
            (right - left) * (bottom - top) < SIZE[0] * SIZE[1] / 8,
            "negative control: it is no larger than needed"
        );
        assert!(Moved::between(&now, &now).rectangles(&camera, SIZE).is_empty());
    }

    #[test]
    fn what_reaches_behind_the_eye_may_be_anywhere_and_what_is_aside_nowhere() {
        let around = |center: Vec3, half: f32| Bounds { min: center - half, max: center + half };
        let of = |bounds: Bounds| rectangle(&camera(3.0).projection(SIZE), &bounds, SIZE);
        assert_eq!(of(around(Vec3::Z * 3.0, 0.5)), [[0, 0], SIZE]);
        let [[left, _], [right, _]] = of(around(Vec3::X * 50.0, 0.5));
        assert!(left >= right, "right of the picture");
        let [[left, _], [right, _]] = of(around(Vec3::X * -50.0, 0.5));
        assert!(left >= right, "left of it");
    }
}
