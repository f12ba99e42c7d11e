//! Window dumps of X servers: a header of big-endian words, a name, a color map, and the pixels row by row. The layout is
//! `X11/XWDFile.h`, version 7.

use std::{collections::BTreeSet, ops::Range};

/// Version of the layout.
const VERSION: usize = 7;

/// Bytes of a color in the color map.
const BYTES_OF_COLOR: usize = 12;

/// Positions of the header words that are read.
mod word {
    pub const HEADER_SIZE: usize = 0;
    pub const FILE_VERSION: usize = 1;
    pub const WIDTH: usize = 4;
    pub const HEIGHT: usize = 5;
    pub const BITS_PER_PIXEL: usize = 11;
    pub const BYTES_PER_LINE: usize = 12;
    pub const COLORS: usize = 19;
}

/// A picture with 32 bits per pixel.
pub struct Xwd<'a> {
    width: usize,
    height: usize,
    bytes_per_line: usize,
    pixels: &'a [u8],
}

impl<'a> Xwd<'a> {
    /// `None` if the bytes are not a complete picture.
    pub fn read(bytes: &'a [u8]) -> Option<Self> {
        let word = |place: usize| {
            let bytes = bytes.get(4 * place..4 * place + 4)?;
            usize::try_from(u32::from_be_bytes(bytes.try_into().ok()?)).ok()
        };
        let (width, height, bytes_per_line) = (word(word::WIDTH)?, word(word::HEIGHT)?, word(word::BYTES_PER_LINE)?);
        let start = word(word::HEADER_SIZE)?.checked_add(word(word::COLORS)?.checked_mul(BYTES_OF_COLOR)?)?;
        let end = start.checked_add(height.checked_mul(bytes_per_line)?)?;
        let is_known = word(word::FILE_VERSION)? == VERSION && word(word::BITS_PER_PIXEL)? == 32;
        let is_whole = width.checked_mul(4)? <= bytes_per_line;
        let pixels = bytes.get(start..end).filter(|_| is_known && is_whole)?;
        Some(Self { width, height, bytes_per_line, pixels })
    }

    /// Number of colors in the square of `side` pixels in the middle.
    pub fn colors_in_middle(&self, side: usize) -> usize {
        let (columns, rows) = (middle(self.width, side), middle(self.height, side));
        let row = |y: usize| &self.pixels[y * self.bytes_per_line..][4 * columns.start..4 * columns.end];
        let colors: BTreeSet<&[u8]> = rows.flat_map(|y| row(y).chunks_exact(4)).collect();
        colors.len()
    }
}

fn middle(size: usize, side: usize) -> Range<usize> {
    let side = side.min(size);
    (size - side) / 2..(size + side) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with distinct pixel colors where `is_colorful`, and two colors in its map.
    fn picture([width, height]: [u32; 2], is_colorful: impl Fn(u32, u32) -> bool) -> Vec<u8> {
        let (header, line) = (104, 4 * width + 8);
        let mut words = [0_u32; 25];
        for (place, value) in [(0, header), (1, 7), (4, width), (5, height), (11, 32), (12, line), (19, 2)] {
            words[place] = value;
        }
        let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
        bytes.extend([b'n', 0, 0, 0]);
        bytes.extend([1; 24]);
        for y in 0..height {
            for x in 0..width {
                let color = if is_colorful(x, y) { 1 + y * width + x } else { 0 };
                bytes.extend(color.to_le_bytes());
            }
            bytes.extend([0xff; 8]);
        }
        bytes
    }

    #[test]
    fn colors_in_the_middle_are_counted_and_those_around_are_not() {
        let inside = |x: u32, y: u32| (3..7).contains(&x) && (2..6).contains(&y);
        let bytes = picture([10, 8], inside);
        assert_eq!(Xwd::read(&bytes).unwrap().colors_in_middle(4), 16);
        assert_eq!(Xwd::read(&bytes).unwrap().colors_in_middle(100), 17, "and the surrounding color");
        let bytes = picture([10, 8], |x, y| !inside(x, y));
        assert_eq!(Xwd::read(&bytes).unwrap().colors_in_middle(4), 1, "negative control");
    }

    #[test]
    fn other_bytes_are_no_picture() {
        let bytes = picture([10, 8], |_, _| true);
        assert!(Xwd::read(&bytes).is_some());
        assert!(Xwd::read(&bytes[..bytes.len() - 1]).is_none() && Xwd::read(&[]).is_none());
        for (place, value) in [(1, 6), (11, 16), (12, 39), (4, u32::MAX), (0, u32::MAX), (19, u32::MAX)] {
            let mut bytes = bytes.clone();
            bytes[4 * place..4 * place + 4].copy_from_slice(&u32::to_be_bytes(value));
            assert!(Xwd::read(&bytes).is_none(), "{place}");
        }
    }
}
