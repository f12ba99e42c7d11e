//! One bounce: surface sources under direct light, gathered by cuts (paper, 4.1).

use super::{BounceLight, BounceSolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::SourceLighting,
    situation::{Changes, Gathering, Situation},
};
use lapidary_core::dataset::BakeParts;
use std::sync::Arc;

/// Gathers directly lit surface sources by cuts.
#[derive(Default)]
pub struct CutsSolver {
    light: Option<Arc<SourceLighting>>,
}

impl Described for CutsSolver {
    const LABEL: &'static str = "Cuts";
    const SUMMARY: &'static str = "One bounce, sharp in glossy and bumped surfaces.";
    const METHOD: &'static str = "One bounce, by cuts over surface sources";
    const BOUNCES: u32 = 1;
    const NEEDS: BakeParts = BakeParts::INDIRECT;
}

impl BounceSolver for CutsSolver {
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        if changes.relight() || changes.gathering {
            let Gathering { illum_cut, tau } = situation.gathering;
            self.light = rigs.sources(situation).map(|rig| rig.lighting(illum_cut).with_tau(tau).into());
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Sources)
    }
}
