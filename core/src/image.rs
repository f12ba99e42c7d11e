//! A floating-point RGB picture.

use glam::Vec3;
use std::path::PathBuf;
use thiserror::Error;

mod region;

pub use region::{Region, RegionError};

/// Why a picture cannot be read or written.
#[derive(Debug, Error)]
pub enum ImageError {
    /// The file system reports an error.
    #[error("cannot {action} the picture: {source}; check the path, the permissions and the free space ({})", path.display())]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The contents are damaged, of a foreign format, or use what is not supported.
    #[error("the picture cannot be read: {reason}; export it again as png, jpg, tga, hdr or exr ({})", path.display())]
    Decode {
        /// Path of the file.
        path: PathBuf,
        /// Error of the decoder.
        reason: String,
    },
    /// The file ends before the picture does.
    #[error("the picture is truncated: {reason}; copy or export it again ({})", path.display())]
    Truncated {
        /// Path of the file.
        path: PathBuf,
        /// What is missing.
        reason: String,
    },
    /// The extension is not a writable format.
    #[error("the extension of the output is not a picture format; end the name in .exr, .hdr or .png ({})", path.display())]
    UnknownExtension {
        /// Path of the file.
        path: PathBuf,
    },
    /// The file has no layer of this name.
    #[error("there is no layer \"{name}\"; {has} ({})", path.display())]
    NoLayer {
        /// Path of the file.
        path: PathBuf,
        /// The requested name.
        name: String,
        /// The existing layers, in words.
        has: String,
    },
    /// There is too little memory for the picture.
    #[error("the picture takes {needed} MB of memory, but {available} MB are free; reduce its size or close other programs ({})", path.display())]
    Memory {
        /// Path of the file.
        path: PathBuf,
        /// Memory for decoding, in megabytes.
        needed: u64,
        /// Free memory, in megabytes.
        available: u64,
    },
    /// The picture has more pixels than the limit.
    #[error("a picture of {width} x {height} is larger than the limit of {limit} pixels; reduce its size ({})", path.display())]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Width in pixels.
        width: u64,
        /// Height in pixels.
        height: u64,
        /// The limit in pixels.
        limit: u64,
    },
}

/// A picture of scene-linear RGB, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// `width * height` pixels.
    pub pixels: Vec<Vec3>,
}

impl Image {
    /// A picture of one color.
    pub fn filled(size: [u32; 2], value: Vec3) -> Self {
        Self { size, pixels: vec![value; size[0] as usize * size[1] as usize] }
    }

    /// A picture with pixels computed from column and row.
    pub fn from_fn(size: [u32; 2], mut f: impl FnMut(u32, u32) -> Vec3) -> Self {
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| f(x, y)).collect();
        Self { size, pixels }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.size[0] as usize
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.size[1] as usize
    }

    /// The pixel at column `x`, row `y`.
    pub fn at(&self, x: usize, y: usize) -> Vec3 {
        self.pixels[y * self.width() + x]
    }

    /// Adds another picture of the same size.
    pub fn add(&mut self, other: &Self) {
        assert_eq!(self.size, other.size, "pictures of one size");
        self.pixels.iter_mut().zip(&other.pixels).for_each(|(sum, value)| *sum += *value);
    }

    /// Every pixel times `factor`.
    pub fn scaled(&self, factor: f32) -> Self {
        Self { size: self.size, pixels: self.pixels.iter().map(|&p| p * factor).collect() }
    }

    /// A region of the picture.
    ///
    /// # Panics
    /// If the region reaches beyond the picture.
    pub fn crop(&self, region: Region) -> Self {
        let rows = region.rows().map(|y| &self.pixels[y as usize * self.width()..][..self.width()]);
        let pixels = rows.flat_map(|row| &row[region.columns().start as usize..region.columns().end as usize]);
        Self { size: region.size(), pixels: pixels.copied().collect() }
    }

    /// The pixels whose column and row are multiples of `step`, as a smaller picture.
    pub fn every(&self, step: u32) -> Self {
        let size = self.size.map(|side| side.div_ceil(step));
        Self::from_fn(size, |x, y| self.at((x * step) as usize, (y * step) as usize))
    }
}
