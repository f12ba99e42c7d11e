//! What other programs write into OBJ, MTL and PLY files, and byte order marks in all texts.

use super::{gltf::QUAD, *};
use glam::DVec3;
use lapidary_core::scene::Mesh;

fn mesh(name: &str, contents: impl AsRef<[u8]>) -> Mesh {
    let imported = import_alone(name, contents).unwrap();
    check_valid(&imported);
    assert_eq!(imported.report.warnings, [""; 0]);
    imported.scene.mesh
}

fn area(mesh: &Mesh) -> f32 {
    (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).sum()
}

/// Text as Windows programs save it: with a byte order mark in UTF-8, and in both kinds of UTF-16.
fn marked(text: &str) -> [Vec<u8>; 3] {
    let utf16 = |to_bytes: fn(u16) -> [u8; 2]| {
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(to_bytes).collect::<Vec<u8>>()
    };
    [format!("\u{feff}{text}").into_bytes(), utf16(u16::to_le_bytes), utf16(u16::to_be_bytes)]
}

const TRIANGLE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Red\nf 1 2 3\n";
const RED: &str = "newmtl Red\nKd 0.8 0.1 0.1\nKs 0 0 0\nNs 10\n";

#[test]
fn byte_order_marks_of_scenes_and_libraries_are_no_part_of_them() {
    let red = |obj: &[u8], mtl: &[u8]| {
        let files = Files::new();
        files.add("a.mtl", mtl);
        let imported = import(&files.add("a.obj", obj)).unwrap();
        assert_eq!(imported.report.warnings, [""; 0]);
        imported.scene.materials[0].parameters.color("base_color")
    };
    let vertex_first = TRIANGLE.replace("mtllib a.mtl\n", "") + "mtllib a.mtl\n";
    for way in 0..3 {
        let (obj, mtl) = (&marked(TRIANGLE)[way], &marked(RED)[way]);
        for (obj, mtl) in
            [(&obj[..], RED.as_bytes()), (TRIANGLE.as_bytes(), &mtl[..]), (&marked(&vertex_first)[way], &mtl[..])]
        {
            assert_eq!(red(obj, mtl), Vec3::new(0.8, 0.1, 0.1), "{way}");
        }
        let ply = &marked(&ply("float", &["0 0 0", "1 0 0", "0 1 0"], &["3 0 1 2"]))[way];
        assert_eq!(mesh("a.ply", ply).triangles.len(), 1);
        assert_eq!(import_alone("a.gltf", &marked(&QUAD.embedded())[way]).unwrap().report.triangles, 2);
    }
    let utf32 = [b"\xff\xfe\0\0".as_slice(), TRIANGLE.as_bytes()].concat();
    let message = import_alone("a.obj", utf32).unwrap_err().to_string();
    assert!(message.contains("UTF-32") && message.ends_with("a.obj)"), "{message}");
}

#[test]
fn byte_order_marks_of_materials_are_no_part_of_them() {
    let files = Files::new();
    let mtlx = "<?xml version=\"1.0\"?>\n<materialx version=\"1.38\"><standard_surface name=\"s\" type=\"surfaceshader\">\
        <input name=\"base_color\" type=\"color3\" value=\"0.8,0.1,0.1\"/></standard_surface></materialx>";
    let json = r#"{"model": "ggx", "parameters": {"base_color": [0.8, 0.1, 0.1]}}"#;
    for (name, text) in [("m.json", json), ("m.mtlx", mtlx)] {
        for contents in marked(text) {
            let path = files.add(name, contents);
            let (material, _) = load_material(&path, &mut Scene::default(), &ImportOptions::default()).unwrap();
            assert_eq!(material.parameters.color("base_color"), Vec3::new(0.8, 0.1, 0.1), "{name}");
        }
    }
}

#[test]
fn an_opaque_material_of_meshlab_is_seen() {
    let files = Files::new();
    files.add("a.mtl", "newmtl Red\nKa 0.2 0.2 0.2\nKd 1 0 0\nKs 1 1 1\nTr 1.000000\nillum 2\nNs 0\n");
    let imported = import(&files.add("a.obj", TRIANGLE)).unwrap();
    assert_eq!(imported.report.warnings, [""; 0]);
    assert_eq!(imported.scene.materials[0].parameters.number("geometry_opacity"), 1.0);
}

