use super::*;
use crate::{
    actions::BakeAction,
    bake::stale::stale_reasons,
    document::Edit,
    test_support::{WIDTH, assert_fits, baked_triangle},
};
use egui::{Key, vec2};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    dataset::{BakeAudit, BakeParts, BakeSettings},
    light_tree::TreeKind,
    shot::Shot,
};
use lapidary_precompute::Preset;

struct Probe {
    document: Document,
    dataset: Option<Dataset>,
    status: BakeStatus,
    actions: Vec<Action>,
}

fn document() -> Document {
    Document { scene: Some("scene.obj".into()), ..Document::empty() }
}

fn panel(status: BakeStatus, document: Document, dataset: Option<Dataset>) -> Harness<'static, Probe> {
    panel_of_scene(1000, status, document, dataset)
}

fn panel_of_scene(
    vertices: usize,
    status: BakeStatus,
    document: Document,
    dataset: Option<Dataset>,
) -> Harness<'static, Probe> {
    let show = move |ui: &mut Ui, probe: &mut Probe| {
        let Probe { document, dataset, status, actions } = probe;
        let scene_stats = Some(SceneStats { vertices, triangles: 2 * vertices });
        let dataset = dataset.as_ref();
        let context = BakeContext {
            document,
            dataset,
            status,
            reasons: &[],
            scene_stats,
            trial: None,
            bounce_trial: None,
            cores: 2,
        };
        show(ui, &context, actions);
    };
    let probe = Probe { document, dataset, status, actions: Vec::new() };
    let mut panel = Harness::builder().with_size(vec2(WIDTH, 900.0)).build_ui_state(show, probe);
    panel.run();
    assert!(panel.state().actions.is_empty(), "showing asks for nothing");
    assert_fits(&panel, WIDTH);
    panel
}

/// Clicks the control of this label and returns the actions.
fn clicked(panel: &mut Harness<Probe>, label: &str) -> Vec<Action> {
    panel.get_by_label(label).click();
    panel.run();
    std::mem::take(&mut panel.state_mut().actions)
}

fn bake_asked(actions: &[Action]) -> Option<BakeSettings> {
    actions.iter().find_map(|action| match action {
        Action::Edit { edit: Edit::Bake(bake), .. } => Some((**bake).clone()),
        _ => None,
    })
}

#[test]
fn bake_resume_and_cancel_ask_for_what_they_say() {
    let mut fresh = panel(BakeStatus::None, document(), None);
    assert!(matches!(clicked(&mut fresh, "Bake")[..], [Action::Bake(BakeAction::Begin { resume: false })]));
    assert!(fresh.query_by_label("Resume").is_none() && fresh.query_by_label("Cancel").is_none());
    let mut stopped = panel(BakeStatus::Cancelled { leftover: Leftover::Fitting }, document(), None);
    assert!(matches!(clicked(&mut stopped, "Resume")[..], [Action::Bake(BakeAction::Begin { resume: true })]));
    assert!(matches!(clicked(&mut stopped, "Start over")[..], [Action::Bake(BakeAction::Begin { resume: false })]));
    let failed =
        BakeStatus::Failed { message: "the disk is full; free some space".into(), leftover: Leftover::Nothing };
    let failed = panel(failed, document(), None);
    assert!(failed.query_by_label_contains("disk is full").is_some() && failed.query_by_label("Resume").is_none());
    let other = panel(BakeStatus::Cancelled { leftover: Leftover::OfAnother }, document(), None);
    assert!(other.query_by_label("Resume").is_none() && other.query_by_label("Bake").is_some());
    assert!(other.query_by_label_contains("other settings").is_some());
}

