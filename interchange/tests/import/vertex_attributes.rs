//! Colors of vertices, second texture coordinates, and what textures show beyond their edges.

use super::{gltf::QUAD, *};
use base64::{Engine, engine::general_purpose::STANDARD};
use glam::Vec3;
use lapidary_core::{
    color::linear_from_srgb,
    texture::{UvSet, Wrap},
};

const RED_GREEN_BLUE_WHITE: [[u8; 4]; 4] = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 128], [255, 255, 255, 255]];

/// The quad with a second set of texture coordinates, turned by a quarter against the first, colors, and a material whose base
/// color and normal textures have `info`.
fn quad(colors: [[u8; 4]; 4], info: &str, alpha_mode: &str) -> Imported {
    let uvs = [[0f32, 0.], [0., 1.], [1., 1.], [1., 0.]];
    let bytes: Vec<u8> =
        uvs.iter().flatten().flat_map(|x| x.to_le_bytes()).chain(colors.into_iter().flatten()).collect();
    let more =
        format!(r#"{{"byteLength": 48, "uri": "data:application/octet-stream;base64,{}"}}"#, STANDARD.encode(bytes));
    let text = QUAD
        .embedded()
        .replace("\"bufferViews\": [", "\"bufferViews\": [{\"buffer\": 1, \"byteLength\": 32}, {\"buffer\": 1, \"byteOffset\": 32, \"byteLength\": 16}, ")
        .replace("\"bufferView\": 2", "\"bufferView\": 4")
        .replace("\"bufferView\": 1", "\"bufferView\": 3")
        .replace("\"bufferView\": 0", "\"bufferView\": 2")
        .replace("\"buffers\": [", &format!("\"buffers\": [{more}, "))
        .replace("{\"buffer\": 0", "{\"buffer\": 9")
        .replace("{\"buffer\": 1", "{\"buffer\": 0")
        .replace("{\"buffer\": 9", "{\"buffer\": 1")
        .replace("\"TEXCOORD_0\": 2", "\"TEXCOORD_0\": 2, \"TEXCOORD_1\": 3, \"COLOR_0\": 4")
        .replace("\"indices\": 1", "\"indices\": 1, \"material\": 0")
        .replace(
            "\"type\": \"VEC2\"}]",
            &format!(
                r#""type": "VEC2"}}, {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2"}},
                {{"bufferView": 1, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"}}],
                "images": [{{"uri": "a.png"}}], "samplers": [{{"wrapS": 33071, "wrapT": 33648}}, {{}}],
                "textures": [{{"source": 0, "sampler": 0}}, {{"source": 0, "sampler": 1}}],
                "materials": [{{"alphaMode": "{alpha_mode}", "pbrMetallicRoughness": {{"baseColorTexture": {info}}},
                    "normalTexture": {info}}}]"#
            ),
        );
    let files = Files::new();
    files.add_png("a.png", [0.25; 3]);
    let imported = import(&files.add("a.gltf", text)).unwrap();
    check_valid(&imported);
    imported
}

#[test]
fn colors_of_gltf_are_linear_factors_and_their_alpha_is_said_where_it_counts() {
    let imported = quad(RED_GREEN_BLUE_WHITE, r#"{"index": 1}"#, "OPAQUE");
    let mesh = &imported.scene.mesh;
    let of = |place: Vec3| mesh.colors[mesh.positions.iter().position(|p| *p == place).unwrap()];
    assert_eq!([of(Vec3::ZERO), of(Vec3::X), of(Vec3::new(1.0, 1.0, 0.0))], [Vec3::X, Vec3::Y, Vec3::Z]);
    assert!(imported.scene.materials[0].vertex_colors);
    assert_eq!(imported.report.warnings, [""; 0], "the alpha of opaque materials counts for nothing");
    let blended = quad(RED_GREEN_BLUE_WHITE, r#"{"index": 1}"#, "BLEND").report.warnings.join("\n");
    assert!(blended.contains("vertex colors with transparency"), "{blended}");
    let gray = quad([[128, 128, 128, 255]; 4], r#"{"index": 1}"#, "BLEND");
    assert!((gray.scene.mesh.colors[0].x - 128.0 / 255.0).abs() < 1e-6, "not decoded as sRGB");
    let white = quad([[255; 4]; 4], r#"{"index": 1}"#, "BLEND");
    assert!(white.scene.mesh.colors.is_empty() && !white.scene.materials[0].vertex_colors, "negative control");
    assert_eq!([gray, white].map(|imported| imported.report.warnings.len()), [0; 2]);
}

#[test]
fn a_slot_has_the_coordinates_and_the_edges_of_its_texture() {
    let slot =
        |info: &str| quad([[255; 4]; 4], info, "OPAQUE").scene.materials[0].maps.get("base_color").cloned().unwrap();
    let first = slot(r#"{"index": 1}"#);
    assert_eq!((first.uv_set, first.wrap), (UvSet::First, [Wrap::Repeat; 2]));
    let second = slot(r#"{"index": 0, "texCoord": 1}"#);
    assert_eq!((second.uv_set, second.wrap), (UvSet::Second, [Wrap::Clamp, Wrap::Mirror]));
    let third = quad([[255; 4]; 4], r#"{"index": 1, "texCoord": 2}"#, "OPAQUE").report.warnings.join("\n");
    assert!(third.contains("use a third set of texture coordinates"), "{third}");
    let mesh = quad([[255; 4]; 4], r#"{"index": 1}"#, "OPAQUE").scene.mesh;
    for ((uv, second), p) in mesh.uvs.iter().zip(&mesh.second_uvs).zip(&mesh.positions) {
        assert_eq!((*uv, *second), (Vec2::new(p.x, 1.0 - p.y), Vec2::new(p.y, p.x)));
    }
}

#[test]
fn tangents_are_along_the_coordinates_of_the_normal_map() {
    let tangent = |set: u32| {
        let mesh = quad([[255; 4]; 4], &format!(r#"{{"index": 1, "texCoord": {set}}}"#), "OPAQUE").scene.mesh;
        mesh.tangents[0].truncate()
    };
    assert!((tangent(0) - Vec3::X).length() < 1e-5 && (tangent(1) - Vec3::Y).length() < 1e-5);
}

#[test]
fn colors_of_obj_are_srgb_and_vertices_without_are_white() {
    let obj = "v 0 0 0 1 0.5 0\nv 1 0 0\nv 0 1 0 0 0 1 1\nv 2 0 0 2\nv 5 5 5\nv 6 5 5\nv 5 6 5\n\
               usemtl A\nf 1 2 3\nusemtl B\nf 5 6 7\n";
    let imported = import_alone("a.obj", obj).unwrap();
    check_valid(&imported);
    let mesh = &imported.scene.mesh;
    let of = |place: Vec3| mesh.colors[mesh.positions.iter().position(|p| *p == place).unwrap()];
    assert_eq!(of(Vec3::ZERO), Vec3::new(1.0, linear_from_srgb(0.5), 0.0));
    assert_eq!([of(Vec3::X), of(Vec3::Y), of(Vec3::splat(5.0))], [Vec3::ONE, Vec3::Z, Vec3::ONE]);
    assert_eq!(imported.scene.materials.iter().map(|m| m.vertex_colors).collect::<Vec<_>>(), [true, false]);
    let plain = import_alone("a.obj", obj.replace(" 1 0.5 0\n", "\n").replace(" 0 0 1 1\n", "\n")).unwrap();
    assert!(plain.scene.mesh.colors.is_empty() && plain.scene.materials.iter().all(|m| !m.vertex_colors));
    assert_eq!(mesh.positions, plain.scene.mesh.positions, "colors move nothing");
}

#[test]
fn colors_stay_at_their_vertices_where_the_mesh_is_far_away_or_has_seams_of_color() {
    let far = "v 4000000 0 0 1 0 0\nv 4000001 0 0 0 1 0\nv 4000000 1 0 0 0 1\nf 1 2 3\n";
    let mesh = import_alone("a.obj", far).unwrap().scene.mesh;
    let mut colors = mesh.colors.clone();
    colors.sort_by(|a, b| b.x.total_cmp(&a.x).then(b.y.total_cmp(&a.y)));
    assert_eq!(colors, [Vec3::X, Vec3::Y, Vec3::Z]);
    let red = mesh.colors.iter().position(|c| *c == Vec3::X).unwrap();
    assert!(mesh.positions[red].x < mesh.positions[mesh.colors.iter().position(|c| *c == Vec3::Y).unwrap()].x);
    let seam = |color: &str| {
        let obj = format!(
            "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 1 0 0 {color}\nv 0 1 0 {color}\nv 1 1 0 {color}\nf 1 2 3\nf 4 6 5\n"
        );
        import_alone("a.obj", obj).unwrap().scene.mesh.positions.len()
    };
    assert_eq!([seam("0 0 1"), seam("1 0 0")], [6, 4]);
}

#[test]
fn colors_of_ply_are_srgb_in_bytes_and_floats_and_all_the_color_of_a_surface_without_a_material() {
    let ply = |kind: &str, [red, half]: [&str; 2]| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property {kind} red\nproperty {kind} green\nproperty {kind} blue\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n\
             0 0 0 {red} 0 0\n1 0 0 {half} {half} {half}\n0 1 0 0 0 {red}\n3 0 1 2\n"
        )
    };
    for (kind, numbers) in [("uchar", ["255", "128"]), ("float", ["1", "0.5019608"]), ("ushort", ["65535", "32896"])] {
        let imported = import_alone("a.ply", ply(kind, numbers)).unwrap();
        check_valid(&imported);
        let mesh = &imported.scene.mesh;
        let of = |place: Vec3| mesh.colors[mesh.positions.iter().position(|p| *p == place).unwrap()];
        assert_eq!((of(Vec3::ZERO), of(Vec3::Y)), (Vec3::X, Vec3::Z), "{kind}");
        assert!((of(Vec3::X) - Vec3::splat(linear_from_srgb(128.0 / 255.0))).length() < 1e-4, "{kind}");
        let material = &imported.scene.materials[0];
        assert!(material.vertex_colors && material.parameters.color("base_color") == Vec3::ONE);
    }
    let plain = import_alone(
        "a.ply",
        ply("uchar", ["255", "255"]).replace(" 255 0 0", " 255 255 255").replace(" 0 0 255", " 255 255 255"),
    )
    .unwrap();
    assert!(plain.scene.mesh.colors.is_empty() && !plain.scene.materials[0].vertex_colors, "negative control");
    assert!(plain.scene.materials[0].parameters.color("base_color") != Vec3::ONE);
}

#[test]
fn colors_of_vertices_are_all_the_color_where_no_file_gives_one() {
    let files = Files::new();
    files.add("a.mtl", "newmtl Plain\nPr 0.25\nnewmtl Coat\nPc 1\nnewmtl Gray\nKd 0.5 0.5 0.5\n");
    let names = ["Missing", "Plain", "Coat", "Gray"];
    let base = |vertices: &str| {
        let faces: String = names.iter().map(|name| format!("usemtl {name}\nf 1 2 3\n")).collect();
        let imported = import(&files.add("a.obj", format!("mtllib a.mtl\n{vertices}{faces}"))).unwrap();
        imported.scene.materials.iter().map(|m| m.parameters.color("base_color").x).collect::<Vec<_>>()
    };
    assert_eq!(base("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\n"), [1.0, 1.0, 1.0, 0.5]);
    let white = base("v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\n");
    assert!(white[..3].iter().all(|gray| *gray < 1.0), "negative control: {white:?}");
}

#[test]
fn colors_of_obj_up_to_255_are_fractions_of_it_for_the_whole_file() {
    let colors = |obj: &str| {
        let mesh = import_alone("a.obj", obj).unwrap().scene.mesh;
        [Vec3::ZERO, Vec3::X, Vec3::Y].map(|at| mesh.colors[mesh.positions.iter().position(|p| *p == at).unwrap()])
    };
    let bytes = colors("v 0 0 0 255 128 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 255\nf 1 2 3\n");
    let [half, one] = [128.0, 1.0].map(|byte: f32| linear_from_srgb(byte / 255.0));
    assert_eq!(bytes, [Vec3::new(1.0, half, 0.0), Vec3::splat(one), Vec3::Z]);
    let rounded = colors("v 0 0 0 1.00001 0.5 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(rounded, [Vec3::new(1.0, linear_from_srgb(0.5), 0.0), Vec3::ONE, Vec3::Z], "negative control");
}
