//! Bumps seen from afar, against the mean over all their normals, against light paths through whole pixels, and while the map moves
//! under the pixels; normal maps that their slots turn and mirror.

use super::*;
use crate::{
    Background, BrdfSampling, PathSettings, Renderer, SamplePositions, View,
    appearance::ResolvedAppearance,
    light::{components::Components, environment::Illumination},
    shade::{
        background::{Backdrop, BlurCache},
        painter::{Painter, PictureLight, SeenOfParts},
        pixel_sampler::PixelSampler,
        surface::SurfacePoint,
    },
    stale::LightPart,
    test_scenes::{dataset, illumination, mesh, rel_rmse},
    view::Quiet,
};
use lapidary_core::{
    brdf::GgxParameters,
    camera::Camera,
    environment::texel_direction,
    image::Image,
    material::{BUMP, BrdfModel, Maps, Material, NORMAL},
    simd::Vec3x8,
    texture::{Texels, Texture, TextureSlot, UvFootprint},
};
use std::{f32::consts::PI, sync::Arc};
use wide::f32x8;

const SIZE: u32 = 128;

/// Heights of waves with fixed directions and phases. They repeat, and slope by about 0.2 at a height of 1 and a width of 1.
fn height(x: f32, y: f32) -> f32 {
    let wave =
        |a: f32, b: f32, phase: f32| (std::f32::consts::TAU * (a * x + b * y) + phase).sin() / (a * a + b * b).sqrt();
    let all = wave(9.0, 2.0, 0.3) + wave(-4.0, 11.0, 1.9) + wave(7.0, 7.0, 4.0) + wave(1.0, -13.0, 2.2);
    0.03 * all
}

fn heights() -> Texture {
    let at = |i: u32| [height((i % SIZE) as f32 / SIZE as f32, (i / SIZE) as f32 / SIZE as f32); 4];
    Texture::new("waves", [SIZE; 2], Texels::F32((0..SIZE * SIZE).map(at).collect()))
}

/// The normals of [`heights`].
fn normals() -> Texture {
    let texel = |i: u32| {
        let (x, y, d) = ((i % SIZE) as f32 / SIZE as f32, (i / SIZE) as f32 / SIZE as f32, 1e-3);
        let along = |a: f32, b: f32| (height(x + a, y + b) - height(x - a, y - b)) / (2.0 * d);
        let n = Vec3::new(-along(d, 0.0), -along(0.0, d), 1.0).normalize();
        (0.5 * n + 0.5).extend(1.0).to_array()
    };
    Texture::new("normals", [SIZE; 2], Texels::F32((0..SIZE * SIZE).map(texel).collect()))
}

/// A place on the plane z = 0, with one unit of u and v per meter.
fn place(uv: UvFootprint) -> SurfacePlace {
    let (smooth_normal, tangent, slopes) = (Vec3::Z, Vec3::X, [Some([Vec3::X, Vec3::Y]); 2]);
    let attributes = uv.into();
    SurfacePlace { position: Vec3::ZERO, smooth_normal, tangent, handedness: 1.0, attributes, slopes }
}

fn look(model: BrdfModel, roughness: f32, map: &'static str, slot: TextureSlot) -> Appearance {
    let parameters = GgxParameters { base_color: Vec3::ONE, metalness: 1.0, roughness, ..Default::default() };
    let material =
        Material { model, parameters: parameters.into(), maps: Maps::from([(map, slot)]), ..Default::default() };
    let texture = if map == BUMP { heights() } else { normals() };
    Appearance { materials: vec![material], textures: vec![Arc::new(texture)], assigned: None }
}

/// BRDF times cosine of a place for light from a world direction.
fn reflected(appearance: &ResolvedAppearance, uv: UvFootprint, wo: Vec3, wi: Vec3, with_slopes: bool) -> f32 {
    let seen = place(uv).under(appearance, appearance.material(0), wo);
    let slopes = if with_slopes { seen.slopes } else { [0.0; 3] };
    let wi = Vec3x8::splat(seen.world_from_local.transpose() * wi);
    seen.material.brdf.spread_cos_x8(wi, seen.wo, f32x8::ZERO, slopes).lane(0).y
}

