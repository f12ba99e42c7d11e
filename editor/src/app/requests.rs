//! Turns the document into requests for the render thread. A request is sent only when it differs from the last one, so that
//! nothing is rendered or compared while nothing changes.

use super::state::EditorState;
use crate::{
    document::{Document, lights::shines},
    jobs::render_thread::RenderRequest,
    viewport::ViewportResponse,
    workspace::BakeStage,
};
use egui::Context;
use lapidary_core::{dataset::BakeParts, environment::Environment};
use lapidary_render::{Appearance, Baked, Components, Illumination, Look, Solution, View};
use std::sync::Arc;

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
        let document = &self.work.document;
        let baked = self.work.scene.rendered();
        let bounces = baked.map_or(BakeParts::NONE, |b| b.dataset.bounces());
        let assigned = baked.and_then(|baked| self.picture.requests.assigned(document, baked));
        Some(Look {
            poses: baked.map(|baked| self.pose.poses_since(&self.work, baked)).unwrap_or_default(),
            appearance: Appearance { assigned, ..document.appearance() },
            illumination: illumination(document, environment),
            lights: document.lights.iter().filter(|light| shines(light)).cloned().collect(),
            components: shown_components(document, baked),
            solution: Solution::closest_to(document.solution, bounces).unwrap_or_default(),
            illum_cut: document.view.illum_cut,
            tau: document.view.tau,
            sampling: document.view.sampling,
            view: view_of(document, size),
            post: document.view.post,
        })
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

/// The components that are shown. An environment that lights no surface would only mislead as a background, and a
/// reference would have a bounce that the picture cannot have.
fn shown_components(document: &Document, baked: Option<&Baked>) -> Components {
    let shown = document.components.shown();
    let Some(dataset) = baked.map(|baked| &baked.dataset) else { return shown };
    let (has_environment, has_bounces) = (dataset.settings.mode.environment(), dataset.has_bounces());
    Components { environment: shown.environment && has_environment, indirect: shown.indirect && has_bounces, ..shown }
}

/// The environment with the document's rotation and intensity.
pub fn illumination(document: &Document, environment: Arc<Environment>) -> Illumination {
    let settings = &document.environment;
    Illumination { environment, rotation: settings.rotation(), intensity: settings.intensity, sun: settings.suns() }
}

/// The view of a document in a picture of `size` pixels.
pub fn view_of(document: &Document, size: [u32; 2]) -> View {
    let view = &document.view;
    View {
        aa: view.aa,
        background: view.background(),
        ground: document.bake.ground,
        mirrors: view.mirrors,
        mode: view.mode,
        basis: view.basis,
        wireframe: view.wireframe,
        ..View::new(document.camera.clone(), size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::{cut::packed::PackedCuts, dataset::BakeParts, sources::IndirectBake, test_scenes};

    #[test]
    fn light_that_was_not_baked_is_not_shown() {
        let document = Document::empty();
        let mut dataset = test_scenes::dataset(&["a"], &[]);
        let shown = shown_components(&document, Some(&dataset.clone().into()));
        assert_eq!(shown, Components { indirect: false, ..Components::ALL }, "no bounces were baked");
        dataset.settings.mode = BakeParts::INDIRECT;
        let shown = shown_components(&document, Some(&dataset.clone().into()));
        assert_eq!(shown, Components { direct: true, ..Components::NONE });
        let [cuts, environment_cuts] = [PackedCuts::default(), PackedCuts::default()];
        dataset.indirect = Some(IndirectBake { sources: Vec::new(), cuts, environment_cuts });
        let shown = shown_components(&document, Some(&dataset.into()));
        assert_eq!(shown, Components { environment: false, ..Components::ALL }, "negative control: bounces were");
        assert_eq!(shown_components(&document, None), Components::ALL);
    }
}
