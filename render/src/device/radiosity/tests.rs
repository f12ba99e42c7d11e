//! Each kernel against plain sums over random data, and whole solutions against those of the cores.

use super::*;
use crate::device::test_adapter::{on_adapter, shared_device};
use fastrand::Rng;
use lapidary_core::{
    bounds::Bounds,
    gather_table::RayFan,
    mesh_surface::{CarryingMesh, MeshSurface},
    meshless::{LitFunctions, Radiosity, RadiosityLight, RadiositySettings, RadiosityStep},
    ray::Intersector,
    scene::Scene,
    surfel::Surfel,
    test_scenes::{cuboid, room, scene_of},
};
use std::collections::BTreeMap;

const BLACK: &(dyn Fn(&Surfel) -> Vec3 + Sync) = &|_| Vec3::ZERO;

/// A closed room with a block, which is object 1.
struct Stage {
    as_baked: Scene,
    now: Scene,
    rays: Intersector,
    two_sided: Vec<bool>,
}

impl Stage {
    /// With the block away from its baked place.
    fn new(by: Vec3) -> Self {
        let (walls, block) = (room(Vec3::ZERO, Vec3::ONE), cuboid(Vec3::new(0.3, -0.7, 0.2), Vec3::new(0.2, 0.3, 0.2)));
        let scene = |by: Vec3| {
            let moved: Vec<[Vec3; 3]> = block.iter().map(|corners| corners.map(|corner| corner + by)).collect();
            let mut scene = scene_of(&[&walls[..], &moved].concat());
            let is_block = |triangle: usize| u32::from(triangle >= walls.len());
            scene.mesh.triangle_object = (0..scene.mesh.triangles.len()).map(is_block).collect();
            scene
        };
        let now = scene(by);
        let two_sided = vec![false; now.mesh.triangles.len()];
        Self { as_baked: scene(Vec3::ZERO), rays: Intersector::new(&now.mesh), two_sided, now }
    }

    fn surface(&self) -> CarryingMesh<'_> {
        CarryingMesh::new(&self.as_baked.mesh, self.mesh_surface())
    }

    fn mesh_surface(&self) -> MeshSurface<'_> {
        MeshSurface::new(&self.now.mesh, &self.rays, &self.two_sided, BLACK)
    }

    /// Functions at random points. The second level sends.
    fn bases(&self, counts: [usize; 3]) -> ObjectBases {
        let surface = self.mesh_surface();
        let level = |(seed, count): (u64, usize)| {
            let mut points: Vec<_> =
                surface.uniform_points(count, seed).0.into_iter().map(|point| (point, surface.owner(&point))).collect();
            points.sort_by_key(|(_, owner)| owner.object);
            points
        };
        let levels: Vec<_> = (0..).zip(counts).map(level).collect();
        // About eight functions reach each point of the walls.
        let radii = counts.map(|count| (8.0 * 24.0 / (std::f32::consts::PI * count as f32)).sqrt());
        ObjectBases::new(&levels, radii.to_vec(), 1).unwrap()
    }

    /// The box around the block now.
    fn block(&self) -> Bounds {
        let mesh = &self.now.mesh;
        let of_block = mesh.owners().into_iter().zip(&mesh.positions).filter(|(owner, _)| *owner == 1);
        Bounds::around(of_block.map(|(_, position)| *position))
    }
}

