//! Inputs of OpenPBR that materials keep and never render.

use super::*;

/// A value in range that is not a default, as a number and in text.
fn other_value(p: &Parameter) -> (Value, &'static str, &'static str) {
    match p.default {
        Value::Color(_) => (Value::Color(Vec3::new(0.125, 0.25, 0.75)), "color3", "0.125, 0.25, 0.75"),
        Value::Number(_) if p.range[0] >= 1.0 => (Value::Number(1.75), "float", "1.75"),
        Value::Number(_) => (Value::Number(0.375), "float", "0.375"),
    }
}

#[test]
fn what_openpbr_stores_is_read_told_and_written_again() {
    for p in BrdfModel::OpenPbr.stored_parameters() {
        let (value, kind, text) = other_value(p);
        let input = format!("<input name=\"{}\" type=\"{kind}\" value=\"{text}\"/>", p.name);
        let ReadMaterial { material, remarks } = read(&open_pbr(&input), None).unwrap();
        assert_eq!(material.parameters.get(p.name), Some(value), "{}", p.name);
        assert_eq!(remarks, [format!("stored but not rendered: {}", p.label.to_lowercase())]);
        let written = write(std::slice::from_ref(&material), Surface::OpenPbr).unwrap();
        assert_eq!((written.text.matches(&input).count(), written.remarks.len()), (1, 0), "{}", written.text);
        let again = read(&written.text, None).unwrap().material;
        assert_eq!((&again.parameters, &again.maps), (&material.parameters, &material.maps));

        let mut without = material.clone();
        without.parameters.set(p.name, p.default);
        assert_ne!(again.parameters, without.parameters, "negative control");
        let default = write(&[without], Surface::OpenPbr).unwrap().text;
        assert!(!default.contains(p.name), "a default is not written: {default}");
        let ReadMaterial { material, remarks } = read(&open_pbr(""), None).unwrap();
        assert_eq!((material.parameters.get(p.name), remarks.len()), (None, 0), "negative control: nothing is told");
    }
}

#[test]
fn maps_of_what_openpbr_stores_are_read_as_they_are_written() {
    for p in BrdfModel::OpenPbr.stored_parameters() {
        let space = if p.is_color() { ColorSpace::Srgb } else { ColorSpace::Linear };
        let map = SlotFile { color_space: Some(space), channel: Channel::R, ..slot("inside.png") };
        let mut material = coated();
        material.parameters.set(p.name, other_value(p).0);
        material.maps.set(p.name, Some(map.clone()));
        let written = write(&[material.clone()], Surface::OpenPbr).unwrap();
        let read = read(&written.text, None).unwrap();
        assert_eq!(read.material.maps, material.maps, "{}", written.text);
        assert_eq!(read.material.parameters.get(p.name), Some(other_value(p).0), "{}", p.name);
        assert_eq!(read.remarks, [format!("stored but not rendered: {}", p.label.to_lowercase())]);
        material.maps.set(p.name, Some(SlotFile { file: "outside.png".into(), ..map }));
        assert_ne!(read.material.maps, material.maps, "negative control");
    }
}

#[test]
fn a_plain_picture_of_a_stored_index_is_kept() {
    let nodes = r#"<image name="p" type="float"><input name="file" type="filename" value="film.png"/></image>"#;
    let surface = |input: &str| {
        format!(
            "{nodes}<open_pbr_surface name=\"s\"><input name=\"{input}\" type=\"float\" nodename=\"p\"/></open_pbr_surface>"
        )
    };
    let of = |input: &str| read(&document(&surface(input)), None).unwrap();
    assert_eq!(of("thin_film_ior").material.maps.get("thin_film_ior").unwrap().file, "maps/film.png");
    let rendered = of("coat_ior");
    assert!(rendered.remarks.join("").contains("cannot be shifted"), "negative control: {:?}", rendered.remarks);
}

#[test]
fn other_surfaces_tell_that_they_leave_out_what_is_stored() {
    let mut glass = MaterialFile { name: "Glass".into(), model: BrdfModel::OpenPbr, ..Default::default() };
    glass.parameters.set("transmission_weight", 1.0);
    glass.maps.set("thin_film_thickness", Some(slot("film.png")));
    for surface in [Surface::StandardSurface, Surface::GltfPbr] {
        let Written { text, remarks } = write(std::slice::from_ref(&glass), surface).unwrap();
        let expected =
            "parameters that are stored but not rendered are left out: transmission weight, thin film thickness";
        assert!(remarks.len() == 1 && remarks[0].ends_with(expected), "{remarks:?}");
        assert!(!text.contains("film"), "{text}");
        let ggx = MaterialFile { model: BrdfModel::Ggx, ..glass.clone() };
        assert!(write(&[ggx], surface).unwrap().remarks.is_empty(), "negative control: GGX stores nothing");
    }
}

#[test]
fn a_stored_value_that_is_none_is_told_and_an_unknown_input_too() {
    let wrong = open_pbr("<input name=\"transmission_depth\" type=\"float\" value=\"deep\"/>");
    assert!(message(&wrong).contains("line 4: the value \"deep\" of \"transmission_depth\""), "{}", message(&wrong));
    let old = open_pbr("<input name=\"transmission_dispersion\" type=\"float\" value=\"1\"/>");
    assert!(message(&old).contains("open_pbr_surface has no input \"transmission_dispersion\""), "{}", message(&old));
    let noise = "<noise2d name=\"n\" type=\"float\"/><open_pbr_surface name=\"s\" type=\"surfaceshader\"><input name=\"subsurface_weight\" type=\"float\" nodename=\"n\"/></open_pbr_surface>";
    assert!(
        message(&document(noise)).contains("\"subsurface_weight\" has its default"),
        "{}",
        message(&document(noise))
    );
    let standard = standard("<input name=\"transmission_depth\" type=\"float\" value=\"1\"/>");
    assert_eq!(message(&standard), "", "Standard Surface has the input");
}
