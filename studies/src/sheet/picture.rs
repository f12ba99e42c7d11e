//! A picture as displayed.

use anyhow::{Context, Result};
use glam::Vec3;
use lapidary_core::{
    color::{codes, codes_from_linear, linear_from_codes},
    image::Image,
    output::write_atomically,
};
use lapidary_interchange::image::encode_png_pixels;
use lapidary_render::{Post, vignetted};
use std::{ops::Range, path::Path};

/// sRGB-encoded pixels with straight (not premultiplied) alpha, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayPicture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// `width * height` pixels: red, green, blue, alpha.
    pub pixels: Vec<[u8; 4]>,
}

impl DisplayPicture {
    /// An opaque picture of one color.
    pub fn filled(size: [u32; 2], [r, g, b]: [u8; 3]) -> Self {
        Self { size, pixels: vec![[r, g, b, 255]; size[0] as usize * size[1] as usize] }
    }

    /// Scene-linear radiance after exposure, vignette and tone curve, opaque; NaN is magenta.
    pub fn shown(image: &Image, post: &Post) -> Self {
        let width = image.size[0].max(1);
        let place = |pixel: u32| [pixel % width, pixel / width];
        let light = |pixel: u32| vignetted(post.vignette, place(pixel), image.size);
        let shown = (0..).zip(&image.pixels).map(|(pixel, &radiance)| post.display(radiance * light(pixel)));
        Self::of_display(image.size, shown)
    }

    /// An opaque picture of display values from 0 to 1.
    pub fn of_display(size: [u32; 2], values: impl Iterator<Item = Vec3>) -> Self {
        let pixel = |value| {
            let [r, g, b] = codes(value);
            [r, g, b, 255]
        };
        Self { size, pixels: values.map(pixel).collect() }
    }

    /// Draws `over` on this picture with its top left corner at `at`, blended by its alpha and clipped.
    pub fn paste(&mut self, over: &Self, [left, top]: [u32; 2]) {
        for y in 0..over.size[1].min(self.size[1].saturating_sub(top)) {
            for x in 0..over.size[0].min(self.size[0].saturating_sub(left)) {
                let [r, g, b, alpha] = over.pixels[over.index(x, y)];
                self.blend([left + x, top + y], [r, g, b], alpha);
            }
        }
    }

    /// Mixes `color` into one pixel with weight `alpha`; positions outside are ignored.
    pub fn blend(&mut self, [x, y]: [u32; 2], color: [u8; 3], alpha: u8) {
        if x >= self.size[0] || y >= self.size[1] {
            return;
        }
        let place = self.index(x, y);
        let [.., below] = self.pixels[place];
        let mix = |i: usize| {
            let (old, new) = (u32::from(self.pixels[place][i]), u32::from(color[i]));
            ((old * (255 - u32::from(alpha)) + new * u32::from(alpha) + 127) / 255) as u8
        };
        self.pixels[place] = [mix(0), mix(1), mix(2), below.max(alpha)];
    }

    /// The picture shrunk to at most `most` pixels per side: means, in linear light, of the pixels that each new one covers. A
    /// smaller picture is unchanged.
    pub fn shrunk(&self, most: u32) -> Self {
        let longest = self.size[0].max(self.size[1]);
        if longest <= most.max(1) {
            return self.clone();
        }
        let side = |side: u32| ((u64::from(side) * u64::from(most.max(1)) / u64::from(longest)) as u32).max(1);
        let size = self.size.map(side);
        let place = |i: u32| [i % size[0], i / size[0]];
        let pixels = (0..size[0] * size[1]).map(|i| self.mean_under(place(i), size)).collect();
        Self { size, pixels }
    }

    fn mean_under(&self, [x, y]: [u32; 2], size: [u32; 2]) -> [u8; 4] {
        let columns = covered(x, size[0], self.size[0]);
        let rows = covered(y, size[1], self.size[1]);
        let (mut color, mut alpha, mut count) = (Vec3::ZERO, 0.0, 0.0);
        for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
            let [r, g, b, a] = self.pixels[self.index(column, row)];
            let a = f32::from(a) / 255.0;
            color += a * linear_from_codes([r, g, b]);
            alpha += a;
            count += 1.0;
        }
        let straight = if alpha > 0.0 { color / alpha } else { Vec3::ZERO };
        let [r, g, b] = codes_from_linear(straight);
        [r, g, b, (255.0 * alpha / count + 0.5) as u8]
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.size[0] as usize + x as usize
    }

    /// Writes a png under a temporary name until complete.
    ///
    /// # Errors
    /// The file system's error; an existing file is kept then.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_atomically(path, &encode_png_pixels(self.size, &self.pixels)).with_context(|| {
            format!("cannot write the picture; check the free space and permissions ({})", path.display())
        })
    }
}

/// The range of `from` pixels that the `i`-th of `to` covers; at least one.
fn covered(i: u32, to: u32, from: u32) -> Range<u32> {
    let at = |i: u32| (u64::from(i) * u64::from(from) / u64::from(to)) as u32;
    at(i)..at(i + 1).max(at(i) + 1)
}
