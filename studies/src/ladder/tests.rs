use super::*;
use glam::Vec3;
use lapidary_core::{camera::Camera, material::BrdfModel, test_scenes};
use lapidary_interchange::environment;
use lapidary_render::{
    Backend, Background, BrdfSampling, Components, CpuBackend, Illumination, LitScene, Look, Post, Progress, Quiet,
    View,
};
use std::sync::atomic::{AtomicBool, Ordering};

/// A diffuse triangle from above, under directional light. A highlight narrower than the spacing of 64 samples would read the map
/// in the reference, but not where the BRDF is sampled once per node.
fn look() -> Look {
    let camera = Camera::look_at(Vec3::new(0.4, 2.0, 0.5), Vec3::new(0.4, 0.0, 0.3), 30.0);
    let view = View { background: Background::Flat(Vec3::ZERO), ..View::new(camera, [16, 12]) };
    let environment = environment::from_spec("orientation").unwrap().0.into();
    let mut scene = test_scenes::dataset(&["a"], &[]).scene;
    scene.materials.iter_mut().for_each(|material| material.model = BrdfModel::Lambert);
    Look::under_environment(&scene, view, Illumination { environment, rotation: 0.0, intensity: 1.0, sun: None })
}

fn scene() -> LitScene {
    LitScene::<dyn Backend>::new(Box::new(CpuBackend::new()), test_scenes::dataset(&["a"], &[]).into()).unwrap()
}

/// Pictures of `sizes` with one BRDF sample per node, then one with lit cuts.
fn settings(sizes: &[u32]) -> Settings {
    Settings::sizes(sizes, &Look { sampling: BrdfSampling::Once, ..look() })
}

fn climbed(sizes: &[u32]) -> Ladder {
    climb(&mut scene(), &look(), &settings(sizes), None, &Quiet, &mut |_| Ok(())).unwrap().unwrap()
}

#[test]
fn a_cut_of_all_leaves_is_the_truth_and_a_single_node_is_not() {
    let ladder = climbed(&[1, 8, 64]);
    let errors: Vec<f64> = ladder.steps.iter().map(|step| step.metrics.rel_rmse).collect();
    assert!(errors[2] < 1e-4, "every leaf, all of them seen: {errors:?}");
    assert!(errors[0] > 10.0 * errors[2].max(1e-3), "negative control: {errors:?}");
    let nodes: Vec<f64> = ladder.steps.iter().map(|step| step.rung.stats.mean_merged_nodes).collect();
    assert_eq!((nodes[0], nodes[2]), (1.0, 64.0));
    assert!(ladder.truth.what.contains("64 samples"), "{}", ladder.truth.what);
}

#[test]
fn each_picture_is_of_its_cuts() {
    let coarse = Look { tau: 0.25, ..look() };
    assert_eq!(Settings::sizes(&[1, 64], &coarse).cuts, [Cuts::Refine(1), Cuts::Refine(64), Cuts::Lit(0.25)]);
    let settings = Settings { cuts: vec![Cuts::Once(1), Cuts::Refine(64), Cuts::Lit(0.25)], frames: 1 };
    let ladder = climb(&mut scene(), &look(), &settings, None, &Quiet, &mut |_| Ok(())).unwrap().unwrap();
    for Step { rung, .. } in &ladder.steps {
        let rendered = scene().show_whole(&rung.cuts.shown(&look())).unwrap();
        assert_eq!(rung.image, rendered.image, "{:?}", rung.cuts);
    }
    let image = |i: usize| &ladder.steps[i].rung.image;
    assert!(image(0) != image(1) && image(1) != image(2) && image(0) != image(2), "negative control");
}

#[test]
fn cuts_are_those_of_a_look_and_back() {
    use BrdfSampling::{Lit, Once, Refine};
    assert_eq!([Once, Refine, Lit].map(|way| Cuts::of(way, 7, 0.5)), [Cuts::Once(7), Cuts::Refine(7), Cuts::Lit(0.5)]);
    assert_eq!([Once, Refine, Lit].map(|way| Cuts::stored(7, way)), [Cuts::Once(7), Cuts::Refine(7), Cuts::Refine(7)]);
    for cuts in [Cuts::Once(7), Cuts::Refine(7), Cuts::Lit(0.5)] {
        let shown = cuts.shown(&look());
        assert_eq!(Cuts::of(shown.sampling, shown.illum_cut, shown.tau), cuts);
    }
    assert_eq!(
        [Cuts::Once(1), Cuts::Refine(512), Cuts::Lit(0.1)].map(Cuts::label),
        ["1 node", "512 nodes", "Lit cuts"]
    );
}

