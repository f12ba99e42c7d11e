//! `ladder` and `evidence` from end to end.

use crate::common::{Folder, keys};
use lapidary_interchange::image;
use std::fs;

/// Looks down on box and floor.
const EYE: &str = "--env sun-sky:50 --eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 32x24";

#[test]
fn the_ladder_shows_errors_and_times_of_every_size() {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    // Metal, and the BRDF once per node: where visibility is coarse only the illumination cut tells where the sun is.
    let view = format!("{EYE} --roughness 0.3 --metalness 1 --background black --no-mirrors");
    let ladder = format!("ladder a.cuts {view} --brdf once --backend cpu --illum-cuts 1,32,256 --out ladder");
    let printed = folder.succeed(&ladder);
    assert!(printed.contains("ladder.html") && printed.contains("relative RMSE"), "{printed}");
    let json = folder.json("ladder/ladder.json");
    let steps = json["steps"].as_array().expect("a list").clone();
    let sizes: Vec<_> = steps.iter().filter_map(|step| step["illum_cut"].as_u64()).collect();
    assert_eq!(sizes, [1, 32, 256]);
    let lit = steps.last().expect("steps");
    assert!(lit["brdf"] == "lit" && lit["lit_cuts"].is_number() && lit["illum_cut"].is_null(), "{lit}");
    assert!(lit["rel_rmse"].as_f64().is_some_and(|error| error < 0.31), "{lit}");
    for key in ["rel_rmse", "flip", "seconds", "mean_merged_nodes"] {
        assert!(steps.iter().all(|step| step[key].is_number()), "{key}");
    }
    let error = |i: usize| steps[i]["rel_rmse"].as_f64().expect("a number");
    let errors = [0, 1, 2].map(error);
    assert!(errors[0] > 0.85 && errors[1] > 0.75 && errors[2] < 0.31, "one node is far from the truth: {errors:?}");
    for name in ["cut-1", "cut-32", "cut-256", "cut-lit", "reference"] {
        for extension in ["png", "exr"] {
            let picture = image::read(&folder.path(&format!("ladder/{name}.{extension}"))).expect("a picture");
            assert_eq!(picture.size, [32, 24], "{name}");
        }
    }
    assert!(image::read(&folder.path("ladder/sheet.png")).is_ok());
    assert!(json["reference"]["what"].as_str().is_some_and(|what| what.contains("samples of the environment")));
    let page = fs::read_to_string(folder.path("ladder/ladder.html")).expect("a page");
    assert!(page.contains("cut-256.png") && page.contains("<svg"));
    // The same pictures as `render` and `reference` make.
    folder.succeed(&format!("render a.cuts {view} --brdf once --backend cpu --illum-cut 32 --out r.exr"));
    folder.succeed(&format!("render a.cuts {view} --backend cpu --out l.exr"));
    folder.succeed(&format!("reference a.cuts {view} --out t.exr"));
    let read = |name: &str| image::read(&folder.path(name)).expect("a picture");
    assert_eq!(read("r.exr"), read("ladder/cut-32.exr"));
    assert_eq!(read("l.exr"), read("ladder/cut-lit.exr"));
    assert_eq!(read("t.exr"), read("ladder/reference.exr"));
}

#[test]
fn bounced_light_has_a_ladder_too_and_says_what_it_is_held_against() {
    let folder = Folder::new();
    folder.succeed("bake scene.obj -o a.cuts --mode cuts --lights 256 --sources 256 --source-sigma 0.1 --pilot-clusters 16 --max-vertices 200 --progress none");
    folder.succeed(&format!("ladder a.cuts {EYE} --components indirect --backend cpu --illum-cuts 1,256 --out ladder"));
    let json = folder.json("ladder/ladder.json");
    assert!(json["reference"]["what"].as_str().is_some_and(|what| what.contains("256 surface sources")), "{json}");
    let error = |i: usize| json["steps"][i]["rel_rmse"].as_f64().expect("a number");
    assert!(error(0) > 0.2 && error(1) < 0.05, "{} and {}", error(0), error(1));
    assert!(keys(&json).contains(&"reference"));
}

