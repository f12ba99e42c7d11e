//! Kernels of implicit visibility against their twins on the cores.

use super::{
    forest::{GpuForest, Look, packed_discs},
    *,
};
use crate::{
    Baked, Renderer,
    appearance::Appearance,
    device::{
        Compute, GlossRequest, Kernel, ModelSet, Room, SharedDevice, is_emulated,
        layout::{Disc, Reflected},
        readback::read_range,
        test_adapter::{on_adapter, shared_device},
    },
    light::{
        bounce::LitPoints,
        implicit::{
            PoseRig, PosedLight, PosedLighting,
            detail::ImplicitDetail,
            gloss::{Gloss, ReflectedLight, SeenLeaves, sent_by},
            seen::sight,
            tests::{blocked, posed, sky},
        },
    },
    test_scenes::{Edited, glossy, point_light, white},
};
use bytemuck::{Pod, bytes_of};
use glam::{Mat3, Vec3, Vec3A, Vec4};
use lapidary_core::{
    dataset::Dataset,
    implicit::{BinLayout, Bins, Drag, EMPTY, LeafLight, Lighting, forest::nodes::Block, node_of},
    material::BrdfModel,
    scene::{
        Mesh,
        pose::{Pose, Poses},
    },
    sphere::octahedron,
    surfel::Surfel,
    test_scenes::{cuboid, quad, room, scene_of},
    texture::{Procedural, TextureSlot},
};
use std::{collections::BTreeSet, sync::MutexGuard, time::Instant};

mod vertices;

const LAYOUT: BinLayout = BinLayout::FINEST.turned(0.3);

/// A room of 2 m without a ceiling, with a turned box, a sheet seen from both sides, and an object without triangles in it.
struct Case {
    mesh: Mesh,
    forest: SurfelForest,
}

impl Case {
    fn new(surfels: u32) -> Self {
        let turn = Mat3::from_rotation_y(0.5) * Mat3::from_rotation_x(0.3);
        let p = |x: f32, y: f32| Vec3::new(x, y, 0.6);
        let cube = cuboid(Vec3::new(0.3, -0.5, 0.0), Vec3::splat(0.3));
        let parts = [
            room(Vec3::ZERO, Vec3::ONE)[2..].to_vec(),
            cube.into_iter().map(|triangle| triangle.map(|v| turn * v)).collect(),
            quad(p(-0.5, 0.0), p(0.1, 0.1), p(0.0, 0.5), p(-0.5, 0.5)).to_vec(),
        ];
        let mut mesh = scene_of(&parts.concat()).mesh;
        mesh.triangle_object = [vec![0; 10], vec![1; 12], vec![3; 2]].concat();
        let two_sided: Vec<bool> = mesh.triangle_object.iter().map(|&object| object == 3).collect();
        Self { forest: SurfelForest::new(&mesh, &two_sided, surfels), mesh }
    }

    /// Vertices with the box elsewhere.
    fn posed(&self, by: Vec3) -> Vec<Vec3> {
        let mut positions = self.mesh.positions.clone();
        let of_box = |t: &usize| self.mesh.triangle_object[*t] == 1;
        let mut moved: Vec<u32> =
            (0..self.mesh.triangles.len()).filter(of_box).flat_map(|t| self.mesh.triangles[t]).collect();
        moved.sort_unstable();
        moved.dedup();
        let turn = Mat3::from_rotation_z(0.7);
        moved.into_iter().for_each(|v| positions[v as usize] = turn * positions[v as usize] * 1.1 + by);
        positions
    }
}

/// On an adapter, which others do not use meanwhile; `None`, said aloud, where there is none and none is required.
fn adapter() -> Option<(MutexGuard<'static, ()>, GpuImplicit)> {
    on_adapter(|| GpuImplicit::on(&shared_device()?))
}

fn nodes_of(forest: &GpuForest) -> (Vec<Disc>, Vec<Block>) {
    let (gpu, b) = (&forest.on.gpu, &forest.buffers);
    let blocks = read_range(gpu, &b.blocks, 0..forest.nodes as usize / 4).unwrap();
    (read_range(gpu, &b.discs, 0..forest.leaves as usize).unwrap(), blocks)
}

