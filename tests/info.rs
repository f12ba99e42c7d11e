//! `info` of scenes, materials and pictures: what of them is left out.

use crate::common::Folder;
use lapidary_core::image::Image;
use lapidary_interchange::image::{self, Layer, LayeredImage, Metadata};
use serde_json::Value;
use std::fs;

fn json(folder: &Folder, file: &str) -> Value {
    serde_json::from_str(&folder.succeed(&format!("info {file} --json"))).expect("JSON")
}

#[test]
fn a_scene_tells_what_of_it_is_left_out() {
    let folder = Folder::new();
    assert!(!folder.succeed("info scene.obj").contains("warning"), "negative control");
    assert_eq!(json(&folder, "scene.obj")["warnings"], serde_json::json!([]), "negative control");
    folder.write("scene.mtl", "newmtl white\nKd 0.8 0.8 0.8\ndisp height.png\n".into());
    let text = folder.succeed("info scene.obj");
    assert!(
        text.contains("warning    the materials \"white\" have the statement disp (displacement), which is left out"),
        "{text}"
    );
    let told = json(&folder, "scene.obj")["warnings"][0].to_string();
    assert!(told.contains("displacement"), "{told}");
}

#[test]
fn materials_and_pictures_tell_what_of_them_is_left_out() {
    let folder = Folder::new();
    let document = "<materialx version=\"1.38\">\n<open_pbr_surface name=\"s\" type=\"surfaceshader\">\n\
        <input name=\"transmission_weight\" type=\"float\" value=\"0.5\"/>\n</open_pbr_surface>\n</materialx>\n";
    folder.write("glass.mtlx", document.into());
    let text = folder.succeed("info glass.mtlx");
    assert!(text.contains("material   s, OpenPBR") && text.contains("not rendered: transmission weight"), "{text}");
    folder.write("glass.mtlx", document.replace("0.5", "0"));
    assert!(!folder.succeed("info glass.mtlx").contains("warning"), "negative control");
    folder.write("gold.json", r#"{"model": "ggx", "parameters": {"roughness": 7}}"#.into());
    assert!(json(&folder, "gold.json")["warnings"][0].to_string().contains("out of range"));

    let sky = Image::from_fn([8, 4], |x, _| glam::Vec3::splat(if x == 0 { f32::INFINITY } else { 1.0 }));
    image::write(&sky, &folder.path("sky.exr")).expect("a writable folder");
    let text = folder.succeed("info sky.exr");
    assert!(text.contains("picture    8 x 4 texels, 32-bit floats\nwarning    4 texels"), "{text}");
    fs::write(folder.path("bad.png"), "no picture").expect("a writable folder");
    for (file, what) in [("bad.png", "bad.png"), ("gone.mtlx", "gone.mtlx"), ("gone.hdr", "gone.hdr")] {
        let message = folder.fail(&format!("info {file}"));
        assert!(message.contains(what), "{message}");
    }
}

#[test]
fn layers_of_a_picture_are_listed_and_chosen_by_name_wherever_a_picture_is_named() {
    let folder = Folder::new();
    let filled = |value| Image::filled([8, 4], glam::Vec3::splat(value));
    let layers = vec![Layer::color("", &filled(1.0)), Layer::color("Half", &filled(0.5))];
    let picture = LayeredImage { size: [8, 4], layers, metadata: Metadata::default() };
    picture.write(&folder.path("a.exr")).expect("a writable folder");
    let text = folder.succeed("info a.exr");
    assert!(text.ends_with("floats\nlayer      RGBA\nof         Half\n"), "{text}");
    let text = folder.succeed("info a.exr#half");
    assert!(text.ends_with("layer      Half\nof         RGBA\n"), "{text}");
    let told = json(&folder, "a.exr");
    assert_eq!((&told["layers"], &told["layer"]), (&serde_json::json!(["RGBA", "Half"]), &"RGBA".into()));
    image::write(&filled(0.5), &folder.path("half.exr")).expect("a writable folder");
    folder.succeed("compare a.exr#Half half.exr --fail-above rmse=1e-6");
    let compared = folder.run("compare a.exr half.exr --fail-above rmse=1e-6");
    assert_eq!(compared.status.code(), Some(3), "negative control");
    let message = folder.fail("compare a.exr#gone half.exr");
    assert!(message.contains("gone") && message.contains("RGBA, Half"), "{message}");
    folder.bake("a.cuts", "");
    let message = folder.fail("render a.cuts --env a.exr#gone --out b.png");
    assert!(message.contains("RGBA, Half"), "{message}");
    folder.succeed("render a.cuts --env a.exr#Half --out b.png");
}

#[test]
fn a_scene_is_chosen_in_scenes_alone() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    image::write(&Image::filled([2, 2], glam::Vec3::ONE), &folder.path("a.png")).expect("a writable folder");
    for file in ["a.cuts", "a.png"] {
        let message = folder.fail(&format!("info {file} --scene night"));
        assert!(message.contains("--scene chooses a scene of a glTF file") && message.contains(file), "{message}");
        folder.succeed(&format!("info {file}"));
    }
    let message = folder.fail("info scene.obj --scene night");
    assert!(message.contains("no scene \"night\"") && message.contains("scene.obj"), "{message}");
}
