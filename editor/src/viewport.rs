//! The viewport: the picture, and the mouse and keys that move the camera, turn the light and select.
//!
//! | input | does |
//! |---|---|
//! | left drag, Alt + left drag, middle drag, Alt + scroll | orbit |
//! | Shift + left drag, Shift + or Alt + middle drag | pan |
//! | wheel, pinch, Ctrl + middle drag, Alt + right drag | dolly |
//! | right drag, with W A S D Q E (Shift: faster, wheel: speed) | fly |
//! | Shift + right drag, `[` and `]` (Shift: finer) | turn the environment |
//! | click, double click | select, orbit about what is clicked |
//! | Ctrl + click | add an object to the selection, or take it away |
//! | drag of a handle of the selected light or objects | move, turn or scale them (Ctrl: steps, Escape: put them back) |
//! | drop of a preset or a material on a surface | give its material these values |
//!
//! Keys that are pressed once are commands of the window: see `app/keys.rs`.

pub mod camera_text;
mod clusters;
pub mod compare;
mod dropping;
pub mod gate;
pub mod gizmo;
mod input;
mod legend;
pub mod object_menu;
mod outline;
mod paint;
pub mod pick;

pub use input::turn_environment;

use crate::{
    actions::{Action, CameraAction, LightAction, PoseAction, SelectAction},
    document::Document,
    viewport::compare::CompareView,
};
use egui::{Color32, Pos2, Rect, Response, Role, Sense, TextureHandle, TextureId, Ui, WidgetInfo};
use glam::Vec2;
use lapidary_core::{bounds::Bounds, camera::Camera, dataset::BakeParts, ray::Intersector, scene::Mesh};
use lapidary_render::{SourceLighting, ViewMode};
use pick::Picked;
use std::{sync::Arc, time::Duration};

/// State of the viewport between frames.
#[derive(Default)]
pub struct ViewportState {
    gesture: Option<input::Gesture>,
    /// When the wheel last moved the camera, in seconds.
    dollied_at: Option<f64>,
    /// When a scroll last orbited, in seconds.
    orbit_scrolled_at: Option<f64>,
    /// Whether the camera has flown since the right button was pressed.
    has_flown: bool,
    /// Scales the speed of flight.
    fly_pace: input::Pace,
    gizmo: gizmo::Gizmo,
    clusters: clusters::Clusters,
    flash: outline::Flash,
    dropping: dropping::Dropping,
    checker: Option<TextureHandle>,
}

impl ViewportState {
    /// Whether the camera is being flown, so that W, A, S, D, Q and E mean directions.
    pub fn is_flying(&self) -> bool {
        self.gesture.is_some_and(|gesture| gesture.is_flight())
    }
}

/// What a click is for, other than to select.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClickFor {
    /// It aims the selected light.
    Aim,
    /// It places the pivot of the selected object.
    Pivot,
    /// It focuses the camera.
    Focus,
}

impl ClickFor {
    /// What to do, over the picture.
    fn words(self) -> &'static str {
        match self {
            Self::Aim => "Click the point to aim at (Esc: cancel)",
            Self::Focus => "Click what is to be sharp (Esc: cancel)",
            Self::Pivot => "Click an edge for a hinge, or any point to turn about it (Esc: cancel)",
        }
    }

    /// The action that ends the wait without a click.
    fn given_up(self) -> Action {
        match self {
            Self::Aim => Action::Light(LightAction::Aim(None)),
            Self::Focus => Action::Camera(CameraAction::Focus(None)),
            Self::Pivot => Action::Pose(PoseAction::PlacePivot(None)),
        }
    }
}

/// What lies behind a transparent picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behind {
    /// Nothing shows through.
    Nothing,
    /// A checkerboard.
    Checker,
    /// A part of a picture, in texture coordinates.
    Plate(TextureId, Rect),
}

/// A picture that is fading.
#[derive(Clone, Copy, Debug)]
pub struct Faded {
    /// Its texture.
    pub texture: TextureId,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Its opacity, 0 to 1.
    pub opacity: f32,
}

