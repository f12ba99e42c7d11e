//! The settings of a bake by name. Errors and warnings refer to them, and each front end says how to change them.

use std::fmt;

/// A setting of a bake. Errors and warnings name it; a command line shows the option in its place, a window the
/// control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Number of light samples.
    Lights,
    /// Weight of the geometric metric in a mixed tree.
    Beta,
    /// Error bound of a cluster of lights.
    Sigma,
    /// Most nodes of a vertex's cut.
    MaxCut,
    /// Error bound of a whole cut.
    TotalError,
    /// Vertex clusters of the pilot visibility.
    PilotClusters,
    /// Most vertices after tessellation.
    MaxVertices,
    /// Most bytes of the vertices' cuts over the environment.
    MaxBytes,
    /// The pictures that the bake is for.
    Shots,
    /// Which parts are baked.
    Mode,
    /// Number of surface sources.
    Sources,
    /// Error bound of a cluster of sources.
    SourceSigma,
    /// How much the sources of a node may differ.
    SourceContrast,
    /// Largest solid angle of a node of sources.
    LargestSolidAngle,
    /// The viewpoint, which separates reachable surfaces from enclosed ones.
    Viewpoint,
    /// Levels of the meshless basis.
    Levels,
    /// How many of them send light.
    SenderLevels,
    /// Distance of its coarsest points.
    CoarseRadius,
    /// Rays by which each of its points gathers.
    GatherRays,
    /// Threshold of its links.
    Epsilon,
    /// Who traces rays.
    Device,
    /// Whether to resume an interrupted bake.
    Resume,
}

impl Setting {
    /// Its name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::Beta => "beta",
            Self::Sigma => "sigma",
            Self::MaxCut => "max cut",
            Self::TotalError => "total error",
            Self::PilotClusters => "pilot clusters",
            Self::MaxVertices => "max vertices",
            Self::MaxBytes => "max bytes",
            Self::Shots => "shots",
            Self::Mode => "mode",
            Self::Sources => "sources",
            Self::SourceSigma => "source sigma",
            Self::SourceContrast => "source contrast",
            Self::LargestSolidAngle => "largest solid angle",
            Self::Viewpoint => "viewpoint",
            Self::Levels => "levels",
            Self::SenderLevels => "sender levels",
            Self::CoarseRadius => "coarse radius",
            Self::GatherRays => "gather rays",
            Self::Epsilon => "epsilon",
            Self::Device => "device",
            Self::Resume => "resume",
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Name of a setting in a front end.
pub type Naming = fn(Setting) -> &'static str;
