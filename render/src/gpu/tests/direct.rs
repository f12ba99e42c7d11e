//! Local lights on the GPU: their radiometry against `Light::sample` on the same surface points, how they add up, and
//! what changes them. Shadows have tests of their own.

mod shadows;
pub(super) mod suns;
mod thousands;

use super::twin::{agrees, appearance, backend, difference, in_bands, maps, parameters, scene, view};
use crate::{
    Backend, BrdfSampling, Components, LocalLighting, Renderer, View, ViewMode,
    gpu::{GpuBackend, shadows::ShadowRoom},
    shade::{
        differentials::Differentials,
        direct::{CELLS, DirectLights, cells, pixel_shift},
        surface::{SurfacePoint, Surfaces},
    },
    test_scenes::{dataset, mesh, white},
};
use glam::{Vec2, Vec3, Vec4};
use lapidary_core::{
    camera::Camera,
    image::Image,
    lights::{Disc, Emission, Light, LightSample},
    material::BrdfModel,
    ray::Hit,
    scene::Mesh,
    simd::Vec3x8,
};
use std::sync::MutexGuard;
use wide::f32x8;

const ROOM: ShadowRoom = ShadowRoom { layers: 256, suns: 8, largest: 2048 };
const NO_ROOM: ShadowRoom = ShadowRoom { layers: 0, suns: 0, largest: 512 };
/// Points of a rectangle that the shader samples, along a side, if it has shadows from 3 x 3.
const RECTANGLE_STEPS: u32 = 6;

/// Local lights without a bounce.
fn local(lights: &[Light]) -> LocalLighting {
    LocalLighting { lights: lights.into(), ..Default::default() }
}

fn light(emission: Emission, position: [f32; 3], target: [f32; 3]) -> Light {
    let (position, target) = (position.into(), target.into());
    Light { emission, position, target, intensity: Vec3::new(4.0, 3.0, 2.5), ..Default::default() }
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
        light(Emission::PARALLEL, [1.0, 2.0, 0.5], [0.0; 3]),
        light(Emission::Directional { angle_degrees: 0.53 }, [1.0, 2.0, 0.5], [0.0; 3]),
        light(Emission::Directional { angle_degrees: 40.0 }, [1.0, 2.0, 0.5], [0.0; 3]),
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
        self.gpu.set_local_lighting(&local(lights)).unwrap();
        self.picture(view)
    }
}

/// A surface point with its place and the normal of its face.
struct Receiver {
    position: Vec3,
    face_normal: Vec3,
    point: SurfacePoint,
    /// Of its rays to suns.
    shift: Vec2,
}

/// What the deferred pass saw at each pixel.
fn receivers(gpu: &GpuBackend, renderer: &Renderer, view: &View) -> Vec<Option<Receiver>> {
    let surfaces = Surfaces::of(renderer).filtered(Differentials::of(view));
    let dataset = renderer.dataset();
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
            shift: pixel_shift(i % view.size[0], i / view.size[0], 0),
        })
    };
    gpu.read_geometry().into_iter().enumerate().map(receiver).collect()
}

/// Light of one sample that a point reflects toward the eye, with the lobe filtered by its spread.
fn reflected(point: &SurfacePoint, sample: &LightSample, inv_kappa: f32) -> Vec3 {
    if sample.direction.dot(point.smooth_normal) <= 0.0 {
        return Vec3::ZERO;
    }
    let wi = point.world_from_local.transpose() * sample.direction;
    let reflected = point.reflect(Vec3x8::splat(wi), f32x8::splat(inv_kappa));
    reflected.lane(0) * sample.irradiance
}

/// Light of all samples, without shadows: the loop of the shader over what `core` says of lights.
fn unshadowed(receiver: &Receiver, lights: &[Light]) -> Vec3 {
    let of_light = |light: &Light| -> Vec3 {
        let at = |n: u32, i: u32| (Vec2::new((i % n) as f32, (i / n) as f32) + 0.5) / n as f32;
        let places: Vec<Vec2> = match light.emission {
            _ if light.is_delta() => vec![Vec2::splat(0.5)],
            Emission::Directional { .. } => {
                cells(receiver.shift).map(|(corner, target)| (corner + target) / CELLS as f32).to_vec()
            }
            _ => (0..RECTANGLE_STEPS * RECTANGLE_STEPS).map(|i| at(RECTANGLE_STEPS, i)).collect(),
        };
        let inv_kappa = Disc::of(light).map_or(0.0, |disc| 0.5 * disc.height / places.len() as f32);
        let samples = places.iter().filter_map(|&place| light.sample(receiver.position, place));
        samples.map(|s| reflected(&receiver.point, &s, inv_kappa)).sum::<Vec3>() / places.len() as f32
    };
    lights.iter().map(of_light).sum()
}

