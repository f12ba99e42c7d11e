//! Lights inside an object, which light nothing visible.

use crate::renderer::Renderer;
use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    lights::{Emission, Light},
    ray::Intersector,
    sphere::fibonacci_directions,
};

/// Directions that are tested: a light whose ray leaves the objects in any of these is in the open.
const DIRECTIONS: usize = 64;

impl Renderer {
    /// The lights that shine and see only the inside of closed objects.
    pub fn buried_lights<'a>(&self, lights: &'a [Light]) -> Vec<&'a Light> {
        lights.iter().filter(|light| light.shines() && is_buried(&self.dataset, self.intersector(), light)).collect()
    }
}

/// Whether a light sees only the inside of closed objects; `intersector` is made of the dataset's mesh.
pub fn is_buried(dataset: &Dataset, intersector: &Intersector, light: &Light) -> bool {
    let forward = light.forward().filter(|_| light.emission.is_aimed());
    let shines_into = |look: &Vec3| forward.is_none_or(|forward| forward.dot(*look) > 0.0);
    let sees_an_inside = |look: Vec3| {
        let hit = intersector.closest_hit(light.position, look);
        hit.is_some_and(|hit| hit.back_face && !dataset.two_sided[hit.triangle as usize])
    };
    !matches!(light.emission, Emission::Directional { .. })
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
            Renderer::new(dataset(mesh.clone(), white())).buried_lights(&[light]).len()
        };
        let lamp = light(Emission::Point, Vec3::new(0.2, 0.1, 0.0), Vec3::ZERO, 1.0);
        assert_eq!((buried(&room, lamp.clone()), buried(&ball, lamp.clone())), (0, 1));
        let outside = Light { position: Vec3::splat(2.0), ..lamp.clone() };
        let off = Light { enabled: false, ..lamp.clone() };
        let sun = Light { emission: Emission::PARALLEL, ..lamp };
        assert_eq!([outside, off, sun].map(|light| buried(&ball, light)), [0; 3]);
    }
}
