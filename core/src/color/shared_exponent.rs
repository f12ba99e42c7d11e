//! Colors with one exponent for three mantissas of nine bits, as textures of the format `rgb9e5` have them: four bytes, no sign, up
//! to 65,408, to 1/512 of the brightest channel.

use glam::Vec3;

/// Bits of a mantissa.
const MANTISSA: u32 = 9;
/// Of the exponent.
const BIAS: i32 = 15;
/// The largest component.
const LARGEST: f32 = 65_408.0;

/// The nearest color of the format; negative components and NaN become 0.
#[inline]
pub fn encode(color: Vec3) -> u32 {
    let color = color.max(Vec3::ZERO).min(Vec3::splat(LARGEST));
    let largest = color.max_element();
    // The exponent of the power of two above the largest component.
    let above = ((largest.to_bits() >> 23) as i32 - 126).max(-BIAS);
    let rounded = |exponent: i32| (color * power_of_two(MANTISSA as i32 - exponent)).to_array().map(nearest_integer);
    let fits = rounded(above).into_iter().all(|mantissa| mantissa < 1 << MANTISSA);
    let exponent = if fits { above } else { above + 1 };
    let [x, y, z] = rounded(exponent);
    x | y << MANTISSA | z << (2 * MANTISSA) | ((exponent + BIAS) as u32) << (3 * MANTISSA)
}

/// The nearest integer to a number of up to 2²², in fewer instructions than a conversion: adding 2²³ leaves no bit for less than 1.
#[inline(always)]
fn nearest_integer(number: f32) -> u32 {
    const SHIFT: f32 = (1 << 23) as f32;
    (number + SHIFT).to_bits() - SHIFT.to_bits()
}

/// The color of a code.
#[inline(always)]
pub fn decode(code: u32) -> Vec3 {
    let mantissa = |i: u32| (code >> (MANTISSA * i) & ((1 << MANTISSA) - 1)) as f32;
    let exponent = (code >> (3 * MANTISSA)) as i32 - BIAS;
    Vec3::new(mantissa(0), mantissa(1), mantissa(2)) * power_of_two(exponent - MANTISSA as i32)
}

/// 2 to the power of -126 to 127.
#[inline(always)]
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_come_back_to_a_share_of_their_brightest_channel() {
        let mut rng = fastrand::Rng::with_seed(2);
        for _ in 0..20_000 {
            let scale = (rng.f32() * 24.0 - 9.0).exp2();
            let color = Vec3::new(rng.f32(), rng.f32(), rng.f32()) * scale;
            let error = (decode(encode(color)) - color).abs().max_element();
            assert!(error <= color.max_element() / 512.0, "{color} {}", decode(encode(color)));
        }
        for exact in [Vec3::ZERO, Vec3::ONE, Vec3::splat(0.75), Vec3::new(4.0, 0.0, 1.0), Vec3::splat(LARGEST)] {
            assert_eq!(decode(encode(exact)), exact);
        }
        assert_eq!(decode(encode(Vec3::splat(0.999_99))), Vec3::ONE, "rounding takes the next exponent");
    }

    #[test]
    fn what_the_format_lacks_becomes_the_nearest_that_it_has() {
        assert_eq!(decode(encode(Vec3::new(-1.0, 2.0, f32::NAN))), Vec3::new(0.0, 2.0, 0.0));
        assert_eq!(decode(encode(Vec3::splat(f32::INFINITY))), Vec3::splat(LARGEST));
        assert_eq!(decode(encode(Vec3::splat(1e-9))), Vec3::ZERO);
    }

    #[test]
    fn codes_are_those_of_the_specification() {
        // EXT_texture_shared_exponent: (red, green, blue) mantissas from the lowest bit, then the exponent.
        assert_eq!(encode(Vec3::ONE), 256 | 256 << 9 | 256 << 18 | 16 << 27);
        assert_eq!(encode(Vec3::new(0.5, 0.0, 0.25)), 256 | 128 << 18 | 15 << 27);
    }
}
