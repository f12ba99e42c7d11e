//! The settings of the environment.

use lapidary_core::{environment::SunSettings, texture::ColorSpace};
use lapidary_interchange::image::file_and_layer;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The environment: its map and orientation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnvironmentSettings {
    /// The path of a map, or a formula as `Environment::from_spec` reads it.
    pub spec: String,
    /// Color space of a map's file.
    pub color_space: ColorSpace,
    /// Turn in degrees, counter-clockwise seen from +Y.
    pub rotation_degrees: f32,
    /// Scales radiance; 0 or more.
    pub intensity: f32,
    /// Direction of the map's center.
    pub orientation: Orientation,
    /// Small bright parts of the map.
    pub sun: SunChoice,
}

/// Treatment of small bright parts of a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SunChoice {
    /// Whether they are suns; otherwise they stay in the light samples.
    pub enabled: bool,
    /// Luminance above which light belongs to a sun, over the mean of the map.
    pub threshold: f32,
    /// Largest angular diameter of a sun in degrees.
    pub largest_degrees: f32,
}

impl Default for SunChoice {
    fn default() -> Self {
        let SunSettings { threshold, largest_angle } = SunSettings::default();
        Self { enabled: true, threshold, largest_degrees: largest_angle.to_degrees() }
    }
}

/// Where the center of a map lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Orientation {
    /// +Z, as in OpenEXR, Mitsuba and MaterialX.
    #[default]
    OpenExr,
    /// +X, as in Blender and three.js.
    Blender,
}

impl Orientation {
    /// Degrees that are added to the rotation.
    pub fn yaw_degrees(self) -> f32 {
        match self {
            Self::OpenExr => 0.0,
            Self::Blender => 90.0,
        }
    }
}

impl Default for EnvironmentSettings {
    fn default() -> Self {
        Self {
            spec: "studio".into(),
            color_space: ColorSpace::Srgb,
            rotation_degrees: 0.0,
            intensity: 1.0,
            orientation: Orientation::default(),
            sun: SunChoice::default(),
        }
    }
}

impl EnvironmentSettings {
    /// The same settings with another map or formula. Another file says what its colors are; another layer of the same file has
    /// the same ones.
    pub fn with_map(&self, spec: &str) -> Self {
        let changed = Self { spec: spec.into(), ..self.clone() };
        let file = |of: &Self| of.file().map(|path| file_and_layer(path).0.to_owned());
        let is_same = file(self).is_some_and(|before| file(&changed) == Some(before));
        let color_space = if is_same { self.color_space } else { ColorSpace::Srgb };
        Self { color_space, ..changed }
    }

    /// The total rotation in radians.
    pub fn rotation(&self) -> f32 {
        (self.rotation_degrees + self.orientation.yaw_degrees()).to_radians()
    }

    /// Settings of suns, if enabled.
    pub fn suns(&self) -> Option<SunSettings> {
        let SunChoice { enabled, threshold, largest_degrees } = self.sun;
        enabled.then(|| SunSettings { threshold, largest_angle: largest_degrees.to_radians() })
    }

    /// The map's file; `None` for a formula.
    pub fn file(&self) -> Option<&Path> {
        let formula = self.spec.split_once(':').map_or(self.spec.as_str(), |(formula, _)| formula);
        (!["constant", "sun-sky", "studio", "orientation"].contains(&formula)).then(|| Path::new(&self.spec))
    }
}
