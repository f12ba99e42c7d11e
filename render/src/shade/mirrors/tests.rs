//! What mirrors show, against light paths and known answers.

use super::*;
use crate::{
    Components, Quiet, Renderer,
    cpu::picture::Picture,
    reference::path::settings::PathSettings,
    sampling::BrdfSampling,
    shade::{
        background::Backdrop,
        painter::{Painter, PictureLight},
        pixel_sampler::PixelSampler,
    },
    stale::Marks,
    test_scenes::{
        dataset, from_below, illumination, into_bowl, mean, metal, mirror, mirror_bowl, mirror_under_ball,
        mirror_under_plate, plates, rel_rmse, sphere, toward_mirror,
    },
    view::View,
};
use lapidary_core::{brdf::LambertParameters, camera::Camera, image::Image};

fn view() -> View {
    View { aa: 64, ..toward_mirror([48, 48]) }
}

fn shown(renderer: &Renderer, view: &View) -> Image {
    renderer.render(view, &from_below(), 256, BrdfSampling::Lit).0
}

fn paths(renderer: &Renderer, view: &View) -> Image {
    renderer.path_reference(view, &from_below(), &[], PathSettings::direct(1024), &Quiet)
}

/// Means over blocks of pixels.
fn in_blocks(image: &Image, side: u32) -> Image {
    let mean = |x: u32, y: u32| {
        let of = |i: u32| image.at((x * side + i % side) as usize, (y * side + i / side) as usize);
        (0..side * side).map(of).sum::<Vec3>() / (side * side) as f32
    };
    Image::from_fn(image.size.map(|pixels| pixels / side), mean)
}

/// The picture some pixels to the right.
fn moved(image: &Image, pixels: u32) -> Image {
    let from = |x: u32, y: u32| image.at(x.saturating_sub(pixels) as usize, y as usize);
    Image::from_fn(image.size, from)
}

#[test]
fn a_floor_mirrors_a_plate_as_light_paths_do() {
    // Wider lobes have noise in single pixels, which would hide an error: means over blocks have less.
    for (alpha, block) in [(0.0025, 1), (0.02, 4)] {
        let renderer = Renderer::new(mirror_under_plate(alpha));
        let (view, paths) = (view(), paths(&renderer, &view()));
        let error = |image: &Image| rel_rmse(&in_blocks(image, block), &in_blocks(&paths, block));
        let picture = shown(&renderer, &view);
        let found = error(&picture);
        assert!(found < 0.06, "{alpha}: {found}");
        assert!((mean(&picture) / mean(&paths) - 1.0).abs() < 0.02);
        let without = error(&shown(&renderer, &View { mirrors: false, ..view.clone() }));
        assert!(without > 3.0 * found, "negative control: the map alone, {without}");
        let beside = error(&moved(&picture, block));
        assert!(beside > 1.5 * found, "negative control: edges a pixel away, {beside}");
    }
}

#[test]
fn the_reference_by_samples_shows_the_same() {
    let renderer = Renderer::new(mirror_under_plate(0.0025));
    let samples = renderer.samples_reference(&view(), &from_below(), &Quiet);
    let found = rel_rmse(&shown(&renderer, &view()), &samples);
    assert!(found < 0.02, "{found}");
    let without = rel_rmse(&shown(&renderer, &View { mirrors: false, ..view() }), &samples);
    assert!(without > 0.1, "negative control: {without}");
}

/// What changes from one roughness to the next stays small, up to lobes that show no scene.
#[test]
fn the_change_over_has_no_seam() {
    // The scene fades over the last half.
    let alphas = (0..=24).map(|step| 0.1 + 0.0075 * step as f32);
    let pictures: Vec<Image> =
        alphas.map(|alpha| shown(&Renderer::new(mirror_under_plate(alpha)), &View { aa: 64, ..view() })).collect();
    let steps: Vec<f64> = pictures.windows(2).map(|pair| rel_rmse(&pair[0], &pair[1])).collect();
    let largest = steps.iter().copied().fold(0.0, f64::max);
    assert!(largest < 0.15, "{steps:?}");
    let ends = rel_rmse(&pictures[0], pictures.last().unwrap());
    assert!(ends > 4.0 * largest, "negative control: the scene disappears, {ends}");
}

