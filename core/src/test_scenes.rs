//! Small scenes and datasets shared by the tests of all crates.

use crate::{
    camera::Camera,
    cut::{
        CutCriterion,
        packed::{PackedCuts, pack_node},
    },
    dataset::{BakeReport, BakeSettings, Dataset, IndirectSettings, MeshlessSettings, scene_hash},
    light_tree::LightTree,
    lights::{Emission, Light},
    material::Material,
    mesh::Mesh,
    meshless::Basis,
    scene::{Object, Scene},
    sources::Source,
    sphere::{fibonacci_directions, uniform_direction},
    surfel::Surfel,
    texture::Texture,
};
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::{PI, TAU};

/// Triangles of many sizes around the origin.
pub fn soup(seed: u64, count: usize) -> Mesh {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut mesh = Mesh::default();
    let mut point = |scale: f32| Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5) * scale;
    for i in 0..count {
        let center = point(8.0);
        let size = if i % 10 == 0 { 3.0 } else { 0.4 };
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([center + point(size), center + point(size), center + point(size)]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

/// A baked triangle that sees the whole environment, with materials and textures of these names.
pub fn dataset(materials: &[&str], textures: &[&str]) -> Dataset {
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        normals: vec![Vec3::Y; 3],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
        triangles: vec![[0, 2, 1]],
        triangle_material: vec![0],
        triangle_object: vec![0],
        ..Default::default()
    };
    let scene = Scene {
        mesh,
        materials: materials.iter().map(|&name| Material { name: name.into(), ..Default::default() }).collect(),
        textures: textures.iter().map(|name| Texture::missing(name).into()).collect(),
        objects: vec![Object { name: "o".into() }],
        ..Default::default()
    };
    let mut cuts = PackedCuts::default();
    for _ in 0..3 {
        let offset = cuts.push_cut(&[pack_node(0, 1.0)]);
        cuts.push_vertex(offset);
    }
    Dataset {
        indirect: None,
        meshless: None,
        object_bases: None,
        wavelet: None,
        two_sided: vec![false],
        vertex_valid: vec![true; 3],
        tree: LightTree::geometric(64).expect("a power of two"),
        cuts,
        settings: settings(),
        scene_hash: scene_hash(&scene),
        report: BakeReport::default(),
        scene,
    }
}

fn settings() -> BakeSettings {
    BakeSettings {
        lights: 64,
        criterion: CutCriterion { sigma: 1.5, ..CutCriterion::default() },
        pilot_clusters: 256,
        max_vertices: Some(30_000),
        indirect: IndirectSettings { sources: 8192, ..IndirectSettings::default() },
        meshless: MeshlessSettings { levels: 4, sender_levels: 3, rays: 256, ..MeshlessSettings::default() },
        ..Default::default()
    }
}

/// A camera of this name.
pub fn camera(name: &str) -> Camera {
    Camera { name: name.into(), ..Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 35.0) }
}

/// A spot light above the origin that shines down.
pub fn light() -> Light {
    Light {
        name: "spot".into(),
        emission: Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 },
        position: Vec3::new(0.0, 2.0, 0.0),
        intensity: Vec3::new(3.0, 2.0, 1.0),
        ..Default::default()
    }
}

/// A scene of plain triangles with flat normals.
pub fn scene_of(triangles: &[[Vec3; 3]]) -> Scene {
    let mut mesh = Mesh::default();
    for &corners in triangles {
        let first = mesh.positions.len() as u32;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        for p in corners {
            mesh.positions.push(p);
            mesh.normals.push(normal);
            mesh.tangents.push(normal.any_orthonormal_vector().extend(1.0));
            mesh.uvs.push(Vec2::ZERO);
        }
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.triangle_material.push(0);
        mesh.triangle_object.push(0);
    }
    let object = Object { name: "test".into() };
    Scene { mesh, materials: vec![Material::default()], objects: vec![object], ..Default::default() }
}

