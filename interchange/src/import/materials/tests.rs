//! Materials with a BRDF file, and with layers of pictures.

use super::{Files, contents, load_material, materials_in_file, materialx, pictures_of_material};
use crate::image::{Layer, LayeredImage, Metadata};
use glam::Vec3;
use lapidary_core::{
    brdf::{BrdfModel, Content, example_file},
    image::Image,
    scene::Scene,
    texture::Texture,
};
use std::{collections::BTreeSet, path::Path, sync::Arc};

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

/// A folder with an exr of colors and normals, and a material whose maps name layers of it.
fn layered() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let filled = |value| Image::filled([2, 2], value);
    let layers = vec![Layer::color("", &filled(Vec3::X)), Layer::vectors("Normal", &filled(Vec3::new(0.5, 0.25, 1.0)))];
    let picture = LayeredImage { size: [2, 2], layers, metadata: Metadata::default() };
    picture.write(&folder.path().join("Maps.exr")).unwrap();
    let material = r#"{"model": "ggx", "maps": {"base_color": {"file": "Maps.exr"},
        "normal": {"file": "maps.EXR#normal"}, "roughness": {"file": "Maps.exr#normal"}}}"#;
    std::fs::write(folder.path().join("paint.json"), material).unwrap();
    folder
}

#[test]
fn maps_read_the_layers_that_they_name_and_share_them() {
    let folder = layered();
    let path = folder.path().join("paint.json");
    let mut scene = Scene::default();
    let (material, remarks) = load_material(&path, &mut scene, &Default::default()).unwrap();
    assert!(remarks.is_empty(), "{remarks:?}");
    let texture = |map| scene.textures[material.maps.get(map).unwrap().texture as usize].clone();
    let texel = |map| texture(map).texel(0, 0, Default::default()).truncate();
    assert_eq!([texel("base_color"), texel("normal")], [Vec3::X, Vec3::new(0.5, 0.25, 1.0)]);
    assert_eq!(texture("normal").name, "maps.EXR#normal");
    assert_eq!(scene.textures.len(), 2, "the same layer is one texture, and another is not");
    load_material(&path, &mut scene, &Default::default()).unwrap();
    assert_eq!(scene.textures.len(), 2, "nor is it read again");
    assert_eq!(pictures_of_material(&path), [folder.path().join("Maps.exr")], "the file");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("#normal", "#height")).unwrap();
    let message = load_material(&path, &mut scene, &Default::default()).unwrap_err().to_string();
    assert!(["height", "RGBA", "Normal"].iter().all(|name| message.contains(name)), "{message}");
}

#[test]
fn a_dataset_keeps_the_layer_of_a_map() {
    let folder = layered();
    let mut scene = Scene::default();
    load_material(&folder.path().join("paint.json"), &mut scene, &Default::default()).unwrap();
    let mut dataset = lapidary_core::test_scenes::dataset(&[""], &[]);
    dataset.scene.textures = scene.textures.clone();
    let path = folder.path().join("a.cuts");
    dataset.write(&path).unwrap();
    std::fs::remove_file(folder.path().join("Maps.exr")).unwrap();
    let read = lapidary_core::dataset::Dataset::read(&path, crate::image::decode).unwrap().scene.textures;
    let texels = |textures: &[Arc<Texture>]| textures.iter().map(|t| t.texels.clone()).collect::<Vec<_>>();
    assert_eq!(texels(&read), texels(&scene.textures));
    assert_ne!(read[0].texels, read[1].texels, "negative control");
}

#[test]
fn a_dataset_is_read_whatever_its_pictures_are_called() {
    let folder = layered();
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, text: &str| std::fs::write(at(name), text).unwrap();
    let png = crate::image::encode_png(&Image::filled([1, 1], Vec3::Y));
    std::fs::write(at("shot.exr#1.png"), &png).unwrap();
    write("a.mtl", "newmtl a\nmap_Kd \"Maps.exr#Normal\"\nmap_Ks shot.exr#1.png\n");
    write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nusemtl a\nf 1/1 3/1 2/1\n");
    write("a.json", r#"{"model": "ggx", "maps": {"base_color": {"file": "Maps.exr#Normal "}}}"#);
    let imported = crate::import::import(&at("a.obj")).unwrap();
    assert!(imported.report.unread.is_empty(), "{:?}", imported.report.unread);
    let mut scene = Scene { textures: imported.scene.textures, ..Default::default() };
    let embedded = "x.exr#1";
    scene.textures.push(crate::image::decode(&png, Path::new(embedded)).unwrap().into());
    let mut alone = Scene::default();
    load_material(&at("a.json"), &mut alone, &Default::default()).unwrap();
    scene.textures.append(&mut alone.textures);
    let names: BTreeSet<&str> = scene.textures.iter().map(|texture| texture.name.as_str()).collect();
    let expected = ["\"Maps.exr#Normal\"", "Maps.exr#Normal ", "shot.exr#1.png", embedded];
    assert_eq!(names, BTreeSet::from(expected));
    let mut dataset = lapidary_core::test_scenes::dataset(&[""], &[]);
    dataset.scene.textures = scene.textures.clone();
    let path = at("a.cuts");
    dataset.write(&path).unwrap();
    let read = lapidary_core::dataset::Dataset::read(&path, crate::image::decode).unwrap().scene.textures;
    let texels = |textures: &[Arc<Texture>]| textures.iter().map(|t| t.texels.clone()).collect::<Vec<_>>();
    assert_eq!(texels(&read), texels(&scene.textures));
}

#[test]
fn the_layer_input_of_a_document_names_a_layer_and_is_written_back() {
    let folder = layered();
    let document = |file: &str| {
        format!(
            r#"<materialx version="1.39"><image name="p" type="color3">
            <input name="file" type="filename" value="{file}"/><input name="layer" type="string" value="Normal"/></image>
            <open_pbr_surface name="S" type="surfaceshader"><input name="base_color" type="color3" nodename="p"/></open_pbr_surface>
            <surfacematerial name="m" type="material"><input name="surfaceshader" nodename="S"/></surfacematerial></materialx>"#
        )
    };
    let path = folder.path().join("a.mtlx");
    let mut scene = Scene::default();
    std::fs::write(&path, document("Maps.exr")).unwrap();
    let (_, remarks) = load_material(&path, &mut scene, &Default::default()).unwrap();
    assert!(remarks.is_empty(), "{remarks:?}");
    assert_eq!(scene.textures[0].texel(0, 0, Default::default()).truncate(), Vec3::new(0.5, 0.25, 1.0));
    let files = &mut Files::beside(&path, &Default::default());
    let read = contents(&path, document("Maps.exr").as_bytes(), None, files).unwrap().material;
    let written = materialx::write(&[read], materialx::Surface::OpenPbr).unwrap().text;
    assert!(written.contains(r#"value="Maps.exr"/>"#) && written.contains(r#"value="Normal""#), "{written}");
    let read = contents(&path, document("wood.png").as_bytes(), None, files).unwrap();
    assert_eq!(read.material.maps.get("base_color").unwrap().file, "wood.png");
    assert!(read.remarks.iter().any(|remark| remark.contains("only exr files have layers")), "{:?}", read.remarks);
}
