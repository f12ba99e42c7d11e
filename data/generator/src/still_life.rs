//! The still life: placement and materials of its pieces.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use crate::cloth::{self, Drape};
use crate::scene::{Camera, Material, Scene, at};
use crate::{backdrop, filigree, gem, knot, pear, rounded_box, shader_ball, vase};

/// The walnut block under the cloth: size in meters, place and turn.
const BLOCK: Vec3 = vec3(0.32, 0.24, 0.28);
const BLOCK_AT: Vec3 = vec3(0.30, 0.0, -0.08);
const BLOCK_TURN: f32 = 24.0;

/// Rounder than in the cloth simulation: the corners must not pierce the weave.
const BLOCK_ROUND: f32 = 0.020;

/// Composes the scene. `cloth_resolution` is the number of vertices along a side of the cloth.
pub fn still_life(cloth_resolution: usize) -> Scene {
    let mut scene = Scene { name: "still-life", materials: materials(), ..Scene::default() };
    scene.add("Backdrop", backdrop::sweep(), "Painted canvas", Affine3A::IDENTITY);
    add_draped_block(&mut scene, cloth_resolution);
    add_pottery(&mut scene);
    add_shader_ball(&mut scene, at(vec3(0.68, 0.0, 0.27), -10.0));
    add_pears(&mut scene);
    scene.add("Lantern", filigree::joined(0.36), "Patinated bronze", at(vec3(-0.34, 0.0, 0.28), 10.0));
    scene.add("Gem", gem::resting(0.16), "Garnet", at(vec3(0.09, 0.0, 0.46), -22.0));
    scene.cameras = cameras();
    scene
}

fn cameras() -> Vec<Camera> {
    vec![
        Camera { name: "main", eye: vec3(0.40, 0.76, 2.02), target: vec3(0.03, 0.165, 0.02), vertical_fov: 35.0 },
        Camera { name: "detail", eye: vec3(-0.06, 0.30, 1.12), target: vec3(0.09, 0.105, 0.20), vertical_fov: 30.0 },
    ]
}

fn add_draped_block(scene: &mut Scene, resolution: usize) {
    let placed = at(BLOCK_AT, BLOCK_TURN);
    let block =
        rounded_box::rounded_box(BLOCK, BLOCK_ROUND, 0.035).shifted(Vec3::Y * 0.5 * BLOCK.y).tiled(Vec2::splat(2.2));
    scene.add("Block", block, "Walnut", placed);
    scene.add("Cloth", cloth::drape(&drape(resolution)), "Linen", placed);
    let on_cloth = at(BLOCK_AT + Vec3::Y * (BLOCK.y + cloth::CLEARANCE), 4.0);
    scene.add("Trefoil knot", knot::trefoil(0.080, 0.036, 0.021, 240), "Copper", on_cloth);
}

fn drape(resolution: usize) -> Drape {
    Drape {
        resolution,
        side: 0.92,
        turn: 0.50,
        centre: vec3(0.0, BLOCK.y + 0.06, 0.06),
        block: BLOCK,
        gather: 0.90,
        weight_radius: 0.10,
        seconds: 3.0,
    }
}

fn add_pottery(scene: &mut Scene) {
    let vase = vase::vase(0.48, 76).tiled(vec2(3.0, 3.0));
    scene.add("Vase", vase, "Petrol glaze", at(vec3(-0.14, 0.0, -0.22), 0.0));
    scene.add("Bottle", vase::bottle(0.30, 52), "Terracotta", at(vec3(-0.375, 0.0, -0.285), 0.0));
    let bowl = vase::bowl(0.22, 64).tiled(vec2(4.0, 1.5));
    scene.add("Bowl", bowl, "Hammered brass", at(vec3(-0.69, 0.0, 0.02), 0.0));
}

fn add_shader_ball(scene: &mut Scene, placed: Affine3A) {
    let ball = shader_ball::shader_ball(0.125);
    scene.add("Shader ball shell", ball.shell, "Porcelain", placed);
    scene.add("Shader ball core", ball.core, "Persimmon lacquer", placed);
    scene.add("Shader ball ring", ball.ring, "Satin steel", placed);
}

fn add_pears(scene: &mut Scene) {
    let height = 0.105;
    let (body, stem) = (pear::pear(height), pear::stem(height));
    let mut whole = body.clone();
    whole.append(&stem);
    let lying = pear::lying(&whole, 0.6);
    let standing = at(vec3(-0.545, 0.0, 0.18), 150.0);
    let tipped = at(vec3(-0.635, 0.0, 0.255), 172.0) * lying;
    let body = scene.piece("Pear", body, "Pear skin");
    let stem = scene.piece("Stem", stem, "Stem");
    for (name, placed) in [("standing", standing), ("lying", tipped)] {
        scene.place(&format!("Pear {name}"), body, placed);
        scene.place(&format!("Stem {name}"), stem, placed);
    }
}

