//! OBJ and MTL, and missing files.

use super::*;
use lapidary_core::brdf::{BrdfModel, OpenPbrParameters};

#[test]
fn unknown_extensions_missing_files_and_absurd_sizes_are_told_apart() {
    let error = import_alone("a.fbx", "x").unwrap_err();
    assert!(
        matches!(error, ImportError::Unsupported { .. }) && error.to_string().contains(".obj, .gltf, .glb or .ply")
    );
    assert!(matches!(import(Path::new("/nowhere/a.obj")), Err(ImportError::Io { .. })));
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n";
    let error = import_alone("a.ply", header).unwrap_err();
    assert!(matches!(error, ImportError::TooLarge { count: 4_000_000_000, .. }), "{error}");
}

#[test]
fn obj_quirks_are_understood() {
    let obj = "mtllib my lib.mtl\r\no Left part\r\nv 0 0 0 # origin\r\nv 1 0 0\r\nv 0 0 1\r\nusemtl  red wood\r\n\
        f 1 \\\r\n 3 2\r\no Right\r\nusemtl lost\r\nf -3 -1 -2 # again\r\n";
    let files = Files::new();
    files.add("My Lib.MTL", "newmtl red wood\r\nKd 1 0 0\r\nmap_Kd -s 2 2 2 Textures\\WOOD one.png\r\nd 0.5\r\n");
    files.add_png("textures/wood One.png", [0.5; 3]);
    let imported = import(&files.add("a.obj", obj)).unwrap();
    check_valid(&imported);
    let scene = &imported.scene;
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["Left part", "Right"]);
    assert_eq!((scene.materials[0].name.as_str(), scene.materials[1].name.as_str()), ("red wood", "lost"));
    assert_eq!(scene.mesh.triangle_material, [0, 1]);
    let slot = scene.materials[0].maps.get("base_color").unwrap();
    assert_eq!((slot.scale, slot.color_space), (Vec2::splat(2.0), ColorSpace::Srgb));
    assert_eq!(scene.textures[0].size, [2, 2]);
    assert!(!scene.textures[0].encoded.is_empty());
    let warnings = imported.report.warnings.join("\n");
    assert!(warnings.contains("\"lost\" are in no material library"));
    assert_eq!(imported.report.warnings.len(), 1, "{warnings}");
    let opacity = |material: usize| scene.materials[material].parameters.number("geometry_opacity");
    assert_eq!([opacity(0), opacity(1)], [0.5, 1.0]);
}

#[test]
fn opacity_is_read_under_all_its_names() {
    let files = Files::new();
    let library = "newmtl d\nd 0.25\nnewmtl tr\nTr 0.25\nnewmtl both\nTr 1\nd 1\n\
        newmtl gray\nmap_d gray.png\nnewmtl alpha\nmap_d -s 2 2 1 alpha.png\nnewmtl said\nmap_d -imfchan g alpha.png\n";
    files.add("a.mtl", library);
    files.add_png("gray.png", [0.5; 3]);
    files.add_rgba("alpha.png", [1, 1], &[255, 255, 255, 0]);
    let mut obj = String::from("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\n");
    let names = ["d", "tr", "both", "gray", "alpha", "said"];
    names.iter().for_each(|name| obj += &format!("usemtl {name}\nf 1 3 2\n"));
    let imported = import(&files.add("a.obj", obj)).unwrap();
    assert_eq!(imported.report.warnings, [""; 0]);
    let materials = &imported.scene.materials;
    let opacity = |i: usize| materials[i].parameters.number("geometry_opacity");
    assert_eq!([0, 1, 2, 3, 4, 5].map(opacity), [0.25, 0.75, 1.0, 1.0, 1.0, 1.0]);
    let map = |i: usize| materials[i].maps.get("geometry_opacity");
    let channels = [0, 3, 4, 5].map(|i| map(i).map(|slot| slot.channel));
    assert_eq!(channels, [None, Some(Channel::R), Some(Channel::A), Some(Channel::G)]);
    assert_eq!(map(4).unwrap().scale, Vec2::splat(2.0));
}

#[test]
fn a_hundred_thousand_missing_libraries_are_told_at_once_and_in_one_sentence() {
    let libraries: String = (0..100_000).map(|i| format!("mtllib {i}.mtl\n")).collect();
    let start = std::time::Instant::now();
    let imported = import_alone("a.obj", format!("{libraries}v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n")).unwrap();
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    let told = imported.report.warnings.iter().filter(|warning| warning.contains("and 99995 more")).count();
    assert_eq!(told, 1, "{:?}", imported.report.warnings.len());
}

#[test]
fn a_face_of_many_corners_and_a_scan_take_what_they_are() {
    // A strip of squares: half a vertex for a triangle.
    let count = 20_000;
    let rows: String = (0..=count).map(|i| format!("v {i} 0 0\nv {i} 0 1\n")).collect();
    let faces: String =
        (0..count).map(|i| 2 * i).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 4, i + 3)).collect();
    let folder = Files::new();
    let path = folder.add("a.obj", rows + &faces);
    let within = |bytes| import_with(&path, &ImportOptions { budget: Some(bytes), ..Default::default() });
    assert_eq!(within(1000 * 2 * count).unwrap().report.triangles as u64, 2 * count);
    assert!(matches!(within(300 * 2 * count), Err(ImportError::Memory { .. })), "negative control");
}

