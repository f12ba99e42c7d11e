//! Round trips of documents, and documents of other programs.

mod foreign;
mod stored;
mod weights;

use super::*;
use crate::material_file::{MaterialFile, SlotFile};
use glam::{Vec2, Vec3};
use lapidary_core::{
    brdf::{BrdfModel, GgxParameters, Parameter, Parameters, Value},
    material::{BUMP, NORMAL, PRESETS},
    texture::{Channel, ColorSpace},
};

fn slot(file: &str) -> SlotFile {
    SlotFile {
        file: file.into(),
        color_space: Some(ColorSpace::Linear),
        channel: Channel::R,
        scale: Vec2::ONE,
        offset: Vec2::ZERO,
        rotation_degrees: 0.0,
        strength: 1.0,
        flip_y: false,
        procedural: None,
        wrap: Default::default(),
        uv_set: Default::default(),
    }
}

/// A material of the model with unique values that differ from all defaults.
fn coated() -> MaterialFile {
    let parameters = Parameters::default()
        .with("base_weight", 0.9)
        .with("base_color", Vec3::new(0.7, 0.2, 0.1))
        .with("base_diffuse_roughness", 0.15)
        .with("base_metalness", 0.0)
        .with("specular_weight", 0.85)
        .with("specular_color", Vec3::new(0.9, 0.95, 1.0))
        .with("specular_roughness", 0.42)
        .with("specular_ior", 1.7)
        .with("specular_roughness_anisotropy", 0.3)
        .with("coat_weight", 0.6)
        .with("coat_color", Vec3::new(1.0, 0.8, 0.6))
        .with("coat_roughness", 0.12)
        .with("coat_roughness_anisotropy", 0.2)
        .with("coat_ior", 1.45)
        .with("coat_darkening", 0.5)
        .with("fuzz_weight", 0.25)
        .with("fuzz_color", Vec3::new(0.2, 0.3, 0.4))
        .with("fuzz_roughness", 0.35);
    MaterialFile { name: "Red lacquer".into(), model: BrdfModel::OpenPbr, parameters, ..Default::default() }
}

/// Writes and reads a material.
fn again(material: &MaterialFile, surface: Surface) -> MaterialFile {
    let written = write(std::slice::from_ref(material), surface).unwrap();
    let read = read(&written.text, None).unwrap_or_else(|e| panic!("{e}: {}", written.text));
    assert_eq!(read.remarks, Vec::<String>::new(), "{}", written.text);
    read.material
}

/// The largest difference of a parameter, and its name.
fn difference(a: &MaterialFile, b: &MaterialFile) -> (f32, &'static str) {
    let of = |p: &'static lapidary_core::brdf::Parameter| {
        let [x, y] = [a, b].map(|material| material.parameters.value(p).color());
        ((x - y).abs().max_element(), p.name)
    };
    BrdfModel::OpenPbr
        .parameters()
        .iter()
        .map(of)
        .fold((0.0, ""), |most, next| if next.0 > most.0 { next } else { most })
}

fn assert_close(a: &MaterialFile, b: &MaterialFile) {
    let (most, name) = difference(a, b);
    assert!(most < 1e-6, "{name}: {:?} and {:?}", a.parameters.get(name), b.parameters.get(name));
}

#[test]
fn what_is_written_is_read_again() {
    let material = coated();
    for surface in [Surface::OpenPbr, Surface::StandardSurface] {
        let mut kept = material.clone();
        if surface == Surface::StandardSurface {
            kept.parameters.set("fuzz_roughness", 0.5);
        }
        let read = again(&kept, surface);
        assert_close(&read, &kept);
        assert_eq!((read.name.as_str(), read.model), ("Red lacquer", BrdfModel::OpenPbr));
        kept.parameters.set("coat_roughness", 0.1200021);
        assert!(difference(&read, &kept).0 > 1e-6, "negative control");
    }
}

