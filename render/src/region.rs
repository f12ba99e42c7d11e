//! A part of a picture, and pictures of such parts alone.

use crate::{frame::Frame, samples::PointShader, view::Progress};
use glam::Vec3;
use lapidary_core::image::Image;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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

/// Why a rectangle is no region of a picture.
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

/// Rows between which a picture of a region can be cancelled.
const BAND: usize = 8;

impl Region {
    /// All of a picture.
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// The square of at most `side` pixels around a pixel of a picture, cut off at the picture's edges.
    pub fn around([x, y]: [u32; 2], side: u32, size: [u32; 2]) -> Self {
        let span = |center: u32, end: u32| {
            let first = center.saturating_sub(side / 2);
            (first, end.min(center + side.div_ceil(2)) - first)
        };
        let ((x, width), (y, height)) = (span(x, size[0]), span(y, size[1]));
        Self { x, y, width, height }
    }

    /// Whether it is a region of a picture of `size`.
    ///
    /// # Errors
    /// No pixels, or pixels that the picture does not have.
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
    pub fn columns(self) -> std::ops::Range<u32> {
        self.x..self.x + self.width
    }

    /// Its rows.
    pub fn rows(self) -> std::ops::Range<u32> {
        self.y..self.y + self.height
    }
}

/// The part of a frame's picture that `region` is, each thread with a shader of its own; `None` if cancelled.
pub(crate) fn picture_of<S: PointShader>(
    frame: &Frame,
    region: Region,
    shader: impl Fn() -> S + Sync,
    progress: &dyn Progress,
) -> Option<Image> {
    let rows: Vec<u32> = region.rows().collect();
    let mut pixels = Vec::with_capacity(region.pixels() as usize);
    for band in rows.chunks(BAND) {
        if progress.cancelled() {
            return None;
        }
        let row = |shader: &mut S, &y: &u32| -> Vec<Vec3> {
            region.columns().map(|x| frame.pixel(x, y, |point| shader.shade(point))).collect()
        };
        let shaded: Vec<Vec<Vec3>> = band.par_iter().map_init(&shader, row).collect();
        pixels.extend(shaded.into_iter().flatten());
        progress.advanced(pixels.len() as u64, region.pixels());
    }
    Some(Image { size: region.size(), pixels })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_without_pixels_or_outside_are_refused() {
        let region = |x, y, width, height| Region { x, y, width, height };
        let size = [40, 30];
        assert!(region(0, 0, 40, 30).check(size).is_ok() && region(39, 29, 1, 1).check(size).is_ok());
        assert_eq!(region(3, 3, 0, 4).check(size), Err(RegionError::Empty));
        assert_eq!(region(3, 3, 4, 0).check(size), Err(RegionError::Empty));
        let message = region(30, 0, 11, 1).check(size).unwrap_err().to_string();
        assert!(message.contains("column 40") && message.contains("40 x 30"), "{message}");
        assert!(region(u32::MAX, 0, u32::MAX, 1).check(size).is_err(), "no overflow");
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
}
