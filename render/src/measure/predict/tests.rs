//! Predicted errors of whole pictures against the true ones.

use super::*;
use crate::{
    Quiet,
    test_scenes::{LIGHTS, dataset, dataset_of_sigma, from_the_side, glossy, illumination, mesh, white},
};
use lapidary_core::material::BrdfModel;

const SIZE: u32 = 24;

fn prepared(sigma: f32) -> Renderer {
    let mut dataset = dataset_of_sigma(mesh(24, true), glossy(0.5), sigma);
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    Renderer::new(dataset)
}

fn uneven_sky() -> crate::Illumination {
    illumination([64, 32], |x, y| Vec3::splat(0.2 + 3.0 * f32::from(u8::from(x % 16 < 5 && y < 14))))
}

fn mean(image: &Image) -> f32 {
    image.pixels.iter().map(|p| p.x).sum::<f32>() / image.pixels.len() as f32
}

#[test]
fn where_visibility_is_exact_the_bound_holds_and_a_hundredth_of_it_does_not() {
    // Without a blocker no pixel has an interpolation error: the floor sees the upper half everywhere.
    let mut open = dataset(mesh(4, false), glossy(0.5));
    open.scene.materials[0].model = BrdfModel::Ggx;
    let (renderer, view, light) = (Renderer::new(open), from_the_side(SIZE), uneven_sky());
    let reference = renderer.samples_reference(&view, &light, &Quiet);
    for sampling in [BrdfSampling::Once, BrdfSampling::Refine, BrdfSampling::Lit] {
        let lighting = renderer.lighting(&light, 512);
        let test = renderer.render_lit(&view, &light, &lighting, sampling).0;
        let predicted = predicted_error(&renderer, &view, &lighting, sampling, &Quiet).unwrap().unwrap();
        let calibration = calibrate(&predicted.bound, &test, &reference, 5).unwrap();
        assert!(calibration.within > 0.99, "{sampling:?}: {calibration:?}");
        let scaled = |scale: f32| {
            let pixels = predicted.bound.pixels.iter().map(|&p| p * scale).collect();
            Image { size: predicted.bound.size, pixels }
        };
        let part = 1e-2;
        let control = calibrate(&scaled(part), &test, &reference, 5).unwrap();
        assert!(control.within < 0.9, "negative control {sampling:?}: {}", control.within);
        assert!(predicted.bound.pixels.iter().zip(&predicted.printed.pixels).all(|(whole, part)| whole.x >= part.x));
        assert!(
            predicted.bound.pixels.iter().zip(&predicted.expected.pixels).all(|(sum, root)| sum.x >= root.x * 0.999)
        );
    }
}

#[test]
fn constant_light_leaves_only_the_covariance_of_visibility_and_brdf() {
    let (renderer, view) = (prepared(2.0), from_the_side(SIZE));
    let constant = illumination([8, 4], |_, _| Vec3::ONE);
    // The leaves of a constant map differ by 0.2 %, so a light without variance is made by hand.
    let tree = &renderer.dataset.tree;
    let even = SceneLighting::new(tree, &vec![Vec3::ONE; LIGHTS], 64);
    assert!(radiance_variance(&even).iter().all(|&v| v == Vec3::ZERO));
    let predict = |lighting: &SceneLighting| {
        predicted_error(&renderer, &view, lighting, BrdfSampling::Refine, &Quiet).unwrap().unwrap()
    };
    let lambert = {
        let renderer = Renderer::new(dataset(mesh(4, false), white()));
        let whole = SceneLighting::new(&renderer.dataset.tree, &vec![Vec3::ONE; LIGHTS], LIGHTS as u32);
        predicted_error(&renderer, &view, &whole, BrdfSampling::Once, &Quiet).unwrap().unwrap()
    };
    assert!(mean(&lambert.printed) < 0.1 * mean(&predict(&even).printed), "exact cuts, even light");
    let uneven = renderer.lighting(&uneven_sky(), 64);
    let (of_even, of_constant) = (predict(&even), predict(&renderer.lighting(&constant, 64)));
    assert!((mean(&of_even.printed) / mean(&of_constant.printed) - 1.0).abs() < 0.1);
    let scale = uneven.nodes.radiance[1].x;
    assert!(
        mean(&predict(&uneven).printed) > 1.5 * scale * mean(&of_even.printed),
        "negative control: light that varies"
    );
}

#[test]
fn finer_light_and_finer_cuts_are_predicted_to_err_less() {
    let view = from_the_side(SIZE);
    let bound = |sigma: f32, nodes: u32| {
        let renderer = prepared(sigma);
        let lighting = renderer.lighting(&uneven_sky(), nodes);
        mean(&predicted_error(&renderer, &view, &lighting, BrdfSampling::Refine, &Quiet).unwrap().unwrap().bound)
    };
    let of_lights = [16, 128, 1024].map(|nodes| bound(0.0, nodes));
    assert!(of_lights.is_sorted_by(|a, b| *a > 1.2 * b), "{of_lights:?}");
    assert!(bound(4.0, 128) > 1.1 * bound(0.0, 128));
}

#[test]
fn lit_cuts_that_move_more_light_are_predicted_to_err_more() {
    // Without a lobe no merge descends into the stored cuts.
    let (renderer, view) = (Renderer::new(dataset(mesh(24, true), white())), from_the_side(SIZE));
    let bound = |tau: f32| {
        let lighting = renderer.lighting(&uneven_sky(), 1).with_tau(tau);
        mean(&predicted_error(&renderer, &view, &lighting, BrdfSampling::Lit, &Quiet).unwrap().unwrap().bound)
    };
    let of_taus = [0.3, 0.03, 0.001].map(bound);
    assert!(of_taus.is_sorted_by(|a, b| *a > 1.1 * b), "{of_taus:?}");
}

#[test]
fn a_cancelled_prediction_is_none_and_a_dataset_without_cuts_is_refused() {
    struct Stop;
    impl Progress for Stop {
        fn advanced(&self, _: u64, _: u64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let renderer = prepared(2.0);
    let (view, lighting) = (from_the_side(SIZE), renderer.lighting(&uneven_sky(), 16));
    assert!(predicted_error(&renderer, &view, &lighting, BrdfSampling::Once, &Stop).unwrap().is_none());
    let mut dark = dataset(mesh(2, false), white());
    dark.settings.mode = lapidary_core::dataset::BakeParts::INDIRECT;
    let refused = predicted_error(&Renderer::new(dark), &view, &lighting, BrdfSampling::Once, &Quiet).unwrap_err();
    assert_eq!(refused, NoCuts::Environment);
}