/// The two triangles of a quad `a b c d`, counter-clockwise.
pub fn quad(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> [[Vec3; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// A horizontal square of half-width `r` at height `y`, facing up.
pub fn floor(r: f32, y: f32) -> [[Vec3; 3]; 2] {
    let p = |x: f32, z: f32| Vec3::new(x * r, y, z * r);
    quad(p(-1.0, -1.0), p(-1.0, 1.0), p(1.0, 1.0), p(1.0, -1.0))
}

/// A closed box around `center`, facing outward.
pub fn cuboid(center: Vec3, half: Vec3) -> Vec<[Vec3; 3]> {
    let p = |x: f32, y: f32, z: f32| center + half * Vec3::new(x, y, z);
    [
        quad(p(-1., 1., -1.), p(-1., 1., 1.), p(1., 1., 1.), p(1., 1., -1.)),
        quad(p(-1., -1., 1.), p(-1., -1., -1.), p(1., -1., -1.), p(1., -1., 1.)),
        quad(p(1., -1., 1.), p(1., -1., -1.), p(1., 1., -1.), p(1., 1., 1.)),
        quad(p(-1., -1., -1.), p(-1., -1., 1.), p(-1., 1., 1.), p(-1., 1., -1.)),
        quad(p(-1., -1., 1.), p(1., -1., 1.), p(1., 1., 1.), p(-1., 1., 1.)),
        quad(p(1., -1., -1.), p(-1., -1., -1.), p(-1., 1., -1.), p(1., 1., -1.)),
    ]
    .concat()
}

/// Cubes of 0.6 m around the point 2.4 m above the origin, each an object.
pub fn cubes(count: u32) -> Scene {
    let center = |i: u32| Vec3::new(1.5, 2.2, 0.0).rotate_y(TAU * i as f32 / count as f32);
    let cubes: Vec<_> = (0..count).map(|i| cuboid(center(i), Vec3::splat(0.3))).collect();
    let mut scene = scene_of(&cubes.concat());
    scene.mesh.triangle_object = (0..count).flat_map(|i| vec![i; cubes[i as usize].len()]).collect();
    scene.objects = (0..count).map(|i| Object { name: format!("cube {i}") }).collect();
    scene
}

/// A closed box that faces inward.
pub fn room(center: Vec3, half: Vec3) -> Vec<[Vec3; 3]> {
    cuboid(center, half).into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

/// Evenly spread points on a sphere, with normals outward, or inward for a negative radius.
pub fn sphere_points(n: usize, radius: f32) -> Vec<Surfel> {
    let point = |d: Vec3| Surfel { position: d * radius.abs(), normal: d * radius.signum(), ..Default::default() };
    fibonacci_directions(n).into_iter().map(point).collect()
}

/// A basis on a sphere: levels with four times as many points each.
///
/// # Panics
/// If there are more sender levels than levels.
pub fn sphere_basis(coarsest: usize, levels: usize, senders: usize, radius: f32) -> Basis {
    let sets: Vec<_> = (0..levels).map(|l| sphere_points(coarsest << (2 * l), radius)).collect();
    // A maximal Poisson-disk set of radius R has about 0.7 / R² points per area.
    let spacing = (0.7 * 4.0 * PI / coarsest as f32).sqrt();
    Basis::new(&sets, spacing, senders).expect("enough levels")
}

/// Uniform directions, the same at each call.
pub fn random_directions(n: usize) -> Vec<Vec3> {
    let mut random = fastrand::Rng::with_seed(2);
    (0..n).map(|_| uniform_direction(random.f32(), random.f32())).collect()
}

/// A square of `2^(2 k)` sources in the plane y = 0, in Morton order, far from the origin.
pub fn square_of_sources(k: u32, half: f32) -> Vec<Source> {
    let side = 1 << k;
    let cell = 2.0 * half / side as f32;
    let coordinate = |code: u32| (0..k).fold(0, |c, bit| c | (code >> (2 * bit) & 1) << bit);
    let source = |i: u32| {
        let at = |c: u32| 100.0 - half + cell * (c as f32 + 0.5);
        let position = Vec3::new(at(coordinate(i)), 0.0, at(coordinate(i >> 1)));
        Source { surfel: Surfel { position, ..Default::default() }, area: cell * cell, spacing: cell }
    };
    (0..side * side).map(source).collect()
}
