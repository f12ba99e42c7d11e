//! glTF files with compressed meshes and pictures. The tests compress them.

use super::{
    gltf::{Gltf, QUAD},
    *,
};
use base64::{Engine, engine::general_purpose::STANDARD};
use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
    PointIndex,
};
use meshoptimizer_rs::{
    Workspace,
    codec::{IndexEncoding, VertexEncoding, encode_index_buffer, encode_index_sequence, encode_vertex_buffer},
};

const INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];

/// Corners of all triangles with their texture coordinates, in a sequence that does not depend on that of the file.
fn corners(imported: &Imported) -> Vec<[i32; 5]> {
    let mesh = &imported.scene.mesh;
    let corner = |&vertex: &u32| {
        let (place, uv) = (mesh.positions[vertex as usize], mesh.uvs[vertex as usize]);
        [place.x, place.y, place.z, uv.x, uv.y].map(|x| (x * 1000.0).round() as i32)
    };
    let mut corners: Vec<_> = mesh.triangles.iter().flatten().map(corner).collect();
    corners.sort_unstable();
    corners
}

/// The quad with its buffer, views and attributes replaced.
fn replaced(buffers: &str, changes: &[(&str, &str)]) -> String {
    let mut json = QUAD.json(buffers);
    for (from, to) in changes {
        assert!(json.contains(from), "{from}");
        json = json.replacen(from, to, 1);
    }
    json
}

