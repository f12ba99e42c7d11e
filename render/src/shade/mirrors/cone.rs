//! The part of a picture that a ray of a mirror stands for, as a cone (Akenine-Möller et al. 2021, *Improved Shader and Texture Level
//! of Detail Using Ray Cones*).
//!
//! Curved mirrors spread the rays of neighboring samples: a small sun in a mirror in a mirror would be a dot in one of many samples.
//! What a mirror shows reflects the map and lamps blurred by the cone. Twin of `shaders/cone.wgsl`.

use crate::{shade::surface::SurfacePoint, view::View};
use glam::Vec3;
use lapidary_core::scene::Mesh;

/// Cones of a picture's camera rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraCones {
    eye: Vec3,
    /// Angle between neighboring samples in radians.
    spread: f32,
    /// Share of a lobe for which the ray of a sample stands.
    of_lobe: f32,
}

impl CameraCones {
    pub fn of(view: &View) -> Self {
        let (projection, samples) = (view.projection(), view.aa.max(1) as f32);
        Self { eye: projection.eye, spread: projection.pixel_span(1.0) / samples.sqrt(), of_lobe: samples.recip() }
    }

    /// The cone of the ray to a position.
    pub fn to(&self, position: Vec3) -> RayCone {
        let Self { eye, spread, of_lobe } = *self;
        RayCone { width: spread * eye.distance(position), spread, of_lobe }
    }
}

/// A cone where its ray ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayCone {
    /// In meters.
    width: f32,
    /// Growth of the width per meter; negative behind a mirror that gathers light.
    spread: f32,
    of_lobe: f32,
}

/// Twice the variance of evenly spread numbers is the square of their range divided by this.
const OF_EVEN: f32 = 6.0;
/// Most that a cone adds to a lobe: that of alpha 0.5.
const WIDEST_CONE: f32 = 0.25;

/// A test compares the shader's copies with these.
#[cfg(test)]
pub(crate) const CONSTANTS: [(&str, f32); 2] = [("OF_EVEN", OF_EVEN), ("WIDEST_CONE", WIDEST_CONE)];

impl RayCone {
    /// How far the half vector of one light turns from the normal across the cone, as a slope: half the spread of the rays, and the turn
    /// of the normals below them.
    fn slope(self, curvature: f32) -> f32 {
        0.5 * self.spread + curvature * self.width
    }

    #[cfg(test)]
    pub fn width(self) -> f32 {
        self.width
    }

    /// Twice the variance of these slopes, as in [`SurfacePoint::slopes`], as far as a lobe can show it.
    pub fn slopes(self, curvature: f32) -> f32 {
        let slope = self.slope(curvature);
        (slope * slope / OF_EVEN).min(WIDEST_CONE)
    }

    /// The cone of a ray that a mirror with a lobe of this width reflects, when it has gone so many meters.
    pub fn mirrored(self, curvature: f32, lobe: f32, distance: f32) -> Self {
        let spread = 2.0 * self.slope(curvature);
        let spread = spread + (2.0 * lobe * (OF_EVEN * self.of_lobe).sqrt()).copysign(spread);
        // Behind a focus the rays are apart again.
        let width = self.width + spread * distance;
        Self { width: width.abs(), spread: spread * width.signum(), ..self }
    }
}

/// Mean curvature of the shading normals along the edges of a point's triangle, per meter: positive where they spread.
pub(crate) fn curvature(mesh: &Mesh, point: &SurfacePoint) -> f32 {
    let (mut bends, mut squares) = (0.0, f32::MIN_POSITIVE);
    for [a, b] in [[0, 1], [1, 2], [2, 0]] {
        let edge = point.corners[b] - point.corners[a];
        let bent = mesh.normals[point.vertices[b] as usize] - mesh.normals[point.vertices[a] as usize];
        bends += bent.dot(edge);
        squares += edge.length_squared();
    }
    if point.from_behind { -bends / squares } else { bends / squares }
}