fn twin(receivers: &[Option<Receiver>], view: &View, lights: &[Light]) -> Image {
    let pixel = |r: &Option<Receiver>| r.as_ref().map_or(Vec3::ZERO, |r| unshadowed(r, lights));
    Image { size: view.size, pixels: receivers.iter().map(pixel).collect() }
}

fn dark_view(camera: Camera, size: [u32; 2]) -> View {
    View { background: crate::Background::Flat(Vec3::ZERO), mirrors: false, ..View::new(camera, size) }
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

fn shadow_rig() -> Option<Rig> {
    Rig::new(Renderer::new(dataset(shadow_scene(), white())))
}

fn shadow_view() -> View {
    dark_view(Camera::look_at(Vec3::new(1.6, 2.6, 3.4), Vec3::new(-0.2, 0.1, 0.0), 46.0), [144, 112])
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
    rig.gpu.set_local_lighting(&local(std::slice::from_ref(&moved))).unwrap();
    let kept_maps = rig.picture(&view);
    assert!(rig.lit_by(&view, &[moved], ROOM) == kept_maps, "maps that were rendered before are as good as new ones");
    let off = Light { enabled: false, ..lights[0].clone() };
    assert_eq!(rig.lit_by(&view, &[off], ROOM).pixels.iter().sum::<Vec3>(), Vec3::ZERO);
    let normals = View { mode: ViewMode::Normals, ..view };
    let plain = rig.picture(&normals);
    assert!(rig.lit_by(&normals, &lights, ROOM) == plain);
}

#[test]
fn what_lights_take_up_is_free_when_they_are_gone_or_not_shown() {
    let Some(mut rig) = shadow_rig() else { return };
    let hidden = LocalLighting { components: Components::NONE, ..local(&every_kind()) };
    for without in [local(&[]), hidden] {
        rig.lit_by(&shadow_view(), &every_kind(), ROOM);
        assert!(rig.gpu.lights_take_room(), "negative control");
        rig.gpu.set_local_lighting(&without).unwrap();
        assert!(!rig.gpu.lights_take_room());
    }
}

#[test]
fn bands_and_jittered_samples_of_local_lights_add_up_to_the_whole() {
    let Some(mut rig) = shadow_rig() else { return };
    rig.gpu.set_local_lighting(&local(&every_kind())).unwrap();
    let view = View { aa: 3, ..shadow_view() };
    let mut whole = |ends: &[u32]| in_bands(&mut rig.gpu, &view, ends);
    let one = whole(&[112]);
    assert!(whole(&[1, 30, 30, 112]) == one);
    let first = rig.picture(&view);
    let d = difference(&one, &first).0;
    assert!(d > 1e-3 && d < 0.3, "the mean of three samples is near the first, but not it: {d}");
}

#[test]
fn another_scene_has_other_shadows_and_lights_beyond_the_limit_are_told() {
    let Some(mut rig) = shadow_rig() else { return };
    let (view, lamp) = (shadow_view(), every_kind().remove(0));
    let before = rig.lit_by(&view, std::slice::from_ref(&lamp), ROOM);
    let plain = Renderer::new(dataset(mesh(8, true), white()));
    rig.gpu.set_scene(&plain.dataset().clone().into()).unwrap();
    rig.gpu.set_local_lighting(&local(std::slice::from_ref(&lamp))).unwrap();
    let after = rig.picture(&view);
    assert!(rig.lit_by(&view, std::slice::from_ref(&lamp), ROOM) == after, "as with new maps");
    assert!(difference(&before, &after).0 > 0.05);
    rig.gpu.limit_shadows(ShadowRoom { layers: 11, ..ROOM });
    let remarks = rig.gpu.set_local_lighting(&local(&[lamp.clone(), lamp.clone()])).unwrap();
    assert!(remarks.len() == 1 && remarks[0].contains("12") && remarks[0].contains("11"), "{remarks:?}");
    assert!(rig.gpu.set_local_lighting(&local(&[lamp.clone(), lamp.clone()])).unwrap().is_empty(), "said once");
    let half = rig.picture(&view);
    let shadowless = rig.lit_by(&view, std::slice::from_ref(&lamp), NO_ROOM);
    let sum = after.pixels.iter().zip(&shadowless.pixels).map(|(a, b)| *a + *b).collect();
    assert!(agrees(&half, &Image { size: view.size, pixels: sum }), "one of them with shadows, one without");
    rig.gpu.limit_shadows(ROOM);
    assert!(rig.gpu.set_local_lighting(&local(std::slice::from_ref(&lamp))).unwrap().is_empty());
    rig.gpu.limit_shadows(ShadowRoom { layers: 1, ..ROOM });
    for _ in 0..2 {
        let remarks = rig.gpu.set_local_lighting(&local(std::slice::from_ref(&lamp))).unwrap();
        assert_eq!(remarks.len(), 1, "it is said anew of another scene");
        rig.gpu.set_scene(&plain.dataset().clone().into()).unwrap();
    }
}
