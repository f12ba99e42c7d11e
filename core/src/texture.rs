//! Textures: the encoded file, its decoded texels, and lookup: bilinear at a point, over levels of detail within the
//! footprint of a sample.

mod color_space;
mod footprint;
mod levels;
mod procedural;
mod reduction;
mod slopes;
mod wrap;

pub use color_space::ColorSpace;
pub use footprint::{MOST_TAPS, TEXELS_PER_WIDTH, Taps, UvFootprint};
pub use levels::{Level, Levels};
pub use procedural::{NOISE_CELLS, Pattern, Procedural};
pub use reduction::level_sizes;
pub use slopes::{SlopeLevel, SlopeMoments, SlopeSource, SlopeTexel, covariance_mapped};
pub use wrap::Wrap;

use crate::color::{LARGEST_HALF, in_rec_709, linear_from_codes, linear_from_deep_codes};
use glam::{Mat2, Mat3, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The component that a scalar parameter reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Channel {
    /// Red.
    #[default]
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

/// The texture coordinates of a surface that a map uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UvSet {
    /// `TEXCOORD_0` of glTF; the only set of most meshes.
    #[default]
    First,
    /// `TEXCOORD_1` of glTF; the first set in meshes that have no second.
    Second,
}

/// A texture in use: its index, its decoding, and its transform on the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TextureSlot {
    /// Index into the scene's textures.
    pub texture: u32,
    /// How its texels are read.
    pub color_space: ColorSpace,
    /// Component for scalar parameters; colors and normals read RGB.
    pub channel: Channel,
    /// Repetitions across the unit square of texture coordinates; at most [`TextureSlot::MOST`].
    pub scale: Vec2,
    /// Added after scaling and rotating; at most [`TextureSlot::MOST`].
    pub offset: Vec2,
    /// Counter-clockwise rotation of the coordinates in radians, before the offset (KHR_texture_transform); at most
    /// [`TextureSlot::MOST`]. Normals turn with it.
    pub rotation: f32,
    /// Scales normals and heights; at most [`TextureSlot::MOST`]. 1 leaves other maps unchanged.
    pub strength: f32,
    /// Normals have their green channel down (DirectX) instead of up (OpenGL).
    pub flip_y: bool,
    /// A pattern instead of a texture; the index is then ignored.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub procedural: Option<Procedural>,
    /// Along u and v, for pictures; patterns repeat.
    #[serde(skip_serializing_if = "is_default")]
    pub wrap: [Wrap; 2],
    /// The coordinates that are transformed.
    #[serde(skip_serializing_if = "is_default")]
    pub uv_set: UvSet,
}

/// Whether a setting need not be written.
pub fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Default for TextureSlot {
    fn default() -> Self {
        Self {
            texture: 0,
            color_space: ColorSpace::Linear,
            channel: Channel::R,
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            rotation: 0.0,
            strength: 1.0,
            flip_y: false,
            procedural: None,
            wrap: Default::default(),
            uv_set: UvSet::First,
        }
    }
}

impl TextureSlot {
    /// Index of its texture; `None` for a pattern.
    pub fn image(&self) -> Option<usize> {
        self.procedural.is_none().then_some(self.texture as usize)
    }

    /// Largest magnitude of its numbers: larger ones have no precision left for texels, and overflow eventually.
    pub const MOST: f32 = 1e6;

    /// The slot with defaults for numbers that are out of range.
    pub fn sanitized(self) -> Self {
        let default = Self::default();
        let number = |x: f32, default: f32| if x.abs() <= Self::MOST { x } else { default };
        let pair = |p: Vec2, default: Vec2| Vec2::new(number(p.x, default.x), number(p.y, default.y));
        Self {
            scale: pair(self.scale, default.scale),
            offset: pair(self.offset, default.offset),
            rotation: number(self.rotation, default.rotation),
            strength: number(self.strength, default.strength),
            procedural: self.procedural.map(Procedural::sanitized),
            ..self
        }
    }

    /// Texture coordinates after this slot's transform.
    #[inline]
    pub fn transform(&self, uv: Vec2) -> Vec2 {
        let (sin, cos) = self.sin_cos();
        let s = uv * self.scale;
        Vec2::new(cos * s.x + sin * s.y, -sin * s.x + cos * s.y) + self.offset
    }

