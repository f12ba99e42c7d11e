//! Many bounces between quads, also from gloss to gloss, by wavelet transport (Kontkanen et al. 2006).

use super::{BounceLight, BounceSolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::PatchLight,
    situation::{Changes, Situation},
};
use lapidary_core::{dataset::BakeParts, wavelet::series::MOST_POWERS};
use std::sync::Arc;

/// Sends the light of lamps through the baked transport.
#[derive(Default)]
pub struct WaveletSolver {
    light: Option<Arc<PatchLight>>,
}

impl Described for WaveletSolver {
    const LABEL: &'static str = "Wavelets";
    const SUMMARY: &'static str =
        "Many bounces of the lamps between quads, also from gloss to gloss, of the materials as baked.";
    const METHOD: &'static str = "Many bounces between quads, glossy ones too, by wavelet transport";
    const BOUNCES: u32 = MOST_POWERS as u32 + 1;
    const NEEDS: BakeParts = BakeParts::WAVELET;
}

impl BounceSolver for WaveletSolver {
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        if changes.lights || changes.environment {
            self.light = rigs.wavelet(situation).map(|rig| rig.light().into());
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Patches)
    }
}
