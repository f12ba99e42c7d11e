//! Eight lights of some extent, as received by a surface.
//!
//! A light is a von Mises-Fisher lobe of directions. Its cosine to a normal is a random number with mean and variance
//! in closed form. It is taken as uniformly distributed: exact for the whole sphere, close for a small cap. This gives
//! the share that the horizon cuts off.

use crate::simd::{Lanes, Vec3x8};

/// Spread that widens a surface's lobes for eight lights.
#[derive(Clone, Copy, Debug)]
pub struct SpreadX8<L> {
    /// Inverse concentrations of the directions of the lights.
    pub inv_kappa: L,
    /// Twice the covariance of the surface's slopes within the footprint of a sample: xx, xy, yy along the local axes.
    /// Squared microfacet widths are twice a variance, too.
    pub slopes: [L; 3],
}

impl<L: Lanes> SpreadX8<L> {
    /// The spread of lights alone: the surface has one normal.
    #[inline(always)]
    pub fn of_lights(inv_kappa: L) -> Self {
        Self { inv_kappa, slopes: [L::splat(0.0); 3] }
    }

    /// The spread of lights and of a surface with these [slopes](Self::slopes).
    #[inline(always)]
    pub fn with_slopes(inv_kappa: L, [xx, xy, yy]: [f32; 3]) -> Self {
        Self { inv_kappa, slopes: [L::splat(xx), L::splat(xy), L::splat(yy)] }
    }
}

/// Eight lights in the local frame of a surface.
#[derive(Clone, Copy, Debug)]
pub struct LightsX8<L> {
    /// Unit directions to the lights.
    pub wi: Vec3x8<L>,
    /// The spread that widens the surface's lobes.
    pub spread: SpreadX8<L>,
    /// Mean cosines to the normal of the light above the horizon.
    pub cosine: L,
    /// 1 where `wi` is above the horizon, else 0.
    pub above: L,
}

impl<L: Lanes> LightsX8<L> {
    /// Lights with the cosines of `wi`, zero below the horizon.
    #[inline(always)]
    pub fn at(wi: Vec3x8<L>, inv_kappa: L) -> Self {
        Self::spread(wi, SpreadX8::of_lights(inv_kappa))
    }

    /// The same lights on a surface with slopes.
    #[inline(always)]
    pub fn spread(wi: Vec3x8<L>, spread: SpreadX8<L>) -> Self {
        let above = wi.z.simd_gt(L::splat(0.0)) & L::splat(1.0);
        Self { wi, spread, cosine: wi.z.at_least(0.0), above }
    }
}

/// First two moments of eight von Mises-Fisher lobes along and across their axes.
#[derive(Clone, Copy, Debug)]
pub struct LobeMomentsX8<L> {
    /// Mean of the component along the axis.
    resultant: L,
    /// Mean square of a component across the axis.
    across_sq: L,
}

impl<L: Lanes> LobeMomentsX8<L> {
    /// Moments of lobes of inverse concentration `inv_kappa`.
    #[inline(always)]
    pub fn new(inv_kappa: L) -> Self {
        let (one, three) = (L::splat(1.0), L::splat(3.0));
        let s = inv_kappa;
        // The root R of `s R (3 - R²) = 1 - R²` (Banerjee et al. 2005, Eq. 4.4), by one Newton step from a guess that
        // is exact for points and for the whole sphere.
        let guess = (one + s) / (one + s + s + three * s * s);
        let guess_sq = guess * guess;
        let residual = s * guess * (three - guess_sq) - one + guess_sq;
        let resultant = guess - residual / (three * s * (one - guess_sq) + guess + guess);
        Self::known(s, resultant)
    }

    /// Moments of lobes of inverse concentration `inv_kappa` with known [resultants](Self::resultant).
    #[inline(always)]
    pub fn known(inv_kappa: L, resultant: L) -> Self {
        Self { resultant, across_sq: resultant * inv_kappa }
    }

    /// Means of the component along the axis.
    #[inline(always)]
    pub fn resultant(&self) -> L {
        self.resultant
    }

