//! A drag from a list of materials onto a surface of the viewport.

use crate::document::{Document, in_place_of};
use lapidary_core::material::{Material, PRESETS};

/// The payload of egui's drag and drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dragged {
    /// A preset, by its index.
    Preset {
        /// Which.
        index: usize,
        /// Whether the target material loses its maps.
        clear_maps: bool,
    },
    /// A material of the document, by its index.
    Material(usize),
}

impl Dragged {
    /// Its name beside the pointer.
    pub fn name(self, document: &Document) -> String {
        match self {
            Self::Preset { index, .. } => PRESETS[index].name.into(),
            Self::Material(index) => document.material_name(index),
        }
    }

    /// Its name in undo.
    pub fn label(self) -> &'static str {
        match self {
            Self::Preset { .. } => "Drop preset",
            Self::Material(_) => "Drop material",
        }
    }

    /// `target` with the dragged values; its name and sides stay. `None` if the dragged material is gone.
    pub fn applied_to(self, target: &Material, document: &Document) -> Option<Material> {
        match self {
            Self::Preset { index, clear_maps } => Some(PRESETS.get(index)?.applied_to(target, clear_maps)),
            Self::Material(index) => Some(in_place_of(target, document.materials.get(index)?.clone())),
        }
    }
}
