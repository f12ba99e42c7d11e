//! The primaries that a file names, as its conversion of colors to linear Rec. 709.

use super::remark::Remark;
use exr::{meta::attribute::Chromaticities, prelude as openexr};
use glam::{DVec2, Mat3};
use lapidary_core::{color::Primaries, texture::Texels};

/// Primaries as OpenEXR writes them.
pub(super) fn chromaticities(of: &Primaries) -> Chromaticities {
    let pair = |p: DVec2| openexr::Vec2(p.x as f32, p.y as f32);
    Chromaticities { red: pair(of.red), green: pair(of.green), blue: pair(of.blue), white: pair(of.white) }
}

/// Primaries as OpenEXR reads them.
pub(super) fn named(found: &Chromaticities) -> Primaries {
    let pair = |p: openexr::Vec2<f32>| DVec2::new(p.0.into(), p.1.into());
    Primaries { red: pair(found.red), green: pair(found.green), blue: pair(found.blue), white: pair(found.white) }
}

/// The matrix from the primaries of a file to linear Rec. 709; `None` if they are those of Rec. 709.
///
/// # Errors
/// Primaries that span no colors, in words.
pub(super) fn rec_709_from(found: &Primaries) -> Result<Option<Mat3>, String> {
    if found.is_rec_709() {
        return Ok(None);
    }
    found.to_rec_709().map(Some).ok_or_else(|| {
        let [red, green, blue, white] =
            [found.red, found.green, found.blue, found.white].map(|c| c.as_vec2().to_array());
        format!("red {red:?}, green {green:?}, blue {blue:?}, white {white:?}")
    })
}

/// Floating-point texels that are in these primaries: colors are converted where they are used, see [`Texels::Wide`].
pub(super) fn texels(texels: Vec<[f32; 4]>, to_rec_709: Option<Mat3>) -> Texels {
    match to_rec_709 {
        Some(to_rec_709) => Texels::Wide { texels, to_rec_709 },
        None => Texels::F32(texels),
    }
}

/// The conversion of a file with these primaries. Without one, if they span no colors: `remarks` gets a sentence.
pub(super) fn rec_709_or_remark(found: &Primaries, remarks: &mut Vec<Remark>) -> Option<Mat3> {
    rec_709_from(found).unwrap_or_else(|space| {
        let text = format!("it names primaries that span no colors ({space}), and is taken for linear Rec. 709");
        remarks.push(Remark::Colors(text));
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{decode, decode_with, read};
    use exr::prelude::WritableImage;
    use glam::Vec3;
    use lapidary_core::{image::Image, texture::ColorSpace};
    use std::{io::Cursor, path::Path};

    const ACES_CG: Primaries = Primaries::AP1;

    fn file(color: Vec3, primaries: Option<Primaries>) -> Vec<u8> {
        let channels = openexr::SpecificChannels::rgb(move |_| (color.x, color.y, color.z));
        let mut image = openexr::Image::from_channels((4, 3), channels);
        image.attributes.chromaticities = primaries.map(|primaries| chromaticities(&primaries));
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn first(color: Vec3, primaries: Option<Primaries>) -> Vec3 {
        let texture = decode(&file(color, primaries), Path::new("a.exr")).unwrap();
        texture.texel(0, 0, ColorSpace::Srgb).truncate()
    }

    #[test]
    fn colours_of_other_primaries_become_rec_709_and_ours_stay_to_the_bit() {
        let color = Vec3::new(0.2, 0.6, 0.1);
        for ours in [None, Some(Primaries::REC_709)] {
            assert_eq!(first(color, ours), color);
        }
        // Computed apart with the matrices of ACES TB-2014-004 and Bradford.
        let right = Vec3::new(-0.0404, 0.6574, 0.0331);
        let found = first(color, Some(ACES_CG));
        assert!((found - right).abs().max_element() < 1e-3, "{found}");
        assert!((color - right).abs().max_element() > 0.05, "negative control");
        let gray = first(Vec3::splat(0.5), Some(ACES_CG));
        assert!((gray - 0.5).abs().max_element() < 1e-5, "{gray}");
    }

    #[test]
    fn an_infinite_sun_stays_bright_in_other_primaries() {
        let sun = first(Vec3::INFINITY, Some(ACES_CG));
        assert!(sun.is_finite() && (sun / Texels::MOST - 1.0).abs().max_element() < 1e-3, "{sun}");
        assert!(first(Vec3::new(f32::NAN, 1.0, 1.0), Some(ACES_CG)).is_nan());
    }

    #[test]
    fn values_of_a_file_with_primaries_stay_as_they_are() {
        let normal = Vec3::new(0.5, 0.75, 1.0);
        let texture = decode(&file(normal, Some(ACES_CG)), Path::new("n.exr")).unwrap();
        let texel = |space| texture.texel(0, 0, space).truncate();
        assert_eq!(texel(ColorSpace::Linear), normal);
        assert!((texel(ColorSpace::Srgb) - normal).abs().max_element() > 0.05, "negative control: a color");
    }

    #[test]
    fn primaries_on_a_line_are_told_or_refused_with_their_values() {
        let flat = Primaries { blue: Primaries::REC_709.red, ..ACES_CG };
        let flat = Primaries { red: Primaries::REC_709.red, ..flat };
        for bad in [flat, Primaries { white: DVec2::ZERO, ..ACES_CG }] {
            let bytes = file(Vec3::new(0.25, 0.5, 1.0), Some(bad));
            let mut remarks = Vec::new();
            let texture = decode_with(&bytes, Path::new("a.exr"), None, &mut remarks).unwrap();
            assert_eq!(texture.texel(0, 0, ColorSpace::Srgb).truncate(), Vec3::new(0.25, 0.5, 1.0));
            assert!(remarks.len() == 1 && remarks[0].contains("green [0.165, 0.83]"), "{remarks:?}");
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.exr");
            std::fs::write(&path, &bytes).unwrap();
            let message = read(&path).unwrap_err().to_string();
            assert!(message.contains("green [0.165, 0.83]") && message.contains("Rec. 709"), "{message}");
        }
    }

    #[test]
    fn a_comparison_reads_the_converted_colours() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, file(Vec3::ONE, Some(ACES_CG))).unwrap();
        let (found, white) = (read(&path).unwrap(), Image::filled([4, 3], Vec3::ONE));
        assert!(found.pixels.iter().zip(&white.pixels).all(|(a, b)| (*a - *b).abs().max_element() < 1e-5));
    }
}
