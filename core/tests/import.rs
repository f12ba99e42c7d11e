//! Imports of small scenes whose right answer is known, and of damaged ones, which are errors and never panics.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic as the tests do")]

use glam::{Vec2, Vec3};
use lapidary_core::{
    import::{ImportError, Imported, import, load_material},
    lights::Emission,
    material::BrdfModel,
    scene::{MeshError, Scene},
    texture::{Channel, ColorSpace},
};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder of input files.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn add(&self, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, contents).unwrap();
        path
    }

    fn add_png(&self, name: &str, rgb: [f32; 3]) -> PathBuf {
        let image = lapidary_core::image::Image::filled([2, 2], Vec3::from_array(rgb));
        self.add(name, lapidary_core::image::encode_png(&image))
    }
}

/// Imports `contents` as the only file of a folder.
fn import_alone(name: &str, contents: impl AsRef<[u8]>) -> Result<Imported, ImportError> {
    let files = Files::new();
    import(&files.add(name, contents))
}

fn check_valid(imported: &Imported) {
    let scene = &imported.scene;
    scene.mesh.validate(scene.materials.len(), scene.objects.len()).unwrap();
    for (normal, tangent) in scene.mesh.normals.iter().zip(&scene.mesh.tangents) {
        assert!((normal.length() - 1.0).abs() < 1e-3 && (tangent.truncate().length() - 1.0).abs() < 1e-3);
        assert!(normal.dot(tangent.truncate()).abs() < 1e-2 && tangent.w.abs() == 1.0);
    }
    for slot in scene.materials.iter().flat_map(|m| m.maps.slots()) {
        assert!((slot.texture as usize) < scene.textures.len());
    }
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

/// A ring of `sides` quads around the y axis, and optionally its top.
fn prism(sides: usize, capped: bool) -> String {
    let mut obj = String::new();
    for i in 0..sides {
        let (sin, cos) = (i as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
        obj += &format!("v {sin} 0 {cos}\nv {sin} 1 {cos}\n");
    }
    for i in 0..sides {
        let j = (i + 1) % sides;
        obj += &format!("f {} {} {} {}\n", 2 * i + 1, 2 * j + 1, 2 * j + 2, 2 * i + 2);
    }
    if capped {
        obj += "f";
        (0..sides).for_each(|i| obj += &format!(" {}", 2 * i + 2));
    }
    obj
}

#[test]
fn a_cube_without_normals_keeps_its_edges_hard() {
    let imported = import_alone("cube.obj", CUBE).unwrap();
    check_valid(&imported);
    let mesh = &imported.scene.mesh;
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), imported.report.normals_rebuilt), (24, 12, 24));
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let face = mesh.area_vector(t).normalize();
        let outward = mesh.corners(t).iter().sum::<Vec3>() / 3.0 - Vec3::splat(0.5);
        assert!(face.dot(outward) > 0.0);
        assert!(corners.iter().all(|&v| mesh.normals[v as usize].dot(face) > 0.999));
    }
    assert_eq!(imported.scene.materials.len(), 1);
    assert_eq!(imported.scene.objects[0].name, "cube");
}

#[test]
fn a_rounded_prism_is_smooth_around_and_hard_at_its_rim() {
    let open = import_alone("a.obj", prism(12, false)).unwrap();
    assert_eq!(open.scene.mesh.positions.len(), 24);
    let mesh = &open.scene.mesh;
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        assert!(n.dot(Vec3::new(p.x, 0.0, p.z).normalize()) > 0.999, "{p} {n}");
    }
    let capped = import_alone("a.obj", prism(12, true)).unwrap();
    assert_eq!(capped.scene.mesh.positions.len(), 36);
    // Negative control: with corners of 90 degrees it is not smooth around.
    assert_eq!(import_alone("a.obj", prism(4, false)).unwrap().scene.mesh.positions.len(), 16);
}

