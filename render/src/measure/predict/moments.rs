//! Bounds of a node's error from variances over its leaves (paper, Eq. 7 to 9).

use glam::Vec3;

/// Mean and variance over a node's leaves, per color channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Mean.
    pub mean: Vec3,
    /// Mean squared distance from the mean.
    pub variance: Vec3,
}

impl Moments {
    /// Moments of `values`.
    pub fn of<const N: usize>(values: [Vec3; N]) -> Self {
        let scale = 1.0 / N as f32;
        let mean = values.iter().sum::<Vec3>() * scale;
        // Squared distances rather than a difference of squares: equal values have exactly no variance.
        let variance = values.iter().map(|&v| (v - mean) * (v - mean)).sum::<Vec3>() * scale;
        Self { mean, variance }
    }

    fn deviation(&self) -> Vec3 {
        self.variance.map(f32::sqrt)
    }
}

/// A node of the merged cut.
#[derive(Clone, Copy, Debug)]
pub struct NodeMoments {
    /// Number of leaves, `|C|`.
    pub leaves: f32,
    /// Radiance of the leaves.
    pub radiance: Moments,
    /// BRDF times cosine toward the leaves.
    pub brdf: Moments,
    /// The renderer's estimate of the mean BRDF.
    pub sampled_brdf: Vec3,
    /// Mean visibility, 0 to 1.
    pub visibility: f32,
    /// Whether the mean visibility is weighted by the light, as in lit cuts. The product of radiance and visibility then has no
    /// error of its own.
    pub is_lit: bool,
}

impl NodeMoments {
    /// Standard deviation of the binary visibility with this mean.
    fn visibility_deviation(&self) -> f32 {
        (self.visibility * (1.0 - self.visibility)).max(0.0).sqrt()
    }

    /// Standard deviation of visible radiance under a light-weighted mean visibility. It assumes that leaves of equal light are
    /// hidden equally often.
    fn visible_deviation(&self) -> Vec3 {
        let (mean, v) = (self.radiance.mean, self.visibility);
        let mean_sq = mean * mean + self.radiance.variance;
        (mean_sq * v - mean * mean * (v * v)).max(Vec3::ZERO).map(f32::sqrt)
    }

    /// `|C| (<l> σv σρ + <v> σl σρ + <ρ> σl σv)`; for lit nodes `|C| σlv σρ`.
    pub fn printed(&self) -> Vec3 {
        if self.is_lit {
            return self.leaves * self.visible_deviation() * self.brdf.deviation();
        }
        let (l, rho, v) = (self.radiance.deviation(), self.brdf.deviation(), self.visibility_deviation());
        self.leaves * (self.radiance.mean * rho * v + self.brdf.mean * l * v + l * rho * self.visibility)
    }

    /// Largest contribution of the third central moment: `|C| max(<v>, 1 - <v>) σl σρ`. Lit nodes have none, but if hidden leaves
    /// are darker than visible ones, visible radiance varies at least as much as all radiance.
    pub fn third_moment(&self) -> Vec3 {
        if self.is_lit {
            let mean = self.radiance.mean;
            let mean_sq = mean * mean + self.radiance.variance;
            let most = (mean_sq - mean * mean * self.visibility.powi(2)).max(Vec3::ZERO).map(f32::sqrt);
            return self.leaves * (most - self.visible_deviation()).max(Vec3::ZERO) * self.brdf.deviation();
        }
        let farthest = self.visibility.max(1.0 - self.visibility);
        self.leaves * farthest * self.radiance.deviation() * self.brdf.deviation()
    }

