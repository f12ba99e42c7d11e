//! Checks against the authors' own program.
//!
//! The expected means were printed by `nv_flip::flip` (nv-flip 0.1.2, which compiles the authors' C++) for the same 8-bit pictures,
//! generated here.

use super::*;

/// A color of 8-bit sRGB for each column and row.
type Picture = fn(u32, u32) -> [u8; 3];

fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let h = x.wrapping_mul(374_761_393);
    let h = h.wrapping_add(y.wrapping_mul(668_265_263)).wrapping_add(seed.wrapping_mul(2_246_822_519));
    let h = (h ^ (h >> 13)).wrapping_mul(1_274_126_177);
    h ^ (h >> 16)
}

const BLACK: Picture = |_, _| [0; 3];
const WHITE: Picture = |_, _| [255; 3];
const GREY: Picture = |_, _| [90; 3];
const GREEN: Picture = |_, _| [0, 255, 0];
const BLUE: Picture = |_, _| [0, 0, 255];
const GRADIENT: Picture = |x, y| [(x * 3) as u8, (y * 5) as u8, 128];
const REDDER: Picture = |x, y| [(x * 3 + 12) as u8, (y * 5) as u8, 128];
const SWAPPED: Picture = |x, y| [128, (y * 5) as u8, (x * 3) as u8];
const CHECKER: Picture = |x, y| [if (x / 8 + y / 8) % 2 == 0 { 40 } else { 210 }; 3];
const SHIFTED: Picture = |x, y| CHECKER(x + 1, y);
const POINTS: Picture = |x, y| if hash(x, y, 1).is_multiple_of(61) { [255, 240, 200] } else { [90; 3] };
const NOISE: Picture = |x, y| [2, 3, 4].map(|seed| (70 + hash(x, y, seed) % 41) as u8);

fn image(size: [u32; 2], picture: Picture) -> Image {
    Image::from_fn(size, |x, y| Vec3::from(picture(x, y).map(|byte| f32::from(byte) / 255.0)))
}

fn mean_flip(size: [u32; 2], test: Picture, reference: Picture, pixels_per_degree: f32) -> f64 {
    let errors = flip(&image(size, test), &image(size, reference), pixels_per_degree);
    errors.iter().map(|&error| f64::from(error)).sum::<f64>() / errors.len() as f64
}

#[test]
fn means_are_those_of_the_authors_program() {
    // Size, test, reference, mean at 67 and at 30 pixels per degree.
    let expected: [([u32; 2], Picture, Picture, f64, f64); 10] = [
        ([80, 48], REDDER, GRADIENT, 0.1356393, 0.1341293),
        ([80, 48], SWAPPED, GRADIENT, 0.5144386, 0.5110679),
        ([64, 64], SHIFTED, CHECKER, 0.2532674, 0.2123674),
        ([61, 37], GREY, POINTS, 0.0957978, 0.0670763),
        ([100, 20], NOISE, GREY, 0.0987980, 0.1878309),
        ([7, 5], CHECKER, NOISE, 0.5639527, 0.5786464),
        ([1, 1], GREY, GRADIENT, 0.7025801, 0.7025693),
        ([33, 1], NOISE, POINTS, 0.1359687, 0.2179374),
        ([16, 16], BLACK, WHITE, 0.9673918, 0.9673844),
        ([16, 16], GREEN, BLUE, 1.0, 1.0),
    ];
    for (i, (size, test, reference, at_67, at_30)) in expected.into_iter().enumerate() {
        for (ppd, expected) in [(67.0, at_67), (30.0, at_30)] {
            let found = mean_flip(size, test, reference, ppd);
            assert!((found - expected).abs() < 2e-5, "pair {i} at {ppd} pixels per degree: {found}, not {expected}");
        }
    }
}

#[test]
fn the_tolerance_tells_neighbouring_settings_and_pictures_apart() {
    let expected = 0.2532674;
    assert!((mean_flip([64, 64], SHIFTED, CHECKER, 67.5) - expected).abs() > 1e-4);
    assert!((mean_flip([64, 63], SHIFTED, CHECKER, 67.0) - expected).abs() > 1e-4);
    assert!((mean_flip([64, 64], |x, y| CHECKER(x, y + 2), CHECKER, 67.0) - expected).abs() > 1e-4);
}

#[test]
fn equal_pictures_do_not_differ_and_order_does_not_matter() {
    assert_eq!(mean_flip([61, 37], POINTS, POINTS, PIXELS_PER_DEGREE), 0.0);
    let there = mean_flip([61, 37], POINTS, GREY, PIXELS_PER_DEGREE);
    assert_eq!(there, mean_flip([61, 37], GREY, POINTS, PIXELS_PER_DEGREE));
}

#[test]
fn an_empty_picture_has_no_errors() {
    assert!(flip(&image([0, 0], GREY), &image([0, 0], GREY), PIXELS_PER_DEGREE).is_empty());
}