/// Input of the viewport.
pub struct ViewportContext<'a> {
    /// The document.
    pub document: &'a Document,
    /// The picture to show, filtered linearly; `None` until there is one.
    pub picture: Option<TextureId>,
    /// Width and height of the picture in pixels.
    pub picture_size: [u32; 2],
    /// The picture that fades into it.
    pub faded: Option<Faded>,
    /// What lies behind the picture.
    pub behind: Behind,
    /// The shown mesh, for picking.
    pub mesh: Option<&'a Mesh>,
    /// The intersector of that mesh.
    pub intersector: Option<&'a Intersector>,
    /// Bounds of the scene; they set the speed of flight and the reach of the wheel.
    pub scene_bounds: Option<Bounds>,
    /// The selected objects.
    pub selected_objects: Vec<u32>,
    /// Bounds of each selected object, outlined briefly when the selection changes.
    pub selection_bounds: &'a [Bounds],
    /// The selected objects, if they have handles.
    pub movable: Option<gizmo::Movable>,
    /// The selected local light.
    pub selected_light: Option<usize>,
    /// Whether local lights are drawn over the picture and can be selected.
    pub shows_lights: bool,
    /// What the next click is for, other than to select.
    pub click_for: Option<ClickFor>,
    /// Parts of the shown bake.
    pub baked: Option<BakeParts>,
    /// Surface sources under the light of the picture, if bounced light is gathered from them.
    pub sources: Option<&'a Arc<SourceLighting>>,
    /// Whether their clusters are drawn over the lit picture.
    pub shows_clusters: bool,
    /// Color of the outline.
    pub accent: Color32,
    /// Running work, such as "Rendering 40 %".
    pub busy: Option<&'a str>,
    /// Text in place of a picture, which disables mouse and keys.
    pub placeholder: Option<&'a str>,
    /// Whether the picture is of a bake that no longer matches.
    pub stale: bool,
    /// The comparison, if there is one.
    pub compared: Option<compare::Compared<'a>>,
}

impl ViewportContext<'_> {
    /// The sources whose clusters are drawn, over the lit picture only.
    fn clusters(&self) -> Option<&Arc<SourceLighting>> {
        self.sources.filter(|_| self.shows_clusters && self.document.view.mode == ViewMode::Shaded)
    }

    /// Whether things can be drawn over the picture: side by side, they would be misplaced.
    fn can_be_drawn_over(&self) -> bool {
        self.compared.as_ref().is_none_or(|compared| compared.view != CompareView::SideBySide)
    }

    /// Picks what `camera` sees at a position of the window, in a viewport at `rect` of `size_px` pixels.
    fn picked(&self, camera: &Camera, at: Pos2, rect: Rect, size_px: [u32; 2]) -> Option<Picked> {
        let scene = (self.mesh?, self.intersector?);
        pick::pick(scene, self.document.bake.ground, camera, pixel(at, rect, size_px), size_px)
    }

    /// The same through locked objects, for what a click selects.
    fn selectable(&self, camera: &Camera, at: Pos2, rect: Rect, size_px: [u32; 2]) -> Option<Picked> {
        let scene = (self.mesh?, self.intersector?);
        let is_locked = |object: u32| self.document.handling_of(object).locked;
        pick::pick_past(scene, self.document.bake.ground, camera, pixel(at, rect, size_px), size_px, is_locked)
    }
}

/// Output of the viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewportResponse {
    /// Wanted size of the picture, in physical pixels.
    pub size_px: [u32; 2],
    /// Whether the user is moving something, so that pictures should come fast.
    pub moving: bool,
    /// Rectangle of the viewport, for overlays.
    pub rect: Rect,
}

impl ViewportResponse {
    /// Converts a position of the window to the picture, 0 to 1 from the upper left corner; `None` outside.
    pub fn place(&self, at: Pos2) -> Option<Vec2> {
        let place = (at - self.rect.min) / self.rect.size();
        self.rect.contains(at).then_some(Vec2::new(place.x, place.y)).filter(|place| place.is_finite())
    }
}

/// Seconds after the last turn of the wheel until the camera counts as at rest.
const WHEEL_REST_SECS: f64 = 0.15;

/// Shows the viewport in all the room of `ui`. Pushes the user's requests to `actions`.
pub fn show(
    ui: &mut Ui,
    state: &mut ViewportState,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) -> ViewportResponse {
    // Not focusable: its keys work without focus, and Tab goes from panel to panel.
    let (room, _) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
    let rect = gate::gate(room, context.document.view.aspect);
    if rect != room {
        ui.painter().rect_filled(room, 0.0, ui.visuals().extreme_bg_color);
    }
    let response = ui.interact(rect, ui.scope_id().with("viewport"), Sense::CLICK | Sense::DRAG);
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, ui.is_enabled(), "Viewport"));
    let size_px = pixels(rect, ui.pixels_per_point());
    if context.placeholder.is_none() {
        input::handle(ui, &response, size_px, state, context, actions);
        dropping::handle(ui, &response, size_px, &mut state.dropping, context, actions);
        show_menu(&response, size_px, state, context, actions);
    } else {
        input::end_gesture(state, actions);
    }
    paint_all(ui, &response, state, context);
    ViewportResponse { size_px, moving: is_moving(ui, state), rect }
}