#[test]
fn a_running_bake_shows_progress_and_can_be_cancelled() {
    let running = BakeStatus::Running {
        mode: BakeParts::ENVIRONMENT,
        draft: Draft::None,
        phase: Phase::Visibility,
        done: 250,
        total: 1000,
        unit: "points",
        cancelling: false,
        elapsed_secs: 30.0,
        left_secs: Some(60.0),
    };
    let mut panel = panel(running, document(), None);
    assert!(panel.query_by_label("250 of 1,000 points").is_some());
    assert!(panel.query_by_label("About 1 min 00 s left in this step, longer while you work").is_some());
    let percent = |name: &str| panel.get_by_label(name).accesskit_node().numeric_value();
    let phases = ["Pilot visibility progress", "Environment visibility progress", "Writing the bake progress"];
    assert_eq!(phases.map(percent), [Some(100.0), Some(25.0), Some(0.0)]);
    assert!(panel.query_by_label("Bake").is_none());
    assert!(panel.query_by_label("Source visibility progress").is_none(), "negative control: no bounces");
    assert!(panel.query_by_label_contains("Canceling").is_none());
    assert!(matches!(clicked(&mut panel, "Cancel")[..], [Action::Bake(BakeAction::Cancel)]));
    let BakeStatus::Running { cancelling, .. } = &mut panel.state_mut().status else { panic!("it runs") };
    *cancelling = true;
    panel.run();
    assert!(
        panel.query_by_label("250 of 1,000 points").is_some() && panel.query_by_label_contains("Canceling").is_some()
    );
    assert!(clicked(&mut panel, "Cancel").is_empty(), "once is enough");
}

#[test]
fn a_bake_of_bounces_shows_its_own_phases() {
    let running = BakeStatus::Running {
        mode: BakeParts::INDIRECT,
        draft: Draft::Shown,
        phase: Phase::SourceVisibility,
        done: 300,
        total: 400,
        unit: "points",
        cancelling: false,
        elapsed_secs: 9.0,
        left_secs: Some(1.0),
    };
    let panel = panel(running, document(), None);
    let percent = |name: &str| panel.get_by_label(name).accesskit_node().numeric_value();
    let phases = ["Reading the scene", "Building the source tree", "Source visibility", "Writing the bake"];
    let percent = |name: &str| percent(&format!("{name} progress"));
    assert_eq!(phases.map(percent), [Some(100.0), Some(100.0), Some(75.0), Some(0.0)]);
    let others = ["Environment visibility", "Meshless basis"];
    assert!(others.iter().all(|name| panel.query_by_label(name).is_none()));
    assert!(panel.query_by_label_contains("shows the draft").is_some());
}

#[test]
fn a_stale_bake_is_named_with_its_reasons() {
    let stale = BakeStatus::Stale { reasons: vec!["The scene file changed since the bake".into()] };
    let mut outdated = panel(stale, document(), Some(baked_triangle()));
    assert!(outdated.query_by_label("The bake is out of date").is_some());
    assert!(outdated.query_by_label_contains("scene file changed").is_some());
    assert!(matches!(clicked(&mut outdated, "Bake")[..], [Action::Bake(BakeAction::Begin { resume: false })]));
    let current = panel(BakeStatus::UpToDate, document(), Some(baked_triangle()));
    assert!(current.query_by_label("The bake is out of date").is_none(), "negative control");
}

#[test]
fn reasons_name_both_values_and_only_what_differs() {
    let (mut document, mut dataset) = (document(), baked_triangle());
    assert_eq!(stale_reasons(&document, &dataset, Some("abc")), [""; 0]);
    assert_eq!(stale_reasons(&document, &dataset, None), [""; 0], "an unknown scene is no reason");
    assert_eq!(stale_reasons(&document, &dataset, Some("other")), ["The scene file changed since the bake"]);
    document.bake.lights = 8192;
    document.bake.max_vertices = None;
    let expected = ["Lights: 8,192 now, 32,768 in the bake", "Vertices: no limit now, 100,000 in the bake"];
    assert_eq!(stale_reasons(&document, &dataset, Some("abc")), expected);
    // A geometric tree ignores beta.
    (document.bake, dataset.settings) = (Preset::Normal.settings(), Preset::Normal.settings());
    (document.bake.tree, dataset.settings.tree) = (TreeKind::Geometric, TreeKind::Geometric);
    document.bake.beta = 0.9;
    assert_eq!(stale_reasons(&document, &dataset, None), [""; 0]);
}