#[test]
fn gltf_keeps_what_it_has_and_the_rest_is_told() {
    let written = write(&[coated()], Surface::GltfPbr).unwrap();
    for lost in ["diffuse base", "color of the coat", "does not darken", "index 1.5", "not stretched"] {
        assert!(written.remarks.iter().any(|remark| remark.contains(lost) && remark.contains("Red lacquer")), "{lost}");
    }
    let mut kept = coated();
    let neutral = [
        ("base_weight", Value::Number(1.0)),
        ("base_diffuse_roughness", Value::Number(0.0)),
        ("coat_color", Value::Color(Vec3::ONE)),
        ("coat_roughness_anisotropy", Value::Number(0.0)),
        ("coat_ior", Value::Number(1.5)),
        ("coat_darkening", Value::Number(0.0)),
        ("fuzz_weight", Value::Number(1.0)),
    ];
    neutral.into_iter().for_each(|(name, value)| kept.parameters.set(name, value));
    assert!(write(std::slice::from_ref(&kept), Surface::GltfPbr).unwrap().remarks.is_empty());
    assert_close(&again(&kept, Surface::GltfPbr), &kept);
    assert!(difference(&again(&coated(), Surface::GltfPbr), &coated()).0 > 0.05, "negative control");
}

#[test]
fn maps_of_all_kinds_are_read_as_they_are_written() {
    let mut material = coated();
    material.double_sided = true;
    material.parameters.set("specular_roughness_anisotropy", 0.0);
    material.parameters.set("coat_roughness_anisotropy", 0.0);
    let placed = SlotFile { scale: Vec2::new(2.0, 3.0), offset: Vec2::new(0.25, 0.5), ..slot("wood & <oak>.png") };
    let turned = SlotFile { rotation_degrees: 30.0, scale: Vec2::new(2.0, 4.0), ..slot("a/b.png") };
    let maps = [
        ("base_color", SlotFile { color_space: Some(ColorSpace::Srgb), ..placed.clone() }),
        ("specular_color", SlotFile { color_space: Some(ColorSpace::AcesCg), ..turned.clone() }),
        ("specular_roughness", SlotFile { channel: Channel::G, ..turned }),
        ("specular_weight", SlotFile { channel: Channel::A, color_space: Some(ColorSpace::Srgb), ..slot("c.png") }),
        ("base_metalness", SlotFile { channel: Channel::B, color_space: Some(ColorSpace::Srgb), ..slot("c.png") }),
        ("specular_ior", slot("d.png")),
        (NORMAL, SlotFile { strength: 0.75, flip_y: true, ..slot("n.png") }),
        (BUMP, SlotFile { strength: 0.002, channel: Channel::A, ..slot("h.png") }),
    ];
    // A name with a bracket stands for several pictures.
    for surface in [Surface::OpenPbr, Surface::StandardSurface, Surface::GltfPbr] {
        let mut kept = material.clone();
        for (name, slot) in &maps {
            let file = slot.file.replace(['<', '>'], "'");
            kept.maps.set(*name, Some(SlotFile { file, ..slot.clone() }));
        }
        kept.double_sided = surface.thin_walled().is_some();
        let read = again(&kept, surface);
        for (name, expected) in kept.maps.iter() {
            let found = read.maps.get(name).unwrap_or_else(|| panic!("{name} of {surface:?}"));
            assert!((found.scale - expected.scale).length() < 1e-5, "{name} {found:?}");
            assert!((found.offset - expected.offset).length() < 1e-5, "{name} {found:?} {expected:?}");
            assert!((found.rotation_degrees - expected.rotation_degrees).abs() < 1e-3, "{name} {found:?}");
            let same = SlotFile {
                scale: expected.scale,
                offset: expected.offset,
                rotation_degrees: expected.rotation_degrees,
                ..found.clone()
            };
            assert_eq!(same, *expected, "{name}");
        }
        assert_eq!(read.maps.slots().count(), kept.maps.slots().count());
        assert_eq!(read.double_sided, kept.double_sided);
        let roughness = read.parameters.number("specular_roughness");
        assert!((roughness - 0.42).abs() < 1e-6 && (read.parameters.number("specular_ior") - 1.7).abs() < 1e-6);
    }
    let bracketed = MaterialFile { maps: [("base_color", placed)].into(), ..material };
    let text = write(&[bracketed], Surface::OpenPbr).unwrap().text;
    assert!(text.contains("wood &amp; &lt;oak&gt;.png"), "{text}");
    assert!(read(&text, None).unwrap().remarks[0].contains("stands for several"));
}

