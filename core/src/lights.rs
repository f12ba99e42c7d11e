//! Local lights: point, spot, directional and rectangular, and the file that holds them.
//!
//! A lights file is JSON: `{"lights": [{"kind": "spot", "position": [x, y, z], "target": [x, y, z], "intensity": [r, g, b],
//! "cone_degrees": 30, "penumbra_degrees": 5}, ...]}`.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// How a light emits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Emission {
    /// Into all directions; intensity in W/sr.
    #[default]
    Point,
    /// Into a cone around the direction to the target; intensity in W/sr on the axis.
    Spot {
        /// Angle between the axis and the edge, beyond which there is no light, in degrees.
        cone_degrees: f32,
        /// How far inside the edge the light begins to fall off, smoothly, in degrees.
        penumbra_degrees: f32,
    },
    /// Parallel light along the direction from position to target; intensity is irradiance in W/m² on a surface that
    /// faces it.
    Directional,
    /// A rectangle around the position that faces the target and emits on that side; intensity is its radiance in
    /// W/(m² sr).
    Rectangle {
        /// Metres along its horizontal edge.
        width: f32,
        /// Metres along the other.
        height: f32,
    },
}

/// A local light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// What it is called.
    #[serde(default)]
    pub name: String,
    /// Whether it shines.
    #[serde(default = "on")]
    pub enabled: bool,
    /// How it emits.
    #[serde(flatten)]
    pub emission: Emission,
    /// Where it is, in metres.
    pub position: Vec3,
    /// What it points at; points have no direction and may leave it out.
    #[serde(default)]
    pub target: Vec3,
    /// Per colour channel; the unit is that of [`Emission`].
    pub intensity: Vec3,
}

fn on() -> bool {
    true
}

/// What a lights file holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightsFile {
    /// The lights.
    pub lights: Vec<Light>,
}
