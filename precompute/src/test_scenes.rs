//! Scenes for tests: plain triangles in known places.

use crate::{
    mesh_surface::MeshSurface,
    vertices::sidedness::{Sidedness, classify},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    material::Material,
    ray::Intersector,
    scene::{Mesh, Object, Scene},
};

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

/// A scene with all that a [`MeshSurface`] borrows.
pub struct Prepared {
    pub scene: Scene,
    pub sides: Sidedness,
    pub intersector: Intersector,
}

impl Prepared {
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let scene = scene_of(triangles);
        Self { sides: classify(&scene), intersector: Intersector::new(&scene.mesh), scene }
    }

    pub fn surface(&self) -> MeshSurface<'_> {
        MeshSurface::new(&self.scene.mesh, &self.intersector, &self.sides.two_sided, &|_| Vec3::splat(0.5))
    }
}

/// A closed box that faces inward.
pub fn room(center: Vec3, half: Vec3) -> Vec<[Vec3; 3]> {
    cuboid(center, half).into_iter().map(|[a, b, c]| [a, c, b]).collect()
}
