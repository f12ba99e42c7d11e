//! Exact Fresnel factors of dielectrics and metals for unpolarized light.

use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use wide::f32x8;

/// Nodes and weights of the Gauss quadrature of `2 ∫ f(c) c dc` over cosines from 0 to 1.
pub const MEAN_NODES: [f32; 3] = [0.212_340_54, 0.590_533_14, 0.911_412_04];
pub const MEAN_WEIGHTS: [f32; 3] = [0.139_653_96, 0.458_482_2, 0.401_863_84];

/// Largest reflectance of a metal at normal incidence whose index of refraction is representable in `f32`.
const MOST_REFLECTANCE: f32 = 0.9999;

/// Factor of a dielectric with an index of refraction of at least 1, for a cosine to the half vector.
#[inline(always)]
pub fn dielectric_x8<L: Lanes>(cosine: L, ior: f32) -> L {
    let c = cosine;
    let g = (L::splat(ior * ior - 1.0) + c * c).sqrt();
    let (sum, difference) = ((g + c).at_least(1e-6), g - c);
    // `a² (1 + b²) / 2` with a = difference / sum and b = over / under, by one division.
    let (over, under) = (c * sum - L::splat(1.0), c * difference + L::splat(1.0));
    let root = difference / (sum * under);
    L::splat(0.5) * root * root * (under * under + over * over)
}

/// [`dielectric_x8`] for one cosine.
#[inline]
pub fn dielectric(cosine: f32, ior: f32) -> f32 {
    dielectric_x8(f32x8::splat(cosine), ior).to_array()[0]
}

/// Indices of refraction and extinction of a metal, per color.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Metal {
    /// Squared index of refraction, per color.
    n_sq: Vec3,
    k_sq: Vec3,
    /// Mean under uniform light.
    mean: Vec3,
}

impl Metal {
    /// Creates a metal from its reflectance at normal incidence and its tint toward grazing angles (Gulbrandsen 2014,
    /// *Artist Friendly Metallic Fresnel*, Eq. 1 to 4).
    #[inline]
    pub fn new(reflectance: Vec3, edge: Vec3) -> Self {
        let r = reflectance.clamp(Vec3::ZERO, Vec3::splat(MOST_REFLECTANCE));
        let root = r.map(f32::sqrt);
        let least = (Vec3::ONE - r) / (Vec3::ONE + r);
        let most = (Vec3::ONE + root) / (Vec3::ONE - root);
        let n = most + (least - most) * edge;
        let (above, below) = (n + Vec3::ONE, n - Vec3::ONE);
        let k_sq = (above * above * r - below * below) / (Vec3::ONE - r);
        let metal = Self { n_sq: n * n, k_sq: k_sq.max(Vec3::ZERO), mean: Vec3::ZERO };
        let at = |i: usize| metal.fresnel(f32x8::splat(MEAN_NODES[i])).lane(0) * MEAN_WEIGHTS[i];
        Self { mean: at(0) + at(1) + at(2), ..metal }
    }

    /// Reflectance at normal incidence and tint toward grazing angles, as [`Self::new`] takes them, of a metal with
    /// indices of refraction and extinction (Gulbrandsen 2014, Eq. 5 and 6).
    pub fn artistic(n: Vec3, k: Vec3) -> (Vec3, Vec3) {
        let (above, below) = (n + Vec3::ONE, n - Vec3::ONE);
        let r = (below * below + k * k) / (above * above + k * k);
        let root = r.map(f32::sqrt);
        let least = (Vec3::ONE - r) / (Vec3::ONE + r);
        let most = (Vec3::ONE + root) / (Vec3::ONE - root);
        (r, ((most - n) / (most - least)).clamp(Vec3::ZERO, Vec3::ONE))
    }

    /// Mean under uniform light.
    pub fn mean(&self) -> Vec3 {
        self.mean
    }

    /// Indices of refraction and extinction, per color.
    pub fn indices(&self) -> [Vec3; 2] {
        [self.n_sq, self.k_sq].map(|sq| sq.map(f32::sqrt))
    }

    /// Factor at this cosine to the half vector.
    #[inline(always)]
    pub fn fresnel<L: Lanes>(&self, cosine: L) -> Vec3x8<L> {
        Vec3x8 {
            x: conductor(cosine, self.n_sq.x, self.k_sq.x),
            y: conductor(cosine, self.n_sq.y, self.k_sq.y),
            z: conductor(cosine, self.n_sq.z, self.k_sq.z),
        }
    }
}

