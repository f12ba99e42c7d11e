//! The backend matches the renderer in any number of bands, and its other modes show known values.

use super::*;
use crate::{
    Background, ViewMode,
    compare::compare,
    measure::compare::map::magma,
    shade::wireframe::{LINE_FADE, LINE_WIDTH},
    test_scenes::{dataset, from_above, from_the_side, glossy, illumination, mesh, point_light, white},
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{GgxParameters, Parameters},
    camera::Camera,
    dataset::Dataset,
    material::{BrdfModel, Material},
    scene::Mesh,
    texture::{Texels, Texture, TextureSlot},
};
use std::f32::consts::FRAC_1_SQRT_2;

const ILLUM_CUT: u32 = 64;

/// A backend with everything it needs for pictures of a dataset.
fn lit(dataset: &Arc<Dataset>, light: &Illumination) -> CpuBackend {
    let mut backend = CpuBackend::new();
    backend.set_scene(&dataset.clone().into()).unwrap();
    let lighting = Renderer::new(dataset.clone()).lighting(light, ILLUM_CUT);
    backend.set_light(light, &lighting.into()).unwrap();
    backend
}

fn scene() -> (Arc<Dataset>, Illumination) {
    let dataset = dataset(mesh(8, true), white());
    let light = illumination([64, 32], |x, y| Vec3::new(0.1 * x as f32, 1.0, 0.2 * y as f32));
    (dataset.into(), light)
}

/// Renders all samples in bands of `rows` rows.
fn picture(backend: &mut CpuBackend, view: &View, rows: u32) -> Image {
    backend.begin(view, BrdfSampling::Refine).unwrap();
    for sample in 0..view.aa {
        for first in (0..view.size[1]).step_by(rows as usize) {
            backend.render_rows(sample, first..first + rows).unwrap();
        }
    }
    backend.read(view.aa).unwrap().0
}

#[test]
fn one_band_and_many_give_what_the_renderer_gives() {
    let (dataset, light) = scene();
    let mut backend = lit(&dataset, &light);
    for aa in [1, 4] {
        for background in [Background::Environment, Background::Blurred(0.2), Background::Flat(Vec3::X)] {
            let view = View { aa, background, ..from_the_side(24) };
            let (expected, stats) =
                Renderer::new(dataset.clone()).render(&view, &light, ILLUM_CUT, BrdfSampling::Refine);
            assert!(picture(&mut backend, &view, 24) == expected, "one band, {aa} samples, {background:?}");
            assert!(picture(&mut backend, &view, 5) == expected, "five bands, {aa} samples, {background:?}");
            assert_eq!(backend.stats().unwrap().pixels_shaded, stats.pixels_shaded);
            assert_eq!(backend.stats().unwrap().mean_merged_nodes, stats.mean_merged_nodes);
            assert_eq!(backend.stats().unwrap().mean_brdf_evaluations, stats.mean_brdf_evaluations);
            let mut turned = light.clone();
            turned.rotation = 0.5;
            let other = Renderer::new(dataset.clone()).render(&view, &turned, ILLUM_CUT, BrdfSampling::Refine).0;
            assert!(other != expected, "negative control");
        }
    }
}

#[test]
fn a_picture_is_right_between_two_bands() {
    let (dataset, light) = scene();
    let mut backend = lit(&dataset, &light);
    let view = View { aa: 2, ..from_above(16) };
    picture(&mut backend, &View { aa: 1, ..view.clone() }, 16);
    let first = backend.display(&Post::default(), 1).unwrap();
    backend.begin(&view, BrdfSampling::Refine).unwrap();
    backend.render_rows(0, 0..16).unwrap();
    backend.render_rows(1, 0..8).unwrap();
    let between = backend.display(&Post::default(), 1).unwrap();
    assert_eq!(between[8 * 16..], first[8 * 16..]);
    let near = |a: &[u8; 4], b: &[u8; 4]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) < 100);
    assert!(between.iter().zip(&first).all(|(a, b)| near(a, b)), "no row is twice as bright");
}

fn microfacets(mesh: Mesh, parameters: GgxParameters) -> Arc<Dataset> {
    let mut dataset = dataset(mesh, parameters);
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    dataset.into()
}

/// A picture with lit cuts.
fn lit_picture(
    dataset: &Arc<Dataset>,
    light: &Illumination,
    tau: f32,
    sampling: BrdfSampling,
) -> (Image, PictureStats) {
    let mut backend = CpuBackend::new();
    backend.set_scene(&dataset.clone().into()).unwrap();
    let lighting = Renderer::new(dataset.clone()).lighting(light, 1).with_tau(tau);
    backend.set_light(light, &lighting.into()).unwrap();
    backend.begin(&View { background: Background::Flat(Vec3::ZERO), ..from_the_side(24) }, sampling).unwrap();
    backend.render_rows(0, 0..24).unwrap();
    (backend.read(1).unwrap().0, backend.stats().unwrap())
}

