//! Wavelet transport in a bake: made, verified, refused, and computed anew after an edit.

use super::*;
use crate::{
    bake::{
        BakeJob, bake, bake_shard, merge,
        settings::{Preset, resolve},
        update::update,
    },
    observer::Silent,
    shard::Shard,
    test_scenes::{floor, quad, scene_of},
    verify,
};
use glam::Vec3;
use lapidary_core::{
    dataset::{BakeParts, BakeSettings, Dataset},
    scene::{
        Object,
        pose::{Pose, Poses},
    },
    texture::{Texels, Texture, TextureSlot},
    wavelet::patch::patch_of_triangles,
};

/// A floor below a ceiling, which are two objects.
fn floor_and_ceiling(height: f32) -> Scene {
    let corner = |x: f32, z: f32| Vec3::new(x, height, z);
    let ceiling = quad(corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5));
    let mut scene = scene_of(&[floor(1.0, 0.0), ceiling].concat());
    scene.objects = ["floor", "ceiling"].map(|name| Object { name: name.into() }).into();
    scene.mesh.triangle_object = vec![0, 0, 1, 1];
    scene
}

fn settings() -> BakeSettings {
    BakeSettings { mode: BakeParts::WAVELET, max_vertices: Some(400), ..Preset::Draft.settings() }
}

fn baked(scene: Scene) -> Result<Dataset, BakeError> {
    let folder = tempfile::tempdir().unwrap();
    bake(scene, &BakeJob::new(resolve(settings()).unwrap(), folder.path().join("a.cuts")), &Silent)
}

fn edited(before: &Dataset, pose: Pose) -> Dataset {
    let mut poses = Poses::default();
    poses.set(1, pose);
    let mut scene = before.scene.clone();
    scene.place_again(&poses).unwrap();
    update(before, scene, &Silent).unwrap()
}

/// Relative difference of one bounce.
fn difference(a: &Dataset, b: &Dataset) -> f64 {
    let [a, b] = [a, b].map(|dataset| dataset.wavelet.as_ref().unwrap());
    if a.basis != b.basis {
        return f64::INFINITY;
    }
    let none = b.direct.compressed(f32::INFINITY);
    (a.direct.squared_distance(&b.direct) / b.direct.squared_distance(&none)).sqrt()
}

#[test]
fn a_bake_has_the_transport_of_its_quads_and_verify_finds_another_one() {
    let mut dataset = baked(floor_and_ceiling(1.0)).unwrap();
    let transport = dataset.wavelet.clone().unwrap();
    assert_eq!(transport.patches.len(), 2);
    assert!(dataset.scene.mesh.triangles.len() > 20, "it is split");
    let patches: Vec<_> = transport.patches.iter().map(|reflecting| reflecting.patch).collect();
    assert!(patch_of_triangles(&dataset.scene.mesh, &patches).iter().all(Option::is_some));
    let report = dataset.report.wavelet.clone().unwrap();
    assert_eq!((report.direct, report.global), (transport.direct.len(), transport.global.len()));
    let found = verify(&dataset, 100);
    assert!(found.passed && found.wavelet.as_ref().unwrap().pairs == 4, "{found:?}");
    let mut changed = (*transport).clone();
    changed.direct = changed.direct.plus(&lapidary_core::wavelet::operator::Operator::identity(report.functions));
    dataset.wavelet = Some(changed.into());
    assert!(!verify(&dataset, 100).passed, "negative control");
    let mut changed = (*transport).clone();
    changed.global = changed.global.plus(&lapidary_core::wavelet::operator::Operator::identity(report.functions));
    dataset.wavelet = Some(changed.into());
    assert!(!verify(&dataset, 100).passed, "negative control: all bounces");
}

#[test]
fn a_scene_of_other_surfaces_is_refused_with_the_triangle() {
    let mut triangles = floor(1.0, 0.0).to_vec();
    triangles.push([Vec3::Y, Vec3::Y + Vec3::X, Vec3::Y + Vec3::Z]);
    let text = baked(scene_of(&triangles)).unwrap_err().to_string();
    assert!(text.contains("triangle 2") && text.contains("leave wavelet transport out with mode"), "{text}");
}

#[test]
fn shares_have_it_and_maps_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob::new(resolve(settings()).unwrap(), folder.path().join("a.cuts"));
    let mut scene = floor_and_ceiling(1.0);
    scene.textures = vec![Texture::new("map", [1, 1], Texels::U8(vec![[9; 4]])).into()];
    scene.materials[0].maps.set("base_color", Some(TextureSlot::default()));
    for shard in Shard::all(2) {
        bake_shard(scene.clone(), &job, shard, None, &Silent).unwrap();
    }
    let merged = merge(&job.output, lapidary_interchange::image::decode, &Silent).unwrap();
    let whole = bake(scene, &job, &Silent).unwrap();
    assert_eq!(merged.report.wavelet, whole.report.wavelet);
    assert!(difference(&merged, &whole) < 1e-6);
    assert!(
        whole.report.warnings.iter().any(|warning| warning.contains("reads no maps")),
        "{:?}",
        whole.report.warnings
    );
    let plain = baked(floor_and_ceiling(1.0)).unwrap().report.warnings;
    assert!(!plain.iter().any(|warning| warning.contains("reads no maps")), "negative control: {plain:?}");
}

#[test]
fn after_a_move_it_is_that_of_a_fresh_bake() {
    let before = baked(floor_and_ceiling(1.0)).unwrap();
    let fresh = baked(floor_and_ceiling(0.75)).unwrap();
    let moved = edited(&before, Pose { translate: Vec3::NEG_Y * 0.25, ..Pose::AS_BAKED });
    let found = difference(&moved, &fresh);
    assert!(found < 1e-3, "{found}");
    assert!(difference(&before, &fresh) > 0.05, "negative control: {}", difference(&before, &fresh));
}

#[test]
fn a_hidden_object_takes_no_part_until_it_is_shown() {
    let before = baked(floor_and_ceiling(1.0)).unwrap();
    let hidden = edited(&before, Pose { hidden: true, ..Pose::AS_BAKED });
    assert!(hidden.wavelet.as_ref().unwrap().direct.is_empty());
    assert!(!before.wavelet.as_ref().unwrap().direct.is_empty(), "negative control");
    assert!(difference(&edited(&hidden, Pose::AS_BAKED), &before) < 1e-3);
}
