//! Sketches of CPU and GPU agree, and a sketch leaves no trace in the picture.

use super::twin::{appearance, backend, maps, scene, view};
use crate::{
    Backend, BackendError, BrdfSampling, CpuBackend, Illumination, LocalLighting, Renderer, STRIDES, Stale, Tiles,
    View, ViewMode,
    test_scenes::{illumination, point_light, rel_rmse},
};
use glam::Vec3;
use lapidary_core::{
    brdf::GgxParameters,
    image::Image,
    material::{BrdfModel, MaterialMaps},
};

fn light() -> Illumination {
    illumination([64, 32], |x, y| Vec3::splat(0.1 * x as f32 + 0.02 * y as f32))
}

pub(super) fn prepare(backend: &mut dyn Backend) {
    let dataset = scene();
    backend.set_scene(&dataset.clone().into()).unwrap();
    let lighting = Renderer::new(dataset.clone()).lighting(&light(), 64);
    backend.set_light(&light(), &lighting.into()).unwrap();
    let local = LocalLighting { lights: [point_light(Vec3::new(0.5, 2.0, 0.5), 3.0)].into(), ..Default::default() };
    backend.set_local_lighting(&local).unwrap();
    let parameters = GgxParameters { base_color: Vec3::new(0.7, 0.4, 0.2), roughness: 0.6, ..Default::default() };
    backend.set_appearance(&appearance(&dataset, BrdfModel::Ggx, parameters, MaterialMaps::default())).unwrap();
}

pub(super) fn sketched(backend: &mut dyn Backend, view: &View, stride: u32) -> Image {
    backend.begin(view, BrdfSampling::Refine).unwrap();
    let tiles: Vec<u32> = (0..Tiles::of(view.size).count()).collect();
    let wanted = STRIDES.iter().filter(|&&s| s >= stride);
    // In parts, as in the window.
    wanted.for_each(|&stride| tiles.chunks(1).for_each(|part| backend.sketch(stride, part).unwrap()));
    if stride > 1 {
        backend.fill(0).unwrap();
    }
    backend.read(u32::from(stride == 1)).unwrap().0
}

#[test]
fn sketches_are_those_of_the_cpu() {
    let Some((_guard, mut gpu)) = backend() else { return };
    let mut cpu = CpuBackend::new();
    prepare(&mut gpu);
    prepare(&mut cpu);
    for mode in [ViewMode::Shaded, ViewMode::Normals, ViewMode::MergedCut] {
        let view = View { size: [150, 100], ..view(mode) };
        let error = |gpu: &Image, cpu: &Image| rel_rmse(gpu, cpu);
        for stride in [8, 4, 2] {
            let [on_gpu, on_cpu] = [&mut gpu as &mut dyn Backend, &mut cpu].map(|b| sketched(b, &view, stride));
            // Edges may lie in different pixels, and so do shadows of maps and of rays.
            let apart = error(&on_gpu, &on_cpu);
            let coarser = error(&on_gpu, &sketched(&mut cpu, &view, 1));
            assert!(apart < 0.05, "{mode:?} {stride}: {apart}");
            assert!(coarser > 2.0 * apart, "negative control: {mode:?} {stride}: {coarser} {apart}");
        }
    }
}

/// A coarse sketch after one of another view.
pub(super) fn sketched_after(backend: &mut dyn Backend, before: (&View, u32), view: &View, stale: &Stale) -> Image {
    sketched(backend, before.0, before.1);
    backend.resume(view, BrdfSampling::Refine, stale).unwrap();
    let tiles: Vec<u32> = (0..Tiles::of(view.size).count()).collect();
    backend.sketch(8, &tiles).unwrap();
    backend.fill(0).unwrap();
    backend.read(0).unwrap().0
}

#[test]
fn after_a_move_sketches_are_those_of_the_cpu() {
    let Some((_guard, mut gpu)) = backend() else { return };
    let mut cpu = CpuBackend::new();
    prepare(&mut gpu);
    prepare(&mut cpu);
    let view = View { size: [150, 100], ..view(ViewMode::Shaded) };
    let mut moved = view.clone();
    moved.camera.eye += 0.1;
    let reduced = View { size: [100, 70], ..moved.clone() };
    let alone = sketched(&mut cpu, &moved, 8);
    for before in [(&view, 1), (&view, 4), (&reduced, 1)] {
        let [on_gpu, on_cpu] =
            [&mut gpu as &mut dyn Backend, &mut cpu].map(|b| sketched_after(b, before, &moved, &Stale::NOTHING));
        let (apart, without) = (rel_rmse(&on_gpu, &on_cpu), rel_rmse(&on_gpu, &alone));
        assert!(apart < 0.03, "{before:?}: {apart}");
        assert!(without > 2.0 * apart, "negative control: {before:?}: {without} {apart}");
    }
    let other_light = sketched_after(&mut gpu, (&view, 1), &moved, &Stale::ALL);
    assert!(other_light == sketched(&mut gpu, &moved, 8));
}

