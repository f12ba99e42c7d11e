//! Files that need more memory than an import may take are refused before allocation, with both numbers.

use super::{gltf::QUAD, *};
use lapidary_core::image::Image;
use lapidary_interchange::image::encode_png;

const MEGABYTE: u64 = 1_000_000;

fn within(budget: u64, path: &Path) -> Result<Imported, ImportError> {
    import_with(path, &ImportOptions { budget: Some(budget), ..Default::default() })
}

/// Checks that an import is refused by its budget of 10 MB, with a message.
fn check_refused(path: &Path) {
    let error = within(10 * MEGABYTE, path).map(|imported| imported.report).unwrap_err();
    assert!(matches!(error, ImportError::Memory { needed: 11.., available: 10, .. }), "{error}");
    let message = error.to_string();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    assert!(message.contains("MB of memory") && message.contains("10 MB are free"), "{message}");
    assert!(message.ends_with(&format!("{name})")), "{message}");
}

#[test]
fn a_sparse_accessor_without_a_view_is_counted() {
    let files = Files::new();
    let sparse = r#"{"componentType": 5126, "count": 90000000, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0],
        "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}}"#;
    let json = |key: &str| {
        let text = QUAD.embedded();
        let start = text.find(key).unwrap();
        let end = start + text[start..].find('}').unwrap() + 1;
        format!("{}{sparse}{}", &text[..start], &text[end..])
    };
    check_refused(&files.add("positions.gltf", json(r#"{"bufferView": 0, "componentType""#)));
    // Attributes with another count than the positions are not read.
    let uvs = json(r#"{"bufferView": 2, "componentType""#);
    let error = within(10 * MEGABYTE, &files.add("uvs.gltf", uvs)).unwrap_err();
    assert!(matches!(error, ImportError::Parse { .. }), "{error}");
    assert!(within(10 * MEGABYTE, &files.add("good.gltf", QUAD.embedded())).is_ok(), "negative control");
}

#[test]
fn keyframes_without_data_are_counted_and_bounded() {
    let files = Files::new();
    let told = |count: u64, budget: u64| {
        let accessors = format!(
            r#""accessors": [{{"componentType": 5126, "count": 1, "type": "SCALAR"}},
                {{"componentType": 5126, "count": {count}, "type": "VEC4"}},"#
        );
        let clip = r#""animations": [{"name": "spin", "samplers": [{"input": 0, "output": 1}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}]}], "asset""#;
        let json = QUAD.embedded().replace(r#""accessors": ["#, &accessors).replace(r#""asset""#, clip);
        let json = json.replace(r#""POSITION": 0, "TEXCOORD_0": 2"#, r#""POSITION": 2, "TEXCOORD_0": 4"#);
        let json = json.replace(r#""indices": 1"#, r#""indices": 3"#);
        within(budget, &files.add("a.gltf", json)).unwrap().report.warnings.join("\n")
    };
    // Products of these counts with 4 and 8 are 0 in 64 bits.
    for count in [1 << 62, 1 << 59] {
        let message = told(count, 10 * MEGABYTE);
        assert!(message.contains("\"spin\" cannot be played") && message.contains("10 MB are free"), "{message}");
        let message = told(count, u64::MAX);
        let reason = format!("accessor 1 has {count} elements without data, more than 4294967295");
        assert!(message.contains("\"spin\" cannot be played") && message.contains(&reason), "{message}");
    }
    let message = told(2, 10 * MEGABYTE);
    assert!(!message.contains("MB") && !message.contains("without data"), "negative control: {message}");
}

#[test]
fn instances_of_a_mesh_are_counted_together() {
    let files = Files::new();
    let nodes = |count: usize| {
        let children: Vec<String> = (1..=count).map(|i| i.to_string()).collect();
        let nodes = format!(r#"[{{"children": [{}]}}{}]"#, children.join(","), r#", {"mesh": 0}"#.repeat(count));
        QUAD.embedded().replace(r#"[{"mesh": 0}]"#, &nodes)
    };
    check_refused(&files.add("many.gltf", nodes(9000)));
    assert!(within(10 * MEGABYTE, &files.add("some.gltf", nodes(1000))).is_ok());
}

/// A PNG of one color takes a few kilobytes, and its texels a thousand times as many.
fn flat_png(side: u32) -> Vec<u8> {
    encode_png(&Image::filled([side, side], Vec3::ONE))
}

#[test]
fn textures_are_counted_by_their_headers_and_together() {
    let files = Files::new();
    let obj = |names: &[String]| {
        let materials: String = names.iter().map(|n| format!("newmtl {n}\nmap_Kd {n}.png\n")).collect();
        files.add("a.mtl", materials);
        let faces: String = names.iter().map(|n| format!("usemtl {n}\nf 1 2 3\n")).collect();
        files.add("a.obj", format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}"))
    };
    let names: Vec<String> = (0..6).map(|i| format!("m{i}")).collect();
    names.iter().for_each(|name| drop(files.add(&format!("{name}.png"), flat_png(700))));
    check_refused(&obj(&names));
    assert_eq!(within(10 * MEGABYTE, &obj(&names[..3])).unwrap().scene.textures.len(), 3);
    files.add("m0.png", flat_png(2000));
    check_refused(&obj(&names[..1]));
}

#[test]
fn the_pictures_of_a_material_are_counted() {
    let files = Files::new();
    files.add("a.png", flat_png(2000));
    let path = files.add("x.json", r#"{"maps": {"bump": {"file": "a.png"}}}"#);
    let load = |budget: u64| {
        load_material(&path, &mut Scene::default(), &ImportOptions { budget: Some(budget), ..Default::default() })
    };
    let message = load(10 * MEGABYTE).unwrap_err().to_string();
    assert!(message.contains("10 MB are free") && message.ends_with("x.json)"), "{message}");
    assert!(load(100 * MEGABYTE).is_ok());
}

#[test]
fn texts_and_elements_of_the_other_formats_are_counted() {
    let files = Files::new();
    let many = 40_000;
    let faces = "f 1 2 3\n".repeat(many);
    check_refused(&files.add("a.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}")));
    // A face of many corners is as many triangles.
    check_refused(&files.add("b.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf{}\n", " 1 2 3".repeat(many))));
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let ply = format!(
        "{header}element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n{}{}\n",
        3 * many,
        " 0 1 2".repeat(many)
    );
    check_refused(&files.add("c.ply", ply));
    // Names take memory, too, wherever they are.
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let names = |text: fn(usize) -> String| (0..10_000).map(text).collect::<String>();
    check_refused(&files.add("e.obj", format!("{triangle}{}", names(|i| format!("usemtl {i}\n")))));
    let same = format!("{triangle}{}", names(|_| "usemtl m\n".into()));
    assert!(within(10 * MEGABYTE, &files.add("f.obj", same)).is_ok(), "negative control");
    for (name, text) in
        [("g", names(|i| format!("newmtl {i}\n"))), ("h", names(|i| format!("newmtl {i}\nmap_Kd {i}.png\n")))]
    {
        files.add(&format!("{name}.mtl"), text);
        check_refused(&files.add(&format!("{name}.obj"), format!("mtllib {name}.mtl\n{triangle}")));
    }
    let objects = format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"nodes\": [{}{{}}]}}", "{},".repeat(many));
    check_refused(&files.add("d.gltf", objects));
}
