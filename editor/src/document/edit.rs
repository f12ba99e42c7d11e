//! Edits: a value that takes another's place. Swapping it in leaves the old one in the edit, which is then its inverse.

use super::{Document, EnvironmentSettings, ViewSettings};
use lapidary_core::{camera::Camera, dataset::BakeSettings, material::Material};
use std::mem::{discriminant, swap};

/// One change to a document.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Another value for a material.
    Material {
        /// Which.
        index: usize,
        /// Its new value.
        material: Box<Material>,
    },
    /// Another light.
    Environment(EnvironmentSettings),
    /// Other view settings.
    View(ViewSettings),
    /// Other bookmarks.
    Bookmarks(Vec<Camera>),
    /// Other settings for the next bake.
    Bake(Box<BakeSettings>),
}

/// The least that must be done again after an edit (all that comes later in the list follows from it).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Redo {
    /// Nothing that is drawn.
    Nothing,
    /// The post pass.
    Post,
    /// Deferred pass and merge.
    Picture,
    /// Illumination cut and merge.
    Light,
}

impl Edit {
    /// Puts the edit's value into the document, and the document's into the edit.
    ///
    /// # Panics
    /// If it names a material that the document does not have.
    pub fn swap(&mut self, document: &mut Document) {
        match self {
            Self::Material { index, material } => swap(&mut **material, &mut document.materials[*index]),
            Self::Environment(environment) => swap(environment, &mut document.environment),
            Self::View(view) => swap(view, &mut document.view),
            Self::Bookmarks(bookmarks) => swap(bookmarks, &mut document.bookmarks),
            Self::Bake(bake) => swap(&mut **bake, &mut document.bake),
        }
    }

    /// Whether both change the same part of a document.
    pub fn same_target(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Material { index: a, .. }, Self::Material { index: b, .. }) => a == b,
            _ => discriminant(self) == discriminant(other),
        }
    }

    /// What must be done again when this edit is swapped into `document`.
    pub fn redo(&self, document: &Document) -> Redo {
        match self {
            Self::Material { .. } => Redo::Picture,
            Self::Environment(e) if *e == document.environment => Redo::Nothing,
            Self::Environment(_) => Redo::Light,
            Self::View(view) => view_redo(view, &document.view),
            Self::Bookmarks(_) | Self::Bake(_) => Redo::Nothing,
        }
    }
}

fn view_redo(new: &ViewSettings, old: &ViewSettings) -> Redo {
    if new.illum_cut != old.illum_cut {
        return Redo::Light;
    }
    let but_post =
        |view: &ViewSettings| ViewSettings { post: Default::default(), frame_budget_ms: 0.0, ..view.clone() };
    if but_post(new) != but_post(old) {
        Redo::Picture
    } else if new.post != old.post {
        Redo::Post
    } else {
        Redo::Nothing
    }
}
