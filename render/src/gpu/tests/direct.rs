//! Local lights on the GPU: their radiometry against `Light::sample` on the same surface points, and their shadow maps
//! against shadow rays. Where rays to a ring of neighbours agree, the map must say exactly the same.

use super::twin::{agrees, appearance, backend, difference, maps, parameters, scene, view};
use crate::{
    Backend, BrdfSampling, Renderer, View, ViewMode,
    gpu::{GpuBackend, shadows::ShadowRoom},
    renderer::tests::{dataset, mesh, white},
    surface::SurfacePoint,
};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    camera::Camera,
    image::Image,
    lights::{Emission, Light, LightSample},
    material::BrdfModel,
    ray::{Hit, Intersector},
    scene::Mesh,
};
use std::sync::MutexGuard;

const ROOM: ShadowRoom = ShadowRoom { layers: 256, largest: 2048 };
const NO_ROOM: ShadowRoom = ShadowRoom { layers: 0, largest: 512 };
/// Points of a rectangle that the shader samples, along a side, if it has shadows from 3 x 3.
const RECTANGLE_STEPS: u32 = 6;

fn light(emission: Emission, position: [f32; 3], target: [f32; 3]) -> Light {
    Light {
        name: String::new(),
        enabled: true,
        emission,
        position: position.into(),
        target: target.into(),
        intensity: Vec3::new(4.0, 3.0, 2.5),
    }
}

fn spot(cone_degrees: f32, penumbra_degrees: f32) -> Emission {
    Emission::Spot { cone_degrees, penumbra_degrees }
}

fn every_kind() -> Vec<Light> {
    vec![
        light(Emission::Point, [0.9, 1.4, 0.5], [0.0; 3]),
        light(spot(35.0, 12.0), [1.2, 2.0, 0.3], [0.2, 0.0, 0.1]),
        light(spot(35.0, 0.0), [1.2, 2.0, 0.3], [0.2, 0.0, 0.1]),
        light(spot(85.0, 40.0), [-0.8, 0.9, 0.4], [0.0, 0.0, 0.3]),
        light(Emission::Directional, [1.0, 2.0, 0.5], [0.0; 3]),
        light(Emission::Rectangle { width: 0.9, height: 0.5 }, [0.4, 1.9, 0.8], [0.0, 0.0, 0.1]),
    ]
}

struct Rig {
    renderer: Renderer,
    gpu: GpuBackend,
    _one: MutexGuard<'static, ()>,
}

impl Rig {
    fn new(renderer: Renderer) -> Option<Self> {
        let (one, mut gpu) = backend()?;
        gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
        Some(Self { renderer, gpu, _one: one })
    }

    /// One sample of the current lights.
    fn picture(&mut self, view: &View) -> Image {
        self.gpu.begin(view, BrdfSampling::Refine).unwrap();
        self.gpu.render_rows(0, 0..view.size[1]).unwrap();
        self.gpu.read(1).unwrap().0
    }

    fn lit_by(&mut self, view: &View, lights: &[Light], room: ShadowRoom) -> Image {
        self.gpu.limit_shadows(room);
        self.gpu.set_local_lights(lights).unwrap();
        self.picture(view)
    }
}

/// A surface point with its place and the normal of its face.
struct Receiver {
    position: Vec3,
    face_normal: Vec3,
    point: SurfacePoint,
}

/// What the deferred pass saw at each pixel.
fn receivers(gpu: &GpuBackend, renderer: &Renderer, view: &View) -> Vec<Option<Receiver>> {
    let (dataset, surfaces) = (renderer.dataset(), renderer.surfaces());
    let mesh = &dataset.scene.mesh;
    let receiver = |(i, [id, b, c, flags]): (usize, [u32; 4])| {
        let triangle = (id as usize).checked_sub(1)?;
        let back_face = flags & 0x100 != 0;
        if back_face && !dataset.two_sided[triangle] {
            return None;
        }
        let barycentric = Vec2::new(f32::from_bits(b), f32::from_bits(c));
        let hit = Hit { triangle: triangle as u32, distance: 0.0, barycentric, back_face };
        let i = i as u32;
        let pixel = Vec2::new((i % view.size[0]) as f32, (i / view.size[0]) as f32) + 0.5;
        let [p, q, r] = mesh.corners(triangle);
        let side = if back_face { -1.0 } else { 1.0 };
        Some(Receiver {
            position: p * (1.0 - barycentric.element_sum()) + q * barycentric.x + r * barycentric.y,
            face_normal: mesh.area_vector(triangle).normalize() * side,
            point: surfaces.point(&hit, -view.camera.direction_through(pixel, view.size)),
        })
    };
    gpu.read_geometry().into_iter().enumerate().map(receiver).collect()
}

