//! Scenes of large quads for wavelet transport, after Kontkanen et al. (2006), Fig. 10: a Cornell box, a maze and a glossy floor.
//! They are not part of the bundle.

use glam::{Affine3A, Vec3, vec3};

use crate::mesh::Mesh;
use crate::scene::{Camera, Material, PunctualLight, Scene, at};

/// All three scenes.
pub fn scenes() -> [Scene; 3] {
    [cornell(), maze(), glossy()]
}

/// A quad with a corner and two edges; it faces along their cross product.
fn quad(corner: Vec3, [a, b]: [Vec3; 2]) -> Mesh {
    let normal = a.cross(b).normalize();
    let mut mesh = Mesh::default();
    let corners = [Vec3::ZERO, a, a + b, b].map(|offset| corner + offset);
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let [i, j, k, l] = [0, 1, 2, 3].map(|i| mesh.push(corners[i], normal, uvs[i].into()));
    mesh.quad(i, j, k, l);
    mesh
}

/// A standing box without its underside: four sides and a top around the origin.
fn standing(size: Vec3) -> Mesh {
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let half = 0.5 * (x + z);
    let mut mesh = Mesh::default();
    for side in [
        quad(z - half, [x, y]),
        quad(x + z - half, [-z, y]),
        quad(x - half, [-x, y]),
        quad(-half, [z, y]),
        quad(y + z - half, [x, -z]),
    ] {
        mesh.append(&side);
    }
    mesh
}

