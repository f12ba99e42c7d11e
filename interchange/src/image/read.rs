//! Decoding of picture files by their contents. The `image` crate reads png, jpg, tga, webp and most of tiff.
//!
//! Headers are checked before memory is allocated: sizes against [`MAX_PIXELS`] and the free memory, channels by name.

use super::{
    ktx2,
    layer_path::{file_and_layer, name_of},
    open_exr::{self, EXR_MAGIC},
    radiance,
    remark::Remark,
    tiff,
};
use glam::Vec3;
use image::{
    ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits,
    error::{ImageFormatHint, UnsupportedError},
};
use lapidary_core::{
    image::{Image, ImageError},
    input, memory,
    texture::{ColorSpace, Texels, Texture},
};
use std::{
    io::{BufReader, Cursor},
    path::Path,
    sync::Arc,
};

/// Largest readable picture in pixels: 16k x 16k, 4 GiB as four floats per pixel.
const MAX_PIXELS: u64 = 1 << 28;

/// Reads a texture from a picture file, or from a layer of it ([`file_and_layer`]). Texels out of range are replaced, see
/// [`Texels::sanitize`].
///
/// # Errors
/// A file that is unreadable, not a picture, or too large.
pub fn read_texture(path: &Path) -> Result<Texture, ImageError> {
    let (file, layer) = file_and_layer(path);
    let mut texture = decode_with(&contents(file)?, file, layer, &mut Vec::new())?;
    texture.texels.sanitize();
    Ok(texture)
}

fn contents(file: &Path) -> Result<Vec<u8>, ImageError> {
    input::read(file).map_err(|source| ImageError::Io { action: "read", path: file.into(), source })
}

/// Reads a picture file, or a layer of it ([`file_and_layer`]), with the colors that it says to have; 8-bit pictures are decoded
/// from sRGB.
///
/// # Errors
/// A file that is unreadable, not a picture, or too large, lacks the layer, shows none by default, or says what its colors are
/// in a way that cannot be used.
pub fn read(path: &Path) -> Result<Image, ImageError> {
    let (file, layer) = file_and_layer(path);
    let (image, remarks) = linear_image(file, layer, ColorSpace::Srgb)?;
    remarks.first().map_or(Ok(image), |remark| Err(remark.refusal(file)))
}

/// Reads a picture file, or a layer of it, whose colors are in this space. Of a file that shows no layer by default, the first
/// is read. Also returns that, and primaries that cannot be used, as sentences: such colors are taken for linear Rec. 709.
///
/// The space replaces what the file says of its colors: the primaries that it names, and the XYZ of a Radiance file.
///
/// # Errors
/// A file that is unreadable, not a picture, or too large, lacks the layer, or has scales that cannot be used.
pub fn read_in(path: &Path, color_space: ColorSpace) -> Result<(Image, Vec<String>), ImageError> {
    let (file, layer) = file_and_layer(path);
    let (image, mut remarks) = linear_image(file, layer, color_space)?;
    remarks.retain(|remark| !remark.is_settled_by(color_space));
    match remarks.iter().find(|remark| matches!(remark, Remark::Scale(_))) {
        Some(remark) => Err(remark.refusal(file)),
        None => Ok((image, remarks.iter().map(Remark::text).collect())),
    }
}

/// Reads one layer of an OpenEXR file: its colors in Rec. 709, its vectors, or its single channel repeated. Names match in any
/// case, `-` matches `_`, and the last words of a long name suffice; `beauty` also means the unnamed layer.
///
/// # Errors
/// A file that is unreadable or lacks the layer.
pub fn read_layer(path: &Path, name: &str) -> Result<Image, ImageError> {
    let (file, _) = file_and_layer(path);
    let (image, remarks) = linear_image(file, Some(name), ColorSpace::Srgb)?;
    remarks.first().map_or(Ok(image), |remark| Err(remark.refusal(file)))
}

/// Decodes the bytes of a picture called `path`, and keeps them with the texture. Of an OpenEXR file, the layer that it shows by
/// default is decoded. `path` tells the format where the bytes do not. It never names a layer: a texture that was kept shows its
/// layer by default, whatever its name.
///
/// Files of 8 and 16 bits keep their codes, because only the slot that uses them knows their encoding (sRGB or linear).
///
/// # Errors
/// Damaged, foreign or oversized contents.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Texture, ImageError> {
    decode_with(bytes, path, None, &mut Vec::new())
}

