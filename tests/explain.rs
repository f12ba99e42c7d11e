//! `explain` and `predict` from end to end: what they say of a picture is true of the picture that `render` writes.

use crate::common::{Folder, SMALL, files_in};
use glam::Vec3;
use lapidary_interchange::image;
use serde_json::Value;

const VIEW: &str = "--env sun-sky:40 --size 48x36 --eye 0.3,2.5,3.5 --target 0,0.2,0 --illum-cut 64";

/// The box over the floor, baked.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    folder
}

fn vector(value: &Value) -> Vec3 {
    serde_json::from_value(value.clone()).expect("three numbers")
}

#[test]
fn the_nodes_of_a_pixel_sum_to_the_pixel_that_is_rendered() {
    let folder = folder();
    folder.succeed(&format!("render a.cuts {VIEW} --no-mirrors --backend cpu --out a.exr"));
    let with_rays = folder.succeed(&format!("explain a.cuts {VIEW} --pixel 20,22 --spp 8 --out why-rays"));
    let said = folder.succeed(&format!("explain a.cuts {VIEW} --no-mirrors --pixel 20,22 --spp 8 --out why"));
    assert!(with_rays.contains("a mirror: rays") && !said.contains("a mirror: rays"), "{with_rays}");
    assert!(said.contains("pixel 20,22") && said.contains("light samples"), "{said}");
    let json = folder.json("why/explain.json");
    let nodes = json["pixel"]["nodes"].as_array().expect("nodes");
    let suns = json["pixel"]["suns"].as_array().expect("suns");
    assert_eq!(suns.len(), 1);
    let of_terms: Vec3 = nodes.iter().chain(suns).map(|term| vector(&term["contribution"])).sum();
    let sum = of_terms + vector(&json["pixel"]["mirror"]);
    assert!(vector(&suns[0]["contribution"]).max_element() > 0.0, "{said}");
    let rendered = image::read(&folder.path("a.exr")).expect("a picture").at(20, 22);
    assert!((sum - rendered).length() < 1e-4 * rendered.length(), "{sum} for {rendered}");
    let greatest = json["by_contribution"][0].as_u64().expect("a position") as usize;
    let without = sum - vector(&nodes[greatest]["contribution"]);
    assert!((without - rendered).length() > 1e-3 * rendered.length(), "negative control");
    let factors = json["split"]["steps"].as_array().expect("steps").iter().map(|step| step["factor"].as_str());
    let expected =
        ["lit cuts", "BRDF sampling", "light clusters", "visibility clusters", "interpolation", "light samples"];
    assert!(factors.eq(expected.map(Some)));
    assert_eq!(json["split"]["region"]["width"], 48, "64 pixels around it are all there is");
    // explain.json, three maps, seven pictures and the strip of them.
    assert_eq!(files_in(&folder.path("why")), 12);
    let map = image::read(&folder.path("why/cut.png")).expect("a map");
    assert!(map.size == [1024, 512] && map.pixels.iter().any(|p| p.x > 0.3));
}

#[test]
fn pictures_of_a_region_are_its_part_of_the_whole() {
    let folder = folder();
    // A lobe as wide as these reads no map, which the split leaves out.
    folder.succeed(&format!("render a.cuts {VIEW} --roughness 1 --background black --backend cpu --out a.exr"));
    folder.succeed(&format!("explain a.cuts {VIEW} --roughness 1 --region 10,12,8,6 --spp 2 --out why"));
    let (whole, part) = (image::read(&folder.path("a.exr")), image::read(&folder.path("why/split-1-rendered.exr")));
    let (whole, part) = (whole.expect("a picture"), part.expect("a picture"));
    assert_eq!(part.size, [8, 6]);
    let same = |dx: usize| {
        (0..48).filter(|i| part.at(i % 8, i / 8).abs_diff_eq(whole.at(10 + dx + i % 8, 12 + i / 8), 2e-3)).count()
    };
    assert_eq!(same(0), 48);
    assert!(same(1) < 48, "negative control");
    assert_eq!(folder.json("why/explain.json")["pixel"], Value::Null);
}

#[test]
fn pixels_and_regions_without_a_surface_are_refused_before_the_work() {
    let folder = folder();
    folder.write("file", String::new());
    let up = "--env studio --size 48x36 --eye 0,1,3 --target 0,9,0";
    for (options, expected) in [
        (format!("{VIEW} --pixel 48,3 --out why"), "48 x 36"),
        (format!("{up} --pixel 20,10 --out why"), "background"),
        (format!("{up} --out why"), "no pixel of the region"),
        (format!("{VIEW} --region 3,3,0,9 --out why"), "no pixels"),
        (format!("{VIEW} --region 40,3,9,9 --out why"), "column 48"),
        (format!("{VIEW} --pixel 20,22 --components direct --out why"), "--tree"),
        (format!("{VIEW} --pixel 20,22 --tree sources --out why"), "--mode indirect"),
        (format!("{VIEW} --pixel 20,22 --out file"), "folder"),
    ] {
        let message = folder.fail(&format!("explain a.cuts {options}"));
        assert!(message.contains(expected), "{options}: {message}");
    }
    assert!(!folder.path("why/explain.json").exists());
    for wrong in ["--pixel 1", "--pixel -1,2", "--region 1,2,3", "--no-split"] {
        let output = folder.run(&format!("explain a.cuts {VIEW} {wrong} --out why"));
        assert_eq!(output.status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn a_predicted_error_is_written_and_calibrated() {
    let folder = Folder::new();
    // Coarse cuts, so that no prediction holds at all pixels.
    folder.bake("a.cuts", "--sigma 8");
    let options = format!("{VIEW} --calibrate --json a.json --out a.png --out a.exr");
    let said = folder.succeed(&format!("predict a.cuts {options}"));
    assert!(said.contains("rank correlation"), "{said}");
    let predicted = image::read(&folder.path("a.exr")).expect("a map");
    assert!(predicted.size == [48, 36] && predicted.pixels.iter().any(|p| p.x > 0.0));
    assert!(image::read(&folder.path("a.png")).expect("a map").height() > 36, "with a legend");
    let json = folder.json("a.json");
    let of = |kind: &str, what: &str| json[kind][what].as_f64().expect("a number");
    assert_eq!(json["bound"]["bins"].as_array().map(Vec::len), Some(10));
    assert!(of("bound", "ratio") >= of("printed", "ratio") && of("bound", "ratio") > of("expected", "ratio"));
    assert!(of("bound", "within") > of("expected", "within"), "{json}");
    folder.succeed(&format!("bake scene.obj -o b.cuts --mode indirect --sources 256 {SMALL}"));
    let message = folder.fail(&format!("predict b.cuts {VIEW} --out b.exr"));
    assert!(message.contains("--mode environment") && !folder.path("b.exr").exists(), "{message}");
}
