//! Distant light: a latitude-longitude map of radiance, from a file or a formula.
//!
//! The center of the map is +Z, its left quarter +X, its top +Y: `u = 1/2 - atan2(x, z) / 2π`, `v = acos(y) / π`.

use crate::{image::Image, texture::Texels};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

mod blur;
mod procedural;
mod pyramid;
mod sun;

pub use procedural::{constant, orientation, studio, sun_and_sky};
pub use pyramid::Pyramid;
pub use sun::{MOST_SUNS, Sun, SunSettings, Suns};

/// Largest radiance of an environment: ten thousand times the sun's, and sums of it still fit `f32`.
pub const MOST_RADIANCE: f32 = 1e12;
/// Largest factor on an environment's radiance.
pub const MOST_INTENSITY: f32 = 1e6;

/// Light from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Name of the file, or the specification of the formula.
    pub name: String,
    /// Latitude-longitude radiance, of any size; 0 to [`MOST_RADIANCE`].
    pub map: Image,
    known: sun::MapCache,
}

impl Environment {
    /// An environment with a name.
    pub fn new(name: String, map: Image) -> Self {
        Self { name, map, known: sun::MapCache::default() }
    }

    /// The suns of the map and the rest of it. They are searched on the first call, and again for other settings.
    pub fn suns(&self, settings: SunSettings) -> Arc<Suns> {
        self.known.suns(self, settings)
    }

    /// Unoccluded irradiance in W/m² per channel on a surface that faces up. Independent of the map's rotation.
    pub fn irradiance_from_above(&self) -> Vec3 {
        *self.known.from_above.get_or_init(|| self.sum_from_above())
    }

    fn sum_from_above(&self) -> Vec3 {
        let [width, height] = self.map.size;
        // The integral of the cosine over a row's latitudes above the horizon.
        let weight = |row: u32| {
            let [top, bottom] =
                [row, row + 1].map(|edge| (PI * edge as f32 / height as f32).min(PI / 2.0).sin().powi(2));
            0.5 * (bottom - top) * TAU / width as f32
        };
        let rows = self.map.pixels.par_chunks(width.max(1) as usize).enumerate();
        rows.map(|(row, texels)| texels.iter().sum::<Vec3>() * weight(row as u32)).sum()
    }

    /// An environment from a file's map. Also returns the repairs, in sentences.
    pub fn repaired(name: String, mut map: Image) -> (Self, Vec<String>) {
        let mut warnings = Vec::new();
        repair(&mut map, &mut warnings);
        (Self::new(name, map), warnings)
    }

    /// Radiance from a unit direction, bilinear between texels; wraps in longitude.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        bilinear(&self.map, uv_from_direction(direction))
    }

    /// The map at decreasing resolutions. Built on the first call.
    pub fn pyramid(&self) -> Arc<Pyramid> {
        self.known.pyramid.get_or_init(|| Pyramid::new(&self.map).into()).clone()
    }
}

/// The value of a latitude-longitude map, bilinear between texels; wraps in longitude.
fn bilinear(map: &Image, uv: Vec2) -> Vec3 {
    let (w, h) = (map.width() as i64, map.height() as i64);
    let p = uv * Vec2::new(w as f32, h as f32) - 0.5;
    let (base, f) = (p.floor(), p - p.floor());
    let texel = |x: i64, y: i64| map.at(x.rem_euclid(w) as usize, y.clamp(0, h - 1) as usize);
    let (x, y) = (base.x as i64, base.y as i64);
    let top = texel(x, y).lerp(texel(x + 1, y), f.x);
    let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), f.x);
    top.lerp(bottom, f.y)
}

/// What infinite radiance becomes: at least the largest 16-bit float, of which it is the overflow, and never less than
/// the brightest texel, so that an infinite sun stays the sun.
fn stand_in_for_infinity(map: &Image) -> f32 {
    let components = map.pixels.iter().flat_map(|texel| texel.to_array());
    components.filter(|x| x.is_finite()).fold(Texels::MOST, f32::max)
}

