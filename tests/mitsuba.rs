//! `export` from end to end, without Mitsuba: files, options, bad input.

use crate::common::Folder;
use lapidary_interchange::{image, import::import};
use std::{fs, path::Path};

fn scene_xml(folder: &Folder) -> String {
    fs::read_to_string(folder.path("m/scene.xml")).expect("a scene")
}

/// Every element that is opened is closed, in order.
fn assert_well_formed(text: &str) {
    let mut open = Vec::new();
    for tag in text.split('<').skip(1).map(|rest| rest.split('>').next().expect("an end")) {
        let name = tag.trim_start_matches('/').split_whitespace().next().expect("a name").trim_end_matches('/');
        match tag {
            _ if tag.starts_with('?') || tag.ends_with('/') => {}
            _ if tag.starts_with('/') => assert_eq!(open.pop(), Some(name), "{text}"),
            _ => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}: {text}");
}

fn triangles(path: &Path) -> usize {
    import(path).expect("a mesh").scene.mesh.triangles.len()
}

#[test]
fn a_scene_is_written_whole_and_its_meshes_are_those_of_the_dataset() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let said = folder.succeed("export a.cuts --env studio --rotate 30 --intensity 2 --size 40x30 --mitsuba m");
    let mesh = folder.dataset("a.cuts").scene.mesh;
    assert!(said.contains(&format!("{} triangles", mesh.triangles.len())), "{said}");
    for name in ["scene.xml", "materials.xml", "materials-exact.xml"] {
        assert_well_formed(&fs::read_to_string(folder.path(&format!("m/{name}"))).expect("a file"));
    }
    let scene = scene_xml(&folder);
    for part in [
        "envmap",
        "\"scale\" value=\"2\"",
        "value=\"40\"",
        "\"max_depth\" value=\"2\"",
        "\"hide_emitters\" value=\"false\"",
    ] {
        assert!(scene.contains(part), "{part}: {scene}");
    }
    let meshes: Vec<_> =
        fs::read_dir(folder.path("m/meshes")).expect("meshes").map(|e| e.expect("one").path()).collect();
    assert_eq!(meshes.iter().map(|path| triangles(path)).sum::<usize>(), mesh.triangles.len());
    assert!(image::read(&folder.path("m/environment.exr")).is_ok());
}

#[test]
fn lights_bounces_and_background_follow_the_options() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    folder.write(
        "lamps.json",
        r#"{"lights": [
            {"kind": "point", "position": [0, 3, 0], "intensity": [1, 2, 3]},
            {"kind": "spot", "position": [0, 3, 0], "target": [0, 0, 0], "intensity": [1, 1, 1], "cone_degrees": 30, "penumbra_degrees": 5},
            {"kind": "directional", "position": [0, 3, 0], "target": [0, 0, 0], "intensity": [1, 1, 1]},
            {"kind": "rectangle", "position": [0, 3, 0], "target": [0, 0, 0], "intensity": [1, 1, 1], "width": 1, "height": 1},
            {"kind": "point", "position": [9, 9, 9], "intensity": [0, 0, 0]}
        ]}"#
            .into(),
    );
    let output = folder.run("export a.cuts --lights lamps.json --bounces 3 --background black --mitsuba m");
    let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && warnings.contains("penumbra") && warnings.contains("rectangular"), "{warnings}");
    let scene = scene_xml(&folder);
    assert_well_formed(&scene);
    for (part, count) in
        [("type=\"point\"", 1), ("type=\"spot\"", 1), ("type=\"directional\"", 1), ("type=\"area\"", 1), ("envmap", 0)]
    {
        assert_eq!(scene.matches(part).count(), count, "{part}");
    }
    assert!(scene.contains("\"max_depth\" value=\"5\"") && scene.contains("\"hide_emitters\" value=\"true\""));
}

#[test]
fn surfaces_that_shine_are_lights() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    folder.write("lamp.json", r#"{"model": "lambert", "parameters": {"emission_luminance": 2}}"#.into());
    let export = |options: &str| {
        let output = folder
            .run(&format!("export a.cuts --lights none --background black --material lamp.json {options} --mitsuba m"));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{options}: {said}");
        (scene_xml(&folder), said)
    };
    let depth = |depth: u32| format!("\"max_depth\" value=\"{depth}\"");
    let (scene, said) = export("--env none --bounces 1");
    assert_well_formed(&scene);
    assert!(scene.contains("\"radiance\" value=\"2, 2, 2\"") && scene.contains(&depth(2)), "{scene}");
    assert!(scene.contains("\"hide_emitters\" value=\"false\"") && !said.contains("bounce"), "{said}");
    let (scene, said) = export("--env studio --bounces 1");
    assert!(scene.contains(&depth(3)) && said.contains("one bounce more") && said.contains("as background"), "{said}");
    let (scene, said) = export("--env studio --components environment");
    assert!(!scene.contains("\"area\"") && scene.contains("\"hide_emitters\" value=\"true\""), "{scene}");
    assert!(!said.contains("bounce"), "{said}");
    let message = folder.fail("export a.cuts --env none --material lamp.json --components indirect --mitsuba m");
    assert!(message.contains("environment and direct"), "{message}");
}

#[test]
fn what_cannot_be_exported_is_told_before_anything_is_written() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    folder.write("file", String::new());
    for (options, words) in [
        ("--env studio --mitsuba file/below", "would lie in something that is no folder"),
        ("--env none --lights none --mitsuba m", "no light"),
        ("--env studio --components indirect --mitsuba m", "environment and direct"),
        ("--env studio --camera nobody --mitsuba m", "nobody"),
    ] {
        let message = folder.fail(&format!("export a.cuts {options}"));
        assert!(message.contains(words), "{options}: {message}");
    }
    assert!(!folder.path("m/scene.xml").exists());
    assert!(folder.fail("reference a.cuts --seed 1 --out a.exr").contains("--kind path"));
    assert!(folder.fail("reference a.cuts --places shifted --out a.exr").contains("--kind path"));
}
