//! Files outside the folder of a scene or a material are named, and read only if allowed.

use super::{gltf::QUAD, *};

/// A folder that contains a scene's folder and a red picture beside it.
fn place() -> Files {
    let files = Files::new();
    files.add_png("red.png", [1.0, 0.0, 0.0]);
    files.add("scene/a.mtl", "newmtl m\nmap_Kd ../red.png\n");
    files.add("scene/a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    files
}

fn with(path: &Path, allow_outside: bool) -> Result<Imported, ImportError> {
    import_with(path, &ImportOptions { allow_outside, ..Default::default() })
}

fn is_red(imported: &Imported) -> bool {
    imported.scene.textures[0].size == [2, 2]
}

/// Checks that a scene's texture is outside: read only if allowed, and named in either case.
fn check_outside(path: &Path, name: &str) {
    for allow in [false, true] {
        let imported = with(path, allow).unwrap();
        assert_eq!(is_red(&imported), allow, "{name}");
        assert_eq!(imported.report.outside, [name]);
        let warnings = imported.report.warnings.join("\n");
        assert!(warnings.contains(&format!("the files \"{name}\" are outside")), "{warnings}");
        assert_eq!(warnings.contains("or allow files outside the folder"), !allow, "{warnings}");
    }
}

#[test]
fn textures_above_the_folder_absolute_and_behind_links_are_outside() {
    let files = place();
    let scene = files.0.path().join("scene/a.obj");
    check_outside(&scene, "../red.png");
    let absolute = files.0.path().join("red.png").to_string_lossy().into_owned();
    files.add("scene/a.mtl", format!("newmtl m\nmap_Kd {absolute}\n"));
    check_outside(&scene, &absolute);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../red.png", files.0.path().join("scene/link.png")).unwrap();
        files.add("scene/a.mtl", "newmtl m\nmap_Kd link.png\n");
        check_outside(&scene, "link.png");
    }
}

#[test]
fn a_file_that_was_copied_beside_is_read_in_place_of_one_outside() {
    let files = place();
    let scene = files.0.path().join("scene/a.obj");
    let absolute = files.0.path().join("red.png").to_string_lossy().into_owned();
    for name in ["../red.png", &absolute] {
        files.add("scene/a.mtl", format!("newmtl m\nmap_Kd {name}\n"));
        check_outside(&scene, name);
        let copy = files.add_png("scene/Red.png", [1.0, 0.0, 0.0]);
        let imported = with(&scene, false).unwrap();
        assert!(is_red(&imported) && imported.report.outside.is_empty(), "{name}: {:?}", imported.report);
        assert!(imported.report.warnings.is_empty() && imported.report.files.contains(&copy), "{:?}", imported.report);
        std::fs::remove_file(copy).unwrap();
    }
}

#[test]
fn files_of_the_folder_are_read_whatever_their_path() {
    let files = place();
    files.add_png("scene/maps/red.png", [1.0, 0.0, 0.0]);
    let scene = files.0.path().join("scene/a.obj");
    let absolute = files.0.path().join("scene/maps/red.png");
    for name in ["maps/red.png", "maps/../maps/red.png", "../scene/maps/red.png", &absolute.to_string_lossy()] {
        files.add("scene/a.mtl", format!("newmtl m\nmap_Kd {name}\n"));
        let imported = with(&scene, false).unwrap();
        assert!(is_red(&imported) && imported.report.outside.is_empty(), "{name}: {:?}", imported.report);
    }
}

#[test]
fn a_material_library_outside_is_not_read() {
    let files = place();
    files.add_png("scene/red.png", [1.0, 0.0, 0.0]);
    files.add("b.mtl", "newmtl m\nmap_Kd red.png\n");
    let path = files.add("scene/b.obj", "mtllib ../b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    let [without, allowed] = [false, true].map(|allow| with(&path, allow).unwrap());
    assert!(without.scene.textures.is_empty() && is_red(&allowed));
    assert_eq!(
        (&without.report.outside[..], &allowed.report.outside[..]),
        (&["../b.mtl".to_owned()][..], &["../b.mtl".to_owned()][..])
    );
}

#[test]
fn a_buffer_outside_is_an_error_that_tells_the_remedy() {
    let files = Files::new();
    files.add("quad.bin", super::gltf::Gltf::buffer());
    let path = files.add("scene/a.gltf", QUAD.json(r#"{"byteLength": 92, "uri": "..%2Fquad.bin"}"#));
    let error = with(&path, false).unwrap_err();
    assert!(matches!(&error, ImportError::Outside { names, .. } if names == &["../quad.bin"]), "{error}");
    let message = error.to_string();
    assert!(message.contains("or allow files outside the folder") && message.ends_with("a.gltf)"), "{message}");
    let imported = with(&path, true).unwrap();
    assert_eq!((imported.report.triangles, imported.report.outside), (2, vec!["../quad.bin".to_owned()]));
}

#[test]
fn pictures_of_a_material_outside_are_an_error_that_names_them_all() {
    let files = place();
    files.add_png("blue.png", [0.0, 0.0, 1.0]);
    let json = r#"{"maps": {"bump": {"file": "../red.png"}, "base_color": {"file": "../blue.png"}}}"#;
    let path = files.add("scene/x.json", json);
    let mut scene = Scene::default();
    let message = load_material(&path, &mut scene, &ImportOptions::default()).unwrap_err().to_string();
    for part in ["\"../blue.png\", \"../red.png\"", "or allow files outside the folder", "x.json)"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(scene.textures.is_empty());
    let allowed = ImportOptions { allow_outside: true, ..Default::default() };
    let (_, warnings) = load_material(&path, &mut scene, &allowed).unwrap();
    assert!(scene.textures.len() == 2 && warnings.join("\n").contains("\"../red.png\""), "{warnings:?}");
}
