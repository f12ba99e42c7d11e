//! What the render thread was asked for last, and what a request is made of.

use crate::{
    document::{Document, lights::shines},
    jobs::render_thread::RenderRequest,
};
use lapidary_core::{lights::Light, material::Material};
use lapidary_render::Appearance;
use std::sync::Arc;

/// What was asked for last.
#[derive(Default)]
pub struct Requests {
    pub(in crate::app) appearance: Appearance,
    pub(in crate::app) appearance_revision: u64,
    pub(in crate::app) lights: Arc<[Light]>,
    pub(in crate::app) sent: Option<RenderRequest>,
    /// The next one is sent even if it is the same.
    pub(in crate::app) is_forgotten: bool,
    /// Revision of the document when no button was held.
    pub(in crate::app) at_rest: u64,
}

impl Requests {
    /// The document's appearance, which has another revision whenever a material or texture is another.
    pub(in crate::app) fn appearance_of(&mut self, document: &Document) -> &Appearance {
        if self.appearance_revision == 0 || !same_appearance(&self.appearance, document) {
            self.appearance = document.appearance();
            self.appearance_revision += 1;
        }
        &self.appearance
    }

    /// The lights that shine, in one place in memory as long as they are the same.
    pub(in crate::app) fn lights_of(&mut self, document: &Document) -> Arc<[Light]> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::TextureEntry;
    use lapidary_core::test_scenes;
    use lapidary_core::texture::Texture;

    #[test]
    fn lights_stay_where_they_are_until_what_shines_changes() {
        let mut requests = Requests::default();
        let off = Light { enabled: false, ..test_scenes::light() };
        let mut document = Document { lights: vec![test_scenes::light(), off], ..Document::empty() };
        let first = requests.lights_of(&document);
        assert_eq!(*first, [test_scenes::light()]);
        document.lights[1].intensity *= 2.0;
        assert!(Arc::ptr_eq(&first, &requests.lights_of(&document)), "it is switched off");
        document.lights[0].intensity *= 2.0;
        assert!(!Arc::ptr_eq(&first, &requests.lights_of(&document)));
    }

    #[test]
    fn the_appearance_has_another_number_only_when_it_is_another() {
        let mut requests = Requests::default();
        let mut document = Document { materials: vec![Material::default()], ..Document::empty() };
        let mut revision_of = |document: &Document| {
            requests.appearance_of(document);
            requests.appearance_revision
        };
        assert_eq!(revision_of(&document), 1);
        document.view.post.exposure = 1.0;
        assert_eq!(revision_of(&document), 1);
        document.materials[0].parameters.roughness = 0.1;
        assert_eq!(revision_of(&document), 2);
        document.textures.push(TextureEntry { texture: Arc::new(Texture::missing("a")), file: None });
        assert_eq!(revision_of(&document), 3);
        document.textures[0].texture = Arc::new(Texture::missing("a"));
        assert_eq!(revision_of(&document), 4);
    }
}