#[test]
fn presets_show_their_cost_and_set_everything() {
    let mut panel = panel(BakeStatus::None, document(), None);
    for cost in ["100,000", "49 s", "34.0 MB"] {
        assert!(panel.query_by_label(cost).is_some(), "{cost}");
    }
    assert!(panel.query_by_label("Custom").is_none());
    assert!(panel.query_by_label_contains("estimates").is_some());
    assert_eq!(bake_asked(&clicked(&mut panel, "Draft")), Some(Preset::Draft.settings()));
}

#[test]
fn settings_out_of_range_are_named_and_cannot_be_baked() {
    let mut wrong = document();
    wrong.bake.max_vertices = Some(1);
    let mut wrong = panel(BakeStatus::None, wrong, None);
    assert!(wrong.query_by_label("Custom").is_some());
    assert!(wrong.query_by_label_contains("Max vertices is 1, but must lie between 3").is_some());
    assert!(clicked(&mut wrong, "Bake").is_empty());
    let mut alone = panel(BakeStatus::None, Document::empty(), None);
    assert!(alone.query_by_label_contains("Open the scene file").is_some());
    assert!(clicked(&mut alone, "Bake").is_empty());
}

#[test]
fn advanced_settings_are_typed_ticked_and_chosen() {
    let mut panel = panel(BakeStatus::None, document(), None);
    assert!(clicked(&mut panel, "Advanced").is_empty());
    panel.run();
    assert_fits(&panel, WIDTH);
    panel.get_by_label("Sigma value").click();
    panel.run();
    panel.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    panel.get_by_label("Sigma value").type_text("1.25");
    panel.run();
    panel.key_press(Key::Enter);
    panel.run();
    let asked = bake_asked(&std::mem::take(&mut panel.state_mut().actions)).expect("an edit");
    let mut expected = Preset::Normal.settings();
    expected.criterion.sigma = 1.25;
    assert_eq!(asked, expected);
    assert_eq!(bake_asked(&clicked(&mut panel, "Byte budget")).expect("an edit").max_bytes, Some(64_000_000));
    assert_eq!(bake_asked(&clicked(&mut panel, "Max vertices")).expect("an edit").max_vertices, None);
    clicked(&mut panel, "Lights");
    assert_eq!(bake_asked(&clicked(&mut panel, "8,192")).expect("an edit").lights, 8192);
}

#[test]
fn advanced_settings_of_bounces_are_those_that_the_bake_has() {
    let open = |mode: BakeParts| {
        let mut document = document();
        document.bake.mode = mode;
        let mut panel = panel(BakeStatus::None, document, None);
        clicked(&mut panel, "Advanced");
        panel.run();
        assert_fits(&panel, WIDTH);
        panel
    };
    let shown =
        |mode: BakeParts| ["Source sigma value", "Epsilon value"].map(|l| open(mode).query_by_label(l).is_some());
    assert_eq!(shown(BakeParts::ENVIRONMENT), [false, false]);
    assert_eq!(shown(BakeParts::CUTS), [true, false]);
    assert_eq!(shown(BakeParts::MESHLESS), [false, true]);
    assert_eq!(shown(BakeParts::ALL), [true, true]);

    let mut panel = open(BakeParts::ALL);
    clicked(&mut panel, "Sources");
    assert_eq!(bake_asked(&clicked(&mut panel, "4,096")).expect("an edit").indirect.sources, 4096);
    clicked(&mut panel, "Gather rays");
    assert_eq!(bake_asked(&clicked(&mut panel, "1,024")).expect("an edit").meshless.rays, 1024);
    clicked(&mut panel, "Basis levels");
    let fewer = bake_asked(&clicked(&mut panel, "3")).expect("an edit").meshless;
    assert_eq!((fewer.levels, fewer.sender_levels), (3, 3), "no more levels send than there are");
}

