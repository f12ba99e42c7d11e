//! Known answers for one bounce: a wall of known radiosity lights a floor by Lambert's formula for polygons, and the sources on it
//! receive the computed light of lamps and environment. Each test has a negative control.

use super::*;
use crate::{
    Appearance, Backend, BounceLight, BrdfSampling, Components, CpuBackend, EnvironmentLight, Illumination,
    LocalLighting, Renderer, View, ViewMode,
    shade::surface::Surfaces,
    test_scenes::{
        Edited, LIGHTS, SIDE_LOG2, SOURCES, WALL, floor_and_wall, from_above, from_the_side, illumination, light,
        point_light, seen,
    },
};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::GgxParameters,
    cut::{solid_angle, solid_angle_code},
    dataset::BakeParts,
    image::Image,
    lights::{Emission, Light},
    material::{BrdfModel, Material},
    sources::Source,
};
use std::f32::consts::PI;

/// Irradiance at a point of the floor under the wall at radiance 1 (Lambert's formula).
fn form_factor(p: Vec3) -> f32 {
    let corners = WALL.map(|w| (w - p).normalize());
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        a.dot(b).acos() * a.cross(b).normalize().y
    };
    0.5 * (0..4).map(edge).sum::<f32>().abs()
}

fn sources_of(baked: &Baked) -> Edited<SourceRig> {
    Edited::new(baked, SourceRig::new(baked).expect("it has sources"))
}

const INDIRECT: Components = Components { indirect: true, ..Components::NONE };

fn picture(dataset: &Arc<Dataset>, lighting: &SourceLighting, view: &View, sampling: BrdfSampling) -> Image {
    let mut backend = CpuBackend::new();
    backend.set_scene(&dataset.clone().into()).unwrap();
    let bounce = Some(BounceLight::Sources(Arc::new(lighting.clone())));
    let local = LocalLighting { bounce, components: INDIRECT, ..Default::default() };
    backend.set_local_lighting(&local).unwrap();
    backend.begin(view, sampling).unwrap();
    backend.render_rows(0, 0..view.size[1]).unwrap();
    backend.read(1).unwrap().0
}

fn rel_rmse(a: &Image, b: &Image) -> f32 {
    let error: f32 = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (*a - *b).length_squared()).sum();
    (error / b.pixels.iter().map(|b| b.length_squared()).sum::<f32>()).sqrt()
}

/// The floor points that a picture shows.
fn floor_image(view: &View, f: impl Fn(Vec3) -> Vec3) -> Image {
    Image::from_fn(view.size, |x, y| {
        let direction = view.camera.direction_through(Vec2::new(x as f32, y as f32) + 0.5, view.size);
        f(view.camera.eye - direction * (view.camera.eye.y / direction.y))
    })
}

fn uniform(rig: &SourceRig, irradiance: f32) -> SourceLighting {
    rig.lighting_with(&[Vec3::splat(irradiance); SOURCES], SOURCES as u32)
}

#[test]
fn the_bounce_of_a_wall_is_that_of_its_form_factor() {
    let dataset = Arc::new(floor_and_wall(2 * SIDE_LOG2));
    let rig = sources_of(&dataset.clone().into());
    let view = from_above(24);
    let albedo = Vec3::new(0.6, 0.3, 0.1);
    let expected = floor_image(&view, |p| albedo * (5.0 / PI) * (form_factor(p) / PI));
    for depth in [2 * SIDE_LOG2, 6, 4] {
        let dataset = Arc::new(floor_and_wall(depth));
        let shown = picture(&dataset, &uniform(&rig, 5.0), &view, BrdfSampling::Refine);
        assert!(rel_rmse(&shown, &expected) < 0.02, "depth {depth}: {}", rel_rmse(&shown, &expected));
    }
    let brighter = picture(&dataset, &uniform(&rig, 5.5), &view, BrdfSampling::Refine);
    assert!(rel_rmse(&brighter, &expected) > 0.08, "negative control");
}

