//! The interior: a living room by day.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use crate::furniture::{self, joined};
use crate::rounded_box::rounded_box;
use crate::scene::{Camera, Material, PunctualLight, Scene, at};
use crate::{gem, knot, lidded_box, room, vase};

/// Thickness of the rug, the height of objects on it.
const RUG: f32 = 0.012;
/// Position of the low table, and the height of its top.
const TABLE_AT: Vec3 = vec3(-0.25, RUG, -0.10);
const TABLE_TOP: f32 = RUG + 0.418;
/// Position of the box: on the rug, with its front toward +X so that the lid opens about Z.
const BOX_AT: Vec3 = vec3(-1.0, RUG, 0.28);
/// Position of the lamp.
const LAMP_AT: Vec3 = vec3(1.18, 0.0, -1.58);
/// Position of the shelf, against the wall at +X.
const SHELF_AT: Vec3 = vec3(2.14, 0.0, -1.05);

/// Composes the scene.
pub fn interior() -> Scene {
    let mut scene = Scene { name: "interior", materials: materials(), ..Scene::default() };
    add_shell(&mut scene);
    add_seats(&mut scene);
    add_table(&mut scene);
    add_shelf(&mut scene);
    add_walls_and_lamp(&mut scene);
    add_box(&mut scene);
    scene.cameras = vec![
        Camera { name: "main", eye: vec3(1.95, 1.42, 1.72), target: vec3(-0.55, 0.78, -0.85), vertical_fov: 50.0 },
        Camera { name: "shelf", eye: vec3(-1.55, 1.38, 1.25), target: vec3(1.75, 0.86, -1.10), vertical_fov: 45.0 },
    ];
    scene.lights = lights();
    scene
}

/// A lamp that shines out of its shade above and below, and a spot light on the table.
fn lights() -> Vec<PunctualLight> {
    vec![
        PunctualLight {
            name: "Lamp",
            position: vec3(LAMP_AT.x, 1.60, LAMP_AT.z),
            target: LAMP_AT,
            intensity: [2.4, 1.9, 1.2],
            cone: None,
        },
        PunctualLight {
            name: "Ceiling spot",
            position: vec3(-0.2, 2.55, 0.5),
            target: TABLE_AT,
            intensity: [9.0, 8.2, 7.0],
            cone: Some([16.0, 26.0]),
        },
    ]
}

fn add_shell(scene: &mut Scene) {
    scene.add("Floor", room::floor().tiled(Vec2::splat(1.0 / 1.6)), "Oak boards", Affine3A::IDENTITY);
    scene.add("Ceiling", room::ceiling(), "Ceiling paint", Affine3A::IDENTITY);
    scene.add("Walls", joined(room::walls()), "Plaster", Affine3A::IDENTITY);
    scene.add("Skirting", joined(room::skirting()), "White lacquer", Affine3A::IDENTITY);
    scene.add("Window frame", joined(room::window_frame()), "White lacquer", Affine3A::IDENTITY);
    let [low, high] = room::WINDOW;
    let x = -room::HALF_WIDTH + 0.11;
    for (name, z, seed) in [("left", low.x - 0.14, 0.0), ("right", high.x + 0.14, 2.0)] {
        let curtain = furniture::curtain(0.46, 2.36, seed);
        scene.add(&format!("Curtain {name}"), curtain, "Curtain linen", at(vec3(x, 0.02, z), 90.0));
    }
}

fn add_seats(scene: &mut Scene) {
    let placed = at(vec3(-0.25, 0.0, -1.50), 0.0);
    scene.add("Sofa", joined(furniture::sofa()).tiled(Vec2::splat(3.0)), "Upholstery", placed);
    scene.add("Sofa feet", joined(furniture::sofa_feet()), "Dark wood", placed);
    scene.add("Cushions", joined(furniture::cushions()).tiled(Vec2::splat(3.0)), "Cushion linen", placed);
    let chair = scene.piece("Chair", joined(furniture::chair()).tiled(Vec2::splat(2.0)), "Walnut");
    scene.place("Chair by the window", chair, at(vec3(-1.62, 0.0, 0.62), 128.0));
    scene.place("Chair by the table", chair, at(vec3(0.98, 0.0, 0.12), -82.0));
}

fn add_table(scene: &mut Scene) {
    let rug = rounded_box(vec3(2.30, RUG, 1.62), 0.004, 0.20).tiled(vec2(1.0 / 2.30, 1.0 / 1.62));
    scene.add("Rug", rug, "Rug", at(vec3(-0.25, 0.5 * RUG, -0.22), 0.0));
    scene.add("Low table", joined(furniture::coffee_table()), "Walnut", at(TABLE_AT, 0.0));
    let on_table = |x: f32, z: f32| vec3(TABLE_AT.x + x, TABLE_TOP, TABLE_AT.z + z);
    scene.add("Bowl", vase::bowl(0.26, 40), "Brass", at(on_table(0.14, 0.12), 0.0));
    scene.add("Stacked books", joined(furniture::book_stack()), "Book ochre", at(on_table(-0.18, 0.10), 25.0));
    scene.add("Bottle", vase::bottle(0.26, 36), "Petrol glaze", at(on_table(-0.02, -0.20), 0.0));
}