fn length(vector: Mat3A) -> f32 {
    vector.to_cols_array().iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// Functions with random senders at the ends of their rays, and what the kernels should make of them.
struct Random {
    bases: ObjectBases,
    fan: RayFan,
    radiance: Vec<Vec3A>,
    covered: Vec<bool>,
    splits: Vec<bool>,
}

impl Random {
    fn new(counts: [usize; 3], rays: usize) -> Self {
        let bases = Stage::new(Vec3::ZERO).bases(counts);
        let mut rng = Rng::with_seed(9);
        let radiance = (0..counts[1]).map(|_| Vec3A::new(rng.f32(), rng.f32(), rng.f32())).collect();
        let covered = (0..bases.len()).map(|_| rng.u32(0..7) == 0).collect();
        Self { splits: vec![false; bases.len()], fan: RayFan::new(rays), radiance, covered, bases }
    }

    fn rays(&self, function: u32) -> ReceiverRays {
        let mut rng = Rng::with_seed(u64::from(function));
        // Some rays meet no sender.
        let sender = |_| Some(rng.u32(0..self.radiance.len() as u32 * 5 / 4));
        let is_there = |sender: &u32| (*sender as usize) < self.radiance.len();
        let senders = (0..self.fan.directions().len()).map(sender);
        ReceiverRays {
            function,
            frame: RayFan::frame(function, self.bases.points()[function as usize].normal),
            senders: senders.map(|sender| sender.filter(is_there).unwrap_or(u32::MAX)).collect(),
        }
    }

    /// The functions of a level that gather.
    fn active(&self, level: usize, covered: &[bool]) -> Vec<u32> {
        let tells_little = |parent: u32| self.splits[parent as usize] || covered[parent as usize];
        let parents = |function: usize| self.bases.parents().row(function);
        let is_active = |&function: &usize| {
            let any = parents(function).iter().any(|(parent, _)| tells_little(*parent));
            !covered[function] && (any || parents(function).is_empty())
        };
        self.bases.level(level).filter(is_active).map(|function| function as u32).collect()
    }

    fn gathered(&self, function: u32, radiance: &[Vec3A]) -> Mat3A {
        let rays = self.rays(function);
        let mut sum = Mat3A::ZERO;
        for (&direction, &sender) in self.fan.directions().iter().zip(&rays.senders) {
            if let Some(sent) = radiance.get(sender as usize) {
                let toward = Vec3A::from(rays.frame * direction) * self.fan.solid_angle();
                sum += Mat3A::from_cols(toward * sent.x, toward * sent.y, toward * sent.z);
            }
        }
        sum
    }
}

/// The most that two lights of functions differ, relative to the mean.
fn most_apart(found: &[Mat3A], expected: &[Mat3A]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let most = found.iter().zip(expected).map(|(a, b)| length(*a - *b)).fold(0.0, f32::max);
    most * expected.len() as f32 / expected.iter().map(|light| length(*light)).sum::<f32>()
}

#[test]
fn lists_are_exact_and_light_and_splits_are_those_of_plain_sums() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    // More blocks than the scan takes at a time, more rays than lanes, and several buffers of rays.
    let mut random = Random::new([75, 1030, 70_000], 72);
    let row = (random.fan.directions().len() * size_of::<u32>()) as u64;
    let mut gpu = GpuRadiosity::new(&device, &random.bases, random.fan.directions(), 9000 * row).unwrap();
    gpu.send(&random.radiance, &random.covered).unwrap();
    for (level, enough) in [-1.0, 0.5, 0.5].into_iter().enumerate() {
        let active = random.active(level, &random.covered);
        let found = gpu.find_active(level).unwrap();
        assert_eq!((found.count, &found.unknown), (active.len(), &active));
        assert!(active != random.active(level, &vec![false; random.bases.len()]), "negative control: none is covered");
        let third: Vec<ReceiverRays> = active.iter().step_by(3).map(|&function| random.rays(function)).collect();
        gpu.take_rays(&third).unwrap();
        let rest: Vec<u32> = active.iter().enumerate().filter(|(i, _)| i % 3 != 0).map(|(_, &f)| f).collect();
        assert_eq!(gpu.find_active(level).unwrap(), ActiveFunctions { count: active.len(), unknown: rest.clone() });
        gpu.take_rays(&rest.iter().map(|&function| random.rays(function)).collect::<Vec<_>>()).unwrap();
        let listed: Vec<u32> = read_range(&device.gpu, &gpu.buffers.receivers, 0..active.len()).unwrap();
        assert_eq!(listed, active);

        gpu.gather(level, enough).unwrap();
        let functions = random.bases.level(level);
        let before = gpu.received(0..functions.start).unwrap();
        let pulled: Vec<Mat3A> =
            functions.clone().map(|function| random.bases.parents().product(function, &before)).collect();
        let with = |radiance: &[Vec3A]| {
            let mut light = pulled.clone();
            for &function in &active {
                light[function as usize - functions.start] = random.gathered(function, radiance);
            }
            light
        };
        let (found, expected) = (gpu.received(functions.clone()).unwrap(), with(&random.radiance));
        assert!(most_apart(&found, &expected) < 1e-5, "{level}: {}", most_apart(&found, &expected));
        let mut others = random.radiance.clone();
        others.rotate_left(1);
        assert!(most_apart(&found, &with(&others)) > 0.1, "negative control: radiance of other senders");

        let states: Vec<u32> = read_range(&device.gpu, &gpu.buffers.states, functions.clone()).unwrap();
        let [mut splits, mut edges, mut of_none] = [0, 0, 0];
        for &function in &active {
            let at = function as usize - functions.start;
            let difference = length(expected[at] - pulled[at]);
            let is_split = states[at] == 2;
            edges += usize::from(is_split != (difference > enough));
            assert!(is_split == (difference > enough) || (difference - enough).abs() < 1e-5, "{difference}");
            (splits, of_none) = (splits + usize::from(is_split), of_none + usize::from(is_split != (difference > 0.0)));
            random.splits[function as usize] = is_split;
        }
        assert!(edges * 1000 <= active.len(), "{edges} of {}", active.len());
        assert!(level == 0 || (splits * 5 > active.len() && of_none * 5 > active.len()), "{splits} {of_none}");
    }
    assert!(gpu.rows.parts().len() > 4, "{}", gpu.rows.parts().len());
    gpu.forget_rays();
    assert_eq!(gpu.find_active(1).unwrap().unknown, random.active(1, &random.covered), "all are unknown again");
}

