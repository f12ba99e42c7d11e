//! PLY, truncated and corrupt files of all formats, and random triangles.

use super::{gltf::QUAD, *};

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
            // An OBJ cut between faces is a smaller OBJ, and trailing whitespace is no loss.
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
    let png = lapidary_interchange::image::encode_png(&lapidary_core::image::Image::filled([3, 3], Vec3::ONE));
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
        let coordinate = |random: &mut fastrand::Rng| random.choice([0.0, 1.0, -1.0, 0.5, 1e-20, 1e9]).unwrap();
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
                let ImportError::Mesh { source, .. } = error else { panic!("{error}\n{obj}") };
                // All corners of all faces may be in one place.
                assert!(matches!(source, MeshError::Empty | MeshError::TooSmall { diagonal: 0.0 }), "{source}\n{obj}")
            }
        }
    }
}