#[test]
fn a_folder_that_cannot_be_written_is_told_before_anything_else() {
    let folder = Folder::new();
    folder.write("file", "not a folder".into());
    for command in ["ladder missing.cuts --out file/ladder", "ladder missing.cuts --out file"] {
        let message = folder.fail(command);
        assert!(message.contains("folder") && !message.contains("missing.cuts"), "{command}: {message}");
    }
    let message = folder.fail("ladder missing.cuts --out ladder");
    assert!(message.contains("missing.cuts"), "negative control: {message}");
}

#[test]
fn a_scene_with_a_lamp_has_the_figures_of_functions() {
    let folder = Folder::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/color-box/color-box.gltf");
    folder.succeed(&format!("evidence --quick --no-bundled --scenes {scene} --out proof"));
    let figures = &folder.json("proof/evidence.json")["figures"];
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let (basis, solved) = (&figures["meshless_table1"][0], &figures["radiosity_table1"][0]);
    for row in [basis, solved] {
        // Few functions, and few paths.
        assert!((0.0..0.4).contains(&number(&row["error"])) && (number(&row["energy"]) - 1.0).abs() < 0.2, "{row}");
    }
    assert!(number(&basis["links"]) > 1000.0 && number(&basis["functions"]) > number(&basis["coarsest"]), "{basis}");
    assert!(number(&solved["rays_traced_again"]) < number(&solved["rays"]), "{solved}");
    assert_eq!((&solved["object"], &solved["levels"]), (&"Short block".into(), &3.into()));
    assert!(figures["wavelet_table1"].is_null(), "its blocks are no quads");
    for (pictures, count) in [("meshless_pictures", 4), ("radiosity_pictures", 3)] {
        let shown = figures[pictures].as_array().expect("a list");
        assert_eq!(shown.len(), count);
        for figure in shown {
            let file = folder.path("proof").join(figure["png"].as_str().expect("a name"));
            let picture = image::read(&file).expect("a picture");
            assert!(picture.pixels.iter().any(|pixel| pixel.max_element() > 0.1), "{figure}: not black");
        }
    }
}

#[test]
fn a_room_of_quads_has_the_figures_of_wavelet_transport() {
    let folder = Folder::new();
    write_room(&folder);
    folder.succeed("evidence --quick --no-bundled --scenes room.gltf --papers wavelet --out proof");
    let figures = &folder.json("proof/evidence.json")["figures"];
    assert_eq!(keys(figures), ["wavelet_compression", "wavelet_gathering", "wavelet_table1"], "of this paper alone");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let row = &figures["wavelet_table1"][0];
    assert_eq!((&row["scene"], &row["patches"]), (&"room".into(), &6.into()));
    // Few paths.
    assert!(number(&row["error"]) < 0.2 && (number(&row["energy"]) - 1.0).abs() < 0.1, "{row}");
    let links: Vec<f64> = row["links"].as_array().expect("a list").iter().map(number).collect();
    assert!(links[0] > 100.0 && links[2] >= links[1], "{row}");
    let compressed = figures["wavelet_compression"].as_array().expect("a list");
    let errors: Vec<f64> = compressed.iter().map(|row| number(&row["errors"][0])).collect();
    assert!(errors[0] == 0.0 && errors.is_sorted() && errors[3] > errors[1], "{errors:?}");
    assert_eq!(figures["wavelet_gathering"].as_array().map(Vec::len), Some(3));
    let picture = image::read(&folder.path("proof").join(row["picture"].as_str().expect("a name"))).expect("a picture");
    assert!(picture.pixels.iter().any(|pixel| pixel.max_element() > 0.1), "not black");
}

/// Writes a closed gray room of six quads with a lamp in it.
fn write_room(folder: &Folder) {
    let mut bytes = Vec::new();
    for (axis, sign) in (0..3).flat_map(|axis| [-1.0_f32, 1.0].map(|sign| (axis, sign))) {
        let mut corners = [[-1.0_f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        if sign > 0.0 {
            corners.reverse();
        }
        for [b, c] in corners {
            let mut position = [0.0; 3];
            (position[axis], position[(axis + 1) % 3], position[(axis + 2) % 3]) = (sign, b, c);
            bytes.extend(position.into_iter().flat_map(f32::to_le_bytes));
        }
    }
    let triangles = (0..6_u16).flat_map(|face| [0, 1, 2, 0, 2, 3].map(|corner| 4 * face + corner));
    bytes.extend(triangles.flat_map(u16::to_le_bytes));
    fs::write(folder.path("room.bin"), &bytes).expect("a file");
    let scene = serde_json::json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1.0}]}},
        "scenes": [{"nodes": [0, 1, 2]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.2, "znear": 0.01}}],
        "nodes": [
            {"mesh": 0, "name": "Room"},
            {"translation": [0.3, 0.5, 0.1], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"translation": [0.0, 0.0, 0.9], "camera": 0},
        ],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1.0], "metallicFactor": 0.0}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "buffers": [{"uri": "room.bin", "byteLength": bytes.len()}],
        "bufferViews": [{"buffer": 0, "byteLength": 288}, {"buffer": 0, "byteOffset": 288, "byteLength": 72}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
    });
    folder.write("room.gltf", scene.to_string());
}

