//! PLY files with textures, as MeshLab and other programs of its library write them, and with large coordinates.

use super::*;

/// A square of two triangles with texture coordinates at their corners. The second uses another part of the texture on the
/// same vertices.
fn square(comments: &str, second: &str) -> String {
    let properties =
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber";
    format!(
        "ply\nformat ascii 1.0\ncomment VCGLIB generated\n{comments}element vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face 2\n{properties}\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
         3 0 1 2 6 0 0 0.5 0 0.5 0.5 0\n3 0 2 3 {second}\n"
    )
}

const SECOND: &str = "6 0.5 0.5 1 1 0.5 1 1";

fn named(files: &Files, comments: &str, second: &str) -> Imported {
    files.add_png("a.png", [0.25; 3]);
    files.add_png("b.png", [0.75; 3]);
    let imported = import(&files.add("square.ply", square(comments, second))).unwrap();
    check_valid(&imported);
    imported
}

/// The texture coordinates of each triangle, from the bottom as in the file, by position.
fn uvs(imported: &Imported, triangle: usize) -> Vec<[f32; 4]> {
    let mesh = &imported.scene.mesh;
    let corner = |&v: &u32| {
        let (p, uv) = (mesh.positions[v as usize], mesh.uvs[v as usize]);
        [p.x, p.y, uv.x, 1.0 - uv.y]
    };
    let mut corners: Vec<_> = mesh.triangles[triangle].iter().map(corner).collect();
    corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
    corners
}

#[test]
fn corners_have_coordinates_of_their_own_and_faces_their_texture() {
    let imported = named(&Files::new(), "comment TextureFile a.png\ncomment TextureFile b.png\n", SECOND);
    assert_eq!(uvs(&imported, 0), [[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.5, 0.0], [1.0, 1.0, 0.5, 0.5]]);
    assert_eq!(uvs(&imported, 1), [[0.0, 0.0, 0.5, 0.5], [0.0, 1.0, 0.5, 1.0], [1.0, 1.0, 1.0, 1.0]]);
    assert_eq!((imported.report.vertices, imported.report.uvs_projected), (6, 0), "two vertices are on the seam");
    assert_eq!(imported.report.warnings, [""; 0]);
    let scene = &imported.scene;
    assert_eq!(scene.mesh.triangle_material, [0, 1]);
    assert_eq!(scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    for (material, value) in scene.materials.iter().zip([0.25, 0.75]) {
        let slot = material.maps.get("base_color").unwrap();
        let shown = scene.textures[slot.texture as usize].texel(0, 0, slot.color_space).x;
        assert!((shown - value).abs() < 0.01 && material.parameters.color("base_color") == Vec3::ONE, "{shown}");
    }
    // Normals are smooth across the seam of the texture, and the square has one.
    assert!(scene.mesh.normals.iter().all(|normal| *normal == Vec3::Z));
}

#[test]
fn a_texture_that_is_missing_or_not_named_is_said_or_none() {
    let files = Files::new();
    let plain = named(&files, "", SECOND);
    assert_eq!((plain.scene.materials.len(), plain.scene.textures.len()), (1, 0), "negative control");
    let none = named(&files, "comment TextureFile a.png\n", "6 0.5 0.5 1 1 0.5 1 -1");
    assert_eq!(none.scene.mesh.triangle_material, [0, 1]);
    assert!(none.scene.materials[1].maps.get("base_color").is_none());
    let far = named(&files, "comment TextureFile a.png\n", "6 0.5 0.5 1 1 0.5 1 7");
    assert!(far.scene.materials[1].maps.get("base_color").is_none() && far.scene.materials.len() == 2);
    let gone = named(&files, "comment TextureFile gone.png\n", SECOND);
    assert!(gone.report.warnings[0].contains("\"gone.png\" was replaced by a magenta"), "{:?}", gone.report.warnings);
    let outside = named(&files, "comment TextureFile ../../secret.png\n", SECOND);
    assert_eq!(outside.report.warnings.len(), 1, "{:?}", outside.report.warnings);
    let spaced = files.add_png("my texture.png", [0.5; 3]);
    assert!(spaced.exists());
    assert_eq!(named(&files, "comment  TextureFile my texture.png\n", SECOND).report.warnings, [""; 0]);
}

#[test]
fn coordinates_that_do_not_fit_their_face_are_left_out_and_said() {
    let files = Files::new();
    let unfit = named(&files, "", "4 0.5 0.5 1 1 0");
    assert!(unfit.report.warnings[0].starts_with("1 faces have texture coordinates"), "{:?}", unfit.report.warnings);
    assert_eq!(unfit.report.uvs_projected, 3);
    let without = named(&files, "", "0 0");
    assert_eq!((without.report.warnings.len(), without.report.uvs_projected), (0, 3));
    let bad = square("", SECOND).replace("3 0 2 3", "3 0 2 9");
    let error = import(&files.add("bad.ply", bad)).unwrap_err().to_string();
    assert!(error.ends_with("bad.ply)"), "{error}");
}

#[test]
fn texts_keep_the_digits_of_coordinates_whatever_their_type() {
    let with = |kind: &str| {
        let mut ply = String::from("ply\nformat ascii 1.0\nelement vertex 4\n");
        ["x", "y", "z"].iter().for_each(|axis| ply += &format!("property {kind} {axis}\n"));
        ply += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        for [x, y] in [[0.0, 0.0], [0.25, 0.0], [0.25, 0.25], [0.0, 0.25]] {
            ply += &format!("{} {} 300.0\n", 451_234.5 + x, 5_411_111.25 + y);
        }
        let imported = import_alone("map.ply", ply + "4 0 1 2 3\n").unwrap();
        assert!(imported.report.warnings[0].contains("lies far from the origin"), "{:?}", imported.report.warnings);
        imported.scene.mesh
    };
    let mesh = with("float");
    let size = mesh.bounds().max - mesh.bounds().min;
    assert_eq!(size, Vec3::new(0.25, 0.25, 0.0), "f32 has steps of 0.5 there");
    assert_eq!(mesh, with("double"));
}

/// A square of two triangles with these properties and values of its vertices and its faces, and further elements.
fn with(vertices: [&str; 2], faces: [&str; 3], elements: [&str; 2]) -> String {
    let places = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"].map(|place| format!("{place} {}\n", vertices[1])).concat();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{}element face 2\n\
         property list uchar int vertex_indices\n{}{}end_header\n{places}3 0 1 2 {}\n3 0 2 3 {}\n{}",
        vertices[0], faces[0], elements[0], faces[1], faces[2], elements[1]
    )
}

