//! Procedural patterns instead of pictures, filtered by the footprint of a sample.
//!
//! All patterns repeat with the unit square of a slot's coordinates, so a picture of one square is the same pattern. Noise is
//! hashed from integers, without functions that round differently between machines. Twin of `shaders/procedural.wgsl`.

use super::{Texels, Texture, UvFootprint};
use glam::{UVec2, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Kind of pattern.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Two by two squares, the lower value at the origin.
    #[default]
    Checker,
    /// Fractal value noise of [`NOISE_CELLS`] cells along a side and twice as many with each octave.
    Noise,
    /// Linear from the lower to the higher value along u.
    Gradient,
}

impl Pattern {
    /// All patterns, in the order of lists.
    pub const ALL: [Self; 3] = [Self::Checker, Self::Noise, Self::Gradient];

    /// Display name.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Checker => "Checker",
            Self::Noise => "Noise",
            Self::Gradient => "Gradient",
        }
    }
}

/// A pattern with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Procedural {
    /// Kind of pattern.
    pub pattern: Pattern,
    /// Lower value, linear; numbers read one channel.
    pub low: Vec3,
    /// Higher value.
    pub high: Vec3,
    /// Octaves of noise, 1 to [`Procedural::MOST_OCTAVES`].
    pub octaves: u32,
}

impl Default for Procedural {
    fn default() -> Self {
        Self { pattern: Pattern::Checker, low: Vec3::ZERO, high: Vec3::ONE, octaves: 4 }
    }
}

/// Cells of the first octave of noise along a side of the unit square.
pub const NOISE_CELLS: u32 = 4;
/// Smallest width of edges, in units of the pattern: differences of sums over less are noise.
const SHARPEST: f32 = 0.01;
/// Mean square slope of one octave for cells of size 1 (a test computes it).
const SLOPE_SQ: f32 = 0.186;

/// A pattern's share of the higher value within a footprint, and the mean square of its unresolved slopes.
struct Filtered {
    share: f32,
    fine_slope_sq: f32,
}

/// Mean of the wave that is -1 in the first half of each unit and 1 in the second, over a width.
fn square_wave(x: f32, width: f32) -> f32 {
    let triangle = |x: f32| (x - x.floor() - 0.5).abs();
    (triangle(x + 0.5 * width) - triangle(x - 0.5 * width)) / width
}

/// Mean of the fraction of `x` over a width.
fn saw(x: f32, width: f32) -> f32 {
    let sum = |x: f32| 0.5 * (x.floor() + (x - x.floor()) * (x - x.floor()));
    (sum(x + 0.5 * width) - sum(x - 0.5 * width)) / width
}

/// Uniform in [0, 1): the finisher of MurmurHash3 over a corner of the lattice.
fn corner(cell: UVec2, octave: u32) -> f32 {
    let mut h = cell.x.wrapping_mul(0x9e37_79b1) ^ cell.y.wrapping_mul(0x85eb_ca77) ^ octave.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    ((h ^ (h >> 16)) >> 8) as f32 / 16_777_216.0
}

/// Noise of a lattice of `cells` cells, at a point of the unit square.
fn value_noise(uv: Vec2, cells: u32, octave: u32) -> f32 {
    let p = (uv - uv.floor()) * cells as f32;
    let low = p.floor().as_uvec2() % cells;
    let high = (low + 1) % cells;
    let f = p - p.floor();
    // Quintic, for smooth slopes.
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let at = |x, y| corner(UVec2::new(x, y), octave);
    let (a, b) = (at(low.x, low.y), at(high.x, low.y));
    let (c, d) = (at(low.x, high.y), at(high.x, high.y));
    let (top, bottom) = (a + (b - a) * s.x, c + (d - c) * s.x);
    top + (bottom - top) * s.y
}

impl Procedural {
    /// Largest number of octaves: cells of 1/512.
    pub const MOST_OCTAVES: u32 = 8;
    /// Texels along a side of a rasterized pattern.
    pub const BAKED: u32 = 1024;

