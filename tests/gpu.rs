//! The GPU renderer from end to end, on whatever adapter there is: `render --backend gpu`, and `bench`.

use crate::common::{Folder, keys};
use lapidary_core::dataset::Dataset;
use lapidary_interchange::image;

const VIEW: &str = "--env sun-sky:50 --eye 0.5,3,3 --target 0,0.3,0 --fov 35 --size 96x72 --no-mirrors";

/// A baked scene, or `None`, said aloud, where there is no adapter and none is required.
fn baked() -> Option<Folder> {
    let folder = Folder::new();
    folder.bake("a.cuts", "");
    let output = folder.run(&format!("render a.cuts {VIEW} --backend gpu --out gpu.exr"));
    if output.status.success() {
        return Some(folder);
    }
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("no graphics adapter"), "{errors}");
    assert!(std::env::var_os("LAPIDARY_REQUIRE_GPU").is_none(), "LAPIDARY_REQUIRE_GPU is set, but {errors}");
    eprintln!("SKIPPED: {errors}");
    None
}

fn error(folder: &Folder, test: &str, reference: &str) -> f64 {
    folder.succeed(&format!("compare {test} {reference} --json m.json"));
    folder.json("m.json")["rel_rmse"].as_f64().expect("a number")
}

#[test]
fn both_backends_make_the_same_picture_but_for_silhouettes() {
    let Some(folder) = baked() else { return };
    folder.succeed(&format!("render a.cuts {VIEW} --backend gpu --aa 4 --out gpu.exr --stats gpu.json"));
    folder.succeed(&format!("render a.cuts {VIEW} --backend cpu --aa 4 --out cpu.exr --stats cpu.json"));
    folder.succeed(&format!("render a.cuts {VIEW} --backend cpu --aa 4 --roughness 0.3 --metalness 1 --out other.exr"));
    let (same, other) = (error(&folder, "gpu.exr", "cpu.exr"), error(&folder, "other.exr", "cpu.exr"));
    assert!(same < 2e-3, "{same}");
    assert!(other > 0.01, "negative control: {other}");
    let (gpu, cpu) = (folder.json("gpu.json"), folder.json("cpu.json"));
    assert_eq!((gpu["backend"].as_str(), cpu["backend"].as_str()), (Some("gpu"), Some("cpu")));
    assert!(gpu["adapter"].is_string() && cpu["adapter"].is_null());
    let nodes = |stats: &serde_json::Value| stats["mean_merged_nodes"].as_f64().expect("a number");
    assert!((nodes(&gpu) / nodes(&cpu) - 1.0).abs() < 0.01);
}

#[test]
fn a_bake_on_the_gpu_is_that_of_the_processor_but_for_rays_along_edges() {
    let Some(folder) = baked() else { return };
    for options in ["", "--exhaustive"] {
        folder.bake("gpu.cuts", &format!("--device gpu {options}"));
        folder.bake("cpu.cuts", &format!("--device cpu {options}"));
        let [gpu, cpu] = ["gpu.cuts", "cpu.cuts"].map(|name| folder.dataset(name));
        assert_eq!((&gpu.settings, &gpu.scene.mesh), (&cpu.settings, &cpu.scene.mesh));
        assert_eq!((&gpu.tree, gpu.report.audit), (&cpu.tree, cpu.report.audit));
        assert!(gpu.report.on_device && !cpu.report.on_device);
        let height = cpu.tree.height();
        let vertices = cpu.scene.mesh.positions.len() as u32;
        let cut = |dataset: &Dataset, vertex| dataset.cuts.cut(height, vertex).to_vec();
        let differ = (0..vertices).filter(|&v| cut(&gpu, v) != cut(&cpu, v)).count();
        assert!(50 * differ < vertices as usize, "{differ} of {vertices} cuts differ");
        assert!((1..vertices).any(|v| cut(&cpu, v - 1) != cut(&cpu, v)), "negative control: cuts do differ");
        folder.succeed("verify gpu.cuts");
    }
}

