//! Suns: parts of a map that are far brighter than the rest and smaller than the spacing of light samples. As
//! directional lights they have sharp shadows, unlike samples. The rest of the map is sampled.
//!
//! Light above a threshold goes to the sun, and the map is clipped there, as Blender does with the sun of a world. A
//! sun has the size of a disc with the same spread of light. All light removed from the map is in its sun.

use super::{Environment, Pyramid, texel_direction, texel_solid_angle};
use crate::{color::luminance, image::Image, sphere::SPHERE};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashSet;
use std::{
    f64::consts::{FRAC_PI_2, TAU},
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

/// Largest number of suns of a map: each costs rays in every pixel.
pub const MOST_SUNS: usize = 4;

/// Smallest share of a map's light that makes a sun.
const LEAST_SHARE: f64 = 0.01;

/// Definition of a sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSettings {
    /// Luminance above which light belongs to a sun, relative to the mean of the map; 1 or more.
    pub threshold: f32,
    /// Largest angular diameter of a sun in radians; larger lights stay in the map.
    pub largest_angle: f32,
}

impl Default for SunSettings {
    /// 30 times the mean, and eight degrees: twelve samples across of 32,768.
    fn default() -> Self {
        Self { threshold: 30.0, largest_angle: 8.0_f32.to_radians() }
    }
}

/// A small bright part of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction toward it, in the frame of the map.
    pub direction: Vec3,
    /// Angular diameter in radians.
    pub angle: f32,
    /// Irradiance in W/m² on a surface that faces it.
    pub irradiance: Vec3,
}

/// The suns of a map and the rest of it.
#[derive(Clone, Debug)]
pub struct Suns {
    /// At most [`MOST_SUNS`], brightest first.
    pub suns: Vec<Sun>,
    /// The map without them; `None` if there are none.
    pub rest: Option<Arc<Environment>>,
}

impl Suns {
    /// Finds the suns of a map.
    pub fn of(environment: &Environment, settings: SunSettings) -> Self {
        let map = Weighted::new(&environment.map);
        let level = map.mean * f64::from(settings.threshold);
        let mut spots: Vec<Spot> = map.spots(level).into_iter().map(|texels| map.spot(texels, level)).collect();
        let is_sun = |spot: &Spot| spot.share >= LEAST_SHARE && spot.sun.angle <= settings.largest_angle;
        spots.retain(is_sun);
        spots.sort_by(|a, b| b.share.total_cmp(&a.share));
        spots.truncate(MOST_SUNS);
        if spots.is_empty() {
            return Self { suns: Vec::new(), rest: None };
        }
        let mut rest = environment.map.clone();
        for texel in spots.iter().flat_map(|spot| &spot.texels) {
            let (index, kept) = (*texel as usize, map.kept(*texel, level));
            rest.pixels[index] *= kept;
        }
        let rest = Some(Environment::new(environment.name.clone(), rest).into());
        Self { suns: spots.into_iter().map(|spot| spot.sun).collect(), rest }
    }
}

/// A map with the solid angles of its texels.
struct Weighted<'a> {
    map: &'a Image,
    /// Solid angle of a texel in each row, in steradians.
    solid_angles: Vec<f64>,
    /// Sum of luminance times solid angle.
    flux: f64,
    /// Mean luminance over the sphere.
    mean: f64,
}

/// Adjacent texels brighter than the threshold.
struct Spot {
    texels: Vec<u32>,
    sun: Sun,
    /// Share of the map's light.
    share: f64,
}

impl<'a> Weighted<'a> {
    fn new(map: &'a Image) -> Self {
        let solid_angles: Vec<f64> = (0..map.size[1]).map(|row| f64::from(texel_solid_angle(row, map.size))).collect();
        let of_row = |(row, solid_angle): (&[Vec3], &f64)| {
            solid_angle * row.iter().map(|&texel| f64::from(luminance(texel))).sum::<f64>()
        };
        let flux: f64 = map.pixels.chunks(map.width().max(1)).zip(&solid_angles).map(of_row).sum();
        Self { map, solid_angles, flux, mean: flux / f64::from(SPHERE) }
    }

    fn luminance(&self, texel: u32) -> f64 {
        f64::from(luminance(self.map.pixels[texel as usize]))
    }

    fn solid_angle(&self, texel: u32) -> f64 {
        self.solid_angles[(texel / self.map.size[0]) as usize]
    }

    /// The share of a texel's light that stays in the map.
    fn kept(&self, texel: u32, level: f64) -> f32 {
        (level / self.luminance(texel)) as f32
    }