/// The menu of a right click, which selects what it hits unless that is selected.
fn show_menu(
    response: &Response,
    size_px: [u32; 2],
    state: &ViewportState,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) {
    // A short flight is no click.
    if response.secondary_clicked() && state.has_flown {
        return;
    }
    let picked = |at: Pos2| context.selectable(&context.document.camera, at, response.rect, size_px);
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.secondary_clicked()) {
        let object = picked(at).map(|picked| picked.object);
        if !object.is_some_and(|object| context.selected_objects.contains(&object)) {
            actions.push(Action::Select(SelectAction::Object(object)));
        }
    }
    let ground = context.mesh.and_then(Mesh::ground_object);
    let objects: Vec<u32> = context.selected_objects.iter().copied().filter(|&o| Some(o) != ground).collect();
    response.context_menu(|ui| object_menu::show(ui, context.document, &objects, actions));
}

fn pixels(rect: Rect, pixels_per_point: f32) -> [u32; 2] {
    let size = rect.size() * pixels_per_point;
    // A float that is negative or NaN becomes 0.
    [size.x, size.y].map(|side| (side.round() as u32).max(1))
}

/// Converts a position of the window to pixels of the picture.
fn pixel(at: Pos2, rect: Rect, size_px: [u32; 2]) -> Vec2 {
    let share = (at - rect.min) / rect.size();
    Vec2::new(share.x * size_px[0] as f32, share.y * size_px[1] as f32)
}

fn is_moving(ui: &Ui, state: &ViewportState) -> bool {
    let since_wheel = state.dollied_at.map(|at| ui.input(|input| input.time) - at);
    let on_wheel = since_wheel.filter(|&secs| secs < WHEEL_REST_SECS);
    if let Some(secs) = on_wheel {
        // Requests the picture at rest.
        ui.request_repaint_after(Duration::from_secs_f64(WHEEL_REST_SECS - secs));
    }
    state.gesture.is_some() || state.gizmo.is_dragging() || on_wheel.is_some()
}

fn paint_all(ui: &mut Ui, response: &Response, state: &mut ViewportState, context: &ViewportContext) {
    let rect = response.rect;
    paint::picture(ui, rect, state, context);
    let view = context.compared.as_ref().map(|compared| compared.view);
    if let Some(compared) = &context.compared {
        let camera = &context.document.camera;
        compare::paint(ui, rect, camera, context.picture.map(|texture| (texture, context.picture_size)), compared);
    }
    if let Some(text) = context.placeholder {
        paint::placeholder(ui, rect, text);
    } else if !context.can_be_drawn_over() {
        paint::badges(ui, rect, context);
    } else {
        let clusters = context.clusters().zip(context.intersector);
        if let Some((sources, intersector)) = clusters {
            state.clusters.paint(ui, rect, &context.document.camera, intersector, sources);
        }
        outline(ui, rect, state, context);
        dropping::paint(ui, rect, &state.dropping, context);
        gizmo::paint(ui, rect, &state.gizmo, context);
        if view != Some(CompareView::Difference) {
            legend::paint(&ui.painter_at(rect), rect, context);
        }
        paint::badges(ui, rect, context);
    }
    if context.document.view.safe_frames && context.placeholder.is_none() {
        gate::paint_safe(&ui.painter_at(rect), rect);
    }
    paint::drop_hint(ui, rect, context.accent);
}

fn outline(ui: &Ui, rect: Rect, state: &mut ViewportState, context: &ViewportContext) {
    let glow = state.flash.update(&context.selected_objects, ui.input(|input| input.time));
    if glow.opacity > 0.0 {
        let color = context.accent.gamma_multiply(glow.opacity);
        for bounds in context.selection_bounds {
            outline::paint(&ui.painter_at(rect), rect, &context.document.camera, *bounds, color);
        }
    }
    if let Some(secs) = glow.next_secs {
        ui.request_repaint_after(Duration::from_secs_f32(secs));
    }
}

#[cfg(test)]
mod test_window;
#[cfg(test)]
mod tests;
