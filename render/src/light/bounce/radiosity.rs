//! Bounced light of posed objects, solved anew in functions that lie on them (meshless radiosity). Rays are kept: a move traces only
//! those again that it changes.

use super::{MeshlessLight, lit_points::LitPoints};
use crate::{
    baked::Baked,
    light::{
        situation::{Changes, Relight, Situation},
        sky::SkyGrid,
    },
};
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    gather_table::GatherHit,
    mesh_surface::{CarryingMesh, MeshSurface},
    meshless::{LitFunctions, Radiosity, RadiosityLight, RadiositySettings, RadiosityStep, irradiance},
    scene::{Mesh, pose::Poses},
    sources::Source,
    sparse::SparseRows,
    surfel::Surfel,
    transport::BounceEnergy,
};
use rayon::prelude::*;
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Samples of an area light along each of its sides, at each function.
const AREA_SAMPLES: u32 = 2;

/// Receivers whose rays are traced in one step, so that a drag need not wait.
const RECEIVERS_OF_A_STEP: usize = 1024;

/// Solves for bounced light bounce by bounce, as baked or posed.
pub struct RadiosityRig {
    as_baked: Baked,
    posed: Baked,
    poses: Poses,
    solver: Radiosity,
    /// The functions under local lights.
    lit: LitPoints,
    sky: SkyGrid,
    /// The object of each vertex.
    owners: Arc<[u32]>,
    light: Option<RadiosityLight>,
    /// Number of the present solution.
    begun: u64,
    /// Values of the functions at the surface sources, if the dataset has any; computed at the first use.
    at_sources: Option<SparseRows>,
}

/// Rays of a [`RadiosityRig`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RadiosityRays {
    /// Rays that are kept, 8 bytes each.
    pub kept: u64,
    /// Kept rays that were traced again since the last move.
    pub traced_again: u64,
}

impl RadiosityRig {
    /// Starts as baked and without light; `None` if the dataset has no bases of objects.
    pub fn new(baked: &Baked) -> Option<Self> {
        let bases = (**baked.dataset.object_bases.as_ref()?).clone();
        let lit = LitPoints::new(baked, bases.points().to_vec(), AREA_SAMPLES).in_spatial_order();
        let owners = baked.dataset.scene.mesh.owners().into();
        let solver = Radiosity::new(bases, RadiositySettings::DEFAULT);
        let (as_baked, posed, sky) = (baked.clone(), baked.clone(), SkyGrid::new(None));
        let poses = Poses::default();
        Some(Self { as_baked, posed, poses, solver, lit, sky, owners, light: None, begun: 0, at_sources: None })
    }

    /// The number of the present solution.
    pub fn begun(&self) -> u64 {
        self.begun
    }

    /// Begins with direct light again; rays stay. Returns the number of the new solution.
    pub fn restart(&mut self) -> u64 {
        self.light = None;
        self.begun += 1;
        self.begun
    }

    /// Goes on with the next bounce, for some tenths of a second at most.
    pub fn step(&mut self) -> RadiosityStep {
        let Self { as_baked, posed, solver, lit, sky: sky_grid, light, .. } = self;
        let sky = |direction| sky_grid.radiance(direction);
        let lit = LitFunctions {
            direct: &lit.irradiance(),
            reflectance: lit.albedo(),
            emitted: lit.emission(),
            sky: sky_grid.shines().then_some(&sky),
        };
        on_surface(as_baked, posed, |surface| match light {
            Some(light) => solver.advance(surface, &lit, light, RECEIVERS_OF_A_STEP),
            none => {
                *none = Some(solver.begin(surface, &lit));
                RadiosityStep::Partial
            }
        })
    }

    /// All bounces so far, for any point.
    pub fn shown(&self) -> Option<MeshlessLight> {
        MeshlessLight::of_objects(&self.as_baked.dataset, &self.owners, self.light.as_ref()?.total.clone())
    }

    /// Irradiance of all bounces so far at the surface sources in W/m²; of a scene as baked.
    pub fn at_sources(&mut self, sources: &[Source]) -> Vec<Vec3> {
        let mesh = &self.as_baked.dataset.scene.mesh;
        let bases = self.solver.bases();
        let values = |source: usize, out: &mut Vec<(u32, f32)>| {
            let at = &sources[source].surfel;
            bases.finest_values(mesh.triangle_object[at.place.triangle as usize], at, out);
        };
        let rows = self.at_sources.take().unwrap_or_else(|| SparseRows::build(sources.len(), values));
        let received = self.received(&rows, |source| mesh.shading_normal(&sources[source].surfel));
        self.at_sources = Some(rows);
        received
    }

    /// Irradiance of points with these values of the functions.
    fn received(&self, rows: &SparseRows, normal: impl Fn(usize) -> Vec3 + Sync) -> Vec<Vec3> {
        let Some(light) = &self.light else { return vec![Vec3::ZERO; rows.len()] };
        let of = |point: usize| irradiance(&rows.product(point, &light.total), normal(point)).max(Vec3::ZERO);
        (0..rows.len()).into_par_iter().map(of).collect()
    }

    /// Energy of the bounces so far.
    pub fn energy(&self) -> Option<BounceEnergy> {
        self.light.as_ref().map(RadiosityLight::energy)
    }

    /// The rays so far.
    pub fn rays(&self) -> RadiosityRays {
        let kept = self.solver.table().bytes() / size_of::<GatherHit>() as u64;
        RadiosityRays { kept, traced_again: self.solver.traced_again() }
    }

    /// Poses the functions. Rays that the move changes are traced again by the next steps.
    fn pose(&mut self, scene: &Baked, poses: &Poses) {
        let changed: BTreeSet<u32> = self.poses.differing(poses).collect();
        if changed.is_empty() {
            return;
        }
        let left: Vec<Bounds> = boxes(&self.posed.dataset.scene.mesh, &changed).into_values().collect();
        let now = boxes(&scene.dataset.scene.mesh, &changed);
        (self.posed, self.poses, self.light) = (scene.clone(), poses.clone(), None);
        let Self { as_baked, posed, solver, lit, .. } = self;
        let points = on_surface(as_baked, posed, |surface| {
            solver.follow(surface, &now, &left);
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

/// Boxes around some objects of a mesh, those that have triangles.
fn boxes(mesh: &Mesh, objects: &BTreeSet<u32>) -> BTreeMap<u32, Bounds> {
    let object = |triangle: usize| mesh.triangle_object[triangle];
    let triangles: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| objects.contains(&object(t))).collect();
    let present: BTreeSet<u32> = triangles.iter().map(|&triangle| object(triangle)).collect();
    present.into_iter().zip(mesh.bounds_by(triangles, object)).collect()
}
