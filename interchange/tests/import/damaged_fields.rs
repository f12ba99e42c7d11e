//! Small files of every kind, each cut short at every place, and with a value of another kind in place of each field.
//! Messages name the file, and for JSON the field.

use super::{
    gltf::Gltf,
    gltf_compressed::{draco, draco_stream, meshopt, views},
    *,
};
use lapidary_core::image::Image;
use serde_json::{Value, json};

/// A scene with an entry in every list that is read.
const SCENE: Gltf = Gltf {
    nodes: r#"[{"name": "n", "mesh": 0, "translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1], "children": [1]},
        {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]"#,
    primitive: r#""indices": 1, "material": 0, "mode": 4"#,
    rest: r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_texture_transform"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "color": [1, 1, 1], "intensity": 3}]}},
        "materials": [{"name": "m", "alphaMode": "MASK", "alphaCutoff": 0.5, "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "roughnessFactor": 0.5,
                "baseColorTexture": {"index": 0, "texCoord": 0,
                    "extensions": {"KHR_texture_transform": {"scale": [2, 2], "rotation": 1}}}},
            "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": 0}}}}],
        "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 10497, "magFilter": 9729}],
        "images": [{"uri": "a.png"}],
        "animations": [{"name": "clip", "channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
            "samplers": [{"input": 0, "output": 0, "interpolation": "LINEAR"}]}]"#,
};

const MATERIAL: &str = r#"{"name": "m", "model": "ggx", "double_sided": true,
    "parameters": {"base_color": [1, 0, 0], "roughness": 0.5, "ior": 1.5},
    "maps": {"base_color": {"file": "a.png", "scale": [2, 2], "offset": [0, 0], "rotation_degrees": 5, "channel": "g"},
        "roughness": {"procedural": {"pattern": "noise", "low": [0, 0, 0], "high": [1, 1, 1], "octaves": 3}},
        "bump": {"file": "a.png", "strength": 0.5, "flip_y": false, "color_space": "linear"}}}"#;

const DOCUMENT: &str = r#"<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <nodegraph name="g">
    <image name="i" type="color3"><input name="file" type="filename" value="a.png" colorspace="srgb_texture"/></image>
    <output name="o" type="color3" nodename="i"/>
  </nodegraph>
  <standard_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="g" output="o"/>
    <input name="specular_roughness" type="float" value="0.25"/>
  </standard_surface>
  <surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="s"/>
  </surfacematerial>
</materialx>
"#;

const LIBRARY: &str = "newmtl m\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 30\nd 0.5\nillum 2\nPr 0.5\nmap_Kd -s 2 2 1 -o 0 0 a.png\n\
    bump -bm 0.5 a.png\nnorm a.png\nKe 0 0 0\n";

const MESH: &str = "mtllib a.mtl\no box\nv 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nv 0 1 0 1\nvt 0 0\nvn 0 0 1\ns 1\nusemtl m\n\
    f 1/1/1 2/1/1 3/1/1 4/1/1\ns off\nf -4 -3 -2\nl 1 2\n";

const POLYGONS: &str = "ply\nformat ascii 1.0\ncomment made by a test\nelement vertex 3\nproperty float x\nproperty double y\n\
    property float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 255\n1 0 0 255\n0 1 0 255\n3 0 1 2\n";

/// A folder with the picture that the others name.
fn folder() -> Files {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    files
}

fn is_material(name: &str) -> bool {
    name.ends_with(".json") || name.ends_with(".mtlx")
}

/// Reads a file of any kind; an error is its message.
fn read(path: &Path) -> Result<(), String> {
    let name = path.file_name().unwrap().to_string_lossy();
    if is_material(&name) {
        let loaded = load_material(path, &mut Scene::default(), &ImportOptions::default());
        return loaded.map(drop).map_err(|error| error.to_string());
    }
    if name.ends_with(".hdr") || name.ends_with(".exr") || name.ends_with(".png") {
        return lapidary_interchange::image::read(path).map(drop).map_err(|error| error.to_string());
    }
    let scene = if name.ends_with(".mtl") { path.with_file_name("a.obj") } else { path.to_owned() };
    import(&scene).map(drop).map_err(|error| error.to_string())
}

/// Checks that a message is one sentence that names the file, and no dump of a parser.
fn check_message(message: &str, name: &str) {
    assert!(message.ends_with(&format!("{name})")), "{message}");
    for part in ["\n", "Error", "Kind", " { ", "Some(", "expected struct", "u32", "f32", "serde"] {
        assert!(!message.contains(part), "{part:?} in {message}");
    }
}

