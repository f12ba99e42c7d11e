//! Direct light of local lights against closed forms.

use super::*;
use crate::{
    Renderer, View,
    shade::{
        background::{Backdrop, BlurCache},
        pixel_sampler::PixelSampler,
    },
    test_scenes::{dataset, from_above, light, mean, mesh, polygon_irradiance, surface_at, white},
};
use lapidary_core::{
    brdf::GgxParameters,
    camera::Camera,
    lights::{Emission, RectangleShape},
};
use std::f32::consts::{FRAC_1_PI, PI};

/// Irradiance at the middle of a white floor.
fn irradiance_below(lights: &[Light], blocker: bool) -> f32 {
    let renderer = Renderer::new(dataset(mesh(4, blocker), white()));
    let mut view = from_above(1);
    if blocker {
        view.camera.eye = Vec3::new(2.5, 0.9, 0.01);
    }
    PI * mean(&renderer.direct_light(&view, lights))
}

#[test]
fn lights_without_extent_are_exact() {
    let point = light(Emission::Point, Vec3::new(1.0, 2.0, 0.0), Vec3::ZERO, 3.0);
    let expected = 3.0 / 5.0 * 2.0 / 5.0_f32.sqrt();
    let found = irradiance_below(std::slice::from_ref(&point), false);
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} of {expected}");
    let sun = light(Emission::PARALLEL, Vec3::new(3.0, 4.0, 0.0), Vec3::ZERO, 2.0);
    assert!((irradiance_below(std::slice::from_ref(&sun), false) / 1.6 - 1.0).abs() < 1e-3);
    let both = irradiance_below(&[point.clone(), sun.clone()], false);
    assert!((both / (expected + 1.6) - 1.0).abs() < 2e-3, "{both}");
    let off = Light { enabled: false, ..sun };
    assert_eq!(irradiance_below(&[off], false), 0.0);
    let below = Light { position: Vec3::new(0.0, -1.0, 0.0), ..point };
    assert_eq!(irradiance_below(&[below], false), 0.0, "from under the floor");
}

#[test]
fn only_what_is_before_a_light_shades_it() {
    let at =
        |height: f32| irradiance_below(&[light(Emission::Point, Vec3::new(0.0, height, 0.0), Vec3::ZERO, 1.0)], true);
    assert!((at(0.5) / 4.0 - 1.0).abs() < 0.01, "under the blocker: {}", at(0.5));
    assert_eq!(at(2.0), 0.0, "over the blocker");
    assert_eq!(at(0.9995), 0.0, "inside the blocker, between its two faces");
}

#[test]
fn a_rectangle_gives_lamberts_irradiance_also_in_the_surface_of_its_lamp() {
    let lamp = light(Emission::Rectangle { width: 0.8, height: 0.5 }, Vec3::new(0.0, 0.999, 0.0), Vec3::ZERO, 2.0);
    let corners = RectangleShape::of(&lamp).unwrap().corners();
    let expected = 2.0 * polygon_irradiance(&corners, Vec3::ZERO, Vec3::Y) as f32;
    let lamps = [lamp];
    // The underside of the blocker lies in the lamp's plane.
    for blocker in [false, true] {
        let found = irradiance_below(&lamps, blocker);
        assert!((found / expected - 1.0).abs() < 0.02, "blocker {blocker}: {found} of {expected}");
    }
    let larger = [Light { emission: Emission::Rectangle { width: 0.84, height: 0.5 }, ..lamps[0].clone() }];
    let control = irradiance_below(&larger, false);
    assert!((control / expected - 1.0).abs() > 0.03, "negative control, five percent more width: {control}");
}

#[test]
fn shifts_of_pixels_fill_the_square_and_differ_between_samples() {
    let shifts: Vec<Vec2> = (0..32).flat_map(|y| (0..32).map(move |x| pixel_shift(x, y, 0))).collect();
    let mean = shifts.iter().sum::<Vec2>() / shifts.len() as f32;
    assert!((mean - 0.5).abs().max_element() < 0.03, "{mean}");
    let quarter = shifts.iter().filter(|s| s.max_element() < 0.5).count() as f32 / shifts.len() as f32;
    assert!((quarter - 0.25).abs() < 0.06, "{quarter}");
    assert!(shifts.iter().all(|s| s.min_element() >= 0.0 && s.max_element() < 1.0));
    // A pixel's next sample continues after the cells of the previous one.
    let next = (pixel_shift(3, 5, 0) + STEP * (CELLS * CELLS) as f32).fract();
    assert!((pixel_shift(3, 5, 1) - next).abs().max_element() < 1e-5, "{next}");
}

