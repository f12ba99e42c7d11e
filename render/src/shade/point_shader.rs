//! Anything that shades surface points.

use crate::shade::surface::SurfacePoint;
use glam::Vec3;

/// Shades one surface point after another.
pub(crate) trait PointShader {
    /// Reflected radiance toward the eye.
    fn shade(&mut self, point: &SurfacePoint) -> Vec3;
}