    /// Sine and cosine of the rotation.
    #[inline]
    fn sin_cos(&self) -> (f32, f32) {
        // Few textures are rotated, and the functions of the angle cost more than the lookup.
        if self.rotation == 0.0 { (0.0, 1.0) } else { self.rotation.sin_cos() }
    }

    /// The picture's axes on the surface: what one unit of a normal's x and y in the picture adds along the tangent (of
    /// growing u) and the bitangent (of falling v). Includes strength and `flip_y`.
    ///
    /// The mesh's tangents belong to its own texture coordinates, as in glTF. The picture lies on them as
    /// [`Self::transform`] places it, so its normals turn with the rotation and are mirrored by negative scales. The
    /// size of the scale does not count: a normal map holds slopes of the surface, and repeating it makes it no steeper.
    /// The axes therefore stay perpendicular under scales that differ, where those of the picture are skewed. The matrix
    /// is [`Self::linear`] transposed, with v upward and the scale reduced to its signs.
    pub fn normal_axes(&self) -> Mat2 {
        let (sin, cos) = self.sin_cos();
        let sign = |x: f32| if x < 0.0 { -1.0 } else { 1.0 };
        let mirror = Vec2::new(sign(self.scale.x), sign(self.scale.y));
        let green = if self.flip_y { -self.strength } else { self.strength };
        Mat2::from_cols(self.strength * mirror * Vec2::new(cos, -sin), green * mirror * Vec2::new(sin, cos))
    }

    /// The tangent-space normal, not normalized, that a texel of a normal map encodes, see [`Self::normal_axes`].
    pub fn tangent_normal(&self, texel: Vec3) -> Vec3 {
        let n = 2.0 * texel - 1.0;
        (self.normal_axes() * n.truncate()).extend(n.z)
    }
}

/// Decoded texels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8 bits per component, as in png, jpg, webp and tga.
    U8(Vec<[u8; 4]>),
    /// 16 bits per component, as in png and tif of 16 bits.
    U16(Vec<[u16; 4]>),
    /// Floating point, as in hdr and exr. Texels of a scene are at most [`Texels::MOST`].
    F32(Vec<[f32; 4]>),
    /// Floating point in other primaries than those of Rec. 709. Only colors are converted: values have no primaries.
    Wide {
        /// The texels as in the file; those of a scene are at most [`Texels::MOST`].
        texels: Vec<[f32; 4]>,
        /// From the file's primaries to linear Rec. 709.
        to_rec_709: Mat3,
    },
}

impl Texels {
    /// The texel at an index, in linear values.
    #[inline]
    pub fn at(&self, index: usize, color_space: ColorSpace) -> Vec4 {
        match (self, color_space) {
            (Self::F32(t), ColorSpace::Srgb) => Vec4::from_array(t[index]),
            (Self::U8(t), ColorSpace::Srgb) => {
                let [r, g, b, a] = t[index];
                linear_from_codes([r, g, b]).extend(f32::from(a) / 255.0)
            }
            (Self::U16(t), ColorSpace::Srgb) => {
                let [r, g, b, a] = t[index];
                linear_from_deep_codes([r, g, b]).extend(f32::from(a) / 65_535.0)
            }
            (Self::Wide { to_rec_709, .. }, ColorSpace::Srgb) => converted(*to_rec_709, self.value(index)),
            (_, ColorSpace::Linear) => self.value(index),
            (_, other) => match other.to_rec_709() {
                Some(to_rec_709) => converted(to_rec_709, self.value(index)),
                None => self.value(index),
            },
        }
    }

    /// The texel at an index as it is; codes from 0 to 1.
    #[inline]
    fn value(&self, index: usize) -> Vec4 {
        match self {
            Self::F32(t) | Self::Wide { texels: t, .. } => Vec4::from_array(t[index]),
            Self::U8(t) => Vec4::from_array(t[index].map(|c| f32::from(c) / 255.0)),
            Self::U16(t) => Vec4::from_array(t[index].map(|c| f32::from(c) / 65_535.0)),
        }
    }

    /// Whether texels that are read in this color space stay codes of 8 bits on the device and in levels; all others
    /// become floats.
    pub fn keeps_codes(&self, color_space: ColorSpace) -> bool {
        matches!((self, color_space), (Self::U8(_), ColorSpace::Srgb | ColorSpace::Linear))
    }

