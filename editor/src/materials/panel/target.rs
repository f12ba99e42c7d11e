//! The edited map of a material.

use crate::actions::{Action, MaterialAction};
use lapidary_core::material::map_label;
use std::path::PathBuf;

/// A map of a material.
#[derive(Clone, Copy)]
pub struct Target {
    /// Which material.
    pub index: usize,
    /// Which map.
    pub kind: &'static str,
}

impl Target {
    /// "Roughness map".
    pub fn name(self) -> String {
        let label = map_label(self.kind);
        if label.ends_with("map") { label.to_owned() } else { format!("{label} map") }
    }

    /// Asks for a picture, or for the path of one.
    pub fn load(self, path: Option<PathBuf>, actions: &mut Vec<Action>) {
        actions.push(Action::Material(MaterialAction::LoadTexture { material: self.index, map: self.kind, path }));
    }
}
