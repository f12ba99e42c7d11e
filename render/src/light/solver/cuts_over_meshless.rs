//! Many bounces in the meshless basis, added to the surface sources, which cuts gather: the last bounce is as sharp as a single
//! bounce by cuts.

use super::{BounceLight, BounceSolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::SourceLighting,
    situation::{Changes, Gathering, Situation},
};
use glam::Vec3;
use lapidary_core::{dataset::BakeParts, meshless::SolveSettings, transport::BounceEnergy};
use std::sync::Arc;

/// Gathers surface sources lit by all bounces of the basis.
#[derive(Default)]
pub struct CutsOverMeshless {
    further: Further,
    light: Option<Arc<SourceLighting>>,
}

/// Bounces beyond the direct light of the sources.
#[derive(Default)]
pub(super) struct Further {
    /// Irradiance of each source in W/m².
    pub irradiance: Vec<Vec3>,
    /// Energy, including the gathered bounce.
    pub energy: Option<BounceEnergy>,
}

impl Further {
    /// Of the present light.
    pub fn of(situation: &Situation, rigs: &mut Rigs) -> Option<Self> {
        let tree = rigs.sources(situation)?.tree().clone();
        let basis = rigs.meshless(situation)?;
        let irradiance = basis.at_sources(tree.sources());
        Some(Self { irradiance, energy: basis.energy().map(BounceEnergy::and_the_next) })
    }
}

impl Described for CutsOverMeshless {
    const LABEL: &'static str = "Cuts over meshless";
    const SUMMARY: &'static str = "Many bounces, the last one sharp in glossy and bumped surfaces.";
    const METHOD: &'static str = "Meshless bounces added to the surface sources, gathered by cuts";
    const BOUNCES: u32 = SolveSettings::DEFAULT.bounces + 1;
    const NEEDS: BakeParts = BakeParts::INDIRECT.with(BakeParts::MESHLESS);
}

impl BounceSolver for CutsOverMeshless {
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        if changes.relight() {
            self.further = Further::of(situation, rigs).unwrap_or_default();
        }
        if changes.relight() || changes.gathering {
            let (Gathering { illum_cut, tau }, further) = (situation.gathering, &self.further.irradiance);
            let gathered = rigs.sources(situation).map(|rig| rig.lighting_with(further, illum_cut).with_tau(tau));
            self.light = gathered.map(Arc::new);
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Sources)
    }

    fn energy(&self) -> Option<BounceEnergy> {
        self.further.energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{linked_floor_and_wall, point_light};

    #[test]
    fn another_cut_takes_no_other_bounces_and_another_light_does() {
        let baked = linked_floor_and_wall().into();
        let (mut rigs, mut solver) = (Rigs::new(&baked), CutsOverMeshless::default());
        let mut situation = Situation::unlit(&baked);
        let mut advance = |situation: &Situation, changes| {
            rigs.note(changes);
            solver.advance(situation, changes, &mut rigs);
            (solver.further.irradiance.as_ptr(), solver.light.as_ref().unwrap().max_nodes)
        };
        situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), 3.0)].into();
        let (first, _) = advance(&situation, Changes::ALL);
        situation.gathering = Gathering { illum_cut: 16, tau: 0.0 };
        assert_eq!(advance(&situation, Changes { gathering: true, ..Changes::NONE }), (first, 16));
        situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), 6.0)].into();
        let (other, _) = advance(&situation, Changes { lights: true, ..Changes::NONE });
        assert!(other != first, "negative control");
    }
}
