//! Known answers for the CPU renderer and both references: furnace, shadow of a single light, orientation, all leaves.

mod from_files;

use super::*;
use crate::{
    Background, BrdfSampling, PathSettings, Quiet, View,
    test_scenes::{LIGHTS, dataset, from_above, from_the_side, glossy, illumination, mesh, rel_rmse, white},
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    cut::packed::{PackedCuts, pack_node},
    material::BrdfModel,
};

fn ggx(mut dataset: Dataset) -> Dataset {
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    dataset
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
    let gray = illumination([64, 32], |_, _| Vec3::splat(0.98));
    let darker = renderer.render(&view, &gray, 256, BrdfSampling::Refine).0;
    assert!(darker.pixels.iter().all(|p| p.x < 0.99), "negative control: two percent less light is seen");
}

/// A single bright texel casts the blocker's shadow at its geometric place: shifted by height times the light's slope.
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
            // Position of a floor point in the picture.
            let view_from_world = view.camera.world_from_view().transpose();
            let p = view_from_world * (Vec3::new(x, 0.0, z) - view.camera.eye);
            let tan = (0.5 * view.camera.fov_y).tan();
            let pixel = |v: f32| ((0.5 + 0.5 * v / (-p.z * tan)) * 96.0) as usize;
            picture.at(pixel(p.x), pixel(-p.y)).x / brightest
        };
        // Shadow of the square [-0.5, 0.5]² at height 1, with a margin for the width of texel and light sample.
        for (dx, dz) in [(0.0, 0.0), (0.35, 0.0), (-0.35, 0.35), (0.0, -0.35)] {
            assert!(value(dx - shift.x, dz - shift.z) < 0.1, "{name}: lit at {dx}, {dz} of the shadow's centre");
        }
        for (dx, dz) in [(0.68, 0.0), (0.0, 0.68), (0.0, -0.68)] {
            assert!(value(dx - shift.x, dz - shift.z) > 0.6, "{name}: dark at {dx}, {dz} of the shadow's centre");
        }
        assert!(value(shift.x, shift.z) > 0.6, "{name}: negative control: there is no shadow on the other side");
    }
}

/// Rotating the map by 90 degrees and the camera by 90 degrees gives the same picture.
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

/// Exact cuts with all leaves in the illumination cut equal the samples reference, up to interpolation.
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
