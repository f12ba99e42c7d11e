//! A rectangle of pixels.

use serde::{Deserialize, Serialize};
use std::ops::Range;
use thiserror::Error;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Region {
    /// Column of its left edge.
    pub x: u32,
    /// Row of its upper edge.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Why a rectangle is not a region of a picture.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum RegionError {
    /// It has no pixels.
    #[error("the region has no pixels; give it a width and a height of at least 1")]
    Empty,
    /// It reaches past an edge.
    #[error(
        "the region reaches to column {} and row {}, but the picture has {} x {} pixels; columns and rows count from 0",
        corner[0], corner[1], size[0], size[1]
    )]
    Outside {
        /// Its last column and row.
        corner: [u64; 2],
        /// Width and height of the picture.
        size: [u32; 2],
    },
}

impl Region {
    /// The whole picture.
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// The square of at most `side` pixels around a pixel, clamped to a picture and cut off at its edges.
    pub fn around([x, y]: [u32; 2], side: u32, size: [u32; 2]) -> Self {
        let span = |center: u32, end: u32| {
            let center = center.min(end.saturating_sub(1));
            let first = center.saturating_sub(side / 2);
            (first, end.min(center + side.div_ceil(2)) - first)
        };
        let ((x, width), (y, height)) = (span(x, size[0]), span(y, size[1]));
        Self { x, y, width, height }
    }

    /// Checks that it is a region of a picture of `size`.
    ///
    /// # Errors
    /// No pixels, or pixels outside the picture.
    pub fn check(self, size: [u32; 2]) -> Result<Self, RegionError> {
        if self.width == 0 || self.height == 0 {
            return Err(RegionError::Empty);
        }
        let end = |first: u32, count: u32| u64::from(first) + u64::from(count);
        let ends = [end(self.x, self.width), end(self.y, self.height)];
        if ends[0] > size[0].into() || ends[1] > size[1].into() {
            return Err(RegionError::Outside { corner: ends.map(|end| end - 1), size });
        }
        Ok(self)
    }

    /// Width and height in pixels.
    pub fn size(self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Number of pixels.
    pub fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Its columns.
    pub fn columns(self) -> Range<u32> {
        self.x..self.x + self.width
    }

    /// Its rows.
    pub fn rows(self) -> Range<u32> {
        self.y..self.y + self.height
    }

    /// The part within a picture of `size` pixels, if any.
    pub fn within(self, size: [u32; 2]) -> Option<Self> {
        let width = self.x.saturating_add(self.width).min(size[0]).saturating_sub(self.x);
        let height = self.y.saturating_add(self.height).min(size[1]).saturating_sub(self.y);
        (width > 0 && height > 0).then_some(Self { width, height, ..self })
    }

    /// The same region of a picture that keeps only the pixels whose column and row are multiples of `step`, if it has any.
    pub fn every(self, step: u32) -> Option<Self> {
        let [columns, rows] = [self.columns(), self.rows()].map(|r| r.start.div_ceil(step)..r.end.div_ceil(step));
        let (width, height) = (columns.len() as u32, rows.len() as u32);
        (width > 0 && height > 0).then_some(Self { x: columns.start, y: rows.start, width, height })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use glam::Vec3;

    #[test]
    fn regions_without_pixels_or_outside_are_refused() {
        let region = |x, y, width, height| Region { x, y, width, height };
        let size = [40, 30];
        for good in [region(0, 0, 40, 30), region(39, 29, 1, 1)] {
            assert_eq!(good.check(size), Ok(good));
        }
        assert_eq!(region(3, 3, 0, 4).check(size), Err(RegionError::Empty));
        assert_eq!(region(3, 3, 4, 0).check(size), Err(RegionError::Empty));
        let message = region(30, 0, 11, 1).check(size).unwrap_err().to_string();
        assert!(message.contains("column 40") && message.contains("40 x 30"), "{message}");
        let corner = [2 * u64::from(u32::MAX) - 1, 0];
        let far = region(u32::MAX, 0, u32::MAX, 1).check(size);
        assert_eq!(far, Err(RegionError::Outside { corner, size }), "no overflow");
    }

    #[test]
    fn a_square_around_a_pixel_stays_in_the_picture() {
        let size = [40, 30];
        assert_eq!(Region::around([20, 15], 8, size), Region { x: 16, y: 11, width: 8, height: 8 });
        for pixel in [[0, 0], [39, 29], [1, 28]] {
            let square = Region::around(pixel, 64, size).check(size).unwrap();
            assert!(square.columns().contains(&pixel[0]) && square.rows().contains(&pixel[1]));
        }
        assert_eq!(Region::around([39, 0], 1, size), Region { x: 39, y: 0, width: 1, height: 1 });
    }

    #[test]
    fn a_region_is_cut_to_the_picture() {
        let region = Region { x: 2, y: 1, width: 3, height: 4 };
        assert_eq!(region.within([9, 9]), Some(region));
        assert_eq!(region.within([4, 2]), Some(Region { width: 2, height: 1, ..region }));
        assert_eq!(region.within([2, 9]), None);
        assert_eq!(Region { x: u32::MAX, y: 0, width: 9, height: 9 }.within([8, 8]), None);
    }

    #[test]
    fn cropping_and_thinning_commute() {
        let image = Image::from_fn([13, 9], |x, y| Vec3::new(x as f32, y as f32, 0.0));
        let region = Region { x: 3, y: 2, width: 7, height: 6 };
        let cropped = image.crop(region);
        assert_eq!((cropped.size, cropped.at(0, 0), cropped.at(6, 5)), ([7, 6], image.at(3, 2), image.at(9, 7)));
        let thinned = image.every(2).crop(region.every(2).unwrap());
        assert_eq!((thinned.size, thinned.at(0, 0), thinned.at(2, 2)), ([3, 3], image.at(4, 2), image.at(8, 6)));
        assert_eq!(Region { x: 1, y: 1, width: 2, height: 2 }.every(4), None, "no pixel of the coarse grid lies in it");
    }
}
