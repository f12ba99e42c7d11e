//! Fragments and kernels have one body: their pixels are equal to the bit.

use super::{
    bounce, direct, meshless, mirrors, sketch,
    twin::{backend, backend_of, on_path, view},
    wavelet,
};
use crate::{
    Backend, Baked, BrdfSampling, Components, LocalLighting, Look, Solution, Stale, View, ViewMode,
    gpu::{GpuBackend, GpuPath, ShaderSource},
    test_scenes::{floor_and_wall, mirror, mirror_under_plate, point_light},
};
use glam::Vec3;
use lapidary_core::{image::Image, material::BrdfModel};

const PATHS: [GpuPath; 2] = [GpuPath::Fragment, GpuPath::Compute];

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels.iter().map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
}

/// Fails unless both are equal to the bit, and show something.
fn assert_same(fragments: &Image, kernels: &Image, what: &str) {
    let differing = bits(fragments).iter().zip(&bits(kernels)).filter(|(a, b)| a != b).count();
    assert!(fragments.size == kernels.size && differing == 0, "{what}: {differing} pixels differ");
    let first = fragments.pixels[0];
    assert!(fragments.pixels.iter().any(|&pixel| pixel != first), "{what} shows nothing");
}

fn drawn_by_both(gpu: &mut GpuBackend, mut draw: impl FnMut(&mut GpuBackend) -> Image, what: &str) {
    let [fragments, kernels] = PATHS.map(|path| {
        gpu.set_path(path).unwrap();
        draw(gpu)
    });
    assert_same(&fragments, &kernels, what);
}

/// Two samples of every pixel, in bands.
fn picture(gpu: &mut GpuBackend, view: &View, sampling: BrdfSampling) -> Image {
    gpu.begin(view, sampling).unwrap();
    let [_, height] = view.size;
    for sample in 0..2 {
        [0..height / 3, height / 3..height].into_iter().for_each(|band| gpu.render_rows(sample, band).unwrap());
    }
    gpu.read(2).unwrap().0
}

#[test]
fn pictures_and_sketches_are_the_same() {
    let Some((_one, mut gpu)) = backend() else { return };
    sketch::prepare(&mut gpu);
    for sampling in [BrdfSampling::Refine, BrdfSampling::Lit, BrdfSampling::Once] {
        let view = View { aa: 2, wireframe: true, ..view(ViewMode::Shaded) };
        drawn_by_both(&mut gpu, |gpu| picture(gpu, &view, sampling), &format!("{sampling:?}"));
    }
    for mode in [ViewMode::Normals, ViewMode::Albedo, ViewMode::MergedCut] {
        drawn_by_both(&mut gpu, |gpu| picture(gpu, &view(mode), BrdfSampling::Refine), &format!("{mode:?}"));
    }
    // More areas than a kernel takes at a time.
    let view = View { size: [600, 480], ..view(ViewMode::Shaded) };
    drawn_by_both(&mut gpu, |gpu| sketch::sketched(gpu, &view, 4), "a sketch");
    let mut moved = view.clone();
    moved.camera.eye += 0.1;
    let after = |gpu: &mut GpuBackend| sketch::sketched_after(gpu, (&view, 1), &moved, &Stale::NOTHING);
    drawn_by_both(&mut gpu, after, "a sketch after a picture");
}

#[test]
fn suns_are_the_same() {
    let Some((_one, mut gpu)) = backend() else { return };
    sketch::prepare(&mut gpu);
    let lights = direct::suns::suns();
    gpu.set_local_lighting(&LocalLighting { lights: lights.into(), ..Default::default() }).unwrap();
    let view = View { size: [150, 100], ..view(ViewMode::Shaded) };
    drawn_by_both(&mut gpu, |gpu| picture(gpu, &view, BrdfSampling::Refine), "suns");
    drawn_by_both(&mut gpu, |gpu| sketch::sketched(gpu, &view, 4), "a sketch with suns");
}

#[test]
fn bounced_light_is_the_same() {
    if let Some(mut rig) = bounce::Rig::new(BrdfModel::Ggx, 0.4) {
        for sampling in [BrdfSampling::Refine, BrdfSampling::Lit] {
            let draw = |gpu: &mut GpuBackend| picture(gpu, &view(ViewMode::Shaded), sampling);
            drawn_by_both(&mut rig.gpu, draw, "sources");
        }
    }
    if let Some(mut rig) = meshless::Rig::new() {
        for mode in [ViewMode::Shaded, ViewMode::BasisLevel] {
            let draw = |gpu: &mut GpuBackend| picture(gpu, &view(mode), BrdfSampling::Refine);
            drawn_by_both(&mut rig.gpu, draw, "meshless functions");
        }
    }
    let Some((_one, mut gpu)) = backend() else { return };
    let baked = wavelet::baked();
    gpu.set_scene(&baked).unwrap();
    let light = wavelet::lit(&baked, 8.0);
    drawn_by_both(&mut gpu, |gpu| wavelet::picture(gpu, &light), "wavelet transport");
}

#[test]
fn light_that_is_sent_by_direction_is_the_same() {
    let Some((_one, mut gpu)) = backend() else { return };
    let (baked, local) = meshless::sent_by_metal();
    gpu.set_scene(&baked).unwrap();
    gpu.set_local_lighting(&local).unwrap();
    let draw = |gpu: &mut GpuBackend| picture(gpu, &meshless::wall_view(), BrdfSampling::Refine);
    drawn_by_both(&mut gpu, draw, "sources of metal");
}

#[test]
fn mirrors_are_the_same() {
    let Some(_one) = backend() else { return };
    let mut wall = floor_and_wall(6);
    wall.scene.materials[0] = mirror(0.1);
    for baked in [Baked::from(mirror_under_plate(0.0025)), Baked::from(wall)] {
        let lamp = point_light(Vec3::new(-1.0, 1.4, 0.2), 3.0);
        let lights = [lamp, direct::suns::suns().remove(2)].into();
        let look = Look { lights, components: Components::ALL, solution: Solution::Cuts, ..mirrors::base(&baked) };
        let [fragments, kernels] = PATHS.map(|path| mirrors::shown(on_path(path), &baked, &look));
        assert_same(&fragments, &kernels, "mirrors");
    }
}

/// Kernels that are off by a texel.
fn shifted(text: &str) -> String {
    text.replace("= written_at(texel);", "= written_at(texel + 1u);")
}

#[test]
fn kernels_draw_where_they_are_asked_for() {
    let Some((_one, mut gpu)) = backend_of(&ShaderSource::Changed(shifted)) else { return };
    sketch::prepare(&mut gpu);
    let [right, off] = PATHS.map(|path| {
        gpu.set_path(path).unwrap();
        picture(&mut gpu, &view(ViewMode::Shaded), BrdfSampling::Refine)
    });
    assert_ne!(bits(&right), bits(&off), "kernels that are off by a texel show something else");
}
