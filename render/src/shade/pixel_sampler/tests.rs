//! Camera rays through transparent surfaces.

use super::*;
use crate::view::pixel_sample_position;
use crate::{
    Appearance,
    test_scenes::{dataset, from_above, mesh, white},
};
use glam::DVec2;
use lapidary_core::{dataset::Dataset, parts::Part};

/// A green floor below two transparent red panes, one just above the other.
pub(crate) fn panes(opacity: f32) -> Dataset {
    let mut dataset = dataset(mesh(4, true), white());
    let scene = &mut dataset.scene;
    let panes = scene.mesh.triangles.len() - 4..;
    scene.mesh.triangle_material[panes.clone()].fill(1);
    dataset.two_sided[panes].fill(true);
    scene.materials.push(scene.materials[0].clone());
    scene.materials[0].set_emission(Vec3::Y);
    scene.materials[1].set_emission(Vec3::X);
    scene.materials[1].parameters.set("geometry_opacity", opacity);
    dataset
}

/// The panes with transparency set on a part of the scene instead of the opaque material.
pub(crate) fn panes_of_a_part(opacity: f32) -> Dataset {
    let mut dataset = panes(1.0);
    let scene = &mut dataset.scene;
    let mut own = scene.materials.clone();
    own.push(panes(opacity).scene.materials[1].clone());
    let pane = Part { object: 0, material: 1 };
    scene.take_opacities(&own, 2, [(pane, 2)], &[]);
    dataset
}

/// Pixels in the middle of the panes.
fn middle(renderer: &Renderer, samples: u32) -> Vec<Vec3> {
    let view = View { aa: samples, ..from_above(48) };
    let backdrop = Backdrop::black();
    let sampler = PixelSampler::new(renderer, &view, &backdrop);
    let pixels = (20..28).flat_map(|y| (20..28).map(move |x| (x, y)));
    pixels.map(|(x, y)| sampler.pixel(x, y, |point| point.emission)).collect()
}

fn mean(pixels: &[Vec3]) -> Vec3 {
    pixels.iter().sum::<Vec3>() / pixels.len() as f32
}

#[test]
fn layers_let_each_other_show_as_often_as_they_let_light_through() {
    for opacity in [0.0, 0.2, 0.5, 0.9, 1.0] {
        let renderer = Renderer::new(panes(opacity));
        let passed = (1.0 - opacity) * (1.0 - opacity);
        let seen = middle(&renderer, 16);
        let expected = Vec3::new(1.0 - passed, passed, 0.0);
        let error = mean(&seen) - expected;
        assert!(error.abs().max_element() < 0.015, "{opacity}: {error}");
        let spread = seen.iter().map(|pixel| (pixel.x - expected.x).abs()).sum::<f32>() / seen.len() as f32;
        // Random thresholds alone would give 0.086 for two panes of opacity one half.
        assert!(spread < 0.075, "{opacity}: {spread}");
        let one_pane = (1.0 - opacity - mean(&seen).y).abs();
        assert!(opacity.fract() == 0.0 || one_pane > 0.05, "negative control: a single pane");
    }
}

#[test]
fn single_samples_and_eights_of_them_see_the_same() {
    let renderer = Renderer::new(panes(0.5));
    let view = View { aa: 4, ..from_above(48) };
    let backdrop = Backdrop::black();
    let sampler = PixelSampler::new(&renderer, &view, &backdrop);
    let pixels: Vec<[u32; 2]> = (0..48 * 48 - 3).map(|i| [i % 48, i / 48]).collect();
    let material = |seen: FirstHit| match seen {
        FirstHit::Surface(point) => Some(point.material),
        FirstHit::Back | FirstHit::Background => None,
    };
    let mut seen = [0; 2];
    for sample in 0..4 {
        for (&[x, y], hit) in pixels.iter().zip(sampler.hits(&pixels, sample)) {
            let [one, of_eight] =
                [sampler.sight(x, y, sample), sampler.sight_of([x, y], sample, hit)].map(|sight| material(sight.seen));
            assert_eq!(one, of_eight);
            one.iter().for_each(|&material| seen[material as usize] += 1);
        }
    }
    assert!(seen.iter().all(|&count| count > 100), "{seen:?}");
}

#[test]
fn parts_let_light_through_as_they_were_baked() {
    let [material, part, opaque] = [panes(0.4), panes_of_a_part(0.4), panes_of_a_part(1.0)].map(Renderer::new);
    assert_eq!(middle(&part, 4), middle(&material, 4));
    assert_eq!(mean(&middle(&opaque, 4)), Vec3::X, "negative control");
}

