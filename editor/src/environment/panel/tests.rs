use super::*;
use crate::{
    actions::{EnvironmentAction, FileAction},
    test_support::{WIDTH, assert_fits},
};
use egui::{Key, vec2};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};
use lapidary_core::image::Image;
use lapidary_render::SceneLighting;

struct Probe {
    document: Document,
    library: Vec<LibraryEntry>,
    environment: Arc<Environment>,
    light: Option<(LightTree, Arc<EnvironmentLight>)>,
    message: Option<&'static str>,
    panel: EnvironmentPanel,
    actions: Vec<Action>,
}

fn probe(spec: &str) -> Probe {
    let mut document = Document::empty();
    document.environment.spec = spec.into();
    let entry = |name: &str, missing| LibraryEntry {
        name: name.into(),
        spec: format!("/maps/{name}.exr"),
        missing,
        thumbnail: None,
    };
    let map = Image::from_fn([16, 8], |x, _| Vec3::splat(x as f32));
    Probe {
        document,
        library: vec![entry("Harbor", false), entry("Attic", true)],
        environment: Arc::new(Environment::new("test".into(), map)),
        light: None,
        message: None,
        panel: EnvironmentPanel::default(),
        actions: Vec::new(),
    }
}

fn panel(probe: Probe) -> Harness<'static, Probe> {
    let show = |ui: &mut Ui, probe: &mut Probe| {
        let context = EnvironmentContext {
            lacks_ground: false,
            document: &probe.document,
            environment: Some(&probe.environment),
            library: &probe.library,
            tree: probe.light.as_ref().map(|l| &l.0),
            lighting: probe.light.as_ref().map(|l| &l.1),
            light_revision: 1,
            message: probe.message,
        };
        show(ui, &mut probe.panel, &context, &mut probe.actions);
        show_library(ui, &mut probe.panel, &context, &mut probe.actions);
    };
    // Thumbnails come from threads, and each asks for another frame.
    let builder = Harness::builder().with_size(vec2(WIDTH, 800.0)).with_max_steps(20);
    let mut panel = builder.build_ui_state(show, probe);
    panel.run();
    assert!(panel.state().actions.is_empty(), "showing asks for nothing");
    assert_fits(&panel, WIDTH);
    panel
}

/// The requested lights.
fn asked(panel: &Harness<Probe>) -> Vec<EnvironmentSettings> {
    let lights = panel.state().actions.iter().filter_map(|action| match action {
        Action::Edit { edit: Edit::Environment(light), .. } => Some(light.clone()),
        _ => None,
    });
    lights.collect()
}

fn typed(panel: &mut Harness<Probe>, label: &str, text: &str) -> EnvironmentSettings {
    panel.get_by_label(label).click();
    panel.run();
    panel.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    panel.get_by_label(label).type_text(text);
    panel.run();
    panel.key_press(Key::Enter);
    panel.run();
    asked(panel).pop().expect("an edit")
}

#[test]
fn a_drag_to_the_right_takes_the_map_along() {
    let mut panel = panel(probe("studio"));
    let rect = panel.get_by_label("Environment map").rect();
    panel.drag_at(rect.center());
    panel.step();
    // A twelfth of the width is thirty degrees.
    panel.hover_at(rect.center() + vec2(rect.width() / 12.0, 20.0));
    panel.step();
    assert!(!panel.state().actions.iter().any(|a| matches!(a, Action::EndGesture)));
    panel.drop_at(rect.center() + vec2(rect.width() / 12.0, 20.0));
    panel.run();
    let light = asked(&panel).pop().expect("an edit");
    assert!((light.rotation_degrees + 30.0).abs() < 0.1, "{}", light.rotation_degrees);
    assert!(matches!(panel.state().actions.last(), Some(Action::EndGesture)));
}

#[test]
fn a_typed_rotation_wraps() {
    assert_eq!([0.0, 180.0, -180.0, 190.0, 540.0, -270.0].map(wrapped), [0.0, 180.0, -180.0, -170.0, -180.0, 90.0]);
    let mut panel = panel(probe("studio"));
    assert_eq!(typed(&mut panel, "Rotation value", "270").rotation_degrees, -90.0);
    assert_eq!(typed(&mut panel, "Rotation value", "45").rotation_degrees, 45.0);
}

#[test]
fn intensity_is_typed_and_shown_in_stops() {
    let mut panel = panel(probe("studio"));
    assert!(panel.query_by_label("+0.0 EV").is_some());
    let light = typed(&mut panel, "Intensity value", "4");
    assert_eq!(light, EnvironmentSettings { intensity: 4.0, ..Default::default() });
    panel.state_mut().document.environment = light;
    panel.run();
    assert!(panel.query_by_label("+2.0 EV").is_some());
    assert_eq!(stops_text(0.0), "off");
}