/// A device that may miss moves, or fail.
struct Faulty {
    gpu: GpuRadiosity,
    misses_moves: bool,
    /// Levels that it gathers before it fails.
    levels: usize,
}

impl TransportDevice for Faulty {
    fn send(&mut self, radiance: &[Vec3A], covered: &[bool]) -> Result<(), String> {
        self.gpu.send(radiance, covered)
    }

    fn find_active(&mut self, level: usize) -> Result<ActiveFunctions, String> {
        self.gpu.find_active(level)
    }

    fn take_rays(&mut self, receivers: &[ReceiverRays]) -> Result<(), String> {
        self.gpu.take_rays(receivers)
    }

    fn forget_rays(&mut self) {
        if !self.misses_moves {
            self.gpu.forget_rays();
        }
    }

    fn gather(&mut self, level: usize, enough: f32) -> Result<(), String> {
        self.levels = self.levels.checked_sub(1).ok_or("it is lost")?;
        self.gpu.gather(level, enough)
    }

    fn received(&self, functions: Range<usize>) -> Result<Vec<Mat3A>, String> {
        self.gpu.received(functions)
    }
}

/// The lit functions of a room.
struct Lit {
    bases: ObjectBases,
    direct: Vec<Vec3>,
    reflectance: Vec<Vec3>,
    emitted: Vec<Vec3>,
}

impl Lit {
    fn new(bases: ObjectBases) -> Self {
        let light = |p: &Surfel| Vec3::new(1.0, 0.5, 1.0) * (0.5 + 0.5 * p.position.y).powi(2) * (1.5 + p.normal.x);
        let shines = |function: usize| bases.owners()[function].object == 1 && bases.points()[function].normal.y > 0.5;
        Self {
            direct: bases.points().iter().map(light).collect(),
            reflectance: vec![Vec3::new(0.7, 0.5, 0.3); bases.len()],
            emitted: (0..bases.len()).map(|function| Vec3::splat(f32::from(u8::from(shines(function))))).collect(),
            bases,
        }
    }

    fn solver(&self, threshold: f32, device: Option<Faulty>) -> Radiosity {
        let settings = RadiositySettings { rays: 128, bounces: 3, least: 0.0, threshold, ..Default::default() };
        let mut solver = Radiosity::new(self.bases.clone(), settings);
        solver.set_device(device.map(|device| Box::new(device) as Box<dyn TransportDevice>));
        solver
    }

    fn functions(&self) -> LitFunctions<'_> {
        LitFunctions {
            direct: &self.direct,
            reflectance: &self.reflectance,
            emitted: &self.emitted,
            sky: Some(&|d| d.abs()),
        }
    }

    fn solved(&self, solver: &mut Radiosity, stage: &Stage, receivers: usize) -> RadiosityLight {
        let (surface, lit) = (stage.surface(), self.functions());
        let mut light = solver.begin(&surface, &lit);
        while solver.advance(&surface, &lit, &mut light, receivers) != RadiosityStep::Last {}
        light
    }
}

/// Of how many functions the light differs by more than a ten-thousandth of the mean, and by how many gathers all differ.
fn apart(found: &RadiosityLight, expected: &RadiosityLight) -> [usize; 2] {
    let mean = expected.total.iter().map(|light| length(*light)).sum::<f32>() / expected.total.len() as f32;
    let is_apart = |(a, b): &(&Mat3A, &Mat3A)| !(length(**a - **b) < 1e-4 * mean);
    let count = found.total.iter().zip(&expected.total).filter(is_apart).count();
    [count, found.gathers.abs_diff(expected.gathers) as usize]
}

