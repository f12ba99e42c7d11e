//! Known answers for the CPU renderer and both references: furnace, a lone light's shadow, orientation, all leaves.

use super::*;
use crate::{Background, BrdfSampling, PathSettings, Quiet, View, measure::compare::compare};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    camera::Camera,
    cut::{
        CutCriterion, CutSelector,
        packed::{PackedCuts, pack_node},
    },
    dataset::{BakeReport, BakeSettings},
    environment::Environment,
    image::Image,
    light_tree::{LightTree, TreeKind},
    material::{BrdfModel, BrdfParameters, Material},
    ray::DirectionSet,
    scene::{Mesh, Object, Scene},
};

pub(crate) const LIGHTS: usize = 4096;

/// A floor of `cells` x `cells` squares over [-2, 2]², with a horizontal blocker of half-width 0.5 at height 1 if asked.
pub(crate) fn mesh(cells: u32, blocker: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let mut grid = |cells: u32, half: f32, y: f32, flip: bool| {
        let first = mesh.positions.len() as u32;
        for j in 0..=cells {
            for i in 0..=cells {
                let p = |k: u32| half * (2.0 * k as f32 / cells as f32 - 1.0);
                mesh.positions.push(Vec3::new(p(i), y, p(j)));
                mesh.normals.push(if flip { Vec3::NEG_Y } else { Vec3::Y });
                mesh.tangents.push(Vec4::new(1.0, 0.0, 0.0, 1.0));
                mesh.uvs.push(Vec2::new(p(i), p(j)));
            }
        }
        for j in 0..cells {
            for i in 0..cells {
                let v = |i: u32, j: u32| first + j * (cells + 1) + i;
                let (a, b, c, d) = (v(i, j), v(i, j + 1), v(i + 1, j + 1), v(i + 1, j));
                mesh.triangles.extend(if flip { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
            }
        }
    };
    grid(cells, 2.0, 0.0, false);
    if blocker {
        grid(1, 0.5, 1.0, false);
        grid(1, 0.5, 0.999, true);
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh.triangle_object = vec![0; mesh.triangles.len()];
    mesh
}

/// A dataset whose cuts are exact at every vertex (sigma 0).
pub(crate) fn dataset(mesh: Mesh, parameters: BrdfParameters) -> Dataset {
    dataset_of_sigma(mesh, parameters, 0.0)
}

/// Sets the lights that a vertex sees, as the cuts of these datasets have it.
pub(crate) fn trace_vertex(
    mesh: &Mesh,
    intersector: &Intersector,
    lights: &DirectionSet,
    vertex: u32,
    seen: &mut [u8],
) {
    let (p, n) = (mesh.positions[vertex as usize], mesh.normals[vertex as usize]);
    intersector.trace_batch(p + n * 1e-3, lights, |d| d.dot(n) > 0.0, seen);
}

pub(crate) fn dataset_of_sigma(mesh: Mesh, parameters: BrdfParameters, sigma: f32) -> Dataset {
    let tree = LightTree::geometric(LIGHTS).unwrap();
    let directions = DirectionSet::new(tree.leaf_directions());
    let intersector = Intersector::new(&mesh);
    let criterion = CutCriterion { sigma, ..Default::default() };
    let mut selector = CutSelector::new(tree.height(), criterion);
    let mut cuts = PackedCuts::default();
    for vertex in 0..mesh.positions.len() as u32 {
        let mut visible = vec![0; LIGHTS];
        trace_vertex(&mesh, &intersector, &directions, vertex, &mut visible);
        let mut cut = Vec::new();
        selector.select(&visible, &mut cut);
        let offset = cuts.push_cut(&cut);
        cuts.push_vertex(offset);
    }
    let settings = BakeSettings {
        lights: LIGHTS,
        tree: TreeKind::Geometric,
        beta: 1.0,
        criterion,
        pilot_clusters: 1,
        max_vertices: None,
        shots: Vec::new(),
        max_bytes: None,
        mode: Default::default(),
        indirect: Default::default(),
        meshless: Default::default(),
    };
    Dataset {
        indirect: None,
        meshless: None,
        two_sided: vec![false; mesh.triangles.len()],
        vertex_valid: vec![true; mesh.positions.len()],
        scene: Scene {
            mesh,
            materials: vec![Material { model: BrdfModel::Lambert, parameters, ..Default::default() }],
            objects: vec![Object { name: "test".into() }],
            ..Default::default()
        },
        tree,
        cuts,
        settings,
        scene_hash: String::new(),
        report: BakeReport::default(),
    }
}

pub(crate) fn white() -> BrdfParameters {
    BrdfParameters { base_color: Vec3::ONE, ..Default::default() }
}

pub(crate) fn glossy(roughness: f32) -> BrdfParameters {
    BrdfParameters { base_color: Vec3::ZERO, roughness, ..Default::default() }
}

pub(crate) fn illumination(size: [u32; 2], f: impl FnMut(u32, u32) -> Vec3) -> Illumination {
    let environment = Environment { name: "test".into(), map: Image::from_fn(size, f) };
    Illumination { environment: environment.into(), rotation: 0.0, intensity: 1.0 }
}

pub(crate) fn from_above(size: u32) -> View {
    // Inside the floor on all sides; a hair off the vertical fixes which way is up in the picture.
    let camera = Camera::look_at(Vec3::new(0.0, 6.0, 0.01), Vec3::ZERO, 30.0);
    View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [size, size]) }
}

pub(crate) fn from_the_side(size: u32) -> View {
    let camera = Camera::look_at(Vec3::new(0.0, 1.5, 3.5), Vec3::ZERO, 30.0);
    View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [size, size]) }
}

