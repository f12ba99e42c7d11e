//! Bounced light from end to end: the bundled colour box baked with few sources, against traced paths of one bounce.

mod common;

use common::Stage;
use glam::{DVec3, Vec3};
use lapidary_core::image::Image;

/// Few sources, but fine cuts over them.
const BAKE: &str = "--mode indirect --sources 4096 --source-sigma 1 --lights 256 --pilot-clusters 64 \
                    --max-vertices 2500 --progress none";
const VIEW: &str = "--env none --components indirect --size 48x48";
/// Pixels along a side of the squares that are compared: their means hide the noise of the paths.
const SQUARE: usize = 8;

/// The colour box, baked.
fn colour_box() -> Stage {
    let stage = Stage::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");
    stage.succeed(&format!("bake {data}/color-box/color-box.gltf -o box.cuts {BAKE}"));
    stage
}

/// Means over squares of a picture, row by row.
fn squares(stage: &Stage, name: &str) -> Vec<DVec3> {
    let picture = Image::read(&stage.path(name)).expect("a picture");
    let [width, height] = picture.size.map(|n| n as usize / SQUARE);
    let pixel = |x: usize, y: usize| picture.pixels[y * width * SQUARE + x].as_dvec3();
    let mean = |i: usize| {
        let (x, y) = (i % width * SQUARE, i / width * SQUARE);
        let sum: DVec3 = (0..SQUARE * SQUARE).map(|p| pixel(x + p % SQUARE, y + p / SQUARE)).sum();
        sum / (SQUARE * SQUARE) as f64
    };
    (0..width * height).map(mean).collect()
}

/// Relative RMSE of the squares' means, and the ratio of the pictures' means by channel.
fn difference(test: &[DVec3], reference: &[DVec3]) -> (f64, DVec3) {
    let squared: f64 = test.iter().zip(reference).map(|(a, b)| a.distance_squared(*b)).sum();
    let norm: f64 = reference.iter().map(|b| b.length_squared()).sum();
    let sum = |squares: &[DVec3]| squares.iter().sum::<DVec3>();
    ((squared / norm).sqrt(), sum(test) / sum(reference))
}

#[test]
fn the_bounce_of_the_colour_box_is_that_of_traced_paths() {
    let stage = colour_box();
    stage.succeed(&format!("reference box.cuts {VIEW} --kind path --bounces 1 --spp 256 --out path.exr"));
    let reference = squares(&stage, "path.exr");
    let against_paths = |dataset: &str, options: &str| {
        stage.succeed(&format!("render {dataset} {VIEW} {options} --backend cpu --out a.exr"));
        difference(&squares(&stage, "a.exr"), &reference)
    };
    // Measured: 0.042, some of it the noise of the paths.
    let (error, means) = against_paths("box.cuts", "");
    assert!(error < 0.06, "{error}");
    assert!((means - 1.0).abs().max_element() < 0.03, "{means}");

    // Negative controls: a green wall in place of the red one, without another bake, and a lamp that points elsewhere.
    let mut other = stage.dataset("box.cuts");
    let red = other.scene.materials.iter_mut().find(|m| m.name == "Red paint").expect("a red wall");
    red.parameters.base_color = Vec3::new(0.1, 0.6, 0.05);
    other.write(&stage.path("green.cuts")).expect("a writable folder");
    let (error, means) = against_paths("green.cuts", "");
    assert!(error > 0.18 && means.x < 0.9 && means.y > 1.1, "{error} {means}");
    stage.write("lamp.json", LAMP.into());
    let (error, means) = against_paths("box.cuts", "--lights lamp.json");
    assert!(error > 0.3 && means.x < 0.8, "{error} {means}");
}

/// The spot of the box, aimed at the green wall.
const LAMP: &str = r#"{"lights": [{"kind": "spot", "position": [0.1, 1.9, 0.1], "target": [0.9, 0.5, 0],
    "intensity": [4, 3.6, 3], "cone_degrees": 48, "penumbra_degrees": 10}]}"#;

#[test]
fn a_solution_that_was_not_baked_is_refused_with_the_bake_that_has_it() {
    let stage = colour_box();
    for (solution, mode) in [("meshless", "--mode meshless"), ("cuts+meshless", "--mode all")] {
        let message = stage.fail(&format!("render box.cuts {VIEW} --solution {solution} --out a.exr"));
        assert!(message.contains("meshless basis") && message.contains(mode), "{message}");
    }
    assert!(!stage.path("a.exr").exists());
    stage.succeed(&format!("render box.cuts {VIEW} --solution cuts --out a.exr"));
}
