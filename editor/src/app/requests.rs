//! Turns the document into requests for the render thread. A request is sent only when it differs from the last one, so that
//! nothing is rendered or compared while nothing changes.

use super::state::EditorState;
use crate::{
    document::BackgroundKind, jobs::render_thread::RenderRequest, look::look_of, looks::PictureOfDocument,
    viewport::ViewportResponse, workspace::BakeStage,
};
use egui::Context;
use lapidary_render::Look;

impl EditorState {
    /// Requests a picture of the document at the size of the viewport.
    pub(super) fn request_picture(&mut self, ctx: &Context, viewport: ViewportResponse) {
        let is_dragging = viewport.moving || self.is_editing_by_pointer(ctx);
        // A clip may play for hours.
        self.baking.hold(is_dragging);
        let moving = is_dragging || self.pose.timeline.playing;
        self.baking.follow_edits(&mut self.work, moving);
        self.picture
            .render
            .set_preview(self.work.scene.seen() == BakeStage::Unshadowed && self.baking.progress().is_some());
        let Some(look) = self.look(viewport.size_px) else { return };
        let request = RenderRequest {
            baked: self.work.scene.rendered().cloned(),
            look,
            moving,
            may_pose: self.pose.movable(&self.work).is_some(),
            frame_budget_ms: self.work.document.view.frame_budget_ms,
            pointer: ctx.input(|i| i.pointer.latest_pos()).and_then(|at| viewport.place(at)),
        };
        let sent = self.picture.requests.sent.as_ref().filter(|_| !self.picture.requests.is_forgotten);
        if sent.is_some_and(|sent| sent.is_same(&request)) {
            return;
        }
        self.picture.render.request(request.clone());
        (self.picture.requests.sent, self.picture.requests.is_forgotten) = (Some(request), false);
    }

    /// The look of the document in a viewport of `size` pixels; `None` without an environment.
    pub(super) fn look(&self, size: [u32; 2]) -> Option<Look> {
        let environment = self.environments.loaded()?.clone();
        let (document, baked) = (&self.work.document, self.work.scene.rendered());
        let assigned = baked.and_then(|baked| self.picture.requests.assigned(document, baked));
        let poses = baked.map(|baked| self.pose.poses_since(&self.work, baked)).unwrap_or_default();
        let backplate =
            self.picture.backplate.picture().filter(|_| document.view.background == BackgroundKind::Picture);
        Some(Look { backplate, ..look_of(document, baked, environment, (assigned, poses), size) })
    }

    /// What the window shows, for pictures that are made elsewhere; `None` without a scene.
    pub(super) fn shown_document(&self, size: [u32; 2]) -> Option<PictureOfDocument> {
        let baked = self.work.scene.rendered()?.clone();
        let poses = self.pose.poses_since(&self.work, &baked);
        Some(PictureOfDocument { document: self.work.document.clone(), baked, poses, size, aa: None })
    }

    /// Whether a button is held and has changed the document, as in a drag of a slider.
    fn is_editing_by_pointer(&mut self, ctx: &Context) -> bool {
        let revision = self.work.history.revision();
        if !ctx.input(|i| i.pointer.any_down()) {
            self.picture.requests.at_rest = revision;
        }
        self.picture.requests.at_rest != revision
    }
}
