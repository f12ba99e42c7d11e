//! Requests about local lights.

use crate::document::lights::LightKind;
use glam::Vec3;
use std::path::PathBuf;

/// A request about local lights.
#[derive(Clone, Debug)]
pub enum LightAction {
    /// Select a local light, or nothing.
    Select(Option<usize>),
    /// Add a local light that lights what the camera looks at.
    Add(LightKind),
    /// Add a copy of a local light beside it.
    Duplicate(usize),
    /// Remove a local light.
    Delete(usize),
    /// Aim the selected light at a point, which ends aiming by a click; without a point the light stays as it is.
    Aim(Option<Vec3>),
    /// Add the lights of a lights file.
    Load(Option<PathBuf>),
    /// Write the lights to a lights file.
    Save(Option<PathBuf>),
}

impl LightAction {
    /// Its path, if it has one.
    pub fn path(&mut self) -> Option<&mut Option<PathBuf>> {
        match self {
            Self::Load(path) | Self::Save(path) => Some(path),
            _ => None,
        }
    }
}
