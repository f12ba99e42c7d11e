//! Materials in the formats of other programs, from end to end.

use crate::common::{Folder, SMALL};
use lapidary_core::scene::Scene;
use lapidary_interchange::import::{import, load_material};
use std::path::PathBuf;

#[test]
fn materials_go_out_in_every_format_and_come_back() {
    let folder = Folder::new();
    folder.write("scene.mtl", "newmtl white\nKd 0.8 0.4 0.2\nPr 0.3\nPm 0.25\nPc 0.5\nPcr 0.125\n".into());
    folder.bake("a.cuts", "");
    for (file, more) in [("a.mtlx", "--surface standard-surface"), ("a.mtl", ""), ("a.glb", ""), ("a.gltf", "")] {
        let said = folder.succeed(&format!("export a.cuts --materials {file} {more}"));
        assert!(said.contains(file) && said.contains("materials"), "{said}");
    }
    let read = |name: &str| load_material(&folder.path(name), &mut Scene::default(), &Default::default());
    let (document, warnings) = read("a.mtlx").expect("a document");
    let original = &folder.dataset("a.cuts").scene.materials[0];
    assert_eq!((document.name.as_str(), warnings), ("white", Vec::new()));
    for name in ["specular_roughness", "base_metalness", "coat_weight", "coat_roughness"] {
        let [a, b] = [&document, original].map(|material| material.parameters.number(name));
        assert!((a - b).abs() < 1e-6 && b > 0.0, "{name}: {a} {b}");
    }
    let of_glb = import(&folder.path("a.glb")).expect("a scene").scene;
    assert_eq!(of_glb.mesh.triangles.len(), folder.dataset("a.cuts").scene.mesh.triangles.len());
    assert!((of_glb.materials[0].parameters.number("coat_weight") - 0.5).abs() < 1e-6);
    folder.succeed("render a.cuts --env studio --size 16x12 --backend cpu --material a.mtlx#white --out a.png");
    for (options, words) in [
        ("export a.cuts --materials a.fbx", "ends in none of .mtlx"),
        ("export a.cuts --materials b.glb --original scene.obj", "scene.obj"),
        ("export a.cuts --materials a.mtlx --material a.mtlx", "over an input"),
        ("render a.cuts --env studio --material a.mtlx#gold --out b.png", "no material \"gold\", but \"white\""),
    ] {
        let message = folder.fail(options);
        assert!(message.contains(words), "{options}: {message}");
    }
}

#[test]
fn variants_are_listed_and_baked_and_the_file_is_written_back_with_them() {
    let folder = Folder::new();
    let data = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    folder.write(
        "shoe.gltf",
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["KHR_materials_variants"],
            "extensions": {{"KHR_materials_variants": {{"variants": [{{"name": "red"}}, {{"name": "blue"}}]}}}},
            "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0, "extensions": {{"KHR_materials_variants":
                {{"mappings": [{{"material": 0, "variants": [0]}}, {{"material": 1, "variants": [1]}}]}}}}}}]}}],
            "buffers": [{{"byteLength": 36, "uri": "{data}"}}], "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}}],
            "materials": [{{"name": "leather"}}, {{"name": "suede"}}]}}"#
        ),
    );
    let info: serde_json::Value = serde_json::from_str(&folder.succeed("info shoe.gltf --json")).expect("JSON");
    assert_eq!(info["variants"], serde_json::json!(["red", "blue"]));
    assert!(folder.succeed("info shoe.gltf").contains("variant    blue"));
    folder.succeed(&format!("bake shoe.gltf --variant blue -o a.cuts {SMALL}"));
    let scene = folder.dataset("a.cuts").scene;
    assert_eq!(scene.materials[scene.mesh.triangle_material[0] as usize].name, "suede");
    let message = folder.fail(&format!("bake shoe.gltf --variant green -o b.cuts {SMALL}"));
    assert!(message.contains("no material variant \"green\"; it has \"red\", \"blue\""), "{message}");
    folder.succeed("export a.cuts --materials out.gltf --original shoe.gltf --roughness 0.25");
    let path: PathBuf = folder.path("out.gltf");
    let back = import(&path).expect("a scene");
    assert_eq!(back.report.variants, ["red", "blue"]);
    assert!(back.scene.materials.iter().all(|material| material.parameters.number("roughness") == 0.25));
}
