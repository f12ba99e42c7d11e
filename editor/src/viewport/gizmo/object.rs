//! The handles of the selected object, and a drag of one.

use super::{
    View,
    change::{Change, SCALE_STEP, TURN_STEP_DEGREES, move_step},
    handles::{Constraint, Handle, Handles},
    rings::{Rings, Sweep},
    size::SizeHandle,
};
use crate::document::Edit;
use egui::{Color32, Painter, Pos2};
use glam::Vec3;
use lapidary_core::scene::pose::Pose;

/// What drags of handles do to the selected object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tool {
    /// Moves it along axes and planes.
    Move,
    /// Turns it about the axes of the world through its centre.
    Turn,
    /// Makes it larger or smaller.
    Scale,
}

impl Tool {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Move, Self::Turn, Self::Scale];

    /// The name of its command and of its step of undo.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Move => "Move object",
            Self::Turn => "Turn object",
            Self::Scale => "Scale object",
        }
    }

    /// What Ctrl does, where moves have steps of so many metres.
    fn steps(self, move_step: f32) -> String {
        match self {
            Self::Move => format!("Ctrl: steps of {move_step} m"),
            Self::Turn => format!("Ctrl: steps of {TURN_STEP_DEGREES}°"),
            Self::Scale => format!("Ctrl: steps of {:.0} %", 100.0 * SCALE_STEP),
        }
    }
}

/// An object that can be posed, and by what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Movable {
    /// Its index.
    pub object: u32,
    /// Its centre where its file has it, in metres.
    pub center: Vec3,
    /// What its handles do.
    pub tool: Tool,
}

impl Movable {
    fn pose(&self, view: &View) -> Pose {
        view.context.document.poses.of(self.object)
    }

    /// Its handles; `None` behind the eye.
    pub(super) fn handles(&self, view: &View) -> Option<ObjectHandles> {
        let (center, projection) = (self.center + self.pose(view).translate, &view.projection);
        Some(match self.tool {
            Tool::Move => ObjectHandles::Move(Handles::of(center, None, projection)?),
            Tool::Turn => ObjectHandles::Turn(Rings::of(center, projection)?),
            Tool::Scale => ObjectHandles::Scale(SizeHandle::of(center, projection)?),
        })
    }

    /// What its handles can do, to be read over the picture.
    pub(super) fn hint(&self, view: &View) -> String {
        self.tool.steps(step_in(view))
    }
}

/// The handles of an object as they are seen.
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

    /// Draws them, `hot` brighter.
    pub fn paint(&self, painter: &Painter, hot: Option<Handle>, accent: Color32) {
        match self {
            Self::Move(handles) => handles.paint(painter, hot, accent),
            Self::Turn(rings) => rings.paint(painter, hot),
            Self::Scale(size) => size.paint(painter, hot, accent),
        }
    }
}

/// An object that is posed.
pub struct ObjectDrag {
    movable: Movable,
    handle: Handle,
    /// The pose when the drag began.
    before: Pose,
    grip: Grip,
    change: Option<Change>,
}

/// How the pointer holds a handle.
enum Grip {
    /// Of a line or a plane, at a place.
    Place(Constraint, Vec3),
    Ring(usize, Sweep),
    Size(SizeHandle, Pos2),
}

impl ObjectDrag {
    /// Takes hold of a handle.
    pub fn begun(movable: Movable, handle: Handle, view: &View, pointer: Pos2) -> Option<Self> {
        let (before, projection) = (movable.pose(view), &view.projection);
        let center = movable.center + before.translate;
        let grip = match handle {
            Handle::Ring(axis) => Grip::Ring(axis, Sweep::begun(axis, center, projection, pointer)?),
            Handle::Size => Grip::Size(SizeHandle::of(center, projection)?, pointer),
            _ => {
                let constraint = handle.constraint(projection.forward())?;
                Grip::Place(constraint, view.meet(constraint, center, pointer)?)
            }
        };
        Some(Self { movable, handle, before, grip, change: None })
    }

    /// What the pointer holds.
    pub fn handle(&self) -> Handle {
        self.handle
    }

    /// The name of the step of undo.
    pub fn label(&self) -> &'static str {
        self.movable.tool.label()
    }

    /// Puts the object back.
    pub fn restored(&self) -> Edit {
        Edit::Pose { object: self.movable.object, pose: self.before }
    }

    /// Whether the same object is still shown with these handles.
    pub fn has_subject(&self, view: &View) -> bool {
        view.context.movable == Some(self.movable)
    }

    /// The object posed as the pointer asks, if that is another pose; in whole steps where it `snaps`.
    pub fn moved(&mut self, view: &View, pointer: Pos2, snaps: bool) -> Option<Edit> {
        let change = self.asked(view, pointer)?;
        let change = if snaps { change.snapped(step_in(view)) } else { change };
        let pose = change.applied(&self.before);
        if pose.validate("").is_err() {
            return None;
        }
        self.change = Some(change);
        (pose != self.movable.pose(view)).then_some(Edit::Pose { object: self.movable.object, pose })
    }

    fn asked(&self, view: &View, pointer: Pos2) -> Option<Change> {
        Some(match &self.grip {
            Grip::Place(constraint, grabbed) => {
                let center = self.movable.center + self.before.translate;
                Change::Move(view.meet(*constraint, center, pointer)? - *grabbed)
            }
            Grip::Ring(axis, sweep) => {
                let degrees = sweep.radians(&view.projection, pointer)?.to_degrees();
                Change::Turn { axis: *axis, degrees }
            }
            Grip::Size(size, grabbed) => Change::Scale(size.factor(*grabbed, pointer)),
        })
    }

    /// What has been done so far, to be read over the picture.
    pub fn words(&self) -> Option<String> {
        self.change.map(Change::words)
    }
}

/// The step of moves in the scene that is seen, in metres.
fn step_in(view: &View) -> f32 {
    move_step(view.context.scene_bounds.map_or(0.0, |bounds| bounds.diagonal()))
}