/// The floor of this scene is white, so only the wall's radiance counts.
#[test]
fn a_wall_that_shines_lights_the_floor_by_its_form_factor() {
    let dataset = Arc::new(floor_and_wall(2 * SIDE_LOG2));
    let mut rig = sources_of(&dataset.clone().into());
    let shines = |luminance: f32| {
        let mut appearance = Appearance::of(&dataset.scene);
        appearance.materials[1].parameters.set("emission_color", Vec3::new(1.0, 0.5, 0.0));
        appearance.materials[1].parameters.set("emission_luminance", luminance);
        appearance
    };
    let view = from_above(24);
    let expected = floor_image(&view, |p| Vec3::new(4.0, 2.0, 0.0) * (form_factor(p) / PI));
    let mut shown = |luminance: f32| {
        rig.set_appearance(&shines(luminance));
        picture(&dataset, &rig.lighting(SOURCES as u32), &view, BrdfSampling::Refine)
    };
    let found = shown(4.0);
    assert!(rel_rmse(&found, &expected) < 0.02, "{}", rel_rmse(&found, &expected));
    assert!(rel_rmse(&shown(4.4), &expected) > 0.08, "negative control: a brighter wall");
    assert_eq!(rel_rmse(&shown(0.0), &expected), 1.0, "negative control: a dark wall");
}

#[test]
fn full_cuts_are_the_sum_over_all_sources() {
    let dataset = Arc::new(floor_and_wall(2 * SIDE_LOG2));
    let mut rig = sources_of(&dataset.clone().into());
    rig.set_lights(&[point_light(Vec3::new(-1.5, 1.0, 0.3), 2.0)]);
    let sources = &dataset.indirect.as_ref().unwrap().sources;
    let lighting = rig.lighting(SOURCES as u32);
    let sent = &lighting.nodes.radiance[SOURCES..];
    // Solid angles are interpolated between vertices, which is exact at them.
    let renderer = Renderer::new(dataset.clone());
    let field = crate::shade::node_field::SourceField::new(&lighting);
    let mut shader =
        crate::shade::merge::Shader::new(field, &dataset.indirect.as_ref().unwrap().cuts, BrdfSampling::Once);
    for vertex in [40_u32, 300, 700] {
        let at = dataset.scene.mesh.positions[vertex as usize];
        let hit = renderer.intersector().closest_hit(at + Vec3::new(1e-3, 1.0, 1e-3), Vec3::NEG_Y).unwrap();
        let mut point = Surfaces::of(&renderer).point(&hit, Vec3::Y);
        (point.vertices, point.weights, point.position) = ([vertex; 3], [1.0, 0.0, 0.0], at);
        let term = |(s, l): (&Source, &Vec3)| {
            let cos = (s.surfel.position - at).normalize().y;
            *l * (solid_angle(solid_angle_code(seen(s, at))) * cos / PI)
        };
        let sum: Vec3 = sources.iter().zip(sent).map(term).sum();
        let shaded = shader.shade(&point);
        assert!((shaded - sum).length() < 1e-4 * sum.length(), "{shaded} for {sum}");
        assert!((shaded - 1.01 * sum).length() > 1e-3 * sum.length(), "negative control");
    }
    assert_eq!(shader.work.merged_nodes, 3 * SOURCES as u64);
}

