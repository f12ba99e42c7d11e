//! TIFF files of gray floats, such as heights, which the `image` crate does not read.

use super::read::{Depth, Footprint, check_size, damaged};
use lapidary_core::{image::ImageError, texture::Texels};
use std::{io::Cursor, path::Path};
use tiff::{
    ColorType, TiffError,
    decoder::{Decoder, DecodingResult, Limits},
    tags::Tag,
};

/// The sample format of floats (TIFF 6.0, section 19).
const FLOATS: u16 = 3;

type Tiff<'a> = Decoder<Cursor<&'a [u8]>>;

/// Whether a file is a TIFF with one float per pixel.
pub fn is_of_gray_floats(bytes: &[u8]) -> bool {
    let is_gray = |mut tiff: Tiff| {
        let formats = tiff.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).ok().flatten().unwrap_or_default();
        matches!(tiff.colortype(), Ok(ColorType::Gray(_))) && formats.first() == Some(&FLOATS)
    };
    let is_tiff = bytes.starts_with(b"II*\0") || bytes.starts_with(b"MM\0*");
    is_tiff && Decoder::new(Cursor::new(bytes)).is_ok_and(is_gray)
}

/// The memory that [`decode`] takes.
pub fn footprint(bytes: &[u8], path: &Path) -> Result<Footprint, ImageError> {
    let [width, height] = size(&mut open(bytes, path)?, path)?.map(u64::from);
    Ok(Footprint::of(width * height, Depth::Float, width * height * 8))
}

/// The size and the texels.
pub fn decode(bytes: &[u8], path: &Path) -> Result<([u32; 2], Texels), ImageError> {
    let tiff = open(bytes, path)?;
    let mut tiff = tiff.with_limits(Limits::unlimited());
    let size = size(&mut tiff, path)?;
    let gray: Vec<f32> = match tiff.read_image().map_err(|error| unreadable(&error, path))? {
        DecodingResult::F16(samples) => samples.into_iter().map(f32::from).collect(),
        DecodingResult::F32(samples) => samples,
        DecodingResult::F64(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
        _ => return Err(damaged(path, "its samples are not the floats that its header names")),
    };
    Ok((size, Texels::F32(gray.into_iter().map(|gray| [gray, gray, gray, 1.0]).collect())))
}

fn open<'a>(bytes: &'a [u8], path: &Path) -> Result<Tiff<'a>, ImageError> {
    Decoder::new(Cursor::new(bytes)).map_err(|error| unreadable(&error, path))
}

fn size(tiff: &mut Tiff, path: &Path) -> Result<[u32; 2], ImageError> {
    let (width, height) = tiff.dimensions().map_err(|error| unreadable(&error, path))?;
    check_size(width.into(), height.into(), path)?;
    Ok([width, height])
}

fn unreadable(error: &TiffError, path: &Path) -> ImageError {
    match error {
        TiffError::IoError(_) => super::read::truncated(path, "bytes are missing"),
        _ => damaged(path, error),
    }
}
