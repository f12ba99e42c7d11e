//! Meshes that need repair: normals, tangents, winding, welding, texture coordinates.

use super::*;

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
    // Negative control: with corners of 90 degrees the prism is not smooth around.
    assert_eq!(import_alone("a.obj", prism(4, false)).unwrap().scene.mesh.positions.len(), 16);
}

#[test]
fn one_sharp_edge_in_a_smooth_surface_splits_nothing() {
    // A fan of six triangles around a raised center, with one of its rim points pulled far down: the edges to it are
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