#[test]
fn one_sharp_edge_in_a_smooth_surface_splits_nothing() {
    // A fan of six triangles around a raised centre, with one of its rim points pulled far down: the edges to it are
    // sharp, and every other edge is smooth.
    let mut obj = String::from("v 0 0 0\n");
    for i in 0..6 {
        let (sin, cos) = (i as f32 / 6.0 * std::f32::consts::TAU).sin_cos();
        obj += &format!("v {sin} {} {cos}\n", if i == 0 { -1.2 } else { -0.02 });
    }
    (0..6).for_each(|i| obj += &format!("f 1 {} {}\n", 2 + i, 2 + (i + 1) % 6));
    assert_eq!(import_alone("a.obj", obj).unwrap().scene.mesh.positions.len(), 7);
}

#[test]
fn equal_vertices_are_welded_and_zero_area_and_unused_ones_dropped() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 0\nv 0 0 1\nv 1 0 1\nv 9 9 9\nvn 0 1 0\n\
        f 1//1 3//1 2//1\nf 4//1 5//1 6//1\nf 1//1 2//1 4//1\nf 1//1 1//1 2//1\n";
    let imported = import_alone("a.obj", obj).unwrap();
    check_valid(&imported);
    let report = &imported.report;
    assert_eq!((report.vertices, report.triangles), (4, 2));
    assert_eq!((report.degenerate_triangles, report.welded_vertices, report.normals_rebuilt), (2, 2, 0));
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n5 5 5\n1 0 0\n0 1 0\n3 0 2 3\n";
    assert_eq!(import_alone("a.ply", ply).unwrap().report.unreferenced_vertices, 1);
}

#[test]
fn triangles_wound_against_their_normals_are_turned_and_reported() {
    let with_winding = |face: &str| format!("v 0 0 0\nv 1 0 0\nv 0 0 1\nvn 0 1 0\nf {face}\n");
    let wrong = import_alone("a.obj", with_winding("1//1 2//1 3//1")).unwrap();
    assert_eq!(wrong.report.flipped_triangles, 1);
    assert!(wrong.scene.mesh.area_vector(0).y > 0.0);
    assert!(wrong.report.warnings[0].contains("wound against"));
    let right = import_alone("a.obj", with_winding("1//1 3//1 2//1")).unwrap();
    assert_eq!((right.report.flipped_triangles, right.report.warnings.len()), (0, 0));
    assert!(right.scene.mesh.area_vector(0).y > 0.0);
}

#[test]
fn invalid_normals_are_rebuilt() {
    for bad in ["vn nan 0 0", "vn 0 0 0", "vn inf 1 0"] {
        let imported = import_alone("a.obj", format!("v 0 0 0\nv 0 0 1\nv 1 0 0\n{bad}\nf 1//1 2//1 3//1\n")).unwrap();
        check_valid(&imported);
        assert_eq!(imported.report.normals_rebuilt, 3);
        assert!(imported.scene.mesh.normals.iter().all(|n| *n == Vec3::Y));
    }
}

#[test]
fn tangents_follow_u_and_mirrored_coordinates_split_the_seam() {
    // Two quads in the xy plane, facing +z; u grows with x on the right and against it on the left.
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0 0\nv -1 1 0\nvn 0 0 1\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        f 1/1/1 2/2/1 3/3/1 4/4/1\nf 5/2/1 1/1/1 4/4/1 6/3/1\n";
    let imported = import_alone("a.obj", obj).unwrap();
    check_valid(&imported);
    let mesh = &imported.scene.mesh;
    assert_eq!((mesh.positions.len(), imported.report.split_vertices), (8, 2));
    for corners in &mesh.triangles {
        let right = corners.iter().all(|&v| mesh.positions[v as usize].x >= 0.0);
        for &v in corners {
            let (t, n) = (mesh.tangents[v as usize], mesh.normals[v as usize]);
            let expected = if right { Vec3::X } else { Vec3::NEG_X };
            assert!((t.truncate() - expected).length() < 1e-5, "{t}");
            // +Y of a normal map is up in the picture, which here is +y for both halves.
            assert!((t.w * n.cross(t.truncate()) - Vec3::Y).length() < 1e-5);
        }
    }
    // v points down from the top left corner.
    let top = mesh.positions.iter().position(|p| p.y == 1.0).unwrap();
    assert_eq!(mesh.uvs[top].y, 0.0);
}

