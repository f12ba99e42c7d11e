//! The scene that is open.

use super::first_view::FirstView;
use crate::{document::session::Unknown, jobs::Imported};
use lapidary_core::{animation::Animation, bounds::Bounds, dataset::BakeParts};
use lapidary_render::Baked;
use std::{path::PathBuf, sync::Arc};

/// The scene that is open, as far as it is not in the document.
#[derive(Default)]
pub struct OpenScene {
    /// The dataset, which can be rendered.
    pub baked: Option<Baked>,
    /// The scene without shadows, which is rendered until there is a dataset.
    pub preview: Option<Baked>,
    /// The scene, which can be baked.
    pub source: Option<Imported>,
    /// What moves in a scene that cannot be baked.
    pub animation: Option<Arc<Animation>>,
    /// Where a bake goes that the user asks for.
    pub bake_output: Option<PathBuf>,
    /// Where a bake goes that begins by itself.
    pub kept_output: Option<PathBuf>,
    /// Whether the dataset is a draft of a bake that is not finished.
    pub is_draft: bool,
    /// Show a bake of another version of the scene.
    pub show_stale: bool,
    /// The session file.
    pub session: Option<PathBuf>,
    /// Keys of the session file that this version does not know.
    pub unknown: Unknown,
    /// The camera that it was first seen by.
    pub first_view: Option<FirstView>,
}

/// What the picture is rendered by.
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

    /// The dataset if it is rendered: a bake of the scene as it is now. One without a ground that was asked for is not.
    pub fn shown(&self) -> Option<&Baked> {
        let is_replaced = |baked: &Baked| self.preview.as_ref().is_some_and(Baked::has_ground) && !baked.has_ground();
        self.baked.as_ref().filter(|baked| self.show_stale || !(self.is_stale() || is_replaced(baked)))
    }

    /// What is rendered: the dataset, or the scene without shadows.
    pub fn rendered(&self) -> Option<&Baked> {
        self.shown().or(self.preview.as_ref())
    }

    /// What the bake that is rendered is of; `None` without a scene.
    pub fn baked_parts(&self) -> Option<BakeParts> {
        self.rendered().map(|baked| baked.dataset.settings.mode)
    }

    /// What the picture is rendered by.
    pub fn seen(&self) -> BakeStage {
        match self.shown() {
            None => BakeStage::Unshadowed,
            Some(_) if self.is_draft => BakeStage::Draft,
            Some(_) => BakeStage::Whole,
        }
    }

    /// What moves in the scene file.
    pub fn animation(&self) -> Option<&Arc<Animation>> {
        self.source.as_ref().map_or(&self.animation, |source| &source.animation).as_ref()
    }

    /// Bounds of all that it has.
    pub fn bounds(&self) -> Option<Bounds> {
        let baked = self.baked.as_ref().map(|baked| &baked.dataset.scene);
        let scene = baked.or(self.source.as_ref().map(|source| &*source.scene));
        scene.map(|scene| scene.mesh.bounds())
    }

    /// Index of the object that a ground is, if one is shown.
    pub fn ground_object(&self) -> Option<u32> {
        self.rendered()?.dataset.scene.mesh.ground_object()
    }

    /// Index of the material of a ground, if one is shown.
    pub fn ground_material(&self) -> Option<usize> {
        self.rendered()?.dataset.scene.mesh.ground_material().map(|material| material as usize)
    }
}
