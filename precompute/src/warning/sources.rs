//! Warnings about surface sources.

use crate::setting::{Naming, Setting};

/// A warning about surface sources.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourcesWarning {
    /// The surface sources differ from those of the checkpoint.
    Other,
    /// Areas of surface sources are noisy.
    UnevenAreas {
        /// Mean number of points that estimate each area.
        points: f32,
    },
    /// Many surface sources have no area.
    WithoutArea {
        /// Number of sources without area.
        without: usize,
        /// Number of all sources.
        sources: usize,
    },
}

impl SourcesWarning {
    /// The message, with settings named by `name`.
    pub(super) fn text(&self, name: Naming) -> String {
        match self {
            Self::Other => {
                "the surface sources differ from those of the interrupted bake, or the vertices do, because cameras, lights, \
                 objects or the device have changed; the finished part of their cuts is baked again"
                    .into()
            }
            Self::UnevenAreas { points } => format!(
                "light reaches a small part of the scene: only {points:.1} points estimate the area of each surface source, \
                 so bounced light is uneven; remove unreachable surfaces, or give a place in a larger space as {}",
                name(Setting::Viewpoint)
            ),
            Self::WithoutArea { without, sources } => format!(
                "{without} of {sources} surface sources have no area and bounce no light; lower {}, or check the scene for \
                 coincident faces",
                name(Setting::Sources)
            ),
        }
    }
}
