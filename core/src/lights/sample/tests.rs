//! Irradiance of lights against closed forms.

use super::*;

fn light(emission: Emission, position: Vec3, target: Vec3) -> Light {
    Light { emission, position, target, intensity: Vec3::new(3.0, 2.0, 1.0), ..Default::default() }
}

fn irradiance(light: &Light, point: Vec3) -> f32 {
    light.sample(point, Vec2::splat(0.5)).map_or(0.0, |s| s.irradiance.x)
}

/// Irradiance on a surface with a normal, by a regular grid of samples.
fn received(light: &Light, point: Vec3, normal: Vec3) -> f64 {
    const N: u32 = 64;
    let at = |i: u32| (i as f32 + 0.5) / N as f32;
    let one = |u| light.sample(point, u).map_or(0.0, |s| s.irradiance.x * s.direction.dot(normal).max(0.0));
    let all = (0..N * N).map(|i| f64::from(one(Vec2::new(at(i % N), at(i / N))))).sum::<f64>();
    all / f64::from(N * N)
}

/// Lambert's formula (1760): the irradiance under a polygon of unit radiance, all of it above the horizon.
fn lambert(corners: &[Vec3], point: Vec3, normal: Vec3) -> f64 {
    let edge = |a: Vec3, b: Vec3| {
        let (a, b) = ((a - point).normalize().as_dvec3(), (b - point).normalize().as_dvec3());
        a.dot(b).clamp(-1.0, 1.0).acos() * a.cross(b).normalize().dot(normal.as_dvec3())
    };
    let around = (0..corners.len()).map(|i| edge(corners[i], corners[(i + 1) % corners.len()])).sum::<f64>();
    (0.5 * around).abs()
}

#[test]
fn point_light_falls_with_the_square_of_the_distance() {
    let light = light(Emission::Point, Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO);
    assert_eq!(irradiance(&light, Vec3::ZERO), 0.75);
    assert!((irradiance(&light, Vec3::new(0.0, -2.0, 0.0)) / 0.1875 - 1.0).abs() < 1e-6);
    let sample = light.sample(Vec3::new(2.0, 0.0, 0.0), Vec2::ZERO).unwrap();
    assert!((sample.direction - Vec3::new(-1.0, 1.0, 0.0).normalize()).length() < 1e-6);
    assert!((sample.distance - 8.0_f32.sqrt()).abs() < 1e-6 && sample.pdf.is_infinite());
    assert!(light.sample(light.position, Vec2::ZERO).is_none(), "at the light itself");
    assert!(Light { enabled: false, ..light }.sample(Vec3::ZERO, Vec2::ZERO).is_none());
}

#[test]
fn a_spot_fades_from_the_penumbra_to_its_edge() {
    let emission = Emission::Spot { cone_degrees: 40.0, penumbra_degrees: 15.0 };
    let spot = light(emission, Vec3::ZERO, Vec3::NEG_Y);
    let at = |degrees: f32| irradiance(&spot, Vec3::new(degrees.to_radians().sin(), -degrees.to_radians().cos(), 0.0));
    assert!((at(0.0) - 3.0).abs() < 1e-5 && (at(24.9) - 3.0).abs() < 1e-4);
    assert_eq!((at(40.1), at(90.0), at(180.0)), (0.0, 0.0, 0.0));
    let falling_off: Vec<f32> = (0..=14).map(|i| at(25.2 + i as f32)).collect();
    assert!(falling_off.windows(2).all(|w| w[0] > w[1]), "{falling_off:?}");
    let sharp = light(Emission::Spot { cone_degrees: 40.0, penumbra_degrees: 0.0 }, Vec3::ZERO, Vec3::NEG_Y);
    let inside = Vec3::new(39.9_f32.to_radians().sin(), -39.9_f32.to_radians().cos(), 0.0);
    assert!((irradiance(&sharp, inside) - 3.0).abs() < 1e-4);
}

