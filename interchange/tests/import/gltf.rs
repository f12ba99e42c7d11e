//! glTF files made by hand in the tests.

use super::*;
use lapidary_core::brdf::{BrdfModel, GgxParameters, OpenPbrParameters};

/// A quad as glTF: positions, and the rest of its JSON from `parts` of the form `"key": value`.
pub struct Gltf {
    pub nodes: &'static str,
    pub primitive: &'static str,
    pub rest: &'static str,
}

pub const QUAD: Gltf = Gltf { nodes: r#"[{"mesh": 0}]"#, primitive: r#""indices": 1"#, rest: "" };

impl Gltf {
    /// Four positions of the unit square in xy, then six `u16` indices, then four texture coordinates.
    pub fn buffer() -> Vec<u8> {
        let positions = [[0f32, 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        let uvs = [[0f32, 1.], [1., 1.], [1., 0.], [0., 0.]];
        let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
        bytes.extend(uvs.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    pub fn json(&self, buffer: &str) -> String {
        let Self { nodes, primitive, rest } = self;
        let separator = if primitive.is_empty() { "" } else { "," };
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": {nodes},
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 2}} {separator} {primitive}}}]}}],
            "buffers": [{buffer}],
            "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 12}},
                {{"buffer": 0, "byteOffset": 60, "byteLength": 32}}],
            "accessors": [
                {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
                {{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}},
                {{"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}}] {rest} }}"#
        )
    }

    pub fn embedded(&self) -> String {
        use base64::Engine;
        let data = base64::engine::general_purpose::STANDARD.encode(Self::buffer());
        self.json(&format!(r#"{{"byteLength": 92, "uri": "data:application/octet-stream;base64,{data}"}}"#))
    }

    pub fn binary(&self) -> Vec<u8> {
        let mut json = self.json(r#"{"byteLength": 92}"#).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        let total = 12 + 8 + json.len() + 8 + 92;
        glb.extend((total as u32).to_le_bytes());
        glb.extend((json.len() as u32).to_le_bytes());
        glb.extend(b"JSON");
        glb.extend(json);
        glb.extend(92u32.to_le_bytes());
        glb.extend(b"BIN\0");
        glb.extend(Self::buffer());
        glb
    }
}

#[test]
fn gltf_buffers_may_be_embedded_external_or_binary() {
    let files = Files::new();
    files.add("data files/quad.bin", Gltf::buffer());
    let external = QUAD.json(r#"{"byteLength": 92, "uri": "data%20files/quad.bin"}"#);
    let a = import(&files.add("a.gltf", external)).unwrap();
    let b = import(&files.add("b.gltf", QUAD.embedded())).unwrap();
    let c = import(&files.add("c.glb", QUAD.binary())).unwrap();
    check_valid(&a);
    assert_eq!((a.report.vertices, a.report.triangles, a.report.uvs_projected), (4, 2, 0));
    assert_eq!(a.scene.mesh, b.scene.mesh);
    assert_eq!(a.scene.mesh, c.scene.mesh);
    assert!(a.scene.mesh.normals.iter().all(|n| *n == Vec3::Z));
}

#[test]
fn gltf_transforms_apply_down_the_hierarchy_and_mirrors_keep_the_outside_out() {
    let moved = Gltf {
        nodes: r#"[{"translation": [0, 0, 5], "children": [1, 2]}, {"mesh": 0, "scale": [2, 2, 2]},
            {"mesh": 0, "name": "mirror", "scale": [-1, 1, 1]}]"#,
        ..QUAD
    };
    let imported = import_alone("a.gltf", moved.embedded()).unwrap();
    check_valid(&imported);
    let mesh = &imported.scene.mesh;
    assert_eq!(imported.scene.objects[1].name, "mirror");
    let bounds = mesh.bounds();
    assert_eq!((bounds.min, bounds.max), (Vec3::new(-1.0, 0.0, 5.0), Vec3::new(2.0, 2.0, 5.0)));
    assert!((0..4).all(|t| mesh.area_vector(t).z > 0.0));
    let handedness = |object: u32| {
        let t = mesh.triangle_object.iter().position(|o| *o == object).unwrap();
        mesh.tangents[mesh.triangles[t][0] as usize]
    };
    assert_eq!((handedness(0).w, handedness(1).w), (1.0, -1.0));
    assert!(handedness(1).x < -0.999);
}

#[test]
fn gltf_strips_fans_and_missing_indices_make_the_same_surface() {
    let area = |primitive| {
        let mesh = import_alone("a.gltf", Gltf { primitive, ..QUAD }.embedded()).unwrap().scene.mesh;
        (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).z).sum::<f32>()
    };
    assert_eq!(area(r#""indices": 1"#), 1.0);
    assert_eq!(area(r#""mode": 6"#), 1.0);
    // As a strip the second triangle is 1, 3, 2: it overlaps the first and faces away.
    assert_eq!(area(r#""mode": 5"#), 0.5 - 0.5);
    assert_eq!(area(""), 0.5);
    let lines = import_alone("a.gltf", Gltf { primitive: r#""mode": 1"#, ..QUAD }.embedded()).unwrap_err();
    assert!(matches!(lines, ImportError::Mesh { source: MeshError::Empty, .. }));
}

#[test]
fn gltf_materials_and_cameras_are_read() {
    let scene = Gltf {
        nodes: r#"[{"mesh": 0, "children": [1]}, {"camera": 0, "name": "view", "translation": [0.5, 0.5, 4]}]"#,
        primitive: r#""indices": 1, "material": 0"#,
        rest: r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
            "extensionsUsed": ["KHR_texture_transform", "KHR_materials_ior", "KHR_materials_iridescence"],
            "images": [{"uri": "a.png"}, {"uri": "gone.png"}], "textures": [{"source": 0}, {"source": 1}],
            "materials": [{"name": "m", "doubleSided": true, "alphaMode": "MASK",
                "extensions": {"KHR_materials_ior": {"ior": 1.33}},
                "normalTexture": {"index": 1, "scale": 0.5, "texCoord": 1,
                    "extensions": {"KHR_texture_transform": {"scale": [3, 4], "offset": [0.25, 0]}}},
                "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1], "roughnessFactor": 0.4, "metallicFactor": 0.6,
                    "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"rotation": 0.5}}},
                    "metallicRoughnessTexture": {"index": 0}}}]"#,
    };
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let imported = import(&files.add("a.gltf", scene.embedded())).unwrap();
    check_valid(&imported);
    let material = &imported.scene.materials[0];
    let p = GgxParameters::from(&material.parameters);
    assert_eq!((p.base_color, p.roughness, p.metalness, p.ior), (Vec3::new(0.1, 0.2, 0.3), 0.4, 0.6, 1.33));
    assert!(material.double_sided);
    assert_eq!(material.parameters.number("opacity_cutoff"), 0.5);
    assert!(material.maps.get("geometry_opacity").is_none(), "its texture has no alpha");
    let maps = &material.maps;
    let base = maps.get("base_color").unwrap();
    assert_eq!((base.color_space, base.rotation, base.texture), (ColorSpace::Srgb, 0.5, 0));
    let (rough, metal) = (maps.get("roughness").unwrap(), maps.get("metalness").unwrap());
    assert_eq!((rough.channel, metal.channel, rough.color_space), (Channel::G, Channel::B, ColorSpace::Linear));
    let normal = maps.get("normal").unwrap();
    assert_eq!((normal.strength, normal.scale, normal.offset), (0.5, Vec2::new(3.0, 4.0), Vec2::new(0.25, 0.0)));
    assert_eq!([base.uv_set, normal.uv_set], [UvSet::First, UvSet::Second]);
    let camera = &imported.scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.eye, camera.fov_y), ("view", Vec3::new(0.5, 0.5, 4.0), 0.7));
    assert!((camera.target - Vec3::new(0.5, 0.5, 0.0)).length() < 1e-5);
    let warnings = imported.report.warnings.join("\n");
    for part in ["\"gone.png\" was replaced", "\"KHR_materials_iridescence\" are"] {
        assert!(warnings.contains(part), "{part} is not in {warnings}");
    }
    assert_eq!(imported.report.warnings.len(), 2, "{warnings}");
}

#[test]
fn gltf_pictures_may_be_called_like_layers() {
    use base64::Engine;
    let png = lapidary_interchange::image::encode_png(&lapidary_core::image::Image::filled([1, 1], Vec3::Y));
    let data = base64::engine::general_purpose::STANDARD.encode(png);
    let rest = format!(
        r#", "images": [{{"name": "x.exr#1", "uri": "data:image/png;base64,{data}"}}], "textures": [{{"source": 0}}],
           "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}]"#
    );
    let file = Gltf { rest: Box::leak(rest.into_boxed_str()), primitive: r#""indices": 1, "material": 0"#, ..QUAD };
    let imported = import_alone("a.gltf", file.embedded()).unwrap();
    assert!(imported.report.unread.is_empty(), "{:?}", imported.report.unread);
    assert_eq!(imported.scene.textures[0].texel(0, 0, ColorSpace::Srgb).truncate(), Vec3::Y);
}

#[test]
fn gltf_coats_and_sheen_become_openpbr_and_bad_textures_are_told() {
    let file = |texture: u32| {
        Gltf {
        primitive: r#""indices": 1, "material": 0"#,
        rest: Box::leak(
            format!(
                r#", "extensionsUsed": ["KHR_materials_clearcoat", "KHR_materials_sheen"],
            "extensionsRequired": ["KHR_materials_clearcoat"],
            "images": [{{"uri": "a.png"}}], "textures": [{{"source": 0}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [0.1, 0.2, 0.3, 1], "roughnessFactor": 0.4}},
                "extensions": {{"KHR_materials_sheen": {{"sheenColorFactor": [0.5, 0.4, 0.3], "sheenRoughnessFactor": 0.6}},
                    "KHR_materials_clearcoat": {{"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.2,
                    "clearcoatTexture": {{"index": {texture}, "extensions": {{"KHR_texture_transform": {{"scale": [3, 4]}}}}}}}}}}}}]"#
            )
            .into_boxed_str(),
        ),
        ..QUAD
    }
    };
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let imported = import(&files.add("a.gltf", file(0).embedded())).unwrap();
    assert_eq!(imported.report.warnings, Vec::<String>::new());
    let material = &imported.scene.materials[0];
    let p = OpenPbrParameters::from(&material.parameters);
    assert_eq!(material.model, BrdfModel::OpenPbr);
    assert_eq!((p.base_color, p.specular_roughness, p.base_metalness), (Vec3::new(0.1, 0.2, 0.3), 0.4, 1.0));
    assert_eq!((p.coat_weight, p.coat_roughness, p.coat_darkening), (0.7, 0.2, 0.0));
    assert_eq!((p.fuzz_weight, p.fuzz_color), (1.0, Vec3::new(0.5, 0.4, 0.3)));
    assert!((p.fuzz_roughness - 0.36).abs() < 1e-6);
    assert_eq!(material.maps.get("coat_weight").unwrap().scale, Vec2::new(3.0, 4.0));
    let refused = import(&files.add("b.gltf", file(9).embedded())).unwrap_err().to_string();
    assert!(refused.contains("b.gltf") && refused.contains("texture 9"), "{refused}");
}

#[test]
fn gltf_lights_are_read_as_they_stand_and_bad_ones_left_out_aloud() {
    let scene = Gltf {
        nodes: r#"[{"mesh": 0, "children": [1, 2, 4, 5, 6, 7, 8, 9]}, {"name": "sun", "rotation": [-0.70710678, 0, 0, 0.70710678],
                "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"translation": [0, 0, 3], "scale": [2, 2, 2], "children": [3]},
            {"translation": [0.25, 0.5, 0.5], "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"name": "lamp", "translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 2}}},
            {"name": "gone", "extensions": {"KHR_lights_punctual": {"light": 9}}},
            {"name": "odd", "extensions": {"KHR_lights_punctual": {"light": 3}}},
            {"name": "wide", "extensions": {"KHR_lights_punctual": {"light": 4}}},
            {"name": "text", "extensions": {"KHR_lights_punctual": {"light": 5}}},
            {"name": "minus", "extensions": {"KHR_lights_punctual": {"light": 6}}}]"#,
        rest: r#", "extensionsUsed": ["KHR_lights_punctual"], "extensionsRequired": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [
                {"type": "directional", "intensity": 2, "color": [1, 0.5, 0.25]},
                {"type": "spot", "name": "key", "intensity": 10, "range": 4,
                    "spot": {"innerConeAngle": 0.3, "outerConeAngle": 0.5}},
                {"type": "point"}, {"type": "laser"}, {"type": "spot", "spot": {"outerConeAngle": 2}},
                {"type": "point", "intensity": "much"}, {"type": "point", "intensity": -1}]}}"#,
        ..QUAD
    };
    let imported = import_alone("a.gltf", scene.embedded()).unwrap();
    let lights = &imported.scene.lights;
    assert_eq!(lights.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["sun", "key", "lamp"]);
    assert_eq!(lights[0].intensity, Vec3::new(2.0, 1.0, 0.5));
    assert!((lights[0].forward().unwrap() - Vec3::NEG_Y).length() < 1e-5, "{:?}", lights[0]);
    assert_eq!((lights[1].position, lights[1].intensity), (Vec3::new(0.5, 1.0, 4.0), Vec3::splat(10.0)));
    assert!((lights[1].target - Vec3::new(0.5, 1.0, 0.0)).length() < 1e-5, "at the depth of the scene");
    let Emission::Spot { cone_degrees, penumbra_degrees } = lights[1].emission else { panic!("{:?}", lights[1]) };
    assert!(
        (cone_degrees - 0.5_f32.to_degrees()).abs() < 1e-4 && (penumbra_degrees - 0.2_f32.to_degrees()).abs() < 1e-4
    );
    assert_eq!((lights[2].emission, lights[2].position), (Emission::Point, Vec3::new(1.0, 2.0, 3.0)));
    let warnings = imported.report.warnings.join("\n");
    for part in [
        "\"gone\"",
        "\"odd\" was left out",
        "\"laser\"",
        "\"wide\"",
        "\"text\"",
        "negative",
        "\"key\" have ends of light",
    ] {
        assert!(warnings.contains(part), "{part} is not in {warnings}");
    }
    assert_eq!(imported.report.warnings.len(), 6, "{warnings}");
    assert!(import_alone("a.gltf", QUAD.embedded()).unwrap().scene.lights.is_empty());
}

