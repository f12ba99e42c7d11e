use super::*;
use crate::{
    actions::{BakeAction, LightAction},
    document::{Component, ComponentSettings, Edit, lights::LightKind},
    test_support::{WIDTH, assert_fits},
};
use egui::{Key, vec2};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use glam::Vec3;
use lapidary_core::{
    dataset::BakeParts,
    lights::{Emission, Light},
    test_scenes,
    transport::BounceEnergy,
};
use lapidary_render::{Baked, Solution, ViewMode};

struct Probe {
    document: Document,
    selected: Option<usize>,
    bounces: Option<BakeParts>,
    baked: Option<BakeParts>,
    energy: Option<BounceEnergy>,
    scene: Option<Baked>,
    panel: LightsPanel,
    actions: Vec<Action>,
}

fn light(kind: LightKind) -> Light {
    Light { name: kind.label().into(), emission: kind.emission(1.0), ..test_scenes::light() }
}

fn panel(selected: Option<usize>, bounces: Option<BakeParts>) -> Harness<'static, Probe> {
    let document = Document { lights: LightKind::ALL.map(light).into(), ..Document::empty() };
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let Probe { document, selected, bounces, baked, energy, scene, panel, actions } = probe;
        let (bounces, baked, energy, scene) = (*bounces, *baked, *energy, scene.as_ref());
        let context = LightsContext {
            document,
            selected: *selected,
            bounces,
            baked,
            energy,
            scene,
            size: [160, 120],
            can_bake: true,
            suns: &[],
        };
        show(ui, panel, &context, actions);
    };
    let probe = Probe {
        document,
        selected,
        bounces,
        baked: None,
        energy: None,
        scene: None,
        panel: LightsPanel::default(),
        actions: Vec::new(),
    };
    let mut panel = Harness::builder().with_size(vec2(WIDTH, 900.0)).build_ui_state(show, probe);
    panel.run();
    assert!(panel.state().actions.is_empty(), "showing asks for nothing");
    assert_fits(&panel, WIDTH);
    panel
}

fn click(panel: &mut Harness<Probe>, label: &str) -> Vec<Action> {
    panel.state_mut().actions.clear();
    panel.get_by_label(label).click();
    panel.run();
    std::mem::take(&mut panel.state_mut().actions)
}

fn typed(panel: &mut Harness<Probe>, label: &str, text: &str) -> Vec<Light> {
    click(panel, label);
    panel.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    panel.get_by_label(label).type_text(text);
    panel.run();
    panel.key_press(Key::Enter);
    panel.run();
    edited(&panel.state().actions)
}

/// The requested lights.
fn edited(actions: &[Action]) -> Vec<Light> {
    let lights = actions.iter().filter_map(|action| match action {
        Action::Edit { edit: Edit::Light { light, .. }, .. } => Some((**light).clone()),
        _ => None,
    });
    lights.collect()
}

fn components(actions: &[Action]) -> Option<ComponentSettings> {
    actions.iter().find_map(|action| match action {
        Action::Edit { edit: Edit::Components(settings), .. } => Some(*settings),
        _ => None,
    })
}

#[test]
fn every_kind_fits_and_has_its_own_numbers() {
    let shows = |panel: &Harness<Probe>, label: &str| panel.query_by_label(label).is_some();
    for (index, kind) in LightKind::ALL.into_iter().enumerate() {
        let panel = panel(Some(index), None);
        assert_eq!(shows(&panel, "Cone"), kind == LightKind::Spot, "{kind:?}");
        assert_eq!(shows(&panel, "Width"), kind == LightKind::Rectangle, "{kind:?}");
        assert_eq!(shows(&panel, "Target X"), kind != LightKind::Point, "{kind:?}");
        assert!(shows(&panel, IntensityUnit::Watts.label(&light(kind))) && shows(&panel, "Position Y"), "{kind:?}");
    }
    assert!(!shows(&panel(None, None), "Intensity"), "negative control: nothing is selected");
}

#[test]
fn intensity_keeps_the_colour_and_the_colour_keeps_the_intensity() {
    let mut panel = panel(Some(0), None);
    let lights = typed(&mut panel, "Intensity value", "6");
    assert!(lights.last().unwrap().intensity.distance(Vec3::new(6.0, 4.0, 2.0)) < 1e-4, "{lights:?}");
    let lights = typed(&mut panel, "Color hex", "#ff0000");
    assert!(lights.last().unwrap().intensity.distance(Vec3::new(3.0, 0.0, 0.0)) < 1e-4, "{lights:?}");
    assert!(
        typed(&mut panel, "Color hex", "#000000").iter().all(|l| l.intensity.max_element() > 2.9),
        "no black light"
    );
}