    /// The color space in which its levels are kept: floats are the same as colors and as values.
    pub fn distinct(&self, color_space: ColorSpace) -> ColorSpace {
        match (self, color_space) {
            (Self::F32(_), ColorSpace::Srgb) => ColorSpace::Linear,
            _ => color_space,
        }
    }

    /// Bilinear lookup in the texels of a picture of this size.
    fn bilinear(&self, size: [u32; 2], uv: Vec2, color_space: ColorSpace, wrap: [Wrap; 2]) -> Vec4 {
        let Quad { indices: [a, b, c, d], blend } = Quad::around(size, uv, wrap);
        let texel = |index| self.at(index, color_space);
        texel(a).lerp(texel(b), blend.x).lerp(texel(c).lerp(texel(d), blend.x), blend.y)
    }

    /// The number of texels.
    pub fn count(&self) -> usize {
        match self {
            Self::U8(texels) => texels.len(),
            Self::U16(texels) => texels.len(),
            Self::F32(texels) | Self::Wide { texels, .. } => texels.len(),
        }
    }

    /// The largest number of a texel.
    pub const MOST: f32 = LARGEST_HALF;

    /// Replaces NaN by 0 and clamps the others to [`Self::MOST`]. Returns the number of changed texels.
    pub fn sanitize(&mut self) -> usize {
        let (Self::F32(texels) | Self::Wide { texels, .. }) = self else { return 0 };
        let is_wrong = |texel: &&mut [f32; 4]| !texel.iter().all(|x| x.abs() <= Self::MOST);
        let repair = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(-Self::MOST, Self::MOST) };
        texels.iter_mut().filter(is_wrong).map(|texel| *texel = texel.map(repair)).count()
    }
}

/// A texel with its color in Rec. 709.
fn converted(to_rec_709: Mat3, texel: Vec4) -> Vec4 {
    in_rec_709(to_rec_709, texel.truncate()).extend(texel.w)
}

/// The four texels around a point.
struct Quad {
    /// Top left, top right, bottom left, bottom right.
    indices: [usize; 4],
    /// Weights of the right and of the bottom texels.
    blend: Vec2,
}

impl Quad {
    fn around(size: [u32; 2], uv: Vec2, wrap: [Wrap; 2]) -> Self {
        let ([left, right], across) = wrap[0].neighbors(uv.x, size[0]);
        let ([above, below], down) = wrap[1].neighbors(uv.y, size[1]);
        let width = size[0] as usize;
        let indices = [above * width + left, above * width + right, below * width + left, below * width + right];
        Self { indices, blend: Vec2::new(across, down) }
    }

    /// Weights of the four texels.
    fn weights(&self) -> [f32; 4] {
        let (right, below) = (self.blend.x, self.blend.y);
        [(1.0 - right) * (1.0 - below), right * (1.0 - below), (1.0 - right) * below, right * below]
    }
}

/// An image that materials use.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Name or path from the source file, for messages and for reloading.
    pub name: String,
    /// Size in texels; both at least 1.
    pub size: [u32; 2],
    /// The decoded texels, `size[0] * size[1]` of them.
    pub texels: Texels,
    /// The bytes of the file, stored whole in datasets. Empty for a generated texture.
    pub encoded: Arc<[u8]>,
    /// Its levels of detail, built on first use.
    pub levels: Levels,
}

impl Texture {
    /// A visible default for an unreadable texture: a magenta and gray checkerboard.
    pub fn missing(name: &str) -> Self {
        let texels = (0..64).map(|i| if (i / 8 + i) % 2 == 0 { [255, 0, 255, 255] } else { [90, 90, 90, 255] });
        Self::new(name, [8, 8], Texels::U8(texels.collect()))
    }

    /// A generated texture, without a file.
    pub fn new(name: impl Into<String>, size: [u32; 2], texels: Texels) -> Self {
        Self { name: name.into(), size, texels, encoded: Arc::from([]), levels: Levels::default() }
    }

    /// The texel at integer coordinates, repeated outside the image, in linear values.
    pub fn texel(&self, x: i64, y: i64, color_space: ColorSpace) -> Vec4 {
        let [w, h] = self.size.map(i64::from);
        self.texels.at((y.rem_euclid(h) * w + x.rem_euclid(w)) as usize, color_space)
    }