#[test]
fn materials_of_other_models_keep_their_quantities() {
    let parameters = GgxParameters { roughness: 0.3, metalness: 0.25, anisotropy: 0.5, ior: 1.8, ..Default::default() };
    let ggx = MaterialFile { name: "m".into(), parameters: parameters.into(), ..Default::default() };
    let read = again(&ggx, Surface::OpenPbr);
    let [along, across] = stretch::of_openpbr(
        read.parameters.number("specular_roughness"),
        read.parameters.number("specular_roughness_anisotropy"),
    );
    let [x, y] = lapidary_core::brdf::widths(0.3, 0.5);
    assert!((along - x).abs() < 1e-5 && (across - y).abs() < 1e-5, "the lobe is as wide");
    assert_eq!((read.parameters.number("base_metalness"), read.parameters.number("specular_ior")), (0.25, 1.8));
    let chalk = MaterialFile { model: BrdfModel::Lambert, ..ggx.clone() };
    assert_eq!(again(&chalk, Surface::OpenPbr).parameters.number("specular_weight"), 0.0, "no highlight");
    let mut across = ggx;
    across.parameters.set("anisotropy", -0.5);
    assert!(write(&[across], Surface::OpenPbr).unwrap().remarks.iter().any(|remark| remark.contains("across")));
}

#[test]
fn every_preset_is_written_and_found_by_its_name() {
    let materials: Vec<MaterialFile> =
        PRESETS.iter().map(|preset| preset.material().with_maps(Default::default())).collect();
    for surface in Surface::ALL {
        let text = write(&materials, surface).unwrap().text;
        for material in &materials {
            let found = read(&text, Some(&material.name)).unwrap().material;
            assert_eq!(found.name, material.name);
        }
        let first = read(&text, None).unwrap();
        assert!(first.remarks[0].contains("#NAME") && first.material.name == materials[0].name);
        let error = read(&text, Some("Unobtainium")).unwrap_err().to_string();
        assert!(error.contains("no material \"Unobtainium\""), "{error}");
    }
}

const HEAD: &str =
    "<?xml version=\"1.0\"?>\n<materialx version=\"1.38\" colorspace=\"lin_rec709\" fileprefix=\"maps/\">\n";

fn document(contents: &str) -> String {
    format!("{HEAD}{contents}</materialx>")
}

fn standard(inputs: &str) -> String {
    document(&format!("<standard_surface name=\"s\" type=\"surfaceshader\">\n{inputs}\n</standard_surface>"))
}

#[test]
fn a_document_of_another_program_is_read() {
    let text = document(
        r#"<nodegraph name="NG">
  <input name="tiling" type="vector2" value="4, 4"/>
  <tiledimage name="orm" type="vector3">
    <input name="file" type="filename" value="orm.png"/>
    <input name="uvtiling" type="vector2" interfacename="tiling"/>
  </tiledimage>
  <image name="base" type="color3"><input name="file" type="filename" value="base.png" colorspace="srgb_texture"/></image>
  <separate3 name="split" type="multioutput"><input name="in" type="vector3" nodename="orm"/></separate3>
  <normalmap name="n" type="vector3"><input name="in" type="vector3" nodename="orm"/></normalmap>
  <output name="c" type="color3" nodename="base"/><output name="r" type="float" nodename="split" output="outy"/>
  <output name="o" type="vector3" nodename="orm"/><output name="normal" type="vector3" nodename="n"/>
</nodegraph>
<gltf_pbr name="SR" type="surfaceshader">
  <input name="base_color" type="color3" nodegraph="NG" output="c"/>
  <input name="roughness" type="float" nodegraph="NG" output="r"/>
  <input name="metallic" type="float" nodegraph="NG" output="o" channels="z"/>
  <input name="normal" type="vector3" nodegraph="NG" output="normal"/>
  <input name="iridescence" type="float" value="0.5"/>
  <input name="clearcoat_normal" type="vector3" value="0, 0, 1"/>
</gltf_pbr>
<surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="SR"/></surfacematerial>
"#,
    );
    let ReadMaterial { material, remarks } = read(&text, Some("M")).unwrap();
    let map = |name: &str| material.maps.get(name).unwrap();
    assert_eq!(
        (map("base_color").file.as_str(), map("base_color").color_space),
        ("maps/base.png", Some(ColorSpace::Srgb))
    );
    assert_eq!((map("specular_roughness").channel, map("base_metalness").channel), (Channel::G, Channel::B));
    assert_eq!((map("specular_roughness").scale, map("specular_roughness").offset.y), (Vec2::splat(4.0), -3.0));
    assert!(material.maps.get(NORMAL).is_some() && material.parameters.number("specular_roughness") == 1.0);
    assert_eq!(remarks, ["left out: iridescence"]);
}

