//! Local lights in the terms of artists: kinds with their units, a color separate from the intensity, and new lights
//! that light the visible part of the scene.

use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    lights::{Emission, Light},
};
use serde::{Deserialize, Serialize};
use std::f32::consts::PI;

/// Largest and smallest angle of a cone in degrees, from its axis to its edge.
pub const CONE_DEGREES: [f32; 2] = [0.1, 90.0];
/// Least and greatest angle of a directional light in degrees, from rim to rim.
pub const ANGLE_DEGREES: [f32; 2] = [0.0, lapidary_core::lights::MOST_ANGLE_DEGREES];
/// Smallest and largest side of a rectangle in meters.
pub const SIDES: [f32; 2] = [1e-3, 1e3];
/// Largest intensity, in any unit.
pub const MOST_INTENSITY: f32 = 1e9;

/// How a light emits, without its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightKind {
    /// In all directions.
    Point,
    /// In a cone.
    Spot,
    /// Parallel light.
    Directional,
    /// From one side of a rectangle.
    Rectangle,
}

impl LightKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Point, Self::Spot, Self::Directional, Self::Rectangle];

    /// The kind of a light.
    pub fn of(light: &Light) -> Self {
        match light.emission {
            Emission::Point => Self::Point,
            Emission::Spot { .. } => Self::Spot,
            Emission::Directional { .. } => Self::Directional,
            Emission::Rectangle { .. } => Self::Rectangle,
        }
    }

    /// Displayed name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Point => "Point",
            Self::Spot => "Spot",
            Self::Directional => "Directional",
            Self::Rectangle => "Rectangle",
        }
    }

    /// Its description.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Point => "Shines in all directions, like a bare bulb.",
            Self::Spot => "Shines in a cone with a soft edge.",
            Self::Directional => "Parallel light from far away, like the sun.",
            Self::Rectangle => "A panel that emits soft light from its front.",
        }
    }

    /// Default emission of a light `distance` meters from its subject.
    pub fn emission(self, distance: f32) -> Emission {
        match self {
            Self::Point => Emission::Point,
            Self::Spot => Emission::Spot { cone_degrees: 35.0, penumbra_degrees: 8.0 },
            Self::Directional => Emission::PARALLEL,
            Self::Rectangle => {
                let side = short(0.4 * distance).clamp(SIDES[0], SIDES[1]);
                Emission::Rectangle { width: side, height: side }
            }
        }
    }

    /// The intensity at which white paper at `distance` meters has a radiance of about 1.
    fn intensity_for(self, distance: f32) -> f32 {
        let intensity = match self.emission(distance) {
            Emission::Point | Emission::Spot { .. } => PI * distance * distance,
            Emission::Directional { .. } => PI,
            Emission::Rectangle { width, height } => PI * distance * distance / (width * height),
        };
        short(intensity).clamp(1e-6, MOST_INTENSITY)
    }
}

/// Units of intensities. As in glTF files and other renderers, a candela is a watt per steradian and a lux a watt per square meter:
/// exposure, not the eye's efficacy, decides how bright a picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum IntensityUnit {
    /// Watts: radiant intensity, irradiance or radiance.
    #[default]
    Watts,
    /// Candela, lux or candela per square meter.
    Candela,
    /// All that the light sends; lux for parallel light.
    Lumens,
    /// Stops: each doubles it, and 0 is one candela.
    Stops,
}

impl IntensityUnit {
    /// All units, each with its name and meaning.
    pub const CHOICES: [(Self, &str, &str); 4] = [
        (Self::Watts, "Watts", "Radiant intensity, irradiance or radiance"),
        (Self::Candela, "Candela", "Candela, lux or candela per square meter, one for each watt, as in glTF"),
        (Self::Lumens, "Lumens", "All that the light sends; lux for parallel light"),
        (Self::Stops, "Stops (EV)", "Each stop doubles the light"),
    ];