#[test]
fn lit_cuts_of_tau_zero_give_the_stored_cuts_picture_and_coarser_ones_nearly() {
    for (parameters, is_broad) in [(white(), true), (glossy(0.4), false)] {
        let dataset = microfacets(mesh(8, true), parameters);
        let light = illumination([64, 32], |x, y| Vec3::splat(if x == 20 && y < 8 { 300.0 } else { 0.02 * x as f32 }));
        let (stored, stored_stats) = lit_picture(&dataset, &light, 0.0, BrdfSampling::Refine);
        let (same, _) = lit_picture(&dataset, &light, 0.0, BrdfSampling::Lit);
        // The same terms in another order.
        let rounding = compare(&same, &stored).unwrap().rel_rmse;
        assert!(rounding < 1e-6, "today's cuts, and no illumination cut: {rounding}");
        let (lit, stats) = lit_picture(&dataset, &light, 0.003, BrdfSampling::Lit);
        let (coarse, _) = lit_picture(&dataset, &light, 1.0, BrdfSampling::Lit);
        let error = |image: &Image| compare(image, &stored).unwrap().rel_rmse;
        assert!(error(&lit) < 0.02 && lit != stored && coarse != lit, "{} {}", error(&lit), error(&coarse));
        // A narrow lobe descends to the stored nodes, however coarse the lit ones are.
        assert!(
            !is_broad || error(&coarse) > 2.0 * error(&lit),
            "negative control: {} {}",
            error(&lit),
            error(&coarse)
        );
        assert!(stats.mean_merged_nodes < 0.6 * stored_stats.mean_merged_nodes, "{stats:?} {stored_stats:?}");
    }
}

#[test]
fn lit_cuts_survive_any_light() {
    let dataset = microfacets(mesh(4, true), glossy(0.4));
    let lights: [&dyn Fn(u32, u32) -> f32; 4] =
        [&|_, _| 0.0, &|x, y| if (x, y) == (9, 3) { 1e9 } else { 0.0 }, &|_, _| 1e30, &|_, _| 1e-30];
    for (i, radiance) in lights.into_iter().enumerate() {
        let light = illumination([64, 32], |x, y| Vec3::splat(radiance(x, y)));
        for tau in [0.0, 0.003, 1.0] {
            let (image, _) = lit_picture(&dataset, &light, tau, BrdfSampling::Lit);
            assert!(image.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0), "{i} {tau}");
            assert_eq!(image.pixels.iter().any(|p| p.x > 0.0), i != 0, "{i} {tau}");
        }
    }
}

#[test]
fn modes_show_known_values() {
    let parameters = GgxParameters { base_color: Vec3::new(0.5, 0.25, 0.1), roughness: 0.3, ..Default::default() };
    let dataset = microfacets(mesh(1, false), parameters);
    let light = illumination([64, 32], |x, _| Vec3::splat(x as f32));
    let mut backend = lit(&dataset, &light);
    let mut mean = |mode| {
        let image = picture(&mut backend, &View { mode, ..from_above(8) }, 8);
        image.pixels.iter().sum::<Vec3>() / image.pixels.len() as f32
    };
    assert!((mean(ViewMode::Normals) - Vec3::new(0.5, 1.0, 0.5)).length() < 1e-5);
    assert!((mean(ViewMode::Albedo) - parameters.base_color).length() < 1e-5);
    assert!((mean(ViewMode::Roughness) - 0.3).length() < 1e-5);
    // Only the horizon divides the sky of a bare floor, and all vertices see the same.
    let cut = dataset.cuts.cut(dataset.tree.height(), 0).len() as f32;
    assert!((mean(ViewMode::VisibilityCut).x / cut - 1.0).abs() < 1e-4);
    let (merged, evaluations) = (mean(ViewMode::MergedCut).x, mean(ViewMode::BrdfEvaluations).x);
    let stats = backend.stats().unwrap();
    assert!((f64::from(merged) - stats.mean_merged_nodes).abs() < 1e-2 * stats.mean_merged_nodes);
    assert!((f64::from(evaluations) - stats.mean_brdf_evaluations).abs() < 1e-2 * stats.mean_brdf_evaluations);
    assert!(merged >= cut && merged < cut + ILLUM_CUT as f32);
    let view = View { mode: ViewMode::MergedCut, ..from_above(8) };
    backend.begin(&view, BrdfSampling::Lit).unwrap();
    backend.render_rows(0, 0..8).unwrap();
    let lit = backend.read(1).unwrap().0.pixels[27].x;
    assert!(lit > 1.0 && lit < 0.5 * cut, "lit cuts are coarser: {lit} of {cut}");
}