fn ggx(mut dataset: Dataset) -> Dataset {
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    dataset
}

pub(crate) fn rel_rmse(test: &Image, reference: &Image) -> f64 {
    compare(test, reference).unwrap().rel_rmse
}

#[test]
fn a_white_floor_in_a_white_furnace_is_white_for_all_three() {
    let dataset = dataset(mesh(4, false), white());
    let renderer = Renderer::new(dataset.clone());
    let (view, light) = (from_above(24), illumination([64, 32], |_, _| Vec3::ONE));
    let pictures = [
        renderer.render(&view, &light, 256, BrdfSampling::Refine).0,
        renderer.samples_reference(&view, &light, &Quiet),
        renderer.path_reference(&view, &light, &[], PathSettings::direct(64), &Quiet),
    ];
    for (i, picture) in pictures.iter().enumerate() {
        let mean = picture.pixels.iter().sum::<Vec3>() / picture.pixels.len() as f32;
        assert!((mean - 1.0).abs().max_element() < 5e-3, "picture {i}: {mean}");
        let worst = picture.pixels.iter().map(|p| (p.x - 1.0).abs()).fold(0.0, f32::max);
        assert!(i == 2 || worst < 0.02, "picture {i}: {worst}"); // the path reference has noise
    }
    let grey = illumination([64, 32], |_, _| Vec3::splat(0.98));
    let darker = renderer.render(&view, &grey, 256, BrdfSampling::Refine).0;
    assert!(darker.pixels.iter().all(|p| p.x < 0.99), "negative control: two percent less light is seen");
}

/// A lone bright texel casts the blocker's shadow where geometry says: shifted by height times the slope of the light.
#[test]
fn the_shadow_of_a_single_bright_texel_is_where_geometry_says() {
    let dataset = dataset(mesh(64, true), white());
    let renderer = Renderer::new(dataset.clone());
    let (width, height) = (256, 128);
    // Toward +X at 45 degrees: u = 1/4, v = 1/4.
    let light =
        illumination([width, height], |x, y| Vec3::splat(f32::from(u8::from((x, y) == (width / 4, height / 4)))));
    let view = from_above(96);
    let toward_light = lapidary_core::environment::texel_direction(width / 4, height / 4, [width, height]);
    let shift = toward_light / toward_light.y;
    let pictures = [
        ("cuts", renderer.render(&view, &light, 256, BrdfSampling::Refine).0),
        ("samples", renderer.samples_reference(&view, &light, &Quiet)),
        ("path", renderer.path_reference(&view, &light, &[], PathSettings::direct(128), &Quiet)),
    ];
    for (name, picture) in pictures {
        let lit = picture.pixels.iter().map(|p| p.x).filter(|&x| x > 0.0);
        let brightest = 1.2 * lit.clone().sum::<f32>() / lit.count() as f32;
        let value = |x: f32, z: f32| {
            // Where a floor point appears in the picture.
            let view_from_world = view.camera.world_from_view().transpose();
            let p = view_from_world * (Vec3::new(x, 0.0, z) - view.camera.eye);
            let tan = (0.5 * view.camera.fov_y).tan();
            let pixel = |v: f32| ((0.5 + 0.5 * v / (-p.z * tan)) * 96.0) as usize;
            picture.at(pixel(p.x), pixel(-p.y)).x / brightest
        };
        // The shadow of the square [-0.5, 0.5]² at height 1, with a margin for the width of texel and light sample.
        for (dx, dz) in [(0.0, 0.0), (0.35, 0.0), (-0.35, 0.35), (0.0, -0.35)] {
            assert!(value(dx - shift.x, dz - shift.z) < 0.1, "{name}: lit at {dx}, {dz} of the shadow's centre");
        }
        for (dx, dz) in [(0.68, 0.0), (0.0, 0.68), (0.0, -0.68)] {
            assert!(value(dx - shift.x, dz - shift.z) > 0.6, "{name}: dark at {dx}, {dz} of the shadow's centre");
        }
        assert!(value(shift.x, shift.z) > 0.6, "{name}: negative control: there is no shadow on the other side");
    }
}

