//! The options about how finished pictures are made and shown, which `render` and `sequence` share.

use super::{BackendOption, ViewedScene, values};
use anyhow::Result;
use clap::{Args, ValueEnum};
use lapidary_render::{BrdfSampling, Look, Post, ToneMap};

/// How pictures are made and shown.
#[derive(Args, Clone, Debug)]
pub struct PictureArgs {
    /// Most nodes of the illumination cut, 1 to 32768: more follow small lights more closely, and cost time
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// How the BRDF is sampled
    #[arg(long, value_enum, default_value_t)]
    brdf: BrdfOption,
    /// Stops by which png files are brighter; exr and hdr files are scene-linear and stay as they are
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::finite, allow_hyphen_values = true)]
    exposure: f32,
    /// Tone curve of png files
    #[arg(long, value_enum, default_value_t)]
    tone_map: ToneMapOption,
    /// What computes
    #[arg(long, value_enum, default_value_t)]
    pub backend: BackendOption,
}

/// How the BRDF is sampled, as an option.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum BrdfOption {
    /// Halve nodes that are wider than the lobe can bear, during the merge
    #[default]
    Refine,
    /// Once for each node of the merged cut, as in the paper
    Once,
}

impl From<BrdfOption> for BrdfSampling {
    fn from(option: BrdfOption) -> Self {
        match option {
            BrdfOption::Refine => Self::Refine,
            BrdfOption::Once => Self::Once,
        }
    }
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum ToneMapOption {
    /// None: clamped and sRGB-encoded
    #[default]
    Standard,
    /// Reinhard, on luminance
    Reinhard,
    /// A fit of the ACES curves
    Aces,
    /// AgX with its default contrast
    Agx,
    /// Khronos PBR Neutral
    PbrNeutral,
}

impl From<ToneMapOption> for ToneMap {
    fn from(option: ToneMapOption) -> Self {
        match option {
            ToneMapOption::Standard => Self::Standard,
            ToneMapOption::Reinhard => Self::Reinhard,
            ToneMapOption::Aces => Self::Aces,
            ToneMapOption::Agx => Self::AgX,
            ToneMapOption::PbrNeutral => Self::PbrNeutral,
        }
    }
}

impl PictureArgs {
    /// Everything that decides the picture of a viewed scene.
    ///
    /// # Errors
    /// Bounced light was asked for, and the dataset has none of that kind.
    pub fn look(&self, viewed: &ViewedScene) -> Result<Look> {
        Ok(Look {
            illum_cut: self.illum_cut,
            sampling: self.brdf.into(),
            post: Post { exposure: self.exposure, tone_map: self.tone_map.into() },
            ..viewed.look()?
        })
    }
}
