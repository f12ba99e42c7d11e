//! Checks of the values of lights.

use super::{Emission, Light};
use crate::bounds::{MOST_COORDINATE, is_within_reach};
use glam::Vec3;
use thiserror::Error;

/// Largest number of lights in a scene: every one may cast a shadow ray per pixel.
pub const MAX_LIGHTS: usize = 4096;

/// Largest intensity of a light, so that its irradiance fits `f32` at any distance.
pub const MOST_INTENSITY: f32 = 1e12;

/// Largest angular diameter of a directional light, in degrees.
pub const MOST_ANGLE_DEGREES: f32 = 90.0;

/// Smallest area of a light in m².
const LEAST_AREA: f32 = 1e-18;

/// Why a light is invalid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LightProblem {
    /// A value is NaN or infinite.
    #[error("its {what} is not a finite number; correct it")]
    NotFinite {
        /// Name of the value.
        what: &'static str,
    },
    /// A point is out of reach.
    #[error("its {what} {place} is farther from the origin than the limit of {MOST_COORDINATE} m; move it closer")]
    TooFar {
        /// Name of the point.
        what: &'static str,
        /// The point, in meters.
        place: Vec3,
    },
    /// The intensity is so large that sums of its light overflow.
    #[error("its intensity {0} is above the limit of {MOST_INTENSITY}; lower it")]
    TooBright(Vec3),
    /// The intensity is negative.
    #[error("its intensity {0} is negative; give numbers of 0 or more")]
    NegativeIntensity(Vec3),
    /// The light has no direction.
    #[error("its target is its position {0}; move one of them, so that it has a direction")]
    NoDirection(Vec3),
    /// The cone is out of range.
    #[error("its cone of {0} degrees is not above 0 and at most 90 (from the axis to the edge)")]
    Cone(f32),
    /// The penumbra is wider than the cone.
    #[error("its penumbra of {penumbra} degrees is not between 0 and its cone of {cone} degrees")]
    Penumbra {
        /// Penumbra in degrees.
        penumbra: f32,
        /// Cone in degrees.
        cone: f32,
    },
    /// The angular diameter is out of range.
    #[error("its angle of {0} degrees is not between 0 and {MOST_ANGLE_DEGREES} (from rim to rim)")]
    Angle(f32),
    /// The rectangle is larger than the limit.
    #[error(
        "its size of {width} x {height} m is above the limit of {MOST_COORDINATE} m; give a smaller width and height"
    )]
    TooLarge {
        /// Width in meters.
        width: f32,
        /// Height in meters.
        height: f32,
    },
    /// The rectangle has no area.
    #[error("its size of {width} x {height} m has no area; give a width and a height above 0")]
    NoArea {
        /// Width in meters.
        width: f32,
        /// Height in meters.
        height: f32,
    },
}

impl Light {
    /// Checks all values.
    ///
    /// # Errors
    /// The first problem found.
    pub fn validate(&self) -> Result<(), LightProblem> {
        self.check_finite()?;
        if self.intensity.min_element() < 0.0 {
            return Err(LightProblem::NegativeIntensity(self.intensity));
        }
        if self.intensity.max_element() > MOST_INTENSITY {
            return Err(LightProblem::TooBright(self.intensity));
        }
        if self.emission.is_aimed() && self.forward().is_none() {
            return Err(LightProblem::NoDirection(self.position));
        }
        self.check_emission()
    }