fn materials() -> Vec<Material> {
    vec![
        Material {
            base_color_texture: Some("canvas.png"),
            ..Material::dielectric("Painted canvas", [1.0, 1.0, 1.0], 0.8)
        },
        Material { base_color_texture: Some("walnut.png"), ..Material::dielectric("Walnut", [1.0, 1.0, 1.0], 0.45) },
        Material {
            base_color_texture: Some("cloth.png"),
            double_sided: true,
            ..Material::dielectric("Linen", [1.0, 1.0, 1.0], 0.8)
        },
        Material {
            roughness_texture: Some("glaze-roughness.png"),
            ..Material::dielectric("Petrol glaze", [0.016, 0.070, 0.080], 0.26)
        },
        Material::dielectric("Terracotta", [0.40, 0.135, 0.070], 0.75),
        Material {
            normal_texture: Some("hammered-normal.png"),
            ..Material::metal("Hammered brass", [0.78, 0.57, 0.28], 0.28)
        },
        Material::dielectric("Porcelain", [0.70, 0.68, 0.64], 0.32),
        Material::dielectric("Persimmon lacquer", [0.50, 0.13, 0.035], 0.25),
        Material::metal("Satin steel", [0.58, 0.57, 0.55], 0.38),
        Material::metal("Copper", [0.86, 0.47, 0.33], 0.22),
        Material::metal("Garnet", [0.50, 0.020, 0.042], 0.2),
        Material::metal("Patinated bronze", [0.30, 0.20, 0.115], 0.42),
        Material::dielectric("Pear skin", [0.46, 0.40, 0.085], 0.45),
        Material::dielectric("Stem", [0.085, 0.050, 0.026], 0.7),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::assert_sound;

    /// Pieces that belong together, touch, or lie on one another.
    const GROUPS: [&[&str]; 4] = [
        &["Backdrop"],
        &["Block", "Cloth", "Trefoil knot"],
        &["Shader ball shell", "Shader ball core", "Shader ball ring"],
        &["Pear standing", "Stem standing", "Pear lying", "Stem lying"],
    ];

    fn placed(scene: &Scene, node: &crate::scene::Node) -> crate::mesh::Mesh {
        scene.pieces[node.piece].mesh.clone().moved(node.world_from_object)
    }

    #[test]
    fn every_piece_is_sound_and_above_the_floor() {
        let scene = still_life(32);
        for node in &scene.nodes {
            let mesh = placed(&scene, node);
            assert_sound(&mesh);
            assert!(mesh.lowest() > -1e-5, "{} sinks to {}", node.name, mesh.lowest());
        }
    }

    fn grouped(a: &str, b: &str) -> bool {
        GROUPS.iter().any(|g| g.contains(&a) && (g.len() == 1 || g.contains(&b)))
    }

    /// Bounding circle, seen from above, of the part below `height`.
    fn circle(mesh: &crate::mesh::Mesh, height: f32) -> Option<(Vec2, f32)> {
        let seen: Vec<Vec2> = mesh.positions.iter().filter(|p| p.y < height).map(|p| vec2(p.x, p.z)).collect();
        let centre = seen.iter().sum::<Vec2>() / seen.len() as f32;
        let radius = seen.iter().fold(0.0, |radius: f32, p| radius.max(p.distance(centre)));
        (!seen.is_empty()).then_some((centre, radius))
    }

    #[test]
    fn pieces_keep_apart() {
        let scene = still_life(8);
        let nodes = scene.nodes.iter().filter(|node| node.name != "Cloth");
        let circles = nodes.map(|node| (&node.name, circle(&placed(&scene, node), f32::INFINITY)));
        let circles: Vec<_> = circles.filter_map(|(name, circle)| Some((name, circle?))).collect();
        for (i, (a, (centre_a, radius_a))) in circles.iter().enumerate() {
            for (b, (centre_b, radius_b)) in &circles[i + 1..] {
                let gap = centre_a.distance(*centre_b) - radius_a - radius_b;
                assert!(grouped(a, b) || gap > 0.0, "{a} and {b} overlap by {}", -gap);
            }
        }
    }

    /// At the shipped resolution: the folds depend on it.
    #[test]
    fn nothing_stands_on_the_cloth_and_the_budget_holds() {
        let scene = still_life(crate::CLOTH_RESOLUTION);
        assert!((30_000..60_000).contains(&scene.vertex_count()), "{}", scene.vertex_count());
        let cloth = scene.nodes.iter().find(|node| node.name == "Cloth").map(|node| placed(&scene, node)).unwrap();
        for node in scene.nodes.iter().filter(|node| !grouped(&node.name, "Cloth")) {
            // The cloth lies flat, away from the block: only pieces near the floor can touch it.
            if let Some((centre, radius)) = circle(&placed(&scene, node), 0.05) {
                let gaps = cloth.positions.iter().map(|p| vec2(p.x, p.z).distance(centre) - radius);
                let gap = gaps.fold(f32::INFINITY, f32::min);
                assert!(gap > 0.0 || node.name == "Backdrop", "{} stands on the cloth: {gap}", node.name);
            }
        }
    }
}
