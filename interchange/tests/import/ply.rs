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
