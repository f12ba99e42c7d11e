//! Directional albedo of lobes: the share of light from a direction that a lobe reflects.
//!
//! It gives the energy that a lobe leaves to the layers below it, and the energy lost between microfacets:
//!
//! * a diffuse base below a lobe of albedo E reflects `(1 - E(wi)) (1 - E(wo)) / (1 - mean E)` of its own BRDF (Kelemen and
//!   Szirmay-Kalos 2001), reciprocal and with the directional albedo `1 - E`;
//! * multiple scattering among microfacets is the same product over π (Kulla and Conty 2017).
//!
//! The albedo of GGX with height-correlated shadowing is integrated here, once, for widths and for indices of refraction.
//! At one pixel both are constants, and the albedo is a polynomial of degree 4 in `1 / (1 + 6 cos θ)`: within 0.009 of the
//! integral everywhere and 0.004 for 99 % of all arguments.

use super::{
    fresnel::dielectric,
    gaussian_lobe::{GaussianLobe, beckmann_weight, ward_weight},
    ggx_lobe::GgxLobe,
};
use crate::simd::Lanes;
use glam::Vec3;
use std::{array::from_fn, sync::LazyLock};

/// Number of coefficients.
const TERMS: usize = 5;
/// Widths and reflectances in the table.
const STEPS: usize = 16;
/// Rows: one per reflectance, and one per other lobe.
const ROWS: usize = STEPS + 3;
/// First row of the other lobes.
const FUZZ: usize = STEPS;
const BECKMANN: usize = STEPS + 1;
const WARD: usize = STEPS + 2;
/// Cosines at which an albedo is integrated.
const ANGLES: usize = 32;
/// Samples along each side of the unit square.
const SAMPLES: usize = 24;

/// Directional albedo as a polynomial, and its mean over the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    terms: [f32; TERMS],
    mean: f32,
}

/// The table for shaders: per row and width the coefficients, the mean, and two numbers of padding.
pub fn albedo_table() -> &'static [[f32; 8]; ROWS * STEPS] {
    static PADDED: LazyLock<[[f32; 8]; ROWS * STEPS]> = LazyLock::new(|| {
        from_fn(|i| {
            let Albedo { terms: [a, b, c, d, e], mean } = TABLE[i / STEPS][i % STEPS];
            [a, b, c, d, e, mean, 0.0, 0.0]
        })
    });
    &PADDED
}

static TABLE: LazyLock<[[Albedo; STEPS]; ROWS]> = LazyLock::new(table);

impl Albedo {
    /// Albedo of nothing.
    pub const BLACK: Self = Self { terms: [0.0; TERMS], mean: 0.0 };

    /// Albedo of a GGX lobe of these widths without Fresnel factor: the mean over the isotropic ones.
    #[inline]
    pub fn of_ggx(alpha: [f32; 2]) -> Self {
        Self::of_widths(alpha, |alpha| Self::between(STEPS - 1, STEPS - 1, 0.0, alpha))
    }

    /// Albedo of the same lobe with the Fresnel factor of a dielectric. The index of refraction is at least 1.
    #[inline]
    pub fn of_dielectric(alpha: [f32; 2], ior: f32) -> Self {
        let row = (ior - 1.0) / (ior + 1.0) * (STEPS - 1) as f32;
        let low = (row as usize).min(STEPS - 2);
        Self::of_widths(alpha, |alpha| Self::between(low, low + 1, row - low as f32, alpha))
    }

    /// Albedo of a smooth dielectric.
    #[inline]
    pub fn of_smooth_dielectric(ior: f32) -> Self {
        Self::of_dielectric([0.0; 2], ior)
    }

    #[inline]
    fn of_widths([x, y]: [f32; 2], of: impl Fn(f32) -> Self) -> Self {
        if x == y { of(x) } else { of(x).lerp(&of(y), 0.5) }
    }

    /// Albedo of fuzz.
    #[inline]
    pub fn of_fuzz(roughness: f32) -> Self {
        Self::between(FUZZ, FUZZ, 0.0, roughness)
    }