#[test]
fn all_that_is_not_rendered_is_told() {
    for surface in Surface::ALL {
        for surface::Lost { input, what, without_effect } in surface.lost() {
            let told = |value: f32| {
                let node = surface.node();
                let text = format!(
                    r#"<materialx version="1.39"><{node} name="SR" type="surfaceshader">
                    <input name="{input}" type="float" value="{value}"/></{node}></materialx>"#
                );
                read(&text, None).unwrap().remarks
            };
            assert_eq!(told(0.5), [format!("left out: {what}")], "{input}");
            assert_eq!(told(*without_effect), Vec::<String>::new(), "negative control: there is no {what}");
        }
    }
}

#[test]
fn a_document_of_version_1_37_is_read() {
    let text = r#"<materialx version="1.37">
<nodegraph name="NG" colorspace="srgb_texture" fileprefix="Images/">
  <tiledimage name="c" type="color3"><parameter name="file" type="filename" value="brass.jpg"/></tiledimage>
  <output name="out" type="color3" nodename="c"/>
</nodegraph>
<material name="Brass">
  <shaderref name="SR" node="standard_surface">
    <bindinput name="metalness" type="float" value="1"/>
    <bindinput name="specular" type="float" value="0"/>
    <bindinput name="coat_color" type="color3" nodegraph="NG" output="out"/>
    <bindinput name="coat_glow" type="float" value="1"/>
  </shaderref>
</material></materialx>"#;
    let ReadMaterial { material, remarks } = read(text, None).unwrap();
    let map = material.maps.get("coat_color").unwrap();
    assert_eq!((map.file.as_str(), map.color_space), ("Images/brass.jpg", Some(ColorSpace::Srgb)));
    // The weight of a metal's highlight has another meaning there.
    assert_eq!((material.name.as_str(), material.parameters.number("specular_weight")), ("Brass", 1.0));
    assert!(remarks.len() == 1 && remarks[0].contains("line 11") && remarks[0].contains("coat_glow"), "{remarks:?}");
}

#[test]
fn colors_are_converted_and_other_spaces_told() {
    let of = |space: &str| {
        let input =
            format!("<input name=\"base_color\" type=\"color3\" value=\"0.5, 0.5, 0.25\" colorspace=\"{space}\"/>");
        let read = read(&standard(&input), None).unwrap();
        (read.material.parameters.color("base_color"), read.remarks.len())
    };
    let plain = glam::Vec3::new(0.5, 0.5, 0.25);
    assert_eq!(of("lin_rec709"), (plain, 0));
    assert!((of("srgb_texture").0.x - 0.214_041).abs() < 1e-5);
    assert_eq!((of("lin_other"), of("g22_rec709").1), ((plain, 1), 1));
    // The matrices of ACES S-2014-004 and ITU-R BT.2407 for the same color.
    for (space, right) in [("acescg", [0.5208, 0.5026, 0.2118]), ("lin_rec2020", [0.5182, 0.5021, 0.2202])] {
        let (found, remarks) = of(space);
        assert!((found - glam::Vec3::from_array(right)).abs().max_element() < 1e-3 && remarks == 0, "{space}: {found}");
        assert!((plain - glam::Vec3::from_array(right)).abs().max_element() > 0.01, "negative control");
    }
}