#[test]
fn solutions_on_the_gpu_are_those_of_the_cores_before_and_after_a_move() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let (stage, moved) = (Stage::new(Vec3::ZERO), Stage::new(Vec3::new(-0.5, 0.0, -0.3)));
    let lit = Lit::new(stage.bases([90, 470, 2900]));
    let faulty = |misses_moves: bool, levels: usize| {
        let cores = lit.solver(0.1, None);
        let gpu = GpuRadiosity::new(&device, &lit.bases, cores.directions(), 300_000).unwrap();
        lit.solver(0.1, Some(Faulty { gpu, misses_moves, levels }))
    };
    let after = |solver: &mut Radiosity| {
        solver.follow(&moved.surface(), &BTreeMap::from([(1, moved.block())]), &[stage.block()]);
        lit.solved(solver, &moved, 100)
    };
    let (mut cores, mut gpu) = (lit.solver(0.1, None), faulty(false, usize::MAX));
    let expected = lit.solved(&mut cores, &stage, usize::MAX);
    let found = lit.solved(&mut gpu, &stage, usize::MAX);
    // Splits at the threshold fall to either side, and so do the functions below them.
    let few = |[functions, gathers]: [usize; 2]| {
        functions * 100 < expected.total.len() && gathers * 500 < expected.gathers as usize
    };
    println!("as baked: {:?} of {} {}", apart(&found, &expected), expected.total.len(), expected.gathers);
    assert!(few(apart(&found, &expected)), "{:?}", apart(&found, &expected));
    assert!(lit.solved(&mut gpu, &stage, 100).total == found.total, "rays are kept");
    assert!(lit.solved(&mut faulty(false, usize::MAX), &stage, 50).total == found.total, "in parts");
    assert!(expected.gathers < 4 * expected.total.len() as u64, "not all gather");
    let of_all = lit.solved(&mut lit.solver(0.0, None), &stage, usize::MAX);
    assert!(!few(apart(&found, &of_all)), "negative control: all that differ split");

    let (there, on_gpu) = (after(&mut cores), after(&mut gpu));
    println!("moved: {:?} of {} {}", apart(&on_gpu, &there), there.total.len(), there.gathers);
    assert!(few(apart(&on_gpu, &there)), "{:?}", apart(&on_gpu, &there));
    assert!(!few(apart(&on_gpu, &found)), "negative control: the light before the move");
    let mut unmoved = faulty(true, usize::MAX);
    lit.solved(&mut unmoved, &stage, usize::MAX);
    assert!(!few(apart(&after(&mut unmoved), &there)), "negative control: the device keeps rays that the move changed");
    assert!(gpu.has_device());
    for levels in [0, 2, 5] {
        let mut failing = faulty(false, levels);
        let light = lit.solved(&mut failing, &stage, 100);
        assert!(few(apart(&light, &expected)) && !failing.has_device(), "the cores go on after {levels}");
    }
}

#[test]
fn two_solutions_in_turns_are_those_one_after_the_other() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let stage = Stage::new(Vec3::ZERO);
    let [bright, mut dim] = [(); 2].map(|()| Lit::new(stage.bases([30, 90, 300])));
    dim.reflectance.iter_mut().for_each(|reflectance| *reflectance *= 0.5);
    let mut solver = bright.solver(0.1, None);
    let gpu = GpuRadiosity::new(&device, &bright.bases, solver.directions(), 1 << 20).unwrap();
    solver.set_device(Some(Box::new(gpu)));
    let expected = [&bright, &dim].map(|lit| lit.solved(&mut solver, &stage, 50).total);
    assert!(expected[0] != expected[1], "negative control");
    let moved = BTreeMap::from([(1, stage.block())]);
    solver.follow(&stage.surface(), &moved, &[]);
    let mut lights = [&bright, &dim].map(|lit| (lit, solver.begin(&stage.surface(), &lit.functions()), false));
    while lights.iter().any(|(.., is_done)| !is_done) {
        for (lit, light, is_done) in lights.iter_mut().filter(|(.., is_done)| !is_done) {
            *is_done = solver.advance(&stage.surface(), &lit.functions(), light, 20) == RadiosityStep::Last;
        }
    }
    assert!(lights.map(|(_, light, _)| light.total) == expected);
}
