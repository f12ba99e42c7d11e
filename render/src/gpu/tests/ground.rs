//! A ground as it is shown: by both renderers and by the references.

use super::twin::backend;
use crate::{
    Backend, Background, Components, CpuBackend, Illumination, LitScene, Look, PathSettings, Quiet, View, ViewMode,
    test_scenes::{dataset, illumination, light, mesh, mirror, rel_rmse, white},
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    dataset::Dataset,
    ground::Ground,
    image::Image,
    lights::Emission,
    material::{BrdfModel, Material},
    scene::Mesh,
};
use std::f32::consts::PI;

/// A blocker above a floor, which is the ground.
fn scene() -> Dataset {
    let whole = mesh(24, true);
    let mut floor = mesh(24, false);
    let (v, t) = (floor.positions.len(), floor.triangles.len());
    floor.triangle_material.fill(1);
    let mut blocker = Mesh {
        positions: whole.positions[v..].to_vec(),
        normals: whole.normals[v..].to_vec(),
        tangents: whole.tangents[v..].to_vec(),
        uvs: whole.uvs[v..].to_vec(),
        triangles: whole.triangles[t..].iter().map(|corners| corners.map(|i| i - v as u32)).collect(),
        triangle_material: whole.triangle_material[t..].to_vec(),
        triangle_object: whole.triangle_object[t..].to_vec(),
        ..Default::default()
    };
    blocker.append_ground(floor);
    let mut dataset = dataset(blocker, white());
    dataset.scene.materials.push(Material {
        model: BrdfModel::Lambert,
        parameters: white().into(),
        ..Default::default()
    });
    dataset
}

/// A gray sky, brighter on one side, above a darker and patterned lower half.
fn sky() -> Illumination {
    illumination([64, 32], |x, y| {
        let above = 0.4 + 0.02 * x as f32;
        Vec3::splat(if y < 16 { above } else { 0.2 + 0.1 * (x % 4) as f32 })
    })
}

fn look(ground: Ground, background: Background) -> Look {
    let camera = Camera::look_at(Vec3::new(0.3, 2.5, 4.0), Vec3::new(0.0, 0.2, 0.0), 40.0);
    let view = View { ground, background, aa: 2, ..View::new(camera, [40, 32]) };
    let sun = light(Emission::PARALLEL, Vec3::new(1.0, 3.0, 0.5), Vec3::ZERO, 1.5);
    let components = Components { environment: true, direct: true, ..Components::NONE };
    Look { lights: [sun].into(), components, ..Look::under_environment(&scene().scene, view, sky()) }
}

/// Picture and coverage on every renderer that there is.
fn pictures(look: &Look) -> Vec<(Image, Vec<f32>)> {
    let picture = |backend: Box<dyn Backend>| {
        let mut scene = LitScene::new(backend, scene().into()).unwrap();
        let finished = scene.show_whole(look).unwrap();
        (finished.image, finished.coverage)
    };
    let cpu = picture(Box::new(CpuBackend::new()));
    let gpu = backend().map(|(_one, gpu)| picture(Box::new(gpu)));
    std::iter::once(cpu).chain(gpu).collect()
}

fn zipped(a: &Image, b: &Image, f: impl Fn(Vec3, Vec3) -> Vec3) -> Image {
    Image { size: a.size, pixels: a.pixels.iter().zip(&b.pixels).map(|(&a, &b)| f(a, b)).collect() }
}

/// Pixels of which all samples see the ground.
fn shows_ground(pixels: usize) -> Vec<bool> {
    let seen = |ground| pictures(&look(ground, Background::Transparent)).remove(0).1;
    let (with, without) = (seen(Ground::On), seen(Ground::Off));
    assert_eq!(with.len(), pixels);
    with.iter().zip(&without).map(|(with, without)| *with == 1.0 && *without == 0.0).collect()
}

fn largest_difference(a: &Image, b: &Image, counts: &[bool]) -> f32 {
    let difference = |(a, b): (&Vec3, &Vec3)| (*a - *b).abs().max_element();
    let counted = a.pixels.iter().zip(&b.pixels).zip(counts).filter(|(_, counts)| **counts);
    counted.map(|(pair, _)| difference(pair)).fold(0.0, f32::max)
}

