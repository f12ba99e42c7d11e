//! Slopes of normal and bump maps with second moments. A footprint then has a mean normal and the spread of normals
//! around it (Olano and Baker 2010, *LEAN Mapping*).
//!
//! A texel of a level holds the mean slope and the covariance below it; the lookup computes second moments. Unlike sums
//! of squares, covariances can be rounded, to the upper 16 bits of floats. The texture itself is the lowest level. It
//! is taken as smooth between its texels, so a map seen from near adds no roughness. Twin of `shaders/bumps.wgsl`.

use super::{
    Channel, ColorSpace, Procedural, Quad, Taps, Texture, TextureSlot, UvFootprint, Wrap,
    reduction::{for_each_covered, level_sizes},
};
use glam::{Mat2, Vec2, Vec3, Vec4Swizzles};

/// Steepest slope in a level, to keep sums of squares finite.
const STEEPEST: f32 = 1e4;
/// Half the distance of two lookups in a pattern for its slope, in units of the pattern.
const PATTERN_STEP: f32 = 1e-3;
/// Smallest z of a texel's unit normal: 83 degrees.
const LEAST_Z: f32 = 0.125;

/// Source of a texture's slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlopeSource {
    /// Texels are tangent-space normals; the slopes are their x and y for a z of 1.
    Normals,
    /// A channel of the texels holds heights; the slopes are its changes per texel.
    Heights {
        /// The channel.
        channel: Channel,
        /// Whether the picture follows itself along u and v; else the heights at its edges go on.
        repeats: [bool; 2],
    },
}

impl SlopeSource {
    /// Number of sources.
    pub const COUNT: usize = 17;

    /// The heights of a bump map.
    pub fn heights(slot: &TextureSlot) -> Self {
        Self::Heights { channel: slot.channel, repeats: slot.wrap.map(|wrap| wrap == Wrap::Repeat) }
    }

    /// Index among the sources.
    pub fn index(self) -> usize {
        match self {
            Self::Normals => 0,
            Self::Heights { channel, repeats: [u, v] } => {
                1 + channel as usize + 4 * usize::from(u) + 8 * usize::from(v)
            }
        }
    }
}

/// Mean and covariance of slopes, floats whose lower 16 bits are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopeTexel {
    /// Mean along x and y.
    pub mean: Vec2,
    /// Covariance: xx, xy, yy.
    pub covariance: [f32; 3],
}

/// A level below a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct SlopeLevel {
    /// Size in texels.
    pub size: [u32; 2],
    /// The texels, row by row from the top.
    pub texels: Vec<SlopeTexel>,
}

/// First and second moments of slopes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopeMoments {
    /// Mean.
    pub mean: Vec2,
    /// Means of the products: xx, xy, yy.
    pub second: [f32; 3],
}

impl SlopeMoments {
    /// Moments of one slope.
    pub fn of(slope: Vec2) -> Self {
        Self { mean: slope, second: [slope.x * slope.x, slope.x * slope.y, slope.y * slope.y] }
    }

    /// Moments of slopes after a linear map.
    pub fn mapped(&self, by: Mat2) -> Self {
        Self { mean: by * self.mean, second: covariance_mapped(self.second, by) }
    }

    /// Adds other moments with a weight.
    fn add(&mut self, weight: f32, other: &Self) {
        self.mean += weight * other.mean;
        self.second.iter_mut().zip(other.second).for_each(|(sum, second)| *sum += weight * second);
    }

    /// Covariance: xx, xy, yy.
    pub fn covariance(&self) -> [f32; 3] {
        let [xx, xy, yy] = Self::of(self.mean).second;
        [(self.second[0] - xx).max(0.0), self.second[1] - xy, (self.second[2] - yy).max(0.0)]
    }
}

/// `B M Bᵀ` for a symmetric M given as xx, xy, yy.
pub fn covariance_mapped([xx, xy, yy]: [f32; 3], by: Mat2) -> [f32; 3] {
    let (x, y) = (by.row(0), by.row(1));
    let product = |a: Vec2, b: Vec2| xx * a.x * b.x + xy * (a.x * b.y + a.y * b.x) + yy * a.y * b.y;
    [product(x, x), product(x, y), product(y, y)]
}