    /// Mean of all texels, in linear values.
    pub fn mean(&self, color_space: ColorSpace) -> Vec4 {
        let count = self.size[0] as usize * self.size[1] as usize;
        let sum: glam::DVec4 = (0..count).map(|index| self.texels.at(index, color_space).as_dvec4()).sum();
        (sum / count as f64).as_vec4()
    }

    /// The smallest value of a channel.
    pub fn least(&self, channel: usize, color_space: ColorSpace) -> f32 {
        let count = self.size[0] as usize * self.size[1] as usize;
        (0..count).map(|index| self.texels.at(index, color_space)[channel]).fold(f32::INFINITY, f32::min)
    }

    /// Bilinear lookup; `uv` (0, 0) is the top left corner of the image.
    pub fn sample(&self, uv: Vec2, color_space: ColorSpace, wrap: [Wrap; 2]) -> Vec4 {
        self.texels.bilinear(self.size, uv, color_space, wrap)
    }

    /// The mean within a footprint, through a slot: coordinates transformed, color space applied.
    pub fn sample_footprint(&self, footprint: &UvFootprint, slot: &TextureSlot) -> Vec4 {
        let taps = footprint.through(slot).taps(self.size);
        let (color_space, wrap) = (slot.color_space, slot.wrap);
        if taps.level <= 0.0 && taps.count == 1 {
            return self.sample(taps.first, color_space, wrap);
        }
        let levels = self.levels(color_space);
        let level = taps.level.min(levels.len() as f32);
        let (finer, blend) = (level as usize, level.fract());
        let at = |level: usize, uv| match level.checked_sub(1).map(|below| &levels[below]) {
            None => self.sample(uv, color_space, wrap),
            Some(level) => level.texels.bilinear(level.size, uv, level.color_space, wrap),
        };
        let blended = |uv| {
            let fine = at(finer, uv);
            if blend > 0.0 { fine.lerp(at(finer + 1, uv), blend) } else { fine }
        };
        taps.positions().map(blended).sum::<Vec4>() / taps.count as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_PI_2, PI};

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    fn two_by_one() -> Texture {
        let texels = Texels::U8(vec![[0, 0, 0, 255], [255, 255, 255, 255]]);
        Texture::new("t", [2, 1], texels)
    }

    #[test]
    fn numbers_out_of_range_are_replaced_and_others_stay() {
        let good = TextureSlot { scale: Vec2::new(-TextureSlot::MOST, 0.5), rotation: 3.0, ..Default::default() };
        assert_eq!(good.clone().sanitized(), good);
        let bad = TextureSlot {
            scale: Vec2::new(f32::INFINITY, 0.5),
            offset: Vec2::new(f32::NAN, 2.0),
            rotation: -1e7,
            strength: f32::NEG_INFINITY,
            ..good
        };
        let expected = TextureSlot { scale: Vec2::new(1.0, 0.5), offset: Vec2::new(0.0, 2.0), ..Default::default() };
        assert_eq!(bad.sanitized(), expected);
        let mut texels = Texels::F32(vec![[0.5, -7.0, 65_504.0, 1.0], [f32::NAN, f32::INFINITY, -1e9, 0.25]]);
        assert_eq!(texels.sanitize(), 1);
        let expected = vec![[0.5, -7.0, 65_504.0, 1.0], [0.0, Texels::MOST, -Texels::MOST, 0.25]];
        assert_eq!(texels, Texels::F32(expected));
    }

    #[test]
    fn sampling_is_exact_at_texel_centres_and_repeats() {
        let t = two_by_one();
        for shift in [-3.0, 0.0, 2.0] {
            assert_eq!(t.sample(Vec2::new(0.25 + shift, 0.5), ColorSpace::Linear, REPEAT).x, 0.0);
            assert_eq!(t.sample(Vec2::new(0.75 + shift, 0.5), ColorSpace::Linear, REPEAT).x, 1.0);
        }
        assert!((t.sample(Vec2::new(0.5, 0.5), ColorSpace::Linear, REPEAT).x - 0.5).abs() < 1e-6);
    }