/// A room of emissive walls that reflect nothing.
fn furnace(emission: f32) -> Renderer {
    let mut mesh = sphere(16);
    let plate = plates();
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(plate.positions.iter().map(|p| 0.3 * *p));
    mesh.normals.extend(&plate.normals);
    mesh.tangents.extend(&plate.tangents);
    mesh.uvs.extend(&plate.uvs);
    mesh.triangles.extend(plate.triangles.iter().map(|t| t.map(|v| v + first)));
    mesh.triangle_material.resize(mesh.triangles.len(), 1);
    mesh.triangle_object.resize(mesh.triangles.len(), 0);
    let mut dataset = dataset(mesh, LambertParameters { base_color: Vec3::ZERO });
    dataset.scene.materials[0].set_emission(Vec3::splat(emission));
    dataset.scene.materials.push(mirror(0.0025));
    Renderer::new(dataset)
}

/// Pictures of light that is not the environment's.
fn picture(renderer: &Renderer, view: &View, emission: bool) -> Image {
    let backdrop = Backdrop::black();
    let sampler = PixelSampler::new(renderer, view, &backdrop);
    let mirrored = SeenScene::in_mirrors(renderer, view, BrdfSampling::Lit, &backdrop);
    let light = PictureLight { emission, mirrored, ..Default::default() };
    let painter = || Painter::new(view, renderer.dataset(), light, BrdfSampling::Lit);
    let mut picture = Picture::new(view.size, light.parts(view.mode), None);
    (0..view.aa).for_each(|sample| picture.add_rows(&sampler, painter, None, sample, 0..view.size[1]));
    picture.read().0
}

fn inside(aa: u32) -> View {
    let camera = Camera::look_at(Vec3::new(0.55, 0.4, 0.1), Vec3::new(0.25, 0.0, 0.0), 60.0);
    View { aa, ..View::new(camera, [24, 24]) }
}

#[test]
fn a_mirror_in_a_furnace_shows_the_furnace() {
    let far = |image: &Image| image.pixels.iter().map(|p| (*p - 1.0).abs().max_element()).fold(0.0, f32::max);
    let renderer = furnace(1.0);
    let image = picture(&renderer, &inside(64), true);
    assert!((mean(&image) - 1.0).abs() < 0.005 && far(&image) < 0.02, "{} {}", mean(&image), far(&image));
    let black = picture(&renderer, &View { mirrors: false, ..inside(4) }, true);
    assert!(far(&black) > 0.9, "negative control: mirrors show no scene");
    assert_eq!(mean(&picture(&renderer, &inside(4), false)), 0.0, "negative control: hits are black");
}

#[test]
fn mirrors_in_a_mirror_room_are_bounded() {
    let mut dataset = dataset(sphere(16), metal(0.0025));
    dataset.scene.materials[0] = mirror(0.0025);
    dataset.scene.materials[0].set_emission(Vec3::ONE);
    let image = picture(&Renderer::new(dataset), &inside(1), true);
    // The surface, and two that mirrors show; a single ray may weigh somewhat more.
    assert!(image.pixels.iter().all(|p| p.is_finite() && p.max_element() < 3.5), "{}", mean(&image));
    assert!(mean(&image) > 2.9, "{}", mean(&image));
}

/// Rays of neighboring samples, from an eye above the pole of a sphere.
#[test]
fn cones_are_as_wide_as_the_rays_of_neighboring_samples_are_apart() {
    let view = View { aa: 4, ..View::new(Camera::look_at(4.0 * Vec3::Y, Vec3::ZERO, 30.0), [100, 100]) };
    let apart = (view.projection().pixel_span(1.0) / 2.0).tan();
    let (eye, distance) = (view.projection().eye, 1.5);
    for radius in [0.2_f32, 1.0] {
        // Where a ray that is tilted by an angle meets the sphere around the origin, and where it goes from there.
        let end = |angle: f32| {
            let direction = Vec3::new(angle, -1.0, 0.0).normalize();
            let (b, c) = (eye.dot(direction), eye.length_squared() - radius * radius);
            let hit = eye + (-b - (b * b - c).sqrt()) * direction;
            let normal = hit / radius;
            hit + distance * (direction - 2.0 * direction.dot(normal) * normal)
        };
        let found = CameraCones::of(&view).to(Vec3::Y * radius).mirrored(radius.recip(), 0.0, distance);
        let expected = end(0.0).distance(end(apart));
        assert!((found.width() / expected - 1.0).abs() < 0.02, "{radius}: {found:?} for {expected}");
        let hollow = CameraCones::of(&view).to(Vec3::Y * radius).mirrored(-radius.recip(), 0.0, distance);
        assert!(hollow.width() < 0.98 * expected, "{hollow:?} of a hollow mirror, behind its focus");
        let flat = CameraCones::of(&view).to(Vec3::Y * radius).mirrored(0.0, 0.0, distance);
        assert!(flat.width() < 0.7 * expected, "negative control: a flat mirror, {flat:?}");
    }
}

