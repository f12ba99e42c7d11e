//! Color: the sRGB transfer function and primaries at the border, luminance inside. Twin of `shaders/color.wgsl`.

mod blackbody;
mod primaries;
pub mod shared_exponent;

pub use {
    blackbody::{KELVINS, blackbody, temperature_of},
    primaries::Primaries,
};

use glam::{Mat3, Vec3};
use std::sync::LazyLock;

/// Rec. 709 luminance weights.
pub const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// The largest number of a 16-bit float.
pub const LARGEST_HALF: f32 = 65_504.0;

/// Luminance of a scene-linear Rec. 709 color.
#[inline]
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(LUMINANCE)
}

/// A change of light as a color: red adds, blue subtracts.
pub fn signed_light(more: f32) -> Vec3 {
    Vec3::new(more, 0.0, -more).max(Vec3::ZERO)
}

/// A color in linear Rec. 709 from other primaries. Infinite components become the largest 16-bit float: they would make NaN of
/// the others.
#[inline]
pub fn in_rec_709(to_rec_709: Mat3, color: Vec3) -> Vec3 {
    to_rec_709 * color.map(|x| if x.is_infinite() { x.clamp(-LARGEST_HALF, LARGEST_HALF) } else { x })
}

/// Decodes one sRGB component (IEC 61966-2-1), 0 to 1.
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// The linear components of the 256 sRGB codes.
pub static LINEAR_FROM_CODE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0)));

/// Decodes sRGB codes.
#[inline]
pub fn linear_from_codes(codes: [u8; 3]) -> Vec3 {
    let table = &*LINEAR_FROM_CODE;
    codes.map(|code| table[code as usize]).into()
}

/// Decodes 16-bit sRGB codes.
#[inline]
pub fn linear_from_deep_codes(codes: [u16; 3]) -> Vec3 {
    codes.map(|code| linear_from_srgb(f32::from(code) / 65_535.0)).into()
}

/// Encodes one linear component as sRGB, clamping to 0 to 1; NaN becomes 0.
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Encodes a linear color as sRGB codes.
pub fn codes_from_linear(rgb: Vec3) -> [u8; 3] {
    codes(rgb.map(srgb_from_linear))
}

/// The nearest codes of encoded components from 0 to 1.
pub fn codes(encoded: Vec3) -> [u8; 3] {
    encoded.to_array().map(|x| (255.0 * x + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_and_hits_the_known_middle_gray() {
        for i in 0..=255 {
            let x = i as f32 / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-5);
            assert_eq!(codes_from_linear(linear_from_codes([i as u8; 3])), [i as u8; 3]);
        }
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-5);
        let difference = linear_from_deep_codes([257 * 128; 3]) - linear_from_codes([128; 3]);
        assert!(difference.abs().max_element() < 1e-6, "8 and 16 bits of one gray");
    }
}
