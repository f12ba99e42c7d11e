//! Picks the surface under a pixel, by one ray.

use glam::{Vec2, Vec3};
use lapidary_core::{camera::Camera, ground::Ground, parts::Part, ray::Intersector, scene::Mesh};

/// Most surfaces of passed objects before one is picked.
const MOST_PASSED: usize = 256;
/// Step behind a passed surface, as a share of its distance.
const STEP_BEHIND: f32 = 1e-5;

/// The surface under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Index of the object.
    pub object: u32,
    /// Index of the mesh's material.
    pub material: usize,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
    /// Position of the hit, in meters.
    pub position: Vec3,
}

impl Picked {
    /// The part of the object.
    pub fn part(&self) -> Part {
        Part { object: self.object, material: self.material as u32 }
    }
}

/// Picks what `camera` sees at `pixel` of a picture of `size`. `intersector` belongs to `mesh`. A ground can be picked from above,
/// if it is shown as a surface.
pub fn pick(
    scene: (&Mesh, &Intersector),
    ground: Ground,
    camera: &Camera,
    pixel: Vec2,
    size: [u32; 2],
) -> Option<Picked> {
    pick_past(scene, ground, camera, pixel, size, |_| false)
}

/// The same, through objects that are `passed`.
pub fn pick_past(
    (mesh, intersector): (&Mesh, &Intersector),
    ground: Ground,
    camera: &Camera,
    pixel: Vec2,
    size: [u32; 2],
    passed: impl Fn(u32) -> bool,
) -> Option<Picked> {
    let (origin, direction) = camera.projection(size).ray(pixel);
    // Every surface that stops some light can be picked.
    let mut way = 0.0;
    for _ in 0..MOST_PASSED {
        let from = origin + way * direction;
        let first = intersector.closest_above(from, direction, |_| 0.0);
        let hit = intersector.past_ground(mesh, first, (from, direction), ground == Ground::On, |_| 0.0)?;
        let (index, distance) = (hit.triangle as usize, way + hit.distance);
        let object = *mesh.triangle_object.get(index)?;
        if !passed(object) {
            let material = *mesh.triangle_material.get(index)? as usize;
            return Some(Picked { object, material, triangle: hit.triangle, position: origin + distance * direction });
        }
        way = distance * (1.0 + STEP_BEHIND);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{bounds::object_bounds, test_support::two_squares};
    use lapidary_core::{ground::add_ground, scene::Scene};

    const SIZE: [u32; 2] = [800, 600];

    fn picked_at(pixel: Vec2) -> Option<Picked> {
        let mesh = two_squares();
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 40.0);
        pick((&mesh, &Intersector::new(&mesh)), Ground::On, &camera, pixel, SIZE)
    }

    #[test]
    fn each_square_is_found_where_it_is_seen_and_nothing_between() {
        let focal = 300.0 / 20.0_f32.to_radians().tan();
        let x_of = |x: f32| 400.0 + focal * x / 5.0;
        let left = picked_at(Vec2::new(x_of(-1.0), 300.0)).unwrap();
        assert_eq!((left.object, left.material), (0, 1));
        assert!((left.position - Vec3::NEG_X).length() < 1e-4);
        let right = picked_at(Vec2::new(x_of(1.0), 300.0)).unwrap();
        assert_eq!((right.object, right.material), (1, 0));
        assert!(right.triangle >= 2);
        assert_eq!(picked_at(Vec2::new(400.0, 300.0)), None);
    }

    #[test]
    fn locked_objects_are_seen_through() {
        let mut mesh = two_squares();
        // The second square goes behind the first.
        mesh.positions[4..].iter_mut().for_each(|position| *position += Vec3::new(-2.0, 0.0, -1.0));
        let camera = Camera::look_at(Vec3::new(-1.1, 0.1, 5.0), Vec3::new(-1.1, 0.1, 0.0), 40.0);
        let picked = |passed: &dyn Fn(u32) -> bool| {
            let middle = Vec2::new(400.0, 300.0);
            pick_past((&mesh, &Intersector::new(&mesh)), Ground::On, &camera, middle, SIZE, passed)
        };
        assert_eq!(picked(&|_| false).unwrap().object, 0, "negative control");
        let behind = picked(&|object| object == 0).unwrap();
        assert!(behind.object == 1 && (behind.position.z + 1.0).abs() < 1e-3, "{behind:?}");
        assert_eq!(picked(&|_| true), None);
    }

    #[test]
    fn a_ground_is_picked_where_it_is_seen_as_a_surface() {
        let mut scene = Scene { mesh: two_squares(), ..Default::default() };
        let bounds = scene.mesh.bounds();
        add_ground(&mut scene);
        let (mesh, intersector) = (&scene.mesh, Intersector::new(&scene.mesh));
        let picked = |ground, eye, target| {
            let camera = Camera::look_at(eye, target, 40.0);
            pick((mesh, &intersector), ground, &camera, Vec2::new(400.0, 300.0), SIZE)
        };
        let (above, beside) = (Vec3::new(3.0, 4.0, 3.0), Vec3::new(3.0, bounds.min.y, 3.0));
        assert_eq!(picked(Ground::On, above, beside).map(|picked| picked.object), mesh.ground_object());
        for ground in [Ground::Off, Ground::Shadow] {
            assert_eq!(picked(ground, above, beside), None);
        }
        for ground in Ground::ALL {
            let from_below = picked(ground, Vec3::new(-1.0, -40.0, 0.5), Vec3::NEG_X).unwrap();
            assert_eq!(from_below.object, 0, "{ground:?}");
        }
        assert_eq!(object_bounds(mesh, mesh.ground_object().unwrap()), Some(bounds));
    }
}
