//! Why points cannot be placed on the surfaces of a scene.

use glam::Vec3;
use thiserror::Error;

/// Least distance of the coarsest points of the meshless basis, as a share of the scene's diagonal: ten times as far as rays
/// start off a surface.
pub const LEAST_COARSE_RADIUS: f32 = 1e-4;

/// Why points cannot be placed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PointsError {
    /// Rays from the viewpoint meet nothing that is seen from its side.
    #[error(
        "no surface is seen from the viewpoint ({}, {}, {}); give one inside the scene with --viewpoint x,y,z",
        .0.x, .0.y, .0.z
    )]
    SeesNothing(Vec3),
    /// Most of what the viewpoint sees are backs of closed surfaces.
    #[error(
        "the viewpoint ({}, {}, {}) lies inside something solid; give one in the open with --viewpoint x,y,z",
        .0.x, .0.y, .0.z
    )]
    InsideSolid(Vec3),
    /// The search found no place that sees a surface.
    #[error(
        "no valid viewpoint: no place in the scene sees the front of a surface; check that the normals of the mesh point \
         out of it, or give a place with --viewpoint x,y,z"
    )]
    NoViewpoint,
    /// Surfaces too small or too few for so many points.
    #[error(
        "light reaches too little surface for {wanted} points; lower --sources, or check the scene for zero-area faces"
    )]
    TooLittleSurface {
        /// Points asked for.
        wanted: usize,
    },
    /// Points so close that there would be no end of them.
    #[error(
        "the coarsest points of the meshless basis would be {radius} m apart in a scene of {diagonal} m; give a \
         --coarse-radius of {} or more, or leave it out", LEAST_COARSE_RADIUS * diagonal
    )]
    RadiusTooSmall {
        /// Asked for, in metres.
        radius: f32,
        /// Diagonal of the scene's bounds in metres.
        diagonal: f32,
    },
    /// The observer asked for it.
    #[error("the placing of points was cancelled")]
    Cancelled,
}
