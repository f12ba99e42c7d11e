//! `render`, `reference` and `compare` from end to end.

mod common;

use common::{Stage, keys};
use lapidary_core::image::Image;

/// Looks down on box and floor.
const VIEW: &str = "--env sun-sky:50 --eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 48x36";

fn baked() -> Stage {
    let stage = Stage::new();
    stage.bake("a.cuts", "");
    stage
}

#[test]
fn a_picture_is_close_to_both_references_and_a_turned_one_is_not() {
    let stage = baked();
    stage.succeed(&format!("render a.cuts {VIEW} --out a.exr --out a.png --stats stats.json"));
    let stats = stage.json("stats.json");
    assert_eq!(keys(&stats), ["backend", "mean_brdf_evaluations", "mean_merged_nodes", "pixels_shaded", "seconds"]);
    assert_eq!(stats["backend"].as_str(), Some("cpu"));
    stage.succeed(&format!("reference a.cuts {VIEW} --kind samples --out samples.exr"));
    stage.succeed(&format!("reference a.cuts {VIEW} --kind path --spp 64 --out path.exr"));
    stage.succeed(&format!("render a.cuts {VIEW} --rotate 120 --out turned.exr"));
    let error = |test: &str, reference: &str| {
        stage.succeed(&format!("compare {test} {reference} --json m.json"));
        let metrics = stage.json("m.json");
        for key in ["rmse", "rel_rmse", "rel_mse", "psnr", "ssim", "flip"] {
            assert!(metrics[key].is_number(), "{key}");
        }
        metrics["rel_rmse"].as_f64().expect("a number")
    };
    let (near, whole, turned) =
        (error("a.exr", "samples.exr"), error("a.exr", "path.exr"), error("turned.exr", "samples.exr"));
    assert!(near < 0.2 && whole < 0.3, "{near} and {whole}");
    assert!(turned > 2.0 * near, "negative control: {turned}");
}

#[test]
fn bounds_decide_the_exit_code_and_maps_are_written() {
    let stage = baked();
    for (name, roughness) in [("a", 0.3), ("b", 0.6)] {
        stage.succeed(&format!("render a.cuts {VIEW} --roughness {roughness} --metalness 1 --out {name}.exr"));
    }
    let code = |bound: &str| stage.run(&format!("compare a.exr b.exr --fail-above {bound}")).status.code();
    assert_eq!((code("rel_rmse=0.0001"), code("rel_rmse=100"), code("nonsense=1")), (Some(3), Some(0), Some(2)));
    for kind in ["rel", "abs", "flip"] {
        stage.succeed(&format!("compare a.exr b.exr --map {kind} --out {kind}.png"));
        assert!(Image::read(&stage.path(&format!("{kind}.png"))).is_ok());
    }
}

#[test]
fn material_options_and_files_change_the_picture() {
    let stage = baked();
    stage.write(
        "gold.json",
        r#"{"model": "ward", "parameters": {"base_color": [1, 0.7, 0.3], "metalness": 1, "roughness": 0.4}}"#.into(),
    );
    for (name, options) in [
        ("own", ""),
        ("option", "--base-color 1,0.7,0.3 --metalness 1"),
        ("file", "--material gold.json"),
        ("once", "--brdf once --illum-cut 8"),
        ("bright", "--intensity 2"),
    ] {
        stage.succeed(&format!("render a.cuts {VIEW} {options} --out {name}.exr"));
    }
    let read = |name: &str| Image::read(&stage.path(&format!("{name}.exr"))).expect("a picture");
    let own = read("own");
    for name in ["option", "file", "once", "bright"] {
        assert_ne!(read(name), own, "{name}");
    }
    let ratio = read("bright").pixels[900].x / own.pixels[900].x;
    assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn more_samples_a_pixel_smooth_edges_in_all_renderers_alike() {
    let stage = baked();
    stage.succeed(&format!("render a.cuts {VIEW} --aa 4 --out a.exr"));
    stage.succeed(&format!("reference a.cuts {VIEW} --aa 4 --out r.exr"));
    stage.succeed(&format!("render a.cuts {VIEW} --out one.exr"));
    let read = |name: &str| Image::read(&stage.path(name)).expect("a picture");
    let distance =
        |a: &Image, b: &Image| a.pixels.iter().zip(&b.pixels).map(|(a, b)| a.distance_squared(*b)).sum::<f32>();
    let (same, other) = (distance(&read("a.exr"), &read("r.exr")), distance(&read("one.exr"), &read("r.exr")));
    assert!(same < other, "{same} and {other}");
}

#[test]
fn the_bundled_still_life_bakes_and_renders() {
    let stage = Stage::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");
    stage.succeed(&format!("bake {data}/still-life/still-life.gltf -o s.cuts --lights 512 --pilot-clusters 32 --no-tessellate --progress none"));
    stage.succeed(&format!("render s.cuts --env {data}/environments/studio.hdr --size 64x48 --out s.exr"));
    let picture = Image::read(&stage.path("s.exr")).expect("a picture");
    assert!(picture.pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0));
    let mean = picture.pixels.iter().map(|p| p.y).sum::<f32>() / picture.pixels.len() as f32;
    assert!((0.02..5.0).contains(&mean), "{mean}");
}
