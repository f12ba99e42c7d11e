//! Materials with a BRDF file.

use super::{load_material, materials_in_file};
use lapidary_core::brdf::{BrdfModel, Content, example_file};
use std::path::Path;

/// A folder with a material file that names `example.binary`, and that file if `table` is given.
fn folder(table: Option<&[u8]>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let material = r#"{"model": "merl", "file": "example.binary", "parameters": {"tint": [1, 0.5, 0.5]}}"#;
    std::fs::write(folder.path().join("paint.json"), material).unwrap();
    table.iter().for_each(|bytes| std::fs::write(folder.path().join("example.binary"), bytes).unwrap());
    folder
}

#[test]
fn a_file_is_not_looked_for_where_the_model_has_none() {
    let folder = folder(None);
    let path = folder.path().join("paint.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("merl", "ggx")).unwrap();
    let (material, remarks) = load(folder.path()).unwrap();
    assert!(material.file.is_none() && material.parameters.get("tint").is_none() && remarks.is_empty(), "{remarks:?}");
    std::fs::write(&path, text).unwrap();
    assert!(load(folder.path()).is_err(), "negative control");
}

fn load(folder: &Path) -> Result<(lapidary_core::material::Material, Vec<String>), super::ImportError> {
    load_material(&folder.join("paint.json"), &mut Default::default(), &Default::default())
}

#[test]
fn a_measured_brdf_beside_a_material_is_read_and_what_it_lacks_is_told() {
    let example = example_file(BrdfModel::Merl).unwrap().content.unwrap();
    let folder = folder(Some(&example.measured().unwrap().to_merl()));
    let (material, remarks) = load(folder.path()).unwrap();
    let file = material.file.clone().unwrap();
    assert_eq!(file.path, folder.path().join("example.binary"));
    assert_eq!(file.content.as_ref().map(Content::hash), Some(example.hash()));
    assert!(remarks.is_empty(), "{remarks:?}");
    assert!(material.plain_brdf().as_brdf().narrowest_lobe().is_some());
    let unread = material.without_content();
    assert!(unread.plain_brdf().as_brdf().narrowest_lobe().is_none(), "negative control: magenta");
}

#[test]
fn a_table_that_is_not_there_or_broken_is_named() {
    let missing = load(folder(None).path()).unwrap_err().to_string();
    assert!(missing.contains("its BRDF example.binary: there is no such file beside it"), "{missing}");
    let broken = load(folder(Some(&[0; 40])).path()).unwrap_err().to_string();
    assert!(
        broken.contains("not a MERL BRDF: its table is 0 x 0 x 0") && broken.contains("example.binary"),
        "{broken}"
    );
}

#[test]
fn a_document_of_several_materials_tells_their_names_unless_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let document = r#"<materialx version="1.39">
        <open_pbr_surface name="S" type="surfaceshader"/><disney name="D" type="surfaceshader"/>
        <surfacematerial name="gold" type="material"><input name="surfaceshader" nodename="S"/></surfacematerial>
        <surfacematerial name="odd" type="material"><input name="surfaceshader" nodename="D"/></surfacematerial>
        <surfacematerial name="steel" type="material"><input name="surfaceshader" nodename="S"/></surfacematerial>
        </materialx>"#;
    let path = write("all.mtlx", document);
    assert_eq!(materials_in_file(&path), ["gold", "steel"], "one of another surface is not read");
    let named = folder.path().join("all.mtlx#steel");
    assert!(materials_in_file(&named).is_empty());
    assert_eq!(load_material(&named, &mut Default::default(), &Default::default()).unwrap().0.name, "steel");
    for other in [write("a.mtlx", "<materialx"), write("a.json", document), folder.path().join("gone.mtlx")] {
        assert!(materials_in_file(&other).is_empty(), "{}", other.display());
    }
}
