//! The list of picture formats. The crates `image` and `exr` determine the readable ones.

use super::{
    ktx2,
    layer_path::file_and_layer,
    open_exr::EXR_MAGIC,
    radiance,
    write::{encode_exr, encode_hdr, encode_png_with},
};
use crate::file_format::FileFormat;
use lapidary_core::image::Image;
use std::{io, path::Path};

/// Writes a picture, with the coverage of its pixels if it has an alpha channel.
type Encode = fn(&Image, Option<&[f32]>) -> io::Result<Vec<u8>>;

/// A format of pictures.
pub struct PictureFormat {
    endings: &'static [&'static str],
    /// Any of these are the first bytes of a file; TGA has none.
    signatures: &'static [&'static [u8]],
    /// Whether its values are unbounded light, as in environments.
    pub is_light: bool,
    /// Encodes a picture with its coverage, if the format is writable.
    pub(super) encode: Option<Encode>,
}

impl FileFormat for PictureFormat {
    const ALL: &'static [Self] = &[
        Self { endings: &["png"], signatures: &[b"\x89PNG"], is_light: false, encode: Some(encode_png_with) },
        Self { endings: &["jpg", "jpeg"], signatures: &[&[0xff, 0xd8]], is_light: false, encode: None },
        Self { endings: &["hdr"], signatures: &[radiance::SIGNATURE], is_light: true, encode: Some(encode_hdr) },
        Self { endings: &["exr"], signatures: &[&EXR_MAGIC], is_light: true, encode: Some(encode_exr) },
        Self { endings: &["tif", "tiff"], signatures: &[b"II*\0", b"MM\0*"], is_light: false, encode: None },
        Self { endings: &["webp"], signatures: &[b"RIFF"], is_light: false, encode: None },
        Self { endings: &["ktx2"], signatures: &[ktx2::SIGNATURE], is_light: false, encode: None },
        Self { endings: &["tga"], signatures: &[b""], is_light: false, encode: None },
    ];

    fn endings(&self) -> &'static [&'static str] {
        self.endings
    }
}

impl PictureFormat {
    /// Whether pictures can be written in it.
    pub fn is_written(&self) -> bool {
        self.encode.is_some()
    }

    /// Whether a file, or a layer of one, has the extension of a format for light.
    pub fn is_of_light(path: &Path) -> bool {
        Self::of(file_and_layer(path).0).is_some_and(|format| format.is_light)
    }

    /// The usual extension of a picture file, by its first bytes.
    pub(crate) fn ending_of(bytes: &[u8]) -> &'static str {
        let format =
            Self::ALL.iter().find(|format| format.signatures.iter().any(|signature| bytes.starts_with(signature)));
        format.map_or("", |format| format.endings[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_bytes_tell_the_ending_of_a_picture() {
        assert_eq!(PictureFormat::ending_of(&[0xff, 0xd8, 0xff]), "jpg");
        assert_eq!(PictureFormat::ending_of(b"#?RADIANCE"), "hdr");
        assert_eq!(PictureFormat::ending_of(b"RIFF\x1a\0\0\0WEBPVP8L"), "webp");
        assert_eq!([b"II*\0", b"MM\0*"].map(|bytes| PictureFormat::ending_of(bytes)), ["tif"; 2]);
        assert_eq!(PictureFormat::ending_of(b"\xabKTX 20\xbb\r\n\x1a\n"), "ktx2");
        assert_eq!(PictureFormat::ending_of(b"solid"), "tga");
        assert_eq!(PictureFormat::ending_of(b""), "tga");
    }
}