#[test]
fn lights_that_were_added_are_in_the_detail() {
    let Some((_guard, mut gpu)) = backend() else { return };
    let mut cpu = CpuBackend::new();
    let view = View { size: [150, 100], ..view(ViewMode::Shaded) };
    let mut moved = view.clone();
    moved.camera.eye += 0.1;
    let lamps = [point_light(Vec3::new(0.5, 2.0, 0.5), 3.0), point_light(Vec3::new(-1.0, 1.5, 0.8), 4.0)];
    let added = LocalLighting { lights: lamps.into(), ..Default::default() };
    let tiles: Vec<u32> = (0..Tiles::of(view.size).count()).collect();
    let after = |backend: &mut dyn Backend, keeps: bool| {
        prepare(backend);
        sketched(backend, &view, 1);
        backend.set_local_lighting(&added).unwrap();
        backend.resume(&view, BrdfSampling::Refine, &Stale { lights: true, ..Stale::NOTHING }).unwrap();
        STRIDES.iter().for_each(|&stride| backend.sketch(stride, &tiles).unwrap());
        let stale = if keeps { Stale::NOTHING } else { Stale::ALL };
        backend.resume(&moved, BrdfSampling::Refine, &stale).unwrap();
        backend.sketch(8, &tiles).unwrap();
        backend.fill(0).unwrap();
        backend.read(0).unwrap().0
    };
    let [on_gpu, on_cpu] = [&mut gpu as &mut dyn Backend, &mut cpu].map(|backend| after(backend, true));
    let (apart, alone) = (rel_rmse(&on_gpu, &on_cpu), rel_rmse(&on_gpu, &after(&mut cpu, false)));
    assert!(apart < 0.05 && alone > 1.5 * apart, "{apart} {alone}");
}

#[test]
fn a_picture_that_is_too_large_leaves_the_renderer_as_it_was() {
    let Some((_guard, mut gpu)) = backend() else { return };
    prepare(&mut gpu);
    let view = View { size: [150, 100], ..view(ViewMode::Shaded) };
    let sketch = sketched(&mut gpu, &view, 1);
    let large = View { size: [100_000, 4], ..view.clone() };
    let error = gpu.resume(&large, BrdfSampling::Refine, &Stale::NOTHING).unwrap_err();
    assert!(matches!(error, BackendError::Limit { .. }), "{error}");
    assert!(sketched(&mut gpu, &view, 1) == sketch);
}

#[test]
fn pictures_with_several_samples_tell_of_the_next_too() {
    let Some((_guard, mut gpu)) = backend() else { return };
    prepare(&mut gpu);
    let view = View { aa: 4, size: [150, 100], ..view(ViewMode::Shaded) };
    let mut moved = view.clone();
    moved.camera.eye += 0.1;
    let full = sketched(&mut gpu, &moved, 1);
    let after = |gpu: &mut dyn Backend, samples: u32| {
        sketched(gpu, &view, 1);
        (1..samples).for_each(|sample| gpu.render_rows(sample, 0..100).unwrap());
        gpu.resume(&moved, BrdfSampling::Refine, &Stale::NOTHING).unwrap();
        gpu.sketch(8, &(0..Tiles::of(view.size).count()).collect::<Vec<_>>()).unwrap();
        gpu.fill(0).unwrap();
        rel_rmse(&gpu.read(0).unwrap().0, &full)
    };
    let (one, four) = (after(&mut gpu, 1), after(&mut gpu, 4));
    let alone = rel_rmse(&sketched(&mut gpu, &moved, 8), &full);
    assert!(one < 0.6 * alone && four < 0.7 * alone, "{one} {four} {alone}");
}

#[test]
fn the_last_lattice_is_the_sample_and_further_samples_follow() {
    let Some((_guard, mut gpu)) = backend() else { return };
    prepare(&mut gpu);
    let view = View { aa: 2, size: [150, 100], ..view(ViewMode::Shaded) };
    let sketch = sketched(&mut gpu, &view, 1);
    let stats = gpu.stats().unwrap();
    gpu.render_rows(1, 0..100).unwrap();
    let both = gpu.read(2).unwrap().0;
    gpu.begin(&view, BrdfSampling::Refine).unwrap();
    gpu.render_rows(0, 0..100).unwrap();
    assert!(gpu.read(1).unwrap().0 == sketch && gpu.stats().unwrap() == stats);
    gpu.render_rows(1, 0..100).unwrap();
    assert!(gpu.read(2).unwrap().0 == both && both != sketch);
    sketched(&mut gpu, &view, 4);
    gpu.render_rows(0, 0..100).unwrap();
    assert!(gpu.read(1).unwrap().0 == sketch, "an unfinished sketch leaves nothing");
}

#[test]
fn small_pictures_and_maps_are_defined() {
    let Some((_guard, mut gpu)) = backend() else { return };
    prepare(&mut gpu);
    let parameters = GgxParameters { base_color: Vec3::ONE, ..Default::default() };
    gpu.set_appearance(&appearance(&scene(), BrdfModel::Ward, parameters, maps())).unwrap();
    for size in [[1, 1], [3, 2], [9, 65]] {
        let image = sketched(&mut gpu, &View { size, wireframe: true, ..view(ViewMode::Shaded) }, 8);
        assert!(image.size == size && image.pixels.iter().all(|p| p.is_finite()), "{size:?}");
    }
}