/// Light of one sample that a point reflects toward the eye.
fn reflected(point: &SurfacePoint, sample: &LightSample) -> Vec3 {
    if sample.direction.dot(point.smooth_normal) <= 0.0 {
        return Vec3::ZERO;
    }
    let wi = point.world_from_local.transpose() * sample.direction;
    point.brdf.as_brdf().brdf_cos(wi, point.wo) * sample.irradiance
}

/// Light of all samples, without shadows: the loop of the shader over what `core` says of lights.
fn unshadowed(receiver: &Receiver, lights: &[Light]) -> Vec3 {
    let of_light = |light: &Light| -> Vec3 {
        let n = if light.is_delta() { 1 } else { RECTANGLE_STEPS };
        let at = |i: u32| (i as f32 + 0.5) / n as f32;
        let samples = (0..n * n).filter_map(|i| light.sample(receiver.position, Vec2::new(at(i % n), at(i / n))));
        samples.map(|s| reflected(&receiver.point, &s)).sum::<Vec3>() / (n * n) as f32
    };
    lights.iter().map(of_light).sum()
}

fn twin(receivers: &[Option<Receiver>], view: &View, lights: &[Light]) -> Image {
    let pixel = |r: &Option<Receiver>| r.as_ref().map_or(Vec3::ZERO, |r| unshadowed(r, lights));
    Image { size: view.size, pixels: receivers.iter().map(pixel).collect() }
}

fn dark_view(camera: Camera, size: [u32; 2]) -> View {
    View { background: crate::Background::Flat(Vec3::ZERO), ..View::new(camera, size) }
}

#[test]
fn every_kind_and_model_agrees_with_the_loop_over_lights() {
    let mut renderer = Renderer::new(scene());
    let data = renderer.dataset().clone();
    let look = |model| appearance(&data, model, parameters(0.4, 0.5), maps());
    let view = dark_view(view(ViewMode::Shaded).camera, [72, 56]);
    let Some(mut rig) = Rig::new(Renderer::new(data.clone())) else { return };
    for model in [BrdfModel::Lambert, BrdfModel::Ggx, BrdfModel::Ward] {
        renderer.set_appearance(look(model));
        assert!(rig.gpu.set_appearance(&look(model)).unwrap().is_empty());
        for light in every_kind() {
            let gpu = rig.lit_by(&view, std::slice::from_ref(&light), NO_ROOM);
            let points = receivers(&rig.gpu, &renderer, &view);
            let expected = twin(&points, &view, std::slice::from_ref(&light));
            let emission = light.emission;
            assert!(agrees(&gpu, &expected), "{model:?} {emission:?}: {:?}", difference(&gpu, &expected));
            let brighter = Light { intensity: 1.001 * light.intensity, ..light.clone() };
            assert!(!agrees(&gpu, &twin(&points, &view, &[brighter])), "{emission:?}");
            let moved = Light { position: light.position + Vec3::new(0.01, -0.01, 0.0), ..light };
            assert!(!agrees(&gpu, &twin(&points, &view, &[moved])), "{emission:?}");
        }
    }
    let all = every_kind();
    let gpu = rig.lit_by(&view, &all, NO_ROOM);
    assert!(agrees(&gpu, &twin(&receivers(&rig.gpu, &renderer, &view), &view, &all)));
}

/// A floor with a hovering blocker, a closed box that stands on it and a thin wall.
fn shadow_scene() -> Mesh {
    let mut mesh = mesh(8, true);
    let (low, high) = (Vec3::new(-1.4, 0.0, 0.3), Vec3::new(-0.7, 0.6, 1.0));
    for axis in 0..3 {
        for side in [low, high] {
            let corner = |u: bool, v: bool| {
                let mut p = side;
                p[(axis + 1) % 3] = if u { high } else { low }[(axis + 1) % 3];
                p[(axis + 2) % 3] = if v { high } else { low }[(axis + 2) % 3];
                p
            };
            let mut normal = Vec3::ZERO;
            normal[axis] = if side == high { 1.0 } else { -1.0 };
            quad(
                &mut mesh,
                [corner(false, false), corner(true, false), corner(true, true), corner(false, true)],
                normal,
            );
        }
    }
    let p = |x: f32, y: f32| Vec3::new(x, y, -1.0);
    quad(&mut mesh, [p(-1.2, 0.0), p(0.6, 0.0), p(0.6, 0.5), p(-1.2, 0.5)], Vec3::Z);
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh.triangle_object = vec![0; mesh.triangles.len()];
    mesh
}

