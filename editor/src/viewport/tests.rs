//! The viewport in a window without a screen: what mouse and keys do to a made-up scene.

mod camera;

use super::*;
use crate::document::Edit;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, TextEdit, Vec2, pos2, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;
use lapidary_core::camera::Camera;

/// Two squares that face +Z: object 0 of material 1 on the left, object 1 of material 0 on the right.
pub(super) fn two_squares() -> Mesh {
    let square = |x: f32| [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(u, v)| Vec3::new(x + u, v, 0.0));
    Mesh {
        positions: [square(-1.0), square(1.0)].concat(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
        triangle_material: vec![1, 1, 0, 0],
        triangle_object: vec![0, 0, 1, 1],
        ..Default::default()
    }
}

pub(super) struct App {
    pub(super) document: Document,
    state: ViewportState,
    mesh: Mesh,
    intersector: Intersector,
    selected: Option<u32>,
    pub(super) selected_light: Option<usize>,
    pub(super) aiming: bool,
    sources: Option<Arc<SourceLighting>>,
    shows_clusters: bool,
    placeholder: Option<&'static str>,
    text: String,
    pub(super) log: Vec<Action>,
    pub(super) last: Option<ViewportResponse>,
}

impl App {
    fn new() -> Self {
        let mesh = two_squares();
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 40.0);
        Self {
            document: Document { camera, ..Document::empty() },
            state: ViewportState::default(),
            intersector: Intersector::new(&mesh),
            mesh,
            selected: None,
            selected_light: None,
            aiming: false,
            sources: None,
            shows_clusters: false,
            placeholder: None,
            text: String::new(),
            log: Vec::new(),
            last: None,
        }
    }

    fn context(&self) -> ViewportContext<'_> {
        let bounds = self.mesh.bounds();
        ViewportContext {
            document: &self.document,
            picture: Some(TextureId::default()),
            picture_size: [800, 600],
            checker: true,
            mesh: Some(&self.mesh),
            intersector: Some(&self.intersector),
            scene_bounds: Some(bounds),
            selected_object: self.selected,
            selection_bounds: self.selected.and_then(|object| pick::object_bounds(&self.mesh, object)),
            selected_light: self.selected_light,
            shows_lights: true,
            aiming: self.aiming,
            baked: Some(BakeParts::ENVIRONMENT),
            sources: self.sources.as_ref(),
            shows_clusters: self.shows_clusters,
            accent: Color32::ORANGE,
            busy: Some("Rendering 40 %"),
            placeholder: self.placeholder,
            stale: true,
            compared: None,
        }
    }

    fn ui(&mut self, ui: &mut Ui) {
        ui.add(TextEdit::singleline(&mut self.text).hint_text("Search"));
        let (mut state, mut actions) = (std::mem::take(&mut self.state), Vec::new());
        let response = show(ui, &mut state, &self.context(), &mut actions);
        self.state = state;
        self.last = Some(response);
        for action in actions {
            self.apply(&action, response);
            self.log.push(action);
        }
    }

    fn apply(&mut self, action: &Action, response: ViewportResponse) {
        match action {
            Action::Camera(camera) => self.document.camera = camera.clone(),
            Action::Edit { edit, .. } => edit.clone().swap(&mut self.document),
            Action::SelectObject(object) => self.selected = *object,
            Action::SelectLight(light) => self.selected_light = *light,
            Action::FrameSelection => {
                let bounds = pick::object_bounds(&self.mesh, self.selected.unwrap_or(0)).unwrap();
                let aspect = response.rect.aspect_ratio();
                self.document.camera = navigation::framed(&self.document.camera, bounds, aspect);
            }
            _ => {}
        }
    }
}

pub(super) fn harness() -> Harness<'static, App> {
    let builder = Harness::builder().with_size([800.0, 620.0]).with_step_dt(1.0 / 60.0);
    let mut harness = builder.build_ui_state(|ui, app: &mut App| app.ui(ui), App::new());
    harness.run();
    harness
}

fn viewport_center(harness: &Harness<App>) -> Pos2 {
    harness.get_by_label("Viewport").rect().center()
}

/// Where a point of the plane z = 0 is seen by the camera at the start.
pub(super) fn seen_at(harness: &Harness<App>, x: f32, y: f32) -> Pos2 {
    let rect = harness.get_by_label("Viewport").rect();
    let focal = 0.5 * rect.height() / 20.0_f32.to_radians().tan();
    rect.center() + focal / 5.0 * vec2(x, -y)
}

pub(super) fn button(harness: &Harness<App>, pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
    harness.event(Event::PointerButton { pos, button, pressed, modifiers });
}

fn drag(harness: &mut Harness<App>, which: PointerButton, modifiers: Modifiers, by: Vec2) {
    let from = viewport_center(harness);
    harness.event(Event::ModifiersChanged(modifiers));
    harness.hover_at(from);
    button(harness, from, which, true, modifiers);
    harness.hover_at(from + 0.5 * by);
    harness.hover_at(from + by);
    button(harness, from + by, which, false, modifiers);
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.step();
}

pub(super) fn click(harness: &mut Harness<App>, pos: Pos2) {
    harness.hover_at(pos);
    button(harness, pos, PointerButton::Primary, true, Modifiers::NONE);
    button(harness, pos, PointerButton::Primary, false, Modifiers::NONE);
    harness.step();
}

fn scroll(harness: &mut Harness<App>, unit: MouseWheelUnit, delta: Vec2, modifiers: Modifiers) {
    let (phase, source) = (egui::TouchPhase::Move, egui::MouseWheelSource::Unknown);
    harness.event_modifiers(Event::MouseWheel { unit, delta, phase, source, modifiers }, modifiers);
    harness.step();
}