fn add_shelf(scene: &mut Scene) {
    let placed = at(SHELF_AT, -90.0);
    scene.add("Shelf", joined(furniture::shelf()), "Walnut", placed);
    let colors = ["Book ochre", "Book brick", "Book ink", "Book cream"];
    for (heap, color) in furniture::books(colors.len()).into_iter().zip(colors) {
        scene.add(color, joined(heap), color, placed);
    }
    let on_board = |level: usize, x: f32| placed * at(vec3(x, furniture::board_top(level), 0.0), 20.0);
    scene.add("Knot", knot::trefoil(0.062, 0.028, 0.016, 120), "Brass", on_board(1, 0.28));
    scene.add("Vase", vase::vase(0.27, 36), "Terracotta", on_board(2, -0.26));
    scene.add("Gem", gem::resting(0.12), "Garnet", on_board(4, -0.22));
}

fn add_walls_and_lamp(scene: &mut Scene) {
    let picture = at(vec3(-0.25, 1.62, -room::HALF_DEPTH), 0.0);
    scene.add("Picture frame", joined(furniture::frame(1.10, 0.72)), "Dark wood", picture);
    scene.add("Painting", furniture::canvas(1.10, 0.72), "Painting", picture);
    let lamp = at(LAMP_AT, 0.0);
    scene.add("Lamp stand", joined(furniture::lamp_stand()), "Brass", lamp);
    scene.add("Lamp shade", furniture::lamp_shade(), "Lamp shade", lamp);
    scene.add("Lamp globe", furniture::lamp_bulb(), "White lacquer", lamp);
}

/// A box and its lid, two objects so that it can open.
fn add_box(scene: &mut Scene) {
    let placed = at(BOX_AT, 90.0);
    scene.add("Box", lidded_box::open_box(), "Walnut", placed);
    scene.add("Box lid", lidded_box::lid(), "Walnut", placed * at(lidded_box::HINGE, 0.0));
}

fn materials() -> Vec<Material> {
    let textured = |name, texture, roughness| Material {
        base_color_texture: Some(texture),
        ..Material::dielectric(name, [1.0, 1.0, 1.0], roughness)
    };
    vec![
        Material::dielectric("Plaster", [0.66, 0.62, 0.56], 0.8),
        Material::dielectric("Ceiling paint", [0.74, 0.72, 0.69], 0.8),
        Material::dielectric("White lacquer", [0.72, 0.70, 0.66], 0.35),
        textured("Oak boards", "boards.png", 0.42),
        textured("Rug", "rug.png", 0.8),
        textured("Upholstery", "upholstery.png", 0.8),
        textured("Walnut", "walnut.png", 0.4),
        textured("Painting", "painting.png", 0.6),
        Material { double_sided: true, ..Material::dielectric("Curtain linen", [0.62, 0.57, 0.49], 0.8) },
        Material::dielectric("Cushion linen", [0.43, 0.16, 0.075], 0.8),
        Material::dielectric("Lamp shade", [0.68, 0.61, 0.50], 0.75),
        Material::dielectric("Dark wood", [0.060, 0.036, 0.022], 0.45),
        Material::metal("Brass", [0.78, 0.57, 0.28], 0.3),
        Material::dielectric("Petrol glaze", [0.016, 0.070, 0.080], 0.22),
        Material::dielectric("Terracotta", [0.40, 0.135, 0.070], 0.7),
        Material::metal("Garnet", [0.50, 0.020, 0.042], 0.2),
        Material::dielectric("Book ochre", [0.42, 0.27, 0.085], 0.6),
        Material::dielectric("Book brick", [0.29, 0.075, 0.045], 0.6),
        Material::dielectric("Book ink", [0.045, 0.065, 0.11], 0.55),
        Material::dielectric("Book cream", [0.60, 0.54, 0.43], 0.6),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::assert_sound;

    #[test]
    fn every_piece_is_sound_and_inside_the_shell() {
        let scene = interior();
        for node in &scene.nodes {
            let mesh = scene.pieces[node.piece].mesh.clone().moved(node.world_from_object);
            assert_sound(&mesh);
            let furthest = mesh.positions.iter().fold(Vec3::ZERO, |far, p| far.max(p.abs()));
            assert!(furthest.x < 2.5 && furthest.y < 2.8 && furthest.z < 2.2, "{} reaches {furthest}", node.name);
        }
    }

    #[test]
    fn cameras_are_in_the_room() {
        for camera in interior().cameras {
            let eye = camera.eye.abs();
            assert!(eye.x < room::HALF_WIDTH && eye.y < room::HEIGHT && eye.z < room::HALF_DEPTH);
        }
    }

    #[test]
    fn the_budget_holds() {
        let count = interior().vertex_count();
        assert!((10_000..32_000).contains(&count), "{count}");
    }
}