#[test]
fn gltf_that_reaches_outside_its_data_is_an_error() {
    let good = QUAD.embedded();
    assert!(import_alone("a.gltf", &good).is_ok());
    for (from, to) in [
        (r#""count": 4, "type": "VEC3""#, r#""count": 5, "type": "VEC3""#),
        (r#""count": 4, "type": "VEC3""#, r#""count": 0, "type": "VEC3""#),
        (r#""count": 4, "type": "VEC3""#, r#""count": 18446744073709551615, "type": "VEC3""#),
        (r#""byteLength": 48"#, r#""byteLength": 4800"#),
        (r#""byteOffset": 48"#, r#""byteOffset": 18446744073709551615"#),
        (r#""byteLength": 92"#, r#""byteLength": 9200"#),
        (
            r#""componentType": 5126, "count": 4, "type": "VEC3""#,
            r#""componentType": 5123, "count": 4, "type": "VEC3""#,
        ),
        (r#""type": "SCALAR""#, r#""type": "VEC2""#),
        (r#""POSITION": 0"#, r#""POSITION": 7"#),
        (r#""POSITION": 0"#, r#""NORMAL": 0"#),
        (r#""indices": 1"#, r#""indices": 0"#),
        (r#"{"mesh": 0}"#, r#"{"mesh": 3}"#),
        (r#"base64,"#, r#"base64,!"#),
        (r#""version": "2.0"}"#, r#""version": "2.0"}, "extensionsRequired": ["EXT_mesh_gpu_instancing"]"#),
    ] {
        assert!(good.contains(from), "{from}");
        let error = import_alone("a.gltf", good.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().ends_with("a.gltf)"), "{to}: {error}");
    }
    let missing = import_alone("a.gltf", QUAD.json(r#"{"byteLength": 92, "uri": "gone.bin"}"#)).unwrap_err();
    assert!(missing.to_string().contains("gone.bin"), "{missing}");
    let cycle = Gltf { nodes: r#"[{"mesh": 0, "children": [0]}]"#, ..QUAD };
    assert_eq!(import_alone("a.gltf", cycle.embedded()).unwrap().report.triangles, 2);
    let mut buffer_with_bad_index = QUAD.binary();
    let at = buffer_with_bad_index.len() - 92 + 48;
    buffer_with_bad_index[at] = 9;
    let error = import_alone("a.glb", buffer_with_bad_index).unwrap_err();
    assert!(matches!(error, ImportError::Mesh { source: MeshError::Index { index: 9, count: 4, .. }, .. }), "{error}");
}

#[test]
fn gltf_sparse_accessors_replace_their_values() {
    let json = QUAD.embedded().replacen(
        r#""min": [0, 0, 0], "max": [1, 1, 0]"#,
        r#""min": [0, 0, 0], "max": [1, 1, 0], "sparse": {"count": 1,
            "indices": {"bufferView": 1, "byteOffset": 4, "componentType": 5123}, "values": {"bufferView": 0, "byteOffset": 12}}"#,
        1,
    );
    let imported = import_alone("a.gltf", &json).unwrap();
    // Vertex 2 moved onto vertex 1, so that one triangle has no area and the other is half the square.
    assert_eq!((imported.report.degenerate_triangles, imported.report.triangles), (1, 1));
    assert_eq!(imported.scene.mesh.area_vector(0), Vec3::Z);
    for (from, to) in
        [(r#""sparse": {"count": 1"#, r#""sparse": {"count": 900"#), (r#""byteOffset": 4,"#, r#""byteOffset": 11,"#)]
    {
        assert!(import_alone("a.gltf", json.replacen(from, to, 1)).is_err(), "{to}");
    }
}
