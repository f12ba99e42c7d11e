//! Bounced light from end to end: the bundled color box baked with few sources, against traced paths of one bounce.

use crate::common::Folder;
use glam::{DVec3, Vec3};
use lapidary_core::{cut::packed::PackedCuts, meshless::Transport};
use lapidary_interchange::image;
use serde_json::Value;
use std::sync::Arc;

/// Few sources, but fine cuts over them.
const BAKE: &str = "--mode indirect --sources 4096 --source-sigma 1 --lights 256 --pilot-clusters 64 \
                    --max-vertices 2500 --progress none";
const VIEW: &str = "--env none --components indirect --size 48x48";
/// Pixels along a side of the squares that are compared: their means hide the noise of the paths.
const SQUARE: usize = 8;

/// The color box, baked.
fn colour_box() -> Folder {
    let folder = Folder::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");
    folder.succeed(&format!("bake {data}/color-box/color-box.gltf -o box.cuts {BAKE}"));
    folder
}

/// Means over squares of a picture, row by row.
fn squares(folder: &Folder, name: &str) -> Vec<DVec3> {
    let picture = image::read(&folder.path(name)).expect("a picture");
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
    let folder = colour_box();
    folder.succeed(&format!("reference box.cuts {VIEW} --kind path --bounces 1 --spp 256 --out path.exr"));
    let reference = squares(&folder, "path.exr");
    let against_paths = |dataset: &str, options: &str| {
        folder.succeed(&format!("render {dataset} {VIEW} {options} --backend cpu --out a.exr"));
        difference(&squares(&folder, "a.exr"), &reference)
    };
    // Measured: 0.042, some of it the noise of the paths.
    let (error, means) = against_paths("box.cuts", "");
    assert!(error < 0.06, "{error}");
    assert!((means - 1.0).abs().max_element() < 0.03, "{means}");

    // Negative controls: a green wall in place of the red one, without another bake, and a lamp that points elsewhere.
    let mut other = folder.dataset("box.cuts");
    let red = other.scene.materials.iter_mut().find(|m| m.name == "Red paint").expect("a red wall");
    red.parameters.set("base_color", Vec3::new(0.1, 0.6, 0.05));
    other.write(&folder.path("green.cuts")).expect("a writable folder");
    let (error, means) = against_paths("green.cuts", "");
    assert!(error > 0.18 && means.x < 0.9 && means.y > 1.1, "{error} {means}");
    folder.write("lamp.json", LAMP.into());
    let (error, means) = against_paths("box.cuts", "--lights lamp.json");
    assert!(error > 0.3 && means.x < 0.8, "{error} {means}");
}

/// A basis for the box as well; its light is soft, so that few levels do.
const BASIS: &str = "--levels 5 --sender-levels 4 --gather-rays 128 --epsilon 0.01";