/// The keys of all leaves in place of views.
fn keys_of(forest: &GpuForest, objects: &dyn Fn(u32) -> bool) -> Vec<u32> {
    let look = Look { leaves: 0..forest.leaves, objects, kept: None, closes: false };
    forest.look(&look, &forest.buffers.views).unwrap();
    read_range(&forest.on.gpu, &forest.buffers.views, 0..forest.leaves as usize * forest.layout.cells.len()).unwrap()
}

fn keys(bins: &Bins) -> Vec<u32> {
    bins.leaves().flat_map(|leaf| bins.of_leaf(leaf)).copied().collect()
}

fn differing<T: PartialEq>(a: &[T], b: &[T]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Keys or nodes of cells. On an emulated adapter they are the same to the bit. Others may fuse products and sums, and divide to 2.5
/// units of the last place, as WGSL allows: there nodes differ in at most a thousandth of the cells.
fn same(what: &str, adapter: &GpuImplicit, found: &[u32], expected: &[u32]) {
    let nodes = |keys: &[u32]| -> Vec<u32> { keys.iter().map(|&key| node_of(key)).collect() };
    let (bits, differ) = (differing(found, expected), differing(&nodes(found), &nodes(expected)));
    println!("{what}: {differ} nodes and {bits} keys of {} differ", found.len());
    assert!(differ * 1000 <= found.len() && (bits == 0 || !is_emulated(&adapter.gpu.info)), "{what}");
}

/// The same for what holds numbers: elsewhere they differ by rounding.
fn same_numbers<T: Pod + PartialEq>(adapter: &GpuImplicit, found: &[T], expected: &[T]) {
    assert!(differing(found, expected) == 0 || !is_emulated(&adapter.gpu.info));
    let numbers = |of: &T| -> Vec<f32> { bytemuck::cast_slice(bytes_of(of)).to_vec() };
    let apart = |(a, b): (&T, &T)| numbers(a).iter().zip(numbers(b)).all(|(a, b)| (a - b).abs() < 1e-3);
    assert!(found.iter().zip(expected).all(apart));
}

#[test]
fn discs_and_nodes_have_the_bits_of_the_twin() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let mut case = Case::new(1024);
    let mut gpu = adapter.forest(&case.forest, case.mesh.positions.len(), LAYOUT).unwrap();
    let baked = nodes_of(&gpu);
    for by in [Vec3::ZERO, Vec3::new(-0.4, 0.2, 0.1)] {
        let posed = case.posed(by);
        gpu.update(&posed).unwrap();
        case.forest.update(&posed, &|_| true);
        let (discs, blocks) = nodes_of(&gpu);
        same_numbers(&adapter, &discs, &packed_discs(case.forest.discs()));
        same_numbers(&adapter, &blocks, case.forest.discs().blocks());
        assert!(
            differing(&discs, &baked.0) > 50 && differing(&blocks, &baked.1) > 10,
            "negative control: the baked pose"
        );
    }
    gpu.update(&case.mesh.positions).unwrap();
    let back = nodes_of(&gpu);
    same_numbers(&adapter, &back.0, &baked.0);
    same_numbers(&adapter, &back.1, &baked.1);
}

#[test]
fn keys_are_those_of_the_twin() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let case = Case::new(1024);
    let discs = case.forest.discs();
    let gpu = adapter.forest(&case.forest, case.mesh.positions.len(), LAYOUT).unwrap();
    let bins = keys(&Bins::walk(discs, LAYOUT, &|_| true));
    same("whole", &adapter, &keys_of(&gpu, &|_| true), &bins);
    let layer = |object: u32| object == 1 || object == 3;
    same("layer", &adapter, &keys_of(&gpu, &layer), &keys(&Bins::walk(discs, LAYOUT, &layer)));
    let apart = |found: &[u32]| differing(found, &bins) * 50 > bins.len();
    assert!(apart(&keys(&Bins::walk(discs, LAYOUT.turned(0.4), &|_| true))), "negative control: another turn");
    assert!(apart(&keys(&Bins::walk(discs, LAYOUT, &layer))), "negative control: another layer");
    let unrefined = gpu.with_limit(100.0);
    assert!(apart(&keys_of(&unrefined, &|_| true)), "negative control: without refinement");
}

