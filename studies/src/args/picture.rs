//! Picture options shared by `render` and `sequence`.

use super::{DeviceArgs, ViewedScene, choices};
use crate::{export::backplate, values};
use anyhow::Result;
use clap::Args;
use lapidary_core::cut::lit::DEFAULT_TAU;
use lapidary_render::{Background, BrdfSampling, Look, Post, ToneMap};
use std::{path::PathBuf, sync::Arc};

/// How pictures are rendered and displayed.
#[derive(Args, Clone, Debug)]
pub struct PictureArgs {
    /// Most nodes of the illumination cut, 1 to 32768; more nodes resolve small lights better and take longer. Only --brdf
    /// refine and once merge it
    #[arg(long, value_name = "K", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=32_768))]
    illum_cut: u32,
    /// Largest share of a vertex's light that a node of its lit cut moves, 0 to 1; 0 keeps the stored cuts
    #[arg(long, value_name = "TAU", default_value_t = DEFAULT_TAU, value_parser = values::share)]
    lit_cuts: f32,
    /// Which cuts are merged, and how the BRDF is sampled
    #[arg(long, default_value = "lit", value_parser = choices::brdf_sampling())]
    brdf: BrdfSampling,
    /// Exposure of png files in stops, -32 to 32; exr and hdr files stay scene-linear
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::exposure, allow_hyphen_values = true)]
    exposure: f32,
    /// Tone curve of png files
    #[arg(long, default_value = "standard", value_parser = choices::tone_map())]
    tone_map: ToneMap,
    /// How much darker png files are toward their corners, 0 to 1
    #[arg(long, value_name = "SHARE", default_value = "0", value_parser = values::fraction)]
    vignette: f32,
    /// Picture behind the scene in png files; a ground that catches shadows (--ground shadow) darkens it
    #[arg(long, value_name = "FILE")]
    pub backplate: Option<PathBuf>,
    /// Where and how they are rendered.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl PictureArgs {
    /// The complete look of a viewed scene.
    ///
    /// # Errors
    /// Bounced light was requested, and the dataset has none of that kind.
    pub fn look(&self, viewed: &ViewedScene) -> Result<Look> {
        let backplate = self.backplate.as_deref().map(backplate::read).transpose()?.map(Arc::new);
        let mut look = Look {
            illum_cut: self.illum_cut,
            tau: self.lit_cuts,
            sampling: self.brdf,
            post: Post { exposure: self.exposure, tone_map: self.tone_map, vignette: self.vignette },
            backplate,
            ..viewed.look()?
        };
        if look.backplate.is_some() {
            look.view.background = Background::Transparent;
        }
        Ok(look)
    }
}
