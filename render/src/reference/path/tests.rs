//! Light paths against closed forms: the integrating sphere, form factors, Lambert's formula; components sum to the whole.

use super::*;
use crate::{
    Appearance, Quiet,
    test_scenes::{
        dataset, glossy, illumination, light, mean, plates, polygon_irradiance, rel_rmse, sphere, surface_at, white,
    },
    view::Background,
};
use glam::Vec2;
use lapidary_core::{brdf::GgxParameters, camera::Camera, lights::Emission, material::BrdfModel};
use std::f32::consts::{FRAC_1_PI, PI};

fn dark() -> Illumination {
    illumination([2, 1], |_, _| Vec3::ZERO)
}

fn gray(albedo: f32) -> GgxParameters {
    GgxParameters { base_color: Vec3::splat(albedo), ..white() }
}

fn view(eye: Vec3, target: Vec3, fov: f32, size: u32) -> View {
    View { background: Background::Flat(Vec3::ZERO), ..View::new(Camera::look_at(eye, target, fov), [size, size]) }
}

fn only(components: &str, bounces: u32, spp: u32) -> PathSettings {
    PathSettings { bounces, components: components.parse().unwrap(), ..PathSettings::direct(spp) }
}

/// Jacquez and Kuppenheim 1955: each bounce in a sphere spreads evenly, so irradiance follows the geometric series.
#[test]
fn bounces_in_a_closed_sphere_follow_the_geometric_series() {
    let albedo = 0.6_f32;
    let renderer = Renderer::new(dataset(sphere(24), gray(albedo)));
    let lamp = [light(Emission::Point, Vec3::ZERO, Vec3::ZERO, PI)];
    let view = view(Vec3::new(0.1, 0.0, 0.0), Vec3::X, 60.0, 12);
    let indirect =
        |bounces, spp| mean(&renderer.path_reference(&view, &dark(), &lamp, only("indirect", bounces, spp), &Quiet));
    let direct = mean(&renderer.path_reference(&view, &dark(), &lamp, only("direct", 5, 4), &Quiet));
    assert!((direct / albedo - 1.0).abs() < 0.01, "{direct}");
    let series = |bounces: i32| albedo * (1..=bounces).map(|k| albedo.powi(k)).sum::<f32>();
    for bounces in [1, 2, 3, 9] {
        let found = indirect(bounces, 64);
        let error = |bounces: u32| (found / series(bounces as i32) - 1.0).abs();
        assert!(error(bounces) < 0.02, "{bounces} bounces: {found} of {}", series(bounces as i32));
        assert!(bounces > 3 || error(bounces + 1) > 0.08, "negative control: one bounce more");
    }
    assert_eq!(indirect(0, 4), 0.0);
    let endless = indirect(60, 64);
    assert!((endless / (albedo * albedo / (1.0 - albedo)) - 1.0).abs() < 0.03, "{endless}");
}