#[test]
fn a_footprint_reflects_as_the_mean_of_all_its_normals_do() {
    let whole = UvFootprint { uv: Vec2::splat(0.5), changes: [2.0 * Vec2::X, 2.0 * Vec2::Y] };
    let texels = || (0..SIZE * SIZE).map(|i| (Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5) / SIZE as f32);
    let wo = Vec3::new(0.4, 0.1, 1.0).normalize();
    // The sum of the waves is nearly Gaussian, like Beckmann's facets; GGX has longer tails.
    for (model, bound) in [(BrdfModel::Beckmann, 0.12), (BrdfModel::Ggx, 0.25)] {
        for map in [NORMAL, BUMP] {
            let appearance = look(model, 0.35, map, TextureSlot::default()).into();
            let (mut error, mut unwidened, mut sum) = (0.0, 0.0, 0.0);
            for (x, y) in [(0.0, 0.0), (-0.4, -0.1), (0.1, 0.3), (-0.8, 0.2), (-0.5, -0.5)] {
                let wi = Vec3::new(x, y, 1.0).normalize();
                let all: f32 = texels().map(|uv| reflected(&appearance, uv.into(), wo, wi, true)).sum();
                let expected = all / (SIZE * SIZE) as f32;
                error += (reflected(&appearance, whole, wo, wi, true) - expected).powi(2);
                unwidened += (reflected(&appearance, whole, wo, wi, false) - expected).powi(2);
                sum += expected * expected;
            }
            let [error, unwidened] = [error, unwidened].map(|e| (e / sum).sqrt());
            assert!(error < bound, "{model:?} {map}: {error}");
            assert!(unwidened > 4.0 * error, "negative control, {model:?} {map}: {unwidened}");
        }
    }
}

#[test]
fn drawn_normals_have_the_covariance_that_they_are_drawn_from() {
    let appearance = look(BrdfModel::Ggx, 0.3, NORMAL, TextureSlot::default());
    let renderer = scene(appearance, 1.0).0;
    let view = view();
    let backdrop = Backdrop::black();
    let sampler = PixelSampler::new(&renderer, &view, &backdrop);
    let mut point = None;
    sampler.sample(20, 20, 0, |seen| {
        point = Some(SurfacePoint { slopes: [0.04, 0.01, 0.02], ..seen.clone() });
        Vec3::ZERO
    });
    let point = point.unwrap();
    let mut sums = [0.0; 3];
    let random = &mut fastrand::Rng::with_seed(5);
    let count = 20_000;
    for _ in 0..count {
        let drawn = point.with_one_normal([random.f32(), random.f32()]);
        let n = point.world_from_local.transpose() * drawn.world_from_local.z_axis;
        let slope = n.truncate() / n.z;
        let products = [slope.x * slope.x, slope.x * slope.y, slope.y * slope.y];
        sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += 2.0 * product / count as f32);
    }
    let expected = point.slopes;
    assert!(sums.iter().zip(expected).all(|(sum, expected)| (sum - expected).abs() < 0.001), "{sums:?}");
    assert_eq!(point.with_one_normal([0.5, 0.5]).slopes, [0.0; 3]);
}

/// A floor with the map under a small bright light, seen from `distance` times the map's design distance.
fn scene(mut appearance: Appearance, distance: f32) -> (Renderer, Illumination) {
    for slot in appearance.materials[0].maps.slots_mut() {
        slot.scale = Vec2::splat(0.75 * distance);
    }
    let mut dataset = dataset(mesh(8, false), GgxParameters::default());
    (dataset.scene.materials, dataset.scene.textures) = (appearance.materials, appearance.textures);
    let size = [256, 128];
    let toward = Vec3::new(0.1, 0.8, -1.0).normalize();
    let light = illumination(size, |x, y| {
        let cosine = texel_direction(x, y, size).dot(toward);
        Vec3::splat(0.2 + 60.0 * ((cosine - 1.0) / (0.08 * 0.08)).exp())
    });
    (Renderer::new(dataset), light)
}

fn view() -> View {
    let camera = Camera::look_at(Vec3::new(0.0, 2.4, 3.0), Vec3::new(0.0, 0.0, 0.1), 24.0);
    View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [48, 48]) }
}

#[derive(Clone, Copy, PartialEq)]
enum Filter {
    /// Point lookups.
    None,
    /// Mean normals.
    Means,
    /// Mean normals, and lobes widened by the spread of the normals.
    Slopes,
}

