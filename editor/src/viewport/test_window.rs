//! A viewport without a screen on a synthetic scene, and simulated input.

use super::*;
use crate::{
    actions::{CameraAction, LightAction, SelectAction},
    test_support::two_squares,
    typing::keys_are_commands,
};
use egui::{Event, Modifiers, MouseWheelUnit, PointerButton, Pos2, TextEdit, Vec2, vec2};
use egui_kittest::{Harness, kittest::Queryable};
use glam::Vec3;
use lapidary_core::camera::Camera;

/// The environment of the viewport: a document, a scene and its requests.
pub struct App {
    pub document: Document,
    pub state: ViewportState,
    pub mesh: Mesh,
    pub intersector: Intersector,
    pub selected: Option<u32>,
    pub others: Vec<u32>,
    pub pivot: gizmo::Pivot,
    pub tool: Option<gizmo::Tool>,
    pub selected_light: Option<usize>,
    pub click_for: Option<ClickFor>,
    pub sources: Option<Arc<SourceLighting>>,
    pub shows_clusters: bool,
    pub placeholder: Option<&'static str>,
    pub text: String,
    pub log: Vec<Action>,
    pub last: Option<ViewportResponse>,
}

impl App {
    pub fn new() -> Self {
        let mesh = two_squares();
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 40.0);
        Self {
            document: Document { camera, ..Document::empty() },
            state: ViewportState::default(),
            intersector: Intersector::new(&mesh),
            mesh,
            selected: None,
            others: Vec::new(),
            pivot: gizmo::Pivot::default(),
            tool: None,
            selected_light: None,
            click_for: None,
            sources: None,
            shows_clusters: false,
            placeholder: None,
            text: String::new(),
            log: Vec::new(),
            last: None,
        }
    }

    pub fn context(&self) -> ViewportContext<'_> {
        let bounds = self.mesh.bounds();
        ViewportContext {
            document: &self.document,
            picture: Some(TextureId::default()),
            picture_size: [800, 600],
            faded: None,
            behind: Behind::Checker,
            mesh: Some(&self.mesh),
            intersector: Some(&self.intersector),
            scene_bounds: Some(bounds),
            selected_objects: self.selected.iter().chain(&self.others).copied().collect(),
            selection_bounds: &[],
            movable: self.movable(),
            selected_light: self.selected_light,
            shows_lights: true,
            click_for: self.click_for,
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

    fn movable(&self) -> Option<gizmo::Movable> {
        let (active, tool) = self.selected.zip(self.tool)?;
        let subject = |object| {
            let center = crate::bounds::object_bounds(&self.mesh, object)?.center();
            Some(gizmo::Subject { object, center, middle: center, hinge: None })
        };
        let others = self.others.iter().filter_map(|&object| subject(object)).collect();
        Some(gizmo::Movable { active: subject(active)?, others, pivot: self.pivot, tool })
    }

    fn ui(&mut self, ui: &mut Ui) {
        ui.add(TextEdit::singleline(&mut self.text).hint_text("Search"));
        let (mut state, mut actions) = (std::mem::take(&mut self.state), Vec::new());
        let response = show(ui, &mut state, &self.context(), &mut actions);
        self.state = state;
        self.last = Some(response);
        if keys_are_commands(ui.ctx()) && self.placeholder.is_none() {
            turn_environment(ui.ctx(), &self.document, &mut actions);
        }
        for action in actions {
            self.apply(&action, response);
            self.log.push(action);
        }
    }

    fn apply(&mut self, action: &Action, response: ViewportResponse) {
        match action {
            Action::Camera(CameraAction::To(camera)) => self.document.camera = camera.clone(),
            Action::Edit { edit, .. } => edit.clone().swap(&mut self.document),
            Action::Select(SelectAction::Object(object)) => (self.selected, self.others) = (*object, Vec::new()),
            Action::Light(LightAction::Select(light)) => self.selected_light = *light,
            Action::Camera(CameraAction::FrameSelection) => {
                let bounds = crate::bounds::object_bounds(&self.mesh, self.selected.unwrap_or(0)).unwrap();
                let aspect = response.rect.aspect_ratio();
                self.document.camera = crate::navigation::framed(&self.document.camera, bounds, aspect);
            }
            _ => {}
        }
    }
}

pub fn harness() -> Harness<'static, App> {
    let builder = Harness::builder().with_size([800.0, 620.0]).with_step_dt(1.0 / 60.0);
    let mut harness = builder.build_ui_state(|ui, app: &mut App| app.ui(ui), App::new());
    harness.run();
    harness
}

pub fn viewport_center(harness: &Harness<App>) -> Pos2 {
    harness.get_by_label("Viewport").rect().center()
}

/// Position of a point of the plane z = 0 in the first view.
pub fn seen_at(harness: &Harness<App>, x: f32, y: f32) -> Pos2 {
    let rect = harness.get_by_label("Viewport").rect();
    let focal = 0.5 * rect.height() / 20.0_f32.to_radians().tan();
    rect.center() + focal / 5.0 * vec2(x, -y)
}

pub fn button(harness: &Harness<App>, pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
    harness.event(Event::PointerButton { pos, button, pressed, modifiers });
}

pub fn drag(harness: &mut Harness<App>, which: PointerButton, modifiers: Modifiers, by: Vec2) {
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

pub fn click(harness: &mut Harness<App>, pos: Pos2) {
    click_with(harness, pos, Modifiers::NONE);
}

pub fn click_with(harness: &mut Harness<App>, pos: Pos2, modifiers: Modifiers) {
    harness.event(Event::ModifiersChanged(modifiers));
    harness.hover_at(pos);
    button(harness, pos, PointerButton::Primary, true, modifiers);
    button(harness, pos, PointerButton::Primary, false, modifiers);
    harness.step();
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.step();
}

pub fn scroll(harness: &mut Harness<App>, unit: MouseWheelUnit, delta: Vec2, modifiers: Modifiers) {
    let (phase, source) = (egui::TouchPhase::Move, egui::MouseWheelSource::Unknown);
    harness.event_modifiers(Event::MouseWheel { unit, delta, phase, source, modifiers }, modifiers);
    harness.step();
}

/// Frames without input, so that the next click is not the second of a double click.
pub fn wait(harness: &mut Harness<App>) {
    harness.run_steps(60);
}
