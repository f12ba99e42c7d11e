//! A drag of a handle of the selected light.

use super::{
    View,
    handles::{Constraint, Handle, Handles},
};
use crate::document::Edit;
use egui::Pos2;
use glam::Vec3;
use lapidary_core::lights::Light;

/// A drag of a light.
pub struct LightDrag {
    index: usize,
    handle: Handle,
    constraint: Constraint,
    /// The light when the drag began.
    before: Light,
    /// Start of the drag on the constraint.
    grabbed: Vec3,
}

/// The handles of a light; `None` behind the eye.
pub fn handles(light: &Light, view: &View) -> Option<Handles> {
    Handles::of(light.position, light.emission.is_aimed().then_some(light.target), &view.projection)
}

impl LightDrag {
    /// Takes hold of a handle of a light.
    pub fn begun(index: usize, light: &Light, handle: Handle, view: &View, pointer: Pos2) -> Option<Self> {
        let constraint = handle.constraint(view.projection.forward())?;
        let grabbed = view.meet(constraint, place_of(light, handle), pointer)?;
        Some(Self { index, handle, constraint, before: light.clone(), grabbed })
    }

    /// The dragged handle.
    pub fn handle(&self) -> Handle {
        self.handle
    }

    /// The name of the step of undo.
    pub fn label(&self) -> &'static str {
        if self.handle == Handle::Target { "Aim light" } else { "Move light" }
    }

    /// The edit that reverts the drag.
    pub fn restored(&self) -> Edit {
        Edit::Light { index: self.index, light: Box::new(self.before.clone()) }
    }

    /// Whether the light still exists.
    pub fn has_subject(&self, view: &View) -> bool {
        self.index < view.context.document.lights.len()
    }

    /// The edit for the pointer, if it moves the light. A target follows surfaces unless it is `free`.
    pub fn moved(&self, view: &View, pointer: Pos2, free: bool) -> Option<Edit> {
        let now = view.context.document.lights.get(self.index)?;
        let surface = if self.handle == Handle::Target && !free { view.surface(pointer) } else { None };
        let before = place_of(&self.before, self.handle);
        let along = || Some(before + view.meet(self.constraint, before, pointer)? - self.grabbed);
        let place = surface.or_else(along)?;
        let mut light = now.clone();
        *(if self.handle == Handle::Target { &mut light.target } else { &mut light.position }) = place;
        let is_new = light.validate().is_ok() && light != *now;
        is_new.then(|| Edit::Light { index: self.index, light: Box::new(light) })
    }
}

fn place_of(light: &Light, handle: Handle) -> Vec3 {
    if handle == Handle::Target { light.target } else { light.position }
}