    /// All texels brighter than `level`, in connected groups, also across the map's seam.
    fn spots(&self, level: f64) -> Vec<Vec<u32>> {
        let bright: Vec<u32> =
            (0..self.map.pixels.len() as u32).filter(|&texel| self.luminance(texel) > level).collect();
        let mut left: FxHashSet<u32> = bright.iter().copied().collect();
        let mut spots = Vec::new();
        for first in bright {
            let mut spot = Vec::new();
            let mut border = Vec::from_iter(left.take(&first));
            while let Some(texel) = border.pop() {
                spot.push(texel);
                border.extend(self.around(texel).filter(|next| left.remove(next)));
            }
            if !spot.is_empty() {
                spots.push(spot);
            }
        }
        spots
    }

    /// The neighbors of a texel, including itself.
    fn around(&self, texel: u32) -> impl Iterator<Item = u32> + use<> {
        let [width, height] = self.map.size;
        let (x, y) = (texel % width, texel / width);
        let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
        rows.flat_map(move |row| [width - 1, 0, 1].map(|step| row * width + (x + step) % width))
    }

    /// The light of a spot above `level`.
    fn spot(&self, texels: Vec<u32>, level: f64) -> Spot {
        let [width, _] = self.map.size;
        let direction = |texel: u32| texel_direction(texel % width, texel / width, self.map.size).as_dvec3();
        let flux_of = |texel: u32| (self.luminance(texel) - level) * self.solid_angle(texel);
        let flux: f64 = texels.iter().map(|&texel| flux_of(texel)).sum();
        let axis = texels.iter().map(|&texel| direction(texel) * flux_of(texel)).sum::<DVec3>().normalize_or(DVec3::Y);
        // The mean squared distance from its center is half of a disc's squared radius. A texel is also a disc.
        let spread = |texel: u32| 2.0 - 2.0 * direction(texel).dot(axis) + self.solid_angle(texel) / TAU;
        let mean_sq = texels.iter().map(|&texel| flux_of(texel) * spread(texel)).sum::<f64>() / flux;
        let radius = (2.0 * mean_sq).sqrt().min(FRAC_PI_2);
        let taken = |texel: u32| {
            let radiance = self.map.pixels[texel as usize] * (1.0 - self.kept(texel, level));
            radiance.as_dvec3() * self.solid_angle(texel)
        };
        // On a surface that faces it, light of a disc falls with the mean of the cosines at its center and its rim.
        let irradiance = texels.iter().map(|&texel| taken(texel)).sum::<DVec3>() * (0.5 * (1.0 + radius.cos()));
        let sun = Sun { direction: axis.as_vec3(), angle: 2.0 * radius as f32, irradiance: irradiance.as_vec3() };
        Spot { texels, sun, share: flux / self.flux }
    }
}

/// Cached results about a map.
#[derive(Debug, Default)]
pub(super) struct MapCache {
    /// The latest suns with their settings: the window and its jobs request several in turn.
    suns: Mutex<Vec<(SunSettings, Arc<Suns>)>>,
    /// See [`Environment::irradiance_from_above`].
    pub from_above: OnceLock<Vec3>,
    /// See [`Environment::pyramid`].
    pub pyramid: OnceLock<Arc<Pyramid>>,
}

/// Number of cached settings.
const KEPT: usize = 3;

/// A copy starts with an empty cache.
impl Clone for MapCache {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Caches follow from the map.
impl PartialEq for MapCache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl MapCache {
    pub fn suns(&self, environment: &Environment, settings: SunSettings) -> Arc<Suns> {
        let mut known = self.suns.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, suns)) = known.iter().find(|(of, _)| *of == settings) {
            return suns.clone();
        }
        let suns: Arc<Suns> = Suns::of(environment, settings).into();
        known.insert(0, (settings, suns.clone()));
        known.truncate(KEPT);
        suns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{constant, sun_and_sky};
    use std::f32::consts::PI;

    fn environment(size: [u32; 2], texel: impl Fn(u32, u32) -> Vec3) -> Environment {
        Environment::new("test".into(), Image::from_fn(size, texel))
    }

    /// All light of a map, as the integral of its radiance.
    fn flux(map: &Image) -> DVec3 {
        let texel =
            |i: usize| map.pixels[i].as_dvec3() * f64::from(texel_solid_angle(i as u32 / map.size[0], map.size));
        (0..map.pixels.len()).map(texel).sum()
    }

    /// Gray with a disc of `angle` degrees around a direction, of `radiance`.
    fn disc(size: [u32; 2], toward: Vec3, angle: f32, radiance: Vec3) -> Environment {
        let cos = (0.5 * angle).to_radians().cos();
        environment(
            size,
            |x, y| if texel_direction(x, y, size).dot(toward) > cos { radiance } else { Vec3::splat(0.5) },
        )
    }

