//! The camera: framed, reset, copied and pasted.

use super::state::EditorState;
use crate::{bounds::object_bounds, lights::light_bounds, navigation, viewport::camera_text};
use egui::Context;
use lapidary_core::{bounds::Bounds, camera::Camera};
use lapidary_render::Baked;

impl EditorState {
    pub(super) fn frame_selection(&mut self) {
        if let Some(bounds) = light_bounds(&self.work) {
            self.work.document.camera = navigation::framed(&self.work.document.camera, bounds, self.work.aspect());
            return;
        }
        let posed = self.pose.posed_at_rest(&self.work);
        let bounds_in = |posed: &Baked| {
            let mesh = &posed.dataset.scene.mesh;
            let is_shown = |object: &u32| !self.work.document.poses.of(*object).hidden;
            let each = self.work.selection.objects().filter(is_shown).filter_map(|object| object_bounds(mesh, object));
            each.reduce(|all, bounds| Bounds::around([all.min, all.max, bounds.min, bounds.max]))
        };
        match posed.as_ref().and_then(bounds_in) {
            Some(bounds) => {
                self.work.document.camera = navigation::framed(&self.work.document.camera, bounds, self.work.aspect())
            }
            None => self.frame_all(),
        }
    }

    pub(super) fn frame_all(&mut self) {
        if let Some(bounds) = self.work.scene.bounds() {
            self.work.document.camera = navigation::framed(&self.work.document.camera, bounds, self.work.aspect());
        }
    }

    /// Returns to the first view of the document.
    pub(super) fn reset_camera(&mut self) {
        if let Some(view) = &self.work.scene.first_view {
            self.work.document.camera = view.fitted(self.work.scene.bounds(), self.work.aspect());
        }
    }

    pub(super) fn copy_camera(&mut self, ctx: &Context) {
        ctx.copy_text(camera_text::text(&self.work.document.camera));
        self.work.messages.note("Camera copied as options for lapidary render");
    }

    /// Moves the camera as a clipboard text says.
    pub(super) fn paste_camera(&mut self, text: &str) {
        match camera_text::parse(text) {
            Ok(camera) => self.work.document.camera = Camera { name: self.work.document.camera.name.clone(), ..camera },
            Err(error) => self.work.messages.error(format!("The clipboard holds no camera: {error:#}")),
        }
    }
}