    /// The unit for a light.
    pub fn label(self, light: &Light) -> &'static str {
        match (self, LightKind::of(light)) {
            (Self::Watts, LightKind::Point | LightKind::Spot) => "W/sr",
            (Self::Watts, LightKind::Directional) => "W/m²",
            (Self::Watts, LightKind::Rectangle) => "W/(m² sr)",
            (Self::Candela, LightKind::Point | LightKind::Spot) => "cd",
            (Self::Candela | Self::Lumens, LightKind::Directional) => "lx",
            (Self::Candela, LightKind::Rectangle) => "cd/m²",
            (Self::Lumens, _) => "lm",
            (Self::Stops, _) => "EV",
        }
    }

    /// An intensity of a light in this unit.
    pub fn of(self, intensity: f32, light: &Light) -> f32 {
        match self {
            Self::Watts | Self::Candela => intensity,
            Self::Lumens => intensity * sent(light),
            Self::Stops => intensity.log2(),
        }
    }

    /// The intensity from a number in this unit.
    pub fn intensity(self, number: f32, light: &Light) -> f32 {
        match self {
            Self::Watts | Self::Candela => number,
            Self::Lumens => number / sent(light),
            Self::Stops => number.exp2(),
        }
    }
}

/// Light that a light of intensity 1 sends: the solid angle of its rays, for panels with their area and the cosine. The soft edge of
/// a cone counts in full.
fn sent(light: &Light) -> f32 {
    match light.emission {
        Emission::Point => 4.0 * PI,
        Emission::Spot { cone_degrees, .. } => 2.0 * PI * (1.0 - cone_degrees.to_radians().cos()),
        Emission::Rectangle { width, height } => PI * width * height,
        Emission::Directional { .. } => 1.0,
    }
}

/// Rounded to two significant digits.
fn short(value: f32) -> f32 {
    let digits = format!("{value:.1e}");
    digits.parse().ok().filter(|v: &f32| v.is_finite()).unwrap_or(value)
}

/// A new light that lights the target of `camera` from `position`.
pub fn new_light(kind: LightKind, lights: &[Light], camera: &Camera, position: Vec3) -> Light {
    let distance = position.distance(camera.target).max(1e-3);
    let (position, target) = (position.to_array().map(short_meters), camera.target.to_array().map(short_meters));
    Light {
        name: free_name(lights, kind.label()),
        enabled: true,
        emission: kind.emission(distance),
        position: position.into(),
        target: target.into(),
        intensity: Vec3::splat(kind.intensity_for(distance)),
    }
}

fn short_meters(coordinate: f32) -> f32 {
    (1e4 * coordinate).round() / 1e4
}

/// `base` and the least unused number.
pub fn free_name(lights: &[Light], base: &str) -> String {
    let name = |number: usize| format!("{base} {number}");
    let taken = |name: &String| lights.iter().any(|light| light.name == *name);
    (1..).map(name).find(|name| !taken(name)).unwrap_or_default()
}

/// The name for a copy: the original's with another number.
pub fn copied_name(lights: &[Light], name: &str) -> String {
    let base = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
    free_name(lights, if base.is_empty() { "Light" } else { base })
}

/// The color of a light, whose brightest channel is 1, and its intensity in that channel. Without any light the color is
/// white.
pub fn color_and_intensity(intensity: Vec3) -> (Vec3, f32) {
    let brightest = intensity.max_element();
    if brightest > 0.0 { (intensity / brightest, brightest) } else { (Vec3::ONE, 0.0) }
}

/// A light of another kind in the same place, about as bright at its target.
pub fn with_kind(light: &Light, kind: LightKind) -> Light {
    let distance = light.position.distance(light.target).max(1e-3);
    let brighter = kind.intensity_for(distance) / LightKind::of(light).intensity_for(distance);
    let has_direction = light.forward().is_some();
    Light {
        emission: kind.emission(distance),
        target: if has_direction { light.target } else { light.position - Vec3::Y },
        intensity: (light.intensity * brighter).min(Vec3::splat(MOST_INTENSITY)),
        ..light.clone()
    }
}

