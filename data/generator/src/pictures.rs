//! Paints images pixel by pixel, and writes them.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use glam::{Vec2, Vec3, vec2, vec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, Luma, RgbImage};
use lapidary_core::color::srgb_from_linear;

/// A 16-bit gray image: 8 bits would show as terraces in a bump map.
pub type Gray16 = ImageBuffer<Luma<u16>, Vec<u16>>;

/// Paints linear Rec. 709 colors into an sRGB image; `paint` gets the pixel center in [0, 1), top left first.
pub fn paint_color(size: u32, paint: impl Fn(Vec2) -> Vec3) -> RgbImage {
    paint_data(size, |uv| paint(uv).map(srgb_from_linear))
}

/// Paints numbers in [0, 1] without encoding.
pub fn paint_data(size: u32, paint: impl Fn(Vec2) -> Vec3) -> RgbImage {
    RgbImage::from_fn(size, size, |x, y| {
        let value = paint(pixel_centre(x, y, size)).clamp(Vec3::ZERO, Vec3::ONE);
        image::Rgb(value.to_array().map(|c| (c * 255.0 + 0.5) as u8))
    })
}

/// Paints heights in [0, 1]. The lowest four bits stay empty: they would be noise, and do not compress.
pub fn paint_height(size: u32, height: impl Fn(Vec2) -> f32) -> Gray16 {
    Gray16::from_fn(size, size, |x, y| {
        let value = height(pixel_centre(x, y, size)).clamp(0.0, 1.0);
        Luma([((value * 4095.0 + 0.5) as u16) << 4])
    })
}

/// Tangent-space normal map (+Y up) of a tiling height field in [0, 1] that is `depth` tiles deep.
pub fn paint_normals(size: u32, depth: f32, height: impl Fn(Vec2) -> f32) -> RgbImage {
    let step = 1.0 / size as f32;
    paint_data(size, |uv| {
        let slope_x = height(uv + vec2(step, 0.0)) - height(uv - vec2(step, 0.0));
        let slope_y = height(uv - vec2(0.0, step)) - height(uv + vec2(0.0, step));
        let normal = vec3(-slope_x, -slope_y, 2.0 * step / depth).normalize();
        0.5 * normal + 0.5
    })
}

/// Writes an 8-bit RGB PNG.
pub fn save_png(picture: &RgbImage, path: &Path) -> Result<()> {
    save(picture.as_raw(), picture.dimensions(), ExtendedColorType::Rgb8, path)
}

/// Writes a 16-bit gray PNG.
pub fn save_png16(picture: &Gray16, path: &Path) -> Result<()> {
    save(bytemuck::cast_slice(picture.as_raw()), picture.dimensions(), ExtendedColorType::L16, path)
}

/// Filters to try. Choosing row by row (`Adaptive`) is up to a third larger than one filter for all rows of a noisy
/// picture; `Paeth` and no filter were never the smallest.
const FILTERS: [FilterType; 4] = [FilterType::Sub, FilterType::Up, FilterType::Avg, FilterType::Adaptive];

/// Writes a file with the filter that compresses best in a quick trial.
fn save(bytes: &[u8], size: (u32, u32), color: ExtendedColorType, path: &Path) -> Result<()> {
    let encoded = compact(bytes, size, color).with_context(|| format!("cannot encode {}", path.display()))?;
    fs::write(path, encoded).with_context(|| format!("cannot write {}", path.display()))
}

fn compact(bytes: &[u8], size: (u32, u32), color: ExtendedColorType) -> Result<Vec<u8>> {
    let encode = |compression, filter| encode(bytes, size, color, compression, filter);
    let trial = |filter| Ok((encode(CompressionType::Level(1), filter)?.len(), filter));
    let trials = FILTERS.into_iter().map(trial).collect::<Result<Vec<_>>>()?;
    let (_, filter) = trials.into_iter().min_by_key(|(bytes, _)| *bytes).context("no filter is tried")?;
    encode(CompressionType::Best, filter)
}

fn encode(
    bytes: &[u8],
    (width, height): (u32, u32),
    color: ExtendedColorType,
    compression: CompressionType,
    filter: FilterType,
) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, compression, filter).write_image(bytes, width, height, color)?;
    Ok(file)
}

fn pixel_centre(x: u32, y: u32, size: u32) -> Vec2 {
    vec2(x as f32 + 0.5, y as f32 + 0.5) / size as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filter_chosen_is_small_and_keeps_every_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let (color, gray) = (folder.path().join("color.png"), folder.path().join("gray.png"));
        let picture = paint_color(128, crate::textures::walnut);
        let heights = paint_height(64, |uv| crate::textures::hammered(uv, 4));
        save_png(&picture, &color).unwrap();
        save_png16(&heights, &gray).unwrap();
        assert_eq!(image::open(&color).unwrap().into_rgb8(), picture);
        assert_eq!(image::open(&gray).unwrap().into_luma16(), heights);
        let best = |filter| {
            let (size, color) = (picture.dimensions(), ExtendedColorType::Rgb8);
            encode(picture.as_raw(), size, color, CompressionType::Best, filter).unwrap().len()
        };
        let chosen = fs::read(&color).unwrap().len();
        assert!(chosen == FILTERS.map(best).into_iter().min().unwrap() && chosen < best(FilterType::Adaptive));
    }
}