fn data_buffer(bytes: &[u8]) -> String {
    format!(r#"{{"byteLength": {}, "uri": "data:;base64,{}"}}"#, bytes.len(), STANDARD.encode(bytes))
}

/// A view that meshoptimizer compressed.
pub struct View {
    bytes: Vec<u8>,
    layout: &'static str,
}

fn vertices(bytes: &[u8], stride: usize, version: u8) -> Vec<u8> {
    let encoding = VertexEncoding::new(version, 2).unwrap();
    encode_vertex_buffer(bytes, bytes.len() / stride, stride, encoding, &mut Workspace::default()).unwrap()
}

/// The views of the quad: its positions, indices and texture coordinates.
pub fn views(version: u8) -> [View; 3] {
    let buffer = Gltf::buffer();
    let indices = encode_index_sequence(&INDICES, IndexEncoding::DEFAULT, &mut Workspace::default()).unwrap();
    [
        View {
            bytes: vertices(&buffer[..48], 12, version),
            layout: r#""mode": "ATTRIBUTES", "byteStride": 12, "count": 4"#,
        },
        View { bytes: indices, layout: r#""mode": "INDICES", "byteStride": 2, "count": 6"# },
        View {
            bytes: vertices(&buffer[60..], 8, version),
            layout: r#""mode": "ATTRIBUTES", "byteStride": 8, "count": 4"#,
        },
    ]
}

/// The quad with these views, and with a fallback buffer that is not there.
pub fn meshopt(extension: &str, views: &[View; 3]) -> String {
    let bytes = views.iter().map(|view| view.bytes.as_slice()).collect::<Vec<_>>().concat();
    let buffers = format!(
        r#"{}, {{"byteLength": 92, "extensions": {{"{extension}": {{"fallback": true}}}}}}"#,
        data_buffer(&bytes)
    );
    let mut at = 0;
    let mut compressed = |view: &View, rest: &str| {
        let (offset, length) = (at, view.bytes.len());
        at += length;
        format!(
            r#"{{"buffer": 1, {rest}, "extensions": {{"{extension}":
                {{"buffer": 0, "byteOffset": {offset}, "byteLength": {length}, {}}}}}}}"#,
            view.layout
        )
    };
    let [positions, indices, uvs] = views;
    let [positions, indices, uvs] = [
        compressed(positions, r#""byteLength": 48"#),
        compressed(indices, r#""byteOffset": 48, "byteLength": 12"#),
        compressed(uvs, r#""byteOffset": 60, "byteLength": 32"#),
    ];
    replaced(
        &buffers,
        &[
            (r#"{"buffer": 0, "byteLength": 48}"#, &positions),
            (r#"{"buffer": 0, "byteOffset": 48, "byteLength": 12}"#, &indices),
            (r#"{"buffer": 0, "byteOffset": 60, "byteLength": 32}"#, &uvs),
            (r#""meshes": [{"#, r#""meshes": [{"name": "Sign", "#),
            (
                r#""scene": 0"#,
                &format!(r#""extensionsUsed": ["{extension}"], "extensionsRequired": ["{extension}"], "scene": 0"#),
            ),
        ],
    )
}

#[test]
fn views_that_meshoptimizer_compressed_are_those_before() {
    let plain = import_alone("a.gltf", QUAD.embedded()).unwrap();
    for (extension, version) in [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 1)] {
        let imported = import_alone("a.gltf", meshopt(extension, &views(version))).unwrap();
        assert_eq!((&imported.scene.mesh, &imported.report), (&plain.scene.mesh, &plain.report), "{extension}");
    }
    let mut triangles = views(0);
    triangles[1] = View {
        bytes: encode_index_buffer(&INDICES, IndexEncoding::DEFAULT, &mut Workspace::default()).unwrap(),
        layout: r#""mode": "TRIANGLES", "byteStride": 2, "count": 6"#,
    };
    let imported = import_alone("a.gltf", meshopt("EXT_meshopt_compression", &triangles)).unwrap();
    assert_eq!(corners(&imported), corners(&plain));
    assert!((0..2).all(|t| imported.scene.mesh.area_vector(t) == Vec3::Z));
}

#[test]
fn filters_of_meshoptimizer_are_undone() {
    // Words of the filter EXPONENTIAL are a mantissa of 24 bits and a power of two: 3 * 2^-2 is 0.75.
    let word = |x: f32| if x == 0.0 { 0 } else { 3 | 0xfe << 24 };
    let positions = [[0f32, 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| [word(x), word(y), 0u32]);
    let bytes: Vec<u8> = positions.iter().flatten().flat_map(|word| word.to_le_bytes()).collect();
    let mut filtered = views(0);
    filtered[0] = View {
        bytes: vertices(&bytes, 12, 0),
        layout: r#""mode": "ATTRIBUTES", "filter": "EXPONENTIAL", "byteStride": 12, "count": 4"#,
    };
    let json = meshopt("EXT_meshopt_compression", &filtered);
    let bounds = import_alone("a.gltf", &json).unwrap().scene.mesh.bounds();
    assert_eq!((bounds.min, bounds.max), (Vec3::ZERO, Vec3::new(0.75, 0.75, 0.0)));
    assert!(
        import_alone("a.gltf", json.replace("EXPONENTIAL", "NONE")).is_err(),
        "negative control: words are no floats"
    );
}

/// An attribute of the four vertices.
fn attribute(kind: GeometryAttributeType, components: u8, of: DataType, bytes: &[u8]) -> PointAttribute {
    let is_normalized = kind == GeometryAttributeType::Color;
    let mut attribute = PointAttribute::new();
    attribute.init(kind, components, of, is_normalized, 4);
    attribute.buffer_mut().write(0, bytes);
    attribute
}

/// The quad as a Draco mesh: its positions have the number 0, its texture coordinates 1.
pub fn draco_stream(method: i32) -> Vec<u8> {
    draco_stream_with(method, [])
}

/// The quad with further attributes, which have the numbers from 2 on.
fn draco_stream_with(method: i32, more: impl IntoIterator<Item = PointAttribute>) -> Vec<u8> {
    let buffer = Gltf::buffer();
    let mut mesh = Mesh::new();
    mesh.set_num_points(4);
    mesh.add_attribute(attribute(GeometryAttributeType::Position, 3, DataType::Float32, &buffer[..48]));
    mesh.add_attribute(attribute(GeometryAttributeType::TexCoord, 2, DataType::Float32, &buffer[60..]));
    for attribute in more {
        mesh.add_attribute(attribute);
    }
    mesh.set_num_faces(2);
    for (face, corners) in INDICES.as_chunks::<3>().0.iter().enumerate() {
        mesh.set_face(FaceIndex(face as u32), corners.map(PointIndex));
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut options = EncoderOptions::new();
    options.set_encoding_method(method);
    options.set_attribute_quantization(0, 14);
    options.set_attribute_quantization(1, 12);
    let mut stream = EncoderBuffer::new();
    encoder.encode(&options, &mut stream).unwrap();
    stream.data().to_vec()
}

/// The quad with a Draco stream, and accessors without data.
pub fn draco(stream: &[u8]) -> String {
    let view = format!(r#"{{"buffer": 0, "byteLength": {}}}"#, stream.len());
    let extension = "KHR_draco_mesh_compression";
    replaced(
        &data_buffer(stream),
        &[
            (r#"{"buffer": 0, "byteLength": 48}"#, &view),
            (r#", {"buffer": 0, "byteOffset": 48, "byteLength": 12}"#, ""),
            (r#"{"buffer": 0, "byteOffset": 60, "byteLength": 32}"#, &view),
            (r#"{"bufferView": 0, "componentType": 5126"#, r#"{"componentType": 5126"#),
            (r#"{"bufferView": 1, "componentType": 5123"#, r#"{"componentType": 5123"#),
            (r#"{"bufferView": 2, "componentType": 5126"#, r#"{"componentType": 5126"#),
            (
                r#""indices": 1"#,
                &format!(
                    r#""indices": 1, "extensions": {{"{extension}": {{"bufferView": 0,
                        "attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}}}}}"#
                ),
            ),
            (r#""meshes": [{"#, r#""meshes": [{"name": "Sign", "#),
            (r#""scene": 0"#, &format!(r#""extensionsRequired": ["{extension}"], "scene": 0"#)),
        ],
    )
}

#[test]
fn meshes_that_draco_compressed_are_those_before() {
    let plain = import_alone("a.gltf", QUAD.embedded()).unwrap();
    for method in [0, 1] {
        let json = draco(&draco_stream(method));
        let imported = import_alone("a.gltf", &json).unwrap();
        check_valid(&imported);
        assert_eq!(corners(&imported), corners(&plain), "method {method}");
        assert!((0..2).all(|t| imported.scene.mesh.area_vector(t) == Vec3::Z));
        assert_eq!(imported.report.warnings, [""; 0]);
        let swapped = json.replace(r#""POSITION": 0, "TEXCOORD_0": 1}}"#, r#""POSITION": 1, "TEXCOORD_0": 0}}"#);
        assert!(corners(&import_alone("a.gltf", swapped).unwrap()) != corners(&plain), "negative control");
    }
}

#[test]
fn integers_that_draco_compressed_are_those_before() {
    let colors = [[255u8, 0, 0, 255], [0, 51, 0, 255], [0, 0, 102, 255], [255, 255, 255, 255]];
    // Joints with numbers of more than a byte.
    let joints = [[299u16, 0, 0, 0], [299, 0, 0, 0], [43, 0, 0, 0], [43, 0, 0, 0]];
    let joints: Vec<u8> = joints.iter().flatten().flat_map(|joint| joint.to_le_bytes()).collect();
    let more = |joints: &[u8]| {
        [
            attribute(GeometryAttributeType::Color, 4, DataType::Uint8, colors.as_flattened()),
            attribute(GeometryAttributeType::Generic, 4, DataType::Uint16, joints),
            attribute(GeometryAttributeType::Generic, 4, DataType::Uint8, [[255u8, 0, 0, 0]; 4].as_flattened()),
        ]
    };
    let nodes = format!(r#""nodes": [{{"mesh": 0, "skin": 0}}{}, {{"translation": [0, 0, 5]}}]"#, ", {}".repeat(299));
    let numbers: Vec<String> = (1..=300).map(|joint| joint.to_string()).collect();
    let skins = format!(r#""skins": [{{"joints": [{}]}}], "asset""#, numbers.join(", "));
    let scene = |stream: &[u8]| {
        draco(stream)
            .replace(r#""nodes": [{"mesh": 0}]"#, &nodes)
            .replace(r#""asset""#, &skins)
            .replace(r#""TEXCOORD_0": 2}"#, r#""TEXCOORD_0": 2, "COLOR_0": 3, "JOINTS_0": 4, "WEIGHTS_0": 5}"#)
            .replace(r#""TEXCOORD_0": 1}"#, r#""TEXCOORD_0": 1, "COLOR_0": 2, "JOINTS_0": 3, "WEIGHTS_0": 4}"#)
            .replace(
                r#""type": "VEC2"}]"#,
                r#""type": "VEC2"}, {"componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"},
                {"componentType": 5123, "count": 4, "type": "VEC4"},
                {"componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"}]"#,
            )
    };
    for method in [0, 1] {
        let imported = import_alone("a.gltf", scene(&draco_stream_with(method, more(&joints)))).unwrap();
        assert_eq!(imported.report.warnings, [""; 0]);
        let mesh = &imported.scene.mesh;
        let found = |place: Vec3| mesh.positions.iter().position(|found| found.distance(place) < 1e-3);
        for (place, color) in [
            (Vec3::new(0.0, 0.0, 5.0), Vec3::X),
            (Vec3::new(1.0, 0.0, 5.0), Vec3::Y * 0.2),
            (Vec3::new(1.0, 1.0, 0.0), Vec3::Z * 0.4),
            (Vec3::new(0.0, 1.0, 0.0), Vec3::ONE),
        ] {
            let vertex = found(place).unwrap_or_else(|| panic!("{place} in {:?}", mesh.positions));
            assert!(mesh.colors[vertex].distance(color) < 1e-6, "{place}: {}", mesh.colors[vertex]);
        }
        let resting = import_alone("a.gltf", scene(&draco_stream_with(method, more(&[0; 32])))).unwrap();
        assert_eq!(resting.scene.mesh.bounds().max.z, 0.0, "negative control");
    }
}

#[test]
fn damaged_compression_names_the_file_and_the_mesh() {
    let stream = draco_stream(1);
    let cut = |json: &str, from: &str, to: &str| {
        assert!(json.contains(from), "{from}");
        import_alone("a.gltf", json.replacen(from, to, 1))
            .err()
            .map_or_else(|| format!("read with {to}"), |e| e.to_string())
    };
    let (packed, mesh) = (meshopt("EXT_meshopt_compression", &views(0)), draco(&stream));
    let many: Vec<String> = (0..33).map(|i| format!(r#""COLOR_{i}": {i}"#)).collect();
    let many = format!("{}}}}}", many.join(", "));
    let length = format!(r#""byteOffset": 0, "byteLength": {}"#, views(0)[0].bytes.len());
    for (json, from, to, reason) in [
        (&packed, r#""count": 4"#, r#""count": 400"#, "are damaged"),
        (&packed, &length, r#""byteOffset": 0, "byteLength": 9"#, "are damaged"),
        (&packed, &length, r#""byteOffset": 9, "byteLength": 999"#, "end past buffer 0"),
        (
            &packed,
            r#""mode": "ATTRIBUTES","#,
            "",
            "cannot be found: in EXT_meshopt_compression, it lacks the field \"mode\"",
        ),
        (&packed, r#""byteStride": 12"#, r#""byteStride": "x""#, "\"byteStride\" is \"x\", where a whole number"),
        (&packed, "ATTRIBUTES", "MAGIC", "in the mode \"MAGIC\", which is not known"),
        (&packed, r#""mode": "ATT"#, r#""filter": "MAGIC", "mode": "ATT"#, "are damaged"),
        (&mesh, r#""count": 4"#, r#""count": 5"#, "has 4 vertices in its compressed data, and 5 in the file"),
        (&mesh, r#""count": 6"#, r#""count": 3"#, "are damaged"),
        (&mesh, r#""count": 6"#, r#""count": 9"#, "has 6 corners of triangles"),
        (&mesh, r#""indices": 1,"#, "", "has no indices"),
        (&mesh, r#""TEXCOORD_0": 1}}"#, r#""TEXCOORD_0": 7}}"#, "are damaged"),
        (&mesh, r#""bufferView": 0"#, r#""bufferView": 9"#, "cannot be found: bufferViews[9] is not there"),
        (&mesh, r#""TEXCOORD_0": 1}}"#, &many, "has 34 compressed attributes, more than the limit of 32"),
    ] {
        let message = cut(json, from, to);
        assert!(message.contains(reason) && message.contains("the mesh \"Sign\""), "{to}: {message}");
        assert!(message.ends_with("a.gltf)"), "{message}");
    }
}

#[test]
fn compressed_meshes_count_against_the_memory() {
    let files = Files::new();
    let json = meshopt("EXT_meshopt_compression", &views(0));
    let options = ImportOptions { budget: Some(10_000_000), ..Default::default() };
    let of = |json: String| import_with(&files.add("a.gltf", json), &options).map(|imported| imported.report);
    let many = json.replacen(r#""byteStride": 12, "count": 4"#, r#""byteStride": 12, "count": 4000000"#, 1);
    assert!(matches!(of(many), Err(ImportError::Memory { needed: 48.., available: 10, .. })));
    let draco = draco(&draco_stream(1));
    let many = draco.replacen(r#""count": 6"#, r#""count": 9000000"#, 1);
    assert!(matches!(of(many), Err(ImportError::Memory { needed: 18.., available: 10, .. })));
    assert!(of(json).is_ok() && of(draco).is_ok(), "negative control");
}

#[test]
fn compressed_files_cut_or_changed_anywhere_never_panic() {
    let files = Files::new();
    let random = &mut fastrand::Rng::with_seed(3);
    let streams = [draco_stream(0), draco_stream(1)];
    let whole = views(1);
    let options = ImportOptions { budget: Some(100_000_000), ..Default::default() };
    let mut damage = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        for _ in 0..random.usize(1..4) {
            let at = random.usize(..bytes.len());
            bytes[at] = random.u8(..);
        }
        if random.bool() {
            bytes.truncate(random.usize(..bytes.len()));
        }
        bytes
    };
    for round in 0..1500 {
        let view = |k: usize, damage: &mut dyn FnMut(&[u8]) -> Vec<u8>| View {
            bytes: if round % 3 == k { damage(&whole[k].bytes) } else { whole[k].bytes.clone() },
            layout: whole[k].layout,
        };
        let views = [view(0, &mut damage), view(1, &mut damage), view(2, &mut damage)];
        for json in [meshopt("KHR_meshopt_compression", &views), draco(&damage(&streams[round % 2]))] {
            match import_with(&files.add("a.gltf", json), &options) {
                Ok(imported) => {
                    imported.scene.mesh.validate(imported.scene.materials.len(), imported.scene.objects.len()).unwrap();
                }
                Err(error) => assert!(error.to_string().ends_with("a.gltf)"), "{error}"),
            }
        }
    }
}

/// The quad with textures, whose images are `a.png`, `b.webp` and `gone.ktx2`, and a material with the first texture.
fn with_textures(files: &Files, textures: &str) -> Imported {
    let rest = format!(
        r#", "images": [{{"uri": "a.png"}}, {{"uri": "b.webp"}}, {{"uri": "gone.ktx2"}}], "textures": [{textures}],
        "materials": [{{"name": "m", "pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}},
            "emissiveTexture": {{"index": 0}}}}]"#
    );
    let scene = Gltf { primitive: r#""indices": 1, "material": 0"#, rest: Box::leak(rest.into_boxed_str()), ..QUAD };
    import(&files.add("a.gltf", scene.embedded())).unwrap()
}

#[test]
fn the_own_picture_of_a_texture_is_shown_where_its_first_cannot_be_read() {
    let files = Files::new();
    files.add_png("a.png", [0.25; 3]);
    files.add("b.webp", b"\xabKTX 20\xbb\r\n\x1a\n and no more");
    for (extension, source, name, reason) in [
        ("EXT_texture_webp", 2, "gone.ktx2", "there is no such file beside it"),
        ("KHR_texture_basisu", 1, "b.webp", ""),
    ] {
        let first = format!(r#""extensions": {{"{extension}": {{"source": {source}}}}}"#);
        let imported = with_textures(&files, &format!(r#"{{"source": 0, {first}}}"#));
        let shown = &imported.scene.textures;
        assert!(shown.len() == 1 && shown[0].size == [2, 2] && shown[0].name == "a.png", "{name}");
        let told = &imported.report.warnings;
        let expected = format!("the texture \"{name}\" cannot be read: {reason}");
        assert!(told.len() == 1 && told[0].starts_with(&expected), "once: {told:?}");
        assert!(told[0].ends_with("\"a.png\" is shown, which the file has for other programs"), "{told:?}");
        assert_eq!(imported.report.unread, [""; 0]);
        for textures in [format!("{{{first}}}"), format!(r#"{{"source": 2, {first}}}"#)] {
            let missing = with_textures(&files, &textures);
            let told = &missing.report.warnings;
            assert!(told.len() == 1 && told[0].contains("magenta") && told[0].contains(name), "control: {told:?}");
        }
    }
}

#[test]
fn pictures_in_extensions_come_before_those_for_other_programs() {
    let with = |texture: &str| {
        let files = Files::new();
        files.add_png("a.png", [0.25; 3]);
        let mut webp = std::io::Cursor::new(Vec::new());
        let pixels = image::RgbImage::from_pixel(3, 1, image::Rgb([9, 8, 7]));
        pixels.write_to(&mut webp, image::ImageFormat::WebP).unwrap();
        files.add("b.webp", webp.into_inner());
        let imported = with_textures(&files, texture);
        assert_eq!(imported.report.warnings, [""; 0]);
        imported.scene.textures[0].size
    };
    assert_eq!(with(r#"{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}"#), [3, 1]);
    assert_eq!(with(r#"{"source": 0, "extensions": {"KHR_texture_basisu": {"source": 1}}}"#), [3, 1]);
    assert_eq!(with(r#"{"source": 0, "extensions": {"MSFT_texture_dds": {"source": 1}}}"#), [2, 2], "not read");
    assert_eq!(with(r#"{"source": 0}"#), [2, 2], "negative control");
}