#[test]
fn an_edit_of_opacity_counts_at_once() {
    let mut renderer = Renderer::new(panes(1.0));
    let before = mean(&middle(&renderer, 16));
    let mut edited = Appearance::of(&panes(0.25).scene);
    renderer.set_appearance(edited.clone());
    let after = mean(&middle(&renderer, 16));
    assert!(before == Vec3::X && (after.y - 0.75 * 0.75).abs() < 0.03, "{before} {after}");
    edited.materials[1].parameters.set("geometry_opacity", 1.0);
    renderer.set_appearance(edited);
    assert_eq!(mean(&middle(&renderer, 16)), before);
}

/// Height of the eye over the floor, and of the plates over it, in meters.
const EYE: f32 = 6.0;
const PLATE: f32 = 1.0;
/// Radius of the aperture in meters.
const APERTURE_RADIUS: f32 = 1.2;

/// From above, with a wide lens that is focused on the floor.
fn through_a_lens(samples: u32) -> View {
    let mut view = View { aa: samples, ..from_above(48) };
    view.camera.lens.f_number = Some(view.camera.focal_length() / (2.0 * APERTURE_RADIUS));
    view.camera.lens.focus = Some(EYE);
    view
}

/// Share of the aperture through which a pixel sees the plate: of the unit disc left of a line.
fn seen_past_the_edge(view: &View, x: u32) -> f32 {
    let on_floor = (x as f32 + 0.5 - 24.0) * view.projection().pixel_span(EYE);
    // Rays from the aperture to the floor meet the height of the plate here.
    let [of_lens, of_floor] = [PLATE / EYE, 1.0 - PLATE / EYE];
    let line = ((0.5 - of_floor * on_floor) / (of_lens * APERTURE_RADIUS)).clamp(-1.0, 1.0);
    0.5 + (line * (1.0 - line * line).sqrt() + line.asin()) / std::f32::consts::PI
}

#[test]
fn an_edge_out_of_focus_is_as_soft_as_the_aperture_is_wide() {
    let renderer = Renderer::new(panes(1.0));
    let (view, backdrop) = (through_a_lens(256), Backdrop::black());
    let sampler = PixelSampler::new(&renderer, &view, &backdrop);
    let mut soft = 0;
    for x in 24..48 {
        let expected = seen_past_the_edge(&view, x);
        let by_samples = sampler.pixel(x, 24, |point| point.emission).x;
        assert!((by_samples - expected).abs() < 0.03, "{x}: {by_samples} for {expected}");
        let at = |i: u32| pixel_sample_position(i, DVec2::splat(0.5));
        let by_chance: f32 = (0..256).map(|i| sampler.sample_at(x, 24, at(i), |point| point.emission).x).sum();
        assert!((by_chance / 256.0 - expected).abs() < 0.12, "{x}: {by_chance} of 256 paths for {expected}");
        soft += u32::from((0.05..0.95).contains(&expected));
    }
    assert!(soft > 4, "{soft} pixels");
    let mut sharp = view.clone();
    sharp.camera.lens.focus = Some(EYE - PLATE);
    let sampler = PixelSampler::new(&renderer, &sharp, &backdrop);
    let between = |x: &u32| (0.05..0.95).contains(&sampler.pixel(*x, 24, |point| point.emission).x);
    assert!((24..48).filter(between).count() < 2, "negative control: the plate is in focus");
}

#[test]
fn rays_of_a_sample_are_traced_together_through_its_point_of_the_lens() {
    let renderer = Renderer::new(panes(1.0));
    let (view, backdrop) = (through_a_lens(8), Backdrop::black());
    let sampler = PixelSampler::new(&renderer, &view, &backdrop);
    let pixels: Vec<[u32; 2]> = (0..48).map(|x| [x, 24]).collect();
    for sample in 0..8 {
        let hits = sampler.hits(&pixels, sample);
        for (&[x, y], hit) in pixels.iter().zip(hits) {
            let [alone, together] = [sampler.sight(x, y, sample), sampler.sight_of([x, y], sample, hit)];
            assert_eq!(alone.position, together.position);
            let place = |sight: &Sight| sight.surface().map(|point| (point.triangle, point.position));
            match [&alone, &together].map(place) {
                [Some((a, at_a)), Some((b, at_b))] => assert!(a == b && at_a.distance(at_b) < 1e-4, "{x}, {sample}"),
                [a, b] => assert_eq!(a, b, "{x}, {sample}"),
            }
        }
    }
}
