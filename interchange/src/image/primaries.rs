//! Conversion of colors to linear Rec. 709 from the primaries that a file names.
//!
//! Both spaces meet in CIE XYZ. Bradford's matrix adapts the white, so gray stays gray (Lam 1985; ICC.1:2022, annex E).

use exr::{meta::attribute::Chromaticities, prelude as openexr};
use glam::{DMat3, DVec3, Mat3, Vec3};
use lapidary_core::texture::Texels;

/// Chromaticities of Rec. 709 and its white, D65 (ITU-R BT.709-6, 1.3 and 1.4).
pub(super) const REC_709: Chromaticities = Chromaticities {
    red: openexr::Vec2(0.64, 0.33),
    green: openexr::Vec2(0.30, 0.60),
    blue: openexr::Vec2(0.15, 0.06),
    white: openexr::Vec2(0.3127, 0.3290),
};

/// CIE XYZ as primaries, with the white of equal energy that Radiance gives it.
pub(super) const XYZ: Chromaticities = Chromaticities {
    red: openexr::Vec2(1.0, 0.0),
    green: openexr::Vec2(0.0, 1.0),
    blue: openexr::Vec2(0.0, 0.0),
    white: openexr::Vec2(1.0 / 3.0, 1.0 / 3.0),
};

/// Bradford's cone responses from XYZ, row by row.
const BRADFORD: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Largest difference of equal chromaticities: they are written with three or four digits.
const SAME: f32 = 3e-3;

/// The matrix from the primaries of a file to linear Rec. 709; `None` if they are those of Rec. 709.
///
/// # Errors
/// Primaries that span no colors, in words.
pub(super) fn rec_709_from(found: &Chromaticities) -> Result<Option<Mat3>, String> {
    if is_rec_709(found) {
        return Ok(None);
    }
    let matrix = conversion(found, &REC_709).filter(|matrix| matrix.is_finite());
    matrix.map(|matrix| Some(matrix.as_mat3())).ok_or_else(|| {
        let [red, green, blue, white] = [found.red, found.green, found.blue, found.white].map(|c| [c.0, c.1]);
        format!("red {red:?}, green {green:?}, blue {blue:?}, white {white:?}")
    })
}

fn is_rec_709(found: &Chromaticities) -> bool {
    let same = |a: openexr::Vec2<f32>, b: openexr::Vec2<f32>| (a.0 - b.0).abs() < SAME && (a.1 - b.1).abs() < SAME;
    same(found.red, REC_709.red)
        && same(found.green, REC_709.green)
        && same(found.blue, REC_709.blue)
        && same(found.white, REC_709.white)
}

fn conversion(from: &Chromaticities, to: &Chromaticities) -> Option<DMat3> {
    let bradford = DMat3::from_cols_array_2d(&BRADFORD).transpose();
    let [cones_from, cones_to] = [from, to].map(|space| bradford * xyz(space.white) / f64::from(space.white.1));
    let adapted = bradford.inverse() * DMat3::from_diagonal(cones_to / cones_from) * bradford;
    Some(xyz_from(to)?.inverse() * adapted * xyz_from(from)?)
}

/// The matrix to XYZ. Red, green and blue of 1 give white with a Y of 1.
fn xyz_from(space: &Chromaticities) -> Option<DMat3> {
    let directions = DMat3::from_cols(xyz(space.red), xyz(space.green), xyz(space.blue));
    // Phrased so that NaN fails.
    let spans = directions.determinant().abs() > 1e-6 && space.white.1 > 1e-3;
    let amounts = directions.inverse() * (xyz(space.white) / f64::from(space.white.1));
    spans.then(|| directions * DMat3::from_diagonal(amounts))
}

/// Luminance of red, green and blue; `None` for primaries that span no colors.
pub(super) fn luminance(space: &Chromaticities) -> Option<Vec3> {
    let luminance = xyz_from(space)?.row(1).as_vec3();
    (luminance.y.abs() > 1e-6).then_some(luminance)
}

fn xyz(chromaticity: openexr::Vec2<f32>) -> DVec3 {
    let [x, y] = [chromaticity.0, chromaticity.1].map(f64::from);
    DVec3::new(x, y, 1.0 - x - y)
}

/// Floating-point texels that are in these primaries: colors are converted where they are used, see [`Texels::Wide`].
pub(super) fn texels(texels: Vec<[f32; 4]>, to_rec_709: Option<Mat3>) -> Texels {
    match to_rec_709 {
        Some(to_rec_709) => Texels::Wide { texels, to_rec_709 },
        None => Texels::F32(texels),
    }
}

/// The conversion of a file with these primaries. Without one, if they span no colors: `remarks` gets a sentence.
pub(super) fn rec_709_or_remark(found: &Chromaticities, remarks: &mut Vec<String>) -> Option<Mat3> {
    rec_709_from(found).unwrap_or_else(|space| {
        remarks.push(format!("it names primaries that span no colors ({space}), and is taken for linear Rec. 709"));
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{decode, decode_with, read};
    use exr::prelude::{self as openexr, WritableImage};
    use lapidary_core::{image::Image, texture::ColorSpace};
    use std::{io::Cursor, path::Path};

    const ACES_CG: Chromaticities = Chromaticities {
        red: openexr::Vec2(0.713, 0.293),
        green: openexr::Vec2(0.165, 0.830),
        blue: openexr::Vec2(0.128, 0.044),
        white: openexr::Vec2(0.32168, 0.33767),
    };

    fn file(color: Vec3, chromaticities: Option<Chromaticities>) -> Vec<u8> {
        let channels = openexr::SpecificChannels::rgb(move |_| (color.x, color.y, color.z));
        let mut image = openexr::Image::from_channels((4, 3), channels);
        image.attributes.chromaticities = chromaticities;
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn first(color: Vec3, chromaticities: Option<Chromaticities>) -> Vec3 {
        let texture = decode(&file(color, chromaticities), Path::new("a.exr")).unwrap();
        texture.texel(0, 0, ColorSpace::Srgb).truncate()
    }

    #[test]
    fn colours_of_other_primaries_become_rec_709_and_ours_stay_to_the_bit() {
        let color = Vec3::new(0.2, 0.6, 0.1);
        for ours in [None, Some(REC_709)] {
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
    fn there_and_back_is_the_same() {
        let there = conversion(&ACES_CG, &XYZ).unwrap();
        let back = conversion(&XYZ, &ACES_CG).unwrap();
        assert!((there * back).abs_diff_eq(DMat3::IDENTITY, 1e-9));
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
        let flat = Chromaticities { blue: REC_709.red, ..ACES_CG };
        let flat = Chromaticities { red: REC_709.red, ..flat };
        for bad in [flat, Chromaticities { white: openexr::Vec2(0.0, 0.0), ..ACES_CG }] {
            let bytes = file(Vec3::new(0.25, 0.5, 1.0), Some(bad));
            let mut remarks = Vec::new();
            let texture = decode_with(&bytes, Path::new("a.exr"), &mut remarks).unwrap();
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
