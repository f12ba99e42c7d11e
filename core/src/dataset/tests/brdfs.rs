//! BRDF files, and materials of earlier versions.

use super::{be_of_version, dataset, read, replace};
use crate::{
    brdf::{BrdfModel, example_file},
    dataset::DatasetError,
    material::Material,
};

fn measured() -> Material {
    Material { model: BrdfModel::Merl, file: example_file(BrdfModel::Merl), ..Default::default() }
}

#[test]
fn a_measured_brdf_is_kept_once_for_all_its_materials() {
    let folder = tempfile::tempdir().unwrap();
    let [path, plain] = ["a.cuts", "b.cuts"].map(|name| folder.path().join(name));
    let mut written = dataset();
    written.write(&plain).unwrap();
    let bytes = |path| std::fs::metadata(path).unwrap().len();
    written.scene.materials = vec![measured(), Material::default(), measured()];
    written.write(&path).unwrap();
    let read = read(&path).unwrap();
    assert_eq!(read.scene.materials, written.scene.materials);
    let more = bytes(&path) - bytes(&plain);
    assert!((8_748_000..8_752_000).contains(&more), "a table of 16-bit floats, once: {more}");
    let mut other = written.scene.materials.clone();
    other[2].file = other[2].file.as_ref().map(|file| file.without_content());
    assert_ne!(read.scene.materials, other, "negative control");
}

#[test]
fn a_material_without_its_table_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut written = dataset();
    written.scene.materials = vec![measured()];
    written.write(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    replace(&mut bytes, r#"\"material_brdfs\":[0]"#, r#"\"material_brdfs\":[7]"#);
    std::fs::write(&path, bytes).unwrap();
    let Err(error @ DatasetError::Damaged { .. }) = read(&path) else { panic!("read") };
    assert!(error.to_string().contains("refers to BRDF 7, but there are 1"), "{error}");
}

#[test]
fn ward_of_version_7_is_ward_duer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cuts");
    let mut written = dataset();
    written.scene.materials = vec![Material { model: BrdfModel::Ward, ..Default::default() }];
    written.write(&path).unwrap();
    let model = |path| read(path).unwrap().scene.materials[0].model;
    assert_eq!(model(&path), BrdfModel::Ward);
    let mut bytes = std::fs::read(&path).unwrap();
    be_of_version(&mut bytes, 7);
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(model(&path), BrdfModel::WardDuer);
}
