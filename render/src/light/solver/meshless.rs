//! Many bounces in the meshless basis (Lehtinen et al. 2008).

use super::{BounceLight, BounceSolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::MeshlessLight,
    situation::{Changes, Situation},
};
use lapidary_core::{dataset::BakeParts, meshless::SolveSettings, transport::BounceEnergy};
use std::sync::Arc;

/// Solves bounced light in the meshless basis.
#[derive(Default)]
pub struct MeshlessSolver {
    light: Option<Arc<MeshlessLight>>,
    energy: Option<BounceEnergy>,
}

impl Described for MeshlessSolver {
    const LABEL: &'static str = "Meshless";
    const SUMMARY: &'static str = "Many bounces, soft: the fastest while a light moves.";
    const METHOD: &'static str = "Many bounces, in the meshless basis";
    const BOUNCES: u32 = SolveSettings::DEFAULT.bounces;
    const NEEDS: BakeParts = BakeParts::MESHLESS;
}

impl BounceSolver for MeshlessSolver {
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        if changes.relight() {
            let rig = rigs.meshless(situation);
            (self.light, self.energy) = rig.map_or((None, None), |rig| (Some(rig.light().into()), rig.energy()));
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Functions)
    }

    fn energy(&self) -> Option<BounceEnergy> {
        self.energy
    }
}
