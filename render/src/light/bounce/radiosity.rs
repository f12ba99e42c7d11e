//! Bounced light of posed objects, solved anew in functions that lie on them (meshless radiosity). Rays are kept: a move traces only
//! those again that it changes.

use super::{MeshlessLight, VerticesAsBaked, lit_points::LitPoints};
use crate::{
    baked::Baked,
    device::{Compute, GpuFans, GpuRadiosity},
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
    meshless::{
        LitFunctions, Radiosity, RadiosityLight, RadiositySettings, RadiosityStep, TransportDevice, irradiance,
    },
    ray::FanDevice,
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

/// Most bytes of a buffer of rays on a device, so that the last one, which is not full, wastes little.
const BYTES_OF_A_BUFFER: u64 = 128 << 20;

/// Solves for bounced light bounce by bounce, as baked or posed.
pub struct RadiosityRig {
    as_baked: Baked,
    /// The mesh as baked, with hidden objects where they would be: there functions lie on them.
    mesh: Mesh,
    vertices: Arc<VerticesAsBaked>,
    posed: Baked,
    poses: Poses,
    solver: Radiosity,
    /// The functions under local lights.
    lit: LitPoints,
    sky: SkyGrid,
    light: Option<RadiosityLight>,
    /// Number of the present solution.
    begun: u64,
    compute: Compute,
    /// The posed scene on the device that traces its rays, if there is one that takes it.
    on_device: Option<GpuFans>,
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
        let mesh = baked.dataset.scene.shown_mesh().into_owned();
        let vertices = VerticesAsBaked::of(&mesh).into();
        let solver = Radiosity::new(bases, RadiositySettings::DEFAULT);
        let (as_baked, posed, sky) = (baked.clone(), baked.clone(), SkyGrid::new(None));
        let (poses, compute) = (Poses::default(), Compute::Cores);
        let (light, on_device, at_sources) = (None, None, None);
        let begun = 0;
        Some(Self {
            as_baked,
            mesh,
            vertices,
            posed,
            poses,
            solver,
            lit,
            sky,
            light,
            begun,
            compute,
            on_device,
            at_sources,
        })
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
        let Self { mesh, posed, solver, lit, sky: sky_grid, light, on_device, .. } = self;
        let sky = |direction| sky_grid.radiance(direction);
        let lit = LitFunctions {
            direct: &lit.irradiance(),
            reflectance: lit.albedo(),
            emitted: lit.emission(),
            sky: sky_grid.shines().then_some(&sky),
        };
        on_surface((mesh, posed), on_device.as_ref(), |surface| match light {
            Some(light) => solver.advance(surface, &lit, light, RECEIVERS_OF_A_STEP),
            none => {
                *none = Some(solver.begin(surface, &lit));
                RadiosityStep::Partial
            }
        })
    }

    /// All bounces so far, for any point.
    pub fn shown(&self) -> Option<MeshlessLight> {
        MeshlessLight::of_objects(&self.as_baked.dataset, &self.vertices, self.light.as_ref()?.total.clone())
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
        let Self { mesh, posed, solver, lit, .. } = self;
        let points = on_surface((mesh, posed), None, |surface| {
            solver.follow(surface, &now, &left);
            solver.placed_points(surface)
        });
        lit.pose(posed, points);
    }

    /// What gathers light on the device, if it takes the functions.
    fn transport_device(&self) -> Option<Box<dyn TransportDevice>> {
        let Compute::Device(device) = &self.compute else { return None };
        let (bases, directions) = (self.solver.bases(), self.solver.directions());
        let gathers = GpuRadiosity::new(device, bases, directions, BYTES_OF_A_BUFFER).ok()?;
        Some(Box::new(gathers))
    }

    /// Takes the posed scene to the device. The cores trace what it does not take.
    fn take_to_device(&mut self) {
        let (scene, known) = (self.posed.intersector(), self.on_device.take());
        self.on_device = match (&self.compute, known) {
            (Compute::Cores, _) => None,
            (Compute::Device(device), Some(known)) => known.with_scene(device, scene).ok(),
            (Compute::Device(device), None) => GpuFans::new(device, scene, self.solver.directions()).ok(),
        };
    }
}

