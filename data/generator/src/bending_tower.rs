//! The bending tower: a tower that follows five joints, on a floor between a red wall, a waving flag and a block that
//! slides and turns. A demonstration of animations.

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use crate::mesh::Mesh;
use crate::motion::{Clip, Joint, Morph, Motion, Skin, sliding, swinging, turning, waving};
use crate::rounded_box::{plain_box, rounded_box};
use crate::scene::{Camera, Material, PunctualLight, Scene, at};

/// Quads of the tower around and up.
const SIDES: usize = 20;
const STOREYS: usize = 24;
/// Radius at the foot and at the top, and height, in meters.
const RADII: [f32; 2] = [0.34, 0.24];
const HEIGHT: f32 = 2.0;
/// Joints of the tower, one above the other.
const JOINTS: usize = 5;
/// How far a joint swings to each side, in degrees.
const SWING: f32 = 15.0;
/// Quads of the flag, and its size in meters.
const FLAG_CELLS: [usize; 2] = [12, 8];
const FLAG_SIZE: Vec2 = vec2(0.8, 0.5);
/// How far the flag waves to each side, in meters.
const WAVE: f32 = 0.12;
/// Position of the block without an animation.
const BLOCK: Vec3 = vec3(1.1, 0.251, 0.8);

/// Composes the scene.
pub fn bending_tower() -> Scene {
    let mut scene = Scene { name: "bending-tower", materials: materials(), ..Scene::default() };
    let floor = plain_box(vec3(5.0, 0.1, 4.0), 0.5).shifted(vec3(0.0, -0.05, 0.0));
    scene.add("Floor", floor, "Gray paint", Affine3A::IDENTITY);
    let wall = plain_box(vec3(0.1, 2.4, 3.0), 0.4).shifted(vec3(-1.2, 1.2, 0.0));
    scene.add("Wall", wall, "Red paint", Affine3A::IDENTITY);
    scene.add("Tower", tower(), "White paint", Affine3A::IDENTITY);
    let tower = scene.nodes.len() - 1;
    let pole = rounded_box(vec3(0.04, 1.5, 0.04), 0.01, 0.1);
    scene.add("Pole", pole, "Gray paint", at(vec3(1.0, 0.751, -0.9), 0.0));
    scene.add("Flag", flag(), "Blue cloth", at(vec3(1.02, 0.95, -0.9), 0.0));
    let flag = scene.nodes.len() - 1;
    scene.add("Block", rounded_box(Vec3::splat(0.5), 0.02, 0.125), "Green paint", at(BLOCK, 0.0));
    let block = scene.nodes.len() - 1;
    scene.cameras =
        vec![Camera { name: "main", eye: vec3(0.6, 1.7, 6.2), target: vec3(0.1, 0.95, 0.0), vertical_fov: 32.0 }];
    scene.lights = vec![PunctualLight {
        name: "Spot",
        position: vec3(2.2, 3.4, 2.2),
        target: vec3(0.0, 0.6, 0.0),
        intensity: [30.0, 28.0, 25.0],
        cone: Some([28.0, 36.0]),
    }];
    scene.motion = Some(motion(&scene, tower, flag, block));
    scene
}

fn motion(scene: &Scene, tower: usize, flag: usize, block: usize) -> Motion {
    let height = |joint: usize| HEIGHT * joint as f32 / JOINTS as f32;
    let joint = |joint: usize| Joint {
        name: format!("Joint {}", joint + 1),
        parent: joint.checked_sub(1),
        position: vec3(0.0, height(joint), 0.0),
    };
    let bend = (1..JOINTS).map(|joint| swinging(joint, SWING));
    let block_moves = [turning(block), sliding(block, BLOCK, vec3(0.0, 0.0, -0.9))];
    let bend = bend.chain([waving(flag)]).chain(block_moves.clone()).collect();
    Motion {
        joints: (0..JOINTS).map(joint).collect(),
        skin: skin(scene.nodes[tower].piece, &scene.pieces[scene.nodes[tower].piece].mesh),
        morph: wave(scene.nodes[flag].piece, &scene.pieces[scene.nodes[flag].piece].mesh),
        clips: vec![Clip { name: "Bend", channels: bend }, Clip { name: "Block", channels: block_moves.into() }],
    }
}

/// Each vertex follows the joint below it and, with increasing weight, the next one.
fn skin(piece: usize, mesh: &Mesh) -> Skin {
    let follow = |p: &Vec3| {
        let place = (p.y / HEIGHT * JOINTS as f32).clamp(0.0, (JOINTS - 1) as f32);
        let (below, share) = (place.floor(), place.fract());
        let above = (below as usize + 1).min(JOINTS - 1);
        ([below as u16, above as u16, 0, 0], [1.0 - share, share, 0.0, 0.0])
    };
    let (joints, weights) = mesh.positions.iter().map(follow).unzip();
    Skin { piece, joints, weights }
}