#[test]
fn a_penumbra_stays_within_its_cone_and_a_light_keeps_a_direction() {
    let mut panel = panel(Some(1), None);
    let lights = typed(&mut panel, "Cone value", "4");
    assert_eq!(
        lights.last().unwrap().emission,
        Emission::Spot { cone_degrees: 4.0, penumbra_degrees: 4.0 },
        "the penumbra was 8"
    );
    assert!(typed(&mut panel, "Target Y", "2").is_empty(), "that is its position");
    assert_eq!(typed(&mut panel, "Target Y", "1").last().unwrap().target, Vec3::Y, "negative control");
}

#[test]
fn lights_are_switched_selected_renamed_and_deleted_in_the_list() {
    let mut panel = panel(Some(1), None);
    let off = click(&mut panel, "Switch off Spot");
    assert!(!edited(&off)[0].enabled && matches!(off.last(), Some(Action::EndGesture)));
    assert!(matches!(click(&mut panel, "Delete Point")[..], [Action::Light(LightAction::Delete(0))]));
    assert!(matches!(click(&mut panel, "Duplicate")[..], [Action::Light(LightAction::Duplicate(1))]));
    panel.state_mut().panel.renaming = Some(list::Renaming::of(1, &LightKind::ALL.map(light)));
    panel.run();
    assert_eq!(typed(&mut panel, "Light name", "Key").last().unwrap().name, "Key");
    click(&mut panel, "Add");
    let add = click_first(&mut panel, "Directional");
    assert!(matches!(add[..], [Action::Light(LightAction::Add(LightKind::Directional))]), "{add:?}");
}

#[test]
fn what_adds_lights_stands_still_while_the_list_grows() {
    let mut panel = panel(None, None);
    let buttons = |panel: &Harness<Probe>| ["Add", "Load...", "Duplicate"].map(|name| panel.get_by_label(name).rect());
    let before = buttons(&panel);
    panel.state_mut().document.lights.push(light(LightKind::Point));
    panel.run();
    assert_eq!(buttons(&panel), before);
    assert!(panel.query_all_by_label("Delete Point").count() == 2, "negative control: there is another row");
}

#[test]
fn a_rename_ends_when_its_row_is_out_of_sight_or_the_list_is_another() {
    let begun = |panel: &mut Harness<Probe>| {
        panel.state_mut().document.lights = (0..100).map(|_| light(LightKind::Spot)).collect();
        panel.state_mut().panel.renaming = Some(list::Renaming::of(1, &panel.state().document.lights.clone()));
        panel.run();
        panel.get_by_label("Light name").type_text("Key ");
        panel.run();
        panel.state_mut().actions.clear();
    };
    let mut panel = panel(None, None);
    begun(&mut panel);
    panel.run();
    assert!(panel.state().panel.renaming.is_some(), "negative control");
    panel.state_mut().document.lights.remove(0);
    panel.run();
    assert!(panel.state().panel.renaming.is_none() && panel.state().actions.is_empty(), "another light is there now");
    begun(&mut panel);
    panel.state_mut().document.lights[1].name = "Renamed elsewhere".into();
    panel.run();
    assert!(panel.state().panel.renaming.is_none() && panel.state().actions.is_empty());
    begun(&mut panel);
    panel.get_all_by_label("Switch off Spot").nth(3).unwrap().hover();
    panel.run();
    panel.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: vec2(0.0, -1500.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
        modifiers: egui::Modifiers::NONE,
    });
    panel.run_steps(30);
    assert!(panel.state().panel.renaming.is_none() && panel.query_by_label("Light name").is_none());
    assert!(edited(&panel.state().actions).last().unwrap().name.contains("Key"), "as by a click elsewhere");
}

#[test]
fn a_touch_leaves_a_large_intensity_large() {
    let mut panel = panel(Some(0), None);
    panel.state_mut().document.lights[0].intensity = Vec3::splat(3e6);
    panel.run();
    panel.get_by_label("Intensity").focus();
    panel.run();
    panel.key_press(Key::ArrowLeft);
    panel.run();
    let light = edited(&panel.state().actions).last().cloned().unwrap();
    assert!((1e6..3e6).contains(&light.intensity.x), "a step of the logarithmic slider: {}", light.intensity);
    assert_eq!(typed(&mut panel, "Intensity value", "1000000000").last().unwrap().intensity, Vec3::splat(1e9));
    panel.state_mut().document.lights[0].intensity = Vec3::splat(1e9);
    panel.run();
    assert_fits(&panel, WIDTH);
}