impl SlopeTexel {
    fn moments(&self) -> SlopeMoments {
        let mut moments = SlopeMoments::of(self.mean);
        moments.second.iter_mut().zip(self.covariance).for_each(|(second, own)| *second += own);
        moments
    }

    fn mean_of(all: &[Self], covered: &[(usize, f32)]) -> Self {
        let mean: Vec2 = covered.iter().map(|&(i, weight)| weight * all[i].mean).sum();
        let mut covariance = [0.0; 3];
        for &(i, weight) in covered {
            let between = SlopeMoments::of(all[i].mean - mean).second;
            covariance.iter_mut().zip(all[i].covariance).zip(between).for_each(|((c, a), b)| *c += weight * (a + b));
        }
        Self { mean, covariance }
    }

    fn rounded(self) -> Self {
        let round = |x: f32| f32::from_bits((x.to_bits() + 0x8000) & 0xffff_0000);
        let mean = self.mean.clamp(Vec2::splat(-STEEPEST), Vec2::splat(STEEPEST));
        Self {
            mean: Vec2::new(round(mean.x), round(mean.y)),
            covariance: self.covariance.map(|c| round(c.clamp(-STEEPEST * STEEPEST, STEEPEST * STEEPEST))),
        }
    }

    /// Three words of two numbers each.
    pub fn words(&self) -> [u32; 3] {
        let pair = |a: f32, b: f32| a.to_bits() >> 16 | b.to_bits();
        let [xx, xy, yy] = self.covariance;
        [pair(self.mean.x, self.mean.y), pair(xx, yy), pair(xy, 0.0)]
    }
}

/// The texels before and after one of a row. Mirrored and held edges go on with the texel at the edge.
fn neighbors(at: usize, size: usize, repeats: bool) -> [usize; 2] {
    match repeats {
        true => [(at + size - 1) % size, (at + 1) % size],
        false => [at.saturating_sub(1), (at + 1).min(size - 1)],
    }
}

/// The slope of an unnormalized tangent-space normal.
pub fn slope_of(normal: Vec3) -> Vec2 {
    normal.truncate() / normal.z.max(LEAST_Z * normal.length()).max(1e-6)
}

impl SlopeLevel {
    /// All levels below a texture, down to one texel.
    pub(super) fn all_of(texture: &Texture, source: SlopeSource) -> Vec<Self> {
        let [width, height] = texture.size.map(|n| n as usize);
        let slope = |x: usize, y: usize| match source {
            SlopeSource::Normals => {
                let texel = texture.texels.at(y * width + x, ColorSpace::Linear).xyz();
                slope_of(2.0 * texel - 1.0)
            }
            SlopeSource::Heights { channel, repeats } => {
                let at = |x: usize, y: usize| texture.texels.at(y * width + x, ColorSpace::Linear)[channel as usize];
                let [[left, right], [above, below]] =
                    [neighbors(x, width, repeats[0]), neighbors(y, height, repeats[1])];
                0.5 * Vec2::new(at(right, y) - at(left, y), at(x, below) - at(x, above))
            }
        };
        let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let one = |(x, y)| SlopeTexel { mean: slope(x, y), covariance: [0.0; 3] };
        let mut above: Vec<SlopeTexel> = positions.map(one).collect();
        let mut size = texture.size;
        let level = |next| {
            let mut texels = Vec::new();
            for_each_covered(size, next, |covered| texels.push(SlopeTexel::mean_of(&above, covered)));
            (above, size) = (texels, next);
            Self { size, texels: above.iter().map(|texel| texel.rounded()).collect() }
        };
        level_sizes(texture.size).map(level).collect()
    }

    fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> SlopeMoments {
        let quad = Quad::around(self.size, uv, wrap);
        let mut moments = SlopeMoments::default();
        for (index, weight) in quad.indices.into_iter().zip(quad.weights()) {
            moments.add(weight, &self.texels[index].moments());
        }
        moments
    }
}