#[test]
fn a_ground_that_catches_shadows_is_the_background_times_its_share_of_the_light() {
    let environment = Background::Environment;
    // A white surface tells its irradiance, and a hidden one what is behind it.
    let [surface, behind, caught] =
        [Ground::On, Ground::Off, Ground::Shadow].map(|ground| pictures(&look(ground, environment)));
    let unshadowed = sky().environment.irradiance_from_above();
    let counts = shows_ground(surface[0].0.pixels.len());
    assert!(counts.iter().filter(|counts| **counts).count() > 300);
    for ((surface, behind), caught) in surface.iter().zip(&behind).zip(&caught) {
        let expected = zipped(&surface.0, &behind.0, |surface, behind| surface * PI / unshadowed * behind);
        // The background changes between the samples of a pixel.
        let difference = largest_difference(&expected, &caught.0, &counts);
        assert!(difference < 0.03, "{difference}");
        let control = largest_difference(&surface.0, &caught.0, &counts);
        assert!(control > 0.3, "negative control: {control}");
    }
}

#[test]
fn with_an_alpha_channel_a_ground_darkens_what_a_picture_is_laid_over() {
    let over = |plate: f32| {
        let laid = pictures(&look(Ground::Shadow, Background::Transparent)).into_iter().map(|(image, coverage)| {
            let pixels = image.pixels.iter().zip(&coverage).map(|(c, alpha)| *c + (1.0 - alpha) * plate).collect();
            (Image { size: image.size, pixels }, coverage)
        });
        laid.collect::<Vec<_>>()
    };
    for plate in [0.0, 0.2, 0.7] {
        let expected = pictures(&look(Ground::Shadow, Background::Flat(Vec3::splat(plate))));
        for ((laid, coverage), (expected, _)) in over(plate).iter().zip(&expected) {
            // Where local lights shine, more light arrives than from the environment alone, which no coverage can tell.
            let is_darker = |i: usize| expected.pixels[i].x <= plate || coverage[i] == 1.0;
            let counts: Vec<bool> = (0..coverage.len()).map(is_darker).collect();
            assert!(largest_difference(laid, expected, &counts) < 2e-3);
            assert!(counts.iter().filter(|counts| **counts).count() > 100);
            let shadow = coverage.iter().filter(|coverage| (0.2..0.95).contains(*coverage)).count();
            assert!(shadow > 10, "{shadow} pixels with a shadow");
        }
    }
}

/// The ground polished, so that it reflects the blocker over what it catches; without lamps.
fn polished(background: Background) -> Look {
    let mut look = Look { lights: [].into(), ..look(Ground::Shadow, background) };
    look.appearance.materials[1] = mirror(0.0025);
    look.appearance.materials[1].parameters.set("base_color", Vec3::splat(0.4));
    look
}

#[test]
fn a_polished_ground_reflects_over_what_it_catches() {
    let environment = Background::Environment;
    let plain = pictures(&Look { lights: [].into(), ..look(Ground::Shadow, environment) });
    let shown = pictures(&polished(environment));
    for ((shown, _), (plain, _)) in shown.iter().zip(&plain) {
        let differs = |(a, b): &(&Vec3, &Vec3)| (**a - **b).abs().max_element() > 0.02;
        let changed = shown.pixels.iter().zip(&plain.pixels).filter(differs).count();
        assert!((20..600).contains(&changed), "{changed} pixels show the plate, and no others differ");
    }
    for ((gpu, _), (cpu, _)) in shown.iter().skip(1).zip(&shown) {
        // The GPU takes the mean of the samples so far for the light that a reflection hides.
        let found = rel_rmse(gpu, cpu);
        assert!(found < 0.03, "{found}");
        let control = rel_rmse(&plain[0].0, cpu);
        assert!(control > 0.045, "negative control: no reflection, {control}");
    }
}