const RGB: &str = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

#[test]
fn faces_have_colors_of_their_own_where_vertices_have_none() {
    let colors = |imported: &Imported| {
        let mesh = &imported.scene.mesh;
        assert_eq!(mesh.triangles.len(), 2);
        [0, 1].map(|t| mesh.triangles[t].map(|v| mesh.colors[v as usize]))
    };
    for vertices in [["", ""], [RGB, "255 255 255"]] {
        let imported = import_alone("a.ply", with(vertices, [RGB, "255 0 0", "0 0 255"], ["", ""])).unwrap();
        check_valid(&imported);
        assert_eq!(colors(&imported), [[Vec3::X; 3], [Vec3::Z; 3]]);
        assert_eq!((imported.report.vertices, &imported.report.warnings[..]), (6, &[][..]));
        let material = &imported.scene.materials[0];
        assert!(material.vertex_colors && material.parameters.color("base_color") == Vec3::ONE);
    }
    let both = import_alone("a.ply", with([RGB, "0 255 0"], [RGB, "255 0 0", "0 0 255"], ["", ""])).unwrap();
    assert_eq!((colors(&both), both.report.vertices), ([[Vec3::Y; 3]; 2], 4));
    assert!(both.report.warnings[0].starts_with("the faces have colors beside those of vertices, which are left out"));
    let white = import_alone("a.ply", with(["", ""], [RGB, "255 255 255", "255 255 255"], ["", ""])).unwrap();
    assert!(white.scene.mesh.colors.is_empty() && white.report.vertices == 4, "negative control");
}

#[test]
fn what_of_a_file_is_left_out_is_said_by_name() {
    let said = |vertices, faces, elements| {
        import_alone("a.ply", with(vertices, faces, elements)).unwrap().report.warnings.join("\n")
    };
    const ALPHA: &str = "property uchar alpha\n";
    const NONE: [&str; 2] = ["", ""];
    let opaque = [ALPHA, "255", "255"];
    let vertices = said([ALPHA, "10"], opaque, NONE);
    assert!(vertices.starts_with("the properties of vertices \"alpha\" have opacities"), "{vertices}");
    assert!(said([ALPHA, "255"], [ALPHA, "255", "10"], NONE).starts_with("the properties of faces \"alpha\" have"));
    let strips = said(NONE, ["", "", ""], ["element tristrips 1\nproperty list int int vertex_indices\n", "3 0 1 2\n"]);
    assert_eq!(strips, "the elements \"tristrips\" have strips of triangles, which are left out; export it with faces");
    let others = said(
        ["property float heat\n", "1"],
        ["property float nx\nproperty float heat\n", "0 1", "0 1"],
        ["element lamp 1\nproperty float heat\nelement rope 0\nproperty float x\n", "1\n"],
    );
    for expected in ["elements \"lamp\"", "properties of vertices \"heat\"", "properties of faces \"nx\", \"heat\""] {
        assert!(others.contains(&format!("the {expected} have other contents, which are left out")), "{others}");
    }
    assert_eq!(others.lines().count(), 3);
    let quality = ["property float quality\n", "1"];
    assert_eq!(said(quality, ["property int flags\n", "0", "0"], NONE), "", "negative control");
    assert_eq!(said([ALPHA, "255"], opaque, NONE), "", "negative control: opaque");
}

#[test]
fn a_file_of_strips_alone_is_refused_with_their_name() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let of = |element: &str| {
        let list = format!("element {element} 1\nproperty list int int vertex_indices\n");
        let text = format!("{head}{list}end_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n");
        import_alone("a.ply", text).map(|_| ()).map_err(|error| error.to_string())
    };
    let refused = of("tristrips").unwrap_err();
    assert!(refused.contains("it has no faces but strips of triangles (\"tristrips\"); export it again"), "{refused}");
    assert!(of("lamp").unwrap_err().contains("holds faces"));
    assert_eq!(of("face"), Ok(()), "negative control");
}