/// The same as [`decode`] for a layer of an OpenEXR file, which alone is kept; `remarks` gets sentences on what of the header
/// cannot be used and is left out.
///
/// # Errors
/// Damaged, foreign or oversized contents, or such without the layer.
pub fn decode_with(
    bytes: &[u8],
    path: &Path,
    layer: Option<&str>,
    remarks: &mut Vec<String>,
) -> Result<Texture, ImageError> {
    let mut found = Vec::new();
    let (size, texels) = texels(bytes, path, layer, &mut found)?;
    remarks.extend(found.iter().map(Remark::text));
    let alone = layer.map_or(Ok(None), |layer| open_exr::alone(bytes, path, layer))?;
    let encoded = alone.map_or_else(|| Arc::from(bytes), Arc::from);
    Ok(Texture { encoded, ..Texture::new(name_of(path, layer), size, texels) })
}

fn texels(
    bytes: &[u8],
    path: &Path,
    layer: Option<&str>,
    remarks: &mut Vec<Remark>,
) -> Result<([u32; 2], Texels), ImageError> {
    footprint(bytes, path)?.check(memory::available(), path)?;
    match layer {
        _ if bytes.starts_with(&EXR_MAGIC) => open_exr::decode(bytes, path, layer, remarks),
        Some(name) => {
            let has = "only exr files have layers".into();
            Err(ImageError::NoLayer { path: path.into(), name: name.into(), has })
        }
        None if bytes.starts_with(radiance::SIGNATURE) => radiance::decode(bytes, path, remarks),
        None if bytes.starts_with(ktx2::SIGNATURE) => ktx2::decode(bytes, path),
        None if tiff::is_of_gray_floats(bytes) => tiff::decode(bytes, path),
        None => decode_common(bytes, path),
    }
}

/// Memory of a picture, estimated from its header alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Footprint {
    /// Bytes of its texels as a texture.
    pub held: u64,
    /// Bytes of its levels of detail: a third of the texels, which are floats beyond 8 bits. A slot that gives primaries to a
    /// picture of 8 bits makes them floats too, and four times as large.
    pub levels: u64,
    /// Additional bytes for the decoder.
    pub decoding: u64,
}

impl Footprint {
    pub(super) fn of(pixels: u64, depth: Depth, decoding: u64) -> Self {
        let [held, of_level] = match depth {
            Depth::Eight => [4, 4],
            Depth::Sixteen => [8, 16],
            Depth::Float => [16, 16],
        };
        Self { held: pixels.saturating_mul(held), levels: pixels.saturating_mul(of_level) / 3, decoding }
    }

    pub(super) fn check(self, available: Option<u64>, path: &Path) -> Result<(), ImageError> {
        let needed = self.held.saturating_add(self.decoding);
        match available {
            Some(available) if needed > available => {
                let [needed, available] = memory::in_megabytes(needed, available);
                Err(ImageError::Memory { path: path.into(), needed, available })
            }
            _ => Ok(()),
        }
    }
}

/// The memory that [`decode`] takes for the bytes of a picture called `path`.
///
/// # Errors
/// Damaged, foreign or oversized contents.
pub fn footprint(bytes: &[u8], path: &Path) -> Result<Footprint, ImageError> {
    if bytes.starts_with(&EXR_MAGIC) {
        // Only one of the parts is decoded.
        let parts = open_exr::headers(bytes, path)?;
        let largest = parts.iter().map(open_exr::Part::of).max_by_key(|part| part.samples).unwrap_or_default();
        return Ok(Footprint::of(largest.pixels, Depth::Float, largest.samples));
    }
    if bytes.starts_with(radiance::SIGNATURE) {
        let [width, height] = radiance::Header::read(bytes, path)?.size().map(u64::from);
        return Ok(Footprint::of(width * height, Depth::Float, width * height * 16));
    }
    if bytes.starts_with(ktx2::SIGNATURE) {
        return ktx2::footprint(bytes, path);
    }
    if tiff::is_of_gray_floats(bytes) {
        return tiff::footprint(bytes, path);
    }
    let format = format_of(bytes, path)?;
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder();
    let decoder = decoder.map_err(|e| undecodable(path, e))?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), path)?;
    let pixels = u64::from(width) * u64::from(height);
    let footprint = Footprint::of(pixels, Depth::of(decoder.color_type()), decoder.total_bytes());
    Ok(Footprint { decoding: footprint.held.max(footprint.decoding), ..footprint })
}

