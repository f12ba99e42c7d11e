//! Sharp lobes against light paths, which read the whole map, and against lobes that need no map.

use super::*;
use crate::{
    Quiet, Renderer,
    light::environment::Illumination,
    reference::path::settings::PathSettings,
    sampling::BrdfSampling,
    test_scenes::{dataset, from_the_side, illumination, mean, mesh, rel_rmse},
    view::View,
};
use lapidary_core::{
    brdf::{BrdfModel, GgxParameters, OpenPbrParameters, Parameters, SurfaceBrdf, Values},
    image::Image,
    scene::Mesh,
};

/// Bright stripes, three per light sample.
fn stripes() -> Illumination {
    illumination([512, 256], |x, y| Vec3::splat(if (x / 2 + y / 2) % 2 == 0 { 1.5 } else { 0.1 }))
}

fn metal(alpha: f32) -> GgxParameters {
    GgxParameters {
        base_color: Vec3::new(0.9, 0.7, 0.5),
        roughness: alpha.sqrt(),
        metalness: 1.0,
        ..Default::default()
    }
}

fn metallic(mesh: Mesh, alpha: f32) -> Renderer {
    let mut dataset = dataset(mesh, metal(alpha));
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    Renderer::new(dataset)
}

fn view() -> View {
    View { aa: 4, ..from_the_side(32) }
}

/// Error against paths at the same positions in the pixels.
fn error(renderer: &Renderer, light: &Illumination, shown: &Image) -> f64 {
    let settings = PathSettings {
        positions: crate::reference::path::settings::SamplePositions::Shared,
        ..PathSettings::direct(1024)
    };
    rel_rmse(shown, &renderer.path_reference(&view(), light, &[], settings, &Quiet))
}

#[test]
fn mirrors_show_what_light_samples_cannot() {
    let light = stripes();
    for alpha in [0.0025, 0.01, 0.02] {
        let renderer = metallic(mesh(32, true), alpha);
        let lighting = renderer.lighting(&light, 256);
        let mut blurred = lighting.clone();
        blurred.lights.mirrored = None;
        let [sharp, blurred] = [&lighting, &blurred].map(|lighting| {
            error(&renderer, &light, &renderer.render_lit(&view(), &light, lighting, BrdfSampling::Lit).0)
        });
        assert!(sharp < 0.1, "{alpha}: {sharp}");
        assert!(blurred > 2.0 * sharp, "negative control: without the map, {alpha}: {blurred}");
    }
}

#[test]
fn the_reference_by_samples_has_the_same_mirrors() {
    let (light, renderer) = (stripes(), metallic(mesh(32, true), 0.01));
    let reference = renderer.samples_reference(&view(), &light, &Quiet);
    let error = error(&renderer, &light, &reference);
    assert!(error < 0.1, "{error}");
}

/// In even light all widths match the paths: metals, plastics, and coats over wide and narrow bases.
#[test]
fn no_energy_is_lost_or_won_and_there_is_no_seam() {
    let light = illumination([64, 32], |_, _| Vec3::ONE);
    let error = |model: BrdfModel, parameters: Parameters| {
        let mut dataset = dataset(mesh(32, false), parameters);
        dataset.scene.materials[0].model = model;
        let renderer = Renderer::new(dataset);
        let shown = mean(&renderer.render(&view(), &light, 256, BrdfSampling::Lit).0);
        shown / mean(&renderer.path_reference(&view(), &light, &[], PathSettings::direct(128), &Quiet)) - 1.0
    };
    let coat = |alpha: f32, base: f32| OpenPbrParameters {
        coat_weight: 1.0,
        coat_roughness: alpha.sqrt(),
        base_metalness: 1.0,
        specular_roughness: base,
        ..Default::default()
    };
    let plastic = |alpha: f32| GgxParameters { metalness: 0.0, ..metal(alpha) };
    let alphas = (1..=60).step_by(6).map(|step| 0.0033 * step as f32);
    let errors = alphas.map(|alpha| {
        [
            error(BrdfModel::Ggx, metal(alpha).into()),
            error(BrdfModel::Ggx, plastic(alpha).into()),
            error(BrdfModel::OpenPbr, coat(alpha, 0.25).into()),
            error(BrdfModel::OpenPbr, coat(alpha, 0.5).into()),
        ]
    });
    let errors: Vec<[f32; 4]> = errors.collect();
    // Light samples are three times as far apart here as in a bake.
    assert!(errors.as_flattened().iter().all(|error| error.abs() < 0.04), "{errors:?}");
}

