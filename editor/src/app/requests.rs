//! From the document to what the render thread is asked for. A request is sent when it differs from the last one, so that
//! nothing is rendered, and nothing compared over there, while nothing changes.

use super::state::EditorState;
use crate::{
    document::{Bounces, Document, lights::shines},
    jobs::render_thread::RenderRequest,
    viewport::ViewportResponse,
};
use egui::Context;
use lapidary_core::{environment::Environment, lights::Light, material::Material};
use lapidary_render::{Appearance, Baked, BrdfSampling, Components, Illumination, Post, Solution, View};
use std::sync::Arc;

/// What was asked for last.
#[derive(Default)]
pub struct Requests {
    appearance: Appearance,
    appearance_revision: u64,
    lights: Arc<[Light]>,
    last: Option<Key>,
    sent: Option<RenderRequest>,
    /// Revision of the document when no button was held.
    at_rest: u64,
}

/// Everything that decides a picture, small enough to compare every frame.
#[derive(PartialEq)]
struct Key {
    dataset: Option<usize>,
    appearance: u64,
    environment: usize,
    rotation: f32,
    intensity: f32,
    lights: usize,
    components: Components,
    solution: Solution,
    illum_cut: u32,
    sampling: BrdfSampling,
    view: View,
    post: Post,
    moving: bool,
    frame_budget_ms: f32,
}

impl Requests {
    /// The number of the document's appearance, which is another whenever a material or texture is.
    fn revision_of(&mut self, document: &Document) -> u64 {
        if self.appearance_revision == 0 || !same_appearance(&self.appearance, document) {
            self.appearance = document.appearance();
            self.appearance_revision += 1;
        }
        self.appearance_revision
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
        self.last = None;
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
        let Some(environment) = self.environments.loaded().cloned() else { return };
        let moving = viewport.moving || self.is_editing_by_pointer(ctx);
        let appearance_revision = self.requests.revision_of(&self.document);
        let lights = self.requests.lights_of(&self.document);
        let document = &self.document;
        let baked = self.scene.shown().cloned();
        let bounces = baked.as_ref().map(|b| Bounces::of(&b.dataset)).unwrap_or_default();
        let view = view_of(document, viewport.size_px);
        let key = Key {
            dataset: baked.as_ref().map(|b| Arc::as_ptr(&b.dataset) as usize),
            appearance: appearance_revision,
            environment: Arc::as_ptr(&environment) as usize,
            rotation: document.environment.rotation(),
            intensity: document.environment.intensity,
            lights: lights.as_ptr() as usize,
            components: shown_components(document, baked.as_ref()),
            solution: bounces.closest_to(document.solution).unwrap_or_default(),
            illum_cut: document.view.illum_cut,
            sampling: document.view.sampling,
            view: view.clone(),
            post: document.view.post,
            moving,
            frame_budget_ms: document.view.frame_budget_ms,
        };
        if self.requests.last.as_ref() == Some(&key) {
            return;
        }
        let request = RenderRequest {
            baked,
            appearance: self.requests.appearance.clone(),
            appearance_revision,
            illumination: illumination(document, environment),
            lights,
            components: key.components,
            solution: key.solution,
            illum_cut: key.illum_cut,
            sampling: key.sampling,
            view,
            post: key.post,
            moving,
            frame_budget_ms: key.frame_budget_ms,
        };
        self.render.request(request.clone());
        (self.requests.last, self.requests.sent) = (Some(key), Some(request));
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

/// The components that are shown: an environment that no surface is lit by would only mislead behind the scene.
pub fn shown_components(document: &Document, baked: Option<&Baked>) -> Components {
    let shown = document.components.shown();
    let has_environment = baked.is_none_or(|baked| baked.dataset.settings.mode.environment());
    Components { environment: shown.environment && has_environment, ..shown }
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
    use lapidary_core::{dataset::BakeMode, texture::Texture};

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
    fn an_environment_that_was_not_baked_is_not_shown() {
        let document = Document::empty();
        let mut dataset = test_data::dataset(&["a"], &[]);
        assert_eq!(shown_components(&document, Some(&dataset.clone().into())), Components::ALL, "negative control");
        dataset.settings.mode = BakeMode::Indirect;
        let shown = shown_components(&document, Some(&dataset.into()));
        assert_eq!(shown, Components { environment: false, ..Components::ALL });
        assert_eq!(shown_components(&document, None), Components::ALL);
    }

    #[test]
    fn the_appearance_has_another_number_only_when_it_is_another() {
        let mut requests = Requests::default();
        let mut document = Document { materials: vec![Material::default()], ..Document::empty() };
        let first = requests.revision_of(&document);
        document.view.post.exposure = 1.0;
        assert_eq!(requests.revision_of(&document), first);
        document.materials[0].parameters.roughness = 0.1;
        let second = requests.revision_of(&document);
        assert_ne!(second, first);
        document.textures.push(TextureEntry { texture: Arc::new(Texture::missing("a")), file: None });
        let third = requests.revision_of(&document);
        assert_ne!(third, second);
        document.textures[0].texture = Arc::new(Texture::missing("a"));
        assert_ne!(requests.revision_of(&document), third);
    }
}