#[test]
fn meshes_without_texture_coordinates_get_a_projection_of_one_unit_per_metre() {
    let imported = import_alone("a.obj", CUBE).unwrap();
    let mesh = &imported.scene.mesh;
    assert_eq!(imported.report.uvs_projected, 24);
    for corners in &mesh.triangles {
        let [a, b, _] = corners.map(|v| v as usize);
        let metres = (mesh.positions[a] - mesh.positions[b]).length();
        assert!(((mesh.uvs[a] - mesh.uvs[b]).length() - metres).abs() < 1e-5);
        // The tangent is the direction in which u grows.
        let along = (mesh.positions[b] - mesh.positions[a]).dot(mesh.tangents[a].truncate());
        assert!((mesh.uvs[b].x - mesh.uvs[a].x - along).abs() < 1e-5);
    }
}

#[test]
fn positions_that_are_not_finite_and_indices_out_of_range_are_errors() {
    let error = import_alone("a.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n").unwrap_err();
    assert!(matches!(error, ImportError::Mesh { source: MeshError::NotFinite { array: "position", index: 1 }, .. }));
    for face in ["f 1 2 4", "f 1 2 -4", "f 1 2 0", "f 1/7 2/7 3/7", "f 1//9 2//9 3//9", "f 1 2 99999999999999999999"] {
        let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n{face}\n");
        let error = import_alone("a.obj", obj).unwrap_err();
        assert!(matches!(error, ImportError::Parse { .. }), "{face}: {error}");
        assert!(error.to_string().contains("line 6"), "{error}");
    }
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n";
    let error = import_alone("a.ply", ply).unwrap_err();
    assert!(matches!(error, ImportError::Mesh { source: MeshError::Index { index: 3, count: 3, .. }, .. }), "{error}");
    assert!(import_alone("a.ply", ply.replace("3 0 1 3", "3 0 1 -1")).is_err());
    assert!(import_alone("a.ply", ply.replace("3 0 1 3", "3 0 1 2")).is_ok());
}

#[test]
fn meshes_without_surface_are_errors() {
    for obj in
        ["", "# nothing\n", "v 0 0 0\nv 1 0 0\nl 1 2\n", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "hello, world\n"]
    {
        let error = import_alone("a.obj", obj).unwrap_err();
        assert!(matches!(error, ImportError::Mesh { source: MeshError::Empty, .. }), "{obj}: {error}");
        assert!(error.to_string().ends_with("a.obj)"), "{error}");
    }
}

#[test]
fn unknown_extensions_missing_files_and_absurd_sizes_are_told_apart() {
    let error = import_alone("a.fbx", "x").unwrap_err();
    assert!(
        matches!(error, ImportError::Unsupported { .. }) && error.to_string().contains(".obj, .gltf, .glb or .ply")
    );
    assert!(matches!(import(Path::new("/nowhere/a.obj")), Err(ImportError::Io { .. })));
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n";
    let error = import_alone("a.ply", header).unwrap_err();
    assert!(matches!(error, ImportError::TooLarge { count: 4_000_000_000, .. }), "{error}");
}

#[test]
fn obj_quirks_are_understood() {
    let obj = "mtllib my lib.mtl\r\no Left part\r\nv 0 0 0 # origin\r\nv 1 0 0\r\nv 0 0 1\r\nusemtl  red wood\r\n\
        f 1 \\\r\n 3 2\r\no Right\r\nusemtl lost\r\nf -3 -1 -2 # again\r\n";
    let files = Files::new();
    files.add("My Lib.MTL", "newmtl red wood\r\nKd 1 0 0\r\nmap_Kd -s 2 2 2 Textures\\WOOD one.png\r\nd 0.5\r\n");
    files.add_png("textures/wood One.png", [0.5; 3]);
    let imported = import(&files.add("a.obj", obj)).unwrap();
    check_valid(&imported);
    let scene = &imported.scene;
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["Left part", "Right"]);
    assert_eq!((scene.materials[0].name.as_str(), scene.materials[1].name.as_str()), ("red wood", "lost"));
    assert_eq!(scene.mesh.triangle_material, [0, 1]);
    let slot = scene.materials[0].maps.base_color.as_ref().unwrap();
    assert_eq!((slot.scale, slot.color_space), (Vec2::splat(2.0), ColorSpace::Srgb));
    assert_eq!(scene.textures[0].size, [2, 2]);
    assert!(!scene.textures[0].encoded.is_empty());
    let warnings = imported.report.warnings.join("\n");
    assert!(
        warnings.contains("\"lost\" are in no material library") && warnings.contains("\"red wood\" are transparent")
    );
    assert_eq!(imported.report.warnings.len(), 2, "{warnings}");
}