fn among(leaf: f32) -> Widths<impl Fn(f32) -> f32> {
    Widths::among_samples(sample_radius(leaf))
}

#[test]
fn only_sharp_lobes_are_mirrors() {
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let leaf = 4.0 * PI / 32_768.0;
    let of = |model: BrdfModel, parameters: Parameters| {
        let brdf = SurfaceBrdf::new(model, &Values::of(model.parameters(), &parameters), None);
        Mirror::of(brdf.as_brdf().lobes(), [0.0; 3], wo, among(leaf))
    };
    assert_eq!(of(BrdfModel::Ggx, metal(0.01).into()).unwrap().share, 1.0);
    assert!(of(BrdfModel::Ggx, metal(0.2).into()).is_none() && of(BrdfModel::Lambert, Parameters::default()).is_none());
    let coated = OpenPbrParameters { coat_weight: 1.0, specular_roughness: 0.5, ..Default::default() };
    let coat = of(BrdfModel::OpenPbr, coated.into()).unwrap();
    assert_eq!((coat.count, coat.share), (2, 1.0), "the coat over a rough base, and the window");
    let grooves = |xy| Mirror::of([[0.01; 2], NO_LOBE, NO_LOBE], [2e-4, xy, 2e-4], wo, among(leaf));
    assert!(grooves(1e-4).is_none() && grooves(0.0).is_some(), "grooves that run along no axis");
    assert!(Mirror::of([[0.01; 2]; 3], [0.0; 3], -wo, among(leaf)).is_none(), "seen from below");
}

/// The window is 1 around the mirror direction, 0 where [`Mirror::overlaps`] is false, and falls in between.
#[test]
fn windows_lie_around_the_direction_of_the_mirror() {
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let mirror = Mirror::of([[0.01, 0.02], NO_LOBE, NO_LOBE], [0.0; 3], wo, among(4.0 * PI / 32_768.0)).unwrap();
    let at = |direction: Vec3| mirror.window::<f32x8>(Vec3x8::splat(direction.normalize())).to_array()[0];
    let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
    assert_eq!(at(mirrored), 1.0);
    let mut inside = 0;
    for i in 0..10_000 {
        let [u, v] = [(i as f32 + 0.5) / 1e4, (i as f32 * 0.618_034).fract()];
        let d = lapidary_core::sphere::cosine_direction(u, v);
        let overlaps = mirror.overlaps(f32x8::splat(d.dot(mirrored)), f32x8::splat(1e-3)).to_bitmask() != 0;
        assert!(at(d) == 0.0 || overlaps, "{d}");
        inside += usize::from(at(d) > 0.0);
    }
    assert!((10..1000).contains(&inside), "{inside}");
}

#[test]
fn samples_fill_the_window_and_follow_the_lobe() {
    let wo = Vec3::new(0.3, 0.2, 0.93).normalize();
    for lobe in [[0.02, 0.02], [0.005, 0.03]] {
        let mirror = Mirror::of([lobe, NO_LOBE, NO_LOBE], [0.0; 3], wo, among(4.0 * PI / 32_768.0)).unwrap();
        // The density integrates to one, for the lobe and for a uniform function in the window.
        let lobes = mirror.lobes.map(GgxLobe::new);
        let lobes = &lobes[..mirror.count];
        let directions = mirror.samples(lobes, Disc::MIDDLE);
        let area = |wi: Vec3| mirror.solid_angles(lobes, Vec3x8::<f32x8>::splat(wi)).to_array()[0];
        let used = &directions[..mirror.count * SAMPLES];
        let integral = |f: &dyn Fn(Vec3) -> f32| used.iter().map(|&wi| f(wi) * area(wi)).sum::<f32>();
        let ggx = GgxLobe::new(lobe);
        let of_lobe = integral(&|wi| ggx.pdf(wi, wo));
        assert!((of_lobe - 1.0).abs() < 0.1, "{of_lobe}");
        let even = integral(&|wi| mirror.window::<f32x8>(Vec3x8::splat(wi)).to_array()[0]);
        let directions = lapidary_core::sphere::fibonacci_directions(400_000);
        let exact =
            directions.iter().filter(|d| d.z > 0.0).map(|&d| mirror.window::<f32x8>(Vec3x8::splat(d)).to_array()[0]);
        let exact = exact.sum::<f32>() * 4.0 * PI / 400_000.0;
        assert!((even / exact - 1.0).abs() < 0.15, "{even} for {exact}");
    }
}