    /// The pattern with numbers in their ranges; the default replaces NaN.
    pub fn sanitized(self) -> Self {
        let default = Self::default();
        let value = |v: Vec3, default: Vec3| if v.abs().max_element() <= Texels::MOST { v } else { default };
        Self {
            low: value(self.low, default.low),
            high: value(self.high, default.high),
            octaves: self.octaves.clamp(1, Self::MOST_OCTAVES),
            ..self
        }
    }

    fn filtered(&self, footprint: &UvFootprint) -> Filtered {
        let UvFootprint { uv, changes: [a, b] } = *footprint;
        let uv = uv - uv.floor();
        let width = (a.abs() + b.abs()).max(Vec2::splat(SHARPEST));
        let share = match self.pattern {
            Pattern::Noise => return self.noise(uv, (0.5 * (a.length_squared() + b.length_squared())).sqrt()),
            Pattern::Checker => 0.5 - 0.5 * square_wave(uv.x, width.x) * square_wave(uv.y, width.y),
            Pattern::Gradient => saw(uv.x, width.x),
        };
        Filtered { share, fine_slope_sq: 0.0 }
    }

    /// Octaves fade with the width of the footprint in cells as the mean over a square does: the line is a fit to its regression on
    /// the value in the middle, 0.92 for half a cell, 0.74 for one, 0.38 for two.
    fn noise(&self, uv: Vec2, width: f32) -> Filtered {
        let (mut sum, mut fine, mut all) = (0.0, 0.0, 0.0);
        let (mut cells, mut weight) = (NOISE_CELLS, 1.0);
        for octave in 0..self.octaves {
            let size = cells as f32;
            let seen = (1.1 - 0.36 * width * size).clamp(0.0, 1.0);
            if seen > 0.0 {
                sum += weight * seen * (value_noise(uv, cells, octave) - 0.5);
            }
            fine += weight * weight * (1.0 - seen * seen) * (SLOPE_SQ * size * size);
            all += weight;
            (cells, weight) = (2 * cells, 0.5 * weight);
        }
        Filtered { share: 0.5 + sum / all, fine_slope_sq: fine / (all * all) }
    }

    /// Its mean value within a footprint.
    pub fn value(&self, footprint: &UvFootprint) -> Vec4 {
        (self.low + (self.high - self.low) * self.filtered(footprint).share).extend(1.0)
    }

    /// Variance along each axis of a channel's slopes that a footprint does not resolve.
    pub fn fine_slope_sq(&self, footprint: &UvFootprint, channel: usize) -> f32 {
        let height = if channel < 3 { (self.high - self.low)[channel] } else { 0.0 };
        height * height * self.filtered(footprint).fine_slope_sq
    }

