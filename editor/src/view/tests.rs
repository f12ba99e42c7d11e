use super::{
    lens::{focal_from_fov, fov_from_focal},
    *,
};
use crate::{
    actions::CameraAction,
    test_support::{WIDTH, assert_fits},
};
use egui::{Key, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use lapidary_core::camera::{Camera, Lens};

type Panel = Harness<'static, (Document, Vec<Action>)>;

fn panel(document: Document) -> Panel {
    let show = |ui: &mut Ui, (document, actions): &mut (Document, Vec<Action>)| {
        show(ui, &ViewContext { document, focusing: false }, actions);
    };
    let mut panel = Harness::builder().with_size(vec2(WIDTH, 800.0)).build_ui_state(show, (document, Vec::new()));
    panel.run();
    assert!(panel.state().1.is_empty(), "showing asks for nothing");
    assert_fits(&panel, WIDTH);
    panel
}

fn typed(panel: &mut Panel, label: &str, text: &str) {
    panel.get_by_label(label).click();
    panel.run();
    panel.key_press_modifiers(egui::Modifiers::COMMAND, Key::A);
    panel.get_by_label(label).type_text(text);
    panel.run();
    panel.key_press(Key::Enter);
    panel.run();
}

/// The last requested view, and the number of requests.
fn asked(panel: &Panel) -> (ViewSettings, usize) {
    let views = panel.state().1.iter().filter_map(|action| match action {
        Action::Edit { edit: Edit::View(view), .. } => Some(view.clone()),
        _ => None,
    });
    let views: Vec<ViewSettings> = views.collect();
    (views.last().cloned().expect("an edit"), views.len())
}

fn camera_asked(panel: &Panel) -> Option<Camera> {
    panel.state().1.iter().rev().find_map(|action| match action {
        Action::Camera(CameraAction::To(camera)) => Some(camera.clone()),
        _ => None,
    })
}

#[test]
fn typing_an_exposure_changes_it_once_and_nothing_else() {
    let mut panel = panel(Document::empty());
    typed(&mut panel, "Exposure value", "1.5");
    let (view, edits) = asked(&panel);
    let mut expected = ViewSettings::default();
    assert_ne!(view, expected, "negative control");
    expected.post.exposure = 1.5;
    assert_eq!((view, edits), (expected, 1));
    assert!(matches!(panel.state().1.last(), Some(Action::EndGesture)));
}

#[test]
fn lists_choose_tone_map_background_and_mode() {
    type Check = fn(&ViewSettings) -> bool;
    let rows: [(&str, &str, Check); 3] = [
        ("Tone map", "AgX", |v| v.post.tone_map == ToneMap::AgX),
        ("Background", "Blurred environment", |v| v.background == BackgroundKind::Blurred),
        ("Show", "Merged cut size", |v| v.mode == ViewMode::MergedCut),
    ];
    for (list, choice, is_set) in rows {
        let mut panel = panel(Document::empty());
        panel.get_by_role_and_label(egui::Role::ComboBox, list).click();
        panel.run();
        panel.get_by_label(choice).click();
        panel.run();
        assert!(is_set(&asked(&panel).0) && !is_set(&ViewSettings::default()), "{list}");
    }
}

#[test]
fn presets_and_counts_set_the_cut_and_the_samples() {
    let mut document = Document::empty();
    document.view.sampling = BrdfSampling::Refine;
    let mut panel = panel(document);
    assert!(panel.query_by_label("Lit cut error value").is_none(), "lit cuts are not merged");
    panel.get_by_label("Light cut 64").click();
    panel.run();
    assert_eq!(asked(&panel).0.illum_cut, 64);
    typed(&mut panel, "Samples value", "900");
    assert_eq!(asked(&panel).0.aa, 256, "clamped to the range");
    typed(&mut panel, "Frame budget value", "33");
    assert_eq!(asked(&panel).0.frame_budget_ms, 33.0);
    panel.get_by_label("Cuts: Paper").click();
    panel.get_by_label("Wireframe").click();
    panel.run();
    assert!(asked(&panel).0.wireframe);
    let once = |a: &Action| matches!(a, Action::Edit { edit: Edit::View(v), .. } if v.sampling == BrdfSampling::Once);
    assert!(panel.state().1.iter().any(once));
}

#[test]
fn blur_and_color_show_only_where_they_act() {
    let with = |background| {
        let mut document = Document::empty();
        document.view.background = background;
        let panel = panel(document);
        (panel.query_by_label("Blur").is_some(), panel.query_by_label("Color hex").is_some())
    };
    assert_eq!(with(BackgroundKind::Environment), (false, false));
    assert_eq!(with(BackgroundKind::Blurred), (true, false));
    assert_eq!(with(BackgroundKind::Flat), (false, true));
}

#[test]
fn focal_length_and_field_of_view_are_one() {
    assert!((fov_from_focal(50.0, 24.0).to_degrees() - 26.991).abs() < 1e-2);
    assert!((focal_from_fov(fov_from_focal(35.0, 18.0), 18.0) - 35.0).abs() < 1e-4);
    let mut panel = panel(Document::empty());
    typed(&mut panel, "Focal length value", "50");
    let camera = camera_asked(&panel).expect("a camera");
    assert!((camera.fov_y.to_degrees() - 26.991).abs() < 1e-2);
    assert_eq!(camera.eye, Document::empty().camera.eye);
}

#[test]
fn a_camera_in_its_own_target_is_not_asked_for() {
    let mut document = Document::empty();
    document.camera = Camera::look_at(glam::Vec3::new(0.0, 0.0, 2.0), glam::Vec3::ZERO, 40.0);
    let mut panel = panel(document);
    typed(&mut panel, "Position Z", "0");
    assert_eq!(camera_asked(&panel), None);
    typed(&mut panel, "Position Z", "3");
    assert_eq!(camera_asked(&panel).expect("a camera").eye.z, 3.0);
}

#[test]
fn the_lens_is_opened_focused_and_shifted_and_a_sensor_keeps_the_field_of_view() {
    let mut panel = panel(Document::empty());
    assert!(panel.query_by_label("Focus by click").is_none(), "negative control: a pinhole has no focus");
    panel.get_by_label("F-number").click();
    panel.run();
    let opened = camera_asked(&panel).expect("a camera");
    assert_eq!(opened.lens.f_number, Some(lens::OPENED));
    panel.state_mut().0.camera = opened.clone();
    panel.run();
    panel.get_by_label("Focus by click").click();
    panel.run();
    assert!(matches!(panel.state().1.last(), Some(Action::Camera(CameraAction::AskForFocus))));
    panel.get_by_label("Focus").click();
    panel.run();
    let distance = Document::empty().camera.focus_distance();
    assert_eq!(camera_asked(&panel).unwrap().lens.focus, Some(distance), "that of the target");
    typed(&mut panel, "Shift up value", "0.25");
    assert_eq!(camera_asked(&panel).unwrap().lens.shift.y, 0.25);
    panel.get_by_role_and_label(egui::Role::ComboBox, "Sensor").click();
    panel.run();
    panel.get_by_label("Super 35").click();
    panel.run();
    let smaller = camera_asked(&panel).unwrap();
    assert_eq!((smaller.lens.sensor_mm, smaller.fov_y), (18.66, opened.fov_y));
    assert!(smaller.focal_length() < opened.focal_length());
}

#[test]
fn a_click_focuses_at_its_depth_and_opens_a_pinhole() {
    let camera = Document::empty().camera;
    let focused = lens::focused(&camera, 1.5);
    assert_eq!(focused.lens, Lens { f_number: Some(lens::OPENED), focus: Some(1.5), ..camera.lens });
    let open = Camera { lens: Lens { f_number: Some(8.0), ..camera.lens }, ..camera };
    assert_eq!(lens::focused(&open, 3.0).lens.f_number, Some(8.0), "an open lens keeps its aperture");
}
