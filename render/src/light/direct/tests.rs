//! Direct light of local lights against closed forms, and scenes that the tests of paths share.

use super::*;
use crate::{
    Renderer, View,
    renderer::tests::{dataset, from_above, mesh, white},
    shade::surface::FirstHit,
};
use glam::Vec4;
use lapidary_core::{
    image::Image,
    lights::{Emission, RectangleShape},
    scene::Mesh,
};
use std::f32::consts::{FRAC_1_PI, PI};

pub(crate) fn light(emission: Emission, position: Vec3, target: Vec3, intensity: f32) -> Light {
    let intensity = Vec3::splat(intensity);
    Light { name: String::new(), enabled: true, emission, position, target, intensity }
}

pub(crate) fn mean(image: &Image) -> f32 {
    image.pixels.iter().map(|p| p.x).sum::<f32>() / image.pixels.len() as f32
}

/// The surface at the middle of a view.
pub(crate) fn surface_at(renderer: &Renderer, view: &View) -> SurfacePoint {
    let direction = view.camera.direction_through(0.5 * Vec2::new(view.size[0] as f32, view.size[1] as f32), view.size);
    match renderer.surfaces().seen_along(view.camera.eye, direction) {
        FirstHit::Surface(point) => *point,
        _ => panic!("the view looks at a surface"),
    }
}

/// Adds a parallelogram; the normal is the cross product of its edges.
fn add_quad(mesh: &mut Mesh, corner: Vec3, u: Vec3, v: Vec3) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([corner, corner + u, corner + u + v, corner + v]);
    mesh.normals.extend([u.cross(v).normalize(); 4]);
    mesh.tangents.extend([u.normalize().extend(1.0); 4]);
    mesh.uvs.extend([Vec2::ZERO; 4]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh.triangle_material.extend([0; 2]);
    mesh.triangle_object.extend([0; 2]);
}

/// A floor over x in [0, 2] and z in [-1, 1], and a wall of height 1 over its edge at x = 0.
pub(crate) fn plates() -> Mesh {
    let mut mesh = Mesh::default();
    add_quad(&mut mesh, Vec3::new(0.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X);
    add_quad(&mut mesh, Vec3::new(0.0, 0.0, -1.0), Vec3::Y, 2.0 * Vec3::Z);
    mesh
}

/// A unit sphere seen from inside, of `rows` from pole to pole.
pub(crate) fn sphere(rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let columns = 2 * rows;
    for (row, column) in (0..=rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let (theta, phi) = (PI * row as f32 / rows as f32, 2.0 * PI * column as f32 / columns as f32);
        let p = Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos());
        mesh.positions.push(p);
        mesh.normals.push(-p);
        mesh.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
        mesh.uvs.push(Vec2::ZERO);
    }
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let at = |r: u32, c: u32| r * columns + c % columns;
        let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        if row + 1 < rows {
            mesh.triangles.push([a, c, b]);
        }
        if row > 0 {
            mesh.triangles.push([a, d, c]);
        }
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh.triangle_object = vec![0; mesh.triangles.len()];
    mesh
}

/// Irradiance under a polygon of unit radiance that lies above the horizon (Lambert 1760).
pub(crate) fn polygon_irradiance(corners: &[Vec3], point: Vec3, normal: Vec3) -> f64 {
    let edge = |a: Vec3, b: Vec3| {
        let (a, b) = ((a - point).normalize().as_dvec3(), (b - point).normalize().as_dvec3());
        let across = a.cross(b).try_normalize();
        across.map_or(0.0, |n| a.dot(b).clamp(-1.0, 1.0).acos() * n.dot(normal.as_dvec3()))
    };
    let around = (0..corners.len()).map(|i| edge(corners[i], corners[(i + 1) % corners.len()])).sum::<f64>();
    (0.5 * around).abs()
}

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
    let sun = light(Emission::Directional, Vec3::new(3.0, 4.0, 0.0), Vec3::ZERO, 2.0);
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
    // The underside of the blocker lies in the plane of the lamp.
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
    assert_ne!(pixel_shift(3, 5, 0), pixel_shift(3, 5, 1));
}

#[test]
fn a_lambert_floor_reflects_a_third_of_its_irradiance_as_radiance() {
    let renderer = Renderer::new(dataset(mesh(4, false), white()));
    let point = surface_at(&renderer, &from_above(1));
    let sun = [light(Emission::Directional, Vec3::Y, Vec3::ZERO, 1.0)];
    let radiance = direct_light(&point, &sun, &renderer.intersector, Vec2::ZERO);
    assert!((radiance - FRAC_1_PI).abs().max_element() < 1e-4, "{radiance}");
}