    /// Albedo of a Beckmann lobe without Fresnel factor.
    #[inline]
    pub fn of_beckmann(alpha: [f32; 2]) -> Self {
        Self::of_widths(alpha, |alpha| Self::between(BECKMANN, BECKMANN, 0.0, alpha))
    }

    /// Albedo of Ward's lobe of 1992 with a reflectance of 1.
    #[inline]
    pub fn of_ward(alpha: [f32; 2]) -> Self {
        Self::of_widths(alpha, |alpha| Self::between(WARD, WARD, 0.0, alpha))
    }

    #[inline]
    fn between(low: usize, high: usize, up: f32, alpha: f32) -> Self {
        let column = alpha.clamp(0.0, 1.0).sqrt() * (STEPS - 1) as f32;
        let left = (column as usize).min(STEPS - 2);
        let right = column - left as f32;
        let row = |row: usize| TABLE[row][left].lerp(&TABLE[row][left + 1], right);
        if low == high { row(low) } else { row(low).lerp(&row(high), up) }
    }

    #[inline]
    fn lerp(&self, other: &Self, t: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Self { terms: from_fn(|i| mix(self.terms[i], other.terms[i])), mean: mix(self.mean, other.mean) }
    }

    /// This albedo times a factor.
    #[inline]
    #[must_use]
    pub fn scaled(self, by: f32) -> Self {
        Self { terms: self.terms.map(|term| by * term), mean: by * self.mean }
    }

    /// Albedo for light from a direction with this cosine.
    #[inline(always)]
    pub fn at<L: Lanes>(&self, cosine: L) -> L {
        let x = L::splat(1.0) / (L::splat(1.0) + L::splat(6.0) * cosine.at_least(0.0));
        let [a, b, c, d, e] = self.terms;
        let [a, b, c, d, e] = [L::splat(a), L::splat(b), L::splat(c), L::splat(d), L::splat(e)];
        let value = (((e * x + d) * x + c) * x + b) * x + a;
        value.at_least(0.0).fast_min(L::splat(1.0))
    }

    /// Share of light left between two directions: the product of `1 - E` for both.
    #[inline(always)]
    pub fn left<L: Lanes>(&self, cos_i: L, cos_o: L) -> L {
        (L::splat(1.0) - self.at(cos_i)) * (L::splat(1.0) - self.at(cos_o))
    }

    /// [`Self::at`] for one cosine.
    #[inline]
    pub fn at_one(&self, cosine: f32) -> f32 {
        self.at(wide::f32x8::splat(cosine)).to_array()[0]
    }

    /// Mean under uniform light.
    pub fn mean(&self) -> f32 {
        self.mean
    }

    /// Factor of the product of `1 - E` for two directions: the result over π is the BRDF of a base that reflects all
    /// remaining light.
    #[inline]
    pub fn normalization(&self) -> f32 {
        1.0 / (1.0 - self.mean).max(1e-4)
    }
}

/// Reflectance of light that bounces among microfacets at least twice, for a mean Fresnel factor (Kulla and Conty 2017).
#[inline]
pub fn multiple_reflectance(mean_fresnel: Vec3, lobe: &Albedo) -> Vec3 {
    let lost = 1.0 - lobe.mean;
    mean_fresnel * mean_fresnel * lobe.mean / (Vec3::ONE - mean_fresnel * lost)
}

/// Powers of `1 / (1 + 6 cos θ)`.
fn powers(cosine: f64) -> [f64; TERMS] {
    let x = 1.0 / (1.0 + 6.0 * cosine);
    from_fn(|k| x.powi(k as i32))
}

