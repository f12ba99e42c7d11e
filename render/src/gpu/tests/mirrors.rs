//! What mirrors show, against the CPU.

use super::twin::{another, backend};
use crate::{
    Appearance, Backend, Background, Baked, Components, CpuBackend, LitScene, Look, Post, Solution, View,
    device::test_adapter::shared_device,
    gpu::{GpuBackend, GpuPath, ShaderSource},
    lit_scene::edits,
    test_looks::look,
    test_scenes::{
        floor_and_wall, from_below, illumination, into_bowl, mirror, mirror_bowl, mirror_under_plate, point_light,
        rel_rmse, toward_mirror, two_mirrors_and_plate,
    },
};
use glam::Vec3;
use lapidary_core::{camera::Camera, image::Image};
use std::{fs, path::Path};

pub(super) fn shown(backend: impl Backend + 'static, baked: &Baked, look: &Look) -> Image {
    LitScene::new(Box::new(backend), baked.clone()).unwrap().show_whole(look).unwrap().image
}

/// The mirror under its plate, in the sky's light and a lamp's.
pub(super) fn base(baked: &Baked) -> Look {
    let view = View { aa: 4, ..toward_mirror([48, 40]) };
    let components = Components { indirect: false, ..Components::ALL };
    // Its own image in the mirror is outside the picture.
    let lights = [point_light(Vec3::new(1.9, 0.3, 0.0), 8.0)].into();
    Look {
        appearance: Appearance::of(&baked.dataset.scene),
        illumination: from_below(),
        lights,
        components,
        view,
        illum_cut: 64,
        ..look()
    }
}

#[test]
fn mirrors_on_the_gpu_show_what_they_show_on_the_cpu() {
    let Some(_one) = backend() else { return };
    for (alpha, most) in [(0.0025, 0.03), (0.06, 0.03)] {
        let baked = Baked::from(mirror_under_plate(alpha));
        let look = base(&baked);
        let cpu = shown(CpuBackend::new(), &baked, &look);
        let found = rel_rmse(&shown(another(), &baked, &look), &cpu);
        assert!(found < most, "{alpha}: {found}");
        let map = Look { view: View { mirrors: false, ..look.view.clone() }, ..look.clone() };
        let without = rel_rmse(&shown(another(), &baked, &map), &cpu);
        assert!(without > 3.0 * most, "negative control: the map alone, {without}");
        let dark = Look { lights: [].into(), ..look };
        let dark = rel_rmse(&shown(another(), &baked, &dark), &cpu);
        assert!(dark > 3.0 * most, "negative control: without the lamp on the plate, {dark}");
    }
}

#[test]
fn a_sample_whose_passes_are_timed_shows_the_same() {
    let Some(_one) = backend() else { return };
    let baked = Baked::from(mirror_under_plate(0.0025));
    let base = base(&baked);
    let look = Look { view: View { aa: 1, ..base.view.clone() }, ..base };
    let timed = |look: &Look| {
        let mut scene = LitScene::new(Box::new(another()), baked.clone()).unwrap();
        scene.light(look).unwrap();
        scene.begin(&look.view, look.sampling).unwrap();
        scene.backend().timed_sample(0, &Post::default()).unwrap();
        scene.backend().read(1).unwrap().0
    };
    let expected = shown(another(), &baked, &look);
    assert!(timed(&look) == expected);
    let map = Look { view: View { mirrors: false, ..look.view.clone() }, ..look };
    assert!(timed(&map) != expected, "negative control: the map alone");
}