#[test]
fn directional_light_is_the_same_everywhere() {
    let sun = light(Emission::PARALLEL, Vec3::new(5.0, 5.0, 0.0), Vec3::ZERO);
    for point in [Vec3::ZERO, Vec3::new(1e3, -7.0, 2.0), sun.position] {
        let sample = sun.sample(point, Vec2::ZERO).unwrap();
        assert_eq!((sample.irradiance, sample.distance), (sun.intensity, f32::INFINITY));
        assert!((sample.direction - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6);
    }
}

#[test]
fn a_rectangle_gives_what_lamberts_formula_says() {
    let emission = Emission::Rectangle { width: 1.5, height: 0.8 };
    let lamp = light(emission, Vec3::new(0.3, 2.0, -0.4), Vec3::new(0.5, 0.0, 0.2));
    let corners = RectangleShape::of(&lamp).unwrap().corners();
    for (point, normal) in [
        (Vec3::ZERO, Vec3::Y),
        (Vec3::new(1.0, 0.2, 0.7), Vec3::Y),
        (Vec3::new(-0.5, 0.1, 0.4), Vec3::new(0.3, 1.0, -0.2).normalize()),
    ] {
        let expected = 3.0 * lambert(&corners, point, normal);
        let found = received(&lamp, point, normal);
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} of {expected}");
        let smaller = light(Emission::Rectangle { width: 1.485, height: 0.8 }, lamp.position, lamp.target);
        let control = received(&smaller, point, normal);
        assert!((control / expected - 1.0).abs() > 5e-3, "negative control: one percent less width, {control}");
    }
}

#[test]
fn from_afar_a_rectangle_is_a_point_with_a_cosine() {
    let lamp = light(Emission::Rectangle { width: 0.2, height: 0.1 }, Vec3::ZERO, Vec3::NEG_Y);
    let point = Vec3::new(30.0, -40.0, 0.0);
    let far = 3.0 * 0.02 * 0.8 / 2500.0; // radiance, area, cosine, squared distance
    assert!((irradiance(&lamp, point) / far - 1.0).abs() < 1e-4);
    assert_eq!(irradiance(&lamp, Vec3::new(1.0, 2.0, 0.0)), 0.0, "one-sided");
    assert_eq!(irradiance(&lamp, Vec3::new(5.0, 0.0, 0.0)), 0.0, "in its plane");
}

#[test]
fn rays_meet_rectangles_with_the_density_that_samples_have() {
    let lamp = light(Emission::Rectangle { width: 1.5, height: 0.8 }, Vec3::new(0.3, 2.0, -0.4), Vec3::ZERO);
    for u in [Vec2::splat(0.5), Vec2::new(0.1, 0.9), Vec2::new(0.8, 0.3)] {
        let sample = lamp.sample(Vec3::X, u).unwrap();
        let hit = lamp.intersect(Vec3::X, sample.direction).unwrap();
        assert!((hit.pdf / sample.pdf - 1.0).abs() < 1e-4 && (hit.distance / sample.distance - 1.0).abs() < 1e-5);
        assert!((hit.radiance / hit.pdf / sample.irradiance - 1.0).abs().max_element() < 1e-4);
    }
    assert!(lamp.intersect(Vec3::X, Vec3::NEG_Y).is_none());
    let point = light(Emission::Point, Vec3::Y, Vec3::ZERO);
    assert!(point.intersect(Vec3::ZERO, Vec3::Y).is_none(), "a point has no extent");
}

#[test]
fn power_is_what_a_sphere_around_receives_at_most() {
    let spot = light(Emission::Spot { cone_degrees: 90.0, penumbra_degrees: 0.0 }, Vec3::ZERO, Vec3::Y);
    let point = light(Emission::Point, Vec3::ZERO, Vec3::Y);
    assert!((2.0 * spot.power_bound(1.0) / point.power_bound(1.0) - 1.0).abs() < 1e-6);
    assert_eq!(Light { enabled: false, ..point }.power_bound(1.0), 0.0);
}