    /// Cosines to a normal, whose cosine to the lobes' axes is `cosine`.
    #[inline(always)]
    pub fn cosines(&self, cosine: L) -> CosinesX8<L> {
        let along_sq = L::splat(1.0) - self.across_sq - self.across_sq;
        let cosine_sq = cosine * cosine;
        let mean = self.resultant * cosine;
        let mean_sq = cosine_sq * along_sq + (L::splat(1.0) - cosine_sq) * self.across_sq;
        let variance = (mean_sq - mean * mean).at_least(0.0);
        // A uniform distribution of half-width h has the variance h² / 3.
        CosinesX8 { mean, half_width: (L::splat(3.0) * variance).sqrt() }
    }
}

/// Cosines of eight lights to a normal, uniformly distributed around their mean.
#[derive(Clone, Copy, Debug)]
pub struct CosinesX8<L> {
    mean: L,
    half_width: L,
}

impl<L: Lanes> CosinesX8<L> {
    /// The mean cosine of the light above the horizon.
    ///
    /// Light below it does not count as dark: baked visibility already includes the horizon.
    #[inline(always)]
    pub fn above_horizon(&self) -> L {
        let Self { mean, half_width } = *self;
        let overlap = (mean + half_width).at_least(0.0).fast_min(half_width + half_width);
        L::splat(0.5) * overlap + (mean - half_width).at_least(0.0)
    }

    /// The share of the light above the horizon.
    #[inline(always)]
    pub fn share_above(&self) -> L {
        let width = (self.half_width + self.half_width).at_least(1e-6);
        ((self.mean + self.half_width) / width).at_least(0.0).fast_min(L::splat(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wide::f32x8;

    /// Mean of the clamped cosine, and the share above the horizon, by quadrature over the sphere.
    fn brute_force(inv_kappa: f64, cosine: f64) -> (f64, f64) {
        let sine = (1.0 - cosine * cosine).sqrt();
        let (mut weight, mut above, mut sum) = (0.0, 0.0, 0.0);
        for i in 0..2000 {
            // Heights along the axis, denser near it for narrow lobes.
            let u = (f64::from(i) + 0.5) / 2000.0;
            let t = 1.0 + inv_kappa * (u + (1.0 - u) * (-2.0 / inv_kappa).exp()).ln();
            for j in 0..200 {
                let phi = (f64::from(j) + 0.5) / 200.0 * std::f64::consts::TAU;
                let w = t * cosine + (1.0 - t * t).max(0.0).sqrt() * sine * phi.cos();
                weight += 1.0;
                above += f64::from(u8::from(w > 0.0));
                sum += w.max(0.0);
            }
        }
        (sum / weight, above / weight)
    }

    #[test]
    fn clamped_cosines_are_near_those_of_brute_force() {
        // Between a cap and the sphere, a lobe has a tail below the horizon that a uniform distribution lacks.
        for (inv_kappa, bound) in [(0.003, 0.02), (0.03, 0.02), (0.1, 0.02), (0.3, 0.026), (1.0, 0.02), (10.0, 0.02)] {
            for cosine in [-0.3, -0.05, 0.0, 0.1, 0.3, 0.6, 0.9, 1.0] {
                let (expected, share) = brute_force(inv_kappa, cosine);
                let moments = LobeMomentsX8::new(f32x8::splat(inv_kappa as f32));
                let cosines = moments.cosines(f32x8::splat(cosine as f32));
                let found_share = f64::from(cosines.share_above().to_array()[0]);
                let received = f64::from(cosines.above_horizon().to_array()[0]) * found_share;
                assert!((received - expected).abs() < bound, "{inv_kappa} {cosine}: {received}, {expected}");
                assert!((found_share - share).abs() < 0.07, "{inv_kappa} {cosine}: {found_share}, {share}");
            }
        }
        assert!(brute_force(0.3, 1.0).0 < 0.9, "negative control: the cosine of the centre is 1");
    }

    #[test]
    fn a_point_has_the_cosine_of_its_direction_and_the_sphere_a_quarter() {
        let at = |inv_kappa, cosine| {
            let cosines = LobeMomentsX8::new(f32x8::splat(inv_kappa)).cosines(f32x8::splat(cosine));
            (cosines.above_horizon().to_array()[0], cosines.share_above().to_array()[0])
        };
        assert_eq!(at(0.0, 0.25), (0.25, 1.0));
        assert_eq!(at(0.0, -0.25), (0.0, 0.0));
        let (mean, share) = at(1e4, 0.7);
        assert!((mean - 0.5).abs() < 1e-3 && (share - 0.5).abs() < 1e-3, "{mean} {share}");
    }
}
