//! A rectangle of pixels.

use serde::{Deserialize, Serialize};
use std::{ops::Range, str::FromStr};

/// A rectangle of a picture's pixels, with at least one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Region {
    /// Column and row of the top left pixel.
    pub origin: [u32; 2],
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl Region {
    /// The part of it that lies in a picture of `size` pixels, if there is one.
    pub fn within(self, size: [u32; 2]) -> Option<Self> {
        let end = |i: usize| self.origin[i].saturating_add(self.size[i]).min(size[i]);
        let size = [0, 1].map(|i| end(i).saturating_sub(self.origin[i]));
        (!size.contains(&0)).then_some(Self { size, ..self })
    }

    /// Its columns.
    pub fn columns(&self) -> Range<u32> {
        self.origin[0]..self.origin[0] + self.size[0]
    }

    /// Its rows.
    pub fn rows(&self) -> Range<u32> {
        self.origin[1]..self.origin[1] + self.size[1]
    }

    /// The same part of a picture of which only the pixels are kept whose column and row are multiples of `step`, if
    /// there are some.
    pub fn every(self, step: u32) -> Option<Self> {
        let [columns, rows] = [self.columns(), self.rows()].map(|r| r.start.div_ceil(step)..r.end.div_ceil(step));
        let size = [&columns, &rows].map(|r| r.len() as u32);
        (!size.contains(&0)).then_some(Self { origin: [columns.start, rows.start], size })
    }
}

impl FromStr for Region {
    type Err = String;

    /// `X,Y,WIDTH,HEIGHT` in pixels.
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Self { origin: [x, y], size: [width, height] }),
            Ok([_, _, _, _]) => Err("a region needs a width and a height of at least 1 pixel".into()),
            _ => Err(format!("\"{text}\" is no region; write X,Y,WIDTH,HEIGHT in pixels, as in 40,30,160,120")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use glam::Vec3;

    #[test]
    fn a_region_is_cut_to_the_picture() {
        let region: Region = "2, 1,3,4".parse().unwrap();
        assert_eq!(region, Region { origin: [2, 1], size: [3, 4] });
        assert_eq!(region.within([9, 9]), Some(region));
        assert_eq!(region.within([4, 2]), Some(Region { origin: [2, 1], size: [2, 1] }));
        assert_eq!(region.within([2, 9]), None);
        assert_eq!(Region { origin: [u32::MAX, 0], size: [9, 9] }.within([8, 8]), None);
        for bad in ["", "1,2,3", "1,2,0,4", "1,2,-3,4", "a,b,c,d"] {
            assert!(bad.parse::<Region>().is_err(), "{bad}");
        }
    }

    #[test]
    fn cropping_and_thinning_commute() {
        let image = Image::from_fn([13, 9], |x, y| Vec3::new(x as f32, y as f32, 0.0));
        let region = Region { origin: [3, 2], size: [7, 6] };
        let cropped = image.crop(region);
        assert_eq!((cropped.size, cropped.at(0, 0), cropped.at(6, 5)), ([7, 6], image.at(3, 2), image.at(9, 7)));
        let thinned = image.every(2).crop(region.every(2).unwrap());
        assert_eq!((thinned.size, thinned.at(0, 0), thinned.at(2, 2)), ([3, 3], image.at(4, 2), image.at(8, 6)));
        assert_eq!(Region { origin: [1, 1], size: [2, 2] }.every(4), None, "no pixel of the coarse grid lies in it");
    }
}
