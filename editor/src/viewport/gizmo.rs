//! Handles over the picture: icons select local lights, handles move the selected light or pose the selected objects.
//!
//! A drag of a handle is one step of undo; Escape reverts it. The target of an aimed light follows the surface under the pointer,
//! or with Ctrl the plane of the view. With Ctrl, poses snap to steps.

mod change;
mod drag;
mod edges;
mod handles;
mod icons;
mod light;
mod movable;
mod object;
mod paint;
mod pivot;
mod projection;
mod rings;
mod size;
#[cfg(test)]
mod tests;
mod tool;

use super::{
    ClickFor, ViewportContext,
    pick::{self, Picked},
};
use crate::{
    actions::{Action, CameraAction, LightAction, PoseAction},
    typing::take_escape,
};
use drag::Drag;
use egui::{CursorIcon, PointerButton, Pos2, Rect, Response, Ui};
use glam::Vec3;
use handles::{Constraint, Handle};
use lapidary_core::{camera::Camera, ground::Ground, lights::Light};
pub use movable::{Movable, Pivot, Subject};
use object::ObjectHandles;
pub use paint::paint;
use pivot::PivotPlace;
pub use projection::Projection;
pub use tool::Tool;

/// State of the handles in the viewport.
#[derive(Default)]
pub struct Gizmo {
    drag: Option<Drag>,
    /// A canceled drag does nothing until the button is released.
    is_given_up: bool,
    hot: Option<Hot>,
    /// The place for a pivot under the pointer.
    pivot: Option<PivotPlace>,
    /// The pointer and the camera for which it was found: that takes a pass over the mesh.
    pivot_of: Option<(Pos2, Camera)>,
}

/// The thing under the pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hot {
    Handle(Handle),
    Light(usize),
}

impl Gizmo {
    /// Whether a handle is dragged.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }
}

/// The contents of the view, and its projection.
struct View<'a> {
    context: &'a ViewportContext<'a>,
    projection: Projection,
    rect: Rect,
    pixels_per_point: f32,
}

impl<'a> View<'a> {
    fn new(ui: &Ui, rect: Rect, context: &'a ViewportContext) -> Self {
        let projection = Projection::new(&context.document.camera, rect);
        Self { context, projection, rect, pixels_per_point: ui.pixels_per_point() }
    }

    /// The selected light, if its handles are shown.
    fn light(&self) -> Option<(usize, &'a Light)> {
        let index = self.context.selected_light.filter(|_| self.context.shows_lights)?;
        Some((index, self.context.document.lights.get(index)?))
    }

    /// The shown handles.
    fn handles(&self) -> Option<ObjectHandles> {
        match self.light() {
            Some((_, light)) => light::handles(light, self).map(ObjectHandles::Move),
            None => self.context.movable.as_ref()?.handles(self),
        }
    }

    fn meet(&self, constraint: Constraint, through: Vec3, pointer: Pos2) -> Option<Vec3> {
        constraint.meet(through, self.projection.eye(), self.projection.direction(pointer))
    }

    /// The surface under the pointer.
    fn picked(&self, pointer: Pos2) -> Option<Picked> {
        let (mesh, intersector) = (self.context.mesh?, self.context.intersector?);
        let size = super::pixels(self.rect, self.pixels_per_point);
        let pixel = super::pixel(pointer, self.rect, size);
        // A light may aim at a shadow on the ground.
        pick::pick((mesh, intersector), Ground::On, &self.context.document.camera, pixel, size)
    }

    /// The position of the surface under the pointer.
    fn surface(&self, pointer: Pos2) -> Option<Vec3> {
        self.picked(pointer).map(|picked| picked.position)
    }

    /// What a click at a position asks for; `None` where there is nothing to click.
    fn asked_by(&self, click: ClickFor, pointer: Pos2) -> Option<Action> {
        Some(match click {
            ClickFor::Aim => Action::Light(LightAction::Aim(Some(self.surface(pointer)?))),
            ClickFor::Focus => Action::Camera(CameraAction::Focus(Some(self.surface(pointer)?))),
            ClickFor::Pivot => Action::Pose(PoseAction::PlacePivot(Some(PivotPlace::at(self, pointer)?.pivot))),
        })
    }

    /// The handle at a position, else the nearest lamp.
    fn hit(&self, pointer: Pos2) -> Option<Hot> {
        if let Some(handle) = self.handles().and_then(|handles| handles.at(pointer)) {
            return Some(Hot::Handle(handle));
        }
        let lights = self.context.document.lights.iter().filter(|_| self.context.shows_lights);
        let distance =
            |(i, light): (usize, &Light)| Some((i, self.projection.point(light.position)?.distance(pointer)));
        let nearest = lights.enumerate().filter_map(distance).min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= icons::REACH).map(|(index, _)| Hot::Light(index))
    }
}

/// Handles a frame's input for handles and lights. Returns whether they take the pointer.
pub fn handle(
    ui: &Ui,
    response: &Response,
    gizmo: &mut Gizmo,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) -> bool {
    let view = View::new(ui, response.rect, context);
    let mut pass = Pass { ui, response, gizmo, actions, view };
    let is_busy = pass.drag() || pass.click();
    pass.gizmo.hot = pass.under_pointer();
    pass.gizmo.pivot = pass.pivot_under_pointer();
    pass.cursor();
    is_busy
}

struct Pass<'a> {
    ui: &'a Ui,
    response: &'a Response,
    gizmo: &'a mut Gizmo,
    actions: &'a mut Vec<Action>,
    view: View<'a>,
}