/// The shaders with one of them changed.
fn changed(folder: &Path, file: &str, [from, to]: [&str; 2]) -> GpuBackend {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    for (from, to) in [(shaders.clone(), folder.to_owned()), (shaders.join("brdf"), folder.join("brdf"))] {
        fs::create_dir_all(&to).unwrap();
        for entry in fs::read_dir(from).unwrap().map(Result::unwrap).filter(|entry| entry.path().is_file()) {
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
    let text = fs::read_to_string(folder.join(file)).unwrap();
    assert!(text.contains(from));
    fs::write(folder.join(file), text.replace(from, to)).unwrap();
    let device = shared_device().expect("there was one before");
    GpuBackend::new(device, &ShaderSource::Folder(folder.into()), GpuPath::Fragment).unwrap()
}

#[test]
fn mirrors_in_mirrors_show_the_scene_on_the_gpu_too() {
    let Some(_one) = backend() else { return };
    let folder = tempfile::tempdir().unwrap();
    let camera = Camera::look_at(Vec3::new(1.6, 1.4, 1.4), Vec3::new(-1.6, 0.2, -0.2), 50.0);
    for alpha in [0.0025, 0.03] {
        let baked = Baked::from(two_mirrors_and_plate(alpha));
        let view = View { background: Background::Flat(Vec3::ZERO), aa: 8, ..View::new(camera.clone(), [48, 40]) };
        // A lamp would be a few bright dots in these mirrors.
        let look = Look { view, lights: [].into(), ..base(&baked) };
        let cpu = shown(CpuBackend::new(), &baked, &look);
        let found = rel_rmse(&shown(another(), &baked, &look), &cpu);
        assert!(found < 0.03, "{alpha}: {found}");
        let rule =
            ["if is_catcher && (IS_SECOND || is_in_mirrors()) {", "if (is_catcher && IS_SECOND) || is_in_mirrors() {"];
        let black = changed(folder.path(), "mirror_rays_pass.wgsl", rule);
        let without = rel_rmse(&shown(black, &baked, &look), &cpu);
        assert!(without > 2.0 * found + 0.02, "negative control: mirrors in mirrors are black, {without} for {found}");
    }
}

#[test]
fn cones_of_curved_mirrors_agree() {
    let Some(_one) = backend() else { return };
    let baked = Baked::from(mirror_bowl(0.0025));
    let view = View { aa: 4, ..View::new(into_bowl(), [40, 40]) };
    let illumination = illumination([256, 128], |x, y| Vec3::splat(if x / 3 == 30 && y / 3 == 7 { 5.5 } else { 0.2 }));
    let look = Look { view, illumination, lights: [].into(), ..base(&baked) };
    let cpu = shown(CpuBackend::new(), &baked, &look);
    let found = rel_rmse(&shown(another(), &baked, &look), &cpu);
    assert!(found < 0.03, "{found}");
    let folder = tempfile::tempdir().unwrap();
    let bent = ["select(sums.x, -sums.x, (flags & FLAG_BACK) != 0u)", "-sums.x"];
    let without = rel_rmse(&shown(changed(folder.path(), "cone.wgsl", bent), &baked, &look), &cpu);
    assert!(without > 2.0 * found + 0.01, "negative control: curved to the other side, {without} for {found}");
}

#[test]
fn edits_reach_what_mirrors_show() {
    let Some(_one) = backend() else { return };
    edits::edits_reach_what_mirrors_show(another);
}

/// The display of the first of some samples.
fn first_sample(backend: impl Backend + 'static, baked: &Baked, look: &Look, samples: u32) -> Vec<[u8; 4]> {
    let view = View { aa: samples, ..look.view.clone() };
    let mut scene = LitScene::new(Box::new(backend), baked.clone()).unwrap();
    scene.light(&Look { view: view.clone(), ..look.clone() }).unwrap();
    scene.begin(&view, look.sampling).unwrap();
    scene.render_rows(0, 0..view.size[1]).unwrap();
    scene.backend().display(&look.post, 1).unwrap()
}

/// Mean difference of two displays.
fn apart(a: &[[u8; 4]], b: &[[u8; 4]]) -> f64 {
    let sum: u32 = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
    f64::from(sum) / a.len() as f64
}

#[test]
fn reflections_of_one_sample_are_smooth_and_rest_is_as_rendered() {
    let Some(_one) = backend() else { return };
    let baked = Baked::from(mirror_under_plate(0.08));
    let look = base(&baked);
    let [cpu, gpu] = [first_sample(CpuBackend::new(), &baked, &look, 4), first_sample(another(), &baked, &look, 4)];
    let raw = first_sample(CpuBackend::new(), &baked, &look, 1);
    let found = apart(&cpu, &gpu);
    assert!(found < 0.5, "{found}");
    let many = Look { view: View { aa: 64, ..look.view.clone() }, ..look.clone() };
    let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
    scene.show_whole(&many).unwrap();
    let rest = scene.backend().display(&look.post, 64).unwrap();
    let [smooth, noisy] = [apart(&cpu, &rest), apart(&raw, &rest)];
    assert!(smooth < 0.7 * noisy, "{smooth} {noisy}");
}

/// Bounced light of sources: in mirrors, and without what rays give.
#[test]
fn mirrors_beside_bounced_light_agree() {
    let Some(_one) = backend() else { return };
    for alpha in [0.0025, 0.1] {
        let mut dataset = floor_and_wall(6);
        dataset.scene.materials[0] = mirror(alpha);
        let baked = Baked::from(dataset);
        let camera = Camera::look_at(Vec3::new(1.8, 1.2, 0.6), Vec3::new(-1.0, 0.1, 0.0), 50.0);
        let view = View { aa: 8, background: Background::Flat(Vec3::ZERO), ..View::new(camera, [48, 36]) };
        let lights = [point_light(Vec3::new(-1.0, 1.4, 0.2), 3.0)].into();
        let look = Look { lights, components: Components::ALL, view, solution: Solution::Cuts, ..base(&baked) };
        let cpu = shown(CpuBackend::new(), &baked, &look);
        let found = rel_rmse(&shown(another(), &baked, &look), &cpu);
        assert!(found < 0.04, "{alpha}: {found}");
        let map = Look { view: View { mirrors: false, ..look.view.clone() }, ..look };
        let without = rel_rmse(&shown(another(), &baked, &map), &cpu);
        assert!(without > 2.0 * found, "negative control: mirrors as baked, {without} for {found}");
    }
}
