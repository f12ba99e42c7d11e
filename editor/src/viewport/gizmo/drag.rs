//! A handle that is dragged: of a light or of an object.

use super::{View, handles::Handle, light::LightDrag, object::ObjectDrag};
use crate::document::Edit;
use egui::Pos2;

/// A handle that is dragged.
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

    /// What the pointer holds.
    pub fn handle(&self) -> Handle {
        match &self.subject {
            Subject::Light(drag) => drag.handle(),
            Subject::Object(drag) => drag.handle(),
        }
    }

    /// Whether it began where clicks are for what lies under the handle.
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

    /// Puts back what is moved.
    pub fn restored(&self) -> Edit {
        match &self.subject {
            Subject::Light(drag) => drag.restored(),
            Subject::Object(drag) => drag.restored(),
        }
    }

    /// Whether what is moved is still there.
    pub fn has_subject(&self, view: &View) -> bool {
        match &self.subject {
            Subject::Light(drag) => drag.has_subject(view),
            Subject::Object(drag) => drag.has_subject(view),
        }
    }

    /// What the pointer asks for, if that is something new. With `command` a target leaves surfaces, and objects snap.
    pub fn moved(&mut self, view: &View, pointer: Pos2, command: bool) -> Option<Edit> {
        match &mut self.subject {
            Subject::Light(drag) => drag.moved(view, pointer, command),
            Subject::Object(drag) => drag.moved(view, pointer, command),
        }
    }

    /// What has been done so far, to be read over the picture.
    pub fn words(&self) -> Option<String> {
        match &self.subject {
            Subject::Light(_) => None,
            Subject::Object(drag) => drag.words(),
        }
    }
}