#[test]
fn missing_libraries_and_textures_are_visible_and_reported() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl m\nf 1 3 2\n";
    let imported = import_alone("a.obj", format!("mtllib gone.mtl\n{triangle}")).unwrap();
    let warnings = imported.report.warnings.join("\n");
    assert!(warnings.contains("\"gone.mtl\"") && warnings.contains("\"m\""), "{warnings}");

    let files = Files::new();
    files.add("a.mtl", "newmtl m\nmap_Kd gone.png\nmap_Pr broken.png\n");
    files.add("broken.png", "not a picture");
    let imported = import(&files.add("a.obj", format!("mtllib a.mtl\n{triangle}"))).unwrap();
    check_valid(&imported);
    assert_eq!(imported.scene.textures.len(), 2);
    assert!(imported.scene.textures.iter().all(|t| t.size == [8, 8] && t.encoded.is_empty()));
    assert_eq!(imported.report.warnings.len(), 2);
    assert!(imported.report.warnings[0].contains("\"gone.png\" was replaced"));
}

#[test]
fn bump_maps_that_are_blue_are_normal_maps_and_a_file_is_loaded_once() {
    let files = Files::new();
    files.add_png("grey.png", [0.2; 3]);
    files.add_png("blue.png", [0.214, 0.214, 1.0]);
    files.add(
        "a.mtl",
        "newmtl a\nbump -bm 0.5 grey.png\nmap_Kd grey.png\nnewmtl b\nmap_Bump -bm 0.25 blue.png\nnewmtl c\nnorm blue.png\n",
    );
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl a\nf 1 3 2\nusemtl b\nf 1 3 2\nusemtl c\nf 1 3 2\n";
    let scene = import(&files.add("a.obj", obj)).unwrap().scene;
    assert_eq!(scene.textures.len(), 2);
    let strength = |slot: &Option<lapidary_core::texture::TextureSlot>| slot.as_ref().map(|s| s.strength);
    let [a, b, c] = [0, 1, 2].map(|i| &scene.materials[i].maps);
    assert_eq!((strength(&a.bump), strength(&a.normal)), (Some(0.005), None));
    assert_eq!((strength(&b.bump), strength(&b.normal)), (None, Some(0.25)));
    assert_eq!((strength(&c.bump), strength(&c.normal)), (None, Some(1.0)));
}

#[test]
fn partly_missing_normals_are_rebuilt_with_a_warning() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nvn 0 -1 0\nf 1//1 3//1 2//1\nf 2 3 4\n";
    let imported = import_alone("a.obj", obj).unwrap();
    check_valid(&imported);
    assert!(imported.scene.mesh.normals.iter().all(|n| *n == Vec3::Y));
    assert!(imported.report.warnings[0].contains("only some faces of \"a\" have normals"));
}

/// A quad as glTF: positions, and the rest of its JSON from `parts` of the form `"key": value`.
struct Gltf {
    nodes: &'static str,
    primitive: &'static str,
    rest: &'static str,
}

