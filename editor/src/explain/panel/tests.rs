use super::*;
use crate::test_support::{WIDTH, assert_fits};
use egui::vec2;
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;
use lapidary_core::{camera::Camera, environment::Environment, image::Image, test_scenes::dataset};
use lapidary_render::{BrdfSampling, CutLight, Illumination, Quiet, Region, Renderer, SplitJob, View};

/// Input of a panel, and its last request.
#[derive(Default)]
struct Probe {
    explanation: Option<PixelExplanation>,
    map: Option<Arc<CutMap>>,
    split: Option<ErrorSplit>,
    progress: Option<f32>,
    message: Option<&'static str>,
    outdated: bool,
    panel: ExplainPanel,
    asked: Option<ExplainRequest>,
}

/// The middle of a triangle under an uneven sky.
fn explained() -> Probe {
    let renderer = Renderer::new(dataset(&["white"], &[]));
    let map = Image::from_fn([32, 16], |x, y| Vec3::new(1.0 + (x * y % 7) as f32, 1.0, 0.5));
    let environment = Environment::new("test".into(), map).into();
    let light = Illumination { environment, rotation: 0.0, intensity: 1.0, sun: None };
    let lighting = renderer.lighting(&light, 64);
    let camera = Camera::look_at(Vec3::new(0.2, 1.0, 0.21), Vec3::new(0.2, 0.0, 0.2), 20.0);
    let view = View::new(camera, [9, 7]);
    let cut_light = CutLight::Environment(&lighting);
    let explanation = renderer.explain(&view, [4, 3], cut_light, BrdfSampling::Once).unwrap();
    let map = renderer.cut_map(&explanation, cut_light, 64);
    let job = SplitJob {
        view: &view,
        region: Region::whole(view.size),
        light: cut_light,
        sampling: BrdfSampling::Once,
        illumination: &light,
        lights: &[],
        spp: 4,
        trace_vertex: None,
    };
    let split = renderer.split_error(&job, &Quiet).unwrap();
    Probe { explanation: Some(explanation), map: Some(map.into()), split, ..Probe::default() }
}

fn panel(probe: Probe) -> Harness<'static, Probe> {
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let context = ExplainContext {
            explanation: probe.explanation.as_ref(),
            map: probe.map.as_ref(),
            split: probe.split.as_ref(),
            progress: probe.progress,
            message: probe.message,
            outdated: probe.outdated,
        };
        let asked = show(ui, &mut probe.panel, &context);
        probe.asked = asked.or(probe.asked);
    };
    let mut panel = Harness::builder().with_size(vec2(WIDTH, 1800.0)).build_ui_state(show, probe);
    panel.run();
    panel
}

#[test]
fn a_pixel_has_its_cuts_its_map_and_its_greatest_nodes() {
    let panel = panel(explained());
    assert_fits(&panel, WIDTH);
    for label in
        ["Pixel 4, 3", "Vertex 2", "64 nodes, 0 of them unlit", "Merged cut on the map of directions", "and 14 more"]
    {
        assert!(panel.query_by_label(label).is_some(), "{label}");
    }
    let explanation = panel.state().explanation.as_ref().unwrap();
    let greatest = &explanation.nodes[explanation.by_contribution()[0]];
    assert!(panel.query_all_by_label(&greatest.heap_index.to_string()).next().is_some());
    let without = self::panel(Probe { message: Some("That is the background."), ..Probe::default() });
    assert!(without.query_by_label("That is the background.").is_some());
    assert!(without.query_by_label("Merged").is_none(), "negative control");
}

#[test]
fn an_explanation_of_what_was_before_says_so() {
    let mut old = panel(Probe { outdated: true, ..explained() });
    assert_fits(&old, WIDTH);
    assert!(old.query_by_label("The picture has changed since.").is_some());
    old.get_by_label("Explain again").click();
    old.run();
    assert_eq!(old.state().asked, Some(ExplainRequest::Again));
    assert!(panel(explained()).query_by_label("Explain again").is_none(), "negative control");
}

#[test]
fn columns_sort_both_ways() {
    let mut panel = panel(explained());
    let smallest = |panel: &Harness<Probe>| {
        let nodes = &panel.state().explanation.as_ref().unwrap().nodes;
        nodes.iter().map(|node| node.heap_index).min().unwrap().to_string()
    };
    let name = smallest(&panel);
    let height = |panel: &Harness<Probe>| panel.query_by_label(&name).map(|node| node.rect().top());
    panel.get_by_label("Sort by node").click();
    panel.run();
    assert_eq!(height(&panel), None, "the least index of 64 is beyond the 50 greatest");
    panel.get_by_label("Sort by node").click();
    panel.run();
    let top = height(&panel).expect("now it is the first");
    let heading = panel.get_by_label("Sort by node").rect();
    assert!((0.0..30.0).contains(&(top - heading.bottom())), "{top} under {heading:?}");
}

#[test]
fn a_node_that_is_pointed_at_is_told() {
    let mut panel = panel(explained());
    assert_eq!(panel.state().panel.hovered_node(), None);
    let explanation = panel.state().explanation.as_ref().unwrap();
    let greatest = explanation.by_contribution()[0];
    let name = explanation.nodes[greatest].heap_index.to_string();
    panel.get_by_label(&name).hover();
    panel.run();
    assert_eq!(panel.state().panel.hovered_node(), Some(greatest));
}

#[test]
fn the_map_can_be_chosen_and_sources_have_no_difference() {
    let mut panel = panel(explained());
    panel.get_by_label("Difference").click();
    panel.run();
    assert_eq!(panel.state().panel.map.picture, map::MapPicture::Visibility);
    let map = panel.state().map.clone().unwrap();
    panel.state_mut().map = Some(Arc::new(CutMap { visibility: None, ..(*map).clone() }));
    panel.run();
    assert_eq!(panel.state().panel.map.picture, map::MapPicture::Cut);
    panel.get_by_label("Difference").click();
    panel.run();
    assert_eq!(panel.state().panel.map.picture, map::MapPicture::Cut, "it is disabled");
}

#[test]
fn bars_tell_every_cause_and_the_split_is_asked_for_and_cancelled() {
    let mut panel = panel(explained());
    let split = panel.state().split.as_ref().unwrap();
    assert_eq!(split.steps.len(), 4);
    let texts = split.steps.iter().chain([&split.total]).map(|step| {
        let mut name = step.factor.to_owned();
        name[..1].make_ascii_uppercase();
        format!("{name} {:.1} %", 100.0 * step.rel_rmse)
    });
    for text in texts.collect::<Vec<_>>() {
        assert!(panel.query_by_label(&text).is_some(), "{text}");
    }
    panel.get_by_label("Split again").click();
    panel.run();
    assert_eq!(panel.state().asked, Some(ExplainRequest::Split));
    let mut running = self::panel(Probe { progress: Some(0.25), ..Probe::default() });
    assert!(running.query_by_label("Split the error").is_none(), "negative control");
    running.get_by_label("Cancel").click();
    running.run();
    assert_eq!(running.state().asked, Some(ExplainRequest::CancelSplit));
}