#[test]
fn refinement_of_few_nodes_is_close_to_all_of_them_for_a_glossy_floor() {
    let glossy = |depth| {
        let mut dataset = floor_and_wall(depth);
        let parameters = GgxParameters { base_color: Vec3::ZERO, roughness: 0.35, ..Default::default() };
        dataset.scene.materials[0] =
            Material { model: BrdfModel::Ggx, parameters: parameters.into(), ..Default::default() };
        Arc::new(dataset)
    };
    let full = glossy(2 * SIDE_LOG2);
    let mut rig = sources_of(&full.clone().into());
    rig.set_lights(&[point_light(Vec3::new(-1.9, 1.5, 0.5), 2.0)]);
    let camera = lapidary_core::camera::Camera::look_at(Vec3::new(1.8, 1.0, 0.3), Vec3::new(-1.0, 0.0, 0.0), 40.0);
    // By cuts alone.
    let view = View { camera, mirrors: false, ..from_the_side(32) };
    let expected = picture(&full, &rig.lighting(SOURCES as u32), &view, BrdfSampling::Once);
    let coarse = glossy(4);
    let refined = rel_rmse(&picture(&coarse, &rig.lighting(16), &view, BrdfSampling::Refine), &expected);
    let once = rel_rmse(&picture(&coarse, &rig.lighting(16), &view, BrdfSampling::Once), &expected);
    assert!(refined < 0.06 && refined < 0.5 * once, "{once} to {refined}");
}

#[test]
fn lights_give_sources_what_geometry_says_and_only_changed_ones_are_cast_again() {
    let dataset = Arc::new(floor_and_wall(4));
    let mut rig = sources_of(&dataset.clone().into());
    assert!(rig.irradiance().iter().all(|&e| e == Vec3::ZERO), "no light, no irradiance");
    let light = point_light(Vec3::new(-1.0, 1.0, 0.0), 3.0);
    rig.set_lights(std::slice::from_ref(&light));
    let at = |position: Vec3| {
        let to_light = light.position - position;
        3.0 * to_light.x / to_light.length().powi(3)
    };
    let parts = rig.lit.points.chunks(source_parts::PARTS);
    for ((source, parts), e) in rig.tree().sources().iter().zip(parts).zip(rig.irradiance()) {
        let expected = parts.iter().map(|part| at(part.position)).sum::<f32>() / parts.len() as f32;
        assert!((e.x / expected - 1.0).abs() < 1e-4, "{e} for {expected}");
        assert!((expected / at(source.surfel.position) - 1.0).abs() < 2e-3, "the mean around the source");
    }
    let behind = point_light(Vec3::new(-3.0, 1.0, 0.0), 3.0);
    let below = point_light(Vec3::new(-1.0, -1.0, 0.0), 3.0);
    let off = Light { enabled: false, ..light.clone() };
    let before = rig.irradiance();
    let first = rig.lit.lights.groups[0].irradiance.as_ptr();
    rig.set_lights(&[light, behind, below, off]);
    assert_eq!(rig.lit.lights.groups[0].irradiance.as_ptr(), first, "what has not changed is kept");
    assert_eq!(rig.irradiance(), before, "neither from behind, nor through the floor, nor while switched off");
    rig.set_lights(&[]);
    assert!(rig.irradiance().iter().all(|&e| e == Vec3::ZERO));
    let thousands: Vec<Light> = (0..1000).map(|i| point_light(Vec3::new(-1.0, 1.0, 1e-3 * i as f32), 1.0)).collect();
    rig.set_lights(&thousands);
    assert!(rig.lit.lights.groups.len() <= light_groups::LIGHT_GROUPS && rig.irradiance()[0].x > 100.0);
}

/// The wall's vertex normals lean by 60 degrees, so the wall looks tilted. It sends the light of its shaded look.
#[test]
fn light_is_received_by_the_normals_that_are_seen_on_either_side() {
    let sun = |toward: Vec3| light(Emission::PARALLEL, -3.0 * toward, Vec3::ZERO, 2.0);
    let mean = |leaning: bool, side: f32, toward: Vec3| {
        let mut dataset = floor_and_wall(4);
        let lean = Vec3::new(0.5, 0.75_f32.sqrt(), 0.0);
        let normals = dataset.scene.mesh.normals.iter_mut().filter(|n| leaning && **n == Vec3::X);
        normals.for_each(|n| *n = lean);
        let sources = &mut dataset.indirect.as_mut().unwrap().sources;
        sources.iter_mut().for_each(|source| source.surfel.normal *= side);
        let mut rig = sources_of(&Arc::new(dataset).into());
        rig.set_lights(&[sun(toward)]);
        rig.irradiance().iter().map(|e| e.x).sum::<f32>() / SOURCES as f32
    };
    for side in [1.0, -1.0] {
        let toward = Vec3::NEG_X * side;
        assert!((mean(true, side, toward) - 1.0).abs() < 1e-4, "{}", mean(true, side, toward));
        assert!((mean(false, side, toward) - 2.0).abs() < 1e-4, "negative control: it does not lean");
        assert_eq!(mean(true, side, -toward), 0.0, "from behind");
    }
}