    fn check_finite(&self) -> Result<(), LightProblem> {
        let vectors = [("position", self.position), ("target", self.target), ("intensity", self.intensity)];
        if let Some((what, _)) = vectors.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(LightProblem::NotFinite { what });
        }
        match vectors[..2].iter().find(|(_, place)| !is_within_reach(*place)) {
            Some(&(what, place)) => Err(LightProblem::TooFar { what, place }),
            None => Ok(()),
        }
    }

    fn check_emission(&self) -> Result<(), LightProblem> {
        match self.emission {
            Emission::Spot { cone_degrees: cone, .. } if !(cone > 0.0 && cone <= 90.0) => Err(LightProblem::Cone(cone)),
            Emission::Spot { cone_degrees: cone, penumbra_degrees: penumbra } if !(0.0..=cone).contains(&penumbra) => {
                Err(LightProblem::Penumbra { penumbra, cone })
            }
            Emission::Directional { angle_degrees: angle } if !(0.0..=MOST_ANGLE_DEGREES).contains(&angle) => {
                Err(LightProblem::Angle(angle))
            }
            Emission::Rectangle { width, height } if width.max(height) > MOST_COORDINATE => {
                Err(LightProblem::TooLarge { width, height })
            }
            Emission::Rectangle { width, height } => {
                let usable = width > 0.0 && height > 0.0 && width * height >= LEAST_AREA;
                if usable { Ok(()) } else { Err(LightProblem::NoArea { width, height }) }
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_is_found_and_a_good_light_has_none() {
        let spot = |cone_degrees, penumbra_degrees| Emission::Spot { cone_degrees, penumbra_degrees };
        let with = |emission| Light { emission, position: Vec3::Y, ..Default::default() };
        let good = with(Emission::Point);
        for emission in [Emission::Point, spot(90.0, 90.0), spot(30.0, 0.0), Emission::PARALLEL] {
            assert_eq!(with(emission).validate(), Ok(()));
        }
        assert_eq!(Light { target: Vec3::Y, ..good.clone() }.validate(), Ok(()), "a point has no direction");
        let aimed = Light { target: Vec3::Y, ..with(Emission::PARALLEL) };
        assert_eq!(aimed.validate(), Err(LightProblem::NoDirection(Vec3::Y)));
        for emission in [spot(0.0, 0.0), spot(91.0, 0.0), spot(f32::NAN, 0.0)] {
            assert!(matches!(with(emission).validate(), Err(LightProblem::Cone(_))));
        }
        for emission in [spot(30.0, 31.0), spot(30.0, -1.0), spot(30.0, f32::NAN)] {
            assert!(matches!(with(emission).validate(), Err(LightProblem::Penumbra { .. })));
        }
        let rectangle = |(width, height)| with(Emission::Rectangle { width, height }).validate();
        for size in [(0.0, 1.0), (1.0, -1.0), (f32::NAN, 1.0), (1.0, f32::NAN), (1e-30, 1e-30)] {
            assert!(matches!(rectangle(size), Err(LightProblem::NoArea { .. })), "{size:?}");
        }
        for size in [(f32::INFINITY, 1.0), (1.1e9, 1e-9), (1.0, 1.1e9)] {
            assert!(matches!(rectangle(size), Err(LightProblem::TooLarge { .. })), "{size:?}");
        }
        let negative = Light { intensity: Vec3::new(1.0, -1.0, 0.0), ..good.clone() };
        assert!(matches!(negative.validate(), Err(LightProblem::NegativeIntensity(_))));
        let nowhere = Light { position: Vec3::splat(f32::NAN), ..good.clone() };
        assert_eq!(nowhere.validate(), Err(LightProblem::NotFinite { what: "position" }));
        let [near, far] = [1.0, 1.1].map(|part| Vec3::new(0.0, -part * MOST_COORDINATE, 0.0));
        assert_eq!(Light { position: near, ..good.clone() }.validate(), Ok(()));
        let far = Light { target: far, ..good.clone() }.validate();
        assert!(matches!(far, Err(LightProblem::TooFar { what: "target", .. })), "{far:?}");
        let of = |intensity| Light { intensity: Vec3::new(0.0, intensity, 0.0), ..good.clone() }.validate();
        assert_eq!(of(MOST_INTENSITY), Ok(()));
        assert!(matches!(of(1.1 * MOST_INTENSITY), Err(LightProblem::TooBright(_))));
    }
}