#[test]
fn bounces_in_the_meshless_basis_are_those_of_traced_paths() {
    let folder = Folder::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");
    let all = BAKE.replace("indirect", "all");
    folder.succeed(&format!("bake {data}/color-box/color-box.gltf -o box.cuts {all} {BASIS}"));
    const PICTURE: &str = "--env none --size 48x36 --aa 16";
    let measured = |solution: &str| {
        let options = format!("{PICTURE} --spp 512 --no-samples --out truth --quiet");
        folder.succeed(&format!("bounces box.cuts --solution {solution} {options}"));
        let row = folder.json("truth/bounces.json")["solutions"][0].clone();
        (row["bounces"].as_u64(), ["error", "energy", "rel_rmse"].map(|name| row[name].as_f64().expect("a number")))
    };
    let mut turned = folder.dataset("box.cuts");
    let bake = Arc::make_mut(turned.meshless.as_mut().expect("a basis"));
    let (transport, size) = (&bake.transport, [bake.transport.receivers(), bake.transport.senders()]);
    let mut links = transport.packed().to_vec();
    links.iter_mut().for_each(|link| link.vector.rotate_left(1));
    bake.transport =
        Transport::from_parts(size, transport.scale(), transport.offsets().to_vec(), links).expect("whole links");
    turned.write(&folder.path("turned.cuts")).expect("a writable folder");
    for (solution, bounces, bound) in [("meshless", 4, 0.08), ("cuts+meshless", 5, 0.06)] {
        let (of_paths, [error, energy, with_noise]) = measured(solution);
        assert_eq!(of_paths, Some(bounces), "{solution}");
        assert!(error < bound && (energy - 1.0).abs() < 0.05, "{solution}: {error} {energy}");
        let wrong = folder.off_from_paths("turned.cuts", solution, PICTURE);
        assert!(wrong > with_noise + 0.05, "negative control, light from other sides: {solution} {wrong} {with_noise}");
    }

    // A wall of metal: sources that send by direction are nearer to paths than diffuse ones.
    let metal =
        r#"{"model": "ggx", "parameters": {"base_color": [0.9, 0.75, 0.6], "roughness": 0.447, "metalness": 1.0}}"#;
    folder.write("metal.json", metal.into());
    let [diffuse, glossy] = ["cuts+meshless", "cuts+gloss"].map(|solution| {
        let options = "--env none --no-mirrors --size 48x36 --spp 1024 --aa 16 --no-samples --out truth --quiet";
        let mut command = folder.command(&format!("bounces box.cuts --solution {solution} {options}"));
        assert!(command.args(["--material", "Red paint=metal.json"]).status().expect("it starts").success());
        folder.json("truth/bounces.json")["solutions"][0]["error"].as_f64().expect("a number")
    });
    assert!(glossy < 0.08, "{glossy}");
    assert!(diffuse > 0.1, "negative control: {diffuse}");

    // White walls send on for ever: the picture says so, and that of gray ones does not.
    let errors = |color: &str| {
        let options = format!("--solution meshless --base-color {color} --backend cpu --out a.exr");
        let output = folder.run(&format!("render box.cuts {VIEW} {options}"));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(errors("1,1,1").contains("bounce on"), "{}", errors("1,1,1"));
    assert!(!errors("0.5,0.5,0.5").contains("bounce on"));
}

/// Cells along a wall of the room.
const CELLS: usize = 12;

/// A closed room of two meters, seen from inside, whose walls shine and reflect.
fn closed_room() -> String {
    let (mut text, mut first) = ("mtllib room.mtl\no Room\nusemtl Walls\n".to_owned(), 1);
    let across = |i: usize| 2.0 * i as f32 / CELLS as f32 - 1.0;
    for (axis, side) in (0..3).flat_map(|axis| [-1.0_f32, 1.0].map(|side| (axis, side))) {
        for (row, column) in (0..=CELLS).flat_map(|row| (0..=CELLS).map(move |column| (row, column))) {
            let mut p = [side; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (across(column), across(row));
            text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
        }
        for (row, column) in (0..CELLS).flat_map(|row| (0..CELLS).map(move |column| (row, column))) {
            let at = |row: usize, column: usize| first + row * (CELLS + 1) + column;
            let mut face = [at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)];
            if side > 0.0 {
                face.reverse();
            }
            text += &format!("f {} {} {} {}\n", face[0], face[1], face[2], face[3]);
        }
        first += (CELLS + 1) * (CELLS + 1);
    }
    text
}

/// With a reflectance r, light that was once 1 everywhere becomes 1 / (1 - r).
#[test]
fn light_in_a_closed_glossy_room_is_the_geometric_series() {
    let folder = Folder::new();
    folder.write("room.obj", closed_room());
    folder.write("room.mtl", "newmtl Walls\nKd 0.5 0.5 0.5\nPm 1\nPr 0.447\nKe 1 1 1\n".into());
    folder.succeed(&format!("bake room.obj -o room.cuts {} {BASIS}", BAKE.replace("indirect", "all")));
    let inside =
        "--env none --components direct,indirect --size 24x24 --eye 0.2,0.1,0.3 --target -0.5,-0.2,-1 --fov 90";
    let mean = |command: &str| {
        folder.succeed(&format!("{command} {inside} --out a.exr"));
        let squares = squares(&folder, "a.exr");
        squares.iter().map(|square| square.x).sum::<f64>() / squares.len() as f64
    };
    let reflectance = mean("reference room.cuts --kind path --bounces 1 --spp 256 --no-mirrors") - 1.0;
    assert!((0.45..0.5).contains(&reflectance), "{reflectance}");
    let of = |solution: &str| mean(&format!("render room.cuts --backend cpu --solution {solution}"));
    // In creases sources are too coarse for such lobes: rays show what is there.
    let (found, expected) = (of("cuts+gloss"), 1.0 / (1.0 - reflectance));
    assert!((found / expected - 1.0).abs() < 0.03, "{found} for {expected}");
    let once = of("cuts");
    assert!(once / expected < 0.95, "negative control, one bounce and what mirrors show of it: {once}");
}

#[test]
fn an_environment_that_was_not_baked_is_left_out_or_told() {
    let folder = colour_box();
    let errors = |options: &str| {
        let output = folder.run(&format!("render box.cuts --size 8x8 --backend cpu --out a.exr {options}"));
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(!errors("").contains("environment"), "{}", errors(""));
    assert!(errors("--env studio").contains("baked without it"), "{}", errors("--env studio"));
}

#[test]
fn solutions_are_measured_and_timed_by_command() {
    let folder = colour_box();
    let options = "--env none --size 48x36 --spp 128 --no-samples --out truth --quiet";
    folder.succeed(&format!("bounces box.cuts {options}"));
    let report = folder.json("truth/bounces.json");
    let solutions = report["solutions"].as_array().expect("a list");
    let [row] = &solutions[..] else { panic!("{report}") };
    let figure = |row: &Value, name: &str| row[name].as_f64().expect("a number");
    assert_eq!((row["solution"].as_str(), row["bounces"].as_u64()), (Some("cuts"), Some(1)));
    assert!(figure(row, "noise") > 0.05 && figure(row, "rel_rmse") > figure(row, "error"), "{row}");
    assert!(figure(row, "error") < 0.2 && (figure(row, "energy") - 1.0).abs() < 0.05, "{row}");
    assert!(folder.path("truth/cuts.png").exists() && folder.path("truth/cuts-paths.exr").exists());
    // Negative control: every vertex sees what a distant one does.
    let mut swapped = folder.dataset("box.cuts");
    let bake = swapped.indirect.as_mut().expect("sources");
    let mut offsets = bake.cuts.offsets().to_vec();
    offsets.rotate_left(1000);
    let height = bake.sources.len().ilog2();
    bake.cuts = PackedCuts::from_parts(height, bake.cuts.nodes().to_vec(), offsets).expect("whole cuts");
    swapped.write(&folder.path("swapped.cuts")).expect("a writable folder");
    folder.succeed(&format!("bounces swapped.cuts {options}"));
    let wrong = &folder.json("truth/bounces.json")["solutions"][0];
    assert!(figure(wrong, "error") > figure(row, "error") + 0.1, "{wrong}");

    let bench =
        folder.succeed("bench box.cuts --env none --backend cpu --size 48x36 --frames 2 --illum-cuts 64 --json");
    let bench: Value = serde_json::from_str(&bench).expect("JSON");
    assert!(figure(&bench, "light_moved_milliseconds") > 0.0 && figure(&bench, "mean_source_cut") > 10.0, "{bench}");
    assert!(figure(&bench["runs"][0], "mean_merged_nodes") > 64.0, "the merge over the sources counts: {bench}");
    for (options, message) in
        [("--components direct", "--components"), ("--spp 7", "multiple of 2"), ("--aa 8 --spp 8", "16")]
    {
        let found = folder.fail(&format!("bounces box.cuts {options} --out bad"));
        assert!(found.contains(message), "{found}");
    }
    assert!(!folder.path("bad").exists());
}

/// The spot of the box, aimed at the green wall.
const LAMP: &str = r#"{"lights": [{"kind": "spot", "position": [0.1, 1.9, 0.1], "target": [0.9, 0.5, 0],
    "intensity": [4, 3.6, 3], "cone_degrees": 48, "penumbra_degrees": 10}]}"#;

