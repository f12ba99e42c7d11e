//! Whatever numbers a file has, the scene's numbers are in range, or the file is refused by name.

use super::{gltf::Gltf, *};
use lapidary_core::{
    bounds::{MOST_COORDINATE, is_within_reach},
    mesh::LEAST_DIAGONAL,
    texture::{Texels, TextureSlot},
};
use proptest::prelude::*;

/// Checks that every number of a scene is finite and in its range.
fn check_in_range(imported: &Imported) {
    check_valid(imported);
    let scene = &imported.scene;
    assert!(scene.mesh.positions.iter().all(|p| is_within_reach(*p)));
    assert!(scene.mesh.bounds().diagonal() >= LEAST_DIAGONAL);
    assert!(scene.mesh.uvs.iter().all(|uv| uv.abs().max_element() <= MOST_COORDINATE));
    for material in &scene.materials {
        assert_eq!(material.parameters, material.parameters.clone().sanitized());
        for slot in material.maps.slots() {
            let numbers = [slot.scale.x, slot.scale.y, slot.offset.x, slot.offset.y, slot.rotation, slot.strength];
            assert!(numbers.iter().all(|x| x.abs() <= TextureSlot::MOST), "{slot:?}");
        }
    }
    for texture in &scene.textures {
        let Texels::F32(texels) = &texture.texels else { continue };
        assert!(texels.iter().flatten().all(|x| x.abs() <= Texels::MOST));
    }
    assert!(scene.cameras.iter().all(|camera| camera.is_valid()));
    for light in &scene.lights {
        assert_eq!(light.validate(), Ok(()));
        assert!(is_within_reach(light.position) && is_within_reach(light.target), "{light:?}");
    }
}

/// Checks a scene, or the refusal of its file.
fn check(name: &str, contents: impl AsRef<[u8]>) -> Option<Imported> {
    match import_alone(name, contents) {
        Ok(imported) => {
            check_in_range(&imported);
            Some(imported)
        }
        Err(error) => {
            assert!(error.to_string().ends_with(&format!("{name})")), "{error}");
            None
        }
    }
}

#[test]
fn scenes_that_were_written_with_null_for_a_number_are_repaired_aloud() {
    let imported = check("rotation.gltf", include_bytes!("broken/rotation.gltf")).unwrap();
    let warnings = imported.report.warnings.join("\n");
    assert!(warnings.contains("unit quaternion"), "{warnings}");
    let imported = check("texture-scale.glb", include_bytes!("broken/texture-scale.glb")).unwrap();
    let warnings = imported.report.warnings.join("\n");
    assert!(warnings.contains("out of range"), "{warnings}");
}

#[test]
fn scenes_of_an_extreme_scale_are_refused_with_the_number_and_the_remedy() {
    let scaled = |scale: &str| {
        CUBE.lines().fold(String::new(), |obj, line| {
            let scaled = if line.starts_with('v') { line.replace('1', scale) } else { line.into() };
            obj + &scaled + "\n"
        })
    };
    for (scale, words) in [
        ("1e12", "1e12"),
        ("3e38", "3e38"),
        ("1e-45", "0e0 m across"),
        ("1e-8", "1.7320508e-8"),
        ("1e-46", "0e0 m across"),
    ] {
        let message = import_alone("x.obj", scaled(scale)).unwrap_err().to_string();
        for part in [words, "scale the scene", "x.obj)"] {
            assert!(message.contains(part), "{scale}: {message}");
        }
    }
    for scale in ["1e-5", "1", "1e9"] {
        check("x.obj", scaled(scale)).unwrap();
    }
}

#[test]
fn a_vertex_far_away_that_no_triangle_uses_is_dropped() {
    let ply = |face: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1e30 0 0\n{face}\n"
        )
    };
    assert_eq!(check("x.ply", ply("3 0 1 2")).unwrap().report.unreferenced_vertices, 1);
    assert!(check("x.ply", ply("3 0 1 3")).is_none(), "negative control: one that a triangle uses");
}

#[test]
fn a_picture_that_is_not_finite_is_repaired_aloud() {
    let files = Files::new();
    let image = lapidary_core::image::Image::from_fn([2, 1], |x, _| Vec3::new(0.5, [f32::NAN, 1e30][x as usize], 0.25));
    lapidary_interchange::image::write(&image, &files.0.path().join("odd.exr")).unwrap();
    files.add("a.mtl", "newmtl m\nmap_Pr odd.exr\n");
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    let imported = import(&files.add("a.obj", obj)).unwrap();
    check_in_range(&imported);
    let warnings = imported.report.warnings.join("\n");
    assert!(warnings.contains("2 texels of the texture \"odd.exr\""), "{warnings}");
}

/// Numbers as in files, mostly extreme ones.
fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        (-2.0..2.0f64).prop_map(|x| x.to_string()),
        any::<f32>().prop_filter("JSON has none other", |x| x.is_finite()).prop_map(|x| format!("{x:e}")),
        (-330..309i32).prop_map(|e| format!("-3e{e}")),
        prop::sample::select(vec!["0", "1", "-0.0", "1e-45", "1e308", "-1e308", "9007199254740992", "1e39", "65504"])
            .prop_map(str::to_owned),
    ]
}

fn numbers(count: usize) -> impl Strategy<Value = Vec<String>> {
    // Most stay as in a valid file, so that many files get far.
    let kept = prop_oneof![3 => Just(None), 1 => number().prop_map(Some)];
    prop::collection::vec(kept, count).prop_map(|numbers| numbers.into_iter().map(Option::unwrap_or_default).collect())
}