/// Text of the error, or of all remarks.
fn message(text: &str) -> String {
    match read(text, None) {
        Ok(read) => read.remarks.join("\n"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let graph = |inner: &str, input: &str| {
        let nodes = format!("<nodegraph name=\"g\">{inner}</nodegraph>\n");
        document(&(nodes + "<standard_surface name=\"s\">\n" + input + "</standard_surface>"))
    };
    let to =
        |node: &str| format!("<input name=\"specular_roughness\" type=\"float\" nodegraph=\"g\" output=\"{node}\"/>");
    let circle = "<dot name=\"a\"><input name=\"in\" nodename=\"b\"/></dot><dot name=\"b\"><input name=\"in\" nodename=\"a\"/></dot><output name=\"o\" nodename=\"a\"/>";
    let tree = "<multiply name=\"a\"><input name=\"in1\" nodename=\"a\"/><input name=\"in2\" nodename=\"a\"/></multiply><output name=\"o\" nodename=\"a\"/>";
    let interface = "<input name=\"i\" interfacename=\"i\"/><dot name=\"a\"><input name=\"in\" interfacename=\"i\"/></dot><output name=\"o\" nodename=\"a\"/>";
    let cases = [
        ("<materialx>\n<a></b></materialx>".to_owned(), "2:"),
        ("<html/>".to_owned(), "line 1: it begins with \"html\""),
        (document(""), "line 2: it has no material"),
        (standard("<input name=\"base\" type=\"float\" value=\"much\"/>"), "line 4: the value \"much\" of \"base\""),
        (standard("<input name=\"base_color\" type=\"color3\" value=\"1, 2\"/>"), "\"base_color\" has 2 numbers"),
        (
            standard("<input name=\"base\" type=\"float\" nodename=\"nowhere\"/>"),
            "line 4: there is no node \"nowhere\"",
        ),
        (
            standard("<input name=\"bsae\" type=\"float\" value=\"1\"/>"),
            "line 4: standard_surface has no input \"bsae\"",
        ),
        (graph(circle, &to("o")), "circle"),
        (graph(tree, &to("o")), "circle"),
        (graph(interface, &to("o")), "circle"),
        (
            graph("<noise2d name=\"n\"/><output name=\"o\" nodename=\"n\"/>", &to("o")),
            "the node \"noise2d\" is not read",
        ),
        (graph("<image name=\"n\"/><output name=\"o\" nodename=\"n\"/>", &to("o")), "no input \"file\""),
        (graph("", &to("o")), "no such output"),
        (
            document(
                "<disney_principled name=\"s\"/><surfacematerial name=\"m\"><input name=\"surfaceshader\" nodename=\"s\"/></surfacematerial>",
            ),
            "line 3: the surface of \"m\" is disney_principled",
        ),
        (format!("<!DOCTYPE a [<!ENTITY e \"{}\">]>{}", "e".repeat(99), document("")), "DTD"),
    ];
    for (text, expected) in cases {
        let message = message(&text);
        assert!(message.contains(expected), "{expected}: {message}");
    }
    assert_eq!(message(&standard("<input name=\"base\" type=\"float\" value=\"0.5\"/>")), "", "negative control");
}

#[test]
fn depth_and_length_are_bounded() {
    let deep = "<a>".repeat(200_000) + &"</a>".repeat(200_000);
    assert!(!message(&document(&deep)).is_empty());
    let many = format!(
        "<standard_surface name=\"s\">{}</standard_surface>",
        "<input name=\"base\" value=\"1\"/>".repeat(50_000)
    );
    assert!(read(&document(&many), None).is_ok());
    assert!(matches!(read(&" ".repeat((64 << 20) + 1), None), Err(MaterialXError::TooLong { .. })));
}

#[test]
fn an_inverted_roughness_has_its_default() {
    let nodes = r#"<nodegraph name="g"><image name="p" type="float"><input name="file" type="filename" value="a.png"/></image>
<multiply name="m" type="float"><input name="in1" type="float" nodename="p"/><input name="in2" type="float" value="-1"/></multiply>
<add name="a" type="float"><input name="in1" type="float" nodename="m"/><input name="in2" type="float" value="1"/></add>
<output name="o" type="float" nodename="a"/></nodegraph>"#;
    let input = r#"<input name="specular_roughness" type="float" nodegraph="g" output="o"/>"#;
    let text =
        document(&format!("{nodes}<standard_surface name=\"s\" type=\"surfaceshader\">{input}</standard_surface>"));
    let ReadMaterial { material, remarks } = read(&text, None).unwrap();
    assert_eq!(material.parameters.number("specular_roughness"), 0.2);
    assert!(remarks.join("").contains("cannot be shifted"), "{remarks:?}");
    let ReadMaterial { material, .. } = read(&text.replace("value=\"1\"", "value=\"0\""), None).unwrap();
    assert!(material.maps.get("specular_roughness").is_some(), "negative control: not shifted");
}

#[test]
fn a_pattern_is_left_out_and_told() {
    let mut material = coated();
    material.maps.set("base_color", Some(SlotFile { procedural: Some(Default::default()), ..slot("") }));
    material.maps.set("coat_weight", Some(slot("a.png")));
    let written = write(&[material], Surface::OpenPbr).unwrap();
    assert!(!written.text.contains("value=\"\"") && written.text.contains("a.png"), "{}", written.text);
    assert!(written.remarks.join("").contains("the pattern of its base color is left out"), "{:?}", written.remarks);
}

/// One input of `open_pbr_surface`, as text.
fn open_pbr(inputs: &str) -> String {
    document(&format!("<open_pbr_surface name=\"s\" type=\"surfaceshader\">\n{inputs}\n</open_pbr_surface>"))
}