/// Floor, ceiling and walls of a room of `size` on the origin, open toward +Z. Their names say where they are.
fn room(scene: &mut Scene, size: Vec3, [left, right, floor]: [&'static str; 3]) {
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let low = -0.5 * (x + z);
    let mut add = |name: &str, corner: Vec3, edges: [Vec3; 2], material| {
        scene.add(name, quad(corner, edges), material, Affine3A::IDENTITY);
    };
    add("Floor", low + z, [x, -z], floor);
    add("Ceiling", low + y, [x, z], "White");
    add("Back wall", low, [x, y], "White");
    add("Left wall", low + z, [-z, y], left);
    add("Right wall", low + x, [z, y], right);
}

fn camera(eye: Vec3, target: Vec3) -> Vec<Camera> {
    vec![Camera { name: "main", eye, target, vertical_fov: 38.0 }]
}

fn lamp(position: Vec3, intensity: f32) -> PunctualLight {
    PunctualLight { name: "Lamp", position, target: position - Vec3::Y, intensity: [intensity; 3], cone: None }
}

/// Rough paint; its reflectance is almost that of a diffuse surface.
fn paint(name: &'static str, color: [f32; 3]) -> Material {
    Material::dielectric(name, color, 1.0)
}

fn paints() -> Vec<Material> {
    vec![
        paint("White", [0.72, 0.72, 0.70]),
        paint("Red", [0.60, 0.06, 0.05]),
        paint("Green", [0.12, 0.45, 0.09]),
        paint("Blue", [0.10, 0.18, 0.55]),
        paint("Yellow", [0.65, 0.50, 0.10]),
    ]
}

fn cornell() -> Scene {
    let mut scene = Scene { name: "cornell", materials: paints(), ..Scene::default() };
    room(&mut scene, Vec3::splat(2.0), ["Red", "Green", "White"]);
    scene.add("Tall block", standing(vec3(0.6, 1.2, 0.6)), "White", at(vec3(-0.35, 0.0, -0.35), 17.0));
    scene.add("Short block", standing(vec3(0.6, 0.6, 0.6)), "White", at(vec3(0.35, 0.0, 0.3), -18.0));
    scene.cameras = camera(vec3(0.0, 1.0, 4.6), vec3(0.0, 1.0, 0.0));
    scene.lights = vec![lamp(vec3(0.1, 1.8, 0.1), 3.0)];
    scene
}

/// Walls of a maze, as (x, z) of their middle, their extent, and their paint.
const MAZE: [([f32; 2], [f32; 2], &str); 11] = [
    ([-1.8, -1.0], [0.1, 2.0], "Red"),
    ([-0.9, 1.0], [1.8, 0.1], "White"),
    ([-0.6, -0.6], [0.1, 1.6], "Blue"),
    ([0.2, -1.4], [1.5, 0.1], "White"),
    ([0.6, 0.2], [0.1, 1.5], "Yellow"),
    ([1.5, -0.5], [0.1, 1.7], "Green"),
    ([1.6, 1.2], [1.5, 0.1], "White"),
    ([0.1, 1.9], [0.1, 1.2], "Red"),
    ([-1.6, 2.0], [1.2, 0.1], "Yellow"),
    ([2.2, -1.8], [1.0, 0.1], "White"),
    ([-1.3, -2.3], [0.1, 0.9], "White"),
];

fn maze() -> Scene {
    let mut scene = Scene { name: "maze", materials: paints(), ..Scene::default() };
    room(&mut scene, vec3(6.0, 1.2, 6.0), ["White", "White", "White"]);
    // It is looked into from above.
    scene.nodes.retain(|node| node.name != "Ceiling");
    for (index, ([x, z], [width, depth], material)) in MAZE.into_iter().enumerate() {
        let wall = standing(vec3(width, 1.0, depth));
        scene.add(&format!("Wall {}", index + 1), wall, material, at(vec3(x, 0.0, z), 0.0));
    }
    scene.cameras = camera(vec3(0.0, 6.5, 6.5), vec3(0.0, 0.0, 0.3));
    scene.lights =
        vec![lamp(vec3(-0.1, 0.8, 0.3), 2.0), lamp(vec3(1.9, 0.7, 0.4), 1.5), lamp(vec3(-2.3, 0.8, -1.6), 1.5)];
    scene
}

fn glossy() -> Scene {
    let mut materials = paints();
    materials.push(Material::metal("Gloss", [0.85, 0.82, 0.75], 0.55));
    let mut scene = Scene { name: "glossy", materials, ..Scene::default() };
    room(&mut scene, vec3(3.0, 2.0, 2.0), ["Red", "Blue", "Gloss"]);
    scene.add("Block", standing(vec3(0.6, 0.9, 0.5)), "Yellow", at(vec3(-0.5, 0.0, -0.2), 25.0));
    scene.add("Low block", standing(vec3(0.6, 0.4, 0.5)), "Green", at(vec3(0.6, 0.0, 0.2), -20.0));
    scene.cameras = camera(vec3(0.0, 1.0, 4.6), vec3(0.0, 0.8, 0.0));
    scene.lights = vec![lamp(vec3(0.2, 1.7, 0.3), 3.0)];
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_quads_that_face_their_lamps() {
        for scene in scenes() {
            for node in &scene.nodes {
                let mesh = scene.pieces[node.piece].mesh.clone().moved(node.world_from_object);
                assert_eq!((mesh.triangle_count() % 2, mesh.positions.len()), (0, mesh.triangle_count() * 2));
                for t in 0..mesh.triangle_count() {
                    let [a, b, c] = mesh.corners(t);
                    let normal = (b - a).cross(c - a).normalize();
                    assert!(normal.dot(mesh.normals[mesh.indices[3 * t] as usize]) > 0.999);
                    let is_wall = node.name.ends_with("wall") || ["Floor", "Ceiling"].contains(&node.name.as_str());
                    let faces = |light: &PunctualLight| (light.position - a).dot(normal) > 0.0;
                    assert!(!is_wall || scene.lights.iter().all(faces), "{}: {}", scene.name, node.name);
                    let outward = (a + b + c) / 3.0 - node.world_from_object.translation.to_vec3();
                    assert!(is_wall || outward.dot(normal) > 0.0, "{}: {}", scene.name, node.name);
                }
            }
        }
    }
}