#[test]
fn a_rectangle_in_front_of_the_wall_gives_lambert_s_irradiance() {
    let dataset = Arc::new(floor_and_wall(4));
    let mut rig = sources_of(&dataset.into());
    let emission = Emission::Rectangle { width: 0.8, height: 0.6 };
    let position = Vec3::new(-0.7, 1.2, 0.0);
    let light = Light { emission, target: Vec3::new(-2.2, 1.2, 0.0), ..point_light(position, 2.0) };
    rig.set_lights(&[light]);
    let corner = |y: f32, z: f32| position + Vec3::new(0.0, 0.3 * y, 0.4 * z);
    let corners = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    for (source, e) in rig.tree().sources().iter().zip(rig.irradiance()) {
        let toward = corners.map(|c| (c - source.surfel.position).normalize());
        let edge = |i: usize| {
            let (a, b) = (toward[i], toward[(i + 1) % 4]);
            a.dot(b).acos() * a.cross(b).normalize().x
        };
        let expected = (0..4).map(edge).sum::<f32>().abs();
        assert!((e.x / expected - 1.0).abs() < 0.01, "{e} for {expected}");
    }
}

#[test]
fn a_constant_environment_gives_a_free_source_pi() {
    let dataset = Arc::new(floor_and_wall(4));
    let renderer = Renderer::new(dataset.clone());
    let mut rig = sources_of(&dataset.clone().into());
    let mut shine = |light: &Illumination| {
        rig.set_environment(Some(renderer.lighting(light, 256)));
        rig.irradiance()
    };
    let full = shine(&illumination([64, 32], |_, _| Vec3::new(1.0, 2.0, 0.5)));
    assert!(full.iter().all(|e| (*e / PI - Vec3::new(1.0, 2.0, 0.5)).abs().max_element() < 0.02), "{}", full[0]);
    // The wall faces +X; those directions are in the left half of the map.
    let half = shine(&illumination([64, 32], |x, _| Vec3::splat(f32::from(u8::from(x >= 32)))));
    assert!(half.iter().all(|e| e.x < 0.02 * PI), "{}", half[0]);
    rig.set_environment(None);
    assert!(rig.irradiance().iter().all(|&e| e == Vec3::ZERO));
    assert_eq!(dataset.tree.len(), LIGHTS);
}

#[test]
fn an_edited_material_scales_the_bounce_and_casts_no_rays() {
    let dataset = Arc::new(floor_and_wall(6));
    let mut rig = sources_of(&dataset.clone().into());
    rig.set_lights(&[point_light(Vec3::new(-1.0, 1.0, 0.0), 3.0)]);
    let view = from_above(12);
    let show = |rig: &SourceRig| picture(&dataset, &rig.lighting(64), &view, BrdfSampling::Refine);
    let before = show(&rig);
    let mut appearance = Appearance::of(&dataset.scene);
    appearance.materials[1].parameters.set("base_color", Vec3::new(0.3, 0.6, 0.1));
    rig.set_appearance(&appearance);
    let after = show(&rig);
    let scaled =
        Image { size: before.size, pixels: before.pixels.iter().map(|p| *p * Vec3::new(0.5, 2.0, 1.0)).collect() };
    assert!(rel_rmse(&after, &scaled) < 0.01, "{}", rel_rmse(&after, &scaled));
    assert!(rel_rmse(&after, &before) > 0.3, "negative control");
}

