//! Many bounces in functions of the objects, solved anew after a move (Zollhöfer and Stamminger 2011).

use super::{BounceLight, BounceSolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::MeshlessLight,
    situation::{Changes, Situation},
};
use lapidary_core::{
    dataset::BakeParts,
    meshless::{RadiositySettings, RadiosityStep},
    scene::pose::Poses,
    transport::BounceEnergy,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Solves bounced light for the objects where they are.
#[derive(Default)]
pub struct RadiositySolver {
    /// What is shown after each step of the present light: its bounces so far, and the further ones of the light before.
    steps: Vec<Arc<MeshlessLight>>,
    /// The steps of the last whole light.
    before: Vec<Arc<MeshlessLight>>,
    shown: Option<Arc<MeshlessLight>>,
    /// Of the present light.
    poses: Poses,
    energy: Option<BounceEnergy>,
    /// The solution of the rig that it advances.
    begun: Option<u64>,
    is_whole: bool,
}

impl Described for RadiositySolver {
    const LABEL: &'static str = "Radiosity";
    const SUMMARY: &'static str = "Many bounces, soft, right again soon after an object was moved.";
    const METHOD: &'static str = "Many bounces in functions of the objects, solved anew after a move";
    const BOUNCES: u32 = RadiositySettings::DEFAULT.bounces;
    const NEEDS: BakeParts = BakeParts::RADIOSITY;
    const FOLLOWS_POSES: bool = true;
}

impl BounceSolver for RadiositySolver {
    /// The first step after a change does nothing, so that a drag goes on with the light before.
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        // Another detail of the preview poses the scene anew, but moves nothing.
        let has_moved = changes.poses && self.poses != situation.poses;
        if has_moved || changes.relight() {
            self.poses = situation.poses.clone();
            if std::mem::take(&mut self.is_whole) {
                self.before = std::mem::take(&mut self.steps);
            }
            self.steps.clear();
            self.begun = None;
            return true;
        }
        let Some(rig) = rigs.radiosity(situation).filter(|_| !self.is_whole) else { return false };
        // A pose may have come back before the rig heard of another, or another solver began.
        if self.begun != Some(rig.begun()) {
            self.begun = Some(rig.restart());
            self.steps.clear();
        }
        let step = rig.step();
        if step == RadiosityStep::Partial {
            return true;
        }
        self.energy = rig.energy();
        self.steps.extend(rig.shown().map(Arc::new));
        self.is_whole = step == RadiosityStep::Last;
        self.shown = self.with_rest_of_before();
        !self.is_whole
    }

    fn light(&self) -> Option<BounceLight> {
        self.shown.clone().map(BounceLight::Functions)
    }

    fn energy(&self) -> Option<BounceEnergy> {
        self.energy
    }
}

impl RadiositySolver {
    /// Whether the present light has all bounces.
    pub(super) fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Whether this or an earlier light had all bounces.
    pub(super) fn was_ever_whole(&self) -> bool {
        self.is_whole || !self.before.is_empty()
    }

    /// The present light with the bounces of the light before that it lacks: a picture would else darken after each move.
    fn with_rest_of_before(&self) -> Option<Arc<MeshlessLight>> {
        let now = self.steps.last()?;
        let rest = self.before.get(self.steps.len() - 1).zip(self.before.last()).filter(|_| !self.is_whole);
        // A bake may have placed other functions since.
        let are_of_now = |(same, all): &(&Arc<MeshlessLight>, &Arc<MeshlessLight>)| {
            [same, all].iter().all(|light| light.has_functions_of(now))
        };
        let Some((same, all)) = rest.filter(are_of_now) else { return Some(now.clone()) };
        let coefficients = [now, all, same].map(|light| light.coefficients());
        let with_rest = |function: usize| {
            let [now, all, same] = coefficients.map(|of| of[function]);
            now + all - same
        };
        let functions = (0..coefficients[0].len()).into_par_iter();
        Some(now.with_coefficients(functions.map(with_rest).collect()).into())
    }
}