fn picture(renderer: &Renderer, light: &Illumination, view: &View, filter: Filter) -> Image {
    let lighting = renderer.lighting(light, 256);
    let lit = PictureLight { environment: Some(&lighting), ..Default::default() };
    let backdrop = Backdrop::new(view, Some(light), true, &mut BlurCache::default());
    let mut sampler = PixelSampler::new(renderer, view, &backdrop);
    if filter == Filter::None {
        sampler = sampler.unfiltered(renderer);
    }
    let mut painter = Painter::new(view, renderer.dataset(), lit, BrdfSampling::Lit);
    Image::from_fn(view.size, |x, y| {
        sampler.pixel(x, y, |point| match filter {
            Filter::Means => painter.part(
                LightPart::Environment,
                &SurfacePoint { slopes: [0.0; 3], ..point.clone() },
                Vec2::ZERO,
                SeenOfParts::default(),
            ),
            _ => painter.part(LightPart::Environment, point, Vec2::ZERO, SeenOfParts::default()),
        })
    })
}

fn by_paths(renderer: &Renderer, light: &Illumination, view: &View, spp: u32) -> Image {
    let components = Components { environment: true, ..Components::ALL };
    let settings = PathSettings { positions: SamplePositions::Shifted, components, ..PathSettings::direct(spp) };
    renderer.path_reference(view, light, &[], settings, &Quiet)
}

const FILTERS: [Filter; 3] = [Filter::None, Filter::Means, Filter::Slopes];

/// Relative RMSE of each filter against paths, and RMS change between frames as a share of the mean while the camera moves by
/// thirds of a pixel.
fn errors(map: &'static str, roughness: f32, distance: f32, spp: u32) -> ([f64; 3], [f64; 3]) {
    // Heights shrink with the map, so slopes stay the same.
    let strength = if map == BUMP { 1.0 / (0.75 * distance) } else { 1.0 };
    let slot = TextureSlot { strength, ..Default::default() };
    let (renderer, light) = scene(look(BrdfModel::Ggx, roughness, map, slot), distance);
    let reference = by_paths(&renderer, &light, &view(), spp);
    let error = FILTERS.map(|filter| rel_rmse(&picture(&renderer, &light, &view(), filter), &reference));
    let change = FILTERS.map(|filter| {
        let frame = |i: u32| {
            let mut view = view();
            view.camera.eye.x += 0.009 * i as f32;
            picture(&renderer, &light, &view, filter)
        };
        let frames: Vec<Image> = (0..4).map(frame).collect();
        frames.windows(2).map(|pair| rel_rmse(&pair[1], &pair[0])).sum::<f64>() / 3.0
    });
    (error, change)
}

#[test]
fn highlights_of_bumps_are_near_those_of_paths_and_stay_as_the_camera_moves() {
    for map in [NORMAL, BUMP] {
        let ([none, means, slopes], [flicker, _, still]) = errors(map, 0.3, 8.0, 64);
        assert!(slopes < 0.3 && slopes < 0.25 * none && slopes < 0.15 * means, "{map}: {none} {means} {slopes}");
        assert!(still < 0.2 * flicker, "{map}: {flicker} {still}");
    }
}

/// Prints the figures of `docs/results.md`.
#[test]
fn slopes_help_at_every_distance() {
    println!("distance: error of points, means, slopes; change of points, means, slopes");
    for distance in [1.0, 2.0, 4.0, 16.0] {
        let (error, change) = errors(NORMAL, 0.3, distance, 256);
        println!("{distance}: {error:.3?} {change:.3?}");
        let ([none, means, slopes], [flicker, _, still]) = (error, change);
        assert!(slopes < 0.35 && slopes < 0.4 * none && slopes < 0.4 * means, "{distance}: {error:?}");
        assert!(still < 0.6 * flicker, "{distance}: {change:?}");
    }
}

/// A place on a quad in z = 0 as in the files of glTF: u along +X, v along -Y.
fn quad(uv: UvFootprint) -> SurfacePlace {
    SurfacePlace { slopes: [Some([Vec3::X, Vec3::NEG_Y]); 2], ..place(uv) }
}

fn with_normals(texture: Texture, slot: TextureSlot) -> ResolvedAppearance {
    let mut appearance = look(BrdfModel::Lambert, 0.5, NORMAL, slot);
    appearance.textures = vec![Arc::new(texture)];
    appearance.into()
}

fn normal_at(appearance: &ResolvedAppearance, uv: UvFootprint) -> Vec3 {
    quad(uv).under(appearance, appearance.material(0), Vec3::Z).world_from_local.z_axis
}

