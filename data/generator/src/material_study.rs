//! The material study: a shader ball alone on the sweep. Its shell has the studied material.

use glam::{Affine3A, vec3};

use crate::backdrop;
use crate::scene::{Camera, Material, Scene, at};
use crate::shader_ball::shader_ball;

/// Radius of the ball in meters.
const RADIUS: f32 = 0.3;

/// Composes the scene.
pub fn material_study() -> Scene {
    let mut scene = Scene { name: "material-study", materials: materials(), ..Scene::default() };
    let (ball, placed) = (shader_ball(RADIUS), at(vec3(0.0, 0.0, 0.2), -18.0));
    scene.add("Backdrop", backdrop::sweep(), "Studio floor", Affine3A::IDENTITY);
    scene.add("Shell", ball.shell, "Subject", placed);
    scene.add("Core", ball.core, "Core", placed);
    scene.add("Ring", ball.ring, "Ring", placed);
    scene.cameras =
        vec![Camera { name: "main", eye: vec3(0.0, 0.62, 1.95), target: vec3(0.0, 0.295, 0.2), vertical_fov: 24.0 }];
    scene
}

fn materials() -> Vec<Material> {
    vec![
        Material::dielectric("Studio floor", [0.30, 0.30, 0.30], 0.8),
        Material::dielectric("Subject", [0.70, 0.68, 0.64], 0.32),
        Material::dielectric("Core", [0.18, 0.18, 0.18], 0.5),
        Material::dielectric("Ring", [0.05, 0.05, 0.05], 0.6),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::assert_sound;

    #[test]
    fn pieces_are_sound_and_the_ball_stands_on_the_floor() {
        let scene = material_study();
        for node in &scene.nodes {
            assert_sound(&scene.pieces[node.piece].mesh.clone().moved(node.world_from_object));
        }
        let ring = scene.nodes.last().unwrap();
        let ring = scene.pieces[ring.piece].mesh.clone().moved(ring.world_from_object);
        let lowest = ring.positions.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        assert!(lowest.abs() < 1e-3, "{lowest}");
        assert!((5_000..40_000).contains(&scene.vertex_count()), "{}", scene.vertex_count());
    }
}