#[test]
fn clusters_can_be_switched_where_they_show() {
    let mut panel = panel(None, Some(BakeParts::INDIRECT.with(BakeParts::MESHLESS)));
    let works = |panel: &mut Harness<Probe>| {
        panel.run();
        let before = panel.state().panel.shows_clusters;
        click(panel, "Show clusters in the viewport");
        panel.state().panel.shows_clusters != before
    };
    assert!(works(&mut panel), "by cuts");
    let changes: [fn(&mut Document); 3] = [
        |document| document.solution = Solution::Meshless,
        |document| document.components.indirect = false,
        |document| document.view.mode = ViewMode::Normals,
    ];
    for change in changes {
        let before = panel.state().document.clone();
        change(&mut panel.state_mut().document);
        assert!(!works(&mut panel));
        panel.state_mut().document = before;
        assert!(works(&mut panel), "negative control");
    }
}

/// Clicks the last of several with this label: a menu lies over the list.
/// The button of the menu, which stands above the list.
fn click_first(panel: &mut Harness<Probe>, label: &str) -> Vec<Action> {
    panel.state_mut().actions.clear();
    panel.get_all_by_label(label).find(|n| n.accesskit_node().role() == egui::Role::Button).unwrap().click();
    panel.run();
    std::mem::take(&mut panel.state_mut().actions)
}

#[test]
fn the_light_is_placed_at_the_camera_and_aiming_waits_for_a_click() {
    let mut panel = panel(Some(1), None);
    let camera = panel.state().document.camera.clone();
    let placed = edited(&click(&mut panel, "Place at camera"));
    assert_eq!((placed[0].position, placed[0].target), (camera.eye, camera.target));
    assert!(click(&mut panel, "Aim by click").is_empty() && panel.state().panel.aiming);
}

#[test]
fn solo_is_set_and_taken_back_and_switches_stay() {
    let mut panel = panel(None, None);
    let soloed = components(&click(&mut panel, "Solo Bounce")).unwrap();
    assert_eq!(soloed, ComponentSettings { solo: Some(Component::Indirect), ..Default::default() });
    panel.state_mut().document.components = soloed;
    panel.run();
    assert_eq!(components(&click(&mut panel, "Solo Lights")).unwrap().solo, Some(Component::Direct));
    assert_eq!(components(&click(&mut panel, "Solo Bounce")).unwrap(), ComponentSettings::default());
    assert!(!components(&click(&mut panel, "Environment")).unwrap().environment);
}

#[test]
fn solutions_are_those_of_the_bake_and_without_any_a_bake_is_offered() {
    let none = panel(None, Some(BakeParts::NONE));
    assert!(none.query_by_label("Bounce method").is_none());
    let mut none = none;
    let asked = click(&mut none, "Bake with bounced light");
    assert!(matches!(asked[..], [Action::Bake(BakeAction::Choose(BakeParts::CUTS))]), "the environment stays baked");
    none.state_mut().document.bake.mode = BakeParts::INDIRECT;
    none.run();
    let asked = click(&mut none, "Bake with bounced light");
    assert!(matches!(asked[..], [Action::Bake(BakeAction::Choose(BakeParts::INDIRECT))]), "there is nothing to lose");
    none.state_mut().baked = Some(BakeParts::ENVIRONMENT);
    none.run();
    let asked = click(&mut none, "Bake with bounced light");
    assert!(matches!(asked[..], [Action::Bake(BakeAction::Choose(BakeParts::CUTS))]), "the environment is baked");
    let mut both = panel(None, Some(BakeParts::INDIRECT.with(BakeParts::MESHLESS)));
    assert!(both.query_by_label("Bake with bounced light").is_none());
    click(&mut both, "Bounce method");
    let chosen = click(&mut both, "Cuts over meshless");
    let is_it = |a: &Action| matches!(a, Action::Edit { edit: Edit::Solution(Solution::CutsMeshless), .. });
    assert!(chosen.iter().any(is_it), "{chosen:?}");
    let mut cuts = panel(None, Some(BakeParts::INDIRECT));
    click(&mut cuts, "Bounce method");
    assert!(cuts.query_by_label("Meshless").is_none());
}

