//! Materials with BRDF files, and materials of the first version.

use super::*;
use lapidary_core::brdf::{BrdfFile, Content, example_file};

/// A document with one measured material.
fn measured(project: &Project) -> Document {
    let mut document = project.document();
    let path = project.path("maps/paint.binary");
    let content = example_file(BrdfModel::Merl).and_then(|file| file.content);
    let table = content.as_ref().and_then(|content| content.measured()).unwrap();
    std::fs::write(&path, table.to_merl()).unwrap();
    document.materials[0].model = BrdfModel::Merl;
    document.materials[0].file = Some(BrdfFile { path, content });
    document
}

#[test]
fn a_measured_brdf_comes_back_and_a_missing_one_is_said_and_not_lost() {
    let project = Project::new();
    let document = measured(&project);
    let (again, warnings) = project.reloaded(&document).into_document(Some(&project.dataset.scene));
    assert_eq!((again.materials[0].clone(), warnings), (document.materials[0].clone(), Vec::new()));
    std::fs::remove_file(project.path("maps/paint.binary")).unwrap();
    let loaded = load(&project.file()).unwrap();
    assert_eq!(loaded.missing, [MissingFile { what: "BRDF", path: project.path("maps/paint.binary") }]);
    let (without, warnings) = loaded.clone().into_document(Some(&project.dataset.scene));
    assert!(warnings[0].contains("magenta") && warnings[0].contains("paint.binary"), "{warnings:?}");
    assert!(without.materials[0].file.as_ref().unwrap().content.is_none());
    assert_eq!(without.materials[1], document.materials[1], "the rest loads");
    assert_eq!(project.reloaded(&without).missing.len(), 1, "saving again keeps the path");
    // A dataset may have it.
    let mut scene = project.dataset.scene.clone();
    scene.materials[0] = document.materials[0].clone();
    let (of_scene, warnings) = loaded.into_document(Some(&scene));
    assert_eq!((of_scene.materials[0].clone(), warnings), (document.materials[0].clone(), Vec::new()));
}

#[test]
fn ward_of_the_first_version_is_ward_duer() {
    let project = Project::new();
    let document = project.document();
    assert_eq!(document.materials[1].model, BrdfModel::Ward);
    project.reloaded(&document);
    let model = || load(&project.file()).unwrap().session.materials.materials[1].model;
    assert_eq!(model(), BrdfModel::Ward);
    let text = std::fs::read_to_string(project.file()).unwrap();
    std::fs::write(project.file(), text.replacen("\"lapidary_session\": 2", "\"lapidary_session\": 1", 1)).unwrap();
    assert_eq!(model(), BrdfModel::WardDuer);
}

#[test]
fn what_a_written_brdf_declares_comes_back_with_its_maps() {
    let project = Project::new();
    let mut document = project.document();
    let path = project.path("maps/mine.wgsl");
    let text = "// @parameter depth_of_mine | Depth | number | 2 | 0..9 | | What.\n\
                // @parameter hue_of_mine | Hue | color | 0.5 0.5 0.5 | 0..1 | | What.\n\
                fn brdf(p: Parameters, wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32> { return p.hue_of_mine * (0.01 * p.depth_of_mine); }\n";
    std::fs::write(&path, text).unwrap();
    let (content, remarks) = Content::read(&path).unwrap();
    assert!(remarks.is_empty(), "{remarks:?}");
    let mut material = Material { model: BrdfModel::Wgsl, ..document.materials[1].clone() };
    material.file = Some(BrdfFile { path, content: Some(content) });
    material.parameters.set("depth_of_mine", 7.5);
    material.parameters.set("hue_of_mine", Vec3::new(0.1, 0.2, 0.3));
    material.maps.set("hue_of_mine", Some(slot(3)));
    document.materials[1] = material.clone();
    let (again, warnings) = project.reloaded(&document).into_document(Some(&project.dataset.scene));
    assert_eq!((again.materials[1].clone(), warnings), (material, Vec::new()));
    assert_ne!(again.materials[1], project.document().materials[1], "negative control");
}
