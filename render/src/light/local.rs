//! Local lights and bounced light of a dataset, prepared repeatedly; results that an edit does not change are kept.

use crate::{
    baked::Baked,
    light::{
        bounce::SourceLighting,
        components::Components,
        implicit::PosedLighting,
        situation::{Changes, Situation},
        solver::{BounceLight, BounceSolver, rigs::Rigs, solutions::Solution},
    },
};
use lapidary_core::{lights::Light, transport::BounceEnergy};
use std::sync::Arc;

/// All light of a picture except the environment, and the components that are shown.
#[derive(Clone, Debug, Default)]
pub struct LocalLighting {
    /// Lights whose direct light is shown.
    pub lights: Arc<[Light]>,
    /// Suns, whose light belongs to the environment's.
    pub suns: Arc<[Light]>,
    /// Bounced light of these lights and of the environment.
    pub bounce: Option<BounceLight>,
    /// Changes of the light by posed objects.
    pub posed: Option<Arc<PosedLighting>>,
    /// The parts that are shown.
    pub components: Components,
    /// Energy of the successive bounces, if the solution has several.
    pub energy: Option<BounceEnergy>,
}

impl LocalLighting {
    /// Local lights if their direct light is shown, and suns if the environment is.
    pub(crate) fn shown_lights(&self) -> Vec<Light> {
        let local = self.lights.iter().filter(|_| self.components.direct);
        local.chain(self.suns.iter().filter(|_| self.components.environment)).cloned().collect()
    }

    /// The same with changes of the light by posed objects. A solution that follows poses has their bounces already.
    pub(crate) fn with_posed(self, posed: Option<Arc<PosedLighting>>, solution: Solution) -> Self {
        let without_bounces = |posed: Arc<PosedLighting>| posed.without_bounces().into();
        let posed = if solution.follows_poses() { posed.map(without_bounces) } else { posed };
        Self { posed, ..self }
    }

    /// Bounced light if it is shown.
    pub(crate) fn shown_bounce(&self) -> Option<&BounceLight> {
        self.bounce.as_ref().filter(|_| self.components.indirect)
    }

    /// The surface sources, if the bounced light is gathered from some.
    pub fn sources(&self) -> Option<&Arc<SourceLighting>> {
        match &self.bounce {
            Some(BounceLight::Sources(sources)) => Some(sources),
            _ => None,
        }
    }
}

/// Makes the [`LocalLighting`] of a picture.
pub struct LocalRig {
    rigs: Rigs,
    /// One solver per available solution, with the changes since its last step.
    solvers: Vec<(Solution, Box<dyn BounceSolver>, Changes)>,
}

impl LocalRig {
    /// Creates a rig for a dataset.
    pub fn new(baked: &Baked) -> Self {
        let solutions = Solution::of(baked.dataset.bounces()).into_iter();
        let solvers = solutions.map(|solution| (solution, solution.solver(), Changes::ALL)).collect();
        Self { rigs: Rigs::new(baked), solvers }
    }

    /// Takes over solvers of a bake with the same vertices whose light follows poses. They show it until theirs is solved.
    pub fn take_over(&mut self, before: Self) {
        for (solution, solver, _) in before.solvers.into_iter().filter(|(solution, ..)| solution.follows_poses()) {
            if let Some(own) = self.solvers.iter_mut().find(|(of, ..)| *of == solution) {
                own.1 = solver;
            }
        }
    }

    /// Records changes. Rays are cast when bounced light is needed.
    pub fn note(&mut self, changes: Changes) {
        self.rigs.note(changes);
        self.solvers.iter_mut().for_each(|(.., since)| *since = *since | changes);
    }

    /// Computes the next step of bounced light by `solution`. Returns whether more steps remain.
    pub fn advance(&mut self, situation: &Situation, solution: Solution) -> bool {
        let Self { rigs, solvers } = self;
        let solver = solvers.iter_mut().find(|(of, ..)| *of == solution);
        solver.is_some_and(|(_, solver, changes)| solver.advance(situation, std::mem::take(changes), rigs))
    }

    /// Light of a picture that shows `components`, with bounced light by `solution` as far as it has advanced.
    pub fn lighting(&self, situation: &Situation, components: Components, solution: Solution) -> LocalLighting {
        let solver = self.solvers.iter().find(|(of, ..)| *of == solution).filter(|_| components.indirect);
        LocalLighting {
            bounce: solver.and_then(|(_, solver, _)| solver.light()),
            energy: solver.and_then(|(_, solver, _)| solver.energy()),
            lights: situation.lights.clone(),
            suns: situation.suns.clone(),
            posed: None,
            components,
        }
    }
}

#[cfg(test)]
mod tests;