#[test]
fn a_bake_without_the_environment_says_so_while_it_is_wanted() {
    let mut panel = panel(None, Some(BakeParts::INDIRECT));
    let offers = |panel: &Harness<Probe>| panel.query_by_label("Bake with the environment").is_some();
    assert!(!offers(&panel), "negative control: no bake");
    panel.state_mut().baked = Some(BakeParts::INDIRECT);
    panel.run();
    assert_fits(&panel, WIDTH);
    assert!(matches!(
        click(&mut panel, "Bake with the environment")[..],
        [Action::Bake(BakeAction::Choose(BakeParts::CUTS))]
    ));
    panel.state_mut().document.components.environment = false;
    panel.run();
    assert!(!offers(&panel));
}

#[test]
fn bounces_are_reported_and_missing_light_comes_with_a_remedy() {
    let mut panel = panel(None, Some(BakeParts::INDIRECT.with(BakeParts::MESHLESS)));
    let says = |panel: &Harness<Probe>, text: &str| panel.query_by_label_contains(text).is_some();
    assert!(!says(&panel, "Bounces:"));
    let mut show = |last_share, missing_share| {
        panel.state_mut().energy = Some(BounceEnergy { bounces: 4, last_share, missing_share });
        panel.run();
        assert_fits(&panel, WIDTH);
        (says(&panel, "Bounces: 4, the last carries"), says(&panel, "Lower the base color"), says(&panel, "33 %"))
    };
    assert_eq!(show(0.003, 0.002), (true, false, false));
    assert_eq!(show(0.1, 0.33), (true, true, true));
    assert_eq!(show(0.2, 1.0), (true, true, false), "without end");
}

/// A closed box around the origin whose triangles face outward; lights inside see its back faces.
fn closed_box() -> Baked {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 0.2 - 0.1;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<_> = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut dataset = test_scenes::dataset(&[""], &[]);
    dataset.two_sided = vec![false; triangles.len()];
    dataset.vertex_valid = vec![true; 8];
    let mesh = &mut dataset.scene.mesh;
    mesh.positions = (0..8).map(corner).collect();
    mesh.normals = (0..8).map(|i| corner(i).normalize()).collect();
    mesh.tangents = vec![glam::Vec4::X; 8];
    mesh.uvs = vec![glam::Vec2::ZERO; 8];
    (mesh.triangle_material, mesh.triangle_object) = (vec![0; triangles.len()], vec![0; triangles.len()]);
    mesh.triangles = triangles;
    let baked = Baked::from(dataset);
    baked.intersector();
    baked
}

#[test]
fn a_light_inside_an_object_is_marked_and_told_how_to_mend() {
    let mut panel = panel(Some(0), None);
    panel.state_mut().scene = Some(closed_box());
    let point = Light { position: Vec3::new(0.02, 0.01, 0.0), ..light(LightKind::Point) };
    panel.state_mut().document.lights = vec![point.clone()];
    panel.run();
    let marked = |panel: &Harness<Probe>| panel.query_by_label("Point is inside an object").is_some();
    assert!(marked(&panel) && panel.query_by_label_contains("Move it out").is_some());
    assert_fits(&panel, WIDTH);
    panel.state_mut().document.lights[0].position = Vec3::ONE;
    panel.run();
    assert!(!marked(&panel), "it was moved out");
}

#[test]
fn thousands_of_lights_have_as_many_rows_as_can_be_seen() {
    let mut panel = panel(Some(0), None);
    panel.state_mut().scene = Some(closed_box());
    let numbered = |i| Light { name: format!("Lamp {i}"), ..light(LightKind::Point) };
    panel.state_mut().document.lights = (0..3000).map(numbered).collect();
    let frame = |panel: &mut Harness<'static, Probe>| {
        let start = std::time::Instant::now();
        panel.step();
        start.elapsed()
    };
    // The median, since other tests delay some frames.
    let mut times: Vec<_> = (0..20).map(|_| frame(&mut panel)).collect();
    times.sort_unstable();
    let rows = panel.query_all_by_label_contains("Switch off Lamp").count();
    assert_eq!(rows, 9, "eight and a part");
    assert!(times[10].as_secs_f32() < 0.1, "a frame took {:?}", times[10]);
}
