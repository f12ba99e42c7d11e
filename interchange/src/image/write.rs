//! Encodes pictures, and replaces a file only when its successor is complete.

use super::PictureFormat;
use super::layers::{Layer, LayeredImage, Metadata};
use crate::file_format::FileFormat;
use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder, Rgb, codecs::hdr::HdrEncoder, codecs::png::PngEncoder};
use lapidary_core::{
    color::codes_from_linear,
    image::{Image, ImageError},
    output::write_atomically,
};
use std::{io, path::Path};

/// Writes a picture in the [`PictureFormat`] of `path`'s extension to a temporary name, and renames it when complete.
///
/// # Errors
/// An unknown extension, or a file that cannot be written; an old file then stays.
pub fn write(image: &Image, path: &Path) -> Result<(), ImageError> {
    write_with(image, None, path)
}

/// [`write()`] with an alpha channel, one value per pixel; the picture is premultiplied. hdr files are written without
/// alpha, which the format lacks.
///
/// # Errors
/// See [`write()`].
pub fn write_with(image: &Image, coverage: Option<&[f32]>, path: &Path) -> Result<(), ImageError> {
    let bytes = encode(image, coverage, path)?;
    write_atomically(path, &bytes).map_err(|source| ImageError::Io { action: "write", path: path.into(), source })
}

/// Encodes the picture in the format of `path`'s extension. `coverage` becomes its alpha channel.
///
/// # Errors
/// An extension without a writable format.
pub(super) fn encode(image: &Image, coverage: Option<&[f32]>, path: &Path) -> Result<Vec<u8>, ImageError> {
    let encode = PictureFormat::of(path).and_then(|format| format.encode);
    let encode = encode.ok_or_else(|| ImageError::UnknownExtension { path: path.into() })?;
    encode(image, coverage).map_err(|source| ImageError::Io { action: "write", path: path.into(), source })
}

/// OpenEXR of 32-bit floats, premultiplied if it has an alpha channel.
pub(super) fn encode_exr(image: &Image, coverage: Option<&[f32]>) -> io::Result<Vec<u8>> {
    let colors = Layer::color("", image);
    let layer = match coverage {
        Some(coverage) => colors.with_alpha(coverage),
        None => colors,
    };
    LayeredImage { size: image.size, layers: vec![layer], metadata: Metadata::default() }.encode()
}

/// Radiance RGBE, which has no alpha channel and holds neither negative values nor NaN: both become zero.
pub(super) fn encode_hdr(image: &Image, _: Option<&[f32]>) -> io::Result<Vec<u8>> {
    let pixels: Vec<Rgb<f32>> =
        image.pixels.iter().map(|p| Rgb(p.to_array().map(|c| if c > 0.0 { c.min(1e38) } else { 0.0 }))).collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes).encode(&pixels, image.width(), image.height()).map_err(io::Error::other)?;
    Ok(bytes)
}

/// The picture as an 8-bit sRGB png with an alpha channel, `alpha` from 0 to 1 per pixel; colors are not premultiplied.
///
/// # Panics
/// If there is not one alpha per pixel.
fn encode_png_with_alpha(image: &Image, alpha: &[f32]) -> Vec<u8> {
    assert_eq!(image.pixels.len(), alpha.len(), "one alpha per pixel");
    let pixel = |(&color, alpha): (&Vec3, &f32)| {
        let [r, g, b] = srgb_bytes(color);
        [r, g, b, (255.0 * alpha.clamp(0.0, 1.0) + 0.5) as u8]
    };
    let bytes: Vec<u8> = image.pixels.iter().zip(alpha).flat_map(pixel).collect();
    png(&bytes, image.size, ExtendedColorType::Rgba8)
}

/// Pixels in the encoding of an 8-bit png: sRGB-encoded red, green and blue, and a straight alpha. The file has an
/// alpha channel if some pixel is not opaque.
///
/// # Panics
/// If there are not `width * height` pixels.
pub fn encode_png_pixels(size: [u32; 2], pixels: &[[u8; 4]]) -> Vec<u8> {
    assert_eq!(pixels.len(), size[0] as usize * size[1] as usize, "width * height pixels");
    if pixels.iter().any(|pixel| pixel[3] != 255) {
        return png(pixels.as_flattened(), size, ExtendedColorType::Rgba8);
    }
    let opaque: Vec<u8> = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    png(&opaque, size, ExtendedColorType::Rgb8)
}

/// The picture as an 8-bit sRGB png: values are clamped to 0 to 1, and NaN shows magenta.
pub fn encode_png(image: &Image) -> Vec<u8> {
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|&p| srgb_bytes(p)).collect();
    png(&bytes, image.size, ExtendedColorType::Rgb8)
}

fn png(bytes: &[u8], [width, height]: [u32; 2], color: ExtendedColorType) -> Vec<u8> {
    let mut encoded = Vec::new();
    PngEncoder::new(&mut encoded)
        .write_image(bytes, width, height, color)
        .expect("writing to memory does not fail and the buffer has the size of the picture");
    encoded
}

