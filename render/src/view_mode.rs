//! The quantity in the pixels of a view: the lit picture, or an underlying quantity.

use crate::sampling::BrdfSampling;
use lapidary_core::{
    cut::packed::PackedCuts,
    dataset::{BakeParts, Dataset},
};
use serde::{Deserialize, Serialize};

/// Least count at the upper end of false colors.
const LEAST_TOP: f32 = 512.0;

/// The quantity that the pixels of a view show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewMode {
    /// Reflected radiance.
    #[default]
    Shaded,
    /// Shading normals in world space after bump and normal map: -1 to 1 as 0 to 1.
    Normals,
    /// Base color after its texture.
    Albedo,
    /// Perceptual roughness after its texture.
    Roughness,
    /// Nodes of the visibility cuts of the triangle's vertices, interpolated; nodes of the cuts over surface sources if only those
    /// were baked.
    VisibilityCut,
    /// Nodes of the merged cut.
    MergedCut,
    /// BRDF evaluations.
    BrdfEvaluations,
    /// Contribution of one level of the meshless basis to bounced light: red adds, blue subtracts.
    BasisLevel,
    /// One function of the meshless basis, over the gray scene.
    BasisFunction,
    /// Centers of functions with nonzero coefficients, in the color of their level.
    BasisCoefficients,
    /// What bounced light gains where sources send by direction, over that of diffuse ones: red adds, blue subtracts.
    Gloss,
}

/// Level and function in the views of the meshless basis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct BasisView {
    /// Level for [`ViewMode::BasisLevel`]; 0 is the coarsest.
    pub level: u32,
    /// Function for [`ViewMode::BasisFunction`], counted from 0, coarsest first.
    pub function: u32,
}

impl ViewMode {
    /// All modes in menu order.
    pub const ALL: [Self; 11] = [
        Self::Shaded,
        Self::Normals,
        Self::Albedo,
        Self::Roughness,
        Self::VisibilityCut,
        Self::MergedCut,
        Self::BrdfEvaluations,
        Self::BasisLevel,
        Self::BasisFunction,
        Self::BasisCoefficients,
        Self::Gloss,
    ];

    /// Display name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Shaded => "Shaded",
            Self::Normals => "Normals",
            Self::Albedo => "Albedo",
            Self::Roughness => "Roughness",
            Self::VisibilityCut => "Visibility cut size",
            Self::MergedCut => "Merged cut size",
            Self::BrdfEvaluations => "BRDF evaluations",
            Self::BasisLevel => "Basis level",
            Self::BasisFunction => "Basis function",
            Self::BasisCoefficients => "Basis coefficients",
            Self::Gloss => "Light by gloss",
        }
    }

    /// Whether pixels show the meshless basis; they are black without one.
    pub fn is_of_basis(self) -> bool {
        matches!(self, Self::BasisLevel | Self::BasisFunction | Self::BasisCoefficients)
    }

    /// Whether pixels show a part of bounced light; they are black without it.
    pub fn is_of_bounce(self) -> bool {
        self.is_of_basis() || self == Self::Gloss
    }

    /// Whether pixels show light, to which exposure applies.
    pub fn is_light(self) -> bool {
        matches!(self, Self::Shaded | Self::BasisLevel | Self::Gloss)
    }

    /// Whether pixels are counts, shown in false colors with a legend.
    pub fn is_count(self) -> bool {
        matches!(self, Self::VisibilityCut | Self::MergedCut | Self::BrdfEvaluations)
    }

    /// The count at the upper end of the false colors, with an illumination cut of `illum_cut` nodes if one is merged.
    pub fn count_top(self, sampling: BrdfSampling, illum_cut: u32) -> f32 {
        match self {
            Self::VisibilityCut => LEAST_TOP,
            _ if sampling == BrdfSampling::Lit => LEAST_TOP,
            _ => (4.0 * illum_cut as f32).clamp(LEAST_TOP, 4096.0),
        }
    }
}

/// The cuts shown by [`ViewMode::VisibilityCut`], and the height of their tree: over the environment, or over the surface sources
/// if only these were baked.
pub fn visibility_cuts(dataset: &Dataset) -> (u32, &PackedCuts) {
    match dataset.indirect.as_ref().filter(|_| shows_source_cuts(dataset.settings.mode)) {
        Some(bake) => (bake.sources.len().ilog2(), &bake.cuts),
        None => (dataset.tree.height(), &dataset.cuts),
    }
}

/// Whether [`ViewMode::VisibilityCut`] shows cuts over surface sources in a bake of this mode.
pub fn shows_source_cuts(mode: BakeParts) -> bool {
    mode.sources() && !mode.environment()
}
