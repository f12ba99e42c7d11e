//! KTX2 files with Basis Universal textures, as glTF's `KHR_texture_basisu` has them: ETC1S and UASTC, transcoded by the
//! crate `basisu`. Files with texels in a format of a graphics card are refused by name.

use super::read::{Depth, Footprint, check_size, damaged, truncated};
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use lapidary_core::{image::ImageError, texture::Texels};
use std::path::Path;

/// The first bytes of a file (KTX 2.0, section 3.1).
pub const SIGNATURE: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// Bytes of the header with its index.
const HEADER: usize = 80;

/// The memory that [`decode`] takes: the texels, and the blocks while they are inflated.
pub fn footprint(bytes: &[u8], path: &Path) -> Result<Footprint, ImageError> {
    let [width, height] = size(bytes, path)?.map(u64::from);
    Ok(Footprint::of(width * height, Depth::Eight, width * height * 5))
}

/// The size and the texels of the largest level.
pub fn decode(bytes: &[u8], path: &Path) -> Result<([u32; 2], Texels), ImageError> {
    let size = size(bytes, path)?;
    let broken = |_| damaged(path, "its Basis Universal texture is damaged");
    let texture = Transcoder::new(bytes).map_err(broken)?;
    if !texture.supports(TargetFormat::Rgba32) {
        let format = texture.source_format();
        return Err(damaged(path, format!("it is a KTX2 with {format:?} texels, and only ETC1S and UASTC are read")));
    }
    let texels = texture.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(broken)?;
    Ok((size, Texels::U8(texels.as_chunks().0.to_vec())))
}

/// Width and height. Checks that the file is a Basis Universal picture.
fn size(bytes: &[u8], path: &Path) -> Result<[u32; 2], ImageError> {
    if bytes.len() < HEADER {
        return Err(truncated(path, "its header is incomplete"));
    }
    let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
    let [format, width, height, depth, layers, faces] = [12, 20, 24, 28, 32, 36].map(word);
    if format != 0 {
        let reason = format!("it is a KTX2 in the format {format} of graphics cards, and only Basis Universal is read");
        return Err(damaged(path, reason));
    }
    if depth > 0 || layers > 1 || faces > 1 {
        return Err(damaged(path, "it is a KTX2 of several pictures, such as a cube map"));
    }
    check_size(width.into(), height.into(), path)?;
    Ok([width, height])
}
