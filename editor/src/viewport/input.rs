//! Turns input of mouse, trackpad and keys into camera moves, turns of the environment and selections.

mod keys;

pub use keys::turn_environment;

use super::{ViewportContext, ViewportState, gizmo, pick::Picked, pixel};
use crate::{
    actions::{Action, CameraAction, SelectAction},
    document::{Edit, EnvironmentSettings},
    navigation,
};
use egui::{CursorIcon, Event, InputState, Modifiers, MouseWheelUnit, PointerButton, Pos2, Response, Ui};
use glam::Vec2;
use lapidary_core::camera::Camera;
use std::f32::consts::PI;

/// Degrees of the environment's turn per point of a drag.
const ENVIRONMENT_DEGREES_PER_POINT: f32 = 0.25;

/// Points per notch of a wheel, as in the rest of the interface.
const POINTS_PER_LINE: f32 = 40.0;

/// Seconds after a scroll with Alt in which its remainder (momentum of a trackpad, a smoothed notch) does not dolly.
const ORBIT_SCROLL_SECS: f64 = 0.3;

/// Natural logarithm of the change of distance per point of scrolling and dragging.
const DOLLY_PER_POINT: f32 = 0.004;

/// Turn of the view in flight for a drag over the height of the viewport, in fields of view.
const LOOK_RATE: f32 = 2.0;

/// Speed of flight in diagonals of the scene a second, and its factor with Shift.
const FLY_SPEED: f32 = 0.3;
const FLY_FASTER: f32 = 4.0;

/// A drag that began in the viewport. Its kind is fixed at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gesture {
    kind: Kind,
    button: PointerButton,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Orbit,
    Pan,
    Dolly,
    Fly,
    TurnEnvironment,
}

impl Gesture {
    fn of(button: PointerButton, modifiers: Modifiers) -> Self {
        let kind = match button {
            PointerButton::Primary if modifiers.shift => Kind::Pan,
            PointerButton::Middle if modifiers.shift || modifiers.alt => Kind::Pan,
            PointerButton::Middle if modifiers.command => Kind::Dolly,
            PointerButton::Secondary if modifiers.shift => Kind::TurnEnvironment,
            PointerButton::Secondary if modifiers.alt => Kind::Dolly,
            PointerButton::Secondary => Kind::Fly,
            _ => Kind::Orbit,
        };
        Self { kind, button }
    }

    pub(super) fn is_flight(self) -> bool {
        self.kind == Kind::Fly
    }

    fn cursor(self) -> CursorIcon {
        match self.kind {
            Kind::Orbit | Kind::Pan => CursorIcon::Grabbing,
            Kind::Dolly => CursorIcon::ResizeVertical,
            Kind::Fly => CursorIcon::Crosshair,
            Kind::TurnEnvironment => CursorIcon::ResizeHorizontal,
        }
    }
}

/// Factor of the speed of flight, set by the wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace(f32);

impl Default for Pace {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Reads all input of a frame.
pub(super) fn handle(
    ui: &Ui,
    response: &Response,
    size_px: [u32; 2],
    state: &mut ViewportState,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) {
    let camera = context.document.camera.clone();
    let can_grab = state.gesture.is_none() && (context.can_be_drawn_over() || state.gizmo.is_dragging());
    let on_handles = can_grab && gizmo::handle(ui, response, &mut state.gizmo, context, actions);
    let mut pass = Pass { ui, response, size_px, state, context, actions, camera };
    if !on_handles {
        pass.drags();
        pass.clicks();
    }
    pass.scrolls();
    if pass.camera != context.document.camera {
        pass.actions.push(Action::Camera(CameraAction::To(pass.camera)));
    }
}

/// Ends the current drag, if any.
pub(super) fn end_gesture(state: &mut ViewportState, actions: &mut Vec<Action>) {
    if state.gesture.take().is_some_and(|gesture| gesture.kind == Kind::TurnEnvironment) {
        actions.push(Action::EndGesture);
    }
}

/// The input of one frame.
struct Pass<'a> {
    ui: &'a Ui,
    response: &'a Response,
    size_px: [u32; 2],
    state: &'a mut ViewportState,
    context: &'a ViewportContext<'a>,
    actions: &'a mut Vec<Action>,
    /// The camera after the input so far.
    camera: Camera,
}