/// Factor of a conductor (PBRT 4th edition, 9.3.6, without complex numbers).
#[inline(always)]
fn conductor<L: Lanes>(cosine: L, n_sq: f32, k_sq: f32) -> L {
    let one = L::splat(1.0);
    let cos_sq = (cosine * cosine).fast_min(one);
    let sin_sq = one - cos_sq;
    let t0 = L::splat(n_sq - k_sq) - sin_sq;
    let length = (t0 * t0 + L::splat(4.0 * n_sq * k_sq)).sqrt();
    let t1 = length + cos_sq;
    let a = (L::splat(0.5) * (length + t0)).at_least(0.0).sqrt();
    let t2 = (a + a) * cosine;
    let t3 = cos_sq * length + sin_sq * sin_sq;
    let t4 = t2 * sin_sq;
    // The mean of (t1 - t2) / (t1 + t2) across and of that times (t3 - t4) / (t3 + t4) along the plane of incidence.
    ((t1 - t2) * t3 / ((t1 + t2) * (t3 + t4))).at_least(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    /// Fresnel's equations with a complex index of refraction, in double precision.
    fn exact(cosine: f64, n: f64, k: f64) -> f64 {
        type Complex = (f64, f64);
        let mul = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let div = |a: Complex, b: Complex| {
            let d = b.0 * b.0 + b.1 * b.1;
            ((a.0 * b.0 + a.1 * b.1) / d, (a.1 * b.0 - a.0 * b.1) / d)
        };
        let root = |a: Complex| {
            let length = a.0.hypot(a.1);
            (((length + a.0) / 2.0).max(0.0).sqrt(), ((length - a.0) / 2.0).max(0.0).sqrt() * a.1.signum())
        };
        let index = (n, k);
        let sine = div((1.0 - cosine * cosine, 0.0), mul(index, index));
        let inner = root((1.0 - sine.0, -sine.1));
        let c = (cosine, 0.0);
        let ratio = |a: Complex, b: Complex| {
            let r = div((a.0 - b.0, a.1 - b.1), (a.0 + b.0, a.1 + b.1));
            r.0 * r.0 + r.1 * r.1
        };
        0.5 * (ratio(c, mul(index, inner)) + ratio(mul(index, c), inner))
    }

    #[test]
    fn factors_are_those_of_fresnels_equations() {
        for i in 0..20 {
            let cosine = (FRAC_PI_2 * i as f32 / 20.0).cos();
            for ior in [1.0, 1.33, 1.5, 2.4] {
                let expected = exact(cosine.into(), ior.into(), 0.0) as f32;
                assert!((dielectric(cosine, ior) - expected).abs() < 1e-5, "{ior} {cosine}");
            }
            for (n, k) in [(0.2, 3.9), (1.1, 6.8), (3.1, 3.3)] {
                let found = conductor(f32x8::splat(cosine), n * n, k * k).to_array()[0];
                let expected = exact(cosine.into(), n.into(), k.into()) as f32;
                assert!((found - expected).abs() < 1e-4, "{n} {k} {cosine}: {found} {expected}");
            }
        }
        assert!((dielectric(1.0, 1.5) - exact(1.0, 1.33, 0.0) as f32).abs() > 0.01, "negative control");
    }

    #[test]
    fn metals_have_their_reflectance_and_their_mean() {
        for (r, g) in [(0.2, 0.0), (0.5, 0.5), (0.9, 0.9), (0.97, 1.0)] {
            let metal = Metal::new(Vec3::splat(r), Vec3::splat(g));
            assert!((metal.fresnel(f32x8::splat(1.0)).lane(0).x - r).abs() < 1e-3, "{r} {g}");
            let steps = 1000;
            let at = |i: usize| (i as f32 + 0.5) / steps as f32;
            let sum: f32 = (0..steps).map(|i| 2.0 * at(i) * metal.fresnel(f32x8::splat(at(i))).lane(0).y).sum();
            assert!((metal.mean().y - sum / steps as f32).abs() < 0.01, "{r} {g}");
        }
        let indices = [Vec3::new(0.143, 0.375, 4.37), Vec3::new(3.983, 2.386, 5.2)];
        let (r, edge) = Metal::artistic(indices[0], indices[1]);
        let found = Metal::new(r, edge).indices();
        assert!((found[0] - indices[0]).length() < 0.02 && (found[1] - indices[1]).length() < 0.02, "{found:?}");
        let white = Metal::new(Vec3::ONE, Vec3::splat(0.9)).fresnel(f32x8::splat(0.3)).lane(0);
        assert!((white - Vec3::ONE).length() < 5e-3, "{white}");
    }
}
