//! Local lights: point, spot, directional and rectangular, their radiometry, and the file that holds them.
//!
//! A lights file is JSON: `{"lights": [{"kind": "spot", "position": [x, y, z], "target": [x, y, z], "intensity": [r, g, b],
//! "cone_degrees": 30, "penumbra_degrees": 5}, ...]}`.
//!
//! A directional light may have an extent, like the sun.
//!
//! Lights are not geometry: cameras and gathering rays do not see them. Only their illumination shows.

mod check;
mod disc;
mod file;
mod rectangle;
mod sample;

pub use check::{LightProblem, MAX_LIGHTS, MOST_ANGLE_DEGREES, MOST_INTENSITY};
pub use disc::Disc;
pub use file::LightsError;
pub use rectangle::RectangleShape;
pub use sample::{LightHit, LightSample, LightSampler};

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Emission of a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Emission {
    /// In all directions; intensity in W/sr.
    #[default]
    Point,
    /// In a cone around the direction to the target; intensity in W/sr on the axis.
    Spot {
        /// Angle between the axis and the edge of the cone, in degrees.
        cone_degrees: f32,
        /// Width in degrees, inside the edge, of the smooth falloff.
        #[serde(default)]
        penumbra_degrees: f32,
    },
    /// From infinitely far along the direction from position to target. Intensity is irradiance in W/m² on a surface
    /// that faces it.
    Directional {
        /// Angular diameter in degrees: 0 for parallel light, 0.53 for the sun.
        #[serde(default)]
        angle_degrees: f32,
    },
    /// From a rectangle around the position that faces the target and emits on that side; intensity is its radiance in W/(m² sr).
    Rectangle {
        /// Length of its horizontal edge in meters.
        width: f32,
        /// Length of its other edge in meters.
        height: f32,
    },
}

impl Emission {
    /// Parallel light.
    pub const PARALLEL: Self = Self::Directional { angle_degrees: 0.0 };

    /// Whether it points at a target.
    pub fn is_aimed(&self) -> bool {
        !matches!(self, Self::Point)
    }
}

/// A local light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// Its name.
    #[serde(default)]
    pub name: String,
    /// Whether it is switched on.
    #[serde(default = "on")]
    pub enabled: bool,
    /// Its emission.
    #[serde(flatten)]
    pub emission: Emission,
    /// Position in meters.
    pub position: Vec3,
    /// Its target; point lights may omit it.
    #[serde(default)]
    pub target: Vec3,
    /// Intensity per color channel, in the unit of [`Emission`].
    pub intensity: Vec3,
}

fn on() -> bool {
    true
}

impl Default for Light {
    /// A point light of unit intensity at the origin, switched on.
    fn default() -> Self {
        Self {
            name: String::new(),
            enabled: true,
            emission: Emission::Point,
            position: Vec3::ZERO,
            target: Vec3::ZERO,
            intensity: Vec3::ONE,
        }
    }
}

impl Light {
    /// Unit direction from position to target; `None` if they coincide.
    pub fn forward(&self) -> Option<Vec3> {
        (self.target - self.position).try_normalize()
    }

    /// Whether it shines up from infinitely far below, so that a ground blocks all of its light.
    pub fn comes_from_below(&self) -> bool {
        matches!(self.emission, Emission::Directional { .. }) && self.forward().is_some_and(|forward| forward.y > 0.0)
    }

    /// Whether it emits any light.
    pub fn shines(&self) -> bool {
        self.enabled && self.intensity.max_element() > 0.0
    }

    /// Whether all its light at a point comes from one direction, so that one sample is exact.
    pub fn is_delta(&self) -> bool {
        match self.emission {
            Emission::Point | Emission::Spot { .. } => true,
            Emission::Directional { angle_degrees } => angle_degrees == 0.0,
            Emission::Rectangle { .. } => false,
        }
    }

    /// Number of samples for a picture without visible noise: one if that is exact, more for lights with an extent.
    pub fn samples_wanted(&self) -> u32 {
        if self.is_delta() { 1 } else { 16 }
    }
}

/// Contents of a lights file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightsFile {
    /// The lights.
    pub lights: Vec<Light>,
}
