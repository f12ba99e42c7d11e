//! Rays to suns against those of the CPU.

use super::*;
use crate::shade::direct::pixel_shift;

/// What the CPU's rays give at the same points.
fn on_the_cpu(points: &[Option<Receiver>], rig: &Rig, view: &View, lights: &[Light], sample: u32) -> Image {
    let shader = DirectLights { lights, intersector: rig.renderer.intersector() }.shader();
    Image::from_fn(view.size, |x, y| {
        let receiver = points[(y * view.size[0] + x) as usize].as_ref();
        receiver.map_or(Vec3::ZERO, |receiver| shader.reflected(&receiver.point, pixel_shift(x, y, sample)))
    })
}

/// Share of the pixels that differ by more than a thousandth of the mean.
fn differing(a: &Image, b: &Image) -> f64 {
    let mean = b.pixels.iter().map(|pixel| pixel.element_sum()).sum::<f32>() / (3 * b.pixels.len()) as f32;
    let differs = |(a, b): &(&Vec3, &Vec3)| (**a - **b).abs().max_element() > 1e-3 * mean;
    a.pixels.iter().zip(&b.pixels).filter(differs).count() as f64 / b.pixels.len() as f64
}

pub(in crate::gpu) fn suns() -> Vec<Light> {
    let sun = |angle_degrees, position| light(Emission::Directional { angle_degrees }, position, [0.0; 3]);
    vec![
        light(Emission::PARALLEL, [1.0, 1.6, 0.7], [0.0; 3]),
        sun(0.53, [0.8, 1.6, 0.9]),
        sun(2.0, [0.5, 2.2, 0.6]),
        sun(30.0, [-0.5, 1.2, 0.6]),
    ]
}

#[test]
fn rays_meet_what_they_meet_on_the_cpu() {
    let Some(mut rig) = shadow_rig() else { return };
    let view = shadow_view();
    let all = suns();
    for lights in all.chunks(1).chain([&all[..]]) {
        let gpu = rig.lit_by(&view, lights, ROOM);
        let points = receivers(&rig.gpu, &rig.renderer, &view);
        let found = differing(&gpu, &on_the_cpu(&points, &rig, &view, lights, 0));
        assert!(found < 0.002, "{:?}: {found}", lights[0].emission);
        let has_penumbra = lights.len() > 1 || lights[0].emission == (Emission::Directional { angle_degrees: 30.0 });
        let other = differing(&gpu, &on_the_cpu(&points, &rig, &view, lights, 1));
        assert!(!has_penumbra || other > 0.05, "negative control: rays of another sample, {other}");
        let open = differing(&rig.lit_by(&view, lights, NO_ROOM), &gpu);
        assert!(open > 0.02, "negative control: {:?} without shadows, {open}", lights[0].emission);
    }
}

#[test]
fn suns_beyond_the_limit_shine_without_shadows_and_are_told() {
    let Some(mut rig) = shadow_rig() else { return };
    let (view, sun) = (shadow_view(), suns().remove(0));
    let shadowed = rig.lit_by(&view, std::slice::from_ref(&sun), ROOM);
    let open = rig.lit_by(&view, std::slice::from_ref(&sun), NO_ROOM);
    // The weakest goes without.
    let mut nine = vec![sun.clone(); 9];
    nine[0].intensity *= 0.5;
    rig.gpu.limit_shadows(ROOM);
    let remarks = rig.gpu.set_local_lighting(&local(&nine)).unwrap();
    assert!(remarks.len() == 1 && remarks[0].contains("1 of 9"), "{remarks:?}");
    let sum = shadowed.pixels.iter().zip(&open.pixels).map(|(a, b)| *a * 8.0 + *b * 0.5).collect();
    assert!(agrees(&rig.picture(&view), &Image { size: view.size, pixels: sum }));
    assert!(rig.gpu.set_local_lighting(&local(&nine[1..])).unwrap().is_empty(), "negative control: eight");
}

/// A sphere of few triangles has no shadows of itself in the light.
#[test]
fn curved_surfaces_do_not_shadow_themselves() {
    let Some(mut rig) = Rig::new(Renderer::new(dataset(ball(12), white()))) else { return };
    let view = dark_view(Camera::look_at(Vec3::new(0.0, 0.6, 4.0), Vec3::ZERO, 30.0), [96, 96]);
    for lights in suns().chunks(1) {
        let gpu = rig.lit_by(&view, lights, ROOM);
        let points = receivers(&rig.gpu, &rig.renderer, &view);
        let expected = on_the_cpu(&points, &rig, &view, lights, 0);
        let found = differing(&gpu, &expected);
        assert!(found < 0.005, "{:?}: {found}", lights[0].emission);
        let lit = expected.pixels.iter().filter(|pixel| pixel.x > 0.0).count();
        assert!(lit > 1000, "there is light: {lit}");
    }
}

/// A unit sphere of `n` rings with smooth normals.
fn ball(n: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let (up, around) = (std::f32::consts::PI * i as f32 / n as f32, std::f32::consts::PI * j as f32 / n as f32);
        Vec3::new(up.sin() * around.cos(), up.cos(), up.sin() * around.sin())
    };
    let mut mesh = Mesh::default();
    for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        let first = mesh.positions.len() as u32;
        let corners = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
        mesh.positions.extend(corners);
        mesh.normals.extend(corners);
        mesh.tangents.extend(corners.map(|normal| normal.any_orthonormal_vector().extend(1.0)) as [Vec4; 4]);
        mesh.uvs.extend([Vec2::ZERO; 4]);
        let halves = [[first, first + 1, first + 2], [first, first + 2, first + 3]];
        let has_area = |half: &[u32; 3]| {
            let [a, b, c] = half.map(|corner| mesh.positions[corner as usize]);
            (b - a).cross(c - a).length() > 1e-6
        };
        mesh.triangles.extend(halves.into_iter().filter(has_area));
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh.triangle_object = vec![0; mesh.triangles.len()];
    mesh
}
