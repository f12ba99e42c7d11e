//! Texels that a picture sample covers.
//!
//! The ray differentials of the sample (Igehy 1999) span a parallelogram of texture coordinates. Its ellipse has the
//! axes of `J Jᵀ`, as in EWA (Heckbert 1989). Several lookups along the long axis, each as wide as the short one,
//! approximate it (McCormack et al. 1999). Twin of `taps_of` in `shaders/materials.wgsl`.

use super::TextureSlot;
use glam::{Mat2, Vec2};

/// Largest number of lookups along the long axis. Longer ellipses are blurred across it.
pub const MOST_TAPS: u32 = 8;
/// Texels of a level per width of the footprint. With bilinear lookups in box-filtered levels, a texel as wide as the
/// footprint has three times the variance of a pixel's box; a texel of this width has the same variance.
pub const TEXELS_PER_WIDTH: f32 = 1.732_050_8;

/// Texture coordinates of a point, and their changes to the neighboring picture samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UvFootprint {
    /// The coordinates.
    pub uv: Vec2,
    /// Changes to the next sample on the right and below; zero for a point.
    pub changes: [Vec2; 2],
}

impl From<Vec2> for UvFootprint {
    fn from(uv: Vec2) -> Self {
        Self { uv, changes: [Vec2::ZERO; 2] }
    }
}

/// The lookups of a footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    /// Number of lookups.
    pub count: u32,
    /// Coordinates of the first one.
    pub first: Vec2,
    /// Step from one lookup to the next.
    pub step: Vec2,
    /// Level of detail: the levels below and above are blended by its fraction. 0 is the texture itself.
    pub level: f32,
}

impl Taps {
    fn at(uv: Vec2) -> Self {
        Self { count: 1, first: uv, step: Vec2::ZERO, level: 0.0 }
    }

    /// Coordinates of all lookups.
    pub fn positions(self) -> impl Iterator<Item = Vec2> {
        (0..self.count).map(move |i| self.first + self.step * i as f32)
    }
}

impl UvFootprint {
    /// Whether it is a single point.
    pub fn is_point(&self) -> bool {
        self.changes == [Vec2::ZERO; 2]
    }

    /// The footprint after a slot's transform.
    #[inline]
    pub fn through(&self, slot: &TextureSlot) -> Self {
        if self.is_point() {
            return slot.transform(self.uv).into();
        }
        let turn = slot.linear();
        Self { uv: slot.transform(self.uv), changes: self.changes.map(|change| turn * change) }
    }

    /// Lengths of the long and the short axis in texels of a picture of this size, and the long axis as a change of the
    /// coordinates.
    fn axes(&self, size: Vec2) -> (f32, f32, Vec2) {
        let [a, b] = self.changes.map(|change| change * size);
        let (xx, xy, yy) = (a.x * a.x + b.x * b.x, a.x * a.y + b.x * b.y, a.y * a.y + b.y * b.y);
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let root = (half * half + xy * xy).sqrt();
        let long = (mean + root).sqrt();
        let short = (a.x * b.y - a.y * b.x).abs() / long;
        // The row of `M - λ I` farther from zero is across the axis.
        let axis = if half > 0.0 { Vec2::new(half + root, xy) } else { Vec2::new(xy, root - half) };
        (long, short, axis * (long / axis.length().max(1e-20)) / size)
    }

    /// The lookups in a texture of this size. NaN gives a single lookup.
    #[inline]
    pub fn taps(&self, size: [u32; 2]) -> Taps {
        if self.is_point() {
            return Taps::at(self.uv);
        }
        let (long, short, axis) = self.axes(Vec2::new(size[0] as f32, size[1] as f32));
        if !(long > TEXELS_PER_WIDTH && long < 1e18) {
            return Taps::at(self.uv);
        }
        // No finer than texels.
        let width = short.max(TEXELS_PER_WIDTH);
        let count = (long / width + 0.5).floor().clamp(1.0, MOST_TAPS as f32);
        let step = axis / count;
        let level = (width.max(long / count) / TEXELS_PER_WIDTH).log2();
        Taps { count: count as u32, first: self.uv - step * (0.5 * (count - 1.0)), step, level }
    }
}

impl TextureSlot {
    /// The linear part of [`Self::transform`].
    pub fn linear(&self) -> Mat2 {
        let (sin, cos) = self.sin_cos();
        Mat2::from_cols(Vec2::new(cos, -sin) * self.scale.x, Vec2::new(sin, cos) * self.scale.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn footprint(a: Vec2, b: Vec2) -> UvFootprint {
        UvFootprint { uv: Vec2::new(0.3, 0.6), changes: [a, b] }
    }

    #[test]
    fn a_square_of_texels_takes_one_lookup_of_its_level_and_a_point_none_of_another_level() {
        for (texels, level) in [(4.0, 2.0), (1.0, 0.0), (64.0, 6.0)] {
            let change = texels * TEXELS_PER_WIDTH / 128.0;
            let taps = footprint(change * Vec2::X, change * Vec2::Y).taps([128; 2]);
            assert!((taps.level - level).abs() < 1e-5 && taps.count == 1, "{taps:?}");
        }
        assert_eq!(UvFootprint::from(Vec2::ONE).taps([128; 2]), Taps::at(Vec2::ONE));
        let invalid = footprint(Vec2::NAN, Vec2::X).taps([8; 2]);
        assert_eq!((invalid.count, invalid.level), (1, 0.0));
    }

    #[test]
    fn long_footprints_take_lookups_along_them_whichever_way_they_are_spanned() {
        let (long, short) = (Vec2::new(0.8, 0.6) * 0.25, Vec2::new(-0.6, 0.8) * 0.0625);
        let taps = footprint(long, short).taps([256; 2]);
        assert_eq!(taps.count, 4);
        assert!((taps.level - (16.0 / TEXELS_PER_WIDTH).log2()).abs() < 1e-4, "{taps:?}");
        assert!((taps.step - 0.25 * long).length() < 1e-5 || (taps.step + 0.25 * long).length() < 1e-5);
        let middle = taps.positions().sum::<Vec2>() / 4.0;
        assert!((middle - Vec2::new(0.3, 0.6)).length() < 1e-5);
        // Two nearly equal changes span a thin parallelogram: neither of their lengths is its width.
        let thin = footprint(long + 0.1 * short, long - 0.1 * short).taps([256; 2]);
        assert!(thin.count == 8, "{thin:?}");
    }

    #[test]
    fn a_slot_turns_and_scales_the_changes_as_it_does_the_coordinates() {
        let slot = TextureSlot { scale: Vec2::new(3.0, 0.5), rotation: 0.7, offset: Vec2::ONE, ..Default::default() };
        let there = footprint(Vec2::new(0.01, 0.02), Vec2::new(-0.03, 0.01)).through(&slot);
        let moved = slot.transform(Vec2::new(0.3, 0.6) + Vec2::new(0.01, 0.02)) - slot.transform(Vec2::new(0.3, 0.6));
        assert!((there.changes[0] - moved).length() < 1e-6);
    }
}