/// Width and height of a picture file that the `image` crate reads, from its header alone.
///
/// # Errors
/// A file that is unreadable, or not such a picture.
pub fn dimensions(path: &Path) -> Result<[u32; 2], ImageError> {
    let io_error = |source| ImageError::Io { action: "read", path: path.into(), source };
    let file = BufReader::new(input::open(path).map_err(io_error)?);
    let mut reader = ImageReader::new(file);
    if let Ok(format) = ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let reader = reader.with_guessed_format().map_err(io_error)?;
    let (width, height) = reader.into_dimensions().map_err(|e| undecodable(path, e))?;
    Ok([width, height])
}

/// The RGB texels of a picture file, scene-linear in Rec. 709.
fn linear_image(file: &Path, layer: Option<&str>, color_space: ColorSpace) -> Result<(Image, Vec<Remark>), ImageError> {
    let mut remarks = Vec::new();
    let (size, texels) = texels(&contents(file)?, file, layer, &mut remarks)?;
    Ok((Image { size, pixels: linear_pixels(&texels, color_space) }, remarks))
}

fn linear_pixels(texels: &Texels, color_space: ColorSpace) -> Vec<Vec3> {
    (0..texels.count()).map(|i| texels.at(i, color_space).truncate()).collect()
}

pub(super) fn damaged(path: &Path, reason: impl ToString) -> ImageError {
    ImageError::Decode { path: path.into(), reason: reason.to_string() }
}

pub(super) fn truncated(path: &Path, reason: &str) -> ImageError {
    ImageError::Truncated { path: path.into(), reason: reason.into() }
}

/// An error of the `image` crate: a file that ends too early is told from one that is damaged or not supported.
pub(super) fn undecodable(path: &Path, error: image::ImageError) -> ImageError {
    let ends_early = |error: &std::io::Error| error.kind() == std::io::ErrorKind::UnexpectedEof;
    let cause = std::error::Error::source(&error).and_then(|source| source.downcast_ref());
    match &error {
        image::ImageError::IoError(error) if ends_early(error) => truncated(path, "bytes are missing"),
        _ if cause.is_some_and(ends_early) => truncated(path, "bytes are missing"),
        image::ImageError::Unsupported(what) => damaged(path, unsupported(what)),
        _ => damaged(path, &error),
    }
}

/// What of a format is not supported, in words.
fn unsupported(error: &UnsupportedError) -> String {
    let format = match error.format_hint() {
        ImageFormatHint::Exact(format) => format.extensions_str()[0],
        _ => "picture",
    };
    format!("it is a {format} of a kind that is not supported")
}

pub(super) fn check_size(width: u64, height: u64, path: &Path) -> Result<(), ImageError> {
    if width == 0 || height == 0 {
        return Err(damaged(path, "it has no pixels"));
    }
    match width.checked_mul(height) {
        Some(pixels) if pixels <= MAX_PIXELS => Ok(()),
        _ => Err(ImageError::TooLarge { path: path.into(), width, height, limit: MAX_PIXELS }),
    }
}

/// The format by the contents; tga has no signature and is identified by its extension.
fn format_of(bytes: &[u8], path: &Path) -> Result<ImageFormat, ImageError> {
    let by_name = ImageFormat::from_path(path).ok().filter(|f| *f == ImageFormat::Tga);
    let format = image::guess_format(bytes).ok().or(by_name);
    match format {
        Some(f) if f.reading_enabled() => Ok(f),
        Some(f) => Err(damaged(path, format!("{f:?} files are not supported"))),
        None if bytes.is_empty() => Err(damaged(path, "the file is empty")),
        None => Err(damaged(path, "its contents are of no known format")),
    }
}

