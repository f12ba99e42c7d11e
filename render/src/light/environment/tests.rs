//! Suns of an environment: energy under rotation, and pictures against light paths of the whole map.

use super::*;
use crate::{
    Backend, Baked, Components, CpuBackend, LitScene, Look, PathSettings, Quiet, Renderer, View,
    test_scenes::{dataset, illumination, mesh, plates, rel_rmse, white},
    view::Background,
};
use lapidary_core::{
    camera::Camera,
    dataset::Dataset,
    environment::{texel_direction, texel_solid_angle},
    image::Image,
};
use std::f32::consts::PI;

const SIZE: [u32; 2] = [1024, 512];

/// Radiance of the sky: small, because the few vertices of these scenes interpolate it.
const SKY: f32 = 0.05;

/// A gray sky with a sun `degrees` wide that gives a surface facing it this `irradiance`.
fn sunny(toward: Vec3, degrees: f32, irradiance: f32) -> Illumination {
    let radius = (0.5 * degrees).to_radians();
    let radiance = irradiance / (PI * radius.sin().powi(2));
    let is_sun = |x, y| texel_direction(x, y, SIZE).angle_between(toward) < radius;
    let sky = |x, y| Vec3::splat(if is_sun(x, y) { radiance } else { SKY });
    Illumination { sun: Some(SunSettings::default()), ..illumination(SIZE, sky) }
}

fn without_suns(light: &Illumination) -> Illumination {
    Illumination { sun: None, ..light.clone() }
}

fn picture(dataset: &Dataset, view: &View, light: &Illumination) -> Image {
    let backend: Box<dyn Backend> = Box::new(CpuBackend::new());
    let look = Look { tau: 0.0, ..Look::under_environment(&dataset.scene, view.clone(), light.clone()) };
    LitScene::new(backend, Baked::from(dataset.clone())).unwrap().show_whole(&look).unwrap().image
}

/// Light on a horizontal floor under the whole sky, from samples and suns.
fn on_the_ground(rig: &mut LightRig, light: &Illumination) -> f64 {
    let lighting = rig.lighting(light, 16);
    let leaves = lighting.nodes.radiance.len() / 2;
    let directions = rig.samples.tree.leaf_directions().iter();
    let sampled = directions.zip(&lighting.nodes.radiance[leaves..]).map(|(d, l)| f64::from(d.y.max(0.0) * l.x));
    let of_suns = light.suns().into_iter().map(|sun| f64::from(-sun.forward().unwrap().y.min(0.0) * sun.intensity.x));
    sampled.sum::<f64>() * f64::from(lighting.lights.leaf_solid_angle) + of_suns.sum::<f64>()
}

#[test]
fn a_rotation_keeps_the_light() {
    let light = sunny(Vec3::new(0.3, 0.5, -0.6).normalize(), 0.53, 3.0);
    let tree = LightTree::geometric(4096).unwrap();
    let mut rig = LightRig::new(&tree);
    let at = |rig: &mut LightRig, degrees: u32, light: &Illumination| {
        let turned = Illumination { rotation: (degrees as f32).to_radians(), ..light.clone() };
        on_the_ground(rig, &turned)
    };
    let all: Vec<f64> = (0..360).step_by(7).map(|degrees| at(&mut rig, degrees, &light)).collect();
    let (least, most) = all.iter().fold((f64::MAX, 0.0_f64), |(a, b), &x| (a.min(x), b.max(x)));
    assert!(most / least - 1.0 < 1e-3, "{least} to {most}");
    // Samples alone change as the sun moves between them.
    let plain = without_suns(&light);
    let all: Vec<f64> = (0..360).step_by(7).map(|degrees| at(&mut rig, degrees, &plain)).collect();
    let (least, most) = all.iter().fold((f64::MAX, 0.0_f64), |(a, b), &x| (a.min(x), b.max(x)));
    assert!(most / least - 1.0 > 1e-3, "negative control: {least} to {most}");
}

#[test]
fn the_whole_light_is_that_of_the_map() {
    let light =
        Illumination { intensity: 2.0, rotation: 1.0, ..sunny(Vec3::new(-0.5, 0.8, 0.1).normalize(), 3.0, 3.0) };
    let [sun] = &light.suns()[..] else { panic!("one sun") };
    let turned = Quat::from_rotation_y(1.0) * Vec3::new(-0.5, 0.8, 0.1).normalize();
    assert!((-sun.forward().unwrap()).angle_between(turned) < 2e-3);
    // The disc in the map has steps.
    assert!((sun.intensity.x / 6.0 - 1.0).abs() < 0.04, "{}", sun.intensity);
    assert!(without_suns(&light).suns().is_empty() && Arc::ptr_eq(&without_suns(&light).sampled(), &light.environment));
    assert!(!light.is_same(&without_suns(&light)));
    let mut rig = LightRig::new(&LightTree::geometric(4096).unwrap());
    let texel = |i: u32| {
        let (x, y) = (i % SIZE[0], i / SIZE[0]);
        let light = light.environment.map.at(x as usize, y as usize).x * texel_solid_angle(y, SIZE);
        f64::from(2.0 * light * texel_direction(x, y, SIZE).y.max(0.0))
    };
    let expected: f64 = (0..SIZE[0] * SIZE[1]).map(texel).sum();
    let found = on_the_ground(&mut rig, &light);
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} of {expected}");
}

/// The wall shades half of the floor; its height decides which points are lit.
#[test]
fn shadows_are_as_sharp_as_the_sun() {
    let data = dataset(plates(), white());
    let camera = Camera::look_at(Vec3::new(1.0, 8.0, 0.01), Vec3::new(1.0, 0.0, 0.0), 14.0);
    let view = View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [64, 64]) };
    // Light from above the wall at 45 degrees: the shadow ends in the middle of the floor.
    let light = sunny(Vec3::new(-1.0, 1.0, 0.0).normalize(), 2.0, 3.0);
    let settings =
        PathSettings { components: Components { environment: true, ..Components::NONE }, ..PathSettings::direct(256) };
    let paths = Renderer::new(data.clone()).path_reference(&view, &light, &[], settings, &Quiet);
    let error = |light: &Illumination| rel_rmse(&picture(&data, &view, light), &paths);
    let (sharp, spread) = (error(&light), error(&without_suns(&light)));
    assert!(sharp < 0.06 && spread > 3.0 * sharp, "{sharp}, with samples alone {spread}");
}

#[test]
fn references_of_samples_have_the_suns_too() {
    let data = dataset(mesh(4, true), white());
    let camera = Camera::look_at(Vec3::new(3.0, 3.0, 0.01), Vec3::ZERO, 30.0);
    let view = View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [24, 24]) };
    let light = sunny(Vec3::new(0.2, 1.0, 0.3).normalize(), 1.0, 3.0);
    let renderer = Renderer::new(data.clone());
    let samples = renderer.samples_reference(&view, &light, &Quiet);
    let found = rel_rmse(&picture(&data, &view, &light), &samples);
    assert!(found < 0.05, "{found}");
    let rest = Illumination { environment: light.sampled(), sun: None, ..light };
    let control = rel_rmse(&renderer.samples_reference(&view, &rest, &Quiet), &samples);
    assert!(control > 4.0 * found, "negative control: {control} without the sun");
}
