//! The cuts that a picture of the ladder merges.

use lapidary_render::{BrdfSampling, Look};
use serde::Serialize;

/// Cuts with their setting. In JSON they are `brdf`, and `illum_cut` or `lit_cuts`, like the options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cuts {
    /// The stored cuts and an illumination cut of at most this many nodes; one BRDF sample per node.
    Once(u32),
    /// The same cuts; nodes too wide for the BRDF are split.
    Refine(u32),
    /// Lit cuts whose nodes move at most this share of a vertex's light.
    Lit(f32),
}

impl Cuts {
    /// Stored cuts and an illumination cut of at most `size` nodes, for a BRDF sampled as by `sampling`. Lit cuts have no size:
    /// stored cuts are then refined.
    pub fn stored(size: u32, sampling: BrdfSampling) -> Self {
        match sampling {
            BrdfSampling::Once => Self::Once(size),
            BrdfSampling::Refine | BrdfSampling::Lit => Self::Refine(size),
        }
    }

    /// The cuts of pictures with these settings.
    pub fn of(sampling: BrdfSampling, illum_cut: u32, tau: f32) -> Self {
        match sampling {
            BrdfSampling::Once => Self::Once(illum_cut),
            BrdfSampling::Refine => Self::Refine(illum_cut),
            BrdfSampling::Lit => Self::Lit(tau),
        }
    }

    /// `look` with these cuts.
    pub fn shown(self, look: &Look) -> Look {
        Look {
            sampling: self.sampling(),
            illum_cut: self.size().unwrap_or(look.illum_cut),
            tau: self.tau().unwrap_or(look.tau),
            ..look.clone()
        }
    }

    /// The BRDF sampling.
    pub fn sampling(self) -> BrdfSampling {
        match self {
            Self::Once(_) => BrdfSampling::Once,
            Self::Refine(_) => BrdfSampling::Refine,
            Self::Lit(_) => BrdfSampling::Lit,
        }
    }

    /// Most nodes of the illumination cut, if there is one.
    pub fn size(self) -> Option<u32> {
        match self {
            Self::Once(size) | Self::Refine(size) => Some(size),
            Self::Lit(_) => None,
        }
    }

    /// Largest share of a vertex's light that a node of lit cuts moves, if lit cuts are merged.
    pub fn tau(self) -> Option<f32> {
        if let Self::Lit(tau) = self { Some(tau) } else { None }
    }

    /// Short heading below a picture.
    pub fn label(self) -> String {
        match self.size() {
            Some(1) => "1 node".into(),
            Some(size) => format!("{} nodes", crate::report::text::grouped(size.into())),
            None => "Lit cuts".into(),
        }
    }

    /// Suffix of its file names.
    pub fn stem(self) -> String {
        self.size().map_or_else(|| "lit".into(), |size| size.to_string())
    }
}

/// Cuts under the options' names.
#[derive(Serialize)]
struct Figures {
    brdf: BrdfSampling,
    #[serde(skip_serializing_if = "Option::is_none")]
    illum_cut: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lit_cuts: Option<f32>,
}

impl Serialize for Cuts {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Figures { brdf: self.sampling(), illum_cut: self.size(), lit_cuts: self.tau() }.serialize(serializer)
    }
}
