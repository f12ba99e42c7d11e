//! What documents of other programs hold beside a plain surface: displacement, units, tiles, coordinates by nodes.

use super::*;

/// A document of a surface with these inputs after these nodes.
fn with_nodes(nodes: &str, surface: &str, inputs: &str) -> ReadMaterial {
    let text = format!("{nodes}<{surface} name=\"s\" type=\"surfaceshader\">{inputs}</{surface}>");
    read(&document(&text), None).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn number(input: &str, value: &str) -> String {
    format!("<input name=\"{input}\" type=\"float\" {value}/>")
}

#[test]
fn displacement_is_left_out_by_name_and_the_surface_is_read() {
    let nodes = r#"<nodegraph name="NG">
      <input name="tint" type="color3" value="0.5,0.5,0.5" colorspace="srgb_texture"/>
      <constant name="c" type="color3"><input name="value" type="color3" interfacename="tint"/></constant>
      <output name="out" type="color3" nodename="c"/></nodegraph>
    <standard_surface name="S" type="surfaceshader">
      <input name="base_color" type="color3" nodegraph="NG" output="out"/></standard_surface>
    <displacement name="D" type="displacementshader"><input name="scale" type="float" value="0.1"/></displacement>"#;
    let of = |connections: &str| {
        let surface = r#"<input name="surfaceshader" type="surfaceshader" nodename="S"/>"#;
        let material =
            format!("<surfacematerial name=\"M\" type=\"material\">{surface}{connections}</surfacematerial>");
        read(&document(&(nodes.to_owned() + &material)), None).unwrap()
    };
    let displaced = r#"<input name="displacementshader" type="displacementshader" nodename="D"/>"#;
    let ReadMaterial { material, remarks } = of(displaced);
    // ((0.5 + 0.055) / 1.055) to the power of 2.4
    assert!((material.parameters.color("base_color") - 0.214_041).abs().max_element() < 1e-5);
    assert_eq!(remarks, ["left out: displacement"]);
    let back = r#"<input name="backsurfaceshader" type="surfaceshader" nodename="S"/>"#;
    assert_eq!(of(back).remarks, ["left out: the surface of its back"]);
    for nothing in ["", r#"<input name="displacementshader" type="displacementshader"/>"#] {
        assert_eq!(of(nothing).remarks, [""; 0], "negative control");
    }
}

#[test]
fn a_surface_of_before_is_read_beside_its_displacement() {
    let text = |first: &str, second: &str| {
        let of = |node: &str| format!("<shaderref name=\"{node}_1\" node=\"{node}\"/>");
        format!("<materialx version=\"1.37\"><material name=\"m\">{}{}</material></materialx>", of(first), of(second))
    };
    for text in [text("displacement", "standard_surface"), text("standard_surface", "displacement")] {
        assert_eq!(read(&text, None).unwrap().remarks, ["left out: displacement"]);
    }
}

#[test]
fn light_below_the_surface_is_told_where_it_shows() {
    let picture = r#"<image name="p" type="float"><input name="file" type="filename" value="a.png"/></image>"#;
    let remarks = |value: &str| {
        let color = "<input name=\"subsurface_color\" type=\"color3\" value=\"1, 0, 0\"/>";
        with_nodes(picture, "standard_surface", &(number("subsurface", value) + color)).remarks
    };
    for shown in ["value=\"0.25\"", "nodename=\"p\""] {
        assert_eq!(remarks(shown), ["left out: subsurface scattering"]);
    }
    assert_eq!(remarks("value=\"0\""), [""; 0], "negative control: a weight of 0 shows nothing");
}

#[test]
fn a_color_for_a_number_is_told() {
    let of = |value: &str| {
        let opacity = format!("<input name=\"opacity\" type=\"color3\" value=\"{value}\"/>");
        with_nodes("", "standard_surface", &opacity)
    };
    let ReadMaterial { material, remarks } = of("0.5, 1, 1");
    assert_eq!(material.parameters.number("geometry_opacity"), 0.5);
    assert_eq!(remarks, ["of the color of \"opacity\" only the red is taken"]);
    assert_eq!(of("0.5, 0.5, 0.5").remarks, [""; 0], "negative control: gray");
}

/// The slot of a picture of roughness whose `texcoord` is the node `c`.
fn placed_by(coordinates: &str) -> (SlotFile, Vec<String>) {
    let nodes = format!(
        r#"<texcoord name="uv" type="vector2"/>{coordinates}
        <image name="p" type="float"><input name="file" type="filename" value="a.png"/>
        <input name="texcoord" type="vector2" nodename="c"/></image>"#
    );
    let ReadMaterial { material, remarks } =
        with_nodes(&nodes, "standard_surface", &number("specular_roughness", "nodename=\"p\""));
    (material.maps.get("specular_roughness").unwrap_or_else(|| panic!("{remarks:?}")).clone(), remarks)
}

fn place2d(inputs: &str) -> (SlotFile, Vec<String>) {
    placed_by(&format!(
        "<place2d name=\"c\" type=\"vector2\"><input name=\"texcoord\" type=\"vector2\" nodename=\"uv\"/>{inputs}</place2d>"
    ))
}

#[test]
fn numbers_are_read_in_their_units() {
    let rotation = |value: &str| place2d(&number("rotate", value)).0.rotation_degrees;
    let degrees = rotation("value=\"90\" unittype=\"angle\" unit=\"degree\"");
    assert!((degrees.abs() - 90.0).abs() < 1e-3, "{degrees}");
    assert!((rotation("value=\"1.5707964\" unittype=\"angle\" unit=\"radian\"") - degrees).abs() < 1e-3);
    assert!((rotation("value=\"1.5707964\"") - degrees).abs() > 80.0, "negative control: without a unit");

    let tiles = |unit: &str| {
        let nodes = format!(
            r#"<tiledimage name="p" type="float"><input name="file" type="filename" value="a.png"/>
            <input name="realworldimagesize" type="vector2" value="50, 25" unit="{unit}"/>
            <input name="realworldtilesize" type="vector2" value="1, 1" unit="meter"/></tiledimage>
            <bump name="b" type="vector3"><input name="height" type="float" nodename="p"/>
            <input name="scale" type="float" value="2" unit="{unit}"/></bump>"#
        );
        let normal = r#"<input name="normal" type="vector3" nodename="b"/>"#;
        let read = with_nodes(&nodes, "standard_surface", normal);
        let slot = read.material.maps.get(BUMP).unwrap().clone();
        (slot.scale, slot.strength, read.remarks)
    };
    let (scale, height, remarks) = tiles("centimeter");
    assert!((scale - Vec2::new(2.0, 4.0)).length() < 1e-5 && (height - 0.02).abs() < 1e-7, "{scale} {height}");
    assert_eq!(remarks, [""; 0]);
    assert!((tiles("meter").0.x - 0.02).abs() < 1e-5, "negative control");
    let (scale, _, remarks) = tiles("cubit");
    assert_eq!(scale.x, 0.02);
    assert!(remarks[0].contains("the unit \"cubit\" of \"realworldimagesize\""), "{remarks:?}");

    let film = |value: &str| read(&open_pbr(&number("thin_film_thickness", value)), None).unwrap().material;
    let thickness = |value: &str| film(value).parameters.number("thin_film_thickness");
    assert!((thickness("value=\"300\" unit=\"nanometer\"") - 0.3).abs() < 1e-6);
    assert_eq!(thickness("value=\"0.3\""), 0.3, "micrometers of OpenPBR");
}

#[test]
fn coordinates_by_several_nodes_are_those_of_one() {
    let rotated = |amount: f32| {
        format!(
            r#"<rotate2d name="c" type="vector2"><input name="in" type="vector2" nodename="m"/>
            <input name="amount" type="float" value="{amount}"/></rotate2d>
            <multiply name="m" type="vector2"><input name="in1" type="vector2" nodename="uv"/>
            <input name="in2" type="vector2" value="2, 4"/></multiply>"#
        )
    };
    let of_place2d =
        place2d(&(number("rotate", "value=\"30\"") + "<input name=\"scale\" type=\"vector2\" value=\"0.5, 0.25\"/>"));
    let difference = |a: &SlotFile, b: &SlotFile| {
        (a.scale - b.scale).length() + (a.offset - b.offset).length() + (a.rotation_degrees - b.rotation_degrees).abs()
    };
    assert!(difference(&of_place2d.0, &placed_by(&rotated(30.0)).0) < 1e-3);
    assert!(difference(&of_place2d.0, &placed_by(&rotated(-30.0)).0) > 1.0, "negative control");
    let combined = |node: &str, value: &str| {
        let second = format!("<input name=\"in2\" type=\"float\" value=\"{value}\"/>");
        placed_by(&format!(
            "<{node} name=\"c\"><input name=\"in1\" type=\"vector2\" nodename=\"uv\"/>{second}</{node}>"
        ))
        .0
    };
    assert_eq!(combined("divide", "0.5").scale, Vec2::splat(2.0));
    // v begins at the bottom.
    assert_eq!(
        (combined("add", "0.25").offset, combined("subtract", "0.25").offset),
        (Vec2::new(0.25, -0.25), Vec2::new(-0.25, 0.25))
    );
}

#[test]
fn a_picture_of_tiles_is_told_in_words_of_the_user() {
    let of = |file: &str| {
        let nodes = format!(
            "<image name=\"p\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"{file}\"/></image>"
        );
        with_nodes(&nodes, "standard_surface", "<input name=\"base_color\" type=\"color3\" nodename=\"p\"/>")
    };
    for token in ["UDIM", "UVTILE"] {
        let ReadMaterial { material, remarks } = of(&format!("c_&lt;{token}&gt;.png"));
        assert!(material.maps.get("base_color").is_none());
        let said = format!(
            "line 3: the picture \"c_<{token}>.png\" is one of several tiles, which are not read; join them to one \
             picture; \"base_color\" has its default"
        );
        assert_eq!(remarks, [said]);
    }
    assert!(of("c_{frame}.png").remarks[0].contains("stands for several"));
    assert_eq!(of("c_1001.png").remarks, [""; 0], "negative control");
}

#[test]
fn the_innermost_prefix_of_files_counts() {
    let file = |graph: &str, input: &str| {
        let nodes = format!(
            r#"<nodegraph name="g"{graph}><image name="p" type="color3"><input name="file" type="filename" value="a.png"{input}/>
            </image><output name="o" type="color3" nodename="p"/></nodegraph>"#
        );
        let color = "<input name=\"base_color\" type=\"color3\" nodegraph=\"g\" output=\"o\"/>";
        with_nodes(&nodes, "standard_surface", color).material.maps.get("base_color").unwrap().file.clone()
    };
    assert_eq!(file("", ""), "maps/a.png", "of the document");
    assert_eq!(file(" fileprefix=\"wood/\"", ""), "wood/a.png");
    assert_eq!(file(" fileprefix=\"wood/\"", " fileprefix=\"oak_\""), "oak_a.png");
    assert_eq!(file(" fileprefix=\"\"", ""), "a.png");
}

#[test]
fn a_turned_normal_map_is_told_where_its_normals_turn_otherwise() {
    let of = |node: &str, coordinates: &str| {
        let image = format!(
            r#"<input name="file" type="filename" value="n.png"/>{}"#,
            if coordinates.is_empty() { "" } else { r#"<input name="texcoord" type="vector2" nodename="c"/>"# }
        );
        let nodes = match node {
            "normalmap" => format!(
                r#"<image name="p" type="vector3">{image}</image>
                <normalmap name="n" type="vector3"><input name="in" type="vector3" nodename="p"/></normalmap>"#
            ),
            other => format!("<{other} name=\"n\" type=\"vector3\">{image}</{other}>"),
        };
        let place = format!("<place2d name=\"c\" type=\"vector2\">{coordinates}</place2d>");
        let normal = r#"<input name="normal" type="vector3" nodename="n"/>"#;
        let ReadMaterial { material, remarks } = with_nodes(&(place + &nodes), "standard_surface", normal);
        assert!(material.maps.get(NORMAL).is_some(), "{remarks:?}");
        remarks
    };
    let turned = number("rotate", "value=\"90\"");
    let mirrored = "<input name=\"scale\" type=\"vector2\" value=\"-1, 1\"/>";
    for coordinates in [&turned, mirrored] {
        assert!(of("normalmap", coordinates)[0].contains("the normals turn with their picture"));
        assert_eq!(of("gltf_normalmap", coordinates), [""; 0], "as in glTF");
    }
    let larger = "<input name=\"scale\" type=\"vector2\" value=\"0.25, 0.5\"/>";
    assert_eq!((of("normalmap", larger), of("normalmap", "")), (Vec::new(), Vec::new()), "negative control");

    let mut material = coated();
    material.maps.set(NORMAL, Some(SlotFile { rotation_degrees: 90.0, ..slot("n.png") }));
    let remarks = |material: &MaterialFile| write(std::slice::from_ref(material), Surface::OpenPbr).unwrap().remarks;
    assert!(remarks(&material)[0].contains("its normals turn with their picture here"), "{:?}", remarks(&material));
    material.maps.set(NORMAL, Some(SlotFile { scale: Vec2::splat(2.0), ..slot("n.png") }));
    assert_eq!(remarks(&material), [""; 0], "negative control");
}

#[test]
fn thin_walls_have_two_sides_also_by_a_connection() {
    let nodes = |value: &str| {
        format!(
            r#"<nodegraph name="g"><input name="thin" type="boolean" value="{value}"/><constant name="k" type="boolean">
            <input name="value" type="boolean" interfacename="thin"/></constant><output name="o" type="boolean" nodename="k"/>
            </nodegraph>"#
        )
    };
    for (value, expected) in [("true", true), ("false", false)] {
        for connection in [format!("value=\"{value}\""), "nodegraph=\"g\" output=\"o\"".into()] {
            let thin = format!("<input name=\"thin_walled\" type=\"boolean\" {connection}/>");
            let ReadMaterial { material, remarks } = with_nodes(&nodes(value), "standard_surface", &thin);
            assert_eq!((material.double_sided, remarks), (expected, vec![]), "{connection}");
        }
    }
    let sheet =
        MaterialFile { double_sided: true, name: "Leaf".into(), model: BrdfModel::OpenPbr, ..Default::default() };
    for surface in Surface::ALL {
        let Written { text, remarks } = write(std::slice::from_ref(&sheet), surface).unwrap();
        let is_kept = read(&text, None).unwrap().material.double_sided;
        assert_eq!(is_kept, remarks.is_empty(), "{surface:?}: {remarks:?}");
        assert_eq!(is_kept, surface != Surface::GltfPbr);
    }
}

#[test]
fn prefixes_of_names_need_no_declaration() {
    let text = |prefix: &str| {
        standard("<input name=\"base\" type=\"float\" value=\"0.5\"/>")
            .replace("</materialx>", &format!("<{prefix}:note/></materialx>"))
    };
    let read = read(&text("acme"), None).unwrap();
    assert_eq!((read.material.parameters.number("base_weight"), read.remarks), (0.5, vec![]));
    assert!(message("<materialx>\n<a:b></materialx>").starts_with("line 2: it is not well-formed XML"));
}

#[test]
fn the_primaries_of_a_float_picture_are_in_its_own_file() {
    let of = |file: &str, kind: &str, input: &str| {
        let nodes = format!(
            "<image name=\"p\" type=\"{kind}\"><input name=\"file\" type=\"filename\" value=\"{file}\" colorspace=\"lin_rec709\"/></image>"
        );
        let input = format!("<input name=\"{input}\" type=\"{kind}\" nodename=\"p\"/>");
        with_nodes(&nodes, "standard_surface", &input).material
    };
    let space = |file: &str| of(file, "color3", "base_color").maps.get("base_color").unwrap().color_space;
    assert_eq!(
        (space("a.EXR"), space("a.hdr"), space("a.png")),
        (Some(ColorSpace::Srgb), Some(ColorSpace::Srgb), Some(ColorSpace::Linear))
    );
    let roughness = of("a.exr", "float", "specular_roughness");
    assert_eq!(roughness.maps.get("specular_roughness").unwrap().color_space, Some(ColorSpace::Linear), "a value");
    let text = write(&[of("a.exr", "color3", "base_color")], Surface::OpenPbr).unwrap().text;
    assert!(!text.contains("srgb_texture"), "{text}");
}

#[test]
fn values_of_a_float_picture_stay_values() {
    let of = |space: &str| {
        let file = format!("<input name=\"file\" type=\"filename\" value=\"a.exr\" colorspace=\"{space}\"/>");
        let nodes = format!("<image name=\"p\" type=\"color3\">{file}</image>");
        let input = "<input name=\"base_color\" type=\"color3\" nodename=\"p\"/>";
        let read = with_nodes(&nodes, "open_pbr_surface", input);
        assert!(read.remarks.is_empty(), "{space}: {:?}", read.remarks);
        read.material
    };
    let space = |material: &MaterialFile| material.maps.get("base_color").unwrap().color_space;
    for values in ["raw", "none", "Raw"] {
        let material = of(values);
        assert_eq!(space(&material), Some(ColorSpace::Linear), "{values}");
        let again = read(&write(&[material], Surface::OpenPbr).unwrap().text, None).unwrap();
        assert_eq!(space(&again.material), Some(ColorSpace::Linear), "{values}");
    }
    for (name, expected) in [
        ("lin_rec709", ColorSpace::Srgb),
        ("", ColorSpace::Srgb),
        ("ACEScg", ColorSpace::AcesCg),
        ("ACES2065-1", ColorSpace::Aces2065),
        ("Lin_Rec2020", ColorSpace::Rec2020),
    ] {
        assert_eq!(space(&of(name)), Some(expected), "{name}");
    }
}

/// A base color by a picture `i` of colors, whose node has `inputs`, and nodes behind it.
fn picture(inputs: &str, behind: &str) -> ReadMaterial {
    let end = if behind.is_empty() { "i" } else { "n" };
    let nodes = format!(
        r#"<nodegraph name="g"><input name="edges" type="string" value="clamp"/><image name="i" type="color3">
        <input name="file" type="filename" value="a.png"/>{inputs}</image>{behind}<output name="o" type="color3" nodename="{end}"/>
        </nodegraph>"#
    );
    with_nodes(&nodes, "open_pbr_surface", r#"<input name="base_color" type="color3" nodegraph="g" output="o"/>"#)
}

#[test]
fn an_added_color_is_told_whichever_component_it_has() {
    let added = |value: &str| {
        let node = format!(
            r#"<add name="n" type="color3"><input name="in1" type="color3" nodename="i"/>
            <input name="in2" type="color3" value="{value}"/></add>"#
        );
        let ReadMaterial { material, remarks } = picture("", &node);
        (material.maps.get("base_color").is_some(), remarks)
    };
    for value in ["0.5, 0, 0", "0, 0.5, 0", "0, 0, 0.5"] {
        let (is_kept, remarks) = added(value);
        assert!(!is_kept && remarks.join("").contains("cannot be shifted"), "{value}: {remarks:?}");
    }
    assert_eq!(added("0, 0, 0"), (true, Vec::new()), "negative control");
}

#[test]
fn edges_of_a_picture_may_come_from_the_graph_around_it() {
    use lapidary_core::texture::Wrap;
    let wrap = |told: &str| {
        let read = picture(&format!("<input name=\"uaddressmode\" type=\"string\" {told}/>"), "");
        read.material.maps.get("base_color").unwrap().wrap
    };
    assert_eq!(wrap("interfacename=\"edges\""), [Wrap::Clamp, Wrap::Repeat]);
    assert_eq!(wrap("value=\"mirror\""), [Wrap::Mirror, Wrap::Repeat]);
    assert_eq!(wrap("interfacename=\"none\""), [Wrap::Repeat; 2], "negative control");
}

#[test]
fn inputs_of_other_surfaces_are_told() {
    for input in ["normal", "thin_walled", "alpha_mode"] {
        let remarks = with_nodes("", "open_pbr_surface", &number(input, "value=\"1\"")).remarks;
        assert_eq!(remarks, [format!("line 3: open_pbr_surface has no input \"{input}\", which is left out")]);
    }
    let remarks = with_nodes("", "standard_surface", &number("emission_colour", "value=\"1\"")).remarks;
    assert!(remarks[0].contains("standard_surface has no input \"emission_colour\""), "{remarks:?}");
    let own = with_nodes("", "gltf_pbr", &number("alpha_mode", "value=\"1\""));
    assert_eq!(own.remarks, [""; 0], "negative control");
}
