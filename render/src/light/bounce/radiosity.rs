//! Bounced light of posed objects, solved anew in functions that lie on them (meshless radiosity). Rays are kept: a move traces only
//! those again that it changes.

use super::lit_points::LitPoints;
use crate::{
    baked::Baked,
    light::{
        implicit::Sides,
        situation::{Changes, Relight, Situation},
        sky::SkyGrid,
    },
};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    dataset::Dataset,
    mesh_surface::{CarryingMesh, MeshSurface},
    meshless::{LitFunctions, ObjectBases, Radiosity, RadiosityLight, RadiositySettings, irradiance},
    scene::{Mesh, pose::Poses},
    sparse::SparseRows,
    surfel::Surfel,
    transport::BounceEnergy,
};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Samples of an area light along each of its sides, at each function.
const AREA_SAMPLES: u32 = 2;

/// Solves for bounced light bounce by bounce, as baked or posed.
pub struct RadiosityRig {
    as_baked: Baked,
    posed: Baked,
    poses: Poses,
    solver: Radiosity,
    /// The functions under local lights.
    lit: LitPoints,
    sky: SkyGrid,
    /// Values of the functions at the front and the back of each vertex.
    at_vertices: [SparseRows; 2],
    light: Option<RadiosityLight>,
}

impl RadiosityRig {
    /// Starts as baked and without light; `None` if the dataset has no bases of objects.
    pub fn new(baked: &Baked) -> Option<Self> {
        let bases = (**baked.dataset.object_bases.as_ref()?).clone();
        let lit = LitPoints::new(baked, bases.points().to_vec(), AREA_SAMPLES).in_spatial_order();
        let at_vertices = values_at_vertices(&bases, &baked.dataset);
        let solver = Radiosity::new(bases, RadiositySettings::DEFAULT);
        let (as_baked, posed, sky) = (baked.clone(), baked.clone(), SkyGrid::new(None));
        Some(Self { as_baked, posed, poses: Poses::default(), solver, lit, sky, at_vertices, light: None })
    }

    /// Begins with direct light again; rays stay.
    pub fn restart(&mut self) {
        self.light = None;
    }

    /// Takes the next step: direct light, then one bounce after another. Returns whether more steps remain.
    pub fn step(&mut self) -> bool {
        let Self { as_baked, posed, solver, lit, sky: sky_grid, light, .. } = self;
        let sky = |direction| sky_grid.radiance(direction);
        let lit = LitFunctions {
            direct: &lit.irradiance(),
            reflectance: lit.albedo(),
            emitted: lit.emission(),
            sky: sky_grid.shines().then_some(&sky),
        };
        on_surface(as_baked, posed, |surface| match light {
            Some(light) => solver.bounce(surface, &lit, light),
            none => {
                *none = Some(solver.begin(surface, &lit));
                true
            }
        })
    }

    /// Irradiance of all bounces so far at the vertices in W/m².
    pub fn at_vertices(&self) -> Sides {
        let mesh = &self.posed.dataset.scene.mesh;
        let side = |rows: &SparseRows, side: f32| -> Vec<Vec3> {
            let Some(light) = &self.light else { return vec![Vec3::ZERO; mesh.positions.len()] };
            let of_vertex = |(vertex, &normal): (usize, &Vec3)| {
                irradiance(&rows.product(vertex, &light.total), normal * side).max(Vec3::ZERO)
            };
            mesh.normals.par_iter().enumerate().map(of_vertex).collect()
        };
        let [front, back] = &self.at_vertices;
        Sides { front: side(front, 1.0), back: side(back, -1.0) }
    }

    /// Energy of the bounces so far.
    pub fn energy(&self) -> Option<BounceEnergy> {
        self.light.as_ref().map(RadiosityLight::energy)
    }

    /// Poses the functions, and traces the rays again that the move changes.
    fn pose(&mut self, scene: &Baked, poses: &Poses) {
        let changed: BTreeSet<u32> = self.poses.differing(poses).collect();
        if changed.is_empty() {
            return;
        }
        let left = boxes(&self.posed.dataset.scene.mesh, &changed);
        let now = boxes(&scene.dataset.scene.mesh, &changed);
        (self.posed, self.poses, self.light) = (scene.clone(), poses.clone(), None);
        let Self { as_baked, posed, solver, lit, .. } = self;
        let points = on_surface(as_baked, posed, |surface| {
            solver.follow(surface, &|object| changed.contains(&object), &now, &left);
            solver.placed_points(surface)
        });
        lit.pose(posed, points);
    }
}

impl Relight for RadiosityRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        if changes.poses {
            self.pose(&situation.scene, &situation.poses);
        }
        if changes.environment {
            self.sky = SkyGrid::of(situation);
        }
        self.lit.update(&situation.appearance, &situation.bouncing(), changes);
        if changes.relight() {
            self.light = None;
        }
    }
}

/// Calls `act` with the posed surface.
fn on_surface<T>(as_baked: &Baked, posed: &Baked, act: impl FnOnce(&CarryingMesh) -> T) -> T {
    let dataset = &posed.dataset;
    // Reflectance is that of the functions.
    let black = |_: &Surfel| Vec3::ZERO;
    let now = MeshSurface::new(&dataset.scene.mesh, posed.intersector(), &dataset.two_sided, &black);
    act(&CarryingMesh::new(&as_baked.dataset.scene.mesh, now))
}

/// Boxes around some objects of a mesh.
fn boxes(mesh: &Mesh, objects: &BTreeSet<u32>) -> Vec<Bounds> {
    let object = |triangle: usize| mesh.triangle_object[triangle];
    mesh.bounds_by((0..mesh.triangles.len()).filter(|&triangle| objects.contains(&object(triangle))), object)
}

/// Values of the functions at both sides of the vertices as baked; none at the back of a one-sided surface.
fn values_at_vertices(bases: &ObjectBases, dataset: &Dataset) -> [SparseRows; 2] {
    let mesh = &dataset.scene.mesh;
    let mut corner = vec![None; mesh.positions.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        corners.iter().for_each(|&vertex| {
            let known = corner[vertex as usize].get_or_insert((triangle, false));
            known.1 |= dataset.two_sided[triangle];
        });
    }
    let rows = |side: f32| {
        SparseRows::build(corner.len(), |vertex, out| {
            if let Some((triangle, _)) = corner[vertex].filter(|(_, is_two_sided)| side > 0.0 || *is_two_sided) {
                let (position, normal) = (mesh.positions[vertex], mesh.normals[vertex] * side);
                let at = Surfel { position, normal, ..Surfel::default() };
                bases.finest_values(mesh.triangle_object[triangle], &at, out);
            }
        })
    };
    [rows(1.0), rows(-1.0)]
}