/// Replaces invalid radiance, and reports it.
fn repair(map: &mut Image, warnings: &mut Vec<String>) {
    let brightest = stand_in_for_infinity(map);
    let (mut invalid, mut infinite, mut negative, mut too_bright) = (0, 0, 0, 0);
    for texel in &mut map.pixels {
        if texel.is_nan() {
            invalid += 1;
            *texel = Vec3::ZERO;
        }
        if texel.max_element() == f32::INFINITY {
            infinite += 1;
            *texel = texel.min(Vec3::splat(brightest));
        }
        if texel.min_element() < 0.0 {
            negative += 1;
            *texel = texel.max(Vec3::ZERO);
        }
        if texel.max_element() > MOST_RADIANCE {
            too_bright += 1;
            *texel = texel.min(Vec3::splat(MOST_RADIANCE));
        }
    }
    if invalid > 0 {
        warnings.push(format!(
            "{invalid} texels of the environment were not numbers and became black; save the map without empty pixels"
        ));
    }
    if infinite > 0 {
        let limit = brightest.min(MOST_RADIANCE);
        warnings.push(format!(
            "{infinite} texels of the environment were infinite and became {limit}; save the map as 32-bit floats, or \
             with less exposure"
        ));
    }
    if negative > 0 {
        warnings.push(format!(
            "{negative} texels of the environment were negative and were raised to zero; they may be colors that Rec. 709 \
             cannot show"
        ));
    }
    if too_bright > 0 {
        warnings.push(format!(
            "{too_bright} texels of the environment were brighter than {MOST_RADIANCE} and were lowered to it; save the map \
             with less exposure"
        ));
    }
    if map.pixels.iter().all(|p| *p == Vec3::ZERO) {
        warnings.push("the environment is black and gives no light; choose another map".into());
    }
    let [width, height] = map.size;
    if width != 2 * height {
        warnings.push(format!(
            "the environment is {width} x {height} and shows distorted; a latitude-longitude map is twice as wide as high"
        ));
    }
}

/// Position of a unit direction in a map: (0, 0) is the top left corner.
pub fn uv_from_direction(direction: Vec3) -> Vec2 {
    let u = 0.5 - direction.x.atan2(direction.z) / TAU;
    Vec2::new(u, direction.y.clamp(-1.0, 1.0).acos() / PI)
}

/// The unit direction at a position in a map.
pub fn direction_from_uv(uv: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = ((0.5 - uv.x) * TAU).sin_cos();
    let (sin_theta, cos_theta) = (uv.y * PI).sin_cos();
    Vec3::new(sin_theta * sin_phi, cos_theta, sin_theta * cos_phi)
}

/// The direction of the center of a texel of a map of `size`.
pub fn texel_direction(x: u32, y: u32, size: [u32; 2]) -> Vec3 {
    direction_from_uv(Vec2::new((x as f32 + 0.5) / size[0] as f32, (y as f32 + 0.5) / size[1] as f32))
}