fn quad(mesh: &mut Mesh, corners: [Vec3; 4], normal: Vec3) {
    let first = mesh.positions.len() as u32;
    let turned = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(normal) < 0.0;
    let order = if turned { [0, 3, 2, 1] } else { [0, 1, 2, 3] };
    mesh.positions.extend(order.map(|i| corners[i]));
    mesh.normals.extend([normal; 4]);
    mesh.tangents.extend([normal.any_orthonormal_vector().extend(1.0); 4] as [Vec4; 4]);
    mesh.uvs.extend([Vec2::ZERO; 4]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

fn blocked(rays: &Intersector, from: Vec3, normal: Vec3, light: &Light) -> Option<bool> {
    let origin = from + 2e-4 * normal;
    let sample = light.sample(origin, Vec2::splat(0.5))?;
    Some(rays.occluded_before(origin, sample.direction, sample.distance))
}

/// Whether a point is in shadow: `None` near an edge, where a ring of points at `texels` of the map around it differs.
fn in_shadow(
    rays: &Intersector,
    receiver: &Receiver,
    light: &Light,
    metres_per_texel: f32,
    texels: f32,
) -> Option<bool> {
    let (p, n) = (receiver.position, receiver.face_normal);
    let sample = light.sample(p, Vec2::splat(0.5))?;
    let distance = if sample.distance.is_finite() { sample.distance } else { 1.0 };
    let cos = sample.direction.dot(n);
    if cos <= 0.0 {
        return Some(true);
    }
    // A texel reaches farther along the direction that the light grazes.
    let along = (sample.direction - n * cos).normalize_or(n.any_orthonormal_vector());
    let radius = texels * metres_per_texel * distance;
    let axes = [along * radius / cos, n.cross(along) * radius];
    let center = blocked(rays, p, n, light)?;
    let around = (0..24).map(|i| {
        let (sin, cos) = (std::f32::consts::TAU * (i % 12) as f32 / 12.0).sin_cos();
        let size = if i < 12 { 1.0 } else { 0.5 };
        blocked(rays, p + size * (cos * axes[0] + sin * axes[1]), n, light)
    });
    around.into_iter().all(|b| b == Some(center)).then_some(center)
}

/// Pixels that must be lit, and how many of them are not; the same of those in shadow.
#[derive(Debug, Default, PartialEq)]
struct Verdict {
    lit: usize,
    lit_wrong: usize,
    dark: usize,
    dark_wrong: usize,
    edge: usize,
}

fn judge(rig: &mut Rig, view: &View, light: &Light, room: ShadowRoom, metres_per_texel: f32) -> Verdict {
    let gpu = rig.lit_by(view, std::slice::from_ref(light), room);
    let mut verdict = Verdict::default();
    for (receiver, &value) in receivers(&rig.gpu, &rig.renderer, view).iter().zip(&gpu.pixels) {
        let Some(receiver) = receiver else { continue };
        let full = unshadowed(receiver, std::slice::from_ref(light));
        if full == Vec3::ZERO {
            continue;
        }
        match in_shadow(rig.renderer.intersector(), receiver, light, metres_per_texel, 6.0) {
            Some(true) => {
                verdict.dark += 1;
                verdict.dark_wrong += usize::from(value.max_element() > 1e-4 * full.max_element());
            }
            Some(false) => {
                verdict.lit += 1;
                verdict.lit_wrong += usize::from((value - full).abs().max_element() > 1e-3 * full.max_element());
            }
            None => verdict.edge += 1,
        }
    }
    verdict
}

fn shadow_rig() -> Option<Rig> {
    Rig::new(Renderer::new(dataset(shadow_scene(), white())))
}

fn shadow_view() -> View {
    dark_view(Camera::look_at(Vec3::new(1.6, 2.6, 3.4), Vec3::new(-0.2, 0.1, 0.0), 46.0), [144, 112])
}

/// Lights and the width of a texel at one metre, or of parallel light, as a multiple of one over the map's size.
fn casting() -> Vec<(Light, f32)> {
    let tan = |degrees: f32| degrees.to_radians().tan();
    vec![
        (light(Emission::Point, [0.3, 1.9, 0.8], [0.0; 3]), 2.0),
        (light(Emission::Point, [1.7, 0.12, 1.4], [0.0; 3]), 2.0), // grazes the floor
        (light(spot(40.0, 10.0), [1.2, 2.4, 0.9], [-0.2, 0.0, 0.1]), 2.0 * tan(40.0)),
        (light(spot(85.0, 5.0), [0.8, 1.6, 1.0], [-0.4, 0.2, 0.0]), 2.0),
        (light(Emission::Directional, [1.0, 1.6, 0.7], [0.0; 3]), 6.0),
        (light(Emission::Directional, [1.0, 0.06, 0.3], [0.0; 3]), 6.0), // grazes the floor
    ]
}

#[test]
fn shadows_agree_with_rays_but_at_their_edges() {
    let Some(mut rig) = shadow_rig() else { return };
    let view = shadow_view();
    for size in [1024, 512] {
        let room = ShadowRoom { largest: size, ..ROOM };
        for (light, texel) in casting() {
            let verdict = judge(&mut rig, &view, &light, room, texel / size as f32);
            println!("{:?} at {size}: {verdict:?}", light.emission);
            assert!(verdict.lit_wrong == 0 && verdict.dark_wrong == 0, "{:?} at {size}: {verdict:?}", light.emission);
            assert!(verdict.lit > 1500 && verdict.dark > 300, "{:?} at {size}: {verdict:?}", light.emission);
            assert!(verdict.edge < 2 * (verdict.lit + verdict.dark), "{:?} at {size}: {verdict:?}", light.emission);
        }
    }
    for (light, texel) in casting() {
        let without = judge(&mut rig, &view, &light, NO_ROOM, texel / 1024.0);
        assert!(without.dark_wrong > 300, "negative control: {without:?}");
    }
}

#[test]
fn edges_are_filtered_and_no_wider_than_the_kernel() {
    let Some(mut rig) = shadow_rig() else { return };
    let camera = Camera::look_at(Vec3::new(-0.5, 3.0, 0.01), Vec3::new(-0.5, 0.0, 0.0), 12.0);
    let view = dark_view(camera, [160, 120]);
    let sun = light(Emission::Directional, [1.0, 2.0, 0.0], [0.0; 3]);
    let share_between = |rig: &mut Rig, size| {
        let gpu = rig.lit_by(&view, std::slice::from_ref(&sun), ShadowRoom { largest: size, ..ROOM });
        let full = gpu.pixels.iter().map(|p| p.x).fold(0.0, f32::max);
        let between = |p: &&Vec3| p.x > 0.02 * full && p.x < 0.98 * full;
        gpu.pixels.iter().filter(between).count() as f32 / gpu.pixels.len() as f32
    };
    let (coarse, fine) = (share_between(&mut rig, 512), share_between(&mut rig, 2048));
    assert!(coarse > 0.01 && fine < 0.4 * coarse, "{coarse} and {fine}");
}

/// The mean over shadow maps at 3 x 3 points is close to the mean over many shadow rays.
#[test]
fn a_rectangle_casts_a_soft_shadow() {
    let Some(mut rig) = shadow_rig() else { return };
    let view = shadow_view();
    let lamp = light(Emission::Rectangle { width: 0.8, height: 0.8 }, [0.5, 2.2, 0.6], [0.0; 3]);
    let soft = rig.lit_by(&view, std::slice::from_ref(&lamp), ROOM);
    let points = receivers(&rig.gpu, &rig.renderer, &view);
    let rays = rig.renderer.intersector().clone();
    let n = 24;
    let at = |i: u32| (i as f32 + 0.5) / n as f32;
    let traced = |receiver: &Receiver| {
        let origin = receiver.position + 2e-4 * receiver.face_normal;
        let samples = (0..n * n).filter_map(|i| lamp.sample(origin, Vec2::new(at(i % n), at(i / n))));
        let seen = samples.filter(|s| !rays.occluded_before(origin, s.direction, s.distance));
        seen.map(|s| reflected(&receiver.point, &s)).sum::<Vec3>() / (n * n) as f32
    };
    let pixels = points.iter().map(|r| r.as_ref().map_or(Vec3::ZERO, traced)).collect();
    let reference = Image { size: view.size, pixels };
    let d = difference(&soft, &reference).0;
    let hard = rig.lit_by(&view, &[lamp], NO_ROOM);
    println!("soft {d}, without shadows {}", difference(&hard, &reference).0);
    assert!(d < 0.06, "{d}");
    assert!(difference(&hard, &reference).0 > 3.0 * d, "negative control");
}

#[test]
fn lights_add_up_move_and_go_out_and_other_views_do_not_show_them() {
    let Some(mut rig) = shadow_rig() else { return };
    let view = View { aa: 2, ..shadow_view() };
    let lights = every_kind();
    let all = rig.lit_by(&view, &lights, ROOM);
    let mut sum = Image::filled(view.size, Vec3::ZERO);
    for light in &lights {
        // The same number of shadow maps, so that rectangles have the same grid.
        let others = lights.iter().map(|l| Light { intensity: 1e-20 * l.intensity, ..l.clone() });
        let only: Vec<Light> = others.map(|l| if l.emission == light.emission { light.clone() } else { l }).collect();
        let one = rig.lit_by(&view, &only, ROOM);
        sum.pixels.iter_mut().zip(one.pixels).for_each(|(sum, p)| *sum += p);
    }
    assert!(agrees(&sum, &all), "{:?}", difference(&sum, &all));
    let moved = Light { position: lights[0].position + 0.2, ..lights[0].clone() };
    rig.gpu.set_local_lights(&[moved.clone()]).unwrap();
    let kept_maps = rig.picture(&view);
    assert!(rig.lit_by(&view, &[moved], ROOM) == kept_maps, "maps that were rendered before are as good as new ones");
    let off = Light { enabled: false, ..lights[0].clone() };
    assert_eq!(rig.lit_by(&view, &[off], ROOM).pixels.iter().sum::<Vec3>(), Vec3::ZERO);
    let normals = View { mode: ViewMode::Normals, ..view };
    let plain = rig.picture(&normals);
    assert!(rig.lit_by(&normals, &lights, ROOM) == plain);
}

#[test]
fn bands_and_jittered_samples_of_local_lights_add_up_to_the_whole() {
    let Some(mut rig) = shadow_rig() else { return };
    rig.gpu.set_local_lights(&every_kind()).unwrap();
    let view = View { aa: 3, ..shadow_view() };
    let mut whole = |ends: &[u32]| {
        rig.gpu.begin(&view, BrdfSampling::Refine).unwrap();
        for sample in 0..3 {
            let mut start = 0;
            for &end in ends {
                rig.gpu.render_rows(sample, start..end).unwrap();
                start = end;
            }
        }
        rig.gpu.read(3).unwrap().0
    };
    let one = whole(&[112]);
    assert!(whole(&[1, 30, 30, 112]) == one);
    let first = rig.picture(&view);
    let d = difference(&one, &first).0;
    assert!(d > 1e-3 && d < 0.3, "the mean of three samples is near the first, but not it: {d}");
}

#[test]
fn another_scene_has_other_shadows_and_lights_beyond_the_limit_are_told() {
    let Some(mut rig) = shadow_rig() else { return };
    let (view, lamp) = (shadow_view(), casting().remove(0).0);
    let before = rig.lit_by(&view, std::slice::from_ref(&lamp), ROOM);
    let plain = Renderer::new(dataset(mesh(8, true), white()));
    rig.gpu.set_scene(&plain.dataset().clone().into()).unwrap();
    let after = rig.picture(&view);
    assert!(rig.lit_by(&view, std::slice::from_ref(&lamp), ROOM) == after, "as with new maps");
    assert!(difference(&before, &after).0 > 0.05);
    rig.gpu.limit_shadows(ShadowRoom { layers: 11, ..ROOM });
    let remarks = rig.gpu.set_local_lights(&[lamp.clone(), lamp.clone()]).unwrap();
    assert!(remarks.len() == 1 && remarks[0].contains("12") && remarks[0].contains("11"), "{remarks:?}");
    let half = rig.picture(&view);
    let shadowless = rig.lit_by(&view, std::slice::from_ref(&lamp), NO_ROOM);
    let sum = after.pixels.iter().zip(&shadowless.pixels).map(|(a, b)| *a + *b).collect();
    assert!(agrees(&half, &Image { size: view.size, pixels: sum }), "one of them with shadows, one without");
    assert!(rig.gpu.set_local_lights(&[lamp]).unwrap().is_empty());
}