#[test]
fn files_that_are_cut_short_are_read_or_refused_by_name() {
    let files = folder();
    let picture = Image::from_fn([5, 3], |x, y| Vec3::new(x as f32, y as f32, 0.5));
    for name in ["a.hdr", "a.exr"] {
        lapidary_interchange::image::write(&picture, &files.add(name, "")).unwrap();
    }
    let kinds: [(&str, Vec<u8>); 9] = [
        ("a.gltf", SCENE.embedded().into_bytes()),
        ("a.glb", SCENE.binary()),
        ("a.mtl", LIBRARY.into()),
        ("a.obj", MESH.into()),
        ("a.ply", POLYGONS.into()),
        ("m.mtlx", DOCUMENT.into()),
        ("m.json", MATERIAL.into()),
        ("a.hdr", std::fs::read(files.path("a.hdr")).unwrap()),
        ("a.exr", std::fs::read(files.path("a.exr")).unwrap()),
    ];
    for (name, bytes) in &kinds {
        let path = files.add(name, bytes);
        if *name == "a.mtl" {
            files.add("a.obj", MESH);
        }
        assert_eq!(read(&path), Ok(()), "{name}");
        let mut refused = 0;
        for length in 0..bytes.len() {
            files.add(name, &bytes[..length]);
            if let Err(message) = read(&path) {
                check_message(&message, name);
                refused += 1;
            }
        }
        // Cut between its lines, a library or a mesh is a smaller one.
        let most = if name.ends_with(".mtl") || name.ends_with(".obj") { bytes.len() } else { 20 };
        assert!(refused + most >= bytes.len(), "{name}: {refused} of {}", bytes.len());
        files.add(name, bytes);
    }
}

/// The places of all values within a value, as JSON pointers.
fn places(of: &Value, at: &str) -> Vec<String> {
    let inner: Vec<(String, &Value)> = match of {
        Value::Object(fields) => fields.iter().map(|(name, value)| (name.clone(), value)).collect(),
        Value::Array(list) => list.iter().enumerate().map(|(index, value)| (index.to_string(), value)).collect(),
        _ => Vec::new(),
    };
    let below = inner.into_iter().flat_map(|(name, value)| places(value, &format!("{at}/{name}")));
    std::iter::once(at.to_owned()).chain(below).collect()
}

/// Whether two values are of one kind: a number of any size fits where another fits, and may be wrong for the rest of the file.
fn are_alike(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| [value.is_u64(), value.is_f64()];
    std::mem::discriminant(a) == std::mem::discriminant(b) && number(a) == number(b)
}

/// Whether a message names the field or the object at a place, or repeats its value.
fn names_the_field(message: &str, place: &str, value: &Value) -> bool {
    /// The mesh of a scene whose field is ignored.
    const OF_THE_MESH: [&str; 3] = ["the mesh has no triangles", "beyond the limit of 1e9", "below the limit of 1e-6"];
    let message = message.to_ascii_lowercase().replace("buffer view", "bufferview");
    let singular = |word: &str| word.trim_end_matches("es").trim_end_matches('s').to_ascii_lowercase();
    let mut words = place.split('/').filter(|word| !word.is_empty() && word.parse::<usize>().is_err());
    words.any(|word| message.contains(&singular(word)))
        || value.is_string() && message.contains(&value.to_string())
        || OF_THE_MESH.iter().any(|text| message.contains(text))
}

#[test]
fn fields_of_another_kind_are_read_or_refused_by_their_name() {
    let files = folder();
    let wrong = [
        Value::Null,
        json!("text"),
        json!(""),
        json!(7),
        json!(-1),
        json!(0.5),
        json!(1e300),
        json!(u64::MAX),
        json!(true),
        json!([]),
        json!([[1, 2, 3]]),
        json!({}),
        json!({ "a": 1 }),
    ];
    for (name, text) in [
        ("a.gltf", SCENE.embedded()),
        ("meshopt.gltf", meshopt("EXT_meshopt_compression", &views(0))),
        ("draco.gltf", draco(&draco_stream(1))),
        ("m.json", MATERIAL.to_owned()),
    ] {
        let document: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(read(&files.add(name, &text)), Ok(()), "{name}");
        let (mut tried, mut refused, mut unnamed) = (0, 0, Vec::new());
        for place in places(&document, "") {
            for value in &wrong {
                let mut damaged = document.clone();
                *damaged.pointer_mut(&place).unwrap() = value.clone();
                tried += 1;
                let Err(message) = read(&files.add(name, damaged.to_string())) else { continue };
                check_message(&message, name);
                refused += 1;
                // The whole document has no name.
                let is_field = !place.is_empty() && !are_alike(document.pointer(&place).unwrap(), value);
                if is_field && !names_the_field(&message, &place, value) {
                    unnamed.push(format!("{place} = {value}: {message}"));
                }
            }
        }
        assert!(tried > 300 && refused > tried / 3, "{name}: {refused} of {tried}");
        assert!(unnamed.is_empty(), "{} messages name no field:\n{}", unnamed.len(), unnamed.join("\n"));
    }
}
