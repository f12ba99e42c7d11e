//! Warnings about the meshless basis.

use crate::setting::{Naming, Setting};

/// A warning about the meshless basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BasisWarning {
    /// The points of the meshless basis differ from those of the checkpoint.
    Other,
    /// The meshless basis has almost no functions.
    FewFunctions,
    /// A level of the meshless basis ends before it covers all surfaces.
    UncoveredLevel {
        /// The level, from 1.
        level: usize,
        /// Number of its points.
        points: usize,
    },
}

impl BasisWarning {
    /// The message, with settings named by `name`.
    pub(super) fn text(&self, name: Naming) -> String {
        match self {
            Self::Other => {
                "the points of the meshless basis differ from those of the interrupted bake, because cameras, lights or \
                 objects have changed; the finished part of their links is baked again"
                    .into()
            }
            Self::FewFunctions => format!(
                "the meshless basis has almost no functions: light reaches hardly any surface; give a place inside the scene \
                 as {}",
                name(Setting::Viewpoint)
            ),
            Self::UncoveredLevel { level, points } => format!(
                "level {level} of the meshless basis ends at {points} points, before they cover all surfaces, and light is \
                 missing; give a larger {} or fewer {}",
                name(Setting::CoarseRadius),
                name(Setting::Levels)
            ),
        }
    }
}