const QUAD: Gltf = Gltf { nodes: r#"[{"mesh": 0}]"#, primitive: r#""indices": 1"#, rest: "" };

impl Gltf {
    /// Four positions of the unit square in xy, then six `u16` indices, then four texture coordinates.
    fn buffer() -> Vec<u8> {
        let positions = [[0f32, 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        let uvs = [[0f32, 1.], [1., 1.], [1., 0.], [0., 0.]];
        let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
        bytes.extend(uvs.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    fn json(&self, buffer: &str) -> String {
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

    fn embedded(&self) -> String {
        use base64::Engine;
        let data = base64::engine::general_purpose::STANDARD.encode(Self::buffer());
        self.json(&format!(r#"{{"byteLength": 92, "uri": "data:application/octet-stream;base64,{data}"}}"#))
    }

    fn binary(&self) -> Vec<u8> {
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
            "extensionsUsed": ["KHR_texture_transform", "KHR_materials_ior", "KHR_materials_clearcoat"],
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
    let p = &material.parameters;
    assert_eq!((p.base_color, p.roughness, p.metalness, p.ior), (Vec3::new(0.1, 0.2, 0.3), 0.4, 0.6, 1.33));
    assert!(material.double_sided);
    let maps = &material.maps;
    let base = maps.base_color.as_ref().unwrap();
    assert_eq!((base.color_space, base.rotation, base.texture), (ColorSpace::Srgb, 0.5, 0));
    let (rough, metal) = (maps.roughness.as_ref().unwrap(), maps.metalness.as_ref().unwrap());
    assert_eq!((rough.channel, metal.channel, rough.color_space), (Channel::G, Channel::B, ColorSpace::Linear));
    let normal = maps.normal.as_ref().unwrap();
    assert_eq!((normal.strength, normal.scale, normal.offset), (0.5, Vec2::new(3.0, 4.0), Vec2::new(0.25, 0.0)));
    let camera = &imported.scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.eye, camera.fov_y), ("view", Vec3::new(0.5, 0.5, 4.0), 0.7));
    assert!((camera.target - Vec3::new(0.5, 0.5, 0.0)).length() < 1e-5);
    let warnings = imported.report.warnings.join("\n");
    for part in ["\"gone.png\" was replaced", "second set", "transparent", "\"KHR_materials_clearcoat\" are"] {
        assert!(warnings.contains(part), "{part} is not in {warnings}");
    }
    assert_eq!(imported.report.warnings.len(), 4, "{warnings}");
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
    for part in
        ["\"gone\"", "\"odd\" was left out", "\"laser\"", "\"wide\"", "\"text\"", "negative", "\"key\" have a range"]
    {
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
        (r#""version": "2.0"}"#, r#""version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"]"#),
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

fn binary_ply() -> Vec<u8> {
    let mut ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property double z\nproperty float s\nproperty float t\nelement face 1\n\
        property list uchar uint vertex_indices\nend_header\n"
        .to_vec();
    for [x, y] in [[0f32, 0.], [1., 0.], [1., 1.], [0., 1.]] {
        ply.extend(x.to_le_bytes());
        ply.extend(y.to_le_bytes());
        ply.extend(0f64.to_le_bytes());
        ply.extend(x.to_le_bytes());
        ply.extend(y.to_le_bytes());
    }
    ply.push(4);
    ply.extend([0u32, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    ply
}

#[test]
fn ply_polygons_and_texture_coordinates_are_read() {
    let imported = import_alone("square.ply", binary_ply()).unwrap();
    check_valid(&imported);
    let mesh = &imported.scene.mesh;
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), imported.report.uvs_projected), (4, 2, 0));
    assert!(mesh.positions.iter().zip(&mesh.uvs).all(|(p, uv)| (p.x, 1.0 - p.y) == (uv.x, uv.y)));
    assert_eq!(imported.scene.objects[0].name, "square");
}

#[test]
fn truncated_files_are_errors_and_corrupt_ones_never_panic() {
    let files = Files::new();
    let random = &mut fastrand::Rng::with_seed(11);
    let whole: [(&str, Vec<u8>); 4] = [
        ("a.ply", binary_ply()),
        ("a.glb", QUAD.binary()),
        ("a.gltf", QUAD.embedded().into_bytes()),
        ("a.obj", format!("{CUBE}vn 0 1 0\nvt 0 0\nf 1/1/1 2/1/1 3/1/1\n").into_bytes()),
    ];
    for (name, bytes) in &whole {
        assert!(import(&files.add(name, bytes)).is_ok(), "{name}");
        for length in (0..bytes.len()).step_by(3) {
            let result = import(&files.add(name, &bytes[..length]));
            // An OBJ cut between faces is a smaller OBJ, and closing blanks are no loss.
            let may_pass = *name == "a.obj" || bytes[length..].trim_ascii().is_empty();
            assert!(may_pass || result.is_err(), "{name} cut to {length} bytes");
        }
        for _ in 0..1500 {
            let mut damaged = bytes.clone();
            for _ in 0..random.usize(1..4) {
                let at = random.usize(..damaged.len());
                damaged[at] = if random.bool() { random.u8(..) } else { random.choice(*b"0123456789-/. \n").unwrap() };
            }
            if let Ok(imported) = import(&files.add(name, &damaged)) {
                let scene = &imported.scene;
                scene.mesh.validate(scene.materials.len(), scene.objects.len()).unwrap();
            }
        }
    }
}

#[test]
fn foreign_files_are_errors_under_every_extension() {
    let png = lapidary_core::image::encode_png(&lapidary_core::image::Image::filled([3, 3], Vec3::ONE));
    let foreign: [&[u8]; 5] = [b"", b"solid cube\nendsolid\n", &png, b"{}", &[0xff; 300]];
    for extension in ["obj", "gltf", "glb", "ply"] {
        for bytes in foreign {
            let error = import_alone(&format!("a.{extension}"), bytes).unwrap_err();
            assert!(error.to_string().ends_with(&format!("a.{extension})")), "{error}");
        }
    }
}

/// A tetrahedron-like soup of random triangles on few positions: edges with many faces, repeated and collapsed ones.
#[test]
fn random_soups_come_out_valid() {
    let files = Files::new();
    let random = &mut fastrand::Rng::with_seed(5);
    for _ in 0..300 {
        let points = random.usize(3..9);
        let mut obj = String::new();
        let coordinate = |random: &mut fastrand::Rng| random.choice([0.0, 1.0, -1.0, 0.5, 1e-20, 1e15]).unwrap();
        for _ in 0..points {
            obj += &format!("v {} {} {}\n", coordinate(random), coordinate(random), coordinate(random));
            obj += &format!("vt {} {}\n", coordinate(random), coordinate(random));
        }
        for _ in 0..random.usize(1..30) {
            let corner =
                |random: &mut fastrand::Rng| format!("{0}/{1}", random.usize(1..=points), random.usize(1..=points));
            obj += &format!("f {} {} {}\n", corner(random), corner(random), corner(random));
        }
        match import(&files.add("a.obj", &obj)) {
            Ok(imported) => check_valid(&imported),
            Err(error) => {
                assert!(matches!(error, ImportError::Mesh { source: MeshError::Empty, .. }), "{error}\n{obj}")
            }
        }
    }
}

#[test]
fn material_files_have_a_map_for_every_parameter() {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let keys = ["base_color", "roughness", "metalness", "specular", "anisotropy", "ior", "normal", "bump"];
    for key in keys {
        let json = format!(r#"{{"maps": {{"{key}": {{"file": "a.png", "channel": "b"}}}}}}"#);
        let maps = load_material(&files.add("one.json", &json), &mut Scene::default()).unwrap().maps;
        let read = serde_json::to_value(&maps).unwrap();
        for other in keys {
            assert_eq!(read[other].is_null(), other != key, "{key}, {other}");
        }
        let expected = if key == "base_color" { "srgb" } else { "linear" };
        assert_eq!((&read[key]["color_space"], &read[key]["channel"]), (&expected.into(), &"b".into()));
    }
    let misspelt = files.add("iro.json", r#"{"maps": {"iro": {"file": "a.png"}}}"#);
    assert!(load_material(&misspelt, &mut Scene::default()).is_err());
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
    let material = load_material(&path, &mut scene).unwrap();
    assert_eq!(
        (material.name.as_str(), material.model, material.parameters.roughness),
        ("gold", BrdfModel::Ward, 0.25)
    );
    let (color, roughness) = (material.maps.base_color.unwrap(), material.maps.roughness.unwrap());
    assert_eq!((color.color_space, roughness.color_space), (ColorSpace::Srgb, ColorSpace::Linear));
    assert_eq!((roughness.channel, color.scale), (Channel::G, Vec2::splat(2.0)));
    assert!((color.rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    load_material(&path, &mut scene).unwrap();
    assert_eq!(scene.textures.len(), 1);

    for (name, bad) in
        [("typo.json", r#"{"rougness": 1}"#), ("gone.json", r#"{"maps": {"bump": {"file": "gone.png"}}}"#)]
    {
        assert!(load_material(&files.add(name, bad), &mut scene).is_err());
    }
    assert_eq!(scene.textures.len(), 1);
}
