//! Camera rays through transparent surfaces.

use super::*;
use crate::{
    Appearance,
    test_scenes::{dataset, from_above, mesh, white},
};
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
