//! The Fibonacci sample nearest to a direction, in closed form (Keinert et al. 2015, *Spherical Fibonacci Mapping*).
//!
//! The directions of all samples, and every term that depends on height alone, are computed once: the grid of an
//! [`super::EnvironmentSampler`] needs millions of nearest samples.

use crate::sphere::GOLDEN_SECTION;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// All samples of a Fibonacci sphere.
pub struct FibonacciLattice {
    directions: Vec<DVec3>,
}

/// A longitude in radians, -π to π.
pub struct Longitude {
    radians: f64,
    sin: f64,
    cos: f64,
}

impl Longitude {
    /// Wraps any angle.
    pub fn new(radians: f64) -> Self {
        let turned = radians.rem_euclid(TAU);
        let radians = if turned > PI { turned - TAU } else { turned };
        Self { radians, sin: radians.sin(), cos: radians.cos() }
    }
}

/// The lattice near one height on the sphere.
pub struct Zone<'a> {
    lattice: &'a FibonacciLattice,
    height: f64,
    /// Steps of the two Fibonacci numbers with the best local basis, in (longitude, height).
    basis: [DVec2; 2],
}

impl FibonacciLattice {
    /// The lattice of `lights` samples.
    pub fn new(lights: usize) -> Self {
        let count = lights as f64;
        let direction = |i: usize| {
            let height = 1.0 - (2.0 * i as f64 + 1.0) / count;
            let (sin, cos) = (TAU * (i as f64 * GOLDEN_SECTION).fract()).sin_cos();
            let radius = (1.0 - height * height).max(0.0).sqrt();
            DVec3::new(radius * sin, height, radius * cos)
        };
        Self { directions: (0..lights).map(direction).collect() }
    }

    /// The lattice near a height, -1 to 1.
    pub fn zone(&self, height: f64) -> Zone<'_> {
        let count = self.directions.len() as f64;
        let zone = (count * PI * 5.0_f64.sqrt() * (1.0 - height * height)).ln() / (2.0 * (1.0 + GOLDEN_SECTION).ln());
        let fk = (1.0 + GOLDEN_SECTION).powf(zone.floor().max(2.0)) / 5.0_f64.sqrt();
        let step =
            |f: f64| DVec2::new(TAU * ((f + 1.0) * GOLDEN_SECTION).fract() - TAU * GOLDEN_SECTION, -2.0 * f / count);
        Zone { lattice: self, height, basis: [step(fk.round()), step((fk * (1.0 + GOLDEN_SECTION)).round())] }
    }
}

impl Zone<'_> {
    /// Index of the nearest sample: one of the corners of the lattice cell around the direction.
    pub fn nearest(&self, longitude: &Longitude) -> u32 {
        let directions = &self.lattice.directions;
        let count = directions.len() as f64;
        let [a, b] = self.basis;
        let p = DVec2::new(longitude.radians, self.height - (1.0 - 1.0 / count));
        let determinant = a.perp_dot(b);
        let cell = DVec2::new(p.perp_dot(b) / determinant, a.perp_dot(p) / determinant).floor();
        let radius = (1.0 - self.height * self.height).max(0.0).sqrt();
        let wanted = DVec3::new(radius * longitude.sin, self.height, radius * longitude.cos);
        let corner = |s: u32| {
            let k = cell + DVec2::new(f64::from(s % 2), f64::from(s / 2));
            let height = k.x * a.y + k.y * b.y + 1.0 - 1.0 / count;
            let mirrored = height.clamp(-1.0, 1.0) * 2.0 - height;
            let i = (count * 0.5 * (1.0 - mirrored)).floor().clamp(0.0, count - 1.0) as usize;
            (directions[i].distance_squared(wanted), i as u32)
        };
        (0..4).map(corner).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, i)| i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;
    use glam::Vec3;

    #[test]
    fn nearest_sample_in_closed_form_is_the_nearest_by_brute_force() {
        for n in [64, 1024, 32_768] {
            let samples = fibonacci_directions(n);
            let lattice = FibonacciLattice::new(n);
            let mut rng = fastrand::Rng::with_seed(3);
            let mut worse = 0;
            for _ in 0..400 {
                let (phi, y) = (rng.f64() * TAU, rng.f64() * 2.0 - 1.0);
                let r = (1.0 - y * y).sqrt();
                let d = Vec3::new((r * phi.sin()) as f32, y as f32, (r * phi.cos()) as f32);
                let best = samples.iter().map(|s| s.distance(d)).fold(f32::INFINITY, f32::min);
                let found = samples[lattice.zone(y).nearest(&Longitude::new(phi)) as usize].distance(d);
                worse += usize::from(found > best + 1e-5);
            }
            assert!(worse <= 4, "{worse} of 400 are not nearest for {n} samples");
        }
    }
}