impl Pass<'_> {
    fn drags(&mut self) {
        if let Some(gesture) = self.state.gesture
            && !self.input(|input| input.pointer.button_down(gesture.button))
        {
            end_gesture(self.state, self.actions);
        }
        if self.state.gesture.is_none() {
            self.state.has_flown &= !self.input(|input| input.pointer.any_pressed());
            self.state.gesture = self.begun();
        }
        let Some(gesture) = self.state.gesture else { return };
        self.ui.set_cursor_icon(gesture.cursor());
        // A pen may come down elsewhere than it left, which is no drag.
        let delta = self.input(|i| if i.pointer.any_pressed() { egui::Vec2::ZERO } else { i.pointer.delta() });
        self.drag(gesture.kind, Vec2::new(delta.x, delta.y));
        if gesture.is_flight() {
            self.fly();
        }
    }

    /// A press that became a drag. Only the left button waits for that, since it selects too.
    fn begun(&self) -> Option<Gesture> {
        let held = |button| self.input(|input| input.pointer.button_down(button));
        let on_viewport = self.response.is_pointer_button_down_on();
        let button = if self.response.dragged_by(PointerButton::Primary) {
            PointerButton::Primary
        } else {
            [PointerButton::Middle, PointerButton::Secondary].into_iter().find(|&b| on_viewport && held(b))?
        };
        // The viewport takes the keys from now on.
        self.ui.memory_mut(|memory| memory.stop_text_input());
        Some(Gesture::of(button, self.input(|input| input.modifiers)))
    }

    fn drag(&mut self, kind: Kind, delta: Vec2) {
        if delta == Vec2::ZERO {
            return;
        }
        let height = self.height();
        let look = delta * LOOK_RATE * self.camera.fov_y / height;
        self.camera = match kind {
            Kind::Orbit => return self.orbit(delta),
            Kind::TurnEnvironment => return self.turn_environment(-ENVIRONMENT_DEGREES_PER_POINT * delta.x),
            Kind::Pan => navigation::pan(&self.camera, delta, height),
            Kind::Fly => navigation::look(&self.camera, -look.x, look.y),
            Kind::Dolly => {
                let factor = (DOLLY_PER_POINT * delta.y).exp();
                navigation::dolly(&self.camera, factor, self.camera.target, self.scene_size())
            }
        };
    }

    /// Orbits with the pointer: half a turn for a drag over the height of the viewport.
    fn orbit(&mut self, delta: Vec2) {
        let turn = delta * PI / self.height();
        self.camera = navigation::orbit(&self.camera, -turn.x, turn.y);
    }

    fn fly(&mut self) {
        let (motion, faster, secs) =
            self.input(|input| (keys::flight_direction(input), input.modifiers.shift, input.stable_dt));
        if motion == glam::Vec3::ZERO {
            return;
        }
        self.state.has_flown = true;
        let speed = FLY_SPEED * self.scene_size() * self.state.fly_pace.0 * if faster { FLY_FASTER } else { 1.0 };
        self.camera = navigation::fly(&self.camera, motion, speed, secs);
        self.ui.request_repaint();
    }

    fn scrolls(&mut self) {
        if !self.response.contains_pointer() {
            return;
        }
        if self.scroll_orbits() {
            return;
        }
        let (scroll, zoom) = self.input(|i| (i.smooth_scroll_delta.y, i.zoom_delta()));
        let change = (-DOLLY_PER_POINT * scroll).exp() / zoom;
        if self.state.is_flying() {
            self.state.fly_pace.0 = (self.state.fly_pace.0 / change).clamp(0.01, 100.0);
        } else if change != 1.0 {
            self.dolly_toward_pointer(change);
        }
    }

    /// Orbits by scrolling with Alt, and by its remainder. Returns whether it does.
    fn scroll_orbits(&mut self) -> bool {
        let (scrolled, alt, now) = self.input(|input| (scrolled(input), input.modifiers.alt, input.time));
        let goes_on = self.state.orbit_scrolled_at.is_some_and(|at| now - at < ORBIT_SCROLL_SECS);
        if scrolled != Vec2::ZERO && (alt || goes_on) {
            self.state.orbit_scrolled_at = Some(now);
            self.orbit(scrolled);
            return true;
        }
        goes_on
    }

    fn dolly_toward_pointer(&mut self, factor: f32) {
        let Some(pointer) = self.input(|input| input.pointer.latest_pos()) else { return };
        let picked = self.picked(pointer).map(|picked| picked.position);
        let toward = picked.unwrap_or_else(|| {
            navigation::point_on_target_plane(
                &self.camera,
                pixel(pointer, self.response.rect, self.size_px),
                self.size_px,
            )
        });
        self.camera = navigation::dolly(&self.camera, factor, toward, self.scene_size());
        self.state.dollied_at = Some(self.input(|input| input.time));
    }

    fn clicks(&mut self) {
        let Modifiers { alt, command, .. } = self.input(|input| input.modifiers);
        let (Some(_), Some(pointer)) = (self.context.intersector, self.response.interact_pointer_pos()) else { return };
        if alt || !self.response.clicked_by(PointerButton::Primary) {
            return;
        }
        let picked = self.context.selectable(&self.camera, pointer, self.response.rect, self.size_px);
        if command {
            self.actions.extend(picked.map(|picked| Action::Select(SelectAction::Toggle(picked.object))));
        } else if !self.response.double_clicked() {
            self.actions.push(Action::Select(SelectAction::Object(picked.map(|picked| picked.object))));
            let part = picked.map(|picked| picked.part());
            self.actions
                .push(Action::Select(SelectAction::Material(part.map(|part| self.context.document.material_of(part)))));
            self.actions.extend(part.map(|part| Action::Select(SelectAction::Part(part))));
        } else if let Some(picked) = picked {
            self.camera = navigation::centered_on(&self.camera, picked.position);
        }
    }

    /// Turns the environment counter-clockwise seen from above.
    fn turn_environment(&mut self, degrees: f32) {
        self.actions.push(turn(&self.context.document.environment, degrees));
    }

    fn picked(&self, pointer: Pos2) -> Option<Picked> {
        self.context.picked(&self.camera, pointer, self.response.rect, self.size_px)
    }

    fn height(&self) -> f32 {
        self.response.rect.height().max(1.0)
    }

    /// Diagonal of the scene in meters.
    fn scene_size(&self) -> f32 {
        let diagonal = self.context.scene_bounds.map(|bounds| bounds.diagonal());
        diagonal.filter(|&size| size > 0.0).unwrap_or_else(|| self.camera.eye.distance(self.camera.target))
    }

    fn input<R>(&self, read: impl FnOnce(&InputState) -> R) -> R {
        self.ui.input(read)
    }
}

fn turn(environment: &EnvironmentSettings, degrees: f32) -> Action {
    Action::Edit { edit: Edit::Environment(turned(environment, degrees)), label: "Rotate environment" }
}

/// The environment turned by `degrees`, wrapped to -180 to 180.
fn turned(environment: &EnvironmentSettings, degrees: f32) -> EnvironmentSettings {
    let rotation = (environment.rotation_degrees + degrees + 180.0).rem_euclid(360.0) - 180.0;
    EnvironmentSettings { rotation_degrees: rotation, ..environment.clone() }
}

/// Points scrolled in both directions; egui's smoothed scroll has only one with Alt.
fn scrolled(input: &InputState) -> Vec2 {
    let points = |event: &Event| match event {
        Event::MouseWheel { unit: MouseWheelUnit::Point, delta, .. } => Vec2::new(delta.x, delta.y),
        Event::MouseWheel { unit: MouseWheelUnit::Line, delta, .. } => POINTS_PER_LINE * Vec2::new(delta.x, delta.y),
        _ => Vec2::ZERO,
    };
    input.events.iter().map(points).sum()
}