#[test]
fn fewer_bins_are_those_of_the_twin() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let case = Case::new(512);
    let (discs, layout) = (case.forest.discs(), BinLayout::new(14).turned(0.3));
    let mut gpu = adapter.forest(&case.forest, case.mesh.positions.len(), layout).unwrap();
    let bins = Bins::walk(discs, layout, &|_| true);
    same("fewer bins", &adapter, &keys_of(&gpu, &|_| true), &keys(&bins));
    gpu.walk().unwrap();
    let (found, expected) = (gpu.views(0..gpu.leaves).unwrap(), bins.views());
    let nodes: [Vec<u32>; 2] =
        [&found, &expected].map(|views| (0..gpu.leaves).flat_map(|leaf| views.of_leaf(leaf)).copied().collect());
    same("fewer bins, closed", &adapter, &nodes[0], &nodes[1]);
    let other = keys(&Bins::walk(discs, layout.turned(0.4), &|_| true));
    assert!(differing(&nodes[0], &other) * 50 > other.len(), "negative control: another turn");
}

#[test]
fn views_of_poses_and_of_a_drag_are_those_of_the_twin() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let mut case = Case::new(512);
    let mut gpu = adapter.forest(&case.forest, case.mesh.positions.len(), LAYOUT).unwrap();
    let drag = Drag::begin(case.forest.discs(), LAYOUT, [1].into());
    let mut last = Vec::new();
    for step in 0..2 {
        let posed = case.posed(Vec3::new(-0.2 * step as f32, 0.1, 0.1));
        case.forest.update(&posed, &|object| object == 1);
        gpu.update(&posed).unwrap();
        gpu.walk_dragged(drag.objects()).unwrap();
        let leaves = 0..gpu.leaves;
        let nodes = |views: &lapidary_core::implicit::Views| -> Vec<u32> {
            leaves.clone().flat_map(|leaf| views.of_leaf(leaf)).copied().collect()
        };
        let dragged = nodes(&gpu.views(leaves.clone()).unwrap());
        same("drag", &adapter, &dragged, &nodes(&drag.frame(case.forest.discs())));
        gpu.walk().unwrap();
        let whole = nodes(&gpu.views(leaves.clone()).unwrap());
        assert_eq!(dragged, whole, "a drag has the bits of a whole walk");
        assert!(step == 0 || differing(&dragged, &last) > 1000, "negative control: the last pose");
        last = dragged;
    }
    let own = case.forest.discs().leaves_of(1);
    let some = gpu.views(own.clone()).unwrap();
    assert_eq!(some.of_leaf(own.start), &last[own.start as usize * LAYOUT.cells.len()..][..LAYOUT.cells.len()]);
    assert_eq!(gpu.views(3..3).unwrap().leaves(), 0);
}

/// Most that a value differs from another; infinite for what is not a number.
fn farthest(found: &[Vec3], expected: &[Vec3]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let apart = |(a, b): (&Vec3, &Vec3)| if a.is_finite() { (*a - *b).abs().max_element() } else { f32::INFINITY };
    found.iter().zip(expected).map(apart).fold(0.0, f32::max)
}

/// The same in means of the other values.
fn worst(found: &[Vec3], expected: &[Vec3]) -> f32 {
    let mean = expected.iter().map(|e| e.element_sum() / 3.0).sum::<f32>() / expected.len() as f32;
    farthest(found, expected) / mean
}

