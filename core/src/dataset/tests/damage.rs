//! Damage that only the part-by-part check finds.

use super::*;
use crate::{
    camera::Camera,
    lights::{Emission, Light},
    test_files::{FileParts, FileTensor},
};

/// The reason why a dataset is not written.
pub fn refusal(dataset: &Dataset) -> String {
    dataset.validate().unwrap_err().to_string()
}

#[test]
fn a_damaged_meshless_basis_is_named() {
    let error_of = |change: &dyn Fn(&mut MeshlessBake)| {
        let mut dataset = with_meshless();
        change(Arc::make_mut(dataset.meshless.as_mut().unwrap()));
        refusal(&dataset)
    };
    let changed = |bake: &MeshlessBake, change: &dyn Fn(&mut Surfel)| {
        let mut points = bake.basis.points().to_vec();
        change(&mut points[3]);
        Basis::from_parts(points, bake.basis.offsets().to_vec(), bake.basis.radii().to_vec(), 1).unwrap()
    };
    let triangle = error_of(&|b| b.basis = changed(b, &|p| p.place.triangle = 1));
    assert!(triangle.contains("function 3") && triangle.contains("but there are 1"), "{triangle}");
    let place = error_of(&|b| b.basis = changed(b, &|p| p.place.barycentric.y = f32::NAN));
    assert!(place.contains("function 3") && place.contains("not a finite number"), "{place}");
    let links = error_of(&|b| b.transport = Transport::from_rows(&vec![vec![(0, Vec3::X)]; 5], 3));
    assert!(links.contains("5 receivers and 2 senders"), "{links}");
    let strong = Transport::from_rows(&vec![vec![(0, 100.0 * Vec3::X)]; 5], 2);
    assert!(error_of(&|b| b.transport = strong.clone()).contains("a scale of 0.003"));
}

#[test]
fn lights_and_cameras_that_are_none_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let written = |change: &dyn Fn(&mut Scene)| {
        let mut dataset = dataset();
        let emission = Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 };
        let light = Light { name: "Desk".into(), emission, position: Vec3::Y, ..Default::default() };
        dataset.scene.lights = vec![light.clone(), light];
        dataset.scene.cameras = vec![Camera { name: "Door".into(), ..Camera::look_at(Vec3::Z, Vec3::ZERO, 40.0) }];
        change(&mut dataset.scene);
        dataset.write(&path).map_err(|e| e.to_string())
    };
    assert!(written(&|_| ()).is_ok());
    let wide = Emission::Spot { cone_degrees: 200.0, penumbra_degrees: 5.0 };
    let cone = written(&|scene| scene.lights[1].emission = wide).unwrap_err();
    assert!(cone.contains("light 1 (`Desk`)") && cone.contains("200"), "{cone}");
    let negative = written(&|scene| scene.lights[0].intensity.y = -1.0).unwrap_err();
    assert!(negative.contains("light 0") && negative.contains("negative"), "{negative}");

    written(&|scene| scene.cameras[0].eye.x = 3.25e8).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    replace(&mut bytes, "325000000.0", "3.25e19");
    std::fs::write(&path, bytes).unwrap();
    let camera = read(&path).unwrap_err().to_string();
    assert!(camera.contains("camera 0 (`Door`)"), "{camera}");
}

#[test]
fn what_could_not_be_read_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    dataset().write(&path).unwrap();
    let before = std::fs::read(&path).unwrap();
    let refused = |change: &dyn Fn(&mut Dataset)| {
        let mut dataset = with_sources();
        change(&mut dataset);
        let error = dataset.write(&path).unwrap_err();
        assert!(matches!(error, DatasetError::Unwritable { .. }), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), before, "nothing was written");
        error.to_string()
    };
    let slot = TextureSlot { scale: Vec2::new(f32::INFINITY, 1.0), ..Default::default() };
    let scale = refused(&|d| d.scene.materials[0].maps.set("bump", Some(slot.clone())));
    assert!(scale.contains("material 0 (`m`)") && scale.contains("its scale of the map bump inf"), "{scale}");
    let report = refused(&|d| d.report.rms_visibility = f64::NAN);
    assert!(report.contains("metadata") && report.contains("null"), "{report}");
    let far = refused(&|d| d.scene.mesh.positions[1].x = 3e38);
    assert!(far.contains("position 1 is 3e38") && far.contains("1e9"), "{far}");
    let tiny = refused(&|d| d.scene.mesh.positions.iter_mut().for_each(|p| *p *= 1e-7));
    assert!(tiny.contains("scale the scene up"), "{tiny}");
    let normal = refused(&|d| d.scene.mesh.normals[2] = Vec3::ZERO);
    assert!(normal.contains("normal 2 is not of length 1"), "{normal}");
    let uv = refused(&|d| d.scene.mesh.uvs[0].y = 2e9);
    assert!(uv.contains("texture coordinate 0"), "{uv}");
    let area = refused(&|d| d.indirect.as_mut().unwrap().sources[3].area = 3e38);
    assert!(area.contains("surface source 3 has an area of 3"), "{area}");
    let place = refused(&|d| d.indirect.as_mut().unwrap().sources[0].surfel.place.barycentric.x = -0.5);
    assert!(place.contains("surface source 0 has a place on its triangle"), "{place}");
    let settings = refused(&|d| d.settings.meshless.rays = 0);
    assert!(settings.contains("the setting rays"), "{settings}");
    let viewpoint = refused(&|d| d.settings.indirect.viewpoint = Some(Vec3::splat(1e10)));
    assert!(viewpoint.contains("the setting viewpoint"), "{viewpoint}");
    let flags = refused(&|d| d.vertex_valid.truncate(2));
    assert!(flags.contains("there are 2 flags of vertices, not 3"), "{flags}");
    with_sources().write(&path).unwrap();
    assert_ne!(std::fs::read(&path).unwrap(), before, "negative control");
}

#[test]
fn every_tensor_needs_its_checksum() {
    let (_folder, path, bytes) = written();
    let read = |change: &dyn Fn(&mut FileParts)| {
        let mut parts = FileParts::of(&bytes);
        change(&mut parts);
        std::fs::write(&path, parts.to_bytes()).unwrap();
        read(&path).map_err(|e| e.to_string())
    };
    assert!(read(&|parts| parts.sum()).is_ok());
    let none = read(&|parts| parts.header["checksums"] = serde_json::json!({})).unwrap_err();
    assert!(none.contains("has no checksum") && none.contains("a.cuts"), "{none}");
    let forgotten = read(&|parts| drop(parts.header["checksums"].as_object_mut().unwrap().remove("uvs")));
    assert!(forgotten.unwrap_err().contains("tensor `uvs` has no checksum"));
    let extra = |parts: &mut FileParts| {
        let more = FileTensor { name: "more".into(), ..parts.tensors[0].clone() };
        parts.tensors.push(more);
    };
    assert!(read(&extra).unwrap_err().contains("tensor `more` has no checksum"));
}