fn table() -> [[Albedo; STEPS]; ROWS] {
    let fit = Fit::new();
    let reflectance = |row: usize| {
        let root = row as f32 / (STEPS - 1) as f32;
        // The last row has no Fresnel factor.
        (row < STEPS - 1).then(|| (1.0 + root) / (1.0 - root))
    };
    let mut rows = [[Albedo::BLACK; STEPS]; ROWS];
    for column in 0..STEPS {
        // Denser toward smooth lobes, whose loss grows with the square of the width.
        let width = (column as f32 / (STEPS - 1) as f32).powi(2);
        let lobe = GgxLobe::new([width.max(1e-3); 2]);
        let mut found = [[0.0; ANGLES]; ROWS];
        for (angle, &cosine) in fit.cosines.iter().enumerate() {
            let cosine = cosine as f32;
            let wo = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
            for (u, v) in grid(SAMPLES) {
                let half = lobe.sample_half_vector(wo, u, v);
                let wi = 2.0 * wo.dot(half) * half - wo;
                let weight = f64::from(lobe.weight(wi, wo)) / (SAMPLES * SAMPLES) as f64;
                for (row, found) in found[..STEPS].iter_mut().enumerate() {
                    let fresnel = reflectance(row).map_or(1.0, |ior| dielectric(wo.dot(half), ior));
                    found[angle] += weight * f64::from(fresnel);
                }
            }
            found[FUZZ][angle] = fuzz_albedo(wo, width);
            let gaussian = GaussianLobe::new([width.max(1e-3); 2]);
            let half_vector = |u, v| gaussian.sample_half_vector(u, v);
            found[BECKMANN][angle] = albedo_of(wo, half_vector, |wi, h| beckmann_weight(width.max(1e-3), wi, wo, h));
            found[WARD][angle] = albedo_of(wo, half_vector, |wi, h| ward_weight(wi, wo, h));
        }
        for (row, found) in rows.iter_mut().zip(&found) {
            row[column] = fit.albedo(found);
        }
    }
    rows
}

/// Mean of a lobe times the cosine over the density of its half vectors.
fn albedo_of(wo: Vec3, half_vector: impl Fn(f32, f32) -> Vec3, weight: impl Fn(Vec3, Vec3) -> f32) -> f64 {
    let sample = |(u, v)| {
        let h = half_vector(u, v);
        let wi = 2.0 * wo.dot(h) * h - wo;
        if wi.z > 0.0 && wo.dot(h) > 0.0 { f64::from(weight(wi, h)) } else { 0.0 }
    };
    grid(SAMPLES).map(sample).sum::<f64>() / (SAMPLES * SAMPLES) as f64
}

fn fuzz_albedo(wo: Vec3, roughness: f32) -> f64 {
    let sum: f64 = grid(SAMPLES)
        .map(|(u, v)| {
            let wi = crate::sphere::cosine_direction(u, v);
            f64::from(super::fuzz::value(roughness, wi, wo)) * std::f64::consts::PI
        })
        .sum();
    sum / (SAMPLES * SAMPLES) as f64
}

/// Stratified points of the unit square.
fn grid(n: usize) -> impl Iterator<Item = (f32, f32)> {
    (0..n * n).map(move |i| (((i % n) as f32 + 0.5) / n as f32, ((i / n) as f32 + 0.5) / n as f32))
}

/// Least squares over [`ANGLES`] cosines.
struct Fit {
    cosines: [f64; ANGLES],
    /// Rows of the pseudoinverse.
    solver: [[f64; ANGLES]; TERMS],
    /// Means of the powers over the hemisphere.
    means: [f64; TERMS],
}

impl Fit {
    fn new() -> Self {
        // Denser toward the horizon, where the albedo bends.
        let cosines: [f64; ANGLES] = from_fn(|i| {
            let t = (i as f64 + 0.5) / ANGLES as f64;
            0.5 * (t + t * t)
        });
        let basis = cosines.map(powers);
        let mut normal = [[0.0; 2 * TERMS]; TERMS];
        for row in 0..TERMS {
            normal[row][TERMS + row] = 1.0;
            for column in 0..TERMS {
                normal[row][column] = basis.iter().map(|b| b[row] * b[column]).sum();
            }
        }
        invert(&mut normal);
        let solver = from_fn(|k| from_fn(|i| (0..TERMS).map(|j| normal[k][TERMS + j] * basis[i][j]).sum()));
        let steps = 4096;
        let mean = |k: usize| {
            let term = |i: usize| {
                let cosine = (i as f64 + 0.5) / steps as f64;
                2.0 * cosine * powers(cosine)[k] / steps as f64
            };
            (0..steps).map(term).sum()
        };
        Self { cosines, solver, means: from_fn(mean) }
    }