/// Of a matte blocker, and of a mirror.
#[test]
fn light_paths_show_what_a_polished_ground_reflects() {
    for blocker in [None, Some(mirror(0.0025))] {
        let mut look = polished(Background::Environment);
        look.view.aa = 16;
        look.appearance.materials[0] = blocker.unwrap_or_else(|| look.appearance.materials[0].clone());
        let settings = PathSettings { components: look.components, ..PathSettings::direct(1024) };
        let renderer = look.renderer(&scene().into());
        let paths = renderer.path_reference(&look.view, &look.illumination, &[], settings, &Quiet);
        let shown = pictures(&look);
        let mut plain = look.clone();
        plain.view.mirrors = false;
        let (plain, _) = &pictures(&plain)[0];
        let changes = zipped(&shown[0].0, plain, |shown, plain| {
            Vec3::splat(f32::from(u8::from((shown - plain).abs().max_element() > 0.015)))
        });
        let there = |image: &Image| zipped(image, &changes, |pixel, changes| pixel * changes);
        let control = rel_rmse(&there(plain), &there(&paths));
        for (shown, _) in &shown {
            let found = rel_rmse(&there(shown), &there(&paths));
            assert!(2.0 * found < control && control > 0.02, "{found}; negative control, no reflection: {control}");
        }
    }
}

#[test]
fn reflections_of_a_ground_are_in_the_alpha() {
    let plate = 0.3;
    let expected = pictures(&polished(Background::Flat(Vec3::splat(plate))));
    for ((image, coverage), (expected, _)) in pictures(&polished(Background::Transparent)).iter().zip(&expected) {
        let pixels = image.pixels.iter().zip(coverage).map(|(c, alpha)| *c + (1.0 - alpha) * plate).collect();
        let laid = Image { size: image.size, pixels };
        let difference = largest_difference(&laid, expected, &vec![true; coverage.len()]);
        assert!(difference < 4e-3, "{difference}");
        let without = largest_difference(image, expected, &vec![true; coverage.len()]);
        assert!(without > 0.1, "negative control: not laid over anything, {without}");
    }
}

#[test]
fn light_of_one_color_gives_an_open_ground_no_coverage() {
    let red = illumination([8, 4], |_, _| Vec3::X);
    let transparent = Look { illumination: red, lights: [].into(), ..look(Ground::Shadow, Background::Transparent) };
    let counts = shows_ground(transparent.view.size.iter().product::<u32>() as usize);
    for (_, coverage) in pictures(&transparent) {
        let of_ground = || coverage.iter().zip(&counts).filter(|(_, counts)| **counts).map(|(coverage, _)| *coverage);
        let open = of_ground().filter(|coverage| *coverage < 0.05).count();
        assert!(open > 100, "{open} of {}", of_ground().count());
        assert!(of_ground().any(|coverage| coverage > 0.08), "and in the shadow some");
    }
}

#[test]
fn without_an_environment_a_ground_is_a_surface() {
    let lamps = Components { direct: true, ..Components::NONE };
    let [shadow, surface] =
        [Ground::Shadow, Ground::On].map(|ground| Look { components: lamps, ..look(ground, Background::Environment) });
    for ((shadow, _), (surface, _)) in pictures(&shadow).iter().zip(&pictures(&surface)) {
        assert_eq!(shadow.pixels, surface.pixels);
        assert!(surface.pixels.iter().any(|pixel| pixel.x > 0.1));
    }
    // Also after it was switched off, when pixels keep what the edit leaves.
    let both = Components { environment: true, ..lamps };
    let toggled = |backend: Box<dyn Backend>| {
        let mut scene = LitScene::new(backend, scene().into()).unwrap();
        scene.show_whole(&Look { components: both, ..shadow.clone() }).unwrap();
        scene.show_whole(&shadow).unwrap().image
    };
    let gpu = backend().map(|(_one, gpu)| toggled(Box::new(gpu)));
    let toggled = std::iter::once(toggled(Box::new(CpuBackend::new()))).chain(gpu);
    for (toggled, (fresh, _)) in toggled.zip(&pictures(&shadow)) {
        assert!(rel_rmse(&toggled, fresh) < 1e-4);
    }
    // A part of a picture with an environment adds up with the others.
    let part = |components, hides_background| {
        let look = look(Ground::Shadow, Background::Environment);
        let view = View { hides_background, ..look.view.clone() };
        pictures(&Look { components, view, ..look })
    };
    let sky = Components { direct: false, ..both };
    for (((all, _), (sky, _)), (lamps, _)) in part(both, false).iter().zip(&part(sky, false)).zip(&part(lamps, true)) {
        let sum = zipped(sky, lamps, |sky, lamps| sky + lamps);
        assert!(largest_difference(&sum, all, &vec![true; all.pixels.len()]) < 1e-4);
    }
}