impl Texture {
    /// Slopes within taps: `finest` gives the texture's slopes at a point, `units` converts levels to the same units there.
    fn slope_moments(
        &self,
        taps: Taps,
        (source, wrap): (SlopeSource, [Wrap; 2]),
        units: impl Fn(Vec2) -> Mat2,
        finest: impl Fn(Vec2) -> Vec2,
    ) -> SlopeMoments {
        let levels = self.slope_levels(source);
        let level = taps.level.min(levels.len() as f32);
        let (finer, blend) = (level as usize, level.fract());
        let at = |level: usize, uv| match level.checked_sub(1) {
            None => SlopeMoments::of(finest(uv)),
            Some(below) => levels[below].bilinear(uv, wrap).mapped(units(uv)),
        };
        let mut sum = SlopeMoments::default();
        let share = 1.0 / taps.count as f32;
        for uv in taps.positions() {
            sum.add(share * (1.0 - blend), &at(finer, uv));
            if blend > 0.0 {
                sum.add(share * blend, &at(finer + 1, uv));
            }
        }
        sum
    }

    /// Slopes of a normal map within a footprint: x and y of the tangent-space normal for a z of 1, with the slot's
    /// strength, turned and mirrored as the slot places the picture. `None` for a footprint of one point: use
    /// [`TextureSlot::tangent_normal`].
    pub fn normal_moments(&self, footprint: &UvFootprint, slot: &TextureSlot) -> Option<SlopeMoments> {
        let taps = footprint.through(slot).taps(self.size);
        if taps.level <= 0.0 && taps.count == 1 {
            return None;
        }
        let at = |uv| slope_of(2.0 * self.sample(uv, ColorSpace::Linear, slot.wrap).xyz() - 1.0);
        let moments = self.slope_moments(taps, (SlopeSource::Normals, slot.wrap), |_| Mat2::IDENTITY, at);
        Some(moments.mapped(slot.normal_axes()))
    }

    /// Changes of a bump map's height in meters per unit of u and v within a footprint; at a point by central
    /// differences over one texel.
    pub fn height_moments(&self, footprint: &UvFootprint, slot: &TextureSlot) -> SlopeMoments {
        let there = footprint.through(slot);
        let taps = there.taps(self.size);
        let size = Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let turn = slot.linear();
        let texel = size * slot.scale;
        let steps = [1.0 / texel.x.abs().max(1e-6), 1.0 / texel.y.abs().max(1e-6)];
        let height = |uv: Vec2| self.sample(uv, ColorSpace::Linear, slot.wrap)[slot.channel as usize];
        let slope = |uv: Vec2, step: f32, along: Vec2| {
            slot.strength * (height(uv + step * along) - height(uv - step * along)) / (2.0 * step)
        };
        let at = |uv| Vec2::new(slope(uv, steps[0], turn.x_axis), slope(uv, steps[1], turn.y_axis));
        if taps.level <= 0.0 && taps.count == 1 {
            return SlopeMoments::of(at(taps.first));
        }
        // A mirrored picture falls where the picture rises.
        let [wrap_u, wrap_v] = slot.wrap;
        let rising = |uv: Vec2| Vec2::new(wrap_u.slope(uv.x), wrap_v.slope(uv.y));
        let units = |uv: Vec2| slot.strength * turn.transpose() * Mat2::from_diagonal(size * rising(uv));
        self.slope_moments(taps, (SlopeSource::heights(slot), slot.wrap), units, at)
    }
}