#[test]
fn results_come_as_they_are_found() {
    let mut order = Vec::new();
    let mut found = |found: Found| {
        order.push(match found {
            Found::Picture(rung) => format!("picture {}", rung.cuts.stem()),
            Found::Truth(_) => "truth".into(),
            Found::Step(step) => format!("step {}", step.rung.cuts.stem()),
        });
        Ok(())
    };
    climb(&mut scene(), &look(), &settings(&[1, 2]), None, &Quiet, &mut found).unwrap();
    assert_eq!(order, ["picture 1", "picture 2", "picture lit", "truth", "step 1", "step 2", "step lit"]);
    let known = climbed(&[1]).truth;
    let marked = Truth { what: "known".into(), ..known };
    let again = climb(&mut scene(), &look(), &settings(&[1]), Some(marked), &Quiet, &mut |_| Ok(()));
    assert_eq!(again.unwrap().unwrap().truth.what, "known");
}

#[test]
fn it_stops_when_it_is_told_to() {
    struct Flag(AtomicBool);
    impl Progress for Flag {
        fn advanced(&self, _done: u64, _total: u64) {}
        fn cancelled(&self) -> bool {
            self.0.load(Ordering::SeqCst)
        }
    }
    let flag = Flag(AtomicBool::new(false));
    let mut pictures = 0;
    let mut found = |found: Found| {
        assert!(matches!(found, Found::Picture(_)), "no truth and no errors after it was stopped");
        pictures += 1;
        flag.0.store(true, Ordering::SeqCst);
        Ok(())
    };
    let ladder = climb(&mut scene(), &look(), &settings(&[1, 2, 4]), None, &flag, &mut found).unwrap();
    assert!(ladder.is_none() && pictures == 1);
    let failing = climb(&mut scene(), &look(), &settings(&[1]), None, &Quiet, &mut |_| anyhow::bail!("a full disk"));
    assert!(failing.unwrap_err().to_string().contains("full disk"));
}

#[test]
fn parts_that_are_not_shown_are_not_in_the_truth() {
    let lit = Look { lights: [test_scenes::light()].into(), components: Components::UNBOUNCED, ..look() };
    let mean = |look: &Look| {
        let truth = Truth::trace(scene().baked(), look, &Quiet).unwrap();
        (truth.image.pixels.iter().map(|p| p.y).sum::<f32>(), truth.what)
    };
    let (both, what) = mean(&lit);
    let (sky, _) = mean(&look());
    let only = Components { direct: true, ..Components::NONE };
    let (lamp, _) = mean(&Look { components: only, ..lit.clone() });
    assert!((both - sky - lamp).abs() < 1e-3 * both && lamp > 0.0 && sky > 0.0, "{both} = {sky} + {lamp}");
    assert!(what.contains("1 local light"), "{what}");
}

#[test]
fn sheet_page_and_figures_show_every_step() {
    let ladder = climbed(&[1, 4, 16]);
    let summary = Summary::new(&look(), &ladder, "x-");
    let json = serde_json::to_value(&summary).unwrap();
    for key in ["rel_rmse", "flip", "seconds", "mean_merged_nodes"] {
        assert!(json["steps"].as_array().unwrap().iter().all(|step| step[key].is_number()), "{key}");
    }
    let cuts = |i: usize| ["brdf", "illum_cut", "lit_cuts"].map(|key| json["steps"][i][key].to_string());
    assert_eq!(cuts(0), ["\"once\"", "1", "null"]);
    assert!(cuts(3)[0] == "\"lit\"" && cuts(3)[1] == "null" && cuts(3)[2].starts_with("0.003"), "{:?}", cuts(3));
    let page = super::page(&summary);
    let lit_line = "lit: rel. RMSE";
    for text in ["x-cut-1.png", "x-cut-16.png", "x-cut-lit.png", "x-reference.png", "<svg", lit_line] {
        assert!(page.contains(text), "{text}");
    }
    let stored = Summary { steps: summary.steps[..3].to_vec(), ..summary.clone() };
    assert!(!super::page(&stored).contains(lit_line), "negative control");
    assert!(!page.contains("NaN"));
    let folder = tempfile::tempdir().unwrap();
    write_picture(Found::Picture(&ladder.steps[0].rung), folder.path(), "x-").unwrap();
    assert!(folder.path().join("x-cut-1.exr").is_file() && folder.path().join("x-cut-1.png").is_file());
    let whole = sheet(&ladder, &Post::default());
    let shorter = sheet(&climbed(&[1]), &Post::default());
    assert!(whole.size[0] > shorter.size[0], "four columns against three");
}