#[test]
fn lines_and_points_are_no_surfaces_and_are_counted() {
    let places = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 3 0 0\nv 4 0 0\nv 3 1 0\n";
    let imported =
        import_alone("a.obj", format!("{places}l 1 2 3 4\nl 1/1 2/2\nf 1 3\np 1 2 \\\n3\nf 5 6 7\n")).unwrap();
    check_valid(&imported);
    assert_eq!((imported.report.triangles, imported.report.vertices), (1, 3));
    let [warning] = &imported.report.warnings[..] else { panic!("{:?}", imported.report.warnings) };
    assert!(warning.starts_with("3 lines and 3 points"), "{warning}");
    // Negative control: as a face the polyline has a surface.
    assert_eq!(mesh("a.obj", format!("{places}f 1 2 3 4\nf 5 6 7\n")).triangles.len(), 3);
    for cut_short in ["f", "f \\\n", "f # 1 2 3\n"] {
        let message = import_alone("a.obj", format!("{places}{cut_short}")).unwrap_err().to_string();
        assert!(message.contains("no corners at line 8") && message.ends_with("a.obj)"), "{message}");
    }
}

#[test]
fn colors_and_weights_of_vertices_move_no_others() {
    let of = |vertices: &str| mesh("a.obj", format!("{vertices}f 1 2 3\n")).positions;
    let plain = of("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    assert_eq!(plain.len(), 3);
    for vertices in [
        "v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0\n",
        "v 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 0 1 0 1 1 1 # white\n",
        "v 0 0 0 1 0 0 1\nv 1 0 0 1.0\nv 0 1 0 a b c\n",
        "v 0 0 0 1\nv 2 0 0 2\nv 0 0.5 0 0.5\n",
    ] {
        assert_eq!(of(vertices), plain, "{vertices}");
    }
    for damaged in ["v 0 0", "v 0 0 x", "v 0 0 0 x", "v 0 0 0 0", "v"] {
        let message = import_alone("a.obj", format!("v 1 0 0\n{damaged}\nv 0 1 0\nf 1 2 3\n")).unwrap_err().to_string();
        assert!(message.contains("line 2") && message.ends_with("a.obj)"), "{message}");
    }
}

/// A file of vertices and faces, in ascii.
fn ply(kind: &str, vertices: &[&str], faces: &[&str]) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{}\n{}\n",
        vertices.len(),
        faces.len(),
        vertices.join("\n"),
        faces.join("\n")
    )
}

/// The letter C, 7 of the 9 cells of a grid.
const C: [&str; 8] =
    ["1.5 -0.5 0", "-0.5 -0.5 0", "-0.5 0.5 0", "1.5 0.5 0", "1.5 1.5 0", "-1.5 1.5 0", "-1.5 -1.5 0", "1.5 -1.5 0"];

#[test]
fn concave_polygons_leave_their_notches_open() {
    let vertices: String = C.iter().map(|place| format!("v {place}\n")).collect();
    let c = format!("{vertices}vn 0 0 1\nf 1//1 2//1 3//1 4//1 5//1 6//1 7//1 8//1\n");
    let arrow = "v -1 -1 0\nv 0 -0.4 0\nv 1 -1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n";
    let as_ply = ply("float", &C, &["8 0 1 2 3 4 5 6 7"]);
    for (name, contents, expected) in [("c.obj", c.as_str(), 7.0), ("a.obj", arrow, 1.4), ("c.ply", &as_ply, 7.0)] {
        let mesh = mesh(name, contents);
        assert!((area(&mesh) - expected).abs() < 1e-5, "{name}: {}", area(&mesh));
        assert!((0..mesh.triangles.len()).all(|t| mesh.area_vector(t).z > 0.0), "{name}");
        for corners in &mesh.triangles {
            let middle = corners.iter().map(|&v| mesh.positions[v as usize]).sum::<Vec3>() / 3.0;
            assert!(!(middle.x > -0.5 && middle.y.abs() < 0.5) || name == "a.obj", "{middle} is in the notch");
        }
    }
    // Negative control: a fan covers the notch.
    let fan: String = (3..=8).map(|i| format!("f 1 {} {i}\n", i - 1)).collect();
    assert!(area(&import_alone("c.obj", vertices + &fan).unwrap().scene.mesh) > 9.0);
}

