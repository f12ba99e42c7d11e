//! Repairs, omissions and changes of settings by a bake.

mod meshless;
mod sources;

pub use meshless::BasisWarning;
pub use sources::SourcesWarning;

use crate::setting::{Naming, Setting};
use glam::Vec3;
use serde::{Serialize, Serializer};
use std::{fmt, path::PathBuf};

/// A repair or omission, with a remedy.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// Plain text: a warning of the import.
    Text(String),
    /// The mesh already has as many vertices as its budget allows.
    NoRoomForVertices {
        /// Vertices of the mesh.
        vertices: usize,
        /// A limit that leaves room for more.
        enough: usize,
    },
    /// A shot, counted from 1, sees no surface.
    BlindShot(usize),
    /// The checkpoint belongs to other bake points or another light tree.
    OtherCheckpoint,
    /// An unfinished bake was discarded, because resuming was not requested.
    Discarded,
    /// The checkpoint's folder contains foreign files, and stays.
    KeptFolder {
        /// The first of these files.
        path: PathBuf,
    },
    /// A graphics adapter did not trace, or stopped.
    DeviceFailed {
        /// The adapter and why.
        reason: String,
    },
    /// Cuts were coarsened to fit a texture.
    Coarsened {
        /// The leaves of the cuts.
        leaves: &'static str,
        /// The setting that bounds their error.
        bound: Setting,
        /// The requested bound.
        asked: f32,
        /// The bound after coarsening.
        fitted: f32,
    },
    /// Much light leaves the scene.
    OpenViewpoint {
        /// Position in meters.
        viewpoint: Vec3,
        /// Share of the directions around it that hit no surface.
        open: f32,
    },
    /// A closed space reflects nearly all light.
    EndlessBounces,
    /// Wavelet transport of surfaces with maps.
    PlainQuads {
        /// The first material with a map.
        material: String,
    },
    /// A warning about surface sources.
    Sources(SourcesWarning),
    /// A warning about the meshless basis.
    Basis(BasisWarning),
}

impl Warning {
    /// Whether it concerns the fate of a checkpoint. Such warnings do not affect the result.
    pub(crate) fn is_about_resuming(&self) -> bool {
        match self {
            Self::OtherCheckpoint | Self::Discarded | Self::KeptFolder { .. } => true,
            Self::Sources(warning) => *warning == SourcesWarning::Other,
            Self::Basis(warning) => *warning == BasisWarning::Other,
            _ => false,
        }
    }

    /// The message, with settings named by `name`.
    pub fn text(&self, name: Naming) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::NoRoomForVertices { vertices, enough } => format!(
                "the scene already has {vertices} vertices, so no triangle is split and shadows on large ones are lost; give \
                 {} {enough} or more",
                name(Setting::MaxVertices)
            ),
            Self::BlindShot(number) => format!("shot {number} sees no surface and is left out; check its camera"),
            Self::OtherCheckpoint => {
                "the checkpoint belongs to other bake points or another light tree and is discarded; everything is \
                 baked again"
                    .into()
            }
            Self::Discarded => format!(
                "an unfinished bake of this output is discarded; bake with {} to resume it instead",
                name(Setting::Resume)
            ),
            Self::KeptFolder { path } => format!(
                "the folder of the checkpoint stays, because this is not part of a checkpoint; move it elsewhere ({})",
                path.display()
            ),
            Self::DeviceFailed { reason } => format!("the processor traces rays in place of {reason}"),
            Self::Coarsened { leaves, bound, asked, fitted } => format!(
                "the cuts over the {leaves} exceed a texture and were coarsened to a {} of {fitted:.2} instead of {asked}; \
                 lower {} to keep it",
                name(*bound),
                name(Setting::MaxVertices)
            ),
            Self::OpenViewpoint { viewpoint: Vec3 { x, y, z }, open } => format!(
                "{:.0} % of the directions around the viewpoint ({x:.2}, {y:.2}, {z:.2}) meet no surface, so most bounced \
                 light leaves the scene; if a closed space should be lit, choose a viewpoint inside it ({})",
                100.0 * open,
                name(Setting::Viewpoint)
            ),
            Self::EndlessBounces => {
                "the viewpoint lies in a closed space that reflects nearly all light, so light is missing after the last \
                 bounce; lower the base colors to 0.9 or less"
                    .into()
            }
            Self::PlainQuads { material } => format!(
                "wavelet transport reads no maps: light that material \"{material}\" bounces has the parameters without them; the last \
                 reflection to the eye has them"
            ),
            Self::Sources(warning) => warning.text(name),
            Self::Basis(warning) => warning.text(name),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Setting::name))
    }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
