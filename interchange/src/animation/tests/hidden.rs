//! Nodes without an extent at rest, and keyframes that are stored sparsely.

use super::*;

const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
const TURN: [f32; 4] = [0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2];

/// A square, and one of scale 0 beside it that a clip brings up in a second.
fn popping() -> TestFile {
    let nodes = json!([
        { "name": "floor", "mesh": 0 },
        { "name": "pop", "mesh": 1, "translation": [10, 2, 3], "rotation": TURN, "scale": [0, 0, 0] },
    ]);
    let mut file = TestFile::new(nodes, 2);
    for _ in 0..2 {
        file.mesh(&SQUARE, &[0, 1, 2, 0, 2, 3], &[]);
    }
    file.clip("pop", 1, "scale", &[0.0, 1.0], &[0., 0., 0., 1., 1., 1.], "LINEAR");
    file
}

/// Positions and normals of the second object.
fn of_pop(mesh: &Mesh) -> Vec<(Vec3, Vec3)> {
    let vertices: std::collections::BTreeSet<u32> =
        (0..mesh.triangles.len()).filter(|&t| mesh.triangle_object[t] == 1).flat_map(|t| mesh.triangles[t]).collect();
    vertices.into_iter().map(|v| (mesh.positions[v as usize], mesh.normals[v as usize])).collect()
}

#[test]
fn an_object_without_extent_at_rest_shows_when_a_clip_brings_it_up() {
    let (bound, scene) = bound(&mut popping());
    assert_eq!(scene.mesh.triangles.len(), 4);
    let place = Vec3::new(10.0, 2.0, 3.0);
    for (position, normal) in of_pop(&scene.mesh) {
        assert!(position.distance(place) < 2e-3 && (normal - Vec3::X).length() < 1e-3, "{position} {normal}");
    }
    let up = of_pop(&at(&bound, 1.0, &scene));
    assert_eq!(up.len(), 4);
    let turn = Quat::from_array(TURN);
    for corner in SQUARE.chunks_exact(3) {
        let expected = place + turn * Vec3::from_slice(corner);
        let nearest = up.iter().map(|(position, _)| position.distance(expected)).fold(f32::INFINITY, f32::min);
        assert!(nearest < 1e-4, "{expected}: {nearest} m");
    }
    assert!(up.iter().all(|(_, normal)| (*normal - Vec3::X).length() < 1e-3));
    let down = of_pop(&at(&bound, 0.0, &scene));
    assert!(down.iter().all(|(position, normal)| position.distance(place) < 2e-3 && normal.is_finite()));
}

#[test]
fn an_object_without_extent_that_nothing_brings_up_is_dropped() {
    let mut file = popping();
    file.json["animations"][0]["channels"][0]["target"]["path"] = json!("translation");
    let imported = import(&file.write()).unwrap();
    assert_eq!((imported.scene.mesh.triangles.len(), imported.report.degenerate_triangles), (2, 2));
    assert_eq!(imported.report.warnings, [] as [String; 0]);
    let imported = import(&popping().write()).unwrap();
    assert!(
        imported.report.warnings[0].contains("\"pop\" have a scale of 0 at rest"),
        "{:?}",
        imported.report.warnings
    );
}

#[test]
fn keyframes_may_be_sparse_over_zeros() {
    let mut file = TestFile::new(json!([{ "name": "A", "mesh": 0 }]), 1);
    file.mesh(&SQUARE, &[0, 1, 2, 0, 2, 3], &[]);
    file.clip("up", 0, "translation", &[0.0, 1.0], &[0., 0., 0., 0., 0., 1.], "LINEAR");
    let output = file.json["animations"][0]["samplers"][0]["output"].as_u64().unwrap() as usize;
    let index = file.shorts(&[1, 0], "SCALAR");
    let value = file.floats(&[0., 0., 1.], "VEC3");
    let view = |accessor: usize, json: &serde_json::Value| json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": view(index, &file.json), "componentType": 5123 },
        "values": { "bufferView": view(value, &file.json) },
    });
    file.json["accessors"][output] = json!({ "componentType": 5126, "count": 2, "type": "VEC3", "sparse": sparse });
    let (bound, scene) = bound(&mut file);
    assert!(at(&bound, 1.0, &scene).positions.iter().all(|p| (p.z - 1.0).abs() < 1e-6));
    assert!(at(&bound, 0.5, &scene).positions.iter().all(|p| (p.z - 0.5).abs() < 1e-6));
}
