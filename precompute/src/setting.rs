//! Names of bake settings. Errors and warnings refer to them, and each front end names its own controls.

use std::fmt;

/// A setting of a bake. Errors and warnings name it; a command line shows the option instead, a window the control.
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
    /// Pictures for which the bake is made.
    Shots,
    /// Parts to bake.
    Mode,
    /// Number of surface sources.
    Sources,
    /// Error bound of a cluster of sources.
    SourceSigma,
    /// Largest contrast between the sources of a node.
    SourceContrast,
    /// Largest solid angle of a node of sources.
    LargestSolidAngle,
    /// The viewpoint, which separates reachable surfaces from enclosed ones.
    Viewpoint,
    /// Levels of the meshless basis.
    Levels,
    /// Number of levels that send light.
    SenderLevels,
    /// Distance of the coarsest points of the meshless basis.
    CoarseRadius,
    /// Gather rays per point of the meshless basis.
    GatherRays,
    /// Threshold of meshless links.
    Epsilon,
    /// Number of functions of all objects.
    Functions,
    /// Levels of the objects' functions.
    ObjectLevels,
    /// The level of the objects' functions that sends light.
    SenderLevel,
    /// Threshold of compression of wavelet transport.
    Compression,
    /// Whether to resume an interrupted bake.
    Resume,
}

impl Setting {
    /// Plain name.
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
            Self::Functions => "functions",
            Self::ObjectLevels => "object levels",
            Self::SenderLevel => "sender level",
            Self::Compression => "compression",
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