    /// Error of sampling the BRDF once: `|C| <l> <v> |ρ - <ρ>|`.
    pub fn sampling(&self) -> Vec3 {
        self.leaves * self.visibility * self.radiance.mean * (self.sampled_brdf - self.brdf.mean).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node's moments, and the difference of `|C| <l> <ρ> <v>` from the sum of products.
    fn node<const N: usize>(l: [f32; N], rho: [f32; N], v: [bool; N]) -> (NodeMoments, f32) {
        let moments = |values: [f32; N]| Moments::of(values.map(Vec3::splat));
        let v = v.map(|v| f32::from(u8::from(v)));
        let node = NodeMoments {
            leaves: N as f32,
            radiance: moments(l),
            brdf: moments(rho),
            sampled_brdf: moments(rho).mean,
            visibility: v.iter().sum::<f32>() / N as f32,
            is_lit: false,
        };
        let sum: f64 = (0..N).map(|i| f64::from(l[i]) * f64::from(rho[i]) * f64::from(v[i])).sum();
        let product = f64::from(node.leaves * node.visibility) * f64::from(node.radiance.mean.x * node.brdf.mean.x);
        (node, (sum - product).abs() as f32)
    }

    fn bound(node: &NodeMoments) -> f32 {
        (node.printed() + node.third_moment()).x
    }

    #[test]
    fn two_leaves_have_the_covariance_of_their_differences() {
        // For a constant BRDF the bound is exact: |C| <ρ> |cov(l, v)| with cov = (l1 - l0)(v1 - v0) / 4.
        let (node, error) = node([1.0, 3.0], [0.5, 0.5], [false, true]);
        assert!((error - 2.0 * 0.5 * 0.5).abs() < 1e-6, "{error}");
        assert!((node.printed().x - error).abs() < 1e-6 && node.third_moment().x == 0.0);
        assert!(0.5 * node.printed().x < error, "negative control: half of the bound is too little");
        let (node, error) = self::node([1.0, 3.0], [0.2, 0.6], [true, true]);
        assert!((error - 2.0 * 0.2).abs() < 1e-6, "cov(l, ρ) = 2 · 0.4 / 4, {error}");
        assert!((node.printed().x - error).abs() < 1e-6);
        let (node, error) = self::node([2.0, 2.0], [0.2, 0.6], [false, true]);
        assert!((node.printed().x - error).abs() < 1e-6 && (error - 2.0 * 2.0 * 0.1).abs() < 1e-6, "{error}");
    }

    #[test]
    fn constant_factors_leave_no_error() {
        for (l, rho, v) in
            [([2.0; 4], [0.3; 4], [true, false, true, true]), ([2.0; 4], [0.1, 0.2, 0.3, 0.4], [true; 4])]
        {
            let (node, error) = node(l, rho, v);
            assert!(error < 1e-6 && bound(&node) == 0.0, "{error} {}", bound(&node));
        }
        let (node, _) = node([1.0, 2.0, 2.0, 1.0], [0.3; 4], [true, false, true, true]);
        assert!(bound(&node) > 0.0, "negative control");
    }

    #[test]
    fn no_random_node_errs_by_more_and_some_by_more_than_half() {
        let mut rng = fastrand::Rng::with_seed(11);
        let (mut beyond_half, mut beyond_print) = (0, 0);
        for _ in 0..20_000 {
            // Powers create rare bright leaves, which cause the largest errors.
            let power = 1 + rng.i32(0..8);
            let l = std::array::from_fn::<f32, 4, _>(|_| rng.f32().powi(power));
            let rho = std::array::from_fn(|_| rng.f32().powi(power));
            let seen = rng.f32();
            let (node, error) = node(l, rho, std::array::from_fn(|_| rng.f32() < seen));
            assert!(error <= bound(&node) * (1.0 + 1e-4) + 1e-6, "{error} beyond {}", bound(&node));
            beyond_half += usize::from(error > 0.5 * bound(&node) + 1e-6);
            beyond_print += usize::from(error > node.printed().x * (1.0 + 1e-4) + 1e-6);
        }
        assert!(beyond_half > 100, "negative control: half of the bound holds for all but {beyond_half}");
        assert!(beyond_print > 0, "the paper's terms are an approximation, not a bound");
    }

    #[test]
    fn sampling_once_errs_by_what_the_sample_is_off() {
        let (mut node, _) = node([2.0, 2.0], [0.2, 0.6], [true, true]);
        assert_eq!(node.sampling().x, 0.0);
        node.sampled_brdf = Vec3::splat(0.7);
        assert!((node.sampling().x - 2.0 * 2.0 * 0.3).abs() < 1e-6);
    }
}
