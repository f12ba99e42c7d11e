//! Primaries of color spaces, and conversion to those of Rec. 709.
//!
//! Both spaces meet in CIE XYZ. Bradford's matrix adapts the white, so gray stays gray (Lam 1985; ICC.1:2022, annex E).

use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};

/// CIE x, y chromaticities of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: DVec2,
    /// Green.
    pub green: DVec2,
    /// Blue.
    pub blue: DVec2,
    /// White.
    pub white: DVec2,
}

/// White of daylight (ITU-R BT.709-6, 1.4).
const D65: DVec2 = DVec2::new(0.3127, 0.3290);

/// White of ACES (SMPTE ST 2065-1, 4.1).
const ACES_WHITE: DVec2 = DVec2::new(0.32168, 0.33767);

/// Bradford's cone responses from XYZ, row by row.
const BRADFORD: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Largest difference of equal chromaticities: files write them with three or four digits.
const SAME: f64 = 3e-3;

impl Primaries {
    /// Rec. 709 (ITU-R BT.709-6, 1.3).
    pub const REC_709: Self = Self::new([0.64, 0.33], [0.30, 0.60], [0.15, 0.06], D65);
    /// Rec. 2020 (ITU-R BT.2020-2, table 3).
    pub const REC_2020: Self = Self::new([0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65);
    /// P3 with the white of daylight (SMPTE EG 432-1).
    pub const P3: Self = Self::new([0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65);
    /// AP1 of ACEScg (ACES S-2014-004).
    pub const AP1: Self = Self::new([0.713, 0.293], [0.165, 0.830], [0.128, 0.044], ACES_WHITE);
    /// AP0 of ACES 2065-1 (SMPTE ST 2065-1).
    pub const AP0: Self = Self::new([0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], ACES_WHITE);
    /// CIE XYZ, with the white of equal energy that Radiance gives it.
    pub const XYZ: Self = Self::new([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], DVec2::splat(1.0 / 3.0));

    const fn new(red: [f64; 2], green: [f64; 2], blue: [f64; 2], white: DVec2) -> Self {
        Self { red: DVec2::from_array(red), green: DVec2::from_array(green), blue: DVec2::from_array(blue), white }
    }

    /// Whether these are the primaries of Rec. 709, as far as files write them.
    pub fn is_rec_709(&self) -> bool {
        let all = |p: &Self| [p.red, p.green, p.blue, p.white];
        all(self).iter().zip(all(&Self::REC_709)).all(|(a, b)| (*a - b).abs().max_element() < SAME)
    }

    /// The matrix to the linear colors of Rec. 709; `None` for primaries that span no colors.
    pub fn to_rec_709(&self) -> Option<Mat3> {
        self.to(&Self::REC_709).filter(|matrix| matrix.is_finite()).map(|matrix| matrix.as_mat3())
    }

    /// Luminance of red, green and blue; `None` for primaries that span no colors.
    pub fn luminance(&self) -> Option<Vec3> {
        let luminance = self.to_xyz()?.row(1).as_vec3();
        (luminance.y.abs() > 1e-6).then_some(luminance)
    }

    fn to(&self, other: &Self) -> Option<DMat3> {
        let bradford = DMat3::from_cols_array_2d(&BRADFORD).transpose();
        let [from, to] = [self, other].map(|space| bradford * xyz(space.white) / space.white.y);
        let adapted = bradford.inverse() * DMat3::from_diagonal(to / from) * bradford;
        Some(other.to_xyz()?.inverse() * adapted * self.to_xyz()?)
    }

    /// The matrix to XYZ. Red, green and blue of 1 give white with a Y of 1.
    pub(super) fn to_xyz(self) -> Option<DMat3> {
        let directions = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        // Phrased so that NaN fails.
        let spans = directions.determinant().abs() > 1e-6 && self.white.y > 1e-3;
        let amounts = directions.inverse() * (xyz(self.white) / self.white.y);
        spans.then(|| directions * DMat3::from_diagonal(amounts))
    }
}

fn xyz(chromaticity: DVec2) -> DVec3 {
    chromaticity.extend(1.0 - chromaticity.x - chromaticity.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_same() {
        let there = Primaries::AP1.to(&Primaries::XYZ).unwrap();
        let back = Primaries::XYZ.to(&Primaries::AP1).unwrap();
        assert!((there * back).abs_diff_eq(DMat3::IDENTITY, 1e-9));
    }

    #[test]
    fn spaces_have_the_published_matrices_and_gray_stays_gray() {
        // Red, of the matrices in ITU-R BT.2407 (table 2), the ACES color transforms (Bradford), and SMPTE EG 432-1.
        for (space, red) in [
            (Primaries::REC_2020, [1.6605, -0.1246, -0.0182]),
            (Primaries::AP1, [1.7051, -0.1302, -0.0240]),
            (Primaries::AP0, [2.5217, -0.2765, -0.0154]),
            (Primaries::P3, [1.2249, -0.0421, -0.0196]),
        ] {
            let matrix = space.to_rec_709().unwrap();
            let found = matrix * Vec3::X;
            assert!((found - Vec3::from_array(red)).abs().max_element() < 1e-3, "{space:?}: {found}");
            assert!((matrix * Vec3::ONE - 1.0).abs().max_element() < 1e-5, "{space:?}");
            assert!(!space.is_rec_709() && (found - Vec3::X).length() > 0.1, "negative control");
        }
        assert!(Primaries::REC_709.is_rec_709());
        let weights = Primaries::REC_709.luminance().unwrap();
        assert!((weights - crate::color::LUMINANCE).abs().max_element() < 1e-4, "{weights}");
    }
}
