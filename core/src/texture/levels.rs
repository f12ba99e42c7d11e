//! Levels of detail of a texture: each has half the size of the one before, down to one texel (Williams 1983).
//!
//! Levels are means of light: sRGB codes are decoded, averaged as floats from level to level, and encoded again.

use super::{
    ColorSpace, Texels, Texture,
    reduction::{level_sizes, reduced},
    slopes::{SlopeLevel, SlopeSource},
};
use crate::color::srgb_from_linear;
use std::sync::OnceLock;

/// A level: its size and its texels, encoded like the texture's if it has 8 bits; others are linear floats in Rec. 709.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Size in texels.
    pub size: [u32; 2],
    /// How its texels are read.
    pub color_space: ColorSpace,
    /// The texels, row by row from the top.
    pub texels: Texels,
}

/// The levels below a texture, built on first use. A copy builds its own, because its texels may change.
#[derive(Default)]
pub struct Levels {
    values: [OnceLock<Vec<Level>>; ColorSpace::ALL.len()],
    slopes: [OnceLock<Vec<SlopeLevel>>; SlopeSource::COUNT],
}

impl Clone for Levels {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl std::fmt::Debug for Levels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Levels")
    }
}

impl Texture {
    /// The levels below it, from half its size down to one texel, of its texels in this color space.
    pub fn levels(&self, color_space: ColorSpace) -> &[Level] {
        let color_space = self.texels.distinct(color_space);
        self.levels.values[color_space as usize].get_or_init(|| self.reduced_levels(color_space))
    }

    fn reduced_levels(&self, color_space: ColorSpace) -> Vec<Level> {
        let mut above = self.size;
        let count = self.size[0] as usize * self.size[1] as usize;
        let mut texels: Vec<[f32; 4]> = (0..count).map(|i| self.texels.at(i, color_space).to_array()).collect();
        let keeps_codes = self.texels.keeps_codes(color_space);
        let level = |size| {
            texels = reduced(&texels, above, size);
            above = size;
            match keeps_codes {
                true => {
                    let texels = texels.iter().map(|&texel| encoded(texel, color_space)).collect();
                    Level { size, color_space, texels: Texels::U8(texels) }
                }
                false => Level { size, color_space: ColorSpace::Linear, texels: Texels::F32(texels.clone()) },
            }
        };
        level_sizes(self.size).map(level).collect()
    }

    /// Slope levels below it, from half its size down to one texel, for `source`.
    pub fn slope_levels(&self, source: SlopeSource) -> &[SlopeLevel] {
        self.levels.slopes[source.index()].get_or_init(|| SlopeLevel::all_of(self, source))
    }
}

fn encoded([r, g, b, a]: [f32; 4], color_space: ColorSpace) -> [u8; 4] {
    let encode = |x: f32| if color_space == ColorSpace::Srgb { srgb_from_linear(x) } else { x };
    [encode(r), encode(g), encode(b), a].map(|x| (255.0 * x + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn texture(size: [u32; 2], texels: Texels) -> Texture {
        Texture::new("t", size, texels)
    }

    #[test]
    fn levels_of_any_size_have_the_mean_of_the_texture() {
        for size in [[8, 8], [7, 5], [1, 9], [13, 2]] {
            let texels = (0..size[0] * size[1]).map(|i| [((i * 37) % 11) as f32, i as f32, 1.0, 0.5]);
            let t = texture(size, Texels::F32(texels.collect()));
            let Texels::F32(all) = &t.texels else { unreachable!() };
            let mean = |c: usize| all.iter().map(|t| t[c]).sum::<f32>() / all.len() as f32;
            let last = t.levels(ColorSpace::Linear).last().unwrap();
            assert_eq!(last.size, [1, 1]);
            let Texels::F32(one) = &last.texels else { panic!("floats stay floats") };
            for (c, &value) in one[0].iter().enumerate() {
                assert!((value - mean(c)).abs() < 1e-4 * mean(c), "{size:?} {c}: {value} {}", mean(c));
            }
        }
    }

    #[test]
    fn srgb_levels_are_means_of_light_and_not_of_codes() {
        let t = texture([2, 1], Texels::U8(vec![[0, 0, 0, 255], [255, 255, 255, 255]]));
        let value = |space| t.levels(space)[0].texels.at(0, space).x;
        assert!((value(ColorSpace::Srgb) - 0.5).abs() < 0.005 && (value(ColorSpace::Linear) - 0.5).abs() < 0.005);
        assert_eq!(t.levels(ColorSpace::Srgb)[0].texels, Texels::U8(vec![[188, 188, 188, 255]]));
        assert_eq!(t.levels(ColorSpace::Linear)[0].texels, Texels::U8(vec![[128, 128, 128, 255]]), "another mean");
    }

    #[test]
    fn levels_of_sixteen_bits_keep_them_and_are_means_of_light_too() {
        let texels = vec![[0, 0, 0, 65535], [65535, 65535, 65535, 65535]];
        let t = texture([2, 1], Texels::U16(texels));
        let value = |space| t.levels(space)[0].texels.at(0, space).x;
        assert!((value(ColorSpace::Srgb) - 0.5).abs() < 1e-6 && (value(ColorSpace::Linear) - 0.5).abs() < 1e-6);
        let t = texture([2, 1], Texels::U16(vec![[32768, 0, 0, 0], [32800, 0, 0, 0]]));
        let mean = t.levels(ColorSpace::Linear)[0].texels.at(0, ColorSpace::Linear).x;
        assert!((mean - 32784.0 / 65535.0).abs() < 1e-6, "{mean}");
        let [srgb, linear] = [ColorSpace::Srgb, ColorSpace::Linear].map(|space| t.levels(space)[0].texels.clone());
        assert_ne!(srgb, linear, "negative control: the encoding matters");
    }

    #[test]
    fn a_chequerboard_far_away_has_the_mean_of_both_colours() {
        let texels = (0..256 * 256).map(|i| if (i / 256 + i) % 2 == 0 { [250, 20, 0, 255] } else { [0, 90, 0, 255] });
        let t = texture([256; 2], Texels::U8(texels.collect()));
        let slot = super::super::TextureSlot { color_space: ColorSpace::Srgb, ..Default::default() };
        let mean = 0.5 * (t.texel(0, 0, ColorSpace::Srgb) + t.texel(1, 0, ColorSpace::Srgb));
        for i in 0..50 {
            let uv = Vec2::new(0.013 * i as f32, 0.02 * i as f32 + 0.0013);
            let changes = [Vec2::new(0.2, 0.03), Vec2::new(-0.01, 0.07)];
            let far = t.sample_footprint(&super::super::UvFootprint { uv, changes }, &slot);
            assert!((far - mean).abs().max_element() < 0.01, "{far} {mean}");
        }
        // Negative control: without levels some lookups see only one color.
        let near = (0..50).map(|i| {
            t.sample(slot.transform(Vec2::new(0.013 * i as f32, 0.02 * i as f32 + 0.0013)), slot.color_space, slot.wrap)
        });
        let worst = near.map(|near| (near - mean).abs().max_element()).fold(0.0, f32::max);
        assert!(worst > 0.2, "{worst}");
    }
}