    fn albedo(&self, found: &[f64; ANGLES]) -> Albedo {
        let terms: [f64; TERMS] = from_fn(|k| self.solver[k].iter().zip(found).map(|(a, b)| a * b).sum());
        let mean: f64 = terms.iter().zip(self.means).map(|(a, b)| a * b).sum();
        Albedo { terms: terms.map(|term| term as f32), mean: mean as f32 }
    }
}

/// Gauss-Jordan elimination: the right half becomes the inverse of the left.
fn invert(m: &mut [[f64; 2 * TERMS]; TERMS]) {
    for column in 0..TERMS {
        let largest = |row: &usize| m[*row][column].abs();
        let pivot = (column..TERMS).max_by(|a, b| largest(a).total_cmp(&largest(b))).unwrap_or(column);
        m.swap(column, pivot);
        let scale = m[column][column];
        m[column].iter_mut().for_each(|x| *x /= scale);
        let source = m[column];
        for (_, row) in m.iter_mut().enumerate().filter(|(row, _)| *row != column) {
            let factor = row[column];
            row.iter_mut().zip(source).for_each(|(x, s)| *x -= factor * s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral with other samples than the table's.
    fn integral(alpha: f32, cosine: f32, ior: Option<f32>) -> f32 {
        let lobe = GgxLobe::new([alpha; 2]);
        let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let n = 61;
        let sample = |(u, v)| {
            let half = lobe.sample_half_vector(wo, u, v);
            let wi = 2.0 * wo.dot(half) * half - wo;
            lobe.weight(wi, wo) * ior.map_or(1.0, |ior| dielectric(wo.dot(half), ior))
        };
        grid(n).map(sample).sum::<f32>() / (n * n) as f32
    }

    #[test]
    fn albedos_are_those_of_the_integrals() {
        for alpha in [0.03, 0.17, 0.41, 0.83, 1.0] {
            for cosine in [0.1, 0.2, 0.5, 0.9, 1.0] {
                let (found, expected) = (Albedo::of_ggx([alpha; 2]).at_one(cosine), integral(alpha, cosine, None));
                // Narrow lobes bend within a step of the table near the horizon.
                let bound = if cosine < 0.15 { 0.025 } else { 0.012 };
                assert!((found - expected).abs() < bound, "{alpha} {cosine}: {found} {expected}");
                for ior in [1.2, 1.5, 2.1] {
                    let found = Albedo::of_dielectric([alpha; 2], ior).at_one(cosine);
                    let expected = integral(alpha, cosine, Some(ior));
                    assert!((found - expected).abs() < bound, "{alpha} {cosine} {ior}: {found} {expected}");
                }
            }
        }
        let other = Albedo::of_ggx([0.41; 2]).at_one(0.5) - integral(0.83, 0.5, None);
        assert!(other.abs() > 0.05, "negative control: {other}");
    }

    /// A spurious loss of nearly smooth lobes would add a haze to the sun's reflection in chrome.
    #[test]
    fn smooth_lobes_lose_next_to_nothing() {
        for alpha in [0.001, 0.004, 0.01] {
            for cosine in [0.2, 0.5, 1.0] {
                let loss = 1.0 - Albedo::of_ggx([alpha; 2]).at_one(cosine);
                assert!(loss < 0.005, "{alpha} {cosine}: {loss}");
            }
        }
        assert!(1.0 - Albedo::of_ggx([0.4; 2]).at_one(0.5) > 0.05, "negative control");
    }

    #[test]
    fn means_are_over_the_hemisphere() {
        for albedo in [Albedo::of_ggx([0.6; 2]), Albedo::of_dielectric([0.3, 0.5], 1.5), Albedo::of_fuzz(0.5)] {
            let steps = 500;
            let cosine = |i: usize| (i as f32 + 0.5) / steps as f32;
            let mean: f32 = (0..steps).map(|i| 2.0 * cosine(i) * albedo.at_one(cosine(i)) / steps as f32).sum();
            assert!((albedo.mean() - mean).abs() < 1e-3, "{} {mean}", albedo.mean());
        }
        assert!((Albedo::of_smooth_dielectric(1.5).mean() - 0.0918).abs() < 2e-3, "2 ∫ F(c) c dc");
    }
}