#[test]
fn convex_polygons_are_fans_as_before() {
    let circle: String = (0..8).map(|i| (i as f32 * 0.785).sin_cos()).map(|(y, x)| format!("v {x} {y} 0\n")).collect();
    let corners = mesh("a.obj", circle + "f 1 2 3 4 5 6 7 8\n").triangles;
    assert_eq!(corners, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7]]);
}

/// The distinct normals.
fn normals(mesh: &Mesh) -> usize {
    let rounded = |n: &Vec3| (1e3 * *n).round().as_ivec3();
    mesh.normals.iter().map(rounded).collect::<std::collections::HashSet<_>>().len()
}

#[test]
fn faces_without_smoothing_have_their_own_normals() {
    let prism = prism(8, false);
    let flat = |off: &str| prism.replacen("f ", &format!("s {off}\nf "), 1);
    for off in ["off", "0"] {
        let mesh = mesh("a.obj", flat(off));
        assert_eq!((normals(&mesh), mesh.positions.len()), (8, 32));
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let face = mesh.area_vector(t).normalize();
            assert!(corners.iter().all(|&v| mesh.normals[v as usize].dot(face) > 0.9999));
        }
    }
    // Negative controls: without the statement, and in a group, neighbors share normals.
    assert_eq!([normals(&mesh("a.obj", &prism)), normals(&mesh("a.obj", flat("1")))], [8, 8]);
    assert_eq!([mesh("a.obj", &prism), mesh("a.obj", flat("1"))].map(|mesh| mesh.positions.len()), [16, 16]);
    // The two triangles of a bent quad are one face.
    let bent = mesh("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\ns off\nf 1 2 3 4\n");
    assert_eq!((normals(&bent), bent.positions.len()), (1, 4));
}

#[test]
fn faces_of_a_group_are_smooth_and_groups_meet_in_hard_edges() {
    let smooth = mesh("a.obj", CUBE.replacen("f ", "s 1\nf ", 1));
    assert_eq!((smooth.positions.len(), normals(&smooth)), (8, 8));
    for (p, n) in smooth.positions.iter().zip(&smooth.normals) {
        assert!(n.dot((*p - 0.5).normalize()) > 0.999, "{p} {n}");
    }
    assert_eq!(mesh("a.obj", CUBE).positions.len(), 24, "negative control: without a group by the angle");
    // Two squares that meet at 30 degrees.
    let two = |second: &str| {
        format!(
            "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\nv 0.866 -1 -0.5\nv 0.866 1 -0.5\ns 1\nf 1 2 3 4\n{second}\nf 2 5 6 3\n"
        )
    };
    assert_eq!(normals(&mesh("two.obj", two("s 2"))), 2);
    assert_eq!(normals(&mesh("two.obj", two("s off"))), 2);
    assert_eq!(normals(&mesh("two.obj", two(""))), 3, "negative control: one group");
    assert_eq!(normals(&mesh("two.obj", two("s"))), 3, "a statement that is cut short says nothing");
    // Faces before the first statement are left to the angle; dropped faces shift no groups.
    let late = two("s 2").replace("s 1\nf 1 2 3 4\n", "f 1 2 3 4\nf 1 1 2\nf 1 2\ns 1\nf 4 3 2 1\n");
    assert_eq!(normals(&import_alone("two.obj", late).unwrap().scene.mesh), 3);
}