#[test]
fn sketches_leave_the_ground_out_of_pictures_with_an_alpha_channel() {
    let look = look(Ground::Shadow, Background::Transparent);
    let size = look.view.size;
    let sketch = |backend: Box<dyn Backend>| {
        let baked: crate::Baked = scene().into();
        let mut scene = LitScene::new(backend, baked).unwrap();
        scene.light(&look).unwrap();
        scene.begin(&look.view, look.sampling).unwrap();
        let tiles = crate::Tiles::of(size);
        let all: Vec<u32> = (0..tiles.count()).collect();
        scene.sketch(crate::STRIDES[0], &all).unwrap();
        scene.fill(0).unwrap();
        scene.display(&look.post).unwrap()
    };
    let cpu = sketch(Box::new(CpuBackend::new()));
    let gpu = backend().map(|(_one, gpu)| sketch(Box::new(gpu)));
    let counts = shows_ground((size[0] * size[1]) as usize);
    for shown in std::iter::once(cpu).chain(gpu) {
        let opaque = shown.iter().zip(&counts).filter(|(shown, counts)| **counts && shown[3] == 255).count();
        let ground = counts.iter().filter(|counts| **counts).count();
        assert!(10 * opaque < ground, "{opaque} of {ground} are opaque");
    }
}

#[test]
fn a_hidden_ground_shows_what_is_behind_it_and_from_below_the_scene() {
    let hidden = pictures(&look(Ground::Off, Background::Flat(Vec3::X)));
    let counts = shows_ground(hidden[0].0.pixels.len());
    for (picture, _) in &hidden {
        let flat = Image::filled(picture.size, Vec3::X);
        assert_eq!(largest_difference(picture, &flat, &counts), 0.0);
    }
    for ground in Ground::ALL {
        let mut below = look(ground, Background::Transparent);
        below.view.camera = Camera::look_at(Vec3::new(0.01, -3.0, 0.0), Vec3::Y, 40.0);
        below.view.mode = ViewMode::Normals;
        for (picture, coverage) in pictures(&below) {
            let [width, height] = picture.size.map(|side| side as usize);
            let middle = height / 2 * width + width / 2;
            assert!((picture.pixels[middle] - Vec3::new(0.5, 0.0, 0.5)).length() < 1e-3, "{}", picture.pixels[middle]);
            assert_eq!((coverage[middle], coverage[0]), (1.0, 0.0), "{ground}");
        }
    }
}

#[test]
fn references_have_the_same_ground() {
    let look = Look {
        components: Components { environment: true, ..Components::NONE },
        ..look(Ground::Shadow, Background::Environment)
    };
    let baked = scene().into();
    let renderer = look.renderer(&baked);
    let samples = renderer.samples_reference(&look.view, &look.illumination, &Quiet);
    let settings = PathSettings { components: look.components, ..PathSettings::direct(256) };
    let paths = renderer.path_reference(&look.view, &look.illumination, &[], settings, &Quiet);
    let surface = Look { view: View { ground: Ground::On, ..look.view.clone() }, ..look.clone() };
    for ((picture, _), (surface, _)) in pictures(&look).iter().zip(&pictures(&surface)) {
        for (name, reference, most) in [("samples", &samples, 0.03), ("paths", &paths, 0.04)] {
            let (error, control) = (rel_rmse(picture, reference), rel_rmse(surface, reference));
            assert!(error < most, "{name}: {error}");
            assert!(control > 5.0 * most, "negative control, {name}: {control}");
        }
    }
}
