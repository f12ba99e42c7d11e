//! A drag of a handle of a light or an object.

use super::{View, handles::Handle, light::LightDrag, object::ObjectDrag};
use crate::document::Edit;
use egui::Pos2;

/// A drag of a handle.
pub struct Drag {
    subject: Subject,
    /// Whether it has changed anything.
    pub has_moved: bool,
}

enum Subject {
    Light(LightDrag),
    Object(ObjectDrag),
}

impl Drag {
    /// Takes hold of the handle at a position.
    pub fn begun(view: &View, pointer: Pos2) -> Option<Self> {
        let handle = view.handles()?.at(pointer)?;
        let subject = match view.light() {
            Some((index, light)) => Subject::Light(LightDrag::begun(index, light, handle, view, pointer)?),
            None => Subject::Object(ObjectDrag::begun(view.context.movable.clone()?, handle, view, pointer)?),
        };
        Some(Self { subject, has_moved: false })
    }

    /// The dragged handle.
    pub fn handle(&self) -> Handle {
        match &self.subject {
            Subject::Light(drag) => drag.handle(),
            Subject::Object(drag) => drag.handle(),
        }
    }

    /// Whether it began where clicks go through the handle.
    pub fn is_for_clicks(&self) -> bool {
        matches!(self.subject, Subject::Object(_)) && self.handle().is_for_clicks()
    }

    /// The name of the step of undo.
    pub fn label(&self) -> &'static str {
        match &self.subject {
            Subject::Light(drag) => drag.label(),
            Subject::Object(drag) => drag.label(),
        }
    }

    /// The edit that reverts the drag.
    pub fn restored(&self) -> Edit {
        match &self.subject {
            Subject::Light(drag) => drag.restored(),
            Subject::Object(drag) => drag.restored(),
        }
    }

    /// Whether the moved thing still exists.
    pub fn has_subject(&self, view: &View) -> bool {
        match &self.subject {
            Subject::Light(drag) => drag.has_subject(view),
            Subject::Object(drag) => drag.has_subject(view),
        }
    }

    /// The edit for the pointer, if it changes anything. With `command` a target leaves surfaces, and objects snap.
    pub fn moved(&mut self, view: &View, pointer: Pos2, command: bool) -> Option<Edit> {
        match &mut self.subject {
            Subject::Light(drag) => drag.moved(view, pointer, command),
            Subject::Object(drag) => drag.moved(view, pointer, command),
        }
    }

    /// The change so far, in words over the picture.
    pub fn words(&self) -> Option<String> {
        match &self.subject {
            Subject::Light(_) => None,
            Subject::Object(drag) => drag.words(),
        }
    }
}
