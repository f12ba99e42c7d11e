//! Colors of signed errors: blue below zero, orange above, black at zero. Blue and orange differ under every common color
//! blindness, and correct pixels are dark, as with magma.

use glam::Vec3;

/// From no error to the end of the range, sRGB-encoded, evenly spaced.
const BELOW: [Vec3; 3] = [Vec3::ZERO, Vec3::new(0.13, 0.38, 0.80), Vec3::new(0.72, 0.90, 1.0)];
const ABOVE: [Vec3; 3] = [Vec3::ZERO, Vec3::new(0.80, 0.36, 0.05), Vec3::new(1.0, 0.91, 0.66)];

/// The sRGB-encoded color of an error, clamped to the range -1 to 1.
pub(super) fn diverging(error: f32) -> Vec3 {
    let stops = if error < 0.0 { BELOW } else { ABOVE };
    let position = 2.0 * error.abs().min(1.0);
    let below = (position as usize).min(1);
    stops[below].lerp(stops[below + 1], position - below as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::color::luminance;

    #[test]
    fn lightness_rises_to_both_sides_alike_and_the_sides_have_their_hues() {
        let lightness = |e: f32| luminance(diverging(e));
        for i in 0..50 {
            let (near, far) = (i as f32 / 50.0, (i + 1) as f32 / 50.0);
            assert!(lightness(far) > lightness(near) && lightness(-far) > lightness(-near));
            assert!((lightness(far) - lightness(-far)).abs() < 0.12, "{far}");
            assert!(diverging(far).x > diverging(far).z && diverging(-far).x < diverging(-far).z);
        }
        assert_eq!((diverging(0.0), diverging(9.0)), (Vec3::ZERO, diverging(1.0)));
    }
}
