//! A clear sky after Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight" (1999), with a sun.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Vec3, vec3};
use lapidary_core::color::luminance;

use crate::environment::Environment;
use crate::noise::smoothstep;

/// Haziness of the air; 2 is very clear, 10 is haze.
const TURBIDITY: f32 = 3.0;
/// Direction of the sun: left of the stage, 37 degrees high, so that shadows cross the picture.
const TOWARDS_SUN: Vec3 = vec3(-0.78, 0.60, 0.14);
/// Radius of the disc, degrees. The real sun has 0.27, too small for a map of this size.
const SUN_RADIUS: f32 = 1.5;
/// Illuminance of a surface facing the sun, relative to a horizontal one under the sky alone. Clear days at this height
/// of the sun have 80 to 90 klx and 13 to 15 klx.
const SUN_TO_SKY: f32 = 6.0;
/// Color of the direct light at this height, luminance 1.
const SUN_COLOR: Vec3 = vec3(1.160, 0.985, 0.715);
/// Albedo of the ground.
const GROUND: Vec3 = vec3(0.23, 0.205, 0.17);

/// The sun-and-sky map.
pub fn sun_and_sky() -> Environment {
    let sun = TOWARDS_SUN.normalize();
    let sky = Sky::new(sun);
    let only_sky = Environment::paint(|d| if d.y > 0.0 { sky.radiance(d) } else { Vec3::ZERO });
    let from_sky = only_sky.irradiance_from_above();
    let from_sun = SUN_COLOR * (SUN_TO_SKY * luminance(from_sky));
    let ground = GROUND * (from_sky + from_sun * sun.y) / PI;
    let mut map = Environment::paint(|d| {
        // The first degrees below the horizon fade into haze.
        let horizon = sky.radiance(vec3(d.x, d.y.max(0.004), d.z).normalize());
        horizon.lerp(ground, smoothstep(0.0, 0.06, -d.y))
    });
    map.add_disc(sun, SUN_RADIUS.to_radians(), from_sun);
    map.scaled_to_mean(0.9)
}

/// Perez coefficients of luminance `Y` and of the chromaticities `x` and `y`.
struct Sky {
    sun: Vec3,
    coefficients: [[f32; 5]; 3],
    /// Zenith values over the function's value there.
    scale: [f32; 3],
}

impl Sky {
    fn new(sun: Vec3) -> Sky {
        let t = TURBIDITY;
        let coefficients = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let from_zenith = sun.y.acos();
        let zenith = zenith(from_zenith);
        let scale = [0, 1, 2].map(|k| zenith[k] / perez(&coefficients[k], 1.0, from_zenith));
        Sky { sun, coefficients, scale }
    }

    fn radiance(&self, d: Vec3) -> Vec3 {
        let from_sun = d.dot(self.sun).clamp(-1.0, 1.0).acos();
        let [luminance, x, y] =
            [0, 1, 2].map(|k| self.scale[k] * perez(&self.coefficients[k], d.y.max(0.01), from_sun));
        rec709(luminance, x, y)
    }
}

/// The function F of Perez et al., with the cosine from the zenith and the angle from the sun.
fn perez([a, b, c, d, e]: &[f32; 5], cos_zenith: f32, from_sun: f32) -> f32 {
    let cos_sun = from_sun.cos();
    (1.0 + a * (b / cos_zenith).exp()) * (1.0 + c * (d * from_sun).exp() + e * cos_sun * cos_sun)
}

/// Luminance (kcd/m^2) and chromaticities at the zenith.
fn zenith(from_zenith: f32) -> [f32; 3] {
    let t = TURBIDITY;
    let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * from_zenith);
    debug_assert!(chi < FRAC_PI_2);
    let luminance = (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
    let cubic = |[a, b, c, d]: [f32; 4]| ((a * from_zenith + b) * from_zenith + c) * from_zenith + d;
    let chromaticity = |rows: [[f32; 4]; 3]| (cubic(rows[0]) * t + cubic(rows[1])) * t + cubic(rows[2]);
    let x = chromaticity([
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ]);
    let y = chromaticity([
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ]);
    [luminance, x, y]
}

/// CIE xyY to linear Rec. 709, without negative components.
fn rec709(luminance: f32, x: f32, y: f32) -> Vec3 {
    let xyz = vec3(x / y, 1.0, (1.0 - x - y) / y) * luminance;
    let r = xyz.dot(vec3(3.240_454, -1.537_139, -0.498_531));
    let g = xyz.dot(vec3(-0.969_266, 1.876_011, 0.041_556));
    let b = xyz.dot(vec3(0.055_643, -0.204_026, 1.057_225));
    vec3(r, g, b).max(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_has_its_share() {
        let map = sun_and_sky();
        let peak = map.texels.iter().map(|t| luminance(*t)).fold(0.0, f32::max);
        let mean = luminance(map.mean());
        assert!((mean - 0.9).abs() < 1e-3);
        assert!((500.0..20_000.0).contains(&peak), "{peak}");
        assert!(map.texels.iter().all(|t| t.is_finite() && t.min_element() >= 0.0));
    }

    #[test]
    fn the_sky_is_blue_opposite_the_sun() {
        let sky = Sky::new(TOWARDS_SUN.normalize());
        let away = sky.radiance(vec3(0.6, 0.7, 0.2).normalize());
        assert!(away.z > 1.3 * away.x, "{away}");
    }
}