fn decode_common(bytes: &[u8], path: &Path) -> Result<([u32; 2], Texels), ImageError> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format_of(bytes, path)?);
    let mut limits = Limits::default();
    limits.max_alloc = Some(24 * MAX_PIXELS); // sixteen bytes per pixel and what the decoder needs beside them
    reader.limits(limits);
    let decoded = reader.decode().map_err(|e| undecodable(path, e))?;
    Ok(([decoded.width(), decoded.height()], texels_of(decoded)))
}

fn texels_of(decoded: DynamicImage) -> Texels {
    match Depth::of(decoded.color()) {
        Depth::Eight => Texels::U8(decoded.into_rgba8().pixels().map(|p| p.0).collect()),
        Depth::Sixteen => Texels::U16(decoded.into_rgba16().pixels().map(|p| p.0).collect()),
        Depth::Float => Texels::F32(decoded.into_rgba32f().pixels().map(|p| p.0).collect()),
    }
}

/// What a component is stored as.
pub(super) enum Depth {
    Eight,
    Sixteen,
    Float,
}

impl Depth {
    fn of(color: ColorType) -> Self {
        match color {
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => Self::Sixteen,
            ColorType::Rgb32F | ColorType::Rgba32F => Self::Float,
            _ => Self::Eight,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{encode_png, write::encode};

    fn ramp() -> Image {
        Image::from_fn([13, 7], |x, y| Vec3::new(x as f32 / 12.0, y as f32 / 6.0, 0.25))
    }

    fn png(image: DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn sixteen_bits_stay_for_the_slot_to_decode() {
        let half = 257 * 128;
        let gray = png(DynamicImage::ImageLuma16(image::ImageBuffer::from_pixel(2, 1, image::Luma([half]))));
        let texture = decode(&gray, Path::new("height.png")).unwrap();
        assert_eq!(texture.texels, Texels::U16(vec![[half, half, half, 65535]; 2]));
        let value = |space| texture.texel(0, 0, space).x;
        assert!((value(ColorSpace::Linear) - 128.0 / 255.0).abs() < 1e-6, "as a height");
        assert!((value(ColorSpace::Srgb) - 0.2159).abs() < 1e-4, "as a color");
        // Negative control and comparison: 8 bits of the same gray.
        let eight = png(DynamicImage::ImageLuma8(image::ImageBuffer::from_pixel(2, 1, image::Luma([128]))));
        let eight = decode(&eight, Path::new("a.png")).unwrap();
        assert_eq!(eight.texels, Texels::U8(vec![[128, 128, 128, 255]; 2]));
        let [deep, codes] = [&texture, &eight].map(|t| linear_pixels(&t.texels, ColorSpace::Srgb)[0]);
        let difference = deep - codes;
        assert!(difference.abs().max_element() < 1e-6, "{difference}");
        let colour = DynamicImage::ImageRgb16(image::ImageBuffer::from_pixel(2, 1, image::Rgb([300, 0, 65535])));
        let texture = decode(&png(colour), Path::new("colour.png")).unwrap();
        assert_eq!(texture.texels, Texels::U16(vec![[300, 0, 65535, 65535]; 2]));
    }

    #[test]
    fn gentle_slopes_of_a_sixteen_bit_normal_map_are_no_steps() {
        // A slope from 0 to 0.02 over 256 texels; one step of 8 bits is 0.0078.
        let code = |x: u32| (32767.5 + 32767.5 * 0.02 * x as f32 / 255.0) as u16;
        let deep = image::ImageBuffer::from_fn(256, 1, |x, _| image::Rgb([code(x), 32768, 65535]));
        let steps = |image: DynamicImage| {
            let texture = decode(&png(image), Path::new("normal.png")).unwrap();
            let x = |i: i64| 2.0 * texture.texel(i, 0, ColorSpace::Linear).x - 1.0;
            (1..256).map(|i| x(i) - x(i - 1)).fold(0.0, f32::max)
        };
        let deep = DynamicImage::ImageRgb16(deep);
        assert!(steps(deep.clone()) < 1.5e-4);
        assert!(steps(deep.into_rgb8().into()) > 5e-3, "negative control: 8 bits");
    }

    #[test]
    fn a_tga_is_known_by_its_extension_only() {
        let mut tga = vec![0u8; 18];
        (tga[2], tga[12], tga[14], tga[16]) = (2, 1, 1, 24);
        tga.extend([10, 20, 30]);
        let texture = decode(&tga, Path::new("a.tga")).unwrap();
        assert_eq!(texture.texels, Texels::U8(vec![[30, 20, 10, 255]]));
        assert!(decode(&tga, Path::new("a.png")).is_err());
    }

    #[test]
    fn an_exr_without_rgb_or_y_names_its_channels() {
        use exr::prelude::{self as openexr, WritableImage};
        let channels = openexr::SpecificChannels::build().with_channel("depth").with_pixel_fn(|_| (1.0f32,));
        let mut bytes = Cursor::new(Vec::new());
        exr::image::Image::from_channels((4, 2), channels).write().to_buffered(&mut bytes).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("z.exr");
        std::fs::write(&path, bytes.get_ref()).unwrap();
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("depth") && message.ends_with("/z.exr)"), "{message}");
    }

    #[test]
    fn a_claimed_size_above_the_limit_is_refused_before_allocation() {
        let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
        let error = decode(header, Path::new("huge.hdr")).unwrap_err();
        assert!(matches!(error, ImageError::TooLarge { width: 60000, limit: MAX_PIXELS, .. }), "{error}");
    }

    #[test]
    fn the_memory_of_a_picture_is_known_from_its_header() {
        let of = |name: &str| {
            let path = Path::new(name);
            footprint(&encode(&ramp(), None, path).unwrap(), path).unwrap()
        };
        let pixels = 13 * 7;
        assert_eq!(of("a.png"), Footprint::of(pixels, Depth::Eight, 4 * pixels));
        assert_eq!(of("a.hdr"), Footprint::of(pixels, Depth::Float, 16 * pixels));
        assert_eq!(of("a.exr"), Footprint::of(pixels, Depth::Float, 12 * pixels));
        assert_eq!([Depth::Eight, Depth::Sixteen].map(|depth| Footprint::of(30, depth, 0).levels), [40, 160]);
        let message = of("a.png").check(Some(8 * pixels - 1), Path::new("a.png")).unwrap_err().to_string();
        assert!(message.contains("1 MB") && message.contains("0 MB") && message.ends_with("(a.png)"), "{message}");
        assert!(of("a.png").check(Some(8 * pixels), Path::new("a.png")).is_ok());
    }

    #[test]
    fn every_truncation_and_many_corruptions_are_errors_and_never_panics() {
        let random = &mut fastrand::Rng::with_seed(7);
        for name in ["a.exr", "a.hdr", "a.png"] {
            let path = Path::new(name);
            let whole = encode(&ramp(), None, path).unwrap();
            assert_eq!(decode(&whole, path).unwrap().size, [13, 7]);
            for length in 0..whole.len() {
                // The last bytes of a png are an empty chunk that decoders need not see.
                let accepted = decode(&whole[..length], path).is_ok();
                assert!(!accepted || length + 16 > whole.len(), "{name} cut to {length} of {}", whole.len());
            }
            let half = decode(&whole[..whole.len() / 2], path).unwrap_err();
            assert!(matches!(half, ImageError::Truncated { .. }), "{half}");
            for _ in 0..2000 {
                let mut bytes = whole.clone();
                let at = random.usize(..bytes.len());
                bytes[at] = random.u8(..);
                let _ = decode(&bytes, path);
            }
        }
    }

    #[test]
    fn eight_bit_pictures_decode_from_srgb() {
        let texture = decode(&encode_png(&ramp()), Path::new("a.png")).unwrap();
        let (read, expected) = (linear_pixels(&texture.texels, ColorSpace::Srgb), ramp());
        let worst = read.iter().zip(&expected.pixels).map(|(a, b)| (*a - *b).abs().max_element());
        assert!(worst.fold(0.0, f32::max) < 0.005);
        // Negative control: the same bytes read as linear are far off in the middle of the ramp.
        assert!((texture.texel(6, 3, ColorSpace::Linear).x - 0.5).abs() > 0.1);
    }
}