#[test]
fn parts_are_shown_alone_and_add_up_and_without_sources_there_is_no_bounce() {
    let dataset = Arc::new(floor_and_wall(6));
    let mut rig = sources_of(&dataset.clone().into());
    let light = illumination([64, 32], |x, _| Vec3::splat(0.1 * x as f32));
    let lighting: Arc<EnvironmentLight> = Renderer::new(dataset.clone()).lighting(&light, 64).into();
    rig.set_environment(Some((*lighting).clone()));
    let bounce = Some(BounceLight::Sources(Arc::new(rig.lighting(64))));
    let mut backend = CpuBackend::new();
    let lamps: Arc<[Light]> = [point_light(Vec3::new(0.5, 1.5, 0.0), 3.0)].into();
    let mut bare = (*dataset).clone();
    bare.indirect = None;
    assert!(SourceRig::new(&bare.clone().into()).is_none());
    let mut show = |dataset: &Arc<Dataset>, components, mode| {
        backend.set_scene(&dataset.clone().into()).unwrap();
        backend.set_light(&light, &lighting).unwrap();
        let local = LocalLighting { lights: lamps.clone(), bounce: bounce.clone(), components, ..Default::default() };
        backend.set_local_lighting(&local).unwrap();
        let view = View { mode, ..from_above(12) };
        backend.begin(&view, BrdfSampling::Refine).unwrap();
        backend.render_rows(0, 0..12).unwrap();
        backend.read(1).unwrap().0
    };
    let environment = Components { environment: true, ..Components::NONE };
    let unlit = Components { direct: false, ..Components::ALL };
    let [all, sky, bounce] = [unlit, environment, INDIRECT].map(|c| show(&dataset, c, ViewMode::Shaded));
    let sum = |a: &Image, b: &Image| Image {
        size: a.size,
        pixels: a.pixels.iter().zip(&b.pixels).map(|(a, b)| *a + *b).collect(),
    };
    assert!(rel_rmse(&sum(&sky, &bounce), &all) < 1e-6);
    assert!(rel_rmse(&sky, &all) > 1e-3 && rel_rmse(&bounce, &all) > 0.1, "negative control");
    let direct = show(&dataset, Components { direct: true, ..Components::NONE }, ViewMode::Shaded);
    let lamp = Renderer::new(dataset.clone()).direct_light(&from_above(12), &lamps);
    assert!(rel_rmse(&direct, &lamp) < 1e-6 && lamp.pixels[70].x > 0.0);
    let none = show(&dataset, Components::NONE, ViewMode::Shaded);
    assert!(none.pixels.iter().all(|&p| p == Vec3::ZERO));
    assert!(rel_rmse(&show(&bare.into(), unlit, ViewMode::Shaded), &sky) < 1e-6);
    let mut nodes = |c| show(&dataset, c, ViewMode::MergedCut).pixels[70].x;
    assert_eq!(nodes(Components::ALL), nodes(environment) + nodes(INDIRECT));
}

#[test]
fn the_view_of_visibility_cuts_shows_those_over_sources_where_the_environment_was_not_baked() {
    let depth = 4;
    let mut dataset = floor_and_wall(depth);
    for (mode, is_over_sources) in [(BakeParts::INDIRECT, true), (BakeParts::ALL, false)] {
        dataset.settings.mode = mode;
        let mut backend = CpuBackend::new();
        backend.set_scene(&dataset.clone().into()).unwrap();
        let view = View { mode: ViewMode::VisibilityCut, ..from_above(8) };
        backend.begin(&view, BrdfSampling::Refine).unwrap();
        backend.render_rows(0, 0..8).unwrap();
        // Every floor vertex has a cut of all nodes of one depth.
        let nodes = backend.read(1).unwrap().0.pixels[27].x;
        assert_eq!((nodes - (1 << depth) as f32).abs() < 1e-3, is_over_sources, "{mode:?}: {nodes}");
    }
}