#[test]
fn counts_are_shown_in_false_colours_up_to_the_top_of_the_legend() {
    let dataset: Arc<Dataset> = dataset(mesh(1, false), white()).into();
    let light = illumination([8, 4], |_, _| Vec3::ONE);
    let mut backend = lit(&dataset, &light);
    let view = View { mode: ViewMode::VisibilityCut, ..from_above(4) };
    picture(&mut backend, &view, 4);
    let cut = dataset.cuts.cut(dataset.tree.height(), 0).len() as f32;
    let expected = magma(cut / ViewMode::VisibilityCut.count_top(BrdfSampling::Once, ILLUM_CUT)) * 255.0;
    let exposed = Post { exposure: 3.0, ..Post::default() };
    let shown = backend.display(&exposed, 1).unwrap()[5];
    for (shown, expected) in shown.iter().zip(expected.to_array()) {
        assert!((f32::from(*shown) - expected).abs() <= 0.6, "{shown} {expected}");
    }
}

#[test]
fn a_transparent_background_has_no_coverage_and_edges_keep_their_colour() {
    let (dataset, _) = scene();
    let light = illumination([8, 4], |_, _| Vec3::splat(0.5));
    let mut backend = lit(&dataset, &light);
    // The floor's far edge and sky above it.
    let camera = Camera::look_at(Vec3::new(0.0, 0.6, 3.0), Vec3::new(0.0, 0.6, 0.0), 60.0);
    let view = View { aa: 16, background: Background::Transparent, ..View::new(camera, [24, 24]) };
    picture(&mut backend, &view, 24);
    let coverage = backend.read(16).unwrap().1;
    let shown = backend.display(&Post::default(), 16).unwrap();
    assert_eq!((coverage[0], shown[0]), (0.0, [0; 4]));
    assert_eq!((coverage[20 * 24 + 12], shown[20 * 24 + 12][3]), (1.0, 255));
    let edge = (0..24 * 24).find(|&i| coverage[i] > 0.2 && coverage[i] < 0.8).expect("an edge runs through a pixel");
    assert_eq!(shown[edge][3], (255.0 * coverage[edge] + 0.5) as u8);
    picture(&mut backend, &View { background: Background::Flat(Vec3::ZERO), ..view }, 24);
    let over_black = backend.display(&Post::default(), 16).unwrap();
    assert!(over_black[edge][0] < shown[edge][0], "negative control: over black the edge is darker");
    assert_eq!(over_black[0], [0, 0, 0, 255]);
}

#[test]
fn wires_run_along_edges_and_change_neither_values_nor_the_rest() {
    let (dataset, light) = (Arc::new(dataset(mesh(2, false), white())), illumination([8, 4], |_, _| Vec3::splat(0.5)));
    let mut backend = lit(&dataset, &light);
    let plain = from_above(64);
    let expected = picture(&mut backend, &plain, 64);
    let without = backend.display(&Post::default(), 1).unwrap();
    let wired = View { wireframe: true, ..plain };
    assert!(picture(&mut backend, &wired, 64) == expected);
    let with = backend.display(&Post::default(), 1).unwrap();
    // Edges of the eight triangles from above, +X right and +Z down: x = 0, z = 0 and z = x + {-2, 0, 2}.
    let metres_per_pixel = 2.0 * 6.0 * 15.0_f32.to_radians().tan() / 64.0;
    let reach = 0.5 * LINE_WIDTH + LINE_FADE;
    for (i, (a, b)) in with.iter().zip(&without).enumerate() {
        let [x, z] = [i % 64, i / 64].map(|p| (p as f32 - 31.5) * metres_per_pixel);
        let diagonal = [-2.0, 0.0, 2.0].map(|c| (z - x - c).abs() * FRAC_1_SQRT_2).into_iter().fold(f32::MAX, f32::min);
        let distance = x.abs().min(z.abs()).min(diagonal) / metres_per_pixel;
        assert!(distance > reach - 0.3 || a != b, "pixel {i} is {distance} pixels from an edge and has no line");
        assert!(distance < reach + 0.1 || a == b, "pixel {i} is {distance} pixels from an edge and has a line");
    }
}

#[test]
fn without_a_light_pictures_are_black_but_for_what_needs_none() {
    let (dataset, light) = scene();
    let mut backend = lit(&dataset, &light);
    backend.set_scene(&dataset.into()).unwrap();
    let black = picture(&mut backend, &from_the_side(8), 8);
    assert!(black.pixels.iter().all(|p| *p == Vec3::ZERO));
    let albedo = picture(&mut backend, &View { mode: ViewMode::Albedo, ..from_above(8) }, 8);
    assert!(albedo.pixels.iter().all(|p| *p == Vec3::ONE));
}