/// Solid angle in steradians of each texel in a row of a map of `size`.
pub fn texel_solid_angle(row: u32, size: [u32; 2]) -> f32 {
    let step = std::f64::consts::PI / f64::from(size[1]);
    let top = f64::from(row) * step;
    // cos a - cos b as a product, which keeps its digits near the poles.
    let cosines = 2.0 * (top + 0.5 * step).sin() * (0.5 * step).sin();
    (std::f64::consts::TAU / f64::from(size[0]) * cosines) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn irradiance_from_above_is_that_of_the_upper_half() {
        for size in [[64, 32], [10, 7], [1, 1]] {
            let all = Environment::new("white".into(), Image::filled(size, Vec3::ONE)).irradiance_from_above();
            assert!((all - PI).abs().max_element() < 1e-4, "{size:?}: {all}");
        }
        let half = |of: fn(u32) -> bool| {
            let map = Image::from_fn([64, 32], |_, y| Vec3::splat(f32::from(of(y))));
            Environment::new("half".into(), map).irradiance_from_above().x
        };
        assert!((half(|y| y < 16) - PI).abs() < 1e-4 && half(|y| y >= 16).abs() < 1e-6);
        // Within an angle of the zenith, the integral is the squared sine of that angle.
        assert!((half(|y| y < 11) - PI * (PI * 11.0 / 32.0).sin().powi(2)).abs() < 1e-4);
    }

    #[test]
    fn directions_and_maps_agree_on_the_convention() {
        for (uv, direction) in [
            (Vec2::new(0.5, 0.5), Vec3::Z),
            (Vec2::new(0.25, 0.5), Vec3::X),
            (Vec2::new(0.75, 0.5), Vec3::NEG_X),
            (Vec2::new(0.3, 0.0), Vec3::Y),
        ] {
            assert!((direction_from_uv(uv) - direction).length() < 1e-6);
        }
        for i in 0..500 {
            let direction = texel_direction(i * 7 % 64, i % 32, [64, 32]);
            assert!((direction_from_uv(uv_from_direction(direction)) - direction).length() < 1e-5);
        }
    }

    #[test]
    fn solid_angles_add_up_to_the_sphere() {
        for size in [[1, 1], [7, 3], [1024, 512]] {
            let sum: f64 = (0..size[1]).map(|row| f64::from(size[0]) * f64::from(texel_solid_angle(row, size))).sum();
            assert!((sum - 4.0 * std::f64::consts::PI).abs() < 1e-5, "{size:?}: {sum}");
        }
    }

    #[test]
    fn lookup_is_exact_at_texel_centres_and_continuous_across_the_seam() {
        let map = Image::from_fn([8, 4], |x, y| Vec3::new(x as f32, y as f32, 1.0));
        let environment = Environment::new("test".into(), map);
        assert!((environment.radiance(texel_direction(5, 2, [8, 4])) - Vec3::new(5.0, 2.0, 1.0)).length() < 1e-4);
        let seam = |x: f32| environment.radiance(Vec3::new(x, 0.0, -1.0).normalize());
        assert!((seam(1e-5) - seam(-1e-5)).length() < 1e-3);
        assert!((seam(0.0).x - 3.5).abs() < 1e-3); // the mean of the first and the last column
    }

    #[test]
    fn an_infinite_sun_stays_the_brightest_place() {
        for rest in [0.5, 2.0 * Texels::MOST] {
            let mut map = Image::filled([64, 32], Vec3::splat(0.5));
            map.pixels[64 * 10 + 20] = Vec3::INFINITY;
            map.pixels[7] = Vec3::splat(rest);
            let (environment, warnings) = Environment::repaired("sun".into(), map);
            let sun = environment.map.at(20, 10);
            assert_eq!(sun, Vec3::splat(rest.max(Texels::MOST)));
            assert!(environment.map.pixels.iter().all(|texel| texel.max_element() <= sun.x));
            assert!(warnings.len() == 1 && warnings[0].contains("infinite"), "{warnings:?}");
            // The sun lights the ground: its solid angle times the cosine to the zenith, beside the sky.
            let zenith = texel_direction(20, 10, [64, 32]).y;
            let light = sun.x * texel_solid_angle(10, [64, 32]) * zenith;
            assert!(environment.irradiance_from_above().x > 0.95 * light);
        }
        let dark = Environment::repaired("nan".into(), Image::filled([64, 32], Vec3::NAN)).0;
        assert!(dark.map.pixels.iter().all(|texel| *texel == Vec3::ZERO), "negative control: no number is no light");
    }

    #[test]
    fn negative_and_invalid_texels_are_repaired_counted_and_reported() {
        let mut map = Image::filled([8, 4], Vec3::ONE);
        map.pixels[3] = Vec3::new(-1.0, 2.0, 0.5);
        map.pixels[4] = Vec3::new(f32::NAN, 1.0, 1.0);
        map.pixels[9] = Vec3::new(1.0, f32::INFINITY, 1.0);
        let (environment, warnings) = Environment::repaired("bad".into(), map);
        assert_eq!(environment.map.pixels[3], Vec3::new(0.0, 2.0, 0.5));
        assert_eq!(environment.map.pixels[4], Vec3::ZERO);
        assert_eq!(environment.map.pixels[9], Vec3::new(1.0, Texels::MOST, 1.0));
        assert_eq!(warnings.len(), 3, "{warnings:?}");
        assert!(warnings.iter().all(|warning| warning.starts_with("1 texels")), "{warnings:?}");
        let mut map = Image::filled([8, 4], Vec3::splat(MOST_RADIANCE));
        map.pixels[5] = Vec3::new(3e38, 1.0, 2.0 * MOST_RADIANCE);
        let (environment, warnings) = Environment::repaired("glaring".into(), map);
        assert_eq!(environment.map.pixels[5], Vec3::new(MOST_RADIANCE, 1.0, MOST_RADIANCE));
        assert!(warnings.len() == 1 && warnings[0].starts_with("1 texels of the environment were brighter"));
        assert!(Environment::repaired("good".into(), Image::filled([8, 4], Vec3::ONE)).1.is_empty());
    }
}
