//! Where the document is seen from: framed, put back, copied and pasted.

use super::state::EditorState;
use crate::viewport::{camera_text, navigation, pick};
use egui::Context;
use lapidary_core::{bounds::Bounds, camera::Camera};
use lapidary_render::Baked;

impl EditorState {
    pub(super) fn frame_selection(&mut self) {
        if let Some(bounds) = self.light_bounds() {
            self.document.camera = navigation::framed(&self.document.camera, bounds, self.aspect());
            return;
        }
        let posed = self.scene.rendered().map(|baked| self.requests.posed(self.poses_since(baked), baked, false));
        let bounds_in = |posed: &Baked| {
            let mesh = &posed.dataset.scene.mesh;
            let each = self.selection.objects().filter_map(|object| pick::object_bounds(mesh, object));
            each.reduce(|all, bounds| Bounds::around([all.min, all.max, bounds.min, bounds.max]))
        };
        match posed.as_ref().and_then(bounds_in) {
            Some(bounds) => self.document.camera = navigation::framed(&self.document.camera, bounds, self.aspect()),
            None => self.frame_all(),
        }
    }

    pub(super) fn frame_all(&mut self) {
        if let Some(bounds) = self.scene_bounds() {
            self.document.camera = navigation::framed(&self.document.camera, bounds, self.aspect());
        }
    }

    /// Goes back to where the document was first seen from.
    pub(super) fn reset_camera(&mut self) {
        if let Some(view) = &self.scene.first_view {
            self.document.camera = view.fitted(self.scene_bounds(), self.aspect());
        }
    }

    pub(super) fn scene_bounds(&self) -> Option<Bounds> {
        let baked = self.scene.baked.as_ref().map(|baked| &baked.dataset.scene);
        let scene = baked.or(self.scene.source.as_ref().map(|source| &*source.scene));
        scene.map(|scene| scene.mesh.bounds())
    }

    /// Width over height of the viewport.
    pub(super) fn aspect(&self) -> f32 {
        let [width, height] = self.interface.viewport_size;
        width as f32 / height.max(1) as f32
    }

    pub(super) fn copy_camera(&mut self, ctx: &Context) {
        ctx.copy_text(camera_text::text(&self.document.camera));
        self.messages.note("The camera is on the clipboard, as options of lapidary render");
    }

    /// Moves the camera to what a text on the clipboard says.
    pub(super) fn paste_camera(&mut self, text: &str) {
        match camera_text::parse(text) {
            Ok(camera) => self.document.camera = Camera { name: self.document.camera.name.clone(), ..camera },
            Err(error) => self.messages.error(format!("The clipboard holds no camera: {error:#}")),
        }
    }
}
