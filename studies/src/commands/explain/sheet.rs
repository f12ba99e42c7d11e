//! All pictures of a split: the chain from the rendered picture to light paths above, each step's change below, and the total error
//! last, with a common legend.

use crate::sheet::{GAP, exposure, side_by_side};
use anyhow::Result;
use glam::Vec3;
use lapidary_core::image::Image;
use lapidary_render::compare::map::{ErrorMap, error_map};

/// Pictures narrower than this many pixels are enlarged by a whole factor.
const NARROW: u32 = 240;

/// All pictures at one exposure and all errors in one range.
pub fn sheet(pictures: &[&Image]) -> Result<Image> {
    let [first, .., truth] = pictures else { return Ok(Image::filled([1, 1], Vec3::ZERO)) };
    let scale = exposure(truth);
    let shown = |image: &Image| enlarged(image, NARROW.div_ceil(image.size[0]), scale);
    let above: Vec<Image> = pictures.iter().map(|image| shown(image)).collect();
    let whole = error_map(&shown(first), &shown(truth), ErrorMap::Absolute, None)?;
    let top = Some(whole.range[1]);
    let mut below = Vec::new();
    for pair in above.windows(2) {
        let map = error_map(&pair[0], &pair[1], ErrorMap::Absolute, top)?.image;
        below.push(Image::from_fn(pair[0].size, |x, y| map.at(x as usize, y as usize)));
    }
    below.push(whole.image);
    Ok(stacked(&side_by_side(&above), &side_by_side(&below)))
}

/// Every pixel as a square of `side` pixels, scaled by `scale`.
fn enlarged(image: &Image, side: u32, scale: f32) -> Image {
    let size = image.size.map(|n| n * side);
    Image::from_fn(size, |x, y| image.at((x / side) as usize, (y / side) as usize) * scale)
}

/// One picture above another, on white.
fn stacked(above: &Image, below: &Image) -> Image {
    let first_row = above.size[1] + GAP;
    let size = [above.size[0].max(below.size[0]), first_row + below.size[1]];
    let pixel = |image: &Image, x: u32, y: u32| {
        (x < image.size[0] && y < image.size[1]).then(|| image.at(x as usize, y as usize))
    };
    let at = |x, y: u32| if y < first_row { pixel(above, x, y) } else { pixel(below, x, y - first_row) };
    Image::from_fn(size, |x, y| at(x, y).unwrap_or(Vec3::ONE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_a_change_are_black_and_all_have_one_range() {
        let gray = |value: f32| Image::filled([120, 90], Vec3::splat(value));
        let sheet = sheet(&[&gray(1.2), &gray(1.2), &gray(1.1), &gray(1.0)]).unwrap();
        let column = |i: u32| (i * (240 + GAP) + 7) as usize;
        let below = |i| sheet.at(column(i), 180 + GAP as usize + 7);
        assert!(below(0).max_element() < 0.01, "nothing changes");
        assert!((below(1) - below(2)).length() < 0.02 && below(1).max_element() > 0.05, "by a tenth each");
        assert!(below(3).element_sum() > below(2).element_sum(), "negative control: both together");
        assert!((sheet.at(column(0), 7).x / sheet.at(column(3), 7).x - 1.2).abs() < 1e-4);
    }
}