/// A wave across the flag that grows with the distance from the pole.
fn wave(piece: usize, mesh: &Mesh) -> Morph {
    let depth = |x: f32| {
        let (along, rate) = (x / FLAG_SIZE.x, std::f32::consts::PI * 1.5);
        let value = WAVE * along * (rate * along).sin();
        let slope = WAVE * ((rate * along).sin() + along * rate * (rate * along).cos()) / FLAG_SIZE.x;
        (value, slope)
    };
    let positions = mesh.positions.iter().map(|p| vec3(0.0, 0.0, depth(p.x).0)).collect();
    let normals = mesh.positions.iter().map(|p| vec3(-depth(p.x).1, 0.0, 1.0).normalize() - Vec3::Z).collect();
    Morph { piece, positions, normals }
}

/// A sheet in the plane of X and Y that hangs on the Y axis.
fn flag() -> Mesh {
    let mut mesh = Mesh::default();
    let [columns, rows] = FLAG_CELLS;
    for row in 0..=rows {
        for column in 0..=columns {
            let uv = vec2(column as f32 / columns as f32, row as f32 / rows as f32);
            mesh.push((uv * FLAG_SIZE).extend(0.0), Vec3::Z, vec2(uv.x, 1.0 - uv.y));
        }
    }
    quads(&mut mesh, columns, rows);
    mesh
}

/// Joins rows of `columns` + 1 vertices by quads.
fn quads(mesh: &mut Mesh, columns: usize, rows: usize) {
    let vertex = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
    for row in 0..rows {
        for column in 0..columns {
            let (right, up) = (column + 1, row + 1);
            mesh.quad(vertex(column, row), vertex(right, row), vertex(right, up), vertex(column, up));
        }
    }
}

/// A closed tower around the Y axis that narrows toward its top.
fn tower() -> Mesh {
    let mut mesh = Mesh::default();
    let radius = |share: f32| RADII[0] + (RADII[1] - RADII[0]) * share;
    let rise = (RADII[0] - RADII[1]) / HEIGHT;
    for storey in 0..=STOREYS {
        let share = storey as f32 / STOREYS as f32;
        for side in 0..=SIDES {
            let outward = around(side);
            let uv = vec2(side as f32 / SIDES as f32, 1.0 - share);
            mesh.push(outward * radius(share) + Vec3::Y * (share * HEIGHT), (outward + Vec3::Y * rise).normalize(), uv);
        }
    }
    quads(&mut mesh, SIDES, STOREYS);
    for (y, radius, normal) in [(0.0, radius(0.0), Vec3::NEG_Y), (HEIGHT, radius(1.0), Vec3::Y)] {
        cap(&mut mesh, y, radius, normal);
    }
    mesh
}

/// A horizontal unit direction. The last equals the first to the bit, which closes the seam.
fn around(side: usize) -> Vec3 {
    let angle = std::f32::consts::TAU * (side % SIDES) as f32 / SIDES as f32;
    vec3(angle.cos(), 0.0, -angle.sin())
}

fn cap(mesh: &mut Mesh, y: f32, radius: f32, normal: Vec3) {
    let uv = |direction: Vec3| Vec2::splat(0.5) + 0.5 * vec2(direction.x, direction.z);
    let middle = mesh.push(Vec3::Y * y, normal, uv(Vec3::ZERO));
    let rim: Vec<u32> =
        (0..=SIDES).map(|side| mesh.push(around(side) * radius + Vec3::Y * y, normal, uv(around(side)))).collect();
    for pair in rim.windows(2) {
        if normal.y > 0.0 { mesh.triangle(middle, pair[0], pair[1]) } else { mesh.triangle(middle, pair[1], pair[0]) }
    }
}

fn materials() -> Vec<Material> {
    let cloth = Material::dielectric("Blue cloth", [0.08, 0.16, 0.55], 0.9);
    vec![
        Material::dielectric("Gray paint", [0.5, 0.5, 0.5], 0.9),
        Material::dielectric("Red paint", [0.58, 0.055, 0.045], 0.9),
        Material::dielectric("White paint", [0.72, 0.70, 0.66], 0.9),
        Material::dielectric("Green paint", [0.12, 0.40, 0.075], 0.9),
        Material { double_sided: true, ..cloth },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound};

    #[test]
    fn pieces_are_sound_and_the_tower_is_closed() {
        let scene = bending_tower();
        for node in &scene.nodes {
            assert_sound(&scene.pieces[node.piece].mesh.clone().moved(node.world_from_object));
        }
        assert_closed(&tower());
        assert!((1_000..6_000).contains(&scene.vertex_count()), "{}", scene.vertex_count());
    }

    #[test]
    fn every_vertex_of_the_tower_follows_joints_and_the_flag_is_fixed_at_its_pole() {
        let motion = bending_tower().motion.unwrap();
        let Skin { joints, weights, .. } = &motion.skin;
        assert_eq!((joints.len(), weights.len()), (tower().positions.len(), tower().positions.len()));
        assert!(joints.iter().flatten().all(|joint| usize::from(*joint) < JOINTS));
        assert!(weights.iter().all(|w| (w.iter().sum::<f32>() - 1.0).abs() < 1e-6));
        let flag = flag();
        let at_pole = flag.positions.iter().zip(&motion.morph.positions).filter(|(p, _)| p.x == 0.0);
        assert!(at_pole.clone().count() == FLAG_CELLS[1] + 1 && at_pole.clone().all(|(_, shift)| *shift == Vec3::ZERO));
        assert!(motion.morph.positions.iter().any(|shift| shift.z.abs() > 0.05));
    }
}