impl Relight for RadiosityRig {
    fn update(&mut self, situation: &Situation, changes: Changes) {
        let is_elsewhere = !self.compute.is_same(&situation.compute);
        if is_elsewhere {
            (self.compute, self.on_device) = (situation.compute.clone(), None);
            self.solver.set_device(self.transport_device());
        }
        if changes.poses {
            self.pose(&situation.scene, &situation.poses);
        }
        if changes.poses || is_elsewhere {
            self.take_to_device();
        }
        if changes.environment {
            self.sky = SkyGrid::of(situation);
        }
        self.lit.update((&situation.appearance, &situation.bouncing()), &situation.compute, changes);
        if changes.relight() {
            self.light = None;
        }
    }
}

/// Calls `act` with the posed surface.
fn on_surface<T>(
    (as_baked, posed): (&Mesh, &Baked),
    device: Option<&GpuFans>,
    act: impl FnOnce(&CarryingMesh) -> T,
) -> T {
    let dataset = &posed.dataset;
    // Reflectance is that of the functions.
    let black = |_: &Surfel| Vec3::ZERO;
    let now = MeshSurface::new(&dataset.scene.mesh, posed.intersector(), &dataset.two_sided, &black);
    let device = device.map(|device| device as &dyn FanDevice);
    act(&CarryingMesh::new(as_baked, now).on_device(device))
}

/// Boxes around some objects of a mesh, those that have triangles.
fn boxes(mesh: &Mesh, objects: &BTreeSet<u32>) -> BTreeMap<u32, Bounds> {
    let object = |triangle: usize| mesh.triangle_object[triangle];
    let triangles: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| objects.contains(&object(t))).collect();
    let present: BTreeSet<u32> = triangles.iter().map(|&triangle| object(triangle)).collect();
    present.into_iter().zip(mesh.bounds_by(triangles, object)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        device::test_adapter::{on_adapter, shared_device},
        light::bounce::meshless::functions::tests::with_functions_of_objects,
        test_scenes::{linked_floor_and_wall, point_light},
    };
    use glam::Mat3A;
    use lapidary_core::scene::{Object, pose::Pose};

    /// The light of all bounces.
    fn solved(rig: &mut RadiosityRig) -> Vec<Mat3A> {
        while rig.step() != RadiosityStep::Last {}
        rig.shown().unwrap().coefficients().to_vec()
    }

    fn difference(a: &[Mat3A], b: &[Mat3A]) -> f32 {
        let length = |m: Mat3A| m.to_cols_array().iter().map(|x| x * x).sum::<f32>();
        let apart: f32 = a.iter().zip(b).map(|(a, b)| length(*a - *b)).sum();
        (apart / b.iter().map(|b| length(*b)).sum::<f32>()).sqrt()
    }

    #[test]
    fn a_device_finds_the_light_of_the_cores_and_after_a_move_that_of_a_fresh_solution() {
        let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
        let mut dataset = linked_floor_and_wall();
        let scene = &mut dataset.scene;
        for triangle in 0..scene.mesh.triangles.len() {
            let is_floor = scene.mesh.area_vector(triangle).normalize().y.abs() > 0.5;
            scene.mesh.triangle_object[triangle] = u32::from(!is_floor);
        }
        scene.objects = ["floor", "wall"].map(|name| Object { name: name.into() }).into();
        let baked = Baked::from(with_functions_of_objects(dataset));
        let mut situation = Situation::unlit(&baked);
        situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), 3.0)].into();
        let fresh = |situation: &Situation| {
            let mut rig = RadiosityRig::new(&baked).unwrap();
            rig.pose(&situation.scene, &situation.poses);
            rig.update(situation, Changes::ALL);
            rig
        };
        let on_cores = solved(&mut fresh(&situation));
        situation.compute = Compute::Device(device);
        let mut rig = fresh(&situation);
        let as_baked = solved(&mut rig);
        assert!(rig.on_device.is_some() && rig.solver.has_device(), "it takes a small scene");
        assert!(difference(&as_baked, &on_cores) < 2e-3, "{}", difference(&as_baked, &on_cores));

        situation.poses.set(1, Pose { translate: Vec3::X * 0.3, ..Pose::AS_BAKED });
        situation.scene = baked.posed(&situation.poses).unwrap();
        rig.update(&situation, Changes { poses: true, ..Changes::NONE });
        let moved = solved(&mut rig);
        assert!(moved == solved(&mut fresh(&situation)), "to the bit");
        assert!(difference(&moved, &on_cores) > 0.02, "negative control: {}", difference(&moved, &on_cores));
        situation.compute = Compute::Cores;
        let on_cores = solved(&mut fresh(&situation));
        assert!(difference(&moved, &on_cores) < 2e-3, "{}", difference(&moved, &on_cores));
    }
}