#[test]
fn a_solution_that_was_not_baked_is_refused_with_the_bake_that_has_it() {
    let folder = colour_box();
    for solution in ["meshless", "cuts+meshless"] {
        let message = folder.fail(&format!("render box.cuts {VIEW} --solution {solution} --out a.exr"));
        assert!(message.contains("meshless basis") && message.contains("--mode indirect,meshless"), "{message}");
    }
    assert!(!folder.path("a.exr").exists());
    folder.succeed(&format!("render box.cuts {VIEW} --solution cuts --out a.exr"));
}

#[test]
fn environment_and_meshless_basis_without_sources_light_a_picture_together() {
    let folder = Folder::new();
    folder.bake("a.cuts", "--mode environment,meshless --levels 3 --sender-levels 2 --gather-rays 64");
    let dataset = folder.dataset("a.cuts");
    assert!(dataset.settings.mode.to_string() == "environment,meshless" && dataset.indirect.is_none());
    let [environment, bounces, both] = ["environment", "indirect", "environment,indirect"].map(|components| {
        let options = format!("--env studio --solution meshless --components {components} --size 24x24");
        folder.succeed(&format!("render a.cuts {options} --out a.exr"));
        squares(&folder, "a.exr").iter().sum::<DVec3>()
    });
    assert!(environment.min_element() > 0.0 && bounces.min_element() > 0.0, "{environment} {bounces}");
    assert!((both / (environment + bounces) - 1.0).abs().max_element() < 1e-3, "{both} of {environment} and {bounces}");
}