#[test]
fn light_is_that_of_the_twin() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let case = Case::new(1024);
    let discs = case.forest.discs();
    let mut gpu = adapter.forest(&case.forest, case.mesh.positions.len(), LAYOUT).unwrap();
    gpu.walk().unwrap();
    let views = gpu.views(0..gpu.leaves).unwrap();
    let values = |seed: u64, most: f32| -> Vec<Vec3> {
        let mut rng = fastrand::Rng::with_seed(seed);
        (0..discs.discs().len()).map(|_| Vec3::new(rng.f32(), rng.f32(), rng.f32()) * most).collect()
    };
    let (reflectance, emitted, received) = (values(1, 0.9), values(2, 0.2), values(3, 2.0));
    let sky = |direction: Vec3| octahedron::direction_of(octahedron::cell_of(direction)) * 20.0 + 20.0;
    let lighting = Lighting { reflectance: &reflectance, emitted: &emitted, received: &received, sky: &sky };
    let twin = LeafLight::new(discs, &views, &lighting, 2);
    let light = gpu.light(&lighting, 2).unwrap();
    let twin_of_sky = views.irradiance_of_sky(discs, &sky);
    let errors =
        [worst(&light.of_sky, &twin_of_sky), worst(&light.direct, &twin.direct), worst(&light.bounced, &twin.bounced)];
    println!("irradiance of sky, emission and bounces differs by {errors:?}");
    assert!(errors.iter().all(|&error| error < 1e-5), "{errors:?}");
    let one = gpu.light(&lighting, 1).unwrap();
    assert!(worst(&one.bounced, &twin.bounced) > 0.1, "negative control: one bounce less");
    let turned = |direction: Vec3| sky(-direction);
    let of_turned = gpu.light(&Lighting { sky: &turned, ..lighting }, 0).unwrap();
    assert!(worst(&of_turned.of_sky, &twin_of_sky) > 0.1, "negative control: another sky");
}

/// Gloss of a scene whose parts all have one material, and its leaves with what they see.
struct GlossyCase {
    baked: Baked,
    forest: SurfelForest,
    gloss: Gloss,
}

impl GlossyCase {
    /// A floor with a block, of which the base color varies.
    fn new(model: BrdfModel) -> Self {
        let mut dataset = blocked(glossy(0.5), 4);
        let material = &mut dataset.scene.materials[0];
        material.model = model;
        let checks = Procedural { low: Vec3::new(0.2, 0.9, 0.4), ..Default::default() };
        let varies = TextureSlot { procedural: Some(checks), ..Default::default() };
        let color = material.own_parameters().iter().find(|p| p.is_color()).expect("all models have a color");
        material.maps.set(color.name, Some(varies));
        let baked = Baked::from(dataset);
        let forest = SurfelForest::new(&baked.dataset.scene.mesh, &baked.dataset.two_sided, 256);
        let leaves = LitPoints::new(&baked, forest.surfels().collect(), 1);
        let gloss = Gloss::new(&Appearance::of(&baked.dataset.scene), &leaves);
        Self { baked, forest, gloss }
    }
}

