//! The color map magma, as in matplotlib (CC0): perceptually uniform, readable with color blindness, black for no error. The FLIP
//! authors use it too, so pictures can be compared with theirs.

use glam::Vec3;

/// Every 17th of matplotlib's 256 sRGB colors; in between, interpolation is off by at most 2.2 / 255.
const STOPS: [u32; 16] = [
    0x000004, 0x0b0924, 0x20114b, 0x3b0f70, 0x57157e, 0x721f81, 0x8c2981, 0xa8327d, 0xc43c75, 0xde4968, 0xf1605d,
    0xfa7f5e, 0xfe9f6d, 0xfebf84, 0xfddea0, 0xfcfdbf,
];

/// The sRGB-encoded color of an error, clamped to the range 0 to 1.
pub fn magma(error: f32) -> Vec3 {
    let position = error.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let below = (position as usize).min(STOPS.len() - 2);
    stop(below).lerp(stop(below + 1), position - below as f32)
}

/// The colors between which [`magma`] interpolates.
pub fn magma_stops() -> [Vec3; 16] {
    std::array::from_fn(stop)
}

fn stop(index: usize) -> Vec3 {
    let [_, r, g, b] = STOPS[index].to_be_bytes();
    Vec3::new(r.into(), g.into(), b.into()) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::color::luminance;

    #[test]
    fn lightness_only_rises_and_the_ends_are_those_of_matplotlib() {
        let lightness: Vec<f32> = (0..=100).map(|i| luminance(magma(i as f32 / 100.0))).collect();
        assert!(lightness.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((magma(-1.0) * 255.0 - Vec3::new(0.0, 0.0, 4.0)).length() < 1e-3);
        assert!((magma(9.0) * 255.0 - Vec3::new(252.0, 253.0, 191.0)).length() < 1e-3);
    }

    #[test]
    fn the_middle_is_near_the_full_table() {
        // Entry 128 of matplotlib's table.
        let expected = Vec3::new(0.716387, 0.214982, 0.475290);
        assert!((magma(128.0 / 255.0) - expected).abs().max_element() < 2.7 / 255.0);
    }
}
