//! The message stream of a long job, for a window or a command line.

use crate::warning::Warning;
use serde::Serialize;

/// A phase of a bake, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Reading the scene.
    Import,
    /// Subdividing where visibility varies.
    Tessellate,
    /// Visibility of a few vertices of each cluster.
    Pilot,
    /// Clustering the light samples.
    Tree,
    /// Visibility of all bake points, and their cuts.
    Visibility,
    /// Placing surface sources where light reaches.
    Points,
    /// Clustering the sources.
    SourceTree,
    /// Solid angles of the sources from all bake points, and their cuts.
    SourceVisibility,
    /// Visibility of the environment from the sources, and their cuts.
    SourceEnvironment,
    /// Placing the points of the meshless basis.
    Basis,
    /// Computing light transport between the functions.
    Transport,
    /// Placing the functions of each object.
    ObjectBases,
    /// Wavelet transport between quads.
    Wavelet,
    /// Packing and writing.
    Pack,
}

impl Phase {
    /// All phases in order.
    pub const ALL: [Self; 14] = [
        Self::Import,
        Self::Tessellate,
        Self::Pilot,
        Self::Tree,
        Self::Visibility,
        Self::Points,
        Self::SourceTree,
        Self::SourceVisibility,
        Self::SourceEnvironment,
        Self::Basis,
        Self::Transport,
        Self::ObjectBases,
        Self::Wavelet,
        Self::Pack,
    ];

    /// Name as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Import => "import",
            Self::Tessellate => "tessellate",
            Self::Pilot => "pilot",
            Self::Tree => "tree",
            Self::Visibility => "visibility",
            Self::Points => "points",
            Self::SourceTree => "source-tree",
            Self::SourceVisibility => "source-visibility",
            Self::SourceEnvironment => "source-environment",
            Self::Basis => "basis",
            Self::Transport => "transport",
            Self::ObjectBases => "object-bases",
            Self::Wavelet => "wavelet",
            Self::Pack => "pack",
        }
    }
}

/// A message from a job.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "event")]
pub enum Event {
    /// A phase started; `total` is its units of work (0 if unknown).
    Started {
        /// The phase.
        phase: Phase,
        /// Units of work.
        total: u64,
        /// Name of a unit.
        unit: &'static str,
    },
    /// `done` units of the current phase are complete.
    Advanced {
        /// Completed units.
        done: u64,
    },
    /// Something was repaired or left out.
    Warning {
        /// The warning, with a remedy.
        message: Warning,
    },
}

/// Receives the messages of a job and may cancel it. Several threads call it.
pub trait Observer: Sync {
    /// Receives a message.
    fn event(&self, event: Event);

    /// Whether the job should stop as soon as it can.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Ignores messages and never cancels.
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _event: Event) {}
}
