//! The open scene.

use super::first_view::FirstView;
use crate::{document::session::Unknown, jobs::Imported};
use lapidary_core::{animation::Animation, bounds::Bounds, dataset::BakeParts};
use lapidary_render::Baked;
use std::{path::PathBuf, sync::Arc};

/// The open scene, without the document.
#[derive(Default)]
pub struct OpenScene {
    /// The dataset, which can be rendered.
    pub baked: Option<Baked>,
    /// The scene without shadows, which is rendered until there is a dataset.
    pub preview: Option<Baked>,
    /// The scene, which can be baked.
    pub source: Option<Imported>,
    /// The animation of a scene that cannot be baked.
    pub animation: Option<Arc<Animation>>,
    /// Output of a bake that the user asks for.
    pub bake_output: Option<PathBuf>,
    /// Output of an automatic bake.
    pub kept_output: Option<PathBuf>,
    /// Whether the dataset is a draft of a bake that is not finished.
    pub is_draft: bool,
    /// Whether a bake of another version of the scene is shown.
    pub show_stale: bool,
    /// The session file.
    pub session: Option<PathBuf>,
    /// Keys of the session file that this version does not know.
    pub unknown: Unknown,
    /// The camera of the first view.
    pub first_view: Option<FirstView>,
}

/// Data behind the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeStage {
    /// The scene without shadows.
    Unshadowed,
    /// A draft of a bake.
    Draft,
    /// A bake.
    Whole,
}

impl OpenScene {
    /// Whether the dataset was baked from another version of the scene.
    pub fn is_stale(&self) -> bool {
        let hashes = self.baked.as_ref().zip(self.source.as_ref());
        hashes.is_some_and(|(baked, source)| baked.dataset.scene_hash != source.hash)
    }

    /// The dataset if it is rendered: a bake of the scene as it is now. A bake that lacks a requested ground is not.
    pub fn shown(&self) -> Option<&Baked> {
        let is_replaced = |baked: &Baked| self.preview.as_ref().is_some_and(Baked::has_ground) && !baked.has_ground();
        self.baked.as_ref().filter(|baked| self.show_stale || !(self.is_stale() || is_replaced(baked)))
    }

    /// The rendered data: the dataset, or the scene without shadows.
    pub fn rendered(&self) -> Option<&Baked> {
        self.shown().or(self.preview.as_ref())
    }

    /// Parts of the rendered bake; `None` without a scene.
    pub fn baked_parts(&self) -> Option<BakeParts> {
        self.rendered().map(|baked| baked.dataset.settings.mode)
    }

    /// Data behind the picture.
    pub fn seen(&self) -> BakeStage {
        match self.shown() {
            None => BakeStage::Unshadowed,
            Some(_) if self.is_draft => BakeStage::Draft,
            Some(_) => BakeStage::Whole,
        }
    }

    /// The animation of the scene file.
    pub fn animation(&self) -> Option<&Arc<Animation>> {
        self.source.as_ref().map_or(&self.animation, |source| &source.animation).as_ref()
    }

    /// Bounds of the whole scene.
    pub fn bounds(&self) -> Option<Bounds> {
        let baked = self.baked.as_ref().map(|baked| &baked.dataset.scene);
        let scene = baked.or(self.source.as_ref().map(|source| &*source.scene));
        scene.map(|scene| scene.mesh.bounds())
    }

    /// Index of the ground's object, if one is shown.
    pub fn ground_object(&self) -> Option<u32> {
        self.rendered()?.dataset.scene.mesh.ground_object()
    }

    /// Whether vertices have a second set of texture coordinates, and colors.
    pub fn has_second_uvs_and_colors(&self) -> [bool; 2] {
        let mesh = self.rendered().map(|baked| &baked.dataset.scene.mesh);
        mesh.map_or([false; 2], |mesh| [!mesh.second_uvs.is_empty(), !mesh.colors.is_empty()])
    }

    /// Index of the ground's material, if one is shown.
    pub fn ground_material(&self) -> Option<usize> {
        self.rendered()?.dataset.scene.mesh.ground_material().map(|material| material as usize)
    }
}
