//! The color box: a closed room of two meters with a red and a green wall and two blocks, after the box of Goral et al. (1984),
//! *Modeling the Interaction of Light between Diffuse Surfaces*. Its front is open; a spot light shines from above.

use glam::{Affine3A, Vec3, vec3};

use crate::furniture::joined;
use crate::mesh::Mesh;
use crate::rounded_box::{plain_box, rounded_box};
use crate::scene::{Camera, Material, PunctualLight, Scene, at};

/// Inner width, height and depth in meters; the floor's middle is the origin.
pub const SIZE: f32 = 2.0;
/// Thickness of the walls in meters.
const WALL: f32 = 0.1;
/// Cells of the walls.
const CELL: f32 = 0.1;

/// Composes the scene.
pub fn color_box() -> Scene {
    let mut scene = Scene { name: "color-box", materials: materials(), ..Scene::default() };
    let half = 0.5 * SIZE;
    scene.add("Shell", joined(shell()), "White paint", Affine3A::IDENTITY);
    let side = |x: f32| between(vec3(x - WALL, 0.0, -half), vec3(x, SIZE, half));
    scene.add("Red wall", side(-half), "Red paint", Affine3A::IDENTITY);
    scene.add("Green wall", side(half + WALL), "Green paint", Affine3A::IDENTITY);
    let tall = vec3(0.6, 1.2, 0.6);
    scene.add("Tall block", rounded_box(tall, 0.01, 0.08), "White paint", at(vec3(-0.35, 0.601, -0.35), 17.0));
    let short = vec3(0.6, 0.6, 0.6);
    scene.add("Short block", rounded_box(short, 0.01, 0.08), "White paint", at(vec3(0.35, 0.301, 0.3), -18.0));
    scene.cameras =
        vec![Camera { name: "main", eye: vec3(0.0, 1.0, 4.6), target: vec3(0.0, 1.0, 0.0), vertical_fov: 36.0 }];
    scene.lights = vec![PunctualLight {
        name: "Spot",
        position: vec3(0.1, 1.9, 0.1),
        target: vec3(0.0, 0.0, -0.1),
        intensity: [12.0, 10.8, 9.0],
        cone: Some([38.0, 48.0]),
    }];
    scene
}

/// Floor, ceiling and back wall.
fn shell() -> Vec<Mesh> {
    let (half, outer) = (0.5 * SIZE, 0.5 * SIZE + WALL);
    vec![
        between(vec3(-outer, -WALL, -outer), vec3(outer, 0.0, half)),
        between(vec3(-outer, SIZE, -outer), vec3(outer, SIZE + WALL, half)),
        between(vec3(-outer, 0.0, -outer), vec3(outer, SIZE, -half)),
    ]
}

fn between(low: Vec3, high: Vec3) -> Mesh {
    plain_box(high - low, CELL).shifted(0.5 * (low + high))
}

fn materials() -> Vec<Material> {
    vec![
        Material::dielectric("White paint", [0.72, 0.70, 0.66], 0.9),
        Material::dielectric("Red paint", [0.58, 0.055, 0.045], 0.9),
        Material::dielectric("Green paint", [0.12, 0.40, 0.075], 0.9),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::assert_sound;

    #[test]
    fn pieces_are_sound_and_the_light_is_inside() {
        let scene = color_box();
        for node in &scene.nodes {
            assert_sound(&scene.pieces[node.piece].mesh.clone().moved(node.world_from_object));
        }
        let light = scene.lights[0].position;
        assert!(light.x.abs() < 1.0 && light.z.abs() < 1.0 && (0.0..SIZE).contains(&light.y));
        assert!((2_000..20_000).contains(&scene.vertex_count()), "{}", scene.vertex_count());
    }
}