    #[test]
    fn flipping_turns_green_upside_down_and_nothing_else() {
        let slot = TextureSlot { strength: 0.5, ..Default::default() };
        let flipped = TextureSlot { flip_y: true, ..slot.clone() };
        let texel = Vec3::new(0.75, 0.75, 1.0);
        assert_eq!(slot.tangent_normal(texel), Vec3::new(0.25, 0.25, 1.0));
        assert_eq!(flipped.tangent_normal(texel), Vec3::new(0.25, -0.25, 1.0));
        let old: TextureSlot = serde_json::from_str(r#"{"texture": 3}"#).unwrap();
        assert!(!old.flip_y, "files from before have their green up");
    }

    /// A placement of a picture.
    fn placed(rotation: f32, scale: Vec2) -> TextureSlot {
        TextureSlot { rotation, scale, ..Default::default() }
    }

    #[test]
    fn normals_turn_and_are_mirrored_with_their_picture() {
        // Leans along the picture's u.
        let texel = 0.5 * Vec3::new(0.6, 0.0, 0.8) + 0.5;
        let mirrored = Vec2::new(-1.0, 1.0);
        for (rotation, scale, expected) in [
            (0.0, Vec2::ONE, Vec3::new(0.6, 0.0, 0.8)),
            (FRAC_PI_2, Vec2::ONE, Vec3::new(0.0, -0.6, 0.8)),
            (PI, Vec2::ONE, Vec3::new(-0.6, 0.0, 0.8)),
            (0.0, mirrored, Vec3::new(-0.6, 0.0, 0.8)),
            (0.0, Vec2::new(3.0, 0.25), Vec3::new(0.6, 0.0, 0.8)),
            (FRAC_PI_2, Vec2::new(3.0, 0.25), Vec3::new(0.0, -0.6, 0.8)),
            (PI, mirrored, Vec3::new(0.6, 0.0, 0.8)),
        ] {
            let slot = placed(rotation, scale);
            let normal = slot.tangent_normal(texel);
            assert!((normal - expected).length() < 1e-6, "{rotation} {scale}: {normal}");
            let unturned = placed(0.0, scale.abs()).tangent_normal(texel);
            let stays = expected.x > 0.5;
            assert_eq!((unturned - expected).length() < 1e-6, stays, "negative control, {rotation} {scale}");
        }
        // A quarter turn takes up to the tangent; a flip comes before it.
        let up = 0.5 * Vec3::new(0.0, 0.6, 0.8) + 0.5;
        let slot = TextureSlot { strength: 0.5, ..placed(FRAC_PI_2, Vec2::ONE) };
        assert!((slot.tangent_normal(up) - Vec3::new(0.3, 0.0, 0.8)).length() < 1e-6);
        let flipped = TextureSlot { flip_y: true, ..slot };
        assert!((flipped.tangent_normal(up) - Vec3::new(-0.3, 0.0, 0.8)).length() < 1e-6);
    }

    #[test]
    fn normals_of_a_plane_of_heights_turn_as_its_gradient_does() {
        // Heights a u + b v in the picture have the gradient `linear` transposed times (a, b) in the mesh's coordinates.
        let mut wrong = 0;
        for seed in 0..100 {
            let mut random = fastrand::Rng::with_seed(seed);
            let size = 0.2 + 3.0 * random.f32();
            let scale = Vec2::new(if random.bool() { size } else { -size }, if random.bool() { size } else { -size });
            let slot = placed(7.0 * random.f32() - 3.5, scale);
            let (a, b) = (random.f32() - 0.5, random.f32() - 0.5);
            let gradient = slot.linear().transpose() * Vec2::new(a, b) / size;
            // Normals lean against the gradient. The bitangent points to falling v.
            let expected = Vec2::new(-gradient.x, gradient.y);
            let encoded = 0.5 * Vec3::new(-a, b, 1.0) + 0.5;
            let error = |slot: &TextureSlot| (slot.tangent_normal(encoded).truncate() - expected).length();
            assert!(error(&slot) < 1e-5, "{seed}: {}", error(&slot));
            let other_way = TextureSlot { rotation: -slot.rotation, ..slot };
            wrong += u32::from(error(&other_way) > 0.01);
        }
        assert!(wrong > 90, "negative control: {wrong}");
    }

    #[test]
    fn primaries_of_a_file_count_for_colors_and_at_every_level_and_not_for_values() {
        // Red and green change places.
        let to_rec_709 = Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::Z);
        let native = vec![[0.25, 0.5, 0.75, 1.0], [0.75, 0.0, 0.25, 1.0]];
        let wide = Texture::new("w", [2, 1], Texels::Wide { texels: native.clone(), to_rec_709 });
        let plain = Texture::new("p", [2, 1], Texels::F32(native));
        let first = |t: &Texture, space| t.texel(0, 0, space).to_array();
        assert_eq!(first(&wide, ColorSpace::Srgb), [0.5, 0.25, 0.75, 1.0]);
        for other in [first(&wide, ColorSpace::Linear), first(&plain, ColorSpace::Srgb)] {
            assert_eq!(other, [0.25, 0.5, 0.75, 1.0], "negative control");
        }
        let last = |t: &Texture, space| t.levels(space).last().unwrap().texels.at(0, space).to_array();
        assert_eq!(last(&wide, ColorSpace::Srgb), [0.25, 0.5, 0.5, 1.0]);
        assert_eq!(last(&wide, ColorSpace::Linear), [0.5, 0.25, 0.5, 1.0]);
        assert_eq!(wide.mean(ColorSpace::Srgb).to_array(), [0.25, 0.5, 0.5, 1.0]);
    }

