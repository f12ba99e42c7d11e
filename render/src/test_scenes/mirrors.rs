//! Mirrors: under a plate, under a ball, beside another, and the inside of a sphere.

use super::{add_quad, add_wall, dataset, floor_under_plate, illumination, sphere};
use crate::{Background, Illumination, View};
use glam::Vec3;
use lapidary_core::{
    brdf::{GgxParameters, LambertParameters},
    camera::Camera,
    dataset::Dataset,
    material::{BrdfModel, Material},
    scene::{Mesh, Scene},
};

pub(crate) fn metal(alpha: f32) -> GgxParameters {
    GgxParameters { base_color: Vec3::ONE, roughness: alpha.sqrt(), metalness: 1.0, ..Default::default() }
}

pub(crate) fn mirror(alpha: f32) -> Material {
    Material { model: BrdfModel::Ggx, parameters: metal(alpha).into(), ..Default::default() }
}

/// A floor of metal under a white plate.
pub(crate) fn mirror_under_plate(alpha: f32) -> Dataset {
    let mut mesh = floor_under_plate(32, Some(32));
    // Behind the triangles of the floor.
    mesh.triangle_material[2 * 32 * 32..].fill(1);
    let mut dataset = dataset(mesh, metal(alpha));
    dataset.scene.materials[0] = mirror(alpha);
    let parameters = LambertParameters { base_color: Vec3::new(0.8, 0.5, 0.3) }.into();
    dataset.scene.materials.push(Material { model: BrdfModel::Lambert, parameters, ..Default::default() });
    dataset
}

/// The same beside a wall that is a mirror, too, of its own material.
pub(crate) fn two_mirrors_and_plate(alpha: f32) -> Dataset {
    let Scene { mut mesh, mut materials, .. } = mirror_under_plate(alpha).scene;
    let before = mesh.triangles.len();
    add_wall(&mut mesh);
    mesh.triangle_material[before..].fill(2);
    materials.push(mirror(alpha));
    let mut both = dataset(mesh, metal(alpha));
    both.scene.materials = materials;
    both
}

/// The inside of a mirror sphere that is open at its top.
pub(crate) fn mirror_bowl(alpha: f32) -> Dataset {
    let mut mesh = sphere(24);
    let is_open = |mesh: &Mesh, corners: &[u32; 3]| corners.iter().all(|&v| mesh.positions[v as usize].y > 0.3);
    mesh.triangles = mesh.triangles.iter().copied().filter(|corners| !is_open(&mesh, corners)).collect();
    mesh.triangle_material.truncate(mesh.triangles.len());
    mesh.triangle_object.truncate(mesh.triangles.len());
    let mut dataset = dataset(mesh, metal(alpha));
    dataset.scene.materials[0] = mirror(alpha);
    dataset
}

/// A mirror floor under a mirror ball.
pub(crate) fn mirror_under_ball(alpha: f32) -> Dataset {
    let mut mesh = sphere(24);
    mesh.positions.iter_mut().for_each(|p| *p = 0.3 * *p + 0.5 * Vec3::Y);
    mesh.normals.iter_mut().for_each(|n| *n = -*n);
    mesh.triangles.iter_mut().for_each(|corners| corners.reverse());
    add_quad(&mut mesh, Vec3::new(-2.0, 0.0, -2.0), 4.0 * Vec3::Z, 4.0 * Vec3::X);
    let mut dataset = dataset(mesh, metal(alpha));
    dataset.scene.materials[0] = mirror(alpha);
    dataset
}

/// Into the bowl.
pub(crate) fn into_bowl() -> Camera {
    Camera::look_at(Vec3::new(0.3, 0.9, 0.5), Vec3::new(-0.1, -0.6, -0.1), 50.0)
}

/// The mirror with what it shows, on black.
pub(crate) fn toward_mirror(size: [u32; 2]) -> View {
    let camera = Camera::look_at(Vec3::new(0.0, 1.2, 3.2), Vec3::new(0.0, -0.5, 0.0), 40.0);
    View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, size) }
}

/// Bright below the horizon: the plate is bright from below, before a dark sky.
pub(crate) fn from_below() -> Illumination {
    illumination([64, 32], |_, y| Vec3::splat(if y < 16 { 0.05 } else { 3.0 }))
}