/// An 8-bit sRGB png, with an alpha channel if there is coverage.
pub(super) fn encode_png_with(image: &Image, coverage: Option<&[f32]>) -> io::Result<Vec<u8>> {
    Ok(coverage.map_or_else(|| encode_png(image), |coverage| encode_png_premultiplied(image, coverage)))
}

/// A premultiplied picture as png, with straight alpha.
fn encode_png_premultiplied(image: &Image, coverage: &[f32]) -> Vec<u8> {
    let straight = |(&p, &a): (&Vec3, &f32)| if a > 0.0 { p / a } else { Vec3::ZERO };
    let pixels = image.pixels.iter().zip(coverage).map(straight).collect();
    encode_png_with_alpha(&Image { size: image.size, pixels }, coverage)
}

pub(crate) fn srgb_bytes(linear: Vec3) -> [u8; 3] {
    if linear.is_nan() {
        return [255, 0, 255];
    }
    codes_from_linear(linear)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{decode, read};
    use lapidary_core::texture::Texels;

    fn picture() -> Image {
        Image::from_fn([9, 5], |x, y| Vec3::new(0.1 * x as f32, 300.0 * y as f32, 70_000.0))
    }

    #[test]
    fn alpha_is_written_beside_the_colours() {
        let image = Image::from_fn([2, 1], |x, _| Vec3::splat(x as f32));
        let bytes = encode_png_with_alpha(&image, &[0.0, 0.5]);
        let read = ::image::load_from_memory(&bytes).unwrap().into_rgba8();
        assert_eq!(read.as_raw()[..], [0, 0, 0, 0, 255, 255, 255, 128]);
    }

    #[test]
    fn exr_is_exact_and_hdr_keeps_seven_bits() {
        let folder = tempfile::tempdir().unwrap();
        let image = picture();
        write(&image, &folder.path().join("a.exr")).unwrap();
        assert_eq!(read(&folder.path().join("a.exr")).unwrap(), image);
        let image = Image::from_fn([9, 5], |x, y| Vec3::new(2.1, 2.0 + 0.37 * x as f32, 1.0 + 0.73 * y as f32));
        write(&image, &folder.path().join("a.HDR")).unwrap();
        let read = read(&folder.path().join("a.HDR")).unwrap();
        // Eight bits of the brightest channel, which fills at least half of their range.
        let miss = |(a, b): (&Vec3, &Vec3)| (*a - *b).abs().max_element() / b.max_element();
        let worst = read.pixels.iter().zip(&image.pixels).map(miss).fold(0.0, f32::max);
        assert!(worst <= 1.0 / 128.0 && worst > 1.0 / 512.0, "{worst}");
    }

    #[test]
    fn coverage_becomes_alpha_premultiplied_in_exr_and_not_in_png() {
        let image = Image { size: [2, 1], pixels: vec![Vec3::splat(0.25), Vec3::ZERO] };
        let coverage = [0.5, 0.0];
        let png = encode(&image, Some(&coverage), Path::new("a.png")).unwrap();
        let texture = decode(&png, Path::new("a.png")).unwrap();
        assert_eq!(texture.texels, Texels::U8(vec![[188, 188, 188, 128], [0; 4]]));
        let exr = encode(&image, Some(&coverage), Path::new("a.exr")).unwrap();
        let texture = decode(&exr, Path::new("a.exr")).unwrap();
        assert_eq!(texture.texels, Texels::F32(vec![[0.25, 0.25, 0.25, 0.5], [0.0; 4]]));
    }

    #[test]
    fn png_clamps_and_shows_nan_magenta() {
        let values = [Vec3::splat(-1.0), Vec3::splat(9.0), Vec3::new(0.0, f32::NAN, 0.0), Vec3::splat(0.215_86)];
        let image = Image { size: [4, 1], pixels: values.to_vec() };
        let texture = decode(&encode_png(&image), Path::new("a.png")).unwrap();
        let expected = vec![[0, 0, 0, 255], [255; 4], [255, 0, 255, 255], [128, 128, 128, 255]];
        assert_eq!(texture.texels, Texels::U8(expected));
    }

    #[test]
    fn an_unknown_extension_is_an_error_that_names_the_known_ones() {
        let message = write(&picture(), Path::new("a.gif")).unwrap_err().to_string();
        let known = PictureFormat::all_endings(PictureFormat::is_written);
        assert!(known.iter().all(|ending| message.contains(&format!(".{ending}"))), "{message}");
        assert!(known.len() == 3 && message.ends_with("(a.gif)"), "{message}");
    }

    #[test]
    fn a_folder_that_is_missing_is_an_error() {
        let missing = tempfile::tempdir().unwrap().path().join("missing/a.png");
        assert!(matches!(write(&picture(), &missing), Err(ImageError::Io { action: "write", .. })));
    }
}