/// Frames without input, so that the next click is not the second of a double click.
fn wait(harness: &mut Harness<App>) {
    harness.run_steps(60);
}

fn camera(harness: &Harness<App>) -> Camera {
    harness.state().document.camera.clone()
}

fn start() -> Camera {
    App::new().document.camera
}

#[test]
fn a_click_selects_the_object_under_it_and_nothing_beside_it() {
    let mut harness = harness();
    let right = seen_at(&harness, 1.0, 0.2);
    click(&mut harness, right);
    assert_eq!(harness.state().selected, Some(1));
    assert!(matches!(harness.state().log[1], Action::SelectMaterial(Some(0))));
    assert_eq!(camera(&harness), start(), "a click does not move the camera");
    wait(&mut harness);
    let left = seen_at(&harness, -1.0, 0.2);
    click(&mut harness, left);
    assert_eq!(harness.state().selected, Some(0));
    wait(&mut harness);
    let between = seen_at(&harness, 0.0, 0.0);
    click(&mut harness, between);
    assert_eq!(harness.state().selected, None);
}

#[test]
fn a_shift_right_drag_turns_what_is_seen_with_the_pointer() {
    let mut harness = harness();
    drag(&mut harness, PointerButton::Secondary, Modifiers::SHIFT, vec2(120.0, 0.0));
    let turned = harness.state().document.environment.rotation().to_degrees();
    assert!((turned + 30.0).abs() < 0.01, "{turned}");
    // What was straight ahead is now to the right of the camera, which looks along -Z with +X to its right.
    let ahead = glam::Quat::from_rotation_y(turned.to_radians()) * Vec3::NEG_Z;
    assert!(ahead.x > 0.4);
    let log = &harness.state().log;
    assert!(matches!(log[0], Action::Edit { edit: Edit::Environment(_), label: "Rotate environment" }));
    assert_eq!(log.iter().filter(|action| matches!(action, Action::EndGesture)).count(), 1);
    assert!(matches!(log.last(), Some(Action::EndGesture)));
    assert_eq!(camera(&harness), start());
}

#[test]
fn brackets_turn_the_environment_and_shift_does_so_finely() {
    let mut harness = harness();
    harness.key_press(Key::CloseBracket);
    harness.step();
    assert_eq!(harness.state().document.environment.rotation_degrees, -5.0);
    assert!(matches!(harness.state().log.last(), Some(Action::EndGesture)));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::OpenCurlyBracket);
    harness.step();
    assert_eq!(harness.state().document.environment.rotation_degrees, -4.0);
}

#[test]
fn typing_in_a_text_field_does_not_move_anything() {
    let mut harness = harness();
    harness.get_by_role(Role::TextInput).click();
    harness.step();
    let keys = [Key::F, Key::A, Key::Home, Key::CloseBracket, Key::W];
    for key in keys {
        harness.key_press(key);
    }
    harness.step();
    assert!(harness.state().log.is_empty(), "{:?}", harness.state().log);
    // Negative control: after a press in the viewport the same keys act.
    let center = viewport_center(&harness);
    click(&mut harness, center);
    harness.state_mut().log.clear();
    for key in keys {
        harness.key_press(key);
    }
    harness.step();
    assert!(harness.state().log.len() >= 4);
}

#[test]
fn nothing_acts_while_nothing_is_open() {
    let mut harness = harness();
    harness.state_mut().placeholder = Some("Open a scene, or drop one here");
    drag(&mut harness, PointerButton::Primary, Modifiers::NONE, vec2(100.0, 0.0));
    harness.key_press(Key::F);
    harness.step();
    assert!(harness.state().log.is_empty());
    harness.get_by_label("Open a scene, or drop one here");
    assert!(harness.query_by_label("Rendering 40 %").is_none());
}

#[test]
fn words_over_the_picture_are_there_and_let_clicks_through() {
    let mut harness = harness();
    harness.get_by_label("Bake is out of date");
    let words = harness.get_by_label("Rendering 40 %").rect();
    click(&mut harness, words.center());
    assert!(matches!(harness.state().log[0], Action::SelectObject(None)));
}

#[test]
fn each_count_mode_has_its_legend_and_the_lit_picture_none() {
    let mut harness = harness();
    let shown = |harness: &Harness<App>, words: &str| {
        let is_text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
            egui::Shape::Text(text) => text.galley.text() == words,
            _ => false,
        };
        harness.output().shapes.iter().any(is_text)
    };
    let title = "Merged cut size, environment";
    assert!(!shown(&harness, title) && !shown(&harness, "1024+"));
    harness.state_mut().document.view.mode = ViewMode::MergedCut;
    harness.step();
    assert!(shown(&harness, title) && shown(&harness, "1024+"));
}

#[test]
fn the_size_asked_for_is_in_physical_pixels_and_idling_asks_for_nothing() {
    let mut harness = harness();
    harness.set_pixels_per_point(2.0);
    harness.run_steps(3);
    let response = harness.state().last.unwrap();
    let expected = [response.rect.width() * 2.0, response.rect.height() * 2.0].map(|side| side.round() as u32);
    assert_eq!(response.size_px, expected);
    assert!(harness.run() <= 2, "an idle viewport settles at once");
    assert_eq!(pixels(Rect::from_min_max(pos2(5.0, 5.0), pos2(0.0, f32::NAN)), 1.0), [1, 1]);
}

#[test]
fn clusters_lie_over_the_lit_picture_only() {
    let mut app = App::new();
    app.sources = Some(Arc::new(clusters::tests::lighting(4)));
    assert!(app.context().clusters().is_none(), "they are not asked for");
    app.shows_clusters = true;
    for mode in ViewMode::ALL {
        app.document.view.mode = mode;
        assert_eq!(app.context().clusters().is_some(), mode == ViewMode::Shaded, "{mode:?}");
    }
}
