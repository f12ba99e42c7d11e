//! Color spaces of texels.

use crate::color::Primaries;
use glam::Mat3;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

/// Conversion of texels to parameter values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorSpace {
    /// Colors as the file has them: texels of 8 and 16 bits are sRGB encoded, and float texels are linear, with the
    /// primaries that the file names.
    Srgb,
    /// Texels are linear values as they are: roughness, normals, heights.
    #[default]
    Linear,
    /// Linear colors with the primaries AP1 of ACES, whatever the file says.
    #[serde(rename = "acescg")]
    AcesCg,
    /// Linear colors with the primaries AP0 of ACES, whatever the file says.
    #[serde(rename = "aces2065-1")]
    Aces2065,
    /// Linear colors with the primaries of Rec. 2020, whatever the file says.
    #[serde(rename = "lin-rec2020")]
    Rec2020,
    /// Linear colors with the primaries P3 and the white of daylight, whatever the file says.
    #[serde(rename = "lin-p3")]
    P3,
}

/// Conversions of [`ColorSpace::ALL`].
static TO_REC_709: LazyLock<[Option<Mat3>; ColorSpace::ALL.len()]> =
    LazyLock::new(|| ColorSpace::ALL.map(|space| space.primaries().and_then(|primaries| primaries.to_rec_709())));

impl ColorSpace {
    /// All of them, in the order of their declaration.
    pub const ALL: [Self; 6] = [Self::Srgb, Self::Linear, Self::AcesCg, Self::Aces2065, Self::Rec2020, Self::P3];

    /// The primaries that it gives to texels; `None` where the file or Rec. 709 counts.
    pub fn primaries(self) -> Option<Primaries> {
        match self {
            Self::Srgb | Self::Linear => None,
            Self::AcesCg => Some(Primaries::AP1),
            Self::Aces2065 => Some(Primaries::AP0),
            Self::Rec2020 => Some(Primaries::REC_2020),
            Self::P3 => Some(Primaries::P3),
        }
    }

    /// The matrix from its primaries to linear Rec. 709, where it gives any.
    #[inline]
    pub fn to_rec_709(self) -> Option<Mat3> {
        match self {
            Self::Srgb | Self::Linear => None,
            other => TO_REC_709[other as usize],
        }
    }
}
