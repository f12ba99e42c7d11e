//! Errors of placing points on a scene's surfaces.

use crate::setting::{Naming, Setting};
use glam::Vec3;
use std::fmt;
use thiserror::Error;

/// Least distance of the coarsest meshless points, as a share of the scene's diagonal: ten times the offset of rays from a surface.
pub const LEAST_COARSE_RADIUS: f32 = 1e-4;

/// Why points cannot be placed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PointsError {
    /// Rays from the viewpoint hit nothing visible from its side.
    SeesNothing(Vec3),
    /// Most visible surfaces are backs of closed pieces.
    InsideSolid(Vec3),
    /// The search found no position that sees a surface.
    NoViewpoint,
    /// The surfaces are too small or too few for this many points.
    TooLittleSurface {
        /// Requested points.
        wanted: usize,
    },
    /// The radius would give too many points.
    RadiusTooSmall {
        /// Requested radius in meters.
        radius: f32,
        /// Diagonal of the scene's bounds in meters.
        diagonal: f32,
    },
    /// The observer cancelled it.
    Cancelled,
}

impl PointsError {
    /// The message, with settings named by `name`.
    pub fn text(&self, name: Naming) -> String {
        let viewpoint = name(Setting::Viewpoint);
        match self {
            Self::SeesNothing(Vec3 { x, y, z }) => {
                format!(
                    "no surface is seen from the viewpoint ({x}, {y}, {z}); choose one inside the scene ({viewpoint})"
                )
            }
            Self::InsideSolid(Vec3 { x, y, z }) => {
                format!(
                    "the viewpoint ({x}, {y}, {z}) lies inside something solid; choose one in the open ({viewpoint})"
                )
            }
            Self::NoViewpoint => format!(
                "no valid viewpoint: no place in the scene sees the front of a surface; check that the normals of the mesh \
                 point out of it, or choose a viewpoint ({viewpoint})"
            ),
            Self::TooLittleSurface { wanted } => format!(
                "light reaches too little surface for {wanted} points; lower {}, or check the scene for zero-area faces",
                name(Setting::Sources)
            ),
            Self::RadiusTooSmall { radius, diagonal } => format!(
                "the coarsest points of the meshless basis would be {radius} m apart in a scene of {diagonal} m; give a {} of \
                 {} or more, or leave it out",
                name(Setting::CoarseRadius),
                LEAST_COARSE_RADIUS * diagonal
            ),
            Self::Cancelled => "the placing of points was cancelled".into(),
        }
    }
}

impl fmt::Display for PointsError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text(Setting::name))
    }
}