#[test]
fn maps_of_anisotropy_and_ior_give_the_picture_of_the_values_that_they_make() {
    let (dataset, light) = scene();
    let mut backend = lit(&dataset, &light);
    let view = from_the_side(24);
    let half = Texture::new("half", [1, 1], Texels::F32(vec![[0.5; 4]]));
    let half = Arc::new(half);
    let parameters = |anisotropy, ior| Parameters::from(GgxParameters { anisotropy, ior, ..glossy(0.5) });
    let mut shown = |parameters, [anisotropy, ior]: [bool; 2]| {
        let mut material = Material { parameters, ..Default::default() };
        material.maps.set("anisotropy", anisotropy.then(TextureSlot::default));
        material.maps.set("ior", ior.then(TextureSlot::default));
        let appearance = Appearance { materials: vec![material], textures: vec![half.clone()], assigned: None };
        assert!(backend.set_appearance(&appearance).unwrap().is_empty());
        picture(&mut backend, &view, 24)
    };
    let plain = shown(parameters(-0.75, 2.0), [false, false]);
    for (maps, made) in [
        ([true, false], parameters(-0.375, 2.0)),
        ([false, true], parameters(-0.75, 1.5)),
        ([true, true], parameters(-0.375, 1.5)),
    ] {
        let mapped = shown(parameters(-0.75, 2.0), maps);
        assert!(mapped == shown(made, [false, false]), "{maps:?}");
        assert!(mapped != plain, "negative control: {maps:?}");
    }
}

#[test]
fn appearances_that_do_not_fit_are_made_to() {
    let (dataset, light) = scene();
    let mut backend = lit(&dataset, &light);
    let view = from_above(8);
    let white_floor = picture(&mut backend, &view, 8);
    assert_eq!(backend.set_appearance(&Appearance::default()).unwrap().len(), 1);
    assert!(picture(&mut backend, &view, 8) == white_floor);
    let mut odd = Material { parameters: glossy(0.5).into(), ..Default::default() };
    odd.maps.set("base_color", Some(TextureSlot { texture: 7, scale: Vec2::ONE, ..Default::default() }));
    let remarks = backend.set_appearance(&Appearance { materials: vec![odd], ..Default::default() }).unwrap();
    assert!(remarks.len() == 1 && remarks[0].contains("without maps"), "{remarks:?}");
    assert!(picture(&mut backend, &view, 8) != white_floor);
    let fitting = Appearance::of(&dataset.scene);
    assert!(backend.set_appearance(&fitting).unwrap().is_empty());
    assert!(picture(&mut backend, &view, 8) == white_floor);
}

#[test]
fn thousands_of_lights_are_shown_and_their_cost_is_said_once() {
    let (dataset, _) = scene();
    let mut backend = CpuBackend::new();
    let baked = dataset.into();
    backend.set_scene(&baked).unwrap();
    let lamp = |i: usize| {
        let turn = i as f32 * 2.4;
        let position = Vec3::new(turn.sin(), 0.5 + 1e-3 * i as f32, turn.cos());
        point_light(position, 0.01)
    };
    let lights: Vec<Light> = (0..2000).map(lamp).collect();
    let mut show = |lights: &[Light]| {
        let local = LocalLighting { lights: lights.into(), ..Default::default() };
        let remarks = backend.set_local_lighting(&local).unwrap();
        (picture(&mut backend, &from_the_side(16), 16), remarks)
    };
    let (all, remarks) = show(&lights);
    assert!(remarks.len() == 1 && remarks[0].contains("2000 local lights"), "{remarks:?}");
    assert!(all.pixels.iter().all(|p| p.is_finite()));
    let mut sum = Image::filled(all.size, Vec3::ZERO);
    for part in lights.chunks(250) {
        let (image, remarks) = show(part);
        assert!(remarks.is_empty(), "250 are not too many");
        sum.add(&image);
    }
    let close = |a: &Image| {
        a.pixels.iter().zip(&all.pixels).all(|(a, b)| (a - b).abs().max_element() <= 3e-4 * b.max_element())
    };
    assert!(close(&sum) && !close(&show(&lights[..1900]).0), "parts add up, and fewer do not");
    assert!(show(&lights).1.len() == 1 && show(&lights).1.is_empty(), "said once");
    backend.set_scene(&baked).unwrap();
    let local = LocalLighting { lights: lights.into(), ..Default::default() };
    assert_eq!(backend.set_local_lighting(&local).unwrap().len(), 1, "and of another scene");
}