/// A sphere of radius 1 m around a place, as the vertices and quads of a grid.
fn ball(center: [f64; 3]) -> (Vec<String>, Vec<[usize; 4]>) {
    let (rows, columns) = (12, 24);
    let at = |row: usize, column: usize| {
        let (polar, around) =
            (row as f64 / rows as f64 * std::f64::consts::PI, column as f64 / columns as f64 * std::f64::consts::TAU);
        let unit = [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()];
        [0, 1, 2].map(|axis| (center[axis] + unit[axis]).to_string()).join(" ")
    };
    let vertices = (0..=rows).flat_map(|row| (0..=columns).map(move |column| at(row, column))).collect();
    let corner = |row: usize, column: usize| row * (columns + 1) + column;
    let quad = |row, column| {
        [corner(row, column), corner(row + 1, column), corner(row + 1, column + 1), corner(row, column + 1)]
    };
    (vertices, (0..rows).flat_map(|row| (0..columns).map(move |column| quad(row, column))).collect())
}

fn ball_files(center: [f64; 3]) -> [(&'static str, String); 2] {
    let (vertices, faces) = ball(center);
    let text = |first: usize| faces.iter().map(move |quad| quad.map(|corner| (corner + first).to_string()).join(" "));
    let mut obj: String = vertices.iter().map(|place| format!("v {place}\n")).collect();
    text(1).for_each(|corners| obj += &format!("f {corners}\n"));
    let places: Vec<&str> = vertices.iter().map(String::as_str).collect();
    let lists: Vec<String> = text(0).map(|corners| format!("4 {corners}")).collect();
    [("ball.obj", obj), ("ball.ply", ply("double", &places, &lists.iter().map(String::as_str).collect::<Vec<_>>()))]
}

#[test]
fn scenes_in_coordinates_of_maps_keep_their_shape() {
    for (name, contents) in ball_files([451_234.5, 5_411_111.25, 300.0]) {
        let imported = import_alone(name, contents).unwrap();
        check_valid(&imported);
        let mesh = &imported.scene.mesh;
        let bounds = mesh.bounds();
        assert!((bounds.max - bounds.min - 2.0).abs().max_element() < 1e-4, "{name}: {bounds:?}");
        let center = bounds.center();
        assert!(center.length() < 2.0, "{center}");
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(n.dot(*p - center) > 0.97, "{name}: {p} {n}");
        }
        let [warning] = &imported.report.warnings[..] else { panic!("{:?}", imported.report.warnings) };
        assert!(warning.contains("add (451235, 5411111, 300)"), "{warning}");
    }
}

#[test]
fn scenes_near_the_origin_stay_where_they_are() {
    for (name, contents) in ball_files([30.0, -20.0, 300.0]) {
        let mesh = mesh(name, contents);
        assert!((mesh.bounds().center() - Vec3::new(30.0, -20.0, 300.0)).length() < 1e-3, "{name}");
    }
    // A vertex that no face uses is no part of the scene.
    let far = "v 451234.5 5411111.25 300\nv 451235.5 5411111.25 300\nv 451234.5 5411112.25 300\n";
    let unused = import_alone("a.obj", format!("v 0 0 0\n{far}f 2 3 4\n")).unwrap();
    assert!((area(&unused.scene.mesh) - 0.5).abs() < 1e-6);
    assert_eq!(unused.report.warnings.len(), 1);
    // Damaged numbers far away are errors as they are elsewhere.
    let message = import_alone("a.obj", format!("{far}v 451234.5 5411111.25\nf 1 2 3\n")).unwrap_err().to_string();
    assert!(message.contains("line 4"), "{message}");
}

/// Warnings of a scene with this material.
fn warnings_of(material: &str) -> Vec<String> {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    files.add_png("b.png", [0.25; 3]);
    files.add("a.mtl", format!("newmtl Red\n{material}"));
    import(&files.add("a.obj", TRIANGLE)).unwrap().report.warnings
}

