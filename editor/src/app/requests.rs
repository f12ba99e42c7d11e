//! From the document to what the render thread is asked for. A request is sent when it differs from the last one, so that
//! nothing is rendered, and nothing compared over there, while nothing changes.

use super::state::EditorState;
use crate::{
    document::{Bounces, Document, lights::shines},
    jobs::render_thread::RenderRequest,
    look::Look,
    viewport::ViewportResponse,
};
use egui::Context;
use lapidary_core::{environment::Environment, lights::Light, material::Material};
use lapidary_render::{Appearance, Baked, Components, Illumination, View};
use std::sync::Arc;

/// What was asked for last.
#[derive(Default)]
pub struct Requests {
    appearance: Appearance,
    appearance_revision: u64,
    lights: Arc<[Light]>,
    sent: Option<RenderRequest>,
    /// The next one is sent even if it is the same.
    is_forgotten: bool,
    /// Revision of the document when no button was held.
    at_rest: u64,
}

impl Requests {
    /// The document's appearance, which has another revision whenever a material or texture is another.
    fn appearance_of(&mut self, document: &Document) -> &Appearance {
        if self.appearance_revision == 0 || !same_appearance(&self.appearance, document) {
            self.appearance = document.appearance();
            self.appearance_revision += 1;
        }
        &self.appearance
    }

    /// The lights that shine, in one place in memory as long as they are the same.
    fn lights_of(&mut self, document: &Document) -> Arc<[Light]> {
        let shining = || document.lights.iter().filter(|light| shines(light));
        if !shining().eq(self.lights.iter()) {
            self.lights = shining().cloned().collect();
        }
        self.lights.clone()
    }

    /// What the render thread was asked for last.
    pub fn last_sent(&self) -> Option<&RenderRequest> {
        self.sent.as_ref()
    }

    /// Sends the next request even if it is that of before: the scene was replaced in place.
    pub fn forget(&mut self) {
        self.is_forgotten = true;
    }
}

fn same_appearance(appearance: &Appearance, document: &Document) -> bool {
    let same_texture = |(a, b): (&Arc<_>, &crate::document::TextureEntry)| Arc::ptr_eq(a, &b.texture);
    let same_material = |(a, b): (&Material, &Material)| a == b;
    appearance.textures.len() == document.textures.len()
        && appearance.materials.len() == document.materials.len()
        && appearance.textures.iter().zip(&document.textures).all(same_texture)
        && appearance.materials.iter().zip(&document.materials).all(same_material)
}

impl EditorState {
    /// Asks for a picture of the document as it is now, in the size of the viewport.
    pub(super) fn request_picture(&mut self, ctx: &Context, viewport: ViewportResponse) {
        let moving = viewport.moving || self.is_editing_by_pointer(ctx);
        let Some(look) = self.look(viewport.size_px) else { return };
        let request = RenderRequest {
            baked: self.scene.shown().cloned(),
            look,
            // That of the look, which has just been made.
            appearance_revision: self.requests.appearance_revision,
            moving,
            frame_budget_ms: self.document.view.frame_budget_ms,
        };
        let sent = self.requests.sent.as_ref().filter(|_| !self.requests.is_forgotten);
        if sent.is_some_and(|sent| sent.is_same(&request)) {
            return;
        }
        self.render.request(request.clone());
        (self.requests.sent, self.requests.is_forgotten) = (Some(request), false);
    }

    /// Everything that decides the picture of the document in a viewport of `size` pixels; `None` before there is an
    /// environment.
    pub(super) fn look(&mut self, size: [u32; 2]) -> Option<Look> {
        let environment = self.environments.loaded()?.clone();
        let document = &self.document;
        let baked = self.scene.shown();
        let bounces = baked.map(|b| Bounces::of(&b.dataset)).unwrap_or_default();
        Some(Look {
            appearance: self.requests.appearance_of(document).clone(),
            light: illumination(document, environment),
            lights: self.requests.lights_of(document),
            components: shown_components(document, baked),
            solution: bounces.closest_to(document.solution).unwrap_or_default(),
            illum_cut: document.view.illum_cut,
            sampling: document.view.sampling,
            view: view_of(document, size),
            post: document.view.post,
        })
    }

    /// Whether a button is held and has changed the document, as a slider that is dragged has.
    fn is_editing_by_pointer(&mut self, ctx: &Context) -> bool {
        let revision = self.history.revision();
        if !ctx.input(|i| i.pointer.any_down()) {
            self.requests.at_rest = revision;
        }
        self.requests.at_rest != revision
    }
}

/// The components that are shown: an environment that no surface is lit by would only mislead behind the scene, and a
/// reference would have a bounce that the picture cannot have.
fn shown_components(document: &Document, baked: Option<&Baked>) -> Components {
    let shown = document.components.shown();
    let Some(dataset) = baked.map(|baked| &baked.dataset) else { return shown };
    let (has_environment, has_bounces) = (dataset.settings.mode.environment(), Bounces::of(dataset).any());
    Components { environment: shown.environment && has_environment, indirect: shown.indirect && has_bounces, ..shown }
}

/// The environment as a document has it turned and scaled.
pub fn illumination(document: &Document, environment: Arc<Environment>) -> Illumination {
    let settings = &document.environment;
    Illumination { environment, rotation: settings.rotation(), intensity: settings.intensity }
}

/// What a picture of `size` pixels shows of a document.
pub fn view_of(document: &Document, size: [u32; 2]) -> View {
    let view = &document.view;
    View {
        aa: view.aa,
        background: view.background(),
        mode: view.mode,
        wireframe: view.wireframe,
        ..View::new(document.camera.clone(), size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{TextureEntry, test_data};
    use lapidary_core::{cut::packed::PackedCuts, dataset::BakeParts, indirect::IndirectBake, texture::Texture};

    #[test]
    fn lights_stay_where_they_are_until_what_shines_changes() {
        let mut requests = Requests::default();
        let off = Light { enabled: false, ..test_data::light() };
        let mut document = Document { lights: vec![test_data::light(), off], ..Document::empty() };
        let first = requests.lights_of(&document);
        assert_eq!(*first, [test_data::light()]);
        document.lights[1].intensity *= 2.0;
        assert!(Arc::ptr_eq(&first, &requests.lights_of(&document)), "it is switched off");
        document.lights[0].intensity *= 2.0;
        assert!(!Arc::ptr_eq(&first, &requests.lights_of(&document)));
    }

    #[test]
    fn light_that_was_not_baked_is_not_shown() {
        let document = Document::empty();
        let mut dataset = test_data::dataset(&["a"], &[]);
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

    #[test]
    fn the_appearance_has_another_number_only_when_it_is_another() {
        let mut requests = Requests::default();
        let mut document = Document { materials: vec![Material::default()], ..Document::empty() };
        let mut revision_of = |document: &Document| {
            requests.appearance_of(document);
            requests.appearance_revision
        };
        let first = revision_of(&document);
        document.view.post.exposure = 1.0;
        assert_eq!(revision_of(&document), first);
        document.materials[0].parameters.roughness = 0.1;
        let second = revision_of(&document);
        assert_ne!(second, first);
        document.textures.push(TextureEntry { texture: Arc::new(Texture::missing("a")), file: None });
        let third = revision_of(&document);
        assert_ne!(third, second);
        document.textures[0].texture = Arc::new(Texture::missing("a"));
        assert_ne!(revision_of(&document), third);
    }
}