#[test]
fn the_evidence_of_a_small_scene_has_all_figures() {
    let folder = Folder::new();
    folder.succeed("evidence --quick --no-bundled --scenes scene.obj --env sun-sky:50 --out proof");
    let json = folder.json("proof/evidence.json");
    assert_eq!((&json["complete"], &json["scenes"][0]), (&true.into(), &"scene".into()));
    let figures = &json["figures"];
    let expected = [
        "error_by_beta",
        "error_by_lights",
        "error_by_sigma",
        "error_by_vertices",
        "fig10_table",
        "fig5_clusters",
        "fig6a_wavelets",
        "fig6b_cut_size_by_beta",
        "fig7_ladder",
        "implicit_drag",
        "implicit_fig11",
        "implicit_fig4",
        "implicit_table1",
    ];
    assert_eq!(keys(figures), expected);
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let ladder = figures["fig7_ladder"][0]["steps"].as_array().expect("a list");
    assert_eq!(ladder.len(), 7, "six sizes, and lit cuts");
    // Finer cuts are larger and see more exactly.
    let sigma = figures["error_by_sigma"]["points"].as_array().expect("a list").clone();
    for pair in sigma.windows(2) {
        assert!(number(&pair[0]["mean_cut"]) > number(&pair[1]["mean_cut"]), "{pair:?}");
        assert!(number(&pair[0]["rms_visibility"]) < number(&pair[1]["rms_visibility"]), "{pair:?}");
    }
    for curve in figures["fig6a_wavelets"]["curves"].as_array().expect("a list") {
        let points = curve["points"].as_array().expect("a list");
        assert!(points.iter().all(|p| number(&p["cut_terms"]) >= 6.0 && number(&p["wavelet_terms"]) > 0.0), "{curve}");
    }
    let row = &figures["fig10_table"][0];
    let bytes = |tree: &str| number(&row[tree]["bytes_cuts"]);
    assert!((number(&row["gain_over_geometric"]) - (1.0 - bytes("data_driven") / bytes("geometric"))).abs() < 1e-9);
    assert_eq!(row["frames"].as_array().map(Vec::len), Some(3));
    for step in figures["implicit_drag"][0]["steps"].as_array().expect("a list") {
        assert!(number(&step["preview"]) < number(&step["as_baked"]), "a drag of the box: {step}");
    }
    assert_eq!(figures["implicit_table1"].as_array().map(Vec::len), Some(6), "two rooms by three numbers of bins");
    let page = fs::read_to_string(folder.path("proof/evidence.html")).expect("a page");
    for (i, part) in page.split("src=\"").enumerate().skip(1) {
        let file = part.split('"').next().expect("a name");
        assert!(image::read(&folder.path(&format!("proof/{file}"))).is_ok(), "picture {i}: {file}");
    }
    assert!(page.contains("Motobike") && page.contains("Wavelets") && !page.contains("NaN"));
}

#[test]
fn evidence_refuses_what_it_cannot_measure_before_it_begins() {
    let folder = Folder::new();
    folder.write("file", "not a folder".into());
    assert!(folder.fail("evidence --quick --out file/proof").contains("folder"));
    folder.write("broken.obj", "v 0 0 0\n".into());
    let message = folder.fail("evidence --quick --no-bundled --scenes scene.obj broken.obj --out proof");
    assert!(message.contains("broken.obj"), "{message}");
    assert!(!folder.path("proof/evidence.json").exists(), "nothing was begun");
    assert!(
        folder.fail("evidence --quick --no-bundled --scenes scene.obj --env nowhere --out proof").contains("nowhere")
    );
    assert_eq!(folder.run("evidence --no-bundled --out proof").status.code(), Some(2));
}