impl TextureSlot {
    /// Changes of the height of a pattern in meters per unit of u and v within a footprint.
    pub fn pattern_moments(&self, pattern: &Procedural, footprint: &UvFootprint) -> SlopeMoments {
        let there = footprint.through(self);
        let turn = self.linear();
        let slope = |along: Vec2| {
            let step = PATTERN_STEP / along.length().max(1e-6);
            let at = |uv| pattern.value(&UvFootprint { uv, ..there })[self.channel as usize];
            self.strength * (at(there.uv + step * along) - at(there.uv - step * along)) / (2.0 * step)
        };
        let mut moments = SlopeMoments::of(Vec2::new(slope(turn.x_axis), slope(turn.y_axis)));
        let fine = self.strength * self.strength * pattern.fine_slope_sq(&there, self.channel as usize);
        let fine = covariance_mapped([fine, 0.0, fine], turn.transpose());
        moments.second.iter_mut().zip(fine).for_each(|(second, fine)| *second += fine);
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{TEXELS_PER_WIDTH, Texels};
    use std::f32::consts::PI;

    fn noise(i: u32) -> f32 {
        (i.wrapping_mul(0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32
    }

    fn normals(size: u32) -> Texture {
        let texel = |i| [0.3 + 0.4 * noise(3 * i), 0.4 + 0.2 * noise(3 * i + 1), 0.95, 1.0];
        Texture::new("normals", [size; 2], Texels::F32((0..size * size).map(texel).collect()))
    }

    #[test]
    fn heights_fall_where_the_picture_is_mirrored_and_are_level_beyond_an_edge_that_is_held() {
        let ramp = |i: u32| [(i % 64) as f32 / 64.0, 0.0, 0.0, 1.0];
        let texture = Texture::new("ramp", [64; 2], Texels::F32((0..64 * 64).map(ramp).collect()));
        for change in [0.0, 0.1] {
            let slope = |wrap, u| {
                let slot = TextureSlot { wrap: [wrap, Wrap::Repeat], ..Default::default() };
                let changes = [change * Vec2::X, change * Vec2::Y];
                texture.height_moments(&UvFootprint { uv: Vec2::new(u, 0.5), changes }, &slot).mean.x
            };
            for (wrap, expected) in
                [(Wrap::Repeat, [1.0, 1.0, 1.0]), (Wrap::Mirror, [1.0, -1.0, -1.0]), (Wrap::Clamp, [1.0, 0.0, 0.0])]
            {
                let found = [0.5, 1.5, -0.5].map(|u| slope(wrap, u));
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02), "{wrap:?} {change}: {found:?}");
            }
        }
    }

    #[test]
    fn the_last_level_has_mean_and_covariance_of_all_texels() {
        let t = normals(12);
        let Texels::F32(texels) = &t.texels else { unreachable!() };
        let slopes: Vec<Vec2> = texels.iter().map(|&[x, y, z, _]| slope_of(2.0 * Vec3::new(x, y, z) - 1.0)).collect();
        let mean = slopes.iter().sum::<Vec2>() / slopes.len() as f32;
        let xy = slopes.iter().map(|s| (s.x - mean.x) * (s.y - mean.y)).sum::<f32>() / slopes.len() as f32;
        let xx = slopes.iter().map(|s| (s.x - mean.x).powi(2)).sum::<f32>() / slopes.len() as f32;
        let last = t.slope_levels(SlopeSource::Normals).last().unwrap().texels[0];
        assert!((last.mean - mean).length() < 4e-3 && (last.covariance[0] - xx).abs() < 4e-3 * xx);
        assert!((last.covariance[1] - xy).abs() < 2e-4 && xx > 0.01);
        let all = UvFootprint { uv: Vec2::ZERO, changes: [64.0 * Vec2::X, 64.0 * Vec2::Y] };
        let strong = TextureSlot { strength: 2.0, flip_y: true, ..Default::default() };
        let seen = t.normal_moments(&all, &strong).unwrap();
        assert!((seen.mean - mean * Vec2::new(2.0, -2.0)).length() < 8e-3);
        assert!((seen.covariance()[0] / xx - 4.0).abs() < 0.02, "the variance grows with the square of the strength");
        let point = UvFootprint::from(Vec2::new(0.1, 0.2));
        assert!(t.normal_moments(&point, &strong).is_none());
    }

    /// Mean and covariance of the slopes of the normals that texels encode through a slot.
    fn moments_of_texels(texels: &[Vec3], slot: &TextureSlot) -> SlopeMoments {
        let mut moments = SlopeMoments::default();
        for &texel in texels {
            moments.add(1.0 / texels.len() as f32, &SlopeMoments::of(slope_of(slot.tangent_normal(texel))));
        }
        moments
    }

    fn differ(a: &SlopeMoments, b: &SlopeMoments) -> bool {
        let (a_spread, b_spread) = (a.covariance(), b.covariance());
        let spread = b_spread[0].max(b_spread[2]);
        (a.mean - b.mean).length() > 0.01 * b.mean.length()
            || a_spread.iter().zip(b_spread).any(|(a, b)| (a - b).abs() > 0.03 * spread)
    }

    #[test]
    fn turned_levels_are_the_mean_of_the_turned_texels() {
        // Normals that lean to the lower right, more spread along x.
        let texel = |i: u32| Vec3::new(0.55 + 0.25 * noise(2 * i), 0.3 + 0.1 * noise(2 * i + 1), 0.95);
        let texels: Vec<Vec3> = (0..64).map(texel).collect();
        let stored = texels.iter().map(|t| t.extend(1.0).to_array()).collect();
        let t = Texture::new("leaning", [8; 2], Texels::F32(stored));
        let upright = TextureSlot { offset: Vec2::new(0.25, -0.125), strength: 0.7, ..Default::default() };
        for (rotation, scale, flip_y) in [
            (0.5 * PI, Vec2::ONE, false),
            (PI, Vec2::ONE, false),
            (0.7, Vec2::new(3.0, 0.4), false),
            (0.0, Vec2::new(-1.0, 1.0), false),
            (-2.2, Vec2::new(0.5, -2.0), true),
        ] {
            let slot = TextureSlot { rotation, scale, flip_y, ..upright.clone() };
            // One texel of the level: a square of 2 or 8 texels from the second row and column of such squares.
            for side in [2, 8] {
                let first = if side == 2 { 2 } else { 0 };
                let rows = (first..first + side).flat_map(|y| (first..first + side).map(move |x| 8 * y + x));
                let covered: Vec<Vec3> = rows.map(|i| texels[i]).collect();
                let back = slot.linear().inverse();
                let center = Vec2::splat((first as f32 + 0.5 * side as f32) / 8.0);
                let width = side as f32 / 8.0 * TEXELS_PER_WIDTH;
                let footprint = UvFootprint {
                    uv: back * (center - slot.offset),
                    changes: [back * (width * Vec2::X), back * (width * Vec2::Y)],
                };
                let seen = t.normal_moments(&footprint, &slot).unwrap();
                let expected = moments_of_texels(&covered, &slot);
                assert!(!differ(&seen, &expected), "{slot:?} {side}: {seen:?} {expected:?}");
                let unturned = moments_of_texels(&covered, &upright);
                assert!(differ(&seen, &unturned), "negative control, {slot:?} {side}: {seen:?}");
            }
        }
    }

    #[test]
    fn a_plane_of_heights_has_the_same_slope_at_all_levels_and_no_variance() {
        // A repeating slope has a step; far from it the levels are unaffected.
        let texel = |i: u32| [0.01 * (i % 64) as f32 + 0.03 * (i / 64) as f32; 4];
        let t = Texture::new("plane", [64; 2], Texels::F32((0..64 * 64).map(texel).collect()));
        for rotation in [0.0, 0.8] {
            let slot = TextureSlot { scale: Vec2::new(0.5, 1.0), rotation, strength: 0.25, ..Default::default() };
            let uv = slot.linear().inverse() * Vec2::splat(0.5);
            let near = t.height_moments(&uv.into(), &slot);
            let far = UvFootprint { uv, changes: [0.1 * Vec2::X, 0.05 * Vec2::Y] };
            let taps = far.through(&slot).taps(t.size);
            assert!(taps.level > 0.5, "{taps:?}");
            let far = t.height_moments(&far, &slot);
            assert!((far.mean - near.mean).length() < 8e-3 * near.mean.length(), "{near:?} {far:?}");
            assert!(far.covariance()[0] < 1e-4 && near.mean.length() > 0.1);
        }
    }

    #[test]
    fn words_hold_what_a_texel_holds() {
        let texel = SlopeTexel { mean: Vec2::new(0.3, -7.0), covariance: [0.02, -0.01, 1e12] }.rounded();
        let half = |bits: u32| f32::from_bits(bits << 16);
        let [mean, variances, product] = texel.words();
        assert_eq!(Vec2::new(half(mean), half(mean >> 16)), texel.mean);
        assert_eq!([half(variances), half(product), half(variances >> 16)], texel.covariance);
        assert!(
            (texel.covariance[2] / (STEEPEST * STEEPEST) - 1.0).abs() < 0.004
                && (texel.mean.x / 0.3 - 1.0).abs() < 0.004
        );
    }
}