/// The kernel for a scene, after it is compiled.
fn compiled(device: &SharedDevice, models: &ModelSet) -> Arc<Kernel> {
    let start = Instant::now();
    loop {
        match device.gloss_kernel(models) {
            Some(kernel) => return kernel,
            None => assert!(start.elapsed() < Duration::from_secs(120), "it takes for ever"),
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// What a table's leaves of some numbers reflect.
fn reflected(forest: &GpuForest, table: &GlossTable, numbers: &[u32]) -> Vec<Option<ReflectedLight>> {
    let all: Vec<Reflected> = read_range(&forest.on.gpu, &table.reflected, 0..forest.leaves as usize).unwrap();
    let color = |of: [f32; 4]| Vec4::from(of).truncate();
    let of_leaf = |&number: &u32| {
        let Reflected { sky, faces_eye, leaves, irradiance } = all[number as usize];
        let light = ReflectedLight { sky: sky.into(), leaves: color(leaves), irradiance: color(irradiance) };
        (faces_eye != 0).then_some(light)
    };
    numbers.iter().map(of_leaf).collect()
}

#[test]
fn gloss_is_that_of_the_twin_for_all_models() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let adapter = GpuImplicit::on(&device).unwrap();
    for model in BrdfModel::ALL.iter().copied().filter(|model| !model.has_file()) {
        let case = GlossyCase::new(model);
        let (mesh, discs) = (&case.baked.dataset.scene.mesh, case.forest.discs());
        if case.gloss.is_empty() {
            assert!([BrdfModel::Lambert, BrdfModel::OrenNayar].contains(&model));
            continue;
        }
        let mut gpu = adapter.forest(&case.forest, mesh.positions.len(), LAYOUT).unwrap();
        gpu.walk().unwrap();
        let views = gpu.views(0..gpu.leaves).unwrap();
        let surfels: Vec<Surfel> = case.forest.surfels().collect();
        let kernel = compiled(&device, &case.gloss.models().unwrap());
        let (leaves, values) = case.gloss.packed(mesh, &surfels);
        let numbers: Vec<u32> = leaves.iter().map(|leaf| leaf.leaf).collect();
        assert!(values.len() > 10 * model.own_parameters().len(), "leaves have their own values");
        let table = gpu.gloss_table(kernel, leaves, &values).unwrap();
        let sky = |direction: Vec3| octahedron::direction_of(octahedron::cell_of(direction)) * 20.0 + 20.0;
        let leaves: Vec<Vec3> = (0..gpu.leaves).map(|leaf| Vec3::splat((leaf % 7) as f32 / 7.0)).collect();
        let lighting = Lighting { reflectance: &leaves, emitted: &leaves, received: &leaves, sky: &sky };
        let sent = sent_by(discs, &lighting, &gpu.light(&lighting, 1).unwrap());
        let both = |eye: Vec3, sent: Option<&[Vec3A]>| {
            let seen = SeenLeaves { forest: discs, mesh, surfels: &surfels, eye, sent, sky: &sky };
            let asked = GlossRequest { frames: &case.gloss.frames(mesh, &surfels), eye, has_sent: sent.is_some() };
            gpu.gloss(&table, &asked).unwrap();
            [reflected(&gpu, &table, &numbers), case.gloss.reflected(&seen, &views)]
        };
        let colors = |all: &[Option<ReflectedLight>]| -> Vec<Vec3> {
            all.iter().flat_map(|of| of.map_or([Vec3::ZERO; 3], |of| [of.sky, of.leaves, of.irradiance])).collect()
        };
        let [found, expected] = both(Vec3::new(1.0, 1.5, 2.0), Some(&sent));
        let faces = |all: &[Option<ReflectedLight>]| all.iter().map(Option::is_some).collect::<Vec<_>>();
        assert_eq!(faces(&found), faces(&expected));
        assert!(faces(&found).contains(&true) && faces(&found).contains(&false));
        let differ = worst(&colors(&found), &colors(&expected));
        println!("gloss of {model:?} differs by {differ}");
        assert!(differ < 1e-4, "{model:?}: {differ}");
        let [elsewhere, _] = both(Vec3::new(-1.0, 0.5, 2.0), Some(&sent));
        assert!(worst(&colors(&elsewhere), &colors(&expected)) > 0.1, "negative control: another eye");
        let [of_sky, twin_of_sky] = both(Vec3::new(1.0, 1.5, 2.0), None);
        assert!(worst(&colors(&of_sky), &colors(&twin_of_sky)) < 1e-4);
        assert!(worst(&colors(&of_sky), &colors(&expected)) > 0.1, "negative control: no light of nodes");
    }
}

#[test]
fn leaves_whose_brdf_is_in_a_file_are_left_to_the_cores() {
    let mut dataset = blocked(glossy(0.5), 4);
    let models = |dataset: &Dataset| {
        let baked = Baked::from(dataset.clone());
        let forest = SurfelForest::new(&baked.dataset.scene.mesh, &baked.dataset.two_sided, 64);
        let leaves = LitPoints::new(&baked, forest.surfels().collect(), 1);
        Gloss::new(&Appearance::of(&baked.dataset.scene), &leaves).models()
    };
    assert!(models(&dataset).is_some());
    dataset.scene.materials[0].model = BrdfModel::Merl;
    assert!(models(&dataset).is_none());
}

#[test]
fn an_object_that_has_shrunk_to_a_point_is_nothing_as_for_the_twin() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let mut case = Case::new(512);
    let mut gpu = adapter.forest(&case.forest, case.mesh.positions.len(), LAYOUT).unwrap();
    let mut light = |positions: &[Vec3]| {
        case.forest.update(positions, &|_| true);
        gpu.update(positions).unwrap();
        gpu.walk().unwrap();
        let bright = vec![Vec3::splat(0.5); gpu.leaves as usize];
        let lighting = Lighting { reflectance: &bright, emitted: &bright, received: &bright, sky: &|_| Vec3::ZERO };
        let views = gpu.views(0..gpu.leaves).unwrap();
        let twin = LeafLight::new(case.forest.discs(), &views, &lighting, 2).bounced;
        (gpu.light(&lighting, 2).unwrap().bounced, twin)
    };
    let (_, whole) = light(&case.mesh.positions);
    let mut shrunk = case.mesh.positions.clone();
    let of_box = case.mesh.triangles.iter().zip(&case.mesh.triangle_object).filter(|(_, object)| **object == 1);
    of_box.for_each(|(corners, _)| corners.iter().for_each(|&v| shrunk[v as usize] = Vec3::new(0.3, -0.5, 0.0)));
    let (found, twin) = light(&shrunk);
    assert!(worst(&found, &twin) < 1e-5, "{}", worst(&found, &twin));
    assert!(worst(&found, &whole) > 0.1, "negative control: the box as it was");
}

#[test]
fn walks_of_an_open_scene_see_the_sky_as_the_twin_does() {
    let Some((_one_at_a_time, adapter)) = adapter() else { return };
    let sees_something = |parts: &[Vec<[Vec3; 3]>]| {
        let mesh = scene_of(&parts.concat()).mesh;
        let forest = SurfelForest::new(&mesh, &vec![false; mesh.triangles.len()], 256);
        let mut gpu = adapter.forest(&forest, mesh.positions.len(), BinLayout::FINEST).unwrap();
        gpu.walk().unwrap();
        let views = gpu.views(0..256).unwrap();
        assert!(views == Bins::walk(forest.discs(), BinLayout::FINEST, &|_| true).views());
        (0..256).any(|leaf| views.of_leaf(leaf).iter().any(|&node| node != EMPTY))
    };
    let cube = |x: f32| cuboid(Vec3::X * x, Vec3::ONE).to_vec();
    assert!(!sees_something(&[cube(0.0)]), "a convex thing sees itself nowhere");
    assert!(sees_something(&[cube(0.0), cube(3.0)]), "negative control: another one");
}

/// Compiles what glossy leaves of a scene need, so that the adapter takes them at once.
fn compile_gloss(device: &SharedDevice, baked: &Baked) {
    compiled(device, &ModelSet::of(&Appearance::of(&baked.dataset.scene)).without_maps());
}

/// All values of growth, uncovered light and bounce.
fn values_of(light: &PosedLight) -> [Vec<Vec3>; 3] {
    [&light.growth, &light.uncovered, &light.bounce].map(|sides| [&sides.front[..], &sides.back].concat())
}

/// What a rig shows of some poses, one after another: its cuts, and the light.
fn shown(compute: &Compute, baked: &Baked, poses: &[Poses]) -> Vec<(Vec<Vec<u16>>, PosedLight)> {
    let mut rig = Edited::new(baked, PoseRig::new(baked, compute, ImplicitDetail::OF_A_DRAG));
    rig.set_environment(Some(Renderer::new(baked.clone()).lighting(&sky(), 64)));
    let show = |poses| {
        rig.situation.eye = Vec3::new(0.0, 1.5, 3.5);
        rig.set_poses(baked, poses);
        let scene = rig.situation.scene.clone();
        let (scene, made) = rig.with_cuts(&scene);
        let cuts = match (compute, made) {
            (Compute::Device(device), Some(made)) => scene.dataset.cuts.with(made.read(&device.gpu).unwrap()),
            (Compute::Cores, None) => scene.dataset.cuts.clone(),
            _ => panic!("cuts are made where visibility is"),
        };
        let height = scene.dataset.tree.height();
        let cuts = (0..cuts.len() as u32).map(|vertex| cuts.cut(height, vertex).to_vec());
        let light = rig.light(2, true).known().clone();
        assert_eq!(
            rig.lights_vertices(),
            matches!(compute, Compute::Device(_)),
            "vertices are lit where visibility is"
        );
        (cuts.collect(), light)
    };
    poses.iter().map(show).collect()
}

#[test]
fn a_kernel_that_comes_later_does_not_mix_its_light_with_that_of_the_cores() {
    // A device of its own, which has compiled nothing.
    let Some((_one_at_a_time, device)) = on_adapter(|| SharedDevice::new(Room::Defaults)) else { return };
    let mut dataset = blocked(glossy(0.5), 8);
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    let baked = Baked::from(dataset);
    let compute = Compute::Device(device.clone());
    let mut rig = Edited::new(&baked, PoseRig::new(&baked, &compute, ImplicitDetail::OF_A_DRAG));
    rig.set_environment(Some(Renderer::new(baked.clone()).lighting(&sky(), 64)));
    rig.situation.eye = Vec3::new(0.0, 1.5, 3.5);
    let growth_at = |rig: &mut Edited<PoseRig>, poses: &Poses| {
        rig.set_poses(&baked, poses);
        rig.light(2, true).known().growth.clone()
    };
    let moved = posed(Pose { translate: Vec3::X * 0.2, ..Pose::AS_BAKED });
    let by_cores = growth_at(&mut rig, &moved);
    compile_gloss(&device, &baked);
    let none = growth_at(&mut rig, &Poses::default());
    assert!(rig.lights_vertices());
    assert!([&none.front, &none.back].into_iter().flatten().all(|growth| *growth == Vec3::ZERO), "as it was baked");
    let by_adapter = growth_at(&mut rig, &moved);
    assert!(by_cores.front.iter().any(|growth| *growth != Vec3::ZERO), "negative control: it moved");
    assert!(by_adapter != by_cores, "negative control: their last digits differ");
}

#[test]
fn a_rig_lights_poses_on_the_adapter_as_on_the_cores() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let mut glossy = blocked(glossy(0.5), 8);
    glossy.scene.materials[0].model = BrdfModel::Ggx;
    // Coarse cuts have halves that are stored as equal nodes, and joined.
    let mut coarse = glossy.clone();
    coarse.settings.criterion.sigma = 1.0;
    let baked = Baked::from(glossy);
    let at = |x: f32| posed(Pose { translate: Vec3::X * x, ..Pose::AS_BAKED });
    let poses = [at(0.2), at(0.7)];
    // So that the adapter is asked for gloss from the first pose on.
    compile_gloss(&device, &baked);
    let computes = [Compute::Device(device), Compute::Cores];
    let [found, expected] = [&computes[0], &computes[1]].map(|compute| shown(compute, &baked, &poses));
    for ((cuts, light), (of_cores, of_twin)) in found.iter().zip(&expected) {
        assert!(cuts == of_cores);
        let differ = values_of(light).iter().zip(values_of(of_twin)).map(|(a, b)| farthest(a, &b)).fold(0.0, f32::max);
        println!("light of a pose differs by {differ}");
        assert!(differ < 1e-4);
    }
    let coarse = Baked::from(coarse);
    let [found, of_cores] =
        [&computes[0], &computes[1]].map(|compute| shown(compute, &coarse, &poses[..1]).remove(0).0);
    assert!(found == of_cores && found != expected[0].0, "coarse cuts");
    let growth = |pose: usize| &expected[pose].1.growth.front;
    assert!(farthest(growth(0), growth(1)) > 0.1 && expected[0].0 != expected[1].0, "negative control: another pose");
}

