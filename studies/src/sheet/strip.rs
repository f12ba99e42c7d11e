//! Pictures side by side: the reference, then each test with its error map.

use anyhow::Result;
use glam::Vec3;
use lapidary_core::{color::luminance, image::Image};
use lapidary_render::compare::map::{ErrorMap, error_map};

/// Share of the pixels whose luminance is displayed below white.
const SHOWN: f32 = 0.98;
/// Displayed value of that luminance.
const BRIGHT: f32 = 0.8;
/// Pixels between pictures.
pub const GAP: u32 = 4;

/// `truth`, then each of `tests` and its absolute error, all at one exposure and all errors in one range.
pub fn strip(truth: &Image, tests: &[Option<&Image>]) -> Result<Image> {
    let exposure = exposure(truth);
    let truth = truth.scaled(exposure);
    let mut pictures = vec![truth.clone()];
    let mut top = None;
    for test in tests.iter().flatten() {
        let test = test.scaled(exposure);
        let map = error_map(&test, &truth, ErrorMap::Absolute, top)?;
        top = Some(map.range[1]);
        pictures.extend([test, map.image]);
    }
    Ok(side_by_side(&pictures))
}

/// Scale that brings all but the brightest pixels below white.
pub fn exposure(image: &Image) -> f32 {
    let mut values: Vec<f32> = image.pixels.iter().map(|&p| luminance(p)).collect();
    values.sort_unstable_by(f32::total_cmp);
    let bright = values.get((SHOWN * values.len() as f32) as usize).copied().unwrap_or_default();
    if bright > 0.0 { BRIGHT / bright } else { 1.0 }
}

/// The pictures from left to right with gaps between them.
pub fn side_by_side(pictures: &[Image]) -> Image {
    let height = pictures.iter().map(|p| p.size[1]).max().unwrap_or_default();
    let width = pictures.iter().map(|p| p.size[0] + GAP).sum::<u32>().saturating_sub(GAP);
    let mut result = Image::filled([width, height], Vec3::ONE);
    let mut left = 0;
    for picture in pictures {
        for (y, row) in picture.pixels.chunks(picture.size[0] as usize).enumerate() {
            let start = y * width as usize + left;
            result.pixels[start..start + row.len()].copy_from_slice(row);
        }
        left += (picture.size[0] + GAP) as usize;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_side_by_side_at_one_exposure() {
        let truth = Image::filled([8, 6], Vec3::splat(4.0));
        let half = Image::filled([8, 6], Vec3::splat(2.0));
        let strip = strip(&truth, &[Some(&half), None]).unwrap();
        assert!(strip.size[0] >= 8 + GAP + 8 + GAP + 8, "{:?}", strip.size);
        assert!((strip.at(3, 3).x - BRIGHT).abs() < 1e-5);
        assert!((strip.at(8 + GAP as usize + 3, 3).x - 0.5 * BRIGHT).abs() < 1e-5);
        assert_eq!(strip.at(9, 3), Vec3::ONE);
        let dark = Image::filled([4, 4], Vec3::ZERO);
        assert!(super::strip(&dark, &[Some(&dark)]).unwrap().pixels.iter().all(|p| p.is_finite()));
    }
}
