//! Many bounces in functions of the objects, added to the surface sources, which cuts gather. Cuts know nothing of a move until they
//! are baked anew: till then the vertices show the light.

use super::{BounceLight, BounceSolver, radiosity::RadiositySolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::SourceLighting,
    situation::{Changes, Gathering, Situation},
};
use glam::Vec3;
use lapidary_core::{dataset::BakeParts, meshless::RadiositySettings, transport::BounceEnergy};
use std::sync::Arc;

/// Gathers surface sources lit by all bounces of the functions.
#[derive(Default)]
pub struct CutsOverRadiosity {
    solver: RadiositySolver,
    /// Irradiance of each source from the bounces of the last whole light, in W/m².
    further: Vec<Vec3>,
    /// As baked; `None` where an object is away.
    gathered: Option<Arc<SourceLighting>>,
}

impl Described for CutsOverRadiosity {
    const LABEL: &'static str = "Cuts over radiosity";
    const SUMMARY: &'static str =
        "Many bounces, right again soon after a move, then the last one sharp in glossy and bumped surfaces.";
    const METHOD: &'static str = "Bounces in functions of the objects added to the surface sources, gathered by cuts";
    const BOUNCES: u32 = RadiositySettings::DEFAULT.bounces + 1;
    const NEEDS: BakeParts = BakeParts::INDIRECT.with(BakeParts::RADIOSITY);
    const FOLLOWS_POSES: bool = true;
}

impl BounceSolver for CutsOverRadiosity {
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        let shown = self.solver.shown().cloned();
        let goes_on = self.solver.advance(situation, changes, rigs);
        let is_as_baked = situation.poses.is_empty();
        // The further bounces of the light before stand in until those of the present light are whole.
        let is_new = match (&shown, self.solver.shown()) {
            (Some(before), Some(now)) => !Arc::ptr_eq(before, now),
            (_, now) => now.is_some(),
        };
        let brings = is_as_baked && is_new && (!goes_on || self.further.is_empty());
        if brings {
            self.further = further(situation, rigs).unwrap_or_default();
        }
        if brings || changes.poses || changes.relight() || changes.gathering {
            self.gathered = if is_as_baked { self.gather(situation, rigs) } else { None };
        }
        goes_on
    }

    fn light(&self) -> Option<BounceLight> {
        self.gathered.clone().map(BounceLight::Sources).or_else(|| self.solver.light())
    }

    fn energy(&self) -> Option<BounceEnergy> {
        self.solver.energy().map(BounceEnergy::and_the_next)
    }
}

impl CutsOverRadiosity {
    fn gather(&mut self, situation: &Situation, rigs: &mut Rigs) -> Option<Arc<SourceLighting>> {
        let (Gathering { illum_cut, tau }, rig) = (situation.gathering, rigs.sources(situation)?);
        // Of another bake.
        if self.further.len() != rig.tree().len() {
            self.further.clear();
        }
        Some(rig.lighting_with(&self.further, illum_cut).with_tau(tau).into())
    }
}

/// Irradiance of the sources from the bounces so far.
fn further(situation: &Situation, rigs: &mut Rigs) -> Option<Vec<Vec3>> {
    let tree = rigs.sources(situation)?.tree().clone();
    Some(rigs.radiosity(situation)?.at_sources(tree.sources()))
}