#[test]
fn the_cores_go_on_where_an_adapter_fails() {
    let Some((_one_at_a_time, device)) = on_adapter(|| SharedDevice::new(Room::Defaults)) else { return };
    let case = Case::new(256);
    let discs = case.forest.discs();
    let mut sight = sight(&Compute::Device(device.clone()), &case.forest, case.mesh.positions.len(), LAYOUT);
    sight.look(&case.forest, &case.mesh.positions, &BTreeSet::new());
    let seen = sight.views(discs, 0..256).into_owned();
    device.gpu.device.destroy();
    let adapter = GpuImplicit::on(&device).unwrap();
    assert!(adapter.forest(&case.forest, 8, LAYOUT).is_err(), "it has failed");
    assert!(*sight.views(discs, 0..256) == seen, "by the cores");
    sight.look(&case.forest, &case.mesh.positions, &[1].into());
    assert!(*sight.views(discs, 0..256) == seen);
    let gray = vec![Vec3::splat(0.5); 256];
    let lighting = Lighting { reflectance: &gray, emitted: &gray, received: &gray, sky: &|_| Vec3::ONE };
    let (bounced, expected) =
        (sight.light(discs, &lighting, 1).bounced, LeafLight::new(discs, &seen, &lighting, 1).bounced);
    assert!(bounced.iter().zip(&expected).all(|(a, b)| a.distance(*b) < 1e-6), "but for the order of sums");
    assert!(bounced.iter().all(|light| light.x > 0.1));
}