#[test]
fn missing_libraries_and_textures_are_visible_and_reported() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl m\nf 1 3 2\n";
    let imported = import_alone("a.obj", format!("mtllib gone.mtl\n{triangle}")).unwrap();
    let warnings = imported.report.warnings.join("\n");
    assert!(warnings.contains("\"gone.mtl\"") && warnings.contains("\"m\""), "{warnings}");

    let files = Files::new();
    files.add("a.mtl", "newmtl m\nmap_Kd gone.png\nmap_Pr broken.png\n");
    files.add("broken.png", "not a picture");
    let imported = import(&files.add("a.obj", format!("mtllib a.mtl\n{triangle}"))).unwrap();
    check_valid(&imported);
    assert_eq!(imported.scene.textures.len(), 2);
    assert!(imported.scene.textures.iter().all(|t| t.size == [8, 8] && t.encoded.is_empty()));
    assert_eq!(imported.report.warnings.len(), 2);
    assert!(imported.report.warnings[0].contains("\"gone.png\" was replaced"));
}

#[test]
fn bump_maps_that_are_blue_are_normal_maps_and_a_file_is_loaded_once() {
    let files = Files::new();
    files.add_png("gray.png", [0.2; 3]);
    files.add_png("blue.png", [0.214, 0.214, 1.0]);
    files.add(
        "a.mtl",
        "newmtl a\nbump -bm 0.5 gray.png\nmap_Kd gray.png\nnewmtl b\nmap_Bump -bm 0.25 blue.png\nnewmtl c\nnorm blue.png\n",
    );
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl a\nf 1 3 2\nusemtl b\nf 1 3 2\nusemtl c\nf 1 3 2\n";
    let scene = import(&files.add("a.obj", obj)).unwrap().scene;
    assert_eq!(scene.textures.len(), 2);
    let strength = |slot: Option<&lapidary_core::texture::TextureSlot>| slot.map(|s| s.strength);
    let [a, b, c] = [0, 1, 2].map(|i| &scene.materials[i].maps);
    assert_eq!((strength(a.get("bump")), strength(a.get("normal"))), (Some(0.005), None));
    assert_eq!((strength(b.get("bump")), strength(b.get("normal"))), (None, Some(0.25)));
    assert_eq!((strength(c.get("bump")), strength(c.get("normal"))), (None, Some(1.0)));
}

#[test]
fn curves_of_free_form_are_left_out_aloud() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let told = |more: &str| import_alone("a.obj", format!("{mesh}{more}")).unwrap().report.warnings.join("\n");
    let surface = told("cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 1\nparm u 0 1\nend\n");
    assert!(surface.contains("curves and surfaces of free form, which are left out; convert them"), "{surface}");
    assert_eq!(told("o end\ng surf\n# curv\n"), "", "negative control");
}

#[test]
fn statements_of_other_renderers_are_left_out_aloud_each_once() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let told = |more: &str| import_alone("a.obj", format!("{more}\n{mesh}")).unwrap().report.warnings.join("\n");
    for (statements, meaning) in [
        ("maplib a.map\nusemap wood", "maps of faces"),
        ("call b.obj", "calls of other files"),
        ("shadow_obj b.obj\ntrace_obj c.obj", "other objects in shadows and reflections"),
    ] {
        let warning = told(&format!("{statements}\n{statements}"));
        assert!(warning.starts_with(&format!("parts of the file have {meaning}, which are left out")), "{warning}");
        assert_eq!(warning.lines().count(), 1, "{warning}");
    }
    assert_eq!(told("maplib a\ncall b.obj\nvp 0 0").lines().count(), 3);
    assert_eq!(told("mg 1 2\nlod 1"), "", "negative control: polygons have no use for them");
}

#[test]
fn coats_and_sheen_of_a_library_become_openpbr() {
    let files = Files::new();
    files.add("a.mtl", "newmtl m\nKd 0.1 0.2 0.3\nPr 0.4\nPm 0.5\nPc 0.7\nPcr 0.2\nPs 0.3\nnewmtl plain\nPr 0.4\n");
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nusemtl m\nf 1 3 2\nusemtl plain\nf 1 3 2\n";
    let materials = import(&files.add("a.obj", obj)).unwrap().scene.materials;
    let p = OpenPbrParameters::from(&materials[0].parameters);
    assert_eq!((p.base_color, p.specular_roughness, p.base_metalness), (Vec3::new(0.1, 0.2, 0.3), 0.4, 0.5));
    assert_eq!((p.coat_weight, p.coat_roughness, p.fuzz_weight), (0.7, 0.2, 0.3));
    assert_eq!([&materials[0], &materials[1]].map(|m| m.model), [BrdfModel::OpenPbr, BrdfModel::Ggx]);
}

#[test]
fn partly_missing_normals_are_rebuilt_with_a_warning() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nvn 0 -1 0\nf 1//1 3//1 2//1\nf 2 3 4\n";
    let imported = import_alone("a.obj", obj).unwrap();
    check_valid(&imported);
    assert!(imported.scene.mesh.normals.iter().all(|n| *n == Vec3::Y));
    assert!(imported.report.warnings[0].contains("only some faces of \"a\" have normals"));
}