#[test]
fn a_lambert_floor_reflects_a_third_of_its_irradiance_as_radiance() {
    let renderer = Renderer::new(dataset(mesh(4, false), white()));
    let point = surface_at(&renderer, &from_above(1));
    let sun = [light(Emission::PARALLEL, Vec3::Y, Vec3::ZERO, 1.0)];
    let radiance =
        DirectLights { lights: &sun, intersector: renderer.intersector() }.shader().reflected(&point, Vec2::ZERO);
    assert!((radiance - FRAC_1_PI).abs().max_element() < 1e-4, "{radiance}");
}

/// Adjacent points in the rows of a view.
fn eights(renderer: &Renderer, view: &View) -> Vec<Vec<SurfacePoint>> {
    let backdrop = Backdrop::new(view, None, false, &mut BlurCache::default());
    let sampler = PixelSampler::new(renderer, view, &backdrop);
    let point = |x, y| sampler.sight(x, y, 0).surface().cloned();
    let row = |y| (0..view.size[0]).filter_map(|x| point(x, y)).collect::<Vec<_>>();
    (0..view.size[1]).flat_map(|y| row(y).chunks(8).map(<[_]>::to_vec).collect::<Vec<_>>()).collect()
}

#[test]
fn lights_that_are_known_to_be_seen_or_hidden_are_as_rays_have_them() {
    let renderer = Renderer::new(dataset(mesh(4, true), GgxParameters { roughness: 0.1, ..white() }));
    let view =
        View { camera: Camera::look_at(Vec3::new(2.5, 0.9, 1.0), Vec3::new(0.0, 0.0, 0.0), 70.0), ..from_above(48) };
    let eights = eights(&renderer, &view);
    let sun = |angle_degrees| Emission::Directional { angle_degrees };
    let from = Vec3::new(1.0, 2.0, 0.3);
    let lights = [
        light(sun(0.53), from, Vec3::ZERO, 2.0),
        light(sun(12.0), from, Vec3::ZERO, 2.0),
        light(Emission::PARALLEL, from, Vec3::ZERO, 2.0),
        light(Emission::Point, Vec3::new(0.4, 1.9, 0.2), Vec3::ZERO, 2.0),
        light(Emission::Rectangle { width: 0.3, height: 0.3 }, from, Vec3::ZERO, 2.0),
    ];
    for light in lights {
        let shader = |lights| DirectLights { lights, intersector: renderer.intersector() }.shader();
        let light = [light];
        let moved = [Light { position: light[0].position - Vec3::X, ..light[0].clone() }];
        let [by_rays, otherwise] = [shader(&light), shader(&moved)];
        let (mut known, mut rest, mut wrong_if_moved) = ([0; 2], 0, 0);
        let mut blockers = Vec::new();
        for eight in &eights {
            let points: EightPoints = std::array::from_fn(|i| eight.get(i));
            let (seen, of_moved) = (by_rays.lights_seen(&points), otherwise.lights_seen(&points));
            for (i, point) in eight.iter().enumerate() {
                let all = by_rays.reflected(point, Vec2::splat(0.4));
                assert_eq!(by_rays.reflected_beside(point, Vec2::splat(0.4), seen[i], &mut blockers), all, "{light:?}");
                wrong_if_moved +=
                    usize::from(by_rays.reflected_beside(point, Vec2::splat(0.4), of_moved[i], &mut blockers) != all);
                match seen[i].of(0) {
                    Some(is_seen) => known[usize::from(is_seen)] += 1,
                    None => rest += 1,
                }
            }
        }
        match light[0].emission {
            Emission::Rectangle { .. } => assert_eq!(known, [0; 2]),
            _ => assert!(known.iter().all(|&count| count > 5) && known[1] > 4 * rest, "{known:?}, {rest}: {light:?}"),
        }
        assert!(
            wrong_if_moved > 10 || known == [0; 2],
            "negative control, another light: {wrong_if_moved}, {known:?}, {light:?}"
        );
    }
}

#[test]
fn eight_places_at_once_are_those_of_the_cells() {
    for shift in [Vec2::ZERO, Vec2::new(0.3, 0.9), Vec2::splat(0.999)] {
        let cells = cells(shift).map(|(corner, shift)| (corner + shift) / CELLS as f32);
        let eights = [0, 1].map(|half| cells_x8::<f32x8>(shift, half).map(|axis| axis.to_array()));
        let at = |cell: usize| eights[cell / 8].map(|axis| axis[cell % 8]);
        assert!((0..ALL_CELLS).all(|cell| (Vec2::from(at(cell)) - cells[cell]).length() < 1e-5), "{shift}");
        assert!((Vec2::from(at(8)) - cells[0]).length() > 1e-2, "negative control: another cell");
    }
}