#[test]
fn a_sequence_with_layers_is_the_same_on_both_backends() {
    let Some(folder) = baked() else { return };
    // From here no sample falls on an outline, where the rasterizer may decide otherwise than a ray.
    let view = VIEW.replace("--eye 0.5,3,3", "--eye 0.6,3,3");
    for backend in ["gpu", "cpu"] {
        let out = format!("--layers environment,normal,depth --backend {backend} --out {backend}.#.exr");
        folder.succeed(&format!("sequence a.cuts {view} --sun off --aa 4 --turn environment --frames 2 {out}"));
    }
    let of_layer = |layer: &str, test: &str, reference: &str| {
        error(&folder, &format!("{test} --layer {layer}"), &format!("{reference} --reference-layer {layer}"))
    };
    for layer in ["environment", "normal", "depth"] {
        for frame in 1..=2 {
            let same = of_layer(layer, &format!("gpu.{frame}.exr"), &format!("cpu.{frame}.exr"));
            assert!(same < 2e-3, "{layer} of frame {frame}: {same}");
        }
    }
    let other = of_layer("environment", "gpu.1.exr", "cpu.2.exr");
    assert!(other > 0.01, "negative control: {other}");
}

#[test]
fn both_paths_write_the_same_pixels() {
    let Some(folder) = baked() else { return };
    for (path, samples) in [("fragment", 2), ("compute", 2), ("compute", 1)] {
        let out = format!("--backend gpu --gpu-path {path} --aa {samples} --out {path}-{samples}.exr");
        folder.succeed(&format!("render a.cuts {VIEW} {out}"));
    }
    assert!(error(&folder, "fragment-2.exr", "compute-2.exr") <= 0.0);
    assert!(error(&folder, "fragment-2.exr", "compute-1.exr") > 0.0, "negative control: other samples");
}

#[test]
fn suns_agree_on_both_backends() {
    let Some(folder) = baked() else { return };
    for degrees in [0, 180, 250] {
        for (backend, sun) in [("gpu", "on"), ("cpu", "on"), ("cpu", "off")] {
            let out = format!("--backend {backend} --sun {sun} --out {backend}-{sun}.exr");
            folder.succeed(&format!("render a.cuts {VIEW} --aa 4 --rotate {degrees} {out}"));
        }
        let same = error(&folder, "gpu-on.exr", "cpu-on.exr");
        assert!(same < 5e-3, "turned by {degrees} degrees: {same}");
        let other = error(&folder, "cpu-off.exr", "cpu-on.exr");
        assert!(other > 0.03, "negative control: {other} without a sun");
    }
}

#[test]
fn a_transparent_background_leaves_alpha_and_no_light() {
    let Some(folder) = baked() else { return };
    let sky = "--env sun-sky:50 --eye 0.5,0.6,3 --target 0,0.9,0 --fov 60 --size 64x48 --background transparent";
    for backend in ["gpu", "cpu"] {
        folder.succeed(&format!("render a.cuts {sky} --backend {backend} --out {backend}.png --out {backend}.exr"));
        let texture = image::read_texture(&folder.path(&format!("{backend}.png"))).expect("a picture");
        let lapidary_core::texture::Texels::U8(texels) = &texture.texels else { panic!("8 bits a channel") };
        assert_eq!(texels[0], [0; 4]);
        assert!(texels.iter().any(|t| t[3] == 255));
        assert_eq!(
            image::read(&folder.path(&format!("{backend}.exr"))).expect("a picture").pixels[0],
            glam::Vec3::ZERO
        );
    }
}

#[test]
fn bench_reports_medians_by_pass_size_and_cut() {
    let Some(folder) = baked() else { return };
    let options = "--size 64x48 --illum-cuts 16,64 --frames 2 --json";
    for (backend, passes) in
        [("gpu", &["deferred", "display", "merge", "total", "visibility"][..]), ("cpu", &["total"][..])]
    {
        let text = folder.succeed(&format!("bench a.cuts --backend {backend} {options}"));
        let bench: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(bench["size"], serde_json::json!([64, 48]));
        assert!(bench["adapter"].is_string() && bench["rotation_milliseconds"].as_f64().is_some_and(|ms| ms > 0.0));
        let runs = bench["runs"].as_array().expect("runs");
        assert_eq!(runs.iter().map(|r| r["illum_cut"].as_u64()).collect::<Vec<_>>(), [Some(16), Some(64)]);
        for run in runs {
            assert_eq!(keys(&run["milliseconds"]), passes);
            assert!(run["milliseconds"]["total"].as_f64().is_some_and(|ms| ms > 0.0));
        }
    }
}
