//! Local lights over the picture: icons that select them, and handles that move the selected one.
//!
//! A drag of a handle is one step of undo; Escape puts the light back. The target of an aimed light follows the surface
//! under the pointer, or with Ctrl the plane of the view.

mod handles;
mod icons;
mod projection;
#[cfg(test)]
mod tests;

use super::{ViewportContext, pick};
use crate::{actions::Action, document::Edit};
use egui::{Align2, Color32, CursorIcon, FontId, Key, Modifiers, PointerButton, Pos2, Rect, Response, Ui, vec2};
use glam::Vec3;
use handles::{Constraint, Handle, Handles};
use icons::Icon;
use lapidary_core::{ground::Ground, lights::Light};
pub use projection::Projection;

/// More lights than this are drawn as lamps only.
const MOST_SHAPES: usize = 100;

/// What goes on with the lights in the viewport.
#[derive(Default)]
pub struct Gizmo {
    drag: Option<Drag>,
    /// A drag was given up: until the button is let go it does nothing.
    is_given_up: bool,
    hot: Option<Hot>,
}

/// What the pointer is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hot {
    Handle(Handle),
    Light(usize),
}

/// A handle that is dragged.
struct Drag {
    light: usize,
    handle: Handle,
    constraint: Constraint,
    /// The light when the drag began.
    before: Light,
    /// Where the pointer took hold of the constraint.
    grabbed: Vec3,
    has_moved: bool,
}

impl Gizmo {
    /// Whether a light is being moved.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }
}

/// The part of the input of a frame that goes to lights. Returns whether the pointer is busy with them.
pub fn handle(
    ui: &Ui,
    response: &Response,
    gizmo: &mut Gizmo,
    context: &ViewportContext,
    actions: &mut Vec<Action>,
) -> bool {
    let projection = Projection::new(&context.document.camera, response.rect);
    let mut pass = Pass { ui, response, gizmo, context, actions, projection };
    let is_busy = pass.drag() || pass.click();
    pass.gizmo.hot = pass.under_pointer();
    pass.cursor();
    is_busy
}

struct Pass<'a> {
    ui: &'a Ui,
    response: &'a Response,
    gizmo: &'a mut Gizmo,
    context: &'a ViewportContext<'a>,
    actions: &'a mut Vec<Action>,
    projection: Projection,
}

