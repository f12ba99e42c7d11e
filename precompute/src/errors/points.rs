//! Why points cannot be placed on the surfaces of a scene.

use crate::setting::{Naming, Setting};
use glam::Vec3;
use std::fmt;
use thiserror::Error;

/// Least distance of the coarsest points of the meshless basis, as a share of the scene's diagonal: ten times as far as rays
/// start off a surface.
pub const LEAST_COARSE_RADIUS: f32 = 1e-4;

/// Why points cannot be placed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PointsError {
    /// Rays from the viewpoint meet nothing that is seen from its side.
    SeesNothing(Vec3),
    /// Most of what the viewpoint sees are backs of closed surfaces.
    InsideSolid(Vec3),
    /// The search found no place that sees a surface.
    NoViewpoint,
    /// Surfaces too small or too few for so many points.
    TooLittleSurface {
        /// Points asked for.
        wanted: usize,
    },
    /// Points so close that there would be no end of them.
    RadiusTooSmall {
        /// Asked for, in meters.
        radius: f32,
        /// Diagonal of the scene's bounds in meters.
        diagonal: f32,
    },
    /// The observer asked for it.
    Cancelled,
}

impl PointsError {
    /// In words, with settings called by `name`.
    pub fn text(&self, name: Naming) -> String {
        let viewpoint = name(Setting::Viewpoint);
        match self {
            Self::SeesNothing(Vec3 { x, y, z }) => {
                format!(
                    "no surface is seen from the viewpoint ({x}, {y}, {z}); give one inside the scene as {viewpoint}"
                )
            }
            Self::InsideSolid(Vec3 { x, y, z }) => {
                format!(
                    "the viewpoint ({x}, {y}, {z}) lies inside something solid; give one in the open as {viewpoint}"
                )
            }
            Self::NoViewpoint => format!(
                "no valid viewpoint: no place in the scene sees the front of a surface; check that the normals of the mesh \
                 point out of it, or give a place as {viewpoint}"
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
