//! Thin surfaces: what the camera sees through them, and what shadow maps let through, against the CPU.

use super::twin::backend;
use crate::{
    Appearance, Backend, BrdfSampling, Components, LocalLighting, Renderer, View,
    shade::direct::DirectLights,
    shade::{
        background::Backdrop,
        pixel_sampler::{
            PixelSampler,
            tests::{panes, panes_of_a_part},
        },
        surface::FirstHit,
    },
    test_scenes::{from_above, point_light},
};
use glam::Vec3;
use lapidary_core::{
    dataset::Dataset,
    lights::{Emission, Light},
    texture::{Procedural, TextureSlot},
};

/// Panes that let half of the light through, and have holes.
fn appearance(opacity: f32, cutoff: f32) -> Appearance {
    let mut appearance = Appearance::of(&panes(opacity).scene);
    let pane = &mut appearance.materials[1];
    let checker = Procedural { low: Vec3::splat(0.1), ..Default::default() };
    pane.maps.set("geometry_opacity", Some(TextureSlot { procedural: Some(checker), ..Default::default() }));
    pane.parameters.set("opacity_cutoff", cutoff);
    appearance
}

#[test]
fn pixels_see_the_same_triangles_in_each_sample() {
    let Some((_one, mut gpu)) = backend() else { return };
    let mut renderer = Renderer::new(panes(1.0));
    gpu.set_scene(&renderer.dataset().clone().into()).unwrap();
    let view = View { aa: 32, ..from_above(64) };
    for (opacity, cutoff) in [(0.5, 0.0), (0.9, 0.5), (1.0, 0.0)] {
        let looks = if opacity < 1.0 { appearance(opacity, cutoff) } else { Appearance::of(&panes(1.0).scene) };
        gpu.set_appearance(&looks).unwrap();
        renderer.set_appearance(looks);
        gpu.begin(&view, BrdfSampling::Once).unwrap();
        let backdrop = Backdrop::black();
        let sampler = PixelSampler::new(&renderer, &view, &backdrop);
        let (mut differ, mut other, mut through) = (0, 0, 0);
        for sample in [0, 3, 17] {
            (0..=sample).for_each(|sample| gpu.render_rows(sample, 0..64).unwrap());
            for (i, [id, ..]) in gpu.read_geometry().into_iter().enumerate() {
                let (x, y) = (i as u32 % 64, i as u32 / 64);
                let material = |sample| match sampler.sight(x, y, sample).seen {
                    FirstHit::Surface(point) => Some(point.material),
                    FirstHit::Back | FirstHit::Background => None,
                };
                let found = (id as usize).checked_sub(1).map(|t| renderer.dataset().scene.mesh.triangle_material[t]);
                differ += usize::from(found != material(sample as usize));
                other += usize::from(found != material(sample as usize + 1));
                let in_the_middle = (28..36).contains(&x) && (28..36).contains(&y);
                through += usize::from(in_the_middle && found == Some(0));
            }
        }
        assert!(differ * 200 < 3 * 64 * 64, "{opacity}, {cutoff}: {differ}");
        assert!((opacity == 1.0) == (through == 0), "{through}");
        assert!(
            opacity != 0.5 || other > 10 * differ.max(10),
            "negative control: thresholds of another sample, {other}"
        );
    }
}

#[test]
fn parts_let_light_through_as_they_were_baked() {
    let Some((_one, mut gpu)) = backend() else { return };
    let mut seen = |dataset: Dataset| {
        gpu.set_scene(&dataset.into()).unwrap();
        gpu.begin(&from_above(64), BrdfSampling::Once).unwrap();
        gpu.render_rows(0, 0..64).unwrap();
        gpu.read_geometry()
    };
    let [material, part, opaque] = [panes(0.4), panes_of_a_part(0.4), panes_of_a_part(1.0)].map(&mut seen);
    assert!(part == material);
    assert!(part != opaque, "negative control");
}

#[test]
fn shadow_maps_let_through_what_rays_do() {
    // In the shadow of the panes, and beside them as the camera sees it.
    let is_in_shadow = |x: f32, y: f32| (12.6..14.4).contains(&x.abs().max(y.abs()));
    lets_through_what_it_does_on_the_cpu(&point_light(Vec3::new(0.0, 3.0, 0.0), 4.0), is_in_shadow);
}

#[test]
fn rays_to_suns_pass_what_they_pass_on_the_cpu() {
    for angle_degrees in [0.0, 2.0] {
        let emission = Emission::Directional { angle_degrees };
        let sun = Light { emission, ..point_light(Vec3::new(1.0, 1.0, 0.0), 1.0) };
        lets_through_what_it_does_on_the_cpu(&sun, |x, y| (-24.0..-16.0).contains(&x) && y.abs() < 7.0);
    }
}

/// Means over pixels that the panes shade, told by their offset from the middle.
fn lets_through_what_it_does_on_the_cpu(light: &Light, is_in_shadow: impl Fn(f32, f32) -> bool) {
    let Some((_one, mut gpu)) = backend() else { return };
    let lamp = [light.clone()];
    let view = View { aa: 4, ..from_above(64) };
    let shaded = |gpu: &mut crate::gpu::backend::GpuBackend, opacity: f32| {
        let dataset = panes(opacity);
        let renderer = Renderer::new(dataset);
        let baked: crate::Baked = renderer.dataset().clone().into();
        gpu.set_scene(&baked).unwrap();
        let components = Components { direct: true, ..Components::NONE };
        let lighting = LocalLighting { components, lights: lamp.to_vec().into(), ..Default::default() };
        gpu.set_local_lighting(&lighting).unwrap();
        gpu.begin(&view, BrdfSampling::Once).unwrap();
        (0..view.aa).for_each(|sample| gpu.render_rows(sample, 0..64).unwrap());
        let found = gpu.read(view.aa).unwrap().0;
        let backdrop = Backdrop::black();
        let sampler = PixelSampler::new(&renderer, &view, &backdrop);
        let from_middle = |x: u32| x as f32 - 31.5;
        let all = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let pixels: Vec<(u32, u32)> = all.filter(|&(x, y)| is_in_shadow(from_middle(x), from_middle(y))).collect();
        let cpu = |(x, y): (u32, u32)| {
            let shade = |point: &crate::shade::surface::SurfacePoint| {
                DirectLights { lights: &lamp, intersector: renderer.intersector() }
                    .shader()
                    .reflected(point, glam::Vec2::ZERO)
                    + point.emission
            };
            sampler.pixel(x, y, shade).x
        };
        let gpu_sum: f32 = pixels.iter().map(|&(x, y)| found.pixels[(y * 64 + x) as usize].x).sum();
        let cpu_sum: f32 = pixels.iter().map(|&pixel| cpu(pixel)).sum();
        (gpu_sum / pixels.len() as f32, cpu_sum / pixels.len() as f32)
    };
    let found = [0.0, 0.4, 1.0].map(|opacity| shaded(&mut gpu, opacity));
    for (gpu, cpu) in found {
        assert!((gpu - cpu).abs() < 0.05 * cpu.max(0.02), "{found:?}");
    }
    let [(none, _), (some, _), (all, _)] = found;
    assert!(none > 1.5 * some && some > 1.5 * all, "negative control: {found:?}");
}
