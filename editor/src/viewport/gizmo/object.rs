//! The handles of the selected objects, and a drag of one.

use super::{
    View,
    change::{Axis, Change, move_step},
    handles::{Constraint, Handle, Handles},
    movable::Movable,
    rings::{Rings, Sweep},
    size::SizeHandle,
    tool::Tool,
};
use crate::document::Edit;
use egui::{Color32, Painter, Pos2};
use glam::Vec3;
use lapidary_core::scene::pose::Poses;

impl Movable {
    /// The projected handles; `None` behind the eye.
    pub(super) fn handles(&self, view: &View) -> Option<ObjectHandles> {
        let (poses, projection) = (&view.context.document.poses, &view.projection);
        let place = self.place(poses);
        Some(match self.tool {
            Tool::Move => ObjectHandles::Move(Handles::of(place, None, projection)?),
            Tool::Turn => ObjectHandles::Turn(Rings::of(place, self.turn_axes(poses), projection)?),
            Tool::Scale => ObjectHandles::Scale(SizeHandle::of(place, projection)?),
        })
    }

    /// A hint on their handles, shown over the picture.
    pub(super) fn hint(&self, view: &View) -> String {
        self.tool.steps(step_in(view))
    }
}

/// The projected handles of objects.
pub enum ObjectHandles {
    /// Arrows, planes and a disc.
    Move(Handles),
    /// Rings.
    Turn(Rings),
    /// A square at the end of a line.
    Scale(SizeHandle),
}

impl ObjectHandles {
    /// The handle under the pointer.
    pub fn at(&self, pointer: Pos2) -> Option<Handle> {
        match self {
            Self::Move(handles) => handles.at(pointer),
            Self::Turn(rings) => rings.at(pointer),
            Self::Scale(size) => size.at(pointer),
        }
    }

    /// Draws the handles, `hot` brighter.
    pub fn paint(&self, painter: &Painter, hot: Option<Handle>, accent: Color32) {
        match self {
            Self::Move(handles) => handles.paint(painter, hot, accent),
            Self::Turn(rings) => rings.paint(painter, hot),
            Self::Scale(size) => size.paint(painter, hot, accent),
        }
    }
}

/// A drag of objects.
pub struct ObjectDrag {
    movable: Movable,
    handle: Handle,
    /// All poses when the drag began.
    before: Poses,
    grip: Grip,
    change: Option<Change>,
}

/// The grip of the pointer on a handle.
enum Grip {
    /// On a line or a plane, at a position.
    Place(Constraint, Vec3),
    Ring(Axis, Sweep),
    Size(SizeHandle, Pos2),
}

impl ObjectDrag {
    /// Takes hold of a handle.
    pub fn begun(movable: Movable, handle: Handle, view: &View, pointer: Pos2) -> Option<Self> {
        let (before, projection) = (view.context.document.poses.clone(), &view.projection);
        let place = movable.place(&before);
        let grip = match handle {
            Handle::Ring(ring) => {
                let axis = *movable.turn_axes(&before).get(ring)?;
                Grip::Ring(axis, Sweep::begun(axis, place, projection, pointer)?)
            }
            Handle::Size => Grip::Size(SizeHandle::of(place, projection)?, pointer),
            _ => {
                let constraint = handle.constraint(projection.forward())?;
                Grip::Place(constraint, view.meet(constraint, place, pointer)?)
            }
        };
        Some(Self { movable, handle, before, grip, change: None })
    }

    /// The dragged handle.
    pub fn handle(&self) -> Handle {
        self.handle
    }

    /// The name of the step of undo.
    pub fn label(&self) -> &'static str {
        self.movable.tool.verb()
    }

    /// The edit that reverts the drag.
    pub fn restored(&self) -> Edit {
        Edit::Poses(self.movable.poses(&self.before))
    }

    /// Whether the same objects are still shown with these handles.
    pub fn has_subject(&self, view: &View) -> bool {
        view.context.movable.as_ref().is_some_and(|movable| movable.is_same(&self.movable))
    }

    /// The edit for the pointer, if it changes the poses; in whole steps if it `snaps`.
    pub fn moved(&mut self, view: &View, pointer: Pos2, snaps: bool) -> Option<Edit> {
        let change = self.asked(view, pointer)?;
        let change = if snaps { change.snapped(step_in(view)) } else { change };
        let change = self.movable.limited(change, &self.before);
        let poses = self.movable.changed(&self.before, change.similarity());
        if poses.values().any(|pose| pose.validate("").is_err()) {
            return None;
        }
        self.change = Some(change);
        (poses != self.movable.poses(&view.context.document.poses)).then_some(Edit::Poses(poses))
    }

    fn asked(&self, view: &View, pointer: Pos2) -> Option<Change> {
        Some(match &self.grip {
            Grip::Place(constraint, grabbed) => {
                let place = self.movable.place(&self.before);
                Change::Move(view.meet(*constraint, place, pointer)? - *grabbed)
            }
            Grip::Ring(axis, sweep) => {
                let degrees = sweep.radians(&view.projection, pointer)?.to_degrees();
                Change::Turn { axis: *axis, degrees }
            }
            Grip::Size(size, grabbed) => Change::Scale(size.factor(*grabbed, pointer)),
        })
    }

    /// The change so far, in words over the picture.
    pub fn words(&self) -> Option<String> {
        self.change.map(Change::words)
    }
}

/// The step of moves in the shown scene, in meters.
fn step_in(view: &View) -> f32 {
    move_step(view.context.scene_bounds.map_or(0.0, |bounds| bounds.diagonal()))
}