impl Pass<'_> {
    /// Goes on with a drag, or begins one. Returns whether there is one.
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
        let escape = || self.ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape));
        if self.gizmo.drag.is_some() && escape() {
            self.give_up();
        } else {
            self.go_on();
        }
        self.gizmo.drag.is_some() || self.gizmo.is_given_up
    }

    fn end_drag(&mut self) -> bool {
        let Some(drag) = self.gizmo.drag.take() else { return false };
        if drag.has_moved {
            self.actions.push(Action::EndGesture);
        }
        true
    }

    fn begun(&self) -> Option<Drag> {
        let index = self.context.selected_light.filter(|_| self.context.shows_lights && !self.context.aiming)?;
        let light = self.context.document.lights.get(index)?;
        let (origin, modifiers, pressed) =
            self.ui.input(|i| (i.pointer.press_origin(), i.modifiers, i.pointer.primary_pressed()));
        let is_mine = pressed && self.response.is_pointer_button_down_on() && !modifiers.shift && !modifiers.alt;
        let origin = origin.filter(|_| is_mine)?;
        let handle = Handles::of(light, &self.projection)?.at(origin)?;
        let constraint = handle.constraint(self.projection.forward());
        let grabbed = self.meet(constraint, place_of(light, handle), origin)?;
        self.ui.memory_mut(|memory| memory.stop_text_input());
        Some(Drag { light: index, handle, constraint, before: light.clone(), grabbed, has_moved: false })
    }

    fn give_up(&mut self) {
        let Some(drag) = self.gizmo.drag.take() else { return };
        self.gizmo.is_given_up = true;
        if drag.has_moved {
            let edit = Edit::Light { index: drag.light, light: Box::new(drag.before) };
            self.actions.extend([Action::Edit { edit, label: label(drag.handle) }, Action::EndGesture]);
        }
    }

    fn go_on(&mut self) {
        let (pointer, moves, free) =
            self.ui.input(|i| (i.pointer.latest_pos(), i.pointer.delta() != egui::Vec2::ZERO, i.modifiers.command));
        let (Some(pointer), Some(drag)) = (pointer, &self.gizmo.drag) else { return };
        let Some(now) = self.context.document.lights.get(drag.light) else {
            // The light is gone: what the drag has done so far is a step of its own.
            self.gizmo.is_given_up = self.end_drag();
            return;
        };
        if !moves {
            return;
        }
        let surface = if drag.handle == Handle::Target && !free { self.surface(pointer) } else { None };
        let before = place_of(&drag.before, drag.handle);
        let moved = || Some(before + self.meet(drag.constraint, before, pointer)? - drag.grabbed);
        let Some(place) = surface.or_else(moved) else { return };
        let mut light = now.clone();
        *(if drag.handle == Handle::Target { &mut light.target } else { &mut light.position }) = place;
        if light.validate().is_ok() && light != *now {
            let (index, label) = (drag.light, label(drag.handle));
            self.actions.push(Action::Edit { edit: Edit::Light { index, light: Box::new(light) }, label });
            if let Some(drag) = &mut self.gizmo.drag {
                drag.has_moved = true;
            }
        }
    }

    /// Aims, or selects a light. Returns whether the click was for that.
    fn click(&mut self) -> bool {
        let alt = self.ui.input(|i| i.modifiers.alt);
        let Some(pointer) = self.response.interact_pointer_pos() else { return self.stop_aiming() };
        if alt || !self.response.clicked_by(PointerButton::Primary) {
            return self.stop_aiming();
        }
        if self.context.aiming {
            if let Some(place) = self.surface(pointer) {
                self.actions.push(Action::AimLight(Some(place)));
            }
            return true;
        }
        match self.hit(pointer) {
            Some(Hot::Light(index)) => {
                self.actions.push(Action::SelectLight(Some(index)));
                true
            }
            Some(Hot::Handle(_)) => true,
            None => false,
        }
    }

    /// Escape gives up aiming.
    fn stop_aiming(&mut self) -> bool {
        if self.context.aiming && self.ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape)) {
            self.actions.push(Action::AimLight(None));
        }
        false
    }

    fn under_pointer(&self) -> Option<Hot> {
        if let Some(drag) = &self.gizmo.drag {
            return Some(Hot::Handle(drag.handle));
        }
        let pointer = self.ui.input(|i| i.pointer.latest_pos()).filter(|_| self.response.contains_pointer())?;
        let any_down = self.ui.input(|i| i.pointer.any_down());
        if any_down || self.context.aiming { None } else { self.hit(pointer) }
    }

    /// What is at a position: a handle, or else the lamp that is nearest to it.
    fn hit(&self, pointer: Pos2) -> Option<Hot> {
        let lights = &self.context.document.lights;
        if !self.context.shows_lights {
            return None;
        }
        let selected = self.context.selected_light.and_then(|index| lights.get(index));
        let handle = selected.and_then(|light| Handles::of(light, &self.projection)?.at(pointer));
        if let Some(handle) = handle {
            return Some(Hot::Handle(handle));
        }
        let distance =
            |(i, light): (usize, &Light)| Some((i, self.projection.point(light.position)?.distance(pointer)));
        let nearest = lights.iter().enumerate().filter_map(distance).min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= icons::REACH).map(|(index, _)| Hot::Light(index))
    }

    fn cursor(&self) {
        let icon = match self.gizmo.hot {
            _ if self.context.aiming && self.response.contains_pointer() => CursorIcon::Crosshair,
            Some(Hot::Handle(_)) if self.gizmo.drag.is_some() => CursorIcon::Grabbing,
            Some(Hot::Handle(_)) => CursorIcon::Grab,
            Some(Hot::Light(_)) => CursorIcon::PointingHand,
            None => return,
        };
        self.ui.set_cursor_icon(icon);
    }

    fn meet(&self, constraint: Constraint, through: Vec3, pointer: Pos2) -> Option<Vec3> {
        constraint.meet(through, self.projection.eye(), self.projection.direction(pointer))
    }

    /// The surface under the pointer.
    fn surface(&self, pointer: Pos2) -> Option<Vec3> {
        let (mesh, intersector) = (self.context.mesh?, self.context.intersector?);
        let rect = self.response.rect;
        let size = super::pixels(rect, self.ui.pixels_per_point());
        let share = (pointer - rect.min) / rect.size();
        let pixel = glam::Vec2::new(share.x * size[0] as f32, share.y * size[1] as f32);
        // What it aims at may be a shadow on the ground.
        let picked = pick::pick((mesh, intersector), Ground::On, &self.context.document.camera, pixel, size);
        picked.map(|picked| picked.position)
    }
}

fn place_of(light: &Light, handle: Handle) -> Vec3 {
    if handle == Handle::Target { light.target } else { light.position }
}

fn label(handle: Handle) -> &'static str {
    if handle == Handle::Target { "Aim light" } else { "Move light" }
}

/// Draws all lights, and the handles of the selected one.
pub fn paint(ui: &Ui, rect: Rect, gizmo: &Gizmo, context: &ViewportContext) {
    let painter = ui.painter_at(rect);
    if context.aiming {
        let at = rect.center_top() + vec2(0.0, 16.0);
        let font = FontId::proportional(13.0);
        let text = painter.layout_no_wrap("Click the point to aim at (Esc: cancel)".into(), font, Color32::WHITE);
        let outer = Align2::CENTER_TOP.anchor_size(at, text.size() + vec2(16.0, 8.0));
        painter.rect_filled(outer, 4.0, Color32::from_black_alpha(170));
        painter.galley(outer.min + vec2(8.0, 4.0), text, Color32::WHITE);
    }
    if !context.shows_lights {
        return;
    }
    let projection = Projection::new(&context.document.camera, rect);
    // On a dark picture the accent of the panels is hardly seen.
    let accent = context.accent.lerp_to_gamma(Color32::WHITE, 0.45);
    let lights = &context.document.lights;
    for (index, light) in lights.iter().enumerate() {
        let (selected, hot) = (context.selected_light == Some(index), gizmo.hot == Some(Hot::Light(index)));
        let plain = lights.len() > MOST_SHAPES;
        Icon { painter: &painter, projection: &projection, accent, selected, hot, plain }.paint(light);
    }
    let handles = context.selected_light.and_then(|index| Handles::of(lights.get(index)?, &projection));
    if let Some(handles) = handles {
        let hot = gizmo.hot.and_then(|hot| if let Hot::Handle(handle) = hot { Some(handle) } else { None });
        handles.paint(&painter, hot, accent);
    }
}