    #[test]
    fn a_disc_is_found_where_it_is_as_large_and_as_bright_as_it_is() {
        let size = [2048, 1024];
        let radiance = Vec3::new(9e4, 8e4, 6e4);
        for toward in [Vec3::new(0.3, 0.8, -0.5), Vec3::new(0.02, 0.1, -1.0), Vec3::Y, Vec3::new(1.0, -1e-3, 0.2)] {
            for angle in [0.53, 2.0, 6.0_f32] {
                let toward = toward.normalize();
                let map = disc(size, toward, angle, radiance);
                let Suns { suns, rest } = Suns::of(&map, SunSettings::default());
                let [sun] = suns[..] else { panic!("{toward} {angle}: {suns:?}") };
                assert!(
                    sun.direction.angle_between(toward) < 0.1_f32.to_radians(),
                    "{toward} {angle}: {}",
                    sun.direction
                );
                let measured = sun.angle.to_degrees();
                assert!((measured - angle).abs() < 0.02 * angle + 0.12, "{toward}: {measured} for {angle} degrees");
                let radius = 0.5 * sun.angle;
                let expected = radiance * (PI * radius.sin().powi(2));
                let off = (sun.irradiance / expected - 1.0).abs().max_element();
                assert!(off < 0.05 || angle < 1.0, "{toward} {angle}: {} for {expected}", sun.irradiance);
                // Nothing is lost: the map lacks exactly the disc's light.
                let of_disc = sun.irradiance.as_dvec3() * (2.0 / (1.0 + f64::from(radius.cos())));
                let lost = (flux(&map.map) - flux(&rest.unwrap().map)) / of_disc - 1.0;
                assert!(lost.abs().max_element() < 1e-5, "{toward} {angle}: {lost}");
            }
        }
    }

    #[test]
    fn what_is_large_faint_or_even_stays_in_the_map() {
        let none = |map: &Environment| {
            let Suns { suns, rest } = Suns::of(map, SunSettings::default());
            suns.is_empty() && rest.is_none()
        };
        let size = [1024, 512];
        assert!(none(&Environment::new("gray".into(), constant(Vec3::ONE))));
        assert!(none(&Environment::new("black".into(), constant(Vec3::ZERO))));
        assert!(none(&disc(size, Vec3::X, 10.0, Vec3::splat(1e4))), "a window");
        assert!(none(&disc(size, Vec3::X, 1.0, Vec3::splat(10.0))), "a lamp among others");
        assert!(none(&environment([8, 4], |x, y| Vec3::splat(if (x, y) == (2, 1) { 1e6 } else { 0.0 }))), "coarse");
        assert!(!none(&Environment::new("sky".into(), sun_and_sky(0.7))), "negative control");
    }

    #[test]
    fn one_texel_two_suns_and_moonlight_are_suns_as_well() {
        let size = [1024, 512];
        let one = environment(size, |x, y| Vec3::splat(if (x, y) == (1023, 200) { 1e7 } else { 0.0 }));
        let suns = Suns::of(&one, SunSettings::default()).suns;
        assert!(
            suns.len() == 1
                && suns[0].angle < 0.01
                && suns[0].direction.dot(texel_direction(1023, 200, size)) > 0.999_99
        );
        let bright = |x: u32, y: u32| match (x, y) {
            (0 | 1023, 100..102) => 2e5,
            (500..502, 300..302) => 1e5,
            _ => 1.0,
        };
        let two = environment(size, |x, y| Vec3::splat(bright(x, y)));
        let suns = Suns::of(&two, SunSettings::default()).suns;
        assert!(
            suns.len() == 2 && suns[0].irradiance.x > suns[1].irradiance.x,
            "one of them lies across the seam: {suns:?}"
        );
        let moon = environment(size, |x, y| Vec3::splat(1e-9 * bright(x, y)));
        let faint = Suns::of(&moon, SunSettings::default()).suns;
        assert!(faint.len() == 2 && (faint[0].irradiance.x / suns[0].irradiance.x / 1e-9 - 1.0).abs() < 1e-3);
        let many = environment(size, |x, y| Vec3::splat(if x % 100 == 3 && y == 250 { 1e6 } else { 0.1 }));
        assert_eq!(Suns::of(&many, SunSettings::default()).suns.len(), MOST_SUNS);
    }

    #[test]
    fn suns_are_found_once_for_the_same_settings() {
        let sky = Environment::new("sky".into(), sun_and_sky(0.7));
        let settings = SunSettings::default();
        let first = sky.suns(settings);
        assert!(Arc::ptr_eq(&first, &sky.suns(settings)));
        let others = sky.suns(SunSettings { threshold: 1e9, ..settings });
        assert!(!Arc::ptr_eq(&first, &others) && others.suns.is_empty() && first.suns.len() == 1);
        assert!(Arc::ptr_eq(&first, &sky.suns(settings)), "in turn");
    }
}
