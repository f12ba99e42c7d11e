//! The primaries of a picture, if its file names them.

use super::read::read;
use exr::meta::{MetaData, attribute::Chromaticities};
use exr::prelude as openexr;
use lapidary_core::image::{Image, ImageError};
use std::path::Path;

/// Chromaticities of Rec. 709 and its white, D65 (ITU-R BT.709-6, 1.3 and 1.4).
pub(super) const REC_709: Chromaticities = Chromaticities {
    red: openexr::Vec2(0.64, 0.33),
    green: openexr::Vec2(0.30, 0.60),
    blue: openexr::Vec2(0.15, 0.06),
    white: openexr::Vec2(0.3127, 0.3290),
};

/// Red and green of color spaces that other programs write, and their names.
const KNOWN: [([f32; 2], [f32; 2], &str); 4] = [
    ([0.7347, 0.2653], [0.0, 1.0], "ACES2065-1 (AP0)"),
    ([0.713, 0.293], [0.165, 0.830], "ACEScg (AP1)"),
    ([0.708, 0.292], [0.170, 0.797], "Rec. 2020"),
    ([0.680, 0.320], [0.265, 0.690], "P3"),
];

/// Largest difference of equal chromaticities: they are written with three or four digits.
const SAME: f32 = 3e-3;

/// Reads a picture for a comparison: like [`read`], but refuses primaries other than Rec. 709. Only exr files name
/// their primaries.
///
/// # Errors
/// See [`read`]; also [`ImageError::Primaries`].
pub fn read_rec_709(path: &Path) -> Result<Image, ImageError> {
    let image = read(path)?;
    match MetaData::read_from_file(path, false).ok().and_then(|meta| foreign(&meta)) {
        None => Ok(image),
        Some(space) => Err(ImageError::Primaries { path: path.into(), space }),
    }
}

/// The color space of a file, unless it is Rec. 709.
fn foreign(meta: &MetaData) -> Option<String> {
    let of = |header: &exr::meta::header::Header| header.shared_attributes.chromaticities;
    let found = meta.headers.iter().find_map(of)?;
    let close = |a: openexr::Vec2<f32>, b: [f32; 2]| (a.0 - b[0]).abs() < SAME && (a.1 - b[1]).abs() < SAME;
    let same = |a: openexr::Vec2<f32>, b: openexr::Vec2<f32>| close(a, [b.0, b.1]);
    let is_rec_709 = same(found.red, REC_709.red)
        && same(found.green, REC_709.green)
        && same(found.blue, REC_709.blue)
        && same(found.white, REC_709.white);
    if is_rec_709 {
        return None;
    }
    let known = KNOWN.iter().find(|(red, green, _)| close(found.red, *red) && close(found.green, *green));
    let primaries = || format!("primaries with red at {:.4}, {:.4}", found.red.0, found.red.1);
    Some(known.map_or_else(primaries, |(_, _, name)| (*name).into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{self as openexr, WritableImage};
    use glam::Vec3;

    fn write(path: &Path, chromaticities: Option<Chromaticities>) {
        let channels = openexr::SpecificChannels::rgb(|_| (0.25_f32, 0.5_f32, 0.75_f32));
        let mut image = openexr::Image::from_channels((4, 3), channels);
        image.attributes.chromaticities = chromaticities;
        image.write().to_file(path).unwrap();
    }

    #[test]
    fn pictures_in_other_colours_are_refused_by_name_and_ours_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for ours in [None, Some(REC_709)] {
            write(&path, ours);
            assert_eq!(read_rec_709(&path).unwrap(), Image::filled([4, 3], Vec3::new(0.25, 0.5, 0.75)));
        }
        let (red, green) = (openexr::Vec2(0.713, 0.293), openexr::Vec2(0.165, 0.830));
        write(&path, Some(Chromaticities { red, green, ..REC_709 }));
        let error = read_rec_709(&path).unwrap_err().to_string();
        assert!(error.contains("ACEScg (AP1)") && error.contains("convert"), "{error}");
        assert!(read(&path).is_ok(), "as an environment it may still be of use");
        write(&path, Some(Chromaticities { red: openexr::Vec2(0.6, 0.3), ..REC_709 }));
        assert!(read_rec_709(&path).unwrap_err().to_string().contains("red at 0.6000"));
        let png = folder.path().join("a.png");
        crate::image::write(&Image::filled([2, 2], Vec3::ONE), &png).unwrap();
        assert!(read_rec_709(&png).is_ok());
    }
}
