//! glTF files as other programs write them: several scenes, optional parts left out, wrong paddings, quantized meshes.

use super::{
    gltf::{Gltf, QUAD},
    *,
};
use base64::{Engine, engine::general_purpose::STANDARD};
use lapidary_core::brdf::GgxParameters;

/// The file of a scene with replacements, each of which must be in it.
fn replaced(scene: &Gltf, changes: &[(&str, &str)]) -> String {
    let mut json = scene.embedded();
    for (from, to) in changes {
        assert!(json.contains(from), "{from}");
        json = json.replacen(from, to, 1);
    }
    json
}

fn shown(json: &str) -> Imported {
    let imported = import_alone("a.gltf", json).unwrap();
    check_valid(&imported);
    imported
}

#[test]
fn one_scene_of_several_is_shown_and_the_others_are_named() {
    let two =
        Gltf { nodes: r#"[{"mesh": 0, "name": "A", "translation": [-1, 0, 0]}, {"mesh": 0, "name": "B"}]"#, ..QUAD };
    let scenes = r#""scene": 0, "scenes": [{"nodes": [0]}]"#;
    let with = |text: &str| replaced(&two, &[(scenes, text)]);
    let both = r#""scenes": [{"nodes": [0], "name": "left"}, {"nodes": [1]}]"#;
    let names = |imported: &Imported| imported.scene.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    let files = Files::new();
    let path = files.add("two.gltf", with(&format!(r#""scene": 1, {both}"#)));
    let default = import(&path).unwrap();
    assert_eq!(names(&default), ["B"]);
    assert_eq!(default.scene.mesh.bounds().min.x, 0.0, "nothing is in the left half");
    assert_eq!(default.report.scenes, ["left", "scene 1"]);
    let warnings = default.report.warnings.join("\n");
    assert!(warnings.contains("\"scene 1\" is shown, and \"left\" left out"), "{warnings}");
    assert_eq!(names(&shown(&with(both))), ["A"], "the first without a default");
    let empty_first = r#""scene": 0, "scenes": [{"nodes": []}, {"nodes": [1]}]"#;
    assert_eq!(names(&shown(&with(empty_first))), ["B"], "the first with nodes");
    assert_eq!(names(&shown(&with(r#""scenes": [{"nodes": []}]"#))), ["A", "B"], "all nodes without any in scenes");
    assert_eq!(names(&shown(&with(r#""asset2": 0"#))), ["A", "B"], "all nodes without scenes");
    let chosen = |name: &str| import_with(&path, &ImportOptions { scene: Some(name.into()), ..Default::default() });
    assert_eq!(names(&chosen("left").unwrap()), ["A"]);
    assert_eq!(names(&chosen("0").unwrap()), ["A"]);
    assert_eq!(names(&chosen("scene 1").unwrap()), ["B"]);
    for name in ["2", "-1", "right"] {
        let refused = chosen(name).unwrap_err().to_string();
        assert!(refused.contains(&format!("no scene \"{name}\"; it has \"left\", \"scene 1\"")), "{refused}");
    }
    let options = ImportOptions { scene: Some("left".into()), ..Default::default() };
    assert!(import_with(&files.add("a.ply", "ply\n"), &options).unwrap_err().to_string().contains("it has none"));
    let alone = import_alone("a.gltf", QUAD.embedded()).unwrap();
    assert!(alone.report.scenes.is_empty() && alone.report.warnings.is_empty(), "negative control");
}

#[test]
fn optional_parts_may_be_left_out() {
    let whole = shown(&QUAD.embedded()).scene.mesh;
    let second_scene = (r#""scenes": [{"nodes": [0]}]"#, r#""scenes": [{"nodes": [0]}, {"name": "Empty"}]"#);
    let no_bounds = (r#", "min": [0, 0, 0], "max": [1, 1, 0]"#, "");
    let bad_bounds = (r#""min": [0, 0, 0]"#, r#""min": [0, null, 0]"#);
    for change in [second_scene, no_bounds, bad_bounds] {
        let imported = shown(&replaced(&QUAD, &[change]));
        assert_eq!(imported.scene.mesh, whole, "{change:?}");
        assert_eq!(imported.report.warnings, [""; 0]);
    }
    // Texture coordinates without data are zeros.
    let zeros = shown(&replaced(&QUAD, &[(r#"{"bufferView": 2, "componentType": 5126"#, r#"{"componentType": 5126"#)]));
    assert_eq!(zeros.scene.mesh.uvs, [Vec2::ZERO; 4]);
    assert_eq!(zeros.scene.mesh.positions, whole.positions);
    // Positions without data have no extent, which is told.
    let json = replaced(&QUAD, &[(r#"{"bufferView": 0, "componentType": 5126"#, r#"{"componentType": 5126"#)]);
    let error = import_alone("a.gltf", json).unwrap_err();
    assert!(matches!(error, ImportError::Mesh { source: MeshError::TooSmall { .. }, .. }), "{error}");
    // What is needed is still needed.
    for (from, to, lack) in [
        (r#""count": 4, "type": "VEC3""#, r#""type": "VEC3""#, r#""accessors[0]" lacks the field "count""#),
        (r#""buffer": 0, "byteLength": 48"#, r#""byteLength": 48"#, r#""bufferViews[0]" lacks the field "buffer""#),
    ] {
        let refused = import_alone("a.gltf", replaced(&QUAD, &[(from, to)])).unwrap_err().to_string();
        assert!(refused.contains(lack) && refused.ends_with("a.gltf)"), "{refused}");
    }
}

#[test]
fn textures_without_a_picture_are_left_out_by_name() {
    let with = |textures: &str| {
        let rest = format!(
            r#", "images": [{{"uri": "a.png"}}], "textures": [{textures}],
            "materials": [{{"name": "wood", "pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}},
                "normalTexture": {{"index": 1}}}}]"#
        );
        let scene =
            Gltf { primitive: r#""indices": 1, "material": 0"#, rest: Box::leak(rest.into_boxed_str()), ..QUAD };
        let files = Files::new();
        files.add_png("a.png", [0.5; 3]);
        import(&files.add("a.gltf", scene.embedded())).unwrap()
    };
    let imported = with(r#"{"sampler": null}, {"source": 0}"#);
    let maps = &imported.scene.materials[0].maps;
    assert!(maps.get("base_color").is_none() && maps.get("normal").is_some());
    let warnings = &imported.report.warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("\"wood\" name textures without a picture"), "{warnings:?}");
    let in_extension = with(r#"{"extensions": {"EXT_texture_webp": {"source": 0}}}, {"source": 0}"#);
    assert!(in_extension.scene.materials[0].maps.get("base_color").is_some());
    assert_eq!(in_extension.report.warnings, [""; 0], "negative control");
}

#[test]
fn required_extensions_of_looks_are_told_and_those_of_shapes_refused() {
    let with = |name: &str| {
        let rest = format!(r#", "extensionsRequired": ["{name}"]"#);
        import_alone("a.gltf", Gltf { rest: Box::leak(rest.into_boxed_str()), ..QUAD }.embedded())
    };
    for name in [
        "KHR_materials_unlit",
        "KHR_materials_iridescence",
        "KHR_materials_volume",
        "ACME_materials_magic",
        "MSFT_texture_dds",
        "EXT_texture_avif",
        "EXT_lights_image_based",
        "KHR_node_visibility",
        "MSFT_lod",
    ] {
        let warnings = with(name).unwrap().report.warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(&format!("\"{name}\"")), "{warnings:?}");
    }
    for name in ["KHR_materials_sheen", "KHR_materials_pbrSpecularGlossiness", "KHR_mesh_quantization", "KHR_xmp"] {
        assert_eq!(with(name).unwrap().report.warnings, [""; 0], "nothing of {name} is lost");
    }
    for name in ["EXT_mesh_gpu_instancing", "ACME_magic", ""] {
        assert!(matches!(with(name), Err(ImportError::Extensions { .. })), "negative control");
    }
}

#[test]
fn version_1_is_named() {
    let old = import_alone("a.gltf", r#"{"asset": {"version": "1.0"}, "accessors": {"a": {}}, "meshes": {}}"#);
    let mut binary = QUAD.binary();
    binary[4] = 1;
    for error in [old.unwrap_err(), import_alone("a.glb", binary).unwrap_err()] {
        let message = error.to_string();
        assert!(message.contains("is glTF 1.0") && message.contains("gltf-pipeline"), "{message}");
    }
    shown(&replaced(&QUAD, &[(r#""version": "2.0""#, r#""version": "2.1""#)]));
}

/// A GLB of chunks, with the length that its header gives.
fn glb(chunks: &[(&[u8; 4], u32, &[u8])], more: i32) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, length, data) in chunks {
        body.extend(length.to_le_bytes());
        body.extend(*kind);
        body.extend(*data);
    }
    let length = (12 + body.len()) as i32 + more;
    [b"glTF\x02\0\0\0".as_slice(), &length.to_le_bytes(), &body].concat()
}

#[test]
fn binary_files_with_wrong_lengths_open() {
    let mut json = QUAD.json(r#"{"byteLength": 92}"#).into_bytes();
    json.truncate(json.trim_ascii_end().len());
    while json.len() % 4 != 2 {
        json.push(b' ');
    }
    let unpadded = json.len() as u32;
    let padded = [json.as_slice(), b"\0\0"].concat();
    let (buffer, odd) = (Gltf::buffer(), [Gltf::buffer(), vec![0; 2]].concat());
    let expected = import_alone("a.glb", QUAD.binary()).unwrap().scene.mesh;
    let good: [Vec<u8>; 8] = [
        glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 92, &buffer)], 0),
        glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 92, &buffer)], 3),
        glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 92, &buffer)], -3),
        glb(&[(b"JSON", unpadded, &json), (b"BIN\0", 92, &buffer)], 0),
        glb(&[(b"JSON", unpadded, &padded), (b"BIN\0", 92, &buffer)], 0),
        glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 95, &buffer)], 0),
        glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 94, &odd)], 0),
        glb(
            &[(b"JSON", unpadded + 2, &padded), (b"ACME", 4, b"abcd"), (b"BIN\0", 92, &buffer), (b"MORE", 4, b"abcd")],
            0,
        ),
    ];
    for (index, bytes) in good.iter().enumerate() {
        assert_eq!(import_alone("a.glb", bytes).unwrap().scene.mesh, expected, "file {index}");
    }
    let bad: [(Vec<u8>, &str); 4] = [
        (glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 92, &buffer)], 4), "it was truncated"),
        (glb(&[(b"JSON", unpadded + 2, &padded), (b"BIN\0", 96, &buffer)], 0), "chunk \"BIN\" has 92 of 96 bytes"),
        (glb(&[(b"BIN\0", 92, &buffer)], 0), "no JSON chunk"),
        (glb(&[(b"JSON", unpadded + 2, &padded)], 0), "binary chunk is missing"),
    ];
    for (bytes, reason) in bad {
        let message = import_alone("a.glb", bytes).unwrap_err().to_string();
        assert!(message.contains(reason) && message.ends_with("a.glb)"), "{message}");
    }
}

#[test]
fn embedded_data_may_lack_its_padding_and_be_on_lines() {
    let data = STANDARD.encode(Gltf::buffer());
    let with = |text: &str| {
        import_alone("a.gltf", QUAD.json(&format!(r#"{{"byteLength": 92, "uri": "data:;base64,{text}"}}"#)))
    };
    let whole = with(&data).unwrap().scene.mesh;
    let lines: Vec<&str> = data.as_bytes().chunks(76).map(|line| std::str::from_utf8(line).unwrap()).collect();
    for text in [data.trim_end_matches('=').to_owned(), lines.join("\\n"), lines.join("\\r\\n ")] {
        assert_eq!(with(&text).unwrap().scene.mesh, whole, "{text}");
    }
    for text in [data.replacen('A', "!", 1), data[..80].to_owned()] {
        assert!(with(&text).is_err(), "negative control: {text}");
    }
}

#[test]
fn specular_glossiness_becomes_metallic_roughness() {
    let with = |extension: &str| {
        let rest = format!(
            r#", "extensionsUsed": ["KHR_materials_pbrSpecularGlossiness"], "images": [{{"uri": "a.png"}}],
            "textures": [{{"source": 0}}], "materials": [{{"name": "m",
                "extensions": {{"KHR_materials_pbrSpecularGlossiness": {{{extension}}}}}}}]"#
        );
        let scene =
            Gltf { primitive: r#""indices": 1, "material": 0"#, rest: Box::leak(rest.into_boxed_str()), ..QUAD };
        let files = Files::new();
        files.add_rgba("a.png", [1, 1], &[188, 188, 188, 64]);
        import(&files.add("a.gltf", scene.embedded())).unwrap()
    };
    let of = |imported: &Imported| {
        let p = GgxParameters::from(&imported.scene.materials[0].parameters);
        (p.base_color, p.metalness, p.roughness)
    };
    let plastic =
        with(r#""diffuseFactor": [0.5, 0.25, 0.1, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.7"#);
    let (base, metalness, roughness) = of(&plastic);
    assert!(base.distance(Vec3::new(0.5, 0.25, 0.1)) < 1e-3 && metalness < 1e-3, "{base} {metalness}");
    assert!((roughness - 0.3).abs() < 1e-6);
    assert_eq!(plastic.report.warnings, [""; 0]);
    let gold = with(r#""diffuseFactor": [0, 0, 0, 1], "specularFactor": [1, 0.77, 0.34]"#);
    let (base, metalness, roughness) = of(&gold);
    assert!(
        base.distance(Vec3::new(1.0, 0.77, 0.34)) < 1e-2 && metalness > 0.99 && roughness < 1e-6,
        "{base} {metalness}"
    );
    let mapped = with(
        r#""specularFactor": [0.04, 0.04, 0.04], "diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 0}"#,
    );
    let (base, metalness, roughness) = of(&mapped);
    assert!(
        mapped.scene.materials[0].maps.get("base_color").is_some() && metalness < 1e-3 && base.min_element() > 0.95,
        "{base}"
    );
    assert!((roughness - (1.0 - 64.0 / 255.0)).abs() < 1e-3, "{roughness}");
    assert!(mapped.report.warnings[0].contains("\"m\" have a map of specular color and glossiness"));
    let metal = with(r#""specularFactor": [1, 0.77, 0.34], "diffuseTexture": {"index": 0}"#);
    assert!(metal.scene.materials[0].maps.get("base_color").is_none());
    assert!(metal.report.warnings[0].contains("\"m\" are metals with a diffuse map"), "{:?}", metal.report.warnings);
}

#[test]
fn equal_names_are_told_apart() {
    let scene = Gltf {
        nodes: r#"[{"mesh": 0, "name": "Wheel", "children": [1, 2]}, {"mesh": 0, "name": "Wheel", "translation": [2, 0, 0]},
            {"mesh": 0, "name": "Body", "translation": [4, 0, 0]}]"#,
        rest: r#", "materials": [{"name": "Red"}, {"name": "Red"}, {"name": "Red 2"}]"#,
        ..QUAD
    };
    let scene = shown(&scene.embedded()).scene;
    assert_eq!(scene.objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(), ["Wheel", "Wheel 2", "Body"]);
    let materials: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(materials[..3], ["Red", "Red 3", "Red 2"]);
}

/// The quad in bytes, half of them normalized, below a node that restores its size.
fn quantized(component: u32, scale: f32, is_normalized: bool, positions: &[u8]) -> String {
    let size = if component > 5121 { 8 } else { 4 };
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let normals = [0u8, 0, 127, 0].repeat(4);
    let data = STANDARD.encode([positions, &normals, &indices].concat());
    let at = positions.len();
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"], "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"mesh": 0, "scale": [{scale}, {scale}, {scale}]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 1}}, "indices": 2}}]}}],
        "buffers": [{{"byteLength": {}, "uri": "data:;base64,{data}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {at}, "byteStride": {size}}},
            {{"buffer": 0, "byteOffset": {at}, "byteLength": 16, "byteStride": 4}},
            {{"buffer": 0, "byteOffset": {}, "byteLength": 12}}],
        "accessors": [
            {{"bufferView": 0, "componentType": {component}, "normalized": {is_normalized}, "count": 4, "type": "VEC3",
                "min": [0, 0, 0], "max": [100, 100, 0]}},
            {{"bufferView": 1, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3"}},
            {{"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}}]}}"#,
        at + 28,
        at + 16,
    )
}

#[test]
fn quantized_meshes_are_read() {
    let corners = [[0u8, 0], [100, 0], [100, 100], [0, 100]];
    let bytes: Vec<u8> = corners.iter().flat_map(|[x, y]| [*x, *y, 0, 0]).collect();
    let shorts: Vec<u8> = corners.iter().flat_map(|[x, y]| [*x, 0, *y, 0, 0, 0, 0, 0]).collect();
    let cases: [(u32, f32, bool, &[u8], f32); 6] = [
        (5120, 0.01, false, &bytes, 1.0),
        (5121, 0.01, false, &bytes, 1.0),
        (5121, 1.0, true, &bytes, 100.0 / 255.0),
        (5120, 1.0, true, &bytes, 100.0 / 127.0),
        (5122, 0.01, false, &shorts, 1.0),
        (5123, 655.35, true, &shorts, 1.0),
    ];
    for (component, scale, is_normalized, positions, expected) in cases {
        let json = quantized(component, scale, is_normalized, positions);
        let imported = shown(&json);
        let mesh = &imported.scene.mesh;
        assert!(
            (mesh.bounds().max - Vec3::new(expected, expected, 0.0)).length() < 1e-5,
            "{component}: {}",
            mesh.bounds().max
        );
        assert!(mesh.normals.iter().all(|normal| *normal == Vec3::Z));
        assert_eq!((imported.report.normals_rebuilt, imported.report.warnings), (0, Vec::<String>::new()));
        let morphed =
            json.replace(r#""indices": 2}]"#, r#""indices": 2, "targets": [{"POSITION": 0}]}], "weights": [1]"#);
        let morphed = shown(&morphed);
        assert!((morphed.scene.mesh.bounds().max.x - 2.0 * expected).abs() < 1e-5, "{component}: twice the size");
        assert_eq!(morphed.report.warnings, [""; 0]);
        let plain = json.replace("KHR_mesh_quantization", "KHR_materials_ior");
        assert!(
            import_alone("a.gltf", plain).unwrap_err().to_string().contains("not allowed there"),
            "negative control"
        );
    }
}