#[test]
fn statements_of_a_library_that_are_not_rendered_are_told_by_name() {
    for (statement, said) in [
        ("disp -mm 0 0.1 a.png", "the statement disp (displacement)"),
        ("map_disp a.png", "the statement map_disp (displacement)"),
        ("decal a.png", "the statement decal (pictures over the others)"),
        ("refl -type sphere a.png", "the statement refl (pictures of reflections)"),
        ("d 0.5\nTf 1 0.5 0.5", "the statement Tf (colors of transmitted light)"),
        ("map_Ns a.png", "the statement map_Ns (maps of shininess)"),
        ("map_RMA a.png", "the statement map_RMA"),
        ("Kd spectral red.rfl", "the statement Kd in a form that is not read"),
        ("Ni glass", "the statement Ni in a form that is not read"),
        ("map_Kd -s", "the statement map_Kd in a form that is not read"),
        ("Ni 7", "the statement Ni out of 1 to 4"),
        ("Ni 0", "the statement Ni out of 1 to 4"),
        ("bump a.png\nmap_bump b.png", "the statement map_bump beside another one"),
        ("Ks 0.9 0.5 0.1", "a highlight (Ks) with a hue"),
        ("map_Kd -cc on a.png", "the option -cc of map_Kd"),
        ("map_Kd -texres 512 a.png", "the option -texres of map_Kd"),
        ("map_Kd -mm 0.2 1 a.png", "the option -mm of map_Kd"),
        ("map_Pr -t 0.5 a.png", "the option -t of map_Pr"),
        ("map_Kd -boost 2 a.png", "the option -boost of map_Kd"),
        ("map_Kd -blendu off a.png", "the option -blendu of map_Kd"),
        ("map_Kd -imfchan g a.png", "the option -imfchan of map_Kd"),
        ("map_Pr -imfchan l a.png", "the option -imfchan of map_Pr"),
        ("map_Pr -bm 2 a.png", "the option -bm of map_Pr"),
    ] {
        let warnings = warnings_of(statement);
        let expected = format!("the materials \"Red\" have {said}, which is left out");
        assert!(warnings.len() == 1 && warnings[0].starts_with(&expected), "{statement}: {warnings:?}");
    }
}

#[test]
fn statements_that_are_rendered_or_have_no_effect_are_not_told() {
    for statement in [
        "Ka 0.2 0.2 0.2\nKd 1 0 0 # red\nKs 0.5 0.5 0.5\nillum 2\nTf 0.5 0.5 0.5\nNi 1.5\nNs 10",
        "d 0.5\nTf 1 1 1",
        "Kd 1 0 0\n\n  \nKs 0 0 0\n",
        "Ni 1",
        "Ni 4",
        "map_Ka a.png\nsharpness 60",
        "map_Kd -clamp on a.png",
        "map_Kd a.png\nmap_Ka a.png",
        "bump a.png\nmap_bump a.png",
        "norm a.png\nKd 0 0 0\nKs 0.9 0.6 0.3\nPm 1",
        "map_Kd -cc off -clamp off -mm 0 1 -t 0 0 0 -boost 0 -blendu on -blendv on -s 2 2 1 -o 0.5 0.5 0 a.png",
        "map_Pr -imfchan g a.png\nmap_bump -bm 2 a.png",
        "Pc 1\nmap_Pc a.png\nPcr 0.1\nPs 0.5\naniso 0.5\nanisor 0.25",
    ] {
        assert_eq!(warnings_of(statement), [""; 0], "{statement}");
    }
    let many: String = (0..50).map(|i| format!("acme_{i} 1\n")).collect();
    let warnings = warnings_of(&many);
    assert_eq!((warnings.len(), warnings[20].as_str()), (21, "30 more kinds of statements of materials are left out"));
}

#[test]
fn a_map_of_a_coat_alone_has_a_coat() {
    let files = Files::new();
    files.add_png("a.png", [0.5; 3]);
    let coat = |material: &str| {
        files.add("a.mtl", format!("newmtl Red\n{material}"));
        let material = import(&files.add("a.obj", TRIANGLE)).unwrap().scene.materials.remove(0);
        (material.maps.get("coat_weight").is_some(), material.parameters.number("coat_weight"))
    };
    assert_eq!(coat("map_Pc a.png"), (true, 1.0));
    assert_eq!(
        (coat("Pc 0.25\nmap_Pc a.png"), coat("Pc 0\nmap_Pc a.png").0),
        ((true, 0.25), false),
        "negative control"
    );
}