#[test]
fn a_color_space_is_given_to_a_map_and_left_behind_with_it() {
    let mut map = panel(probe("/maps/Harbor.exr"));
    map.get_by_label("Color space").click();
    map.run();
    map.get_by_label("ACEScg").click();
    map.run();
    let given = asked(&map).pop().expect("an edit");
    let kept = EnvironmentSettings { spec: "/maps/Harbor.exr".into(), ..Default::default() };
    assert_eq!(given, EnvironmentSettings { color_space: ColorSpace::AcesCg, ..kept });
    assert_eq!(given.with_map("studio"), EnvironmentSettings::default());
    let [layer, other] = ["Harbor.exr#depth", "Market.exr"].map(|map| given.with_map(&format!("/maps/{map}")));
    assert_eq!((layer.color_space, other.color_space), (ColorSpace::AcesCg, ColorSpace::Srgb), "of the same file");
    assert_eq!(layer.with_map("/maps/Harbor.exr"), given);
    let formula = EnvironmentSettings { color_space: ColorSpace::AcesCg, ..Default::default() };
    assert_eq!(formula.with_map("sun-sky").color_space, ColorSpace::Srgb, "a formula has no file");
    assert!(panel(probe("studio")).query_by_label("Color space").is_none(), "formulas are in Rec. 709");
}

#[test]
fn orientation_and_library_are_chosen() {
    let mut panel = panel(probe("studio"));
    panel.get_by_label("Orientation: Blender, three.js").click();
    panel.run();
    assert_eq!(asked(&panel).pop().expect("an edit").orientation, Orientation::Blender);
    for (name, spec) in [("Harbor", "/maps/Harbor.exr"), ("Sun and sky", "sun-sky:45")] {
        panel.get_by_label(name).click();
        panel.run();
        assert_eq!(asked(&panel).pop().expect("an edit").spec, spec);
    }
    panel.state_mut().actions.clear();
    panel.get_by_label("Studio").click();
    panel.run();
    assert!(panel.state().actions.is_empty(), "it is chosen already");
}

#[test]
fn formulas_and_maps_stand_under_headings() {
    let panel = panel(probe("studio"));
    let top = |label: &str| panel.get_by_label(label).rect().top();
    let tops = ["Formulas", "Studio", "Constant", "Maps", "Harbor"].map(top);
    assert!(tops.is_sorted(), "{tops:?}");
}

#[test]
fn a_missing_map_is_looked_for_and_not_loaded() {
    let mut panel = panel(probe("studio"));
    panel.get_by_label("Attic").click();
    panel.run();
    assert!(matches!(panel.state().actions[..], [Action::File(FileAction::Relink(None))]));
}

#[test]
fn buttons_ask_for_files() {
    let mut panel = panel(probe("studio"));
    panel.get_by_label("Load...").click();
    panel.run();
    panel.get_by_label("Add to library...").click();
    panel.run();
    assert!(matches!(
        panel.state().actions[..],
        [
            Action::Environment(EnvironmentAction::Load(None)),
            Action::Environment(EnvironmentAction::AddToLibrary(None))
        ]
    ));
}

#[test]
fn formulas_show_their_numbers_and_files_do_not() {
    let mut sky = panel(probe("sun-sky:30"));
    assert_eq!(typed(&mut sky, "Sun height value", "12.5").spec, "sun-sky:12.5");
    let mut constant = panel(probe("constant:0.5"));
    assert_eq!(typed(&mut constant, "Color hex", "#ff0000").spec, "constant:1,0,0");
    let file = panel(probe("/maps/Harbor.exr"));
    assert!(file.query_by_label("Sun height value").is_none() && file.query_by_label("Color hex").is_none());
    assert_eq!(["constant:1,2", "constant:1,x"].map(constant_radiance), [None; 2]);
}

#[test]
fn samples_and_cut_are_shown_where_there_is_a_tree() {
    let tree = LightTree::geometric(256).unwrap();
    let lighting = SceneLighting::new(&tree, &[Vec3::ONE; 256], 4).into();
    let mut panel = panel(Probe { light: Some((tree, lighting)), ..probe("studio") });
    let is_enabled = |panel: &Harness<Probe>| !panel.get_by_label("Subtree depth").accesskit_node().is_disabled();
    let place = panel.get_by_label("Light cut").rect();
    assert!(!is_enabled(&panel));
    panel.get_by_label("Light samples").click();
    panel.run();
    assert!(is_enabled(&panel));
    assert_eq!(panel.get_by_label("Light cut").rect(), place, "nothing moves");
    panel.get_by_label("Light cut").click();
    panel.run();
    assert!(panel.state().actions.is_empty(), "what is shown is no edit");
}

#[test]
fn the_pointer_tells_about_a_node() {
    let tree = LightTree::geometric(256).unwrap();
    let lighting = SceneLighting::new(&tree, &[Vec3::splat(2.0); 256], 256).into();
    let mut panel = panel(Probe { light: Some((tree.clone(), lighting)), ..probe("studio") });
    let rect = panel.get_by_label("Environment map").rect();
    let leaf = lapidary_core::environment::uv_from_direction(tree.leaf_directions()[77]);
    let at = rect.min + vec2(leaf.x, leaf.y) * rect.size();
    let tells = |panel: &mut Harness<Probe>| {
        panel.hover_at(at);
        panel.run_steps(8);
        panel.query_by_label_contains("Mean radiance 2.000").is_some()
    };
    assert!(!tells(&mut panel), "negative control: the cut is not shown");
    panel.get_by_label("Light cut").click();
    panel.run();
    assert!(tells(&mut panel));
}

#[test]
fn a_message_is_shown() {
    let text = "The map cannot be read; choose another (/maps/x.exr)";
    let with = panel(Probe { message: Some(text), ..probe("studio") });
    assert!(with.query_by_label(text).is_some());
    assert!(panel(probe("studio")).query_by_label(text).is_none());
}