#[test]
fn normals_that_lean_along_the_picture_turn_with_it_near_and_far() {
    let leaning = || {
        let texel = (0.5 * Vec3::new(0.6, 0.0, 0.8) + 0.5).extend(1.0).to_array();
        Texture::new("leaning", [4; 2], Texels::F32(vec![texel; 16]))
    };
    let mirrored = Vec2::new(-1.0, 1.0);
    let near = UvFootprint::from(Vec2::new(0.3, 0.8));
    let far = UvFootprint { changes: [0.7 * Vec2::X, 0.9 * Vec2::Y], ..near };
    for (rotation, scale) in [(0.0, Vec2::ONE), (0.5 * PI, Vec2::ONE), (PI, Vec2::ONE), (0.0, mirrored)] {
        // The direction on the quad in which the picture's u grows.
        let along = Vec3::new(scale.x * rotation.cos(), -rotation.sin(), 0.0);
        let slot = TextureSlot { rotation, scale, ..Default::default() };
        let appearance = with_normals(leaning(), slot);
        let upright = with_normals(leaning(), TextureSlot::default());
        // Levels are rounded to the upper 16 bits of floats.
        for (footprint, bound) in [(near, 1e-5), (far, 4e-3)] {
            let expected = 0.6 * along + 0.8 * Vec3::Z;
            let error = |appearance: &ResolvedAppearance| (normal_at(appearance, footprint) - expected).length();
            assert!(error(&appearance) < bound, "{rotation} {scale}: {}", normal_at(&appearance, footprint));
            let is_upright = along.x > 0.9;
            assert_eq!(error(&upright) < bound, is_upright, "negative control, {rotation} {scale}");
        }
    }
}

/// Normals of a dome beside the middle of a picture, which the slot then shows upright: the picture holds it turned.
fn dome(slot: &TextureSlot) -> Texture {
    let texel = |i: u32| {
        let there = (Vec2::new((i % SIZE) as f32, (i / SIZE) as f32) + 0.5) / SIZE as f32;
        // Where the slot shows this texel.
        let uv = slot.linear().inverse() * (there - slot.offset);
        let from_top = uv - Vec2::new(0.4, 0.55);
        let steep = if from_top.length() < 0.3 { 4.0 } else { 0.0 };
        // The gradient in the picture's own coordinates.
        let gradient = slot.linear().inverse().transpose() * (-steep * from_top);
        (0.5 * Vec3::new(-gradient.x, gradient.y, 1.0).normalize() + 0.5).extend(1.0).to_array()
    };
    Texture::new("dome", [SIZE; 2], Texels::F32((0..SIZE * SIZE).map(texel).collect()))
}

#[test]
fn a_turned_dome_in_a_turned_picture_is_lit_as_the_upright_dome() {
    let wo = Vec3::Z;
    let wi = Vec3::new(0.75, 0.2, 0.63).normalize();
    let lit = |appearance: &ResolvedAppearance| {
        Image::from_fn([SIZE; 2], |x, y| {
            let uv = (Vec2::new(x as f32, y as f32) + 0.5) / SIZE as f32;
            let seen = quad(uv.into()).under(appearance, appearance.material(0), wo);
            Vec3::splat(seen.world_from_local.z_axis.dot(wi).max(0.0))
        })
    };
    let upright = TextureSlot::default();
    let expected = lit(&with_normals(dome(&upright), upright));
    for slot in [
        TextureSlot { rotation: PI, offset: Vec2::ONE, ..Default::default() },
        TextureSlot { rotation: 0.5 * PI, offset: Vec2::Y, ..Default::default() },
        TextureSlot { scale: Vec2::new(-1.0, 1.0), offset: Vec2::X, ..Default::default() },
        TextureSlot { scale: Vec2::new(1.0, -1.0), rotation: 0.5 * PI, offset: Vec2::ONE, ..Default::default() },
    ] {
        let error = rel_rmse(&lit(&with_normals(dome(&slot), slot.clone())), &expected);
        assert!(error < 1e-3, "{slot:?}: {error}");
        // The same picture as if its normals did not turn.
        let mut untold = dome(&slot);
        let Texels::F32(texels) = &mut untold.texels else { unreachable!() };
        let back = slot.normal_axes().inverse();
        for texel in texels {
            let xy = back * (2.0 * Vec2::new(texel[0], texel[1]) - 1.0);
            [texel[0], texel[1]] = (0.5 * xy + 0.5).to_array();
        }
        let error = rel_rmse(&lit(&with_normals(untold, slot.clone())), &expected);
        assert!(error > 0.1, "negative control, {slot:?}: {error}");
    }
}