/// The short block of the color box moved aside.
const MOVE: &str = r#"{"objects": {"Short block": {"translate": [0.25, 0, 0.1]}}}"#;

#[test]
fn light_solved_anew_is_that_of_paths_as_baked_and_after_a_move() {
    let folder = Folder::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../data");
    folder.write("move.json", MOVE.into());
    let bake = BAKE.replace("indirect", "indirect,radiosity --functions 20000 --object-levels 5");
    folder.succeed(&format!("bake {data}/color-box/color-box.gltf -o box.cuts {bake}"));
    let measured = |solution: &str, pose: &str| {
        let options = "--env none --size 48x36 --spp 512 --aa 16 --no-samples --out truth --quiet";
        folder.succeed(&format!("bounces box.cuts --solution {solution} {options} {pose}"));
        let row = folder.json("truth/bounces.json")["solutions"][0].clone();
        (row["error"].as_f64().unwrap(), row["energy"].as_f64().unwrap())
    };
    let picture = |name: &str| squares(&folder, &format!("truth/radiosity{name}.exr"));
    let (error, energy) = measured("radiosity", "");
    assert!(error < 0.11 && (energy - 1.0).abs() < 0.09, "{error} {energy}");
    let as_baked = picture("");
    let (by_cuts, energy) = measured("cuts+radiosity", "");
    assert!(by_cuts < 0.06 && by_cuts < error && (energy - 1.0).abs() < 0.05, "{by_cuts} {energy}");
    let (error, energy) = measured("cuts+radiosity", "--pose move.json");
    assert!(error < 0.11 && (energy - 1.0).abs() < 0.09, "by the vertices until cuts are baked anew: {error} {energy}");
    let (error, energy) = measured("radiosity", "--pose move.json");
    assert!(error < 0.11 && (energy - 1.0).abs() < 0.09, "{error} {energy}");
    let (moved, paths) = (picture(""), picture("-paths"));
    let ([right, forgotten], by) = ([&moved, &as_baked].map(|test| difference(test, &paths).0), 0.03);
    assert!(forgotten > right + by, "negative control, the pose is forgotten: {forgotten} {right}");

    let resolve = |object: &str| {
        let mut command = folder.command("bench box.cuts --env none --frames 2 --json resolve.json");
        command.args(["--resolve", object]).output().expect("the program starts")
    };
    assert!(resolve("Short block").status.success());
    let times = folder.json("resolve.json");
    let of = |name: &str| times[name].as_f64().unwrap();
    assert!(of("first_bounce_milliseconds") < of("after_a_move_milliseconds"), "{times}");
    assert!(of("after_a_move_milliseconds") < of("whole_milliseconds"), "{times}");
    let again = of("rays_traced_again") / of("rays");
    assert!((0.02..0.6).contains(&again) && of("table_bytes") == 8.0 * of("rays"), "{times}");
    let refused = String::from_utf8_lossy(&resolve("Lamp").stderr).into_owned();
    assert!(refused.contains("there is no object \"Lamp\"") && refused.contains("Short block"), "{refused}");
}
