//! Files with damage in the inputs of an animation: meshes, matrices and weights.

use super::*;
use crate::import::import_with;

#[test]
fn weights_of_more_nodes_and_targets_than_there_is_memory_for_are_refused() {
    // One node shows; the others could be joints.
    let node = |_| json!({ "mesh": 0 });
    let mut file = TestFile::new((0..1000).map(node).collect(), 1);
    file.mesh(&[0., 0., 0., 1., 0., 0., 1., 1., 0.], &[0, 1, 2], &[]);
    file.json["meshes"][0]["primitives"][0]["targets"] = (0..1000).map(|_| json!({})).collect();
    let path = file.write();
    let read = |budget| import_with(&path, &ImportOptions { budget: Some(budget), ..Default::default() }).map(drop);
    let error = read(15_000_000).unwrap_err().to_string();
    assert!(error.contains("MB of memory, but 15 MB are free") && error.contains("moving.gltf"), "{error}");
    assert!(read(40_000_000).is_ok(), "negative control");
}

#[test]
fn a_mesh_that_was_damaged_after_its_bake_is_refused() {
    type Damage = fn(&mut TestFile) -> (&'static str, usize);
    let damages: [(Damage, &str); 2] = [
        (|file| ("indices", file.shorts(&[0, 1, 99], "SCALAR")), "99"),
        (|file| ("POSITION", file.floats(&[f32::NAN; 60], "VEC3")), "not a finite number"),
    ];
    for (damage, said) in damages {
        let mut file = bending_bar();
        let (_, baked) = bound(&mut file);
        let (key, accessor) = damage(&mut file);
        let primitive = &mut file.json["meshes"][0]["primitives"][0];
        *if key == "indices" { &mut primitive[key] } else { &mut primitive["attributes"][key] } = json!(accessor);
        for key in ["min", "max"] {
            file.json["accessors"][accessor][key] = json!([0, 0, 0]);
        }
        let path = file.write();
        let animation = animation::read(&path, &ImportOptions::default());
        let error =
            animation.and_then(|animation| Ok(BoundAnimation::new(animation, &baked)?)).unwrap_err().to_string();
        assert!(error.contains(said) && error.contains("moving.gltf"), "{error}");
    }
}

/// The bending bar with inverse bind matrices in a sparse accessor: it stores only the second, or both without a base.
fn sparsely_bound(has_base: bool) -> (TestFile, usize) {
    let mut file = bending_bar();
    let stored = file.json["skins"][0]["inverseBindMatrices"].as_u64().unwrap() as usize;
    let upper = file.floats(&Mat4::from_translation(Vec3::NEG_Y).to_cols_array(), "MAT4");
    let indices = file.shorts(if has_base { &[1] } else { &[0, 1] }, "SCALAR");
    let sparse = file.floats(&Mat4::IDENTITY.to_cols_array().repeat(2), "MAT4");
    let view = |file: &TestFile, accessor: usize| file.json["accessors"][accessor]["bufferView"].clone();
    file.json["accessors"][sparse]["sparse"] = json!({
        "count": if has_base { 1 } else { 2 },
        "indices": { "bufferView": view(&file, indices), "componentType": 5123 },
        "values": { "bufferView": view(&file, if has_base { upper } else { stored }) },
    });
    if !has_base {
        file.json["accessors"][sparse].as_object_mut().unwrap().remove("bufferView");
    }
    file.json["skins"][0]["inverseBindMatrices"] = json!(sparse);
    (file, sparse)
}

#[test]
fn inverse_bind_matrices_may_be_sparse() {
    for has_base in [true, false] {
        let (mut file, _) = sparsely_bound(has_base);
        let (animation, scene) = bound(&mut file);
        assert!((scene.mesh.bounds().max.y - 2.0).abs() < 1e-5);
        let expected = scene.mesh.positions.iter().map(|&p| bent(p, FRAC_PI_2));
        assert!(farthest(&at(&animation, 2.0, &scene).positions, expected) < 1e-5);
    }
    let (mut file, sparse) = sparsely_bound(true);
    file.json["accessors"][sparse].as_object_mut().unwrap().remove("sparse");
    assert!(bound(&mut file).1.mesh.bounds().max.y > 2.5, "negative control: what it stands on");
}

#[test]
fn a_vertex_at_no_place_is_bound_to_nothing() {
    let mut file = bending_bar();
    let (_, mut scene) = bound(&mut file);
    scene.mesh.positions[3].x = f32::NAN;
    let animation = animation::read(&file.write(), &ImportOptions::default()).unwrap();
    let error = BoundAnimation::new(animation, &scene).unwrap_err().to_string();
    assert!(error.contains("\"bar\"") && error.contains("bake it again"), "{error}");
}

#[test]
fn a_file_that_is_infinitely_large_at_rest_is_not_that_of_the_scene() {
    let mut file = bending_bar();
    let (_, scene) = bound(&mut file);
    for size in [1e30, 3e38] {
        file.json["nodes"][1]["scale"] = json!([size, size, size]);
        file.json["nodes"][2]["scale"] = json!([size, size, size]);
        let animation = animation::read(&file.write(), &ImportOptions::default()).unwrap();
        let error = BoundAnimation::new(animation, &scene).unwrap_err().to_string();
        assert!(error.contains("\"bar\"") && error.contains("bake it again"), "{error}");
    }
}

#[test]
fn no_comparison_takes_what_is_no_number_for_near() {
    let nowhere = [Vec3::ZERO, Vec3::NAN, Vec3::ONE];
    let distance = farthest(&nowhere, [Vec3::ZERO; 3]);
    assert!(distance.is_nan() && farthest(&nowhere[2..], [Vec3::ZERO]) > 1.0);
}
