//! The scene, its light, and light by rays.

use anyhow::Result;
use glam::{Vec2, Vec3};
use lapidary_core::{
    material::Material,
    mesh_surface::MeshSurface,
    meshless::{SenderSamples, Solver},
    ray::Intersector,
    scene::{Object, Scene},
    sphere::{GOLDEN_TURN, cosine_direction, frame_around},
    surfel::{Surface, Surfel},
};
use lapidary_interchange::import::import;
use lapidary_precompute::{Sidedness, classify};
use rayon::prelude::*;

/// Diffuse reflectance of all surfaces.
pub const GREY: f32 = 0.5;

/// A scene with the data that its surface borrows.
pub struct Prepared {
    pub scene: Scene,
    sides: Sidedness,
    intersector: Intersector,
}

impl Prepared {
    pub fn load(name: &str) -> Result<Self> {
        let scene = if name == "boxes" { boxes() } else { import(name.as_ref())?.scene };
        Ok(Self { sides: classify(&scene), intersector: Intersector::new(&scene.mesh), scene })
    }

    pub fn surface(&self) -> MeshSurface<'_> {
        MeshSurface::new(&self.scene.mesh, &self.intersector, &self.sides.two_sided, &|_| Vec3::splat(GREY))
    }
}

/// A point light of 1 W/sr.
pub struct Lamp {
    pub position: Vec3,
}

impl Lamp {
    /// Irradiance of the lamp.
    pub fn direct(&self, surface: &MeshSurface, at: &Surfel) -> f32 {
        let to_lamp = self.position - at.position;
        let cosine = to_lamp.normalize_or_zero().dot(at.normal);
        let lit = cosine > 0.0 && surface.sees(at.position + at.normal * surface.offset(), self.position);
        if lit { cosine / to_lamp.length_squared() } else { 0.0 }
    }
}

/// Irradiance of the senders under the lamp, and their reflectance.
pub fn lit(samples: &SenderSamples, solver: &Solver, surface: &MeshSurface, lamp: &Lamp) -> (Vec<Vec3>, Vec<Vec3>) {
    let direct: Vec<Vec3> = samples.points().par_iter().map(|p| Vec3::splat(lamp.direct(surface, p))).collect();
    samples.fit(solver, &direct, &vec![Vec3::splat(GREY); direct.len()])
}

/// Irradiance of a point from surfaces with the given radiance, by cosine-distributed rays along a Fibonacci lattice with a random
/// shift per point.
pub fn gathered(surface: &MeshSurface, at: &Surfel, rays: usize, radiance: impl Fn(&Surfel) -> f32) -> f32 {
    let (frame, origin) = (frame_around(at.normal), at.position + at.normal * surface.offset());
    let mut random = fastrand::Rng::with_seed(at.position.x.to_bits().into());
    let (shift, turn) = (random.f32(), random.f32());
    let ray = |i: usize| {
        let (u, v) = ((i as f32 + shift) / rays as f32, (i as f32 * GOLDEN_TURN + turn).fract());
        surface.first_hit(origin, frame * cosine_direction(u, v)).map_or(0.0, |hit| radiance(&hit))
    };
    (0..rays).map(ray).sum::<f32>() * (std::f32::consts::PI / rays as f32)
}

/// A closed room of 2 m that faces inward, with a tall and a low box in it.
fn boxes() -> Scene {
    let mut scene = Scene {
        materials: vec![Material::default()],
        objects: vec![Object { name: "boxes".into() }],
        ..Default::default()
    };
    add_box(&mut scene, Vec3::ZERO, Vec3::ONE, true);
    add_box(&mut scene, Vec3::new(-0.4, -0.4, -0.4), Vec3::new(0.25, 0.6, 0.25), false);
    add_box(&mut scene, Vec3::new(0.4, -0.7, 0.4), Vec3::new(0.3, 0.3, 0.3), false);
    scene
}

fn add_box(scene: &mut Scene, center: Vec3, half: Vec3, inward: bool) {
    let mesh = &mut scene.mesh;
    for face in 0..6 {
        let (axis, outward) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let normal = Vec3::AXES[axis] * outward;
        let (u, v) = (Vec3::AXES[(axis + 1) % 3] * outward, Vec3::AXES[(axis + 2) % 3]);
        let first = mesh.positions.len() as u32;
        for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            mesh.positions.push(center + half * (normal + u * s + v * t));
            mesh.normals.push(if inward { -normal } else { normal });
            mesh.tangents.push(u.extend(1.0));
            mesh.uvs.push(Vec2::ZERO);
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
            mesh.triangles.push(if inward {
                [first + a, first + c, first + b]
            } else {
                [first + a, first + b, first + c]
            });
            mesh.triangle_material.push(0);
            mesh.triangle_object.push(0);
        }
    }
}