#[test]
fn a_picture_with_a_damaged_line_is_read_and_told_by_name() {
    let files = Files::new();
    let warnings = |line: &str| {
        let header = format!("#?RADIANCE\n{line}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
        files.add("sky.hdr", [header.as_bytes(), &[128, 64, 32, 129]].concat());
        files.add("a.mtl", "newmtl Red\nmap_Kd sky.hdr\n");
        let imported = import(&files.add("a.obj", TRIANGLE)).unwrap();
        let texel = imported.scene.textures[0].texel(0, 0, ColorSpace::Srgb).truncate();
        assert_eq!(texel, Vec3::new(1.0, 0.5, 0.25));
        let json = files.add("m.json", r#"{"maps": {"base_color": {"file": "sky.hdr"}}}"#);
        let (_, remarks) = load_material(&json, &mut Scene::default(), &ImportOptions::default()).unwrap();
        assert_eq!(remarks, imported.report.warnings);
        remarks
    };
    for (line, said) in
        [("EXPOSURE=much\n", "its EXPOSURE is \"much\""), ("PRIMARIES=0 0\n", "its PRIMARIES is \"0 0\"")]
    {
        let found = warnings(line);
        assert!(found.len() == 1 && found[0].starts_with(&format!("the picture \"sky.hdr\": {said}")), "{found:?}");
    }
    assert_eq!(warnings("EXPOSURE=1\n"), [""; 0], "negative control");
}

#[test]
fn a_gltf_far_from_the_origin_is_moved_in_the_digits_of_its_text_and_says_where_it_was() {
    let far = |nodes: &'static str| import_alone("a.gltf", super::gltf::Gltf { nodes, ..QUAD }.embedded()).unwrap();
    let moved = far(r#"[{"mesh": 0, "translation": [451235.25, 0, 0]}]"#);
    check_valid(&moved);
    assert_eq!(moved.scene.origin, DVec3::new(451_236.0, 1.0, 0.0));
    let near = far(r#"[{"mesh": 0, "translation": [0.25, 0, 0]}]"#);
    assert_eq!(near.scene.origin, DVec3::ZERO);
    let offset = Vec3::new(-1.0, -1.0, 0.0);
    for (moved, near) in moved.scene.mesh.positions.iter().zip(&near.scene.mesh.positions) {
        assert_eq!(*moved, *near + offset, "to the last bit, which is of 3 cm at the place of the file");
    }
    assert!(moved.report.warnings.join("\n").contains("add (451236, 1, 0) to its coordinates"));
    let by_matrix = far(r#"[{"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 451235.25,0,0,1]}]"#);
    assert_eq!(by_matrix.scene.mesh.positions, moved.scene.mesh.positions);
    // It is written back where it was.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.glb");
    lapidary_interchange::export::write_materials(&moved.scene, &path, &Default::default()).unwrap();
    let again = import(&path).unwrap();
    assert_eq!((again.scene.origin, &again.scene.mesh.positions), (moved.scene.origin, &moved.scene.mesh.positions));
    let bytes = std::fs::read(&path).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("\"translation\":[451236.0,1.0,0.0]"));
}

#[test]
fn file_names_are_found_in_either_unicode_form() {
    let [composed, apart] = ["caf\u{e9}.png", "cafe\u{301}.png"];
    for (on_disk, named) in [(composed, apart), (apart, composed), (apart, apart)] {
        let files = Files::new();
        files.add_png(on_disk, [0.25; 3]);
        files.add("a.mtl", format!("newmtl Red\nmap_Kd {named}\n"));
        assert_eq!(import(&files.add("a.obj", TRIANGLE)).unwrap().report.warnings, [""; 0], "{on_disk:?} {named:?}");
    }
    let files = Files::new();
    files.add_png("cafe.png", [0.25; 3]);
    files.add("a.mtl", format!("newmtl Red\nmap_Kd {composed}\n"));
    assert_eq!(import(&files.add("a.obj", TRIANGLE)).unwrap().report.warnings.len(), 1, "negative control");
}