#[test]
fn walls_that_absorb_nothing_end_and_stay_finite() {
    let renderer = Renderer::new(dataset(sphere(12), white()));
    let lamp = [light(Emission::Point, Vec3::ZERO, Vec3::ZERO, PI)];
    let view = view(Vec3::new(0.1, 0.0, 0.0), Vec3::X, 60.0, 8);
    let picture = renderer.path_reference(&view, &dark(), &lamp, only("direct,indirect", 10_000, 16), &Quiet);
    assert!(picture.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
    assert!(mean(&picture) > 10.0, "{}", mean(&picture));
}

/// A lamp lights only the wall, so the floor shows the wall's form factor.
#[test]
fn one_bounce_from_a_wall_is_its_form_factor() {
    let albedo = 0.8;
    let renderer = Renderer::new(dataset(plates(), gray(albedo)));
    let along = [light(Emission::PARALLEL, Vec3::new(1.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.0), 2.0)];
    let view = view(Vec3::new(1.0, 3.0, 0.01), Vec3::new(1.0, 0.0, 0.0), 25.0, 12);
    let picture = renderer.path_reference(&view, &dark(), &along, only("indirect", 1, 1024), &Quiet);
    let expected = |top: f32| {
        let wall = [(0.0, -1.0), (top, -1.0), (top, 1.0), (0.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z));
        let at = |x: u32, y: u32| {
            let direction = view.camera.direction_through(Vec2::new(x as f32, y as f32) + 0.5, view.size);
            let floor = view.camera.eye - direction * (view.camera.eye.y / direction.y);
            let irradiance = albedo * 2.0 * FRAC_1_PI * polygon_irradiance(&wall, floor, Vec3::Y) as f32;
            Vec3::splat(albedo * FRAC_1_PI * irradiance)
        };
        mean(&Image::from_fn(view.size, at))
    };
    let error = |top: f32| (mean(&picture) / expected(top) - 1.0).abs();
    assert!(error(1.0) < 0.02, "{} of {}", mean(&picture), expected(1.0));
    assert!(error(0.8) > 0.04, "negative control: a wall of four fifths, {}", error(0.8));
    let direct = renderer.path_reference(&view, &dark(), &along, only("direct", 1, 1), &Quiet);
    assert_eq!(mean(&direct), 0.0, "the light grazes the floor");
}

/// The floor shows the form factor of an emissive black wall, by samples of the wall and of the BRDF.
#[test]
fn a_wall_that_shines_lights_the_floor_by_its_form_factor() {
    let (albedo, shines) = (0.8, 3.0);
    let mut mesh = plates();
    let half = mesh.triangles.len() / 2;
    mesh.triangle_material[half..].fill(1);
    let mut dataset = dataset(mesh, gray(albedo));
    let mut lamp = dataset.scene.materials[0].clone();
    lamp.parameters = gray(0.0).into();
    lamp.parameters.set("emission_luminance", shines);
    dataset.scene.materials.push(lamp);
    let renderer = Renderer::new(dataset);
    let view = view(Vec3::new(1.0, 3.0, 0.01), Vec3::new(1.0, 0.0, 0.0), 25.0, 12);
    let wall = [(0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z));
    let at = |x: u32, y: u32| {
        let direction = view.camera.direction_through(Vec2::new(x as f32, y as f32) + 0.5, view.size);
        let floor = view.camera.eye - direction * (view.camera.eye.y / direction.y);
        Vec3::splat(albedo * FRAC_1_PI * shines * polygon_irradiance(&wall, floor, Vec3::Y) as f32)
    };
    let expected = mean(&Image::from_fn(view.size, at));
    let shown = |components, bounces| {
        mean(&renderer.path_reference(&view, &dark(), &[], only(components, bounces, 256), &Quiet))
    };
    let error = |expected: f32| (shown("indirect", 1) / expected - 1.0).abs();
    assert!(error(expected) < 0.02, "{} of {expected}", shown("indirect", 1));
    assert!(error(1.1 * expected) > 0.05, "negative control: a brighter wall");
    assert_eq!(shown("indirect", 0), 0.0, "a bounce carries it");
    let at_wall = self::view(Vec3::new(1.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.0), 25.0, 4);
    let seen = |components| renderer.path_reference(&at_wall, &dark(), &[], only(components, 0, 4), &Quiet).pixels[5];
    assert!((seen("direct") - shines).abs().max_element() < 1e-5, "it is seen with the local lights");
    assert_eq!(seen("environment"), Vec3::ZERO);
}

#[test]
fn a_wall_that_is_assigned_a_material_that_shines_lights_as_one_of_the_mesh() {
    let mut own = dataset(plates(), gray(0.8));
    let mut lamp = own.scene.materials[0].clone();
    lamp.parameters.set("emission_luminance", 3.0);
    own.scene.materials.push(lamp);
    let mut assigned = own.scene.mesh.triangle_material.clone();
    let half = assigned.len() / 2;
    assigned[half..].fill(1);
    let mut of_mesh = own.clone();
    of_mesh.scene.mesh.triangle_material.clone_from(&assigned);
    let mut renderer = Renderer::new(own);
    let view = view(Vec3::new(1.0, 3.0, 0.01), Vec3::new(1.0, 0.0, 0.0), 25.0, 12);
    let shown = |renderer: &Renderer| renderer.path_reference(&view, &dark(), &[], only("indirect", 1, 16), &Quiet);
    assert_eq!(mean(&shown(&renderer)), 0.0, "negative control: nothing shines");
    let appearance = Appearance { assigned: Some(assigned.into()), ..Appearance::of(&renderer.dataset().scene) };
    renderer.set_appearance(appearance);
    let expected = shown(&Renderer::new(of_mesh));
    assert!(mean(&expected) > 0.0 && shown(&renderer) == expected);
}

#[test]
fn components_sum_to_the_whole() {
    let mut dataset = dataset(plates(), GgxParameters { roughness: 0.4, ..gray(0.7) });
    dataset.scene.materials[0].model = BrdfModel::Ggx;
    let renderer = Renderer::new(dataset);
    let sky = illumination([16, 8], |x, y| Vec3::new(0.3, 0.1, if (x, y) == (4, 2) { 9.0 } else { 0.1 }));
    let rectangle = Emission::Rectangle { width: 0.5, height: 0.5 };
    let lamps = [
        light(Emission::Point, Vec3::new(0.5, 0.7, 0.3), Vec3::ZERO, 0.2),
        light(rectangle, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.8, 0.0, 0.0), 2.0),
    ];
    // Mirrored light is a bounce in paths of bounced light, and part of the others where they are alone.
    let view = View { mirrors: false, ..view(Vec3::new(2.5, 1.5, 0.4), Vec3::new(0.3, 0.3, 0.0), 40.0, 12) };
    let of = |names| {
        let picture = renderer.path_reference(&view, &sky, &lamps, only(names, 2, 512), &Quiet);
        picture.pixels.iter().sum::<Vec3>() / picture.pixels.len() as f32
    };
    let parts = ["environment", "direct", "indirect"].map(of);
    let (whole, sum) = (of("environment,direct,indirect"), parts.into_iter().sum::<Vec3>());
    assert!((sum / whole - 1.0).abs().max_element() < 0.02, "{parts:?} and {whole}");
    assert!(parts.iter().all(|p| p.x > 0.02 * whole.x), "each part is there: {parts:?}");
    assert!((of("direct,indirect") + parts[0] - whole).abs().max_element() < 0.02 * whole.max_element());
}