/// The floor mirrors the ball, and in it a small lamp of the map, a texel, which no other way leads to the eye. The cones of 16 samples are
/// twice, then four times as wide as the lamp. They find it as four, or 16, times as many narrow rays would: errors are a half, or a
/// quarter, and the bounds are between these and 1.
#[test]
fn a_small_light_in_a_curved_mirror_in_a_mirror_is_no_dot() {
    let renderer = Renderer::new(mirror_under_ball(0.0025));
    let camera = Camera::look_at(Vec3::new(0.0, 1.2, 2.0), Vec3::new(0.0, -0.455, 0.2), 5.56);
    let backdrop = Backdrop::black();
    for (map, radiance, most) in [([256, 128], 3000.0, 0.7), ([512, 256], 12_000.0, 0.45)] {
        let mut squares = [0.0; 2];
        for place in 0..4 {
            let lamp = (map[0] / 2 + place, map[1] * 13 / 32);
            let light = illumination(map, |x, y| Vec3::splat(if (x, y) == lamp { radiance } else { 0.2 }));
            let lighting = renderer.lighting(&light, 256);
            // The first of the samples that a view has: each stands for its part of the picture.
            let shown = |size: [u32; 2], of: u32, samples: u32| {
                let view = View { aa: of, ..View::new(camera.clone(), size) };
                let sampler = PixelSampler::new(&renderer, &view, &backdrop);
                let mirrored = SeenScene::in_mirrors(&renderer, &view, BrdfSampling::Lit, &backdrop);
                let light = PictureLight { environment: Some(&lighting), mirrored, ..Default::default() };
                let painter = || Painter::new(&view, renderer.dataset(), light, BrdfSampling::Lit);
                let mut picture = Picture::new(view.size, light.parts(view.mode), None);
                (0..samples).for_each(|sample| picture.add_rows(&sampler, painter, None, sample, 0..size[1]));
                picture.read().0
            };
            // Four times as fine: no sample of this is among those of the others.
            let truth = in_blocks(&shown([48, 40], 64, 64), 4);
            for (square, of) in squares.iter_mut().zip([16, 4096]) {
                *square += rel_rmse(&shown([12, 10], of, 16), &truth).powi(2);
            }
        }
        let ratio = (squares[0] / squares[1]).sqrt();
        assert!(ratio < most, "{ratio} of the error of narrow cones, the negative control");
    }
}

#[test]
fn scenes_without_sharp_lobes_have_no_mirrors() {
    let marks = |alpha| Renderer::new(mirror_under_plate(alpha)).mirrors;
    assert_eq!(marks(0.3), Marks::default());
    assert_eq!(marks(0.01), Marks::of_materials([0]));
}

/// Light that mirrors show belongs to the kinds of light of the surfaces in them.
#[test]
fn kinds_of_light_in_paths_with_mirrors_sum_to_all_light() {
    let mut shining = mirror_under_plate(0.0025);
    shining.scene.materials[1].set_emission(Vec3::splat(0.5));
    let none = Components::NONE;
    for (dataset, bounces) in [(shining, 2), (mirror_bowl(0.0025), 1), (mirror_bowl(0.0025), 2)] {
        let renderer = Renderer::new(dataset);
        let picture = |mirrors: bool, components: Components| {
            let settings = PathSettings { bounces, components, ..PathSettings::direct(128) };
            let view = View { camera: into_bowl(), mirrors, size: [24, 24], ..view() };
            mean(&renderer.path_reference(&view, &from_below(), &[], settings, &Quiet))
        };
        let all = picture(true, Components::ALL);
        let environment = picture(true, Components { environment: true, ..none });
        let direct = picture(true, Components { direct: true, ..none });
        let indirect = picture(true, Components { indirect: true, ..none });
        let sum = environment + direct + indirect;
        assert!((sum / all - 1.0).abs() < 0.02, "{environment}, {direct} and {indirect} of {all}");
        let twice = environment + direct + picture(false, Components { indirect: true, ..none });
        assert!(
            twice / all > 1.1,
            "negative control: what mirrors show of direct light is there twice, {twice} of {all}"
        );
    }
}