impl Pass<'_> {
    /// Continues or begins a drag. Returns whether there is one.
    fn drag(&mut self) -> bool {
        let held = self.ui.input(|i| i.pointer.primary_down());
        if !held {
            let was_dragged = self.end_drag();
            // The click that ends a drag selects nothing.
            return std::mem::take(&mut self.gizmo.is_given_up) || was_dragged;
        }
        if self.gizmo.drag.is_none() && !self.gizmo.is_given_up {
            self.gizmo.drag = self.begun();
        }
        if self.gizmo.drag.is_some() && take_escape(self.ui.ctx()) {
            self.give_up();
        } else {
            self.go_on();
        }
        self.gizmo.drag.is_some() || self.gizmo.is_given_up
    }

    /// Ends a drag. Returns whether there was one, other than a click on the middle of an object.
    fn end_drag(&mut self) -> bool {
        let Some(drag) = self.gizmo.drag.take() else { return false };
        if drag.has_moved {
            self.actions.push(Action::EndGesture);
        }
        drag.has_moved || !drag.is_for_clicks()
    }

    fn begun(&self) -> Option<Drag> {
        let (origin, modifiers, pressed) =
            self.ui.input(|i| (i.pointer.press_origin(), i.modifiers, i.pointer.primary_pressed()));
        let is_mine = pressed && self.response.is_pointer_button_down_on() && !modifiers.shift && !modifiers.alt;
        let origin = origin.filter(|_| is_mine && self.view.context.click_for.is_none())?;
        let drag = Drag::begun(&self.view, origin)?;
        self.ui.memory_mut(|memory| memory.stop_text_input());
        Some(drag)
    }

    fn give_up(&mut self) {
        let Some(drag) = self.gizmo.drag.take() else { return };
        self.gizmo.is_given_up = true;
        if drag.has_moved {
            let (edit, label) = (drag.restored(), drag.label());
            self.actions.extend([Action::Edit { edit, label }, Action::EndGesture]);
        }
    }

    fn go_on(&mut self) {
        // A shaky click moves nothing.
        let (pointer, moves, command) = self.ui.input(|i| {
            let moves = i.pointer.delta() != egui::Vec2::ZERO && i.pointer.is_decidedly_dragging();
            (i.pointer.latest_pos(), moves, i.modifiers.command)
        });
        let (Some(pointer), Some(drag)) = (pointer, &mut self.gizmo.drag) else { return };
        if !drag.has_subject(&self.view) {
            // The dragged thing is gone; the drag so far is a step of its own.
            self.end_drag();
            self.gizmo.is_given_up = true;
            return;
        }
        let edit = if moves { drag.moved(&self.view, pointer, command) } else { None };
        if let Some(edit) = edit {
            drag.has_moved = true;
            self.actions.push(Action::Edit { edit, label: drag.label() });
        }
    }

    /// Does what the click is for, or selects a light. Returns whether it took the click.
    fn click(&mut self) -> bool {
        let alt = self.ui.input(|i| i.modifiers.alt);
        let Some(pointer) = self.response.interact_pointer_pos() else { return self.stop_waiting() };
        if alt || !self.response.clicked_by(PointerButton::Primary) {
            return self.stop_waiting();
        }
        if let Some(click) = self.view.context.click_for {
            self.actions.extend(self.view.asked_by(click, pointer));
            return true;
        }
        match self.view.hit(pointer) {
            Some(Hot::Light(index)) => {
                self.actions.push(Action::Light(LightAction::Select(Some(index))));
                true
            }
            Some(Hot::Handle(handle)) => self.view.light().is_some() || !handle.is_for_clicks(),
            None => false,
        }
    }

    /// Escape gives up what the click was for.
    fn stop_waiting(&mut self) -> bool {
        if let Some(click) = self.view.context.click_for.filter(|_| take_escape(self.ui.ctx())) {
            self.actions.push(click.given_up());
        }
        false
    }

    fn under_pointer(&self) -> Option<Hot> {
        if let Some(drag) = &self.gizmo.drag {
            return Some(Hot::Handle(drag.handle()));
        }
        let pointer = self.ui.input(|i| i.pointer.latest_pos()).filter(|_| self.response.contains_pointer())?;
        let any_down = self.ui.input(|i| i.pointer.any_down());
        if any_down || self.view.context.click_for.is_some() { None } else { self.view.hit(pointer) }
    }

    fn pivot_under_pointer(&mut self) -> Option<PivotPlace> {
        let is_placed = self.view.context.click_for == Some(ClickFor::Pivot) && self.response.contains_pointer();
        let pointer = self.ui.input(|i| i.pointer.latest_pos()).filter(|_| is_placed);
        let now = pointer.map(|pointer| (pointer, self.view.context.document.camera.clone()));
        if now != self.gizmo.pivot_of {
            self.gizmo.pivot_of = now;
            return PivotPlace::at(&self.view, pointer?);
        }
        self.gizmo.pivot.filter(|_| pointer.is_some())
    }

    fn cursor(&self) {
        let icon = match self.gizmo.hot {
            _ if self.view.context.click_for.is_some() && self.response.contains_pointer() => CursorIcon::Crosshair,
            Some(Hot::Handle(_)) if self.gizmo.drag.is_some() => CursorIcon::Grabbing,
            Some(Hot::Handle(_)) => CursorIcon::Grab,
            Some(Hot::Light(_)) => CursorIcon::PointingHand,
            None => return,
        };
        self.ui.set_cursor_icon(icon);
    }
}