/// Replaces each `@GOOD@` in `text` by a number; an empty one becomes GOOD.
fn filled(text: &str, numbers: &[String]) -> String {
    let places = text.split('@').enumerate();
    let mut numbers = numbers.iter();
    places
        .map(|(i, part)| {
            let number = (i % 2 == 1).then(|| numbers.next().expect("a number for each place"));
            number.filter(|number| !number.is_empty()).cloned().unwrap_or_else(|| part.to_owned())
        })
        .collect()
}

const GLTF: Gltf = Gltf {
    nodes: r#"[{"mesh": 0, "children": [1, 2, 3, 4], "rotation": [@0@, @0@, @0@, @1@], "translation": [@0@, @0@, @0@],
        "scale": [@1@, @1@, @1@]}, {"camera": 0, "translation": [@0@, @1@, @3@]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [@0@, @1@, @0@]},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}, "rotation": [@0.5@, @0@, @0@, @0.8@]},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}, "matrix": [@1@, 0, 0, 0, 0, @1@, 0, 0, 0, 0, @1@, 0, 0, @1@, 0, 1]}]"#,
    primitive: r#""indices": 1, "material": 0"#,
    rest: r#", "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior", "KHR_materials_specular"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "color": [@1@, @1@, @1@], "intensity": @5@, "range": @9@},
            {"type": "spot", "intensity": @5@, "spot": {"innerConeAngle": @0.1@, "outerConeAngle": @0.5@}},
            {"type": "directional", "intensity": @2@}]}},
        "cameras": [{"type": "perspective", "perspective": {"yfov": @0.7@, "znear": @0.1@, "aspectRatio": @1@}}],
        "images": [{"uri": "gone.png"}], "textures": [{"source": 0}],
        "materials": [{"emissiveFactor": [0, 0, 0],
            "extensions": {"KHR_materials_ior": {"ior": @1.5@}, "KHR_materials_specular": {"specularFactor": @1@, "specularColorFactor": [@1@, @1@, @1@]}},
            "normalTexture": {"index": 0, "scale": @0.5@,
                "extensions": {"KHR_texture_transform": {"scale": [@3@, @4@], "offset": [@0.25@, @0@], "rotation": @1@}}},
            "pbrMetallicRoughness": {"baseColorFactor": [@0.1@, @0.2@, @0.3@, @1@], "roughnessFactor": @0.4@, "metallicFactor": @0.6@,
                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [@2@, @2@], "rotation": @0.5@}}}}}]"#,
};

const OBJ: &str = "mtllib a.mtl\nv @0@ @0@ @0@\nv @1@ @0@ @0@\nv @0@ @1@ @0@\nv @1@ @1@ @1@\nvt @0@ @0@\nvt @1@ @0@\nvt @1@ @1@\n\
    vn @0@ @0@ @1@\nusemtl m\nf 1/1/1 2/2/1 3/3/1\nf 2/2 3/3 4/1\n";

const MTL: &str = "newmtl m\nKd @0.5@ @0.5@ @0.5@\nKs @0.1@ @0.1@ @0.1@\nNi @1.5@\nNs @30@\nPm @0@\naniso @0@\nd @1@\n\
    map_Kd -s @2@ @3@ 1 -o @0.1@ @0.2@ gone.png\nbump -bm @0.5@ gone.png\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty float z\n\
    property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty double t\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n\
    @0@ @0@ @0@ @0@ @0@ @1@ @0@ @0@\n@1@ @0@ @0@ @0@ @0@ @1@ @1@ @0@\n@0@ @1@ @0@ @0@ @0@ @1@ @0@ @1@\n3 0 1 2\n";

const MATERIAL: &str = r#"{"parameters": {"base_color": [@0.1@, @0.2@, @0.3@], "roughness": @0.5@, "anisotropy": @0.5@, "metalness": @0@,
    "ior": @1.5@, "specular": @1@}, "maps": {"bump": {"file": "a.png", "strength": @0.1@, "scale": [@1@, @1@], "offset": [@0@, @0@],
    "rotation_degrees": @90@}}}"#;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn gltf_scenes_have_numbers_in_range_or_are_refused(numbers in numbers(80)) {
        check("a.gltf", filled(&GLTF.embedded(), &numbers));
    }

    #[test]
    fn obj_scenes_have_numbers_in_range_or_are_refused(obj in numbers(30), mtl in numbers(30)) {
        let files = Files::new();
        files.add("a.mtl", filled(MTL, &mtl));
        match import(&files.add("a.obj", filled(OBJ, &obj))) {
            Ok(imported) => check_in_range(&imported),
            Err(error) => assert!(error.to_string().ends_with("a.obj)"), "{error}"),
        }
    }

    #[test]
    fn ply_scenes_have_numbers_in_range_or_are_refused(numbers in numbers(24)) {
        check("a.ply", filled(PLY, &numbers));
    }

    #[test]
    fn materials_have_numbers_in_range_or_are_refused(numbers in numbers(20)) {
        let files = Files::new();
        files.add_png("a.png", [0.5; 3]);
        let path = files.add("a.json", filled(MATERIAL, &numbers));
        match load_material(&path, &mut Scene::default(), &ImportOptions::default()) {
            Ok((material, _)) => assert_eq!(material, material.clone().sanitized()),
            Err(error) => assert!(error.to_string().ends_with("a.json)"), "{error}"),
        }
    }
}

#[test]
fn the_good_files_of_the_property_tests_are_imported_whole() {
    let none = vec![String::new(); 80];
    let imported = check("a.gltf", filled(&GLTF.embedded(), &none)).unwrap();
    assert_eq!((imported.scene.cameras.len(), imported.scene.lights.len()), (1, 3), "{:?}", imported.report);
    assert!(check("a.obj", filled(OBJ, &none)).is_some() && check("a.ply", filled(PLY, &none)).is_some());
}