    #[test]
    fn a_slot_can_give_primaries_to_texels_of_any_depth_at_every_level() {
        // Computed apart with the matrices of ACES TB-2014-004 and Bradford, for (0.2, 0.6, 0.1).
        let right = Vec3::new(-0.0404, 0.6574, 0.0331);
        let gray = Vec4::new(0.5, 0.5, 0.5, 1.0);
        let other = Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::Z);
        let color = [0.2, 0.6, 0.1, 1.0];
        for texels in [
            Texels::U8(vec![[51, 153, 26, 255], [51, 153, 26, 255]]),
            Texels::U16(vec![[13107, 39321, 6554, 65535]; 2]),
            Texels::F32(vec![color; 2]),
            Texels::Wide { texels: vec![color; 2], to_rec_709: other },
        ] {
            let t = Texture::new("t", [2, 1], texels);
            let level = &t.levels(ColorSpace::AcesCg)[0];
            let at = UvFootprint { uv: Vec2::new(0.5, 0.5), changes: [Vec2::X, Vec2::Y] };
            let slot = TextureSlot { color_space: ColorSpace::AcesCg, ..Default::default() };
            let found = [
                t.texel(0, 0, ColorSpace::AcesCg),
                level.texels.at(0, level.color_space),
                t.mean(ColorSpace::AcesCg),
                t.sample_footprint(&at, &slot),
            ];
            for (i, found) in found.into_iter().enumerate() {
                assert!((found.truncate() - right).abs().max_element() < 3e-3, "{:?} {i}: {found}", t.texels);
            }
            let values = t.texel(0, 0, ColorSpace::Linear).truncate();
            assert!((values - right).abs().max_element() > 0.05, "negative control");
        }
        let t = Texture::new("t", [1, 1], Texels::F32(vec![gray.to_array()]));
        for space in ColorSpace::ALL {
            assert!((t.texel(0, 0, space) - gray).abs().max_element() < 1e-5, "{space:?}");
            assert_eq!(ColorSpace::ALL[space as usize], space, "in order");
        }
    }

    #[test]
    fn srgb_slots_decode_before_filtering() {
        let texels = Texels::U8(vec![[128, 128, 128, 255]]);
        let t = Texture { size: [1, 1], texels, ..two_by_one() };
        assert!((t.sample(Vec2::ZERO, ColorSpace::Srgb, REPEAT).x - 0.2158605).abs() < 1e-5);
        assert!((t.sample(Vec2::ZERO, ColorSpace::Linear, REPEAT).x - 128.0 / 255.0).abs() < 1e-6);
        let deep = Texture { texels: Texels::U16(vec![[257 * 128; 4]]), ..t.clone() };
        for space in [ColorSpace::Srgb, ColorSpace::Linear] {
            let [deep, codes] = [&deep, &t].map(|t| t.sample(Vec2::ZERO, space, REPEAT).truncate());
            assert!((deep - codes).abs().max_element() < 1e-6, "{space:?}: {deep} {codes}");
        }
    }
}
