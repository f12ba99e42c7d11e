//! Materials in separate files.

use super::*;
use lapidary_core::{
    material::Material,
    texture::{Pattern, Procedural},
};

fn load(path: &Path, scene: &mut Scene) -> Result<Material, ImportError> {
    load_material(path, scene, &ImportOptions::default()).map(|(material, _)| material)
}

#[test]
fn material_files_have_a_map_for_every_parameter() {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let keys = ["base_color", "roughness", "metalness", "specular", "anisotropy", "ior", "normal", "bump"];
    for key in keys {
        let json = format!(r#"{{"maps": {{"{key}": {{"file": "a.png", "channel": "b"}}}}}}"#);
        let maps = load(&files.add("one.json", &json), &mut Scene::default()).unwrap().maps;
        let read = serde_json::to_value(&maps).unwrap();
        for other in keys {
            assert_eq!(read[other].is_null(), other != key, "{key}, {other}");
        }
        let expected = if key == "base_color" { "srgb" } else { "linear" };
        assert_eq!((&read[key]["color_space"], &read[key]["channel"]), (&expected.into(), &"b".into()));
    }
    let misspelt = files.add("iro.json", r#"{"maps": {"iro": {"file": "a.png"}}}"#);
    assert!(load(&misspelt, &mut Scene::default()).is_err());
}

#[test]
fn material_files_have_patterns_and_a_map_without_any_source_is_an_error() {
    let files = Files::new();
    let json = r#"{"maps": {"roughness": {"procedural": {"pattern": "noise", "octaves": 90}, "scale": [3, 3]}}}"#;
    let mut scene = Scene::default();
    let material = load(&files.add("noisy.json", json), &mut scene).unwrap();
    let slot = material.maps.get("roughness").unwrap();
    let pattern = slot.procedural.unwrap();
    assert_eq!((pattern.pattern, pattern.octaves, slot.scale.x), (Pattern::Noise, Procedural::MOST_OCTAVES, 3.0));
    assert!(scene.textures.is_empty() && slot.image().is_none());
    let error = |json| load(&files.add("bad.json", json), &mut Scene::default()).unwrap_err().to_string();
    let unsourced = error(r#"{"maps": {"roughness": {"scale": [3, 3]}}}"#);
    assert!(unsourced.contains("`roughness` names neither a `file` nor a `procedural`"), "{unsourced}");
    let unknown = error(r#"{"maps": {"roughness": {"procedural": {"pattern": "marble"}}}}"#);
    assert!(unknown.contains("unknown variant `marble`"), "{unknown}");
}

#[test]
fn material_files_bring_their_pictures_once() {
    let files = Files::new();
    files.add_png("maps/a.png", [0.5; 3]);
    let json = r#"{"model": "ward", "parameters": {"roughness": 0.25},
        "maps": {"base_color": {"file": "maps/a.png", "scale": [2, 2], "rotation_degrees": 90},
                 "roughness": {"file": "maps/a.png", "channel": "g"}}}"#;
    let path = files.add("gold.json", json);
    let mut scene = Scene::default();
    let material = load(&path, &mut scene).unwrap();
    assert_eq!(
        (material.name.as_str(), material.model, material.parameters.number("roughness")),
        ("gold", BrdfModel::Ward, 0.25)
    );
    let (color, roughness) =
        (material.maps.get("base_color").cloned().unwrap(), material.maps.get("roughness").cloned().unwrap());
    assert_eq!((color.color_space, roughness.color_space), (ColorSpace::Srgb, ColorSpace::Linear));
    assert_eq!((roughness.channel, color.scale), (Channel::G, Vec2::splat(2.0)));
    assert!((color.rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    load(&path, &mut scene).unwrap();
    assert_eq!(scene.textures.len(), 1);

    for (name, bad) in
        [("typo.json", r#"{"rougness": 1}"#), ("gone.json", r#"{"maps": {"bump": {"file": "gone.png"}}}"#)]
    {
        assert!(load(&files.add(name, bad), &mut scene).is_err());
    }
    assert_eq!(scene.textures.len(), 1);
}

#[test]
fn a_picture_that_cannot_be_read_is_told_with_the_material_that_names_it() {
    let files = Files::new();
    files.add("text.png", "no picture");
    for name in ["data:,", "\\u0000", "gone.png", "text.png", ""] {
        let path = files.add("x.json", format!(r#"{{"maps": {{"bump": {{"file": "{name}"}}}}}}"#));
        let error = load(&path, &mut Scene::default()).unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, ImportError::Map { .. }), "{name}: {message}");
        assert!(message.ends_with("x.json)") && message.contains("map of the material"), "{message}");
        assert!(name.starts_with('\\') || message.contains(&format!("{name})")), "{name}: {message}");
    }
}

#[test]
fn numbers_of_a_material_file_are_kept_in_range_aloud() {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let text = r#"{"name": "odd", "parameters": {"roughness": 7},
        "maps": {"bump": {"file": "a.png", "scale": [1e30, 2], "strength": 1e31}}}"#;
    let path = files.add("x.json", text);
    let (material, warnings) = load_material(&path, &mut Scene::default(), &ImportOptions::default()).unwrap();
    let slot = material.maps.get("bump").unwrap();
    assert_eq!((slot.scale, slot.strength, material.parameters.number("roughness")), (Vec2::new(1.0, 2.0), 1.0, 1.0));
    assert!(matches!(&warnings[..], [warning] if warning.contains("\"odd\"")), "{warnings:?}");
    let beyond = files.add("z.json", text.replace("1e30", "1e300"));
    let refused = load_material(&beyond, &mut Scene::default(), &ImportOptions::default()).unwrap_err().to_string();
    assert!(refused.contains("number out of range") && refused.ends_with("z.json)"), "{refused}");
    let good = files.add("y.json", text.replace("1e31", "3").replace("1e30", "3").replace('7', "0.5"));
    assert_eq!(load_material(&good, &mut Scene::default(), &ImportOptions::default()).unwrap().1, [""; 0]);
}

/// A document of two materials; the first has a map.
const MATERIALX: &str = r#"<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709">
  <image name="picture" type="color3">
    <input name="file" type="filename" value="maps/a.png" colorspace="srgb_texture"/>
  </image>
  <open_pbr_surface name="SR_wood" type="surfaceshader">
    <input name="base_color" type="color3" nodename="picture"/>
    <input name="specular_roughness" type="float" value="0.25"/>
  </open_pbr_surface>
  <surfacematerial name="wood" type="material"><input name="surfaceshader" type="surfaceshader" nodename="SR_wood"/></surfacematerial>
  <standard_surface name="SR_gold" type="surfaceshader"><input name="metalness" type="float" value="1"/></standard_surface>
  <surfacematerial name="gold" type="material"><input name="surfaceshader" type="surfaceshader" nodename="SR_gold"/></surfacematerial>
</materialx>
"#;

#[test]
fn a_material_of_a_materialx_document_is_chosen_by_its_name() {
    let files = Files::new();
    files.add_png("maps/a.png", [0.5; 3]);
    let path = files.add("two.mtlx", MATERIALX);
    let named = |name: &str| {
        let mut path = path.clone().into_os_string();
        path.push(name);
        std::path::PathBuf::from(path)
    };
    let mut scene = Scene::default();
    let (first, warnings) = load_material(&path, &mut scene, &ImportOptions::default()).unwrap();
    assert_eq!((first.name.as_str(), first.model, scene.textures.len()), ("wood", BrdfModel::OpenPbr, 1));
    assert_eq!(first.parameters.number("specular_roughness"), 0.25);
    assert_eq!(first.maps.get("base_color").unwrap().color_space, ColorSpace::Srgb);
    assert!(warnings[0].contains("has 2 materials") && warnings[0].contains("\"gold\""), "{warnings:?}");
    let gold = load(&named("#gold"), &mut scene).unwrap();
    assert_eq!((gold.name.as_str(), gold.parameters.number("base_metalness"), scene.textures.len()), ("gold", 1.0, 1));
    let error = load(&named("#lead"), &mut scene).unwrap_err().to_string();
    assert!(error.contains("no material \"lead\", but \"wood\", \"gold\"") && error.contains("two.mtlx"), "{error}");
    assert_eq!(pictures_of_material(&named("#wood")).len(), 1);
    assert!(pictures_of_material(&named("#gold")).is_empty());
}

#[test]
fn a_materialx_document_that_is_wrong_is_told_with_its_file_and_line() {
    let files = Files::new();
    files.add_png("maps/a.png", [0.5; 3]);
    let with = |from: &str, to: &str| {
        let path = files.add("bad.mtlx", MATERIALX.replace(from, to));
        load_material(&path, &mut Scene::default(), &ImportOptions::default())
    };
    let refused = |from: &str, to: &str| with(from, to).unwrap_err().to_string();
    for (from, to, expected) in [
        ("maps/a.png", "maps/gone.png", "maps/gone.png"),
        ("maps/a.png", "../a.png", "../a.png"),
        ("0.25", "dull", "line 8"),
        ("</materialx>", "", "root"),
        ("<?xml version=\"1.0\"?>", "<!DOCTYPE m [<!ENTITY a \"b\">]>", "DTD"),
    ] {
        let message = refused(from, to);
        assert!(message.contains(expected) && message.contains("bad.mtlx"), "{message}");
    }
    let (material, warnings) = with("0.25", "nan").unwrap();
    assert!(warnings.iter().any(|warning| warning.contains("out of range")), "{warnings:?}");
    assert_eq!(material.parameters.number("specular_roughness"), 0.3);
    assert!(with("0.25", "0.5").unwrap().1.len() == 1, "negative control");
}

#[test]
fn included_documents_are_read_from_beside_and_others_told() {
    let files = Files::new();
    files.add_png("lib/maps/c.png", [0.5; 3]);
    let graph = "<materialx version=\"1.39\" fileprefix=\"maps/\" colorspace=\"srgb_texture\"><image name=\"c\" type=\"color3\">\
        <input name=\"file\" type=\"filename\" value=\"c.png\"/></image></materialx>";
    files.add("lib/nodes.mtlx", graph);
    let document = |href: &str| {
        let text = format!(
            "<materialx version=\"1.39\"><xi:include href=\"{href}\"/><standard_surface name=\"s\" type=\"surfaceshader\">\
             <input name=\"base_color\" type=\"color3\" nodename=\"c\"/></standard_surface></materialx>"
        );
        let path = files.add("m.mtlx", text);
        let mut scene = Scene::default();
        let loaded = load_material(&path, &mut scene, &ImportOptions::default()).unwrap();
        (loaded, scene.textures.len(), pictures_of_material(&path).len())
    };
    let ((material, remarks), textures, pictures) = document("lib/nodes.mtlx");
    assert_eq!(material.maps.get("base_color").unwrap().color_space, ColorSpace::Srgb);
    assert_eq!((remarks, textures, pictures), (vec![], 1, 1));
    let outside = Files::new();
    let foreign = outside.add("nodes.mtlx", graph);
    for (href, reason) in [("gone.mtlx", "there is no such file"), (foreign.to_str().unwrap(), "outside the folder")] {
        let ((material, remarks), textures, _) = document(href);
        assert!(material.maps.get("base_color").is_none() && textures == 0, "negative control");
        assert!(remarks[0].contains("which it includes, is left out") && remarks[0].contains(reason), "{remarks:?}");
    }
}

/// A document that includes another, and one surface.
const INCLUDING: &str = "<materialx version=\"1.39\">\n<xi:include href=\"lib/m.mtlx\"/>\n\
    <standard_surface name=\"own\" type=\"surfaceshader\"/></materialx>";

#[test]
fn an_error_in_an_included_document_is_located_there() {
    let files = Files::new();
    let path = files.add("m.mtlx", INCLUDING);
    let with = |inputs: &str| {
        let surface = format!("<standard_surface name=\"s\" type=\"surfaceshader\">\n{inputs}</standard_surface>");
        files.add("lib/m.mtlx", format!("<materialx version=\"1.39\">\n\n{surface}</materialx>"));
        load_material(&path, &mut Scene::default(), &ImportOptions::default())
    };
    let base = |value: &str| format!("<input name=\"base\" type=\"float\" value=\"{value}\"/>");
    let message = with(&base("much")).unwrap_err().to_string();
    assert!(
        message.contains("line 4 of \"lib/m.mtlx\": the value \"much\"") && message.ends_with("m.mtlx)"),
        "{message}"
    );
    let remarks = with("\n<input name=\"bsae\" type=\"float\" value=\"1\"/>").unwrap().1.join("\n");
    assert!(remarks.contains("line 5 of \"lib/m.mtlx\": standard_surface has no input \"bsae\""), "{remarks}");
    assert!(!with(&base("0.5")).unwrap().1.join("\n").contains("line"), "negative control");
    let own =
        files.add("m.mtlx", INCLUDING.replace("shader\"/>", "shader\">\n<input name=\"bsae\"/></standard_surface>"));
    let mut scene = Scene::default();
    let mut named = own.into_os_string();
    named.push("#own");
    let (_, remarks) = load_material(Path::new(&named), &mut scene, &ImportOptions::default()).unwrap();
    assert!(remarks.join("\n").contains("line 4: standard_surface has no input"), "negative control: {remarks:?}");
}

#[test]
fn a_missing_document_is_not_another_of_its_name() {
    let files = Files::new();
    let path = files.add("m.mtlx", INCLUDING);
    let remarks = || load_material(&path, &mut Scene::default(), &ImportOptions::default()).unwrap().1;
    let missing = remarks();
    assert!(missing.len() == 1 && missing[0].ends_with("is left out: there is no such file beside it"), "{missing:?}");
    files.add("LIB/M.mtlx", "<materialx version=\"1.39\"/>");
    assert_eq!(remarks(), [""; 0], "negative control: the same name in another case");
}

#[test]
fn included_documents_are_counted_with_what_their_elements_inherit() {
    let files = Files::new();
    let path = files.add("m.mtlx", INCLUDING);
    files.add(
        "lib/m.mtlx",
        format!("<materialx fileprefix=\"{}\">{}</materialx>", "a".repeat(10_000), "<a/>".repeat(1000)),
    );
    let remarks = |budget: u64| {
        let options = ImportOptions { budget: Some(budget), ..Default::default() };
        load_material(&path, &mut Scene::default(), &options).unwrap().1
    };
    assert!(remarks(2_000_000)[0].ends_with("is left out: it does not fit into the memory"));
    assert_eq!(remarks(50_000_000), [""; 0], "negative control");
}