/// The mean over samples of light and BRDF is the integral over the rectangle, for mirrors and for diffuse surfaces.
#[test]
fn rectangles_in_highlights_are_integrated_exactly() {
    let rectangle = Emission::Rectangle { width: 1.2, height: 0.6 };
    let lamps = [light(rectangle, Vec3::new(0.2, 1.2, 0.1), Vec3::new(0.9, 0.0, 0.0), 3.0)];
    let view = view(Vec3::new(2.2, 1.5, 0.0), Vec3::new(1.2, 0.0, 0.0), 1.0, 1);
    for roughness in [0.1, 0.3, 0.7] {
        let mut dataset = dataset(plates(), glossy(roughness));
        dataset.scene.materials[0].model = BrdfModel::Ggx;
        let renderer = Renderer::new(dataset);
        let point = surface_at(&renderer, &view);
        let n = 400;
        let at = |i: u32| (i as f32 + 0.5) / n as f32;
        let integral = (0..n * n).map(|i| {
            let sample = lamps[0].sample(point.ray_origin, Vec2::new(at(i % n), at(i / n))).unwrap();
            let wi = point.world_from_local.transpose() * sample.direction;
            f64::from((point.brdf.as_brdf().brdf_cos(wi, point.wo) * sample.irradiance).x)
        });
        let expected = (integral.sum::<f64>() / f64::from(n * n)) as f32;
        let found = mean(&renderer.path_reference(&view, &dark(), &lamps, PathSettings::direct(20_000), &Quiet));
        assert!((found / expected - 1.0).abs() < 0.02, "{roughness}: {found} of {expected}");
        assert!((0.95 * found / expected - 1.0).abs() > 0.025, "negative control: five percent are seen");
        let deterministic = mean(&renderer.direct_light(&View { aa: 16, ..view.clone() }, &lamps));
        assert!((deterministic / expected - 1.0).abs() < 0.05, "{roughness}: {deterministic} of {expected}");
    }
}

#[test]
fn one_of_many_lights_at_a_time_gives_the_mean_of_all() {
    let renderer = Renderer::new(dataset(plates(), gray(0.8)));
    let mut rng = fastrand::Rng::with_seed(3);
    let mut lamps = Vec::new();
    for _ in 0..50 {
        let position = Vec3::new(0.2 + 1.6 * rng.f32(), 0.5 + rng.f32(), rng.f32() - 0.5);
        lamps.push(light(Emission::Point, position, Vec3::ZERO, 0.1 + rng.f32()));
    }
    let view = view(Vec3::new(1.0, 3.0, 0.01), Vec3::new(1.0, 0.0, 0.0), 1.0, 1);
    let expected = mean(&renderer.direct_light(&view, &lamps));
    let found = mean(&renderer.path_reference(&view, &dark(), &lamps, PathSettings::direct(20_000), &Quiet));
    assert!((found / expected - 1.0).abs() < 0.03, "{found} of {expected}");
    lamps.truncate(45);
    let fewer = mean(&renderer.direct_light(&view, &lamps));
    assert!((fewer / expected - 1.0).abs() > 0.04, "negative control: {fewer}");
}

/// A sunlit sheet on black. Four shared positions per pixel misplace its edges alike in all pictures; shifted ones find its share
/// of the pixels, and pictures with other first paths show the error.
#[test]
fn shifted_places_see_whole_pixels_and_their_misses_are_noise() {
    let renderer = Renderer::new(dataset(plates(), gray(0.5)));
    let sun = [light(Emission::PARALLEL, Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 0.0, 0.0), 2.0)];
    let view = view(Vec3::new(1.0, 40.0, 0.01), Vec3::new(1.0, 0.0, 0.0), 5.0, 12);
    let trace = |positions, spp, first_pass, aa| {
        let settings = PathSettings { positions, first_pass, ..PathSettings::direct(spp) };
        renderer.path_reference(&View { aa, ..view.clone() }, &dark(), &sun, settings, &Quiet)
    };
    let truth = trace(SamplePositions::Shared, 16_384, 0, 16_384);
    let apart = rel_rmse;
    let [shared, shifted] =
        [SamplePositions::Shared, SamplePositions::Shifted].map(|positions| trace(positions, 1024, 0, 4));
    let (of_shared, of_shifted) = (apart(&shared, &truth), apart(&shifted, &truth));
    assert!(
        of_shifted < 0.1 * of_shared,
        "negative control: {of_shared} by shared positions, {of_shifted} by shifted ones"
    );
    let elsewhere = trace(SamplePositions::Shifted, 1024, 1024, 4);
    assert!(apart(&elsewhere, &shifted) > 0.7 * of_shifted, "what is missed differs from picture to picture");
    assert_eq!(
        trace(SamplePositions::Shared, 1024, 1024, 4),
        shared,
        "negative control: no other first path moves shared positions"
    );
}