#[test]
fn a_bake_is_for_the_views_that_are_chosen() {
    let asked = |document: Document, name: &str| {
        let mut panel = panel(BakeStatus::None, document, None);
        panel.get_by_label("Views").click();
        panel.run();
        match &clicked(&mut panel, name)[..] {
            [Action::Bake(BakeAction::ForViews(cameras))] => cameras.clone(),
            _ => panic!("no views"),
        }
    };
    let shown = |document: &Document, name: &str| {
        panel(BakeStatus::None, document.clone(), None).query_by_value(name).is_some()
    };
    let mut document = document();
    assert!(shown(&document, "All views") && !shown(&document, "This view"));
    assert_eq!(asked(document.clone(), "This view"), [document.camera.clone()]);
    let shot = |camera: &Camera| Shot { camera: camera.clone(), aspect: 1.5 };
    document.bake.shots = vec![shot(&document.camera)];
    assert!(shown(&document, "This view"));
    assert_eq!(asked(document.clone(), "All views"), []);
    document.camera.eye.x += 1.0;
    assert!(shown(&document, "Another view"), "the camera has moved");
    document.bookmarks = vec![document.camera.clone(), Camera::look_at(Vec3::ONE, Vec3::ZERO, 30.0)];
    assert_eq!(asked(document.clone(), "Bookmarked views"), document.bookmarks);
    document.bake.shots = document.bookmarks.iter().map(shot).collect();
    assert!(shown(&document, "Bookmarked views"));
    document.bookmarks.pop();
    assert!(shown(&document, "Other views"));
}

#[test]
fn presets_leave_room_for_vertices_and_keep_the_views() {
    let mut dense = document();
    dense.bake.shots = vec![Shot { camera: dense.camera.clone(), aspect: 1.5 }];
    let shots = dense.bake.shots.clone();
    let mut panel = panel_of_scene(57_810, BakeStatus::None, dense, None);
    panel.get_by_label("Draft").click();
    panel.run();
    let asked = bake_asked(&panel.state().actions).expect("a preset");
    assert_eq!((asked.max_vertices, asked.shots), (Some(72_262), shots));
}

#[test]
fn the_report_shows_its_table_and_warnings() {
    let mut dataset = baked_triangle();
    dataset.report.audit = Some(BakeAudit { leaves_per_probe: 16, leaves_wrong: 1e-4, ..Default::default() });
    let with = panel(BakeStatus::UpToDate, document(), Some(dataset));
    for label in ["Mean cut", "Visibility error", "Lights missed", "a corner is thin", "Nodes of the visibility cuts"] {
        assert!(with.query_by_label(label).is_some(), "{label}");
    }
    assert_fits(&with, WIDTH);
    let without = panel(BakeStatus::None, document(), None);
    assert!(without.query_by_label("Mean cut").is_none());
}

#[test]
fn what_is_baked_is_chosen_and_presets_keep_it() {
    let mut document = document();
    document.bake.mode = BakeParts::ALL;
    let mut both = panel(BakeStatus::None, document, None);
    both.get_by_label("Draft").click();
    both.run();
    let preset = both.state().actions.iter().find_map(|action| match action {
        Action::Edit { edit: Edit::Bake(bake), .. } => Some((bake.mode, bake.lights)),
        _ => None,
    });
    assert_eq!(preset, Some((BakeParts::ALL, Preset::Draft.settings().lights)));
    both.state_mut().actions.clear();
    both.get_by_label("Bake type").click();
    both.run();
    assert!(both.query_by_label_contains("Takes longest").is_some(), "what it gives and costs");
    both.get_by_label("Bounced light").click();
    both.run();
    assert!(matches!(both.state().actions[..], [Action::Bake(BakeAction::Choose(BakeParts::INDIRECT))]));
}