/// Whether it adds anything to a picture.
pub fn shines(light: &Light) -> bool {
    light.shines() && light.validate().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn new(kind: LightKind) -> Light {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 40.0);
        new_light(kind, &[], &camera, Vec3::new(0.0, 2.0, 0.0))
    }

    #[test]
    fn new_lights_are_sound_and_light_the_target_alike() {
        for kind in LightKind::ALL {
            let light = new(kind);
            assert!(shines(&light), "{kind:?}");
            assert!(!shines(&Light { enabled: false, ..light.clone() }));
            let nowhere = Light { target: light.position, ..light.clone() };
            assert_eq!(shines(&nowhere), !light.emission.is_aimed(), "{kind:?}");
            assert_eq!((LightKind::of(&light), light.name.as_str()), (kind, format!("{} 1", kind.label()).as_str()));
            let area = match light.emission {
                Emission::Rectangle { width, height } => width * height,
                _ => 1.0,
            };
            let falloff = if kind == LightKind::Directional { 1.0 } else { 4.0 };
            let irradiance = light.intensity.x * area / falloff;
            assert!((irradiance / PI - 1.0).abs() < 0.06, "{kind:?}: {irradiance}");
        }
    }

    #[test]
    fn colour_and_intensity_come_apart_and_together() {
        let (color, intensity) = color_and_intensity(Vec3::new(2.0, 4.0, 1.0));
        assert_eq!((color, intensity), (Vec3::new(0.5, 1.0, 0.25), 4.0));
        assert_eq!(color_and_intensity(Vec3::ZERO), (Vec3::ONE, 0.0));
    }

    #[test]
    fn another_kind_is_as_bright_and_comes_back() {
        let point = Light { target: Vec3::ZERO, intensity: Vec3::new(2.0, 1.0, 0.5), ..new(LightKind::Point) };
        let panel = with_kind(&point, LightKind::Rectangle);
        let area = 0.8 * 0.8;
        assert!((panel.intensity.x * area / point.intensity.x - 1.0).abs() < 0.05, "{panel:?}");
        let back = with_kind(&panel, LightKind::Point);
        assert!(back.intensity.distance(point.intensity) < 1e-5 && back.emission == point.emission);
        let nowhere = Light { target: point.position, ..point };
        assert!(with_kind(&nowhere, LightKind::Spot).validate().is_ok());
    }

    #[test]
    fn intensities_go_to_all_units_and_back() {
        let point = Light { intensity: Vec3::splat(10.0), ..new(LightKind::Point) };
        assert!((IntensityUnit::Lumens.of(10.0, &point) - 125.66).abs() < 0.01, "4 pi steradians");
        let half = Emission::Spot { cone_degrees: 90.0, penumbra_degrees: 0.0 };
        assert!((IntensityUnit::Lumens.of(10.0, &Light { emission: half, ..point.clone() }) - 62.83).abs() < 0.01);
        let panel = Light { emission: Emission::Rectangle { width: 2.0, height: 0.5 }, ..point.clone() };
        assert!((IntensityUnit::Lumens.of(10.0, &panel) - 31.416).abs() < 0.01, "Lambert's law: pi times the area");
        assert_eq!((IntensityUnit::Stops.of(8.0, &point), IntensityUnit::Stops.intensity(-1.0, &point)), (3.0, 0.5));
        for (unit, ..) in IntensityUnit::CHOICES {
            for kind in LightKind::ALL {
                let light = new(kind);
                let back = unit.intensity(unit.of(3.5, &light), &light);
                assert!((back - 3.5).abs() < 1e-4 && !unit.label(&light).is_empty(), "{unit:?}, {kind:?}: {back}");
            }
        }
    }

    #[test]
    fn names_are_free() {
        let lights = [new(LightKind::Spot), Light { name: "Key".into(), ..new(LightKind::Point) }];
        assert_eq!(free_name(&lights, "Spot"), "Spot 2");
        assert_eq!(copied_name(&lights, "Spot 1"), "Spot 2");
        assert_eq!(copied_name(&lights, "Key"), "Key 1");
        assert_eq!(copied_name(&lights, "7"), "Light 1");
    }
}
