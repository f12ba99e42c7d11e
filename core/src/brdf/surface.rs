//! Emission and opacity, common to materials of all models.

use super::{Parameter, Values, parameter::parameters};
use glam::Vec3;

parameters! {
    /// Parameters of a surface beside its reflectance, named as in OpenPBR.
    pub struct SurfaceParameters {
        emission_luminance: f32 = Parameter::number(
            "Emission luminance", [0.0, 1e6], 0.0,
            "Brightness of the emitted light, in the unit of the environment. With bounces it lights other surfaces.",
        ).with_slider([0.0, 20.0]).in_section("Emission"),
        emission_color: Vec3 = Parameter::color("Emission color", [1.0; 3], "Color of the emitted light.")
            .in_section("Emission"),
        geometry_opacity: f32 = Parameter::number(
            "Opacity", [0.0, 1.0], 1.0,
            "Share of light that the surface stops; the rest passes straight on. Baked shadows follow with the next bake.",
        ).in_section("Transparency"),
        opacity_cutoff: f32 = Parameter::number(
            "Cutoff", [0.0, 1.0], 0.0,
            "Above zero: points below this opacity are holes, and all others stop all light.",
        ).in_section("Transparency"),
    }
}

impl SurfaceParameters {
    /// Count of their numbers.
    pub(super) const NUMBERS: usize = {
        let (mut sum, mut i) = (0, 0);
        while i < Self::LIST.len() {
            sum += Self::LIST[i].numbers();
            i += 1;
        }
        sum
    };

    /// Takes the last values of a material.
    #[inline]
    pub fn of(values: &Values) -> Self {
        Self::new(&values.last(Self::NUMBERS))
    }

    /// Radiance emitted in all directions, in W/(m² sr).
    #[inline]
    pub fn emission(&self) -> Vec3 {
        self.emission_color * self.emission_luminance
    }
}

/// A model's own parameters followed by the surface parameters, `N` in all.
pub(super) const fn with_surface<const N: usize>(own: &[Parameter]) -> [Parameter; N] {
    let mut all = [SurfaceParameters::LIST[0]; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < own.len() { own[i] } else { SurfaceParameters::LIST[i - own.len()] };
        i += 1;
    }
    all
}
