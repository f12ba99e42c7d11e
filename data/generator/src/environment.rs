//! Latitude-longitude radiance maps: directions, painting, energy, and the file.
//!
//! The center of the image is +Z, its left quarter +X, its top +Y. Texels are radiance, linear Rec. 709.

use std::f32::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use glam::{Vec2, Vec3, vec2, vec3};
use image::Rgb;
use image::codecs::hdr::HdrEncoder;
use lapidary_core::color::luminance;

/// Width in pixels; the height is half of it.
pub const WIDTH: usize = 512;
/// Height in pixels.
pub const HEIGHT: usize = WIDTH / 2;
/// Samples along each side of a pixel, so that edges of lights are smooth and keep their energy.
const SUPERSAMPLES: usize = 4;

/// A map of radiance over all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Row by row from the top.
    pub texels: Vec<Vec3>,
}

impl Environment {
    /// Paints every pixel with the mean of `radiance` over it.
    pub fn paint(radiance: impl Fn(Vec3) -> Vec3) -> Environment {
        let texel = |i: usize| {
            let samples = pixel_samples(i).map(|uv| radiance(direction(uv)));
            samples.sum::<Vec3>() / (SUPERSAMPLES * SUPERSAMPLES) as f32
        };
        Environment { texels: (0..WIDTH * HEIGHT).map(texel).collect() }
    }

    /// Mean radiance over the sphere.
    pub fn mean(&self) -> Vec3 {
        let sum: Vec3 = self.texels.iter().enumerate().map(|(i, texel)| *texel * solid_angle(i)).sum();
        sum / (4.0 * PI)
    }

    /// Scales the map to a mean luminance over the sphere.
    pub fn scaled_to_mean(mut self, mean: f32) -> Environment {
        let factor = mean / luminance(self.mean());
        for texel in &mut self.texels {
            *texel *= factor;
        }
        self
    }

    /// Adds a disc of `angular_radius` radians around `centre` that gives `irradiance` on a surface facing it.
    pub fn add_disc(&mut self, centre: Vec3, angular_radius: f32, irradiance: Vec3) {
        let inside = |d: Vec3| d.angle_between(centre) < angular_radius;
        let coverage: Vec<f32> = (0..WIDTH * HEIGHT).map(|i| disc_coverage(i, &inside)).collect();
        // Divided by the rasterized solid angle, so that the energy is right at any resolution.
        let covered: f32 = coverage.iter().enumerate().map(|(i, c)| c * solid_angle(i)).sum();
        for (texel, c) in self.texels.iter_mut().zip(&coverage) {
            *texel += irradiance * (c / covered);
        }
    }

    /// Irradiance on a horizontal surface facing up.
    pub fn irradiance_from_above(&self) -> Vec3 {
        let texels = self.texels.iter().enumerate();
        texels.map(|(i, texel)| *texel * solid_angle(i) * direction(centre_uv(i)).y.max(0.0)).sum()
    }

    /// Writes Radiance RGBE.
    pub fn save(&self, path: &Path) -> Result<()> {
        let pixels: Vec<Rgb<f32>> = self.texels.iter().map(|t| Rgb(t.to_array())).collect();
        let mut bytes = Vec::new();
        HdrEncoder::new(&mut bytes).encode(&pixels, WIDTH, HEIGHT).context("cannot encode the environment")?;
        fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
    }
}

/// Direction seen at texture coordinates `uv`.
pub fn direction(uv: Vec2) -> Vec3 {
    let (azimuth, polar) = ((0.5 - uv.x) * TAU, uv.y * PI);
    vec3(polar.sin() * azimuth.sin(), polar.cos(), polar.sin() * azimuth.cos())
}

fn centre_uv(i: usize) -> Vec2 {
    vec2((i % WIDTH) as f32 + 0.5, (i / WIDTH) as f32 + 0.5) / vec2(WIDTH as f32, HEIGHT as f32)
}

fn pixel_samples(i: usize) -> impl Iterator<Item = Vec2> {
    let corner = vec2((i % WIDTH) as f32, (i / WIDTH) as f32);
    (0..SUPERSAMPLES * SUPERSAMPLES).map(move |k| {
        let within = vec2((k % SUPERSAMPLES) as f32 + 0.5, (k / SUPERSAMPLES) as f32 + 0.5) / SUPERSAMPLES as f32;
        (corner + within) / vec2(WIDTH as f32, HEIGHT as f32)
    })
}

fn disc_coverage(i: usize, inside: &impl Fn(Vec3) -> bool) -> f32 {
    let hits = pixel_samples(i).filter(|uv| inside(direction(*uv))).count();
    hits as f32 / (SUPERSAMPLES * SUPERSAMPLES) as f32
}

fn solid_angle(i: usize) -> f32 {
    let row = (i / WIDTH) as f32;
    let band = (PI * row / HEIGHT as f32).cos() - (PI * (row + 1.0) / HEIGHT as f32).cos();
    band * TAU / WIDTH as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_follow_the_convention() {
        assert!(direction(vec2(0.5, 0.5)).distance(Vec3::Z) < 1e-6);
        assert!(direction(vec2(0.25, 0.5)).distance(Vec3::X) < 1e-6);
        assert!(direction(vec2(0.3, 0.0)).distance(Vec3::Y) < 1e-6);
    }

    #[test]
    fn a_uniform_map_has_its_own_mean_and_pi_times_the_irradiance() {
        let map = Environment::paint(|_| Vec3::splat(0.25));
        assert!((map.mean().x - 0.25).abs() < 1e-4);
        assert!((map.irradiance_from_above().x - 0.25 * PI).abs() < 1e-3);
    }

    #[test]
    fn a_disc_has_the_irradiance_asked_for() {
        let mut map = Environment::paint(|_| Vec3::ZERO);
        map.add_disc(Vec3::Y.lerp(Vec3::X, 0.5).normalize(), 0.026, Vec3::splat(5.0));
        let cosine = std::f32::consts::FRAC_1_SQRT_2;
        assert!((map.irradiance_from_above().x - 5.0 * cosine).abs() < 0.02);
    }
}
