//! Which cuts a picture of the ladder merges.

use lapidary_render::{BrdfSampling, Look};
use serde::Serialize;

/// Cuts and their one setting. As JSON they are `brdf`, and `illum_cut` or `lit_cuts`, like the options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cuts {
    /// The stored cuts and an illumination cut of at most so many nodes; the BRDF once per node.
    Once(u32),
    /// The same cuts; nodes too wide for the BRDF are halved.
    Refine(u32),
    /// Lit cuts, whose nodes move at most this share of a vertex's light.
    Lit(f32),
}

impl Cuts {
    /// Stored cuts and an illumination cut of at most `size` nodes, for a BRDF sampled as by `sampling`. Lit cuts know no size:
    /// the stored ones are then refined.
    pub fn stored(size: u32, sampling: BrdfSampling) -> Self {
        match sampling {
            BrdfSampling::Once => Self::Once(size),
            BrdfSampling::Refine | BrdfSampling::Lit => Self::Refine(size),
        }
    }

    /// Those of pictures with these settings.
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

    /// How the BRDF is sampled.
    pub fn sampling(self) -> BrdfSampling {
        match self {
            Self::Once(_) => BrdfSampling::Once,
            Self::Refine(_) => BrdfSampling::Refine,
            Self::Lit(_) => BrdfSampling::Lit,
        }
    }

    /// Most nodes of the illumination cut, where there is one.
    pub fn size(self) -> Option<u32> {
        match self {
            Self::Once(size) | Self::Refine(size) => Some(size),
            Self::Lit(_) => None,
        }
    }

    /// Largest share of a vertex's light that a node of lit cuts moves.
    pub fn tau(self) -> Option<f32> {
        if let Self::Lit(tau) = self { Some(tau) } else { None }
    }

    /// In a word or two, as a heading below a picture.
    pub fn label(self) -> String {
        match self.size() {
            Some(1) => "1 node".into(),
            Some(size) => format!("{} nodes", crate::report::text::grouped(size.into())),
            None => "Lit cuts".into(),
        }
    }

    /// End of the names of its files.
    pub fn stem(self) -> String {
        self.size().map_or_else(|| "lit".into(), |size| size.to_string())
    }
}

/// Cuts by the names of options.
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
