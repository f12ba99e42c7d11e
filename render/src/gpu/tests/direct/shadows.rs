//! Shadow maps against shadow rays: where rays to a ring of neighbors agree, the map must say exactly the same.

use super::*;
use lapidary_core::ray::Intersector;

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

/// Lights and the width of a texel at one meter, as a multiple of one over the map's size.
fn casting() -> Vec<(Light, f32)> {
    let tan = |degrees: f32| degrees.to_radians().tan();
    vec![
        (light(Emission::Point, [0.3, 1.9, 0.8], [0.0; 3]), 2.0),
        (light(Emission::Point, [1.7, 0.12, 1.4], [0.0; 3]), 2.0), // grazes the floor
        (light(spot(40.0, 10.0), [1.2, 2.4, 0.9], [-0.2, 0.0, 0.1]), 2.0 * tan(40.0)),
        (light(spot(85.0, 5.0), [0.8, 1.6, 1.0], [-0.4, 0.2, 0.0]), 2.0),
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
            assert!(verdict.lit_wrong == 0 && verdict.dark_wrong == 0, "{:?} at {size}: {verdict:?}", light.emission);
            let grazes = light.position.y < 0.2;
            assert!(
                verdict.lit > 1500 && (verdict.dark > 200 || grazes),
                "{:?} at {size}: {verdict:?}",
                light.emission
            );
            assert!(verdict.edge < verdict.lit + verdict.dark, "{:?} at {size}: {verdict:?}", light.emission);
        }
    }
    for (light, texel) in casting() {
        let without = judge(&mut rig, &view, &light, NO_ROOM, texel / 1024.0);
        assert_eq!(without.dark_wrong, without.dark, "negative control: {without:?}");
    }
}

#[test]
fn edges_are_filtered_and_no_wider_than_the_kernel() {
    let Some(mut rig) = shadow_rig() else { return };
    let camera = Camera::look_at(Vec3::new(-1.0, 3.0, -0.1), Vec3::new(-1.0, 0.0, -0.11), 6.0);
    let view = dark_view(camera, [160, 120]);
    let lamp = light(spot(40.0, 0.0), [1.0, 4.0, -0.1], [-1.0, 0.0, -0.1]);
    let share_between = |rig: &mut Rig, size| {
        let gpu = rig.lit_by(&view, std::slice::from_ref(&lamp), ShadowRoom { largest: size, ..ROOM });
        let open = rig.lit_by(&view, std::slice::from_ref(&lamp), NO_ROOM);
        let between = |(p, open): &(&Vec3, &Vec3)| p.x > 0.02 * open.x && p.x < 0.98 * open.x;
        gpu.pixels.iter().zip(&open.pixels).filter(between).count() as f32 / gpu.pixels.len() as f32
    };
    let (coarse, fine) = (share_between(&mut rig, 512), share_between(&mut rig, 2048));
    assert!(coarse > 0.01 && fine < 0.4 * coarse, "{coarse} and {fine}");
}

/// The mean over samples, which share the shadow maps of a rectangle's points or are rays to a sun, is close to the mean over many shadow
/// rays.
#[test]
fn lights_with_an_extent_cast_soft_shadows() {
    let Some(mut rig) = shadow_rig() else { return };
    let view = shadow_view();
    let disc = |angle_degrees| light(Emission::Directional { angle_degrees }, [0.5, 2.2, 0.6], [0.0; 3]);
    let panel = light(Emission::Rectangle { width: 0.8, height: 0.8 }, [0.5, 2.2, 0.6], [0.0; 3]);
    for (lamp, most) in [(panel, 0.02), (disc(2.0), 0.01), (disc(8.0), 0.02)] {
        let soft = rig.lit_by(&view, std::slice::from_ref(&lamp), ROOM);
        let points = receivers(&rig.gpu, &rig.renderer, &view);
        let rays = rig.renderer.intersector();
        let n = 24;
        let at = |i: u32| (i as f32 + 0.5) / n as f32;
        let traced = |receiver: &Receiver| {
            let origin = receiver.position + 2e-4 * receiver.face_normal;
            let samples = (0..n * n).filter_map(|i| lamp.sample(origin, Vec2::new(at(i % n), at(i / n))));
            let seen = samples.filter(|s| !rays.occluded_before(origin, s.direction, s.distance));
            seen.map(|s| reflected(&receiver.point, &s, 0.0)).sum::<Vec3>() / (n * n) as f32
        };
        let pixels = points.iter().map(|r| r.as_ref().map_or(Vec3::ZERO, traced)).collect();
        let reference = Image { size: view.size, pixels };
        let d = difference(&soft, &reference).0;
        let hard = rig.lit_by(&view, std::slice::from_ref(&lamp), NO_ROOM);
        assert!(d < most, "{:?}: {d}", lamp.emission);
        assert!(difference(&hard, &reference).0 > 3.0 * d, "negative control");
        let parallel = rig.lit_by(&view, &[Light { emission: Emission::PARALLEL, ..lamp.clone() }], ROOM);
        let is_sun = matches!(lamp.emission, Emission::Directional { .. });
        assert!(
            !is_sun || difference(&parallel, &reference).0 > 1.5 * d,
            "{:?}: a sharp shadow is worse",
            lamp.emission
        );
    }
}
