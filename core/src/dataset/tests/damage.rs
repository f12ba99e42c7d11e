//! What only a reader that checks the parts of a dataset one by one finds.

use super::*;
use crate::{
    camera::Camera,
    lights::{Emission, Light},
};

#[test]
fn a_damaged_meshless_basis_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let error_of = |change: &dyn Fn(&mut MeshlessBake)| {
        let mut dataset = with_meshless();
        change(dataset.meshless.as_mut().unwrap());
        dataset.write(&path).unwrap();
        Dataset::read(&path).unwrap_err().to_string()
    };
    let changed = |bake: &MeshlessBake, change: &dyn Fn(&mut Surfel)| {
        let mut points = bake.basis.points().to_vec();
        change(&mut points[3]);
        Basis::from_parts(points, bake.basis.offsets().to_vec(), bake.basis.radii().to_vec(), 1).unwrap()
    };
    let triangle = error_of(&|b| b.basis = changed(b, &|p| p.place.triangle = 1));
    assert!(triangle.contains("function 3") && triangle.contains("but there are 1"), "{triangle}");
    let place = error_of(&|b| b.basis = changed(b, &|p| p.place.barycentric.y = f32::NAN));
    assert!(place.contains("function 3") && place.contains("no finite number"), "{place}");
    let links = error_of(&|b| b.transport = Transport::from_rows(&vec![vec![(0, Vec3::X)]; 5], 3));
    assert!(links.contains("5 receivers and 2 senders"), "{links}");
}

#[test]
fn lights_and_cameras_that_are_none_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let read = |change: &dyn Fn(&mut Scene)| {
        let mut dataset = dataset();
        let emission = Emission::Spot { cone_degrees: 30.0, penumbra_degrees: 5.0 };
        let light = Light { name: "Desk".into(), emission, position: Vec3::Y, ..Default::default() };
        dataset.scene.lights = vec![light.clone(), light];
        dataset.scene.cameras = vec![Camera { name: "Door".into(), ..Camera::look_at(Vec3::Z, Vec3::ZERO, 40.0) }];
        change(&mut dataset.scene);
        dataset.write(&path).unwrap();
        Dataset::read(&path).map_err(|e| e.to_string())
    };
    assert!(read(&|_| ()).is_ok());
    let wide = Emission::Spot { cone_degrees: 200.0, penumbra_degrees: 5.0 };
    let cone = read(&|scene| scene.lights[1].emission = wide).unwrap_err();
    assert!(cone.contains("light 1 (`Desk`)") && cone.contains("200"), "{cone}");
    let negative = read(&|scene| scene.lights[0].intensity.y = -1.0).unwrap_err();
    assert!(negative.contains("light 0") && negative.contains("negative"), "{negative}");

    read(&|scene| scene.cameras[0].eye.x = 3.25e9).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    replace(&mut bytes, "3250000000.0", "3.25e99");
    std::fs::write(&path, bytes).unwrap();
    let camera = Dataset::read(&path).unwrap_err().to_string();
    assert!(camera.contains("camera 0 (`Door`)"), "{camera}");
}
