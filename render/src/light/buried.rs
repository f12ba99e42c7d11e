//! Lights inside an object, which light no visible surface.

use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    lights::{Emission, Light},
    ray::Intersector,
    sphere::fibonacci_directions,
};

/// Test directions: a light is in the open if its ray leaves the objects in any of them.
const DIRECTIONS: usize = 64;

/// Whether a light lies inside closed objects and shines on their inner sides only; `intersector` is built from the dataset's mesh.
pub fn is_buried(dataset: &Dataset, intersector: &Intersector, light: &Light) -> bool {
    let forward = light.forward().filter(|_| light.emission.is_aimed());
    let shines_into = |look: &Vec3| forward.is_none_or(|forward| forward.dot(*look) > 0.0);
    let sees_an_inside = |look: Vec3| {
        let hit = intersector.closest_hit(light.position, look);
        hit.is_some_and(|hit| hit.back_face && !dataset.two_sided[hit.triangle as usize])
    };
    light.shines()
        && !matches!(light.emission, Emission::Directional { .. })
        && fibonacci_directions(DIRECTIONS).into_iter().filter(shines_into).all(sees_an_inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{dataset, light, sphere, white};

    #[test]
    fn a_light_in_a_room_is_in_the_open_and_one_in_a_ball_is_buried() {
        let room = sphere(8);
        let mut ball = room.clone();
        ball.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        ball.normals.iter_mut().for_each(|n| *n = -*n);
        let buried = |mesh: &lapidary_core::scene::Mesh, light: Light| {
            is_buried(&dataset(mesh.clone(), white()), &Intersector::new(mesh), &light)
        };
        let lamp = light(Emission::Point, Vec3::new(0.2, 0.1, 0.0), Vec3::ZERO, 1.0);
        assert_eq!((buried(&room, lamp.clone()), buried(&ball, lamp.clone())), (false, true));
        let outside = Light { position: Vec3::splat(2.0), ..lamp.clone() };
        let off = Light { enabled: false, ..lamp.clone() };
        let sun = Light { emission: Emission::PARALLEL, ..lamp };
        assert_eq!([outside, off, sun].map(|light| buried(&ball, light)), [false; 3]);
    }
}