    /// A picture of the unit square with `size` x `size` texels.
    pub fn baked(&self, size: u32) -> Texture {
        let texel = |i: u32| {
            let uv = (Vec2::new((i % size) as f32, (i / size) as f32) + 0.5) / size as f32;
            let changes = [Vec2::X / size as f32, Vec2::Y / size as f32];
            self.value(&UvFootprint { uv, changes }).to_array()
        };
        Texture::new(self.pattern.label(), [size; 2], Texels::F32((0..size * size).map(texel).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pattern: Pattern) -> Procedural {
        Procedural { pattern, low: Vec3::new(0.1, 0.2, 0.3), high: Vec3::new(0.9, 0.4, 0.3), octaves: 5 }
    }

    #[test]
    fn footprints_see_the_mean_of_what_is_in_them() {
        for pattern in Pattern::ALL {
            let p = of(pattern);
            let mut worst = [0.0_f32; 2];
            for (u, v, width) in [(0.3, 0.4, 0.2), (0.49, 0.1, 0.11), (0.98, 0.77, 0.3), (0.2, 0.6, 2.0)] {
                let changes = [width * Vec2::X, 0.7 * width * Vec2::Y];
                let seen = p.value(&UvFootprint { uv: Vec2::new(u, v), changes });
                let points = (0..128 * 128).map(|i| {
                    let within = Vec2::new((i % 128) as f32, (i / 128) as f32) / 128.0 - 0.5 + 0.5 / 128.0;
                    p.value(&(Vec2::new(u, v) + width * within * Vec2::new(1.0, 0.7)).into())
                });
                let mean = points.sum::<Vec4>() / (128.0 * 128.0);
                worst[0] = worst[0].max((seen - mean).abs().max_element());
                let point = p.value(&Vec2::new(u, v).into());
                worst[1] = worst[1].max((point - mean).abs().max_element());
            }
            // Octaves of noise fade as a whole, so they are only near the mean.
            let bound = if pattern == Pattern::Noise { 0.06 } else { 0.01 };
            assert!(worst[0] < bound && worst[1] > 1.4 * worst[0], "{pattern:?}: {worst:?}");
        }
    }

    #[test]
    fn patterns_repeat_and_squares_begin_with_the_lower_value() {
        let checker = of(Pattern::Checker);
        let at = |p: &Procedural, u: f32, v: f32| p.value(&Vec2::new(u, v).into()).x;
        for (u, v, expected) in [(0.2, 0.2, 0.1), (0.7, 0.2, 0.9), (0.7, 0.8, 0.1)] {
            assert!((at(&checker, u, v) - expected).abs() < 1e-5, "{u} {v}");
        }
        for pattern in Pattern::ALL {
            let p = of(pattern);
            assert!((at(&p, 0.3, 0.6) - at(&p, 1.3, -0.4)).abs() < 1e-5, "{pattern:?}");
        }
        assert!((at(&of(Pattern::Gradient), 0.25, 0.5) - 0.3).abs() < 1e-5);
    }

    #[test]
    fn slopes_of_an_octave_have_the_mean_square_that_is_told() {
        let noise = |uv| value_noise(uv, 64, 0);
        let (mut sum, step) = (0.0, 1e-4);
        for i in 0..40_000 {
            let uv = Vec2::new((i % 200) as f32 / 200.0 + 0.0013, (i / 200) as f32 / 200.0 + 0.0021);
            sum += ((noise(uv + step * Vec2::X) - noise(uv - step * Vec2::X)) / (2.0 * step * 64.0)).powi(2) / 40_000.0;
        }
        assert!((sum / SLOPE_SQ - 1.0).abs() < 0.08, "{sum}");
        let p = Procedural { octaves: 1, ..of(Pattern::Noise) };
        let far = UvFootprint { uv: Vec2::ZERO, changes: [Vec2::X, Vec2::Y] };
        let expected = 0.8 * 0.8 * SLOPE_SQ * (NOISE_CELLS * NOISE_CELLS) as f32;
        assert!((p.fine_slope_sq(&far, 0) / expected - 1.0).abs() < 1e-4);
        assert_eq!(p.fine_slope_sq(&Vec2::ZERO.into(), 0), 0.0, "from near all is seen");
    }

    #[test]
    fn files_have_names_and_bad_numbers_are_replaced() {
        let text = serde_json::to_string(&of(Pattern::Noise)).unwrap();
        assert!(text.starts_with(r#"{"pattern":"noise","low":[0.1"#), "{text}");
        assert_eq!(serde_json::from_str::<Procedural>(&text).unwrap(), of(Pattern::Noise));
        assert!(serde_json::from_str::<Procedural>(r#"{"pattern": "marble"}"#).is_err());
        let bad = Procedural { low: Vec3::NAN, octaves: 900, ..of(Pattern::Noise) }.sanitized();
        assert_eq!((bad.low, bad.octaves), (Vec3::ZERO, Procedural::MOST_OCTAVES));
    }
}