/// Rotating the map by 90 degrees and looking from 90 degrees further gives the same picture.
#[test]
fn rotation_turns_the_light_and_not_the_camera() {
    let dataset = ggx(dataset(mesh(16, true), glossy(0.6)));
    let renderer = Renderer::new(dataset.clone());
    let mut light = illumination([64, 32], |x, y| Vec3::splat(if x < 16 { 4.0 } else { 0.1 } + y as f32 * 0.01));
    let view = |angle: f32| {
        let eye = glam::Quat::from_rotation_y(angle) * Vec3::new(0.0, 1.5, 3.5);
        View { background: Background::Flat(Vec3::ZERO), ..View::new(Camera::look_at(eye, Vec3::ZERO, 30.0), [32, 32]) }
    };
    let quarter = std::f32::consts::FRAC_PI_2;
    let straight = renderer.path_reference(&view(0.0), &light, &[], PathSettings::direct(128), &Quiet);
    let not_turned = renderer.render(&view(quarter), &light, 512, BrdfSampling::Refine).0;
    light.rotation = quarter;
    let turned = renderer.render(&view(quarter), &light, 512, BrdfSampling::Refine).0;
    assert!(rel_rmse(&turned, &straight) < 0.15, "{}", rel_rmse(&turned, &straight));
    assert!(rel_rmse(&not_turned, &straight) > 0.3, "negative control {}", rel_rmse(&not_turned, &straight));
}

/// Exact cuts with all leaves in the illumination cut are the samples reference, but for interpolation.
#[test]
fn full_cuts_equal_brute_force_where_visibility_is_linear() {
    let dataset = ggx(dataset(mesh(8, false), glossy(0.5)));
    let renderer = Renderer::new(dataset.clone());
    let light = illumination([64, 32], |x, y| Vec3::splat(f32::from(u8::from(x % 9 == 0 && y < 14)) * 20.0 + 0.1));
    let view = from_the_side(32);
    let reference = renderer.samples_reference(&view, &light, &Quiet);
    let full = renderer.render(&view, &light, LIGHTS as u32, BrdfSampling::Once);
    assert_eq!(full.1.mean_merged_nodes, LIGHTS as f64);
    assert!(rel_rmse(&full.0, &reference) < 1e-4, "{}", rel_rmse(&full.0, &reference));
    let coarse = renderer.render(&view, &light, 16, BrdfSampling::Once);
    assert!(rel_rmse(&coarse.0, &reference) > 0.05, "negative control");
}

#[test]
fn refinement_beats_sampling_once_at_few_more_evaluations() {
    let dataset = ggx(dataset(mesh(24, true), glossy(0.35)));
    let renderer = Renderer::new(dataset.clone());
    let sun = |x: u32, y: u32| if (30..33).contains(&x) && (20..22).contains(&y) { 300.0 } else { 0.5 };
    let light = illumination([128, 64], |x, y| Vec3::splat(sun(x, y)));
    let view = from_the_side(48);
    let reference = renderer.samples_reference(&view, &light, &Quiet);
    let (once, once_stats) = renderer.render(&view, &light, 64, BrdfSampling::Once);
    let (refined, refined_stats) = renderer.render(&view, &light, 64, BrdfSampling::Refine);
    let (before, after) = (rel_rmse(&once, &reference), rel_rmse(&refined, &reference));
    assert!(after < 0.5 * before, "{before} to {after}");
    let more = refined_stats.mean_brdf_evaluations / once_stats.mean_brdf_evaluations;
    assert!(more < 1.5, "{more} times the evaluations");
}

#[test]
fn buried_vertices_have_no_say() {
    let mut dataset = dataset(mesh(1, false), white());
    let light = illumination([64, 32], |_, _| Vec3::ONE);
    let blind = |dataset: &mut Dataset| {
        let offset = dataset.cuts.push_cut(&[pack_node(0, 0.0)]);
        let mut offsets = dataset.cuts.offsets().to_vec();
        offsets[0] = offset;
        dataset.cuts = PackedCuts::from_parts(12, dataset.cuts.nodes().to_vec(), offsets).unwrap();
    };
    blind(&mut dataset);
    let least = |d: &Dataset| {
        let picture = Renderer::new(d.clone()).render(&from_above(16), &light, 64, BrdfSampling::Refine).0;
        picture.pixels.iter().map(|p| p.x).fold(f32::INFINITY, f32::min)
    };
    assert!(least(&dataset) < 0.8, "a blind vertex darkens its triangles");
    dataset.vertex_valid[0] = false;
    assert!(least(&dataset) > 0.97, "{}", least(&dataset));
}

#[test]
fn a_cancelled_reference_is_a_whole_coarse_picture() {
    struct StopAfterOnePass(std::sync::atomic::AtomicBool);
    impl crate::Progress for StopAfterOnePass {
        fn advanced(&self, _: u64, _: u64) {}
        fn preview(&self, _: &crate::Preview) {
            self.0.store(true, std::sync::atomic::Ordering::Relaxed);
        }
        fn cancelled(&self) -> bool {
            self.0.load(std::sync::atomic::Ordering::Relaxed)
        }
    }
    let dataset = dataset(mesh(4, false), white());
    let renderer = Renderer::new(dataset.clone());
    let light = illumination([8, 4], |_, _| Vec3::ONE);
    let stop = StopAfterOnePass(false.into());
    let picture = renderer.samples_reference(&from_above(16), &light, &stop);
    assert!(picture.pixels.iter().all(|p| (p.x - 1.0).abs() < 0.05));
}
