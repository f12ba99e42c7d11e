//! Local lights and bounced light of a dataset, prepared repeatedly; results that an edit does not change are kept.

use crate::{
    appearance::Appearance,
    baked::Baked,
    light::{
        bounce::SourceLighting,
        components::Components,
        environment::{SceneLighting, is_same},
        implicit::PosedLight,
        solver::{BounceLight, BounceSolver, Lit, LitBy, Told, shared::Rigs, solutions::Solution},
    },
};
use lapidary_core::{
    lights::{Emission, Light},
    scene::pose::Poses,
    transport::BounceEnergy,
};
use std::sync::Arc;

/// The light of a picture beside the environment, and the components that are shown.
#[derive(Clone, Debug, Default)]
pub struct LocalLighting {
    /// Lights whose direct light is shown.
    pub lights: Arc<[Light]>,
    /// Suns, whose light belongs to the environment's.
    pub suns: Vec<Light>,
    /// Bounced light, of these lights and of the environment.
    pub bounce: Option<BounceLight>,
    /// What posed objects change of all that.
    pub posed: Option<Arc<PosedLight>>,
    /// The parts that are shown.
    pub components: Components,
    /// How the bounces in the picture decrease, if the solution has several.
    pub energy: Option<BounceEnergy>,
}

impl LocalLighting {
    /// Whether both are the same light, not only equal.
    pub fn is_same(&self, other: &Self) -> bool {
        let bounces = self.bounce.as_ref().zip(other.bounce.as_ref());
        self.bounce.is_some() == other.bounce.is_some()
            && bounces.is_none_or(|(a, b)| a.is_same(b))
            && is_same(self.posed.as_ref(), other.posed.as_ref())
            && Arc::ptr_eq(&self.lights, &other.lights)
            && self.suns == other.suns
            && self.components == other.components
    }

    /// Local lights if their direct light is shown, and suns if the environment is.
    pub(crate) fn shown_lights(&self) -> Vec<Light> {
        let local = self.lights.iter().filter(|_| self.components.direct);
        local.chain(self.suns.iter().filter(|_| self.components.environment)).cloned().collect()
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
    lights: Arc<[Light]>,
    /// Of the environment.
    suns: Vec<Light>,
    /// What the solvers are told.
    by: LitBy,
    /// One for each solution that the dataset has.
    solvers: Vec<(Solution, Told<dyn BounceSolver>)>,
}

impl LocalRig {
    /// For a dataset with the materials of its bake and without light.
    pub fn new(baked: &Baked) -> Self {
        let rigs = Rigs::new(baked);
        let told = |&solution: &Solution| Some((solution, Told::new(solution.solver(baked, &rigs)?, &rigs.nothing)));
        let solvers = Solution::ALL.iter().filter_map(told).collect();
        Self { lights: Arc::default(), suns: Vec::new(), by: rigs.nothing.clone(), solvers }
    }

    /// Poses the objects.
    pub fn set_poses(&mut self, poses: &Poses) {
        if *self.by.poses != *poses {
            self.by.set_poses(&Arc::new(poses.clone()));
        }
    }

    /// Gives the scene other materials.
    pub fn set_appearance(&mut self, appearance: &Appearance) {
        self.by.set_appearance(&Arc::new(appearance.clone()));
    }

    /// Sets the local lights; those that have changed cast rays when bounced light is needed.
    pub fn set_lights(&mut self, lights: &Arc<[Light]>) {
        if !Arc::ptr_eq(&self.lights, lights) {
            self.lights = lights.clone();
            self.by.set_lights(&self.bouncing());
        }
    }

    /// Sets the suns of the environment, as [`Self::set_lights`].
    pub fn set_suns(&mut self, suns: Vec<Light>) {
        if self.suns != suns {
            self.suns = suns;
            self.by.set_lights(&self.bouncing());
        }
    }

    /// The lights that bounce: of a sun the middle, for its penumbra is lost between the points that it lights.
    fn bouncing(&self) -> Arc<[Light]> {
        let middle = |sun: &Light| Light { emission: Emission::PARALLEL, ..sun.clone() };
        self.lights.iter().cloned().chain(self.suns.iter().map(middle)).collect()
    }

    /// Gives the lit cuts over the sources another `tau`, see [`SourceLighting::with_tau`].
    pub fn set_tau(&mut self, tau: f32) {
        self.by.gathering.tau = tau;
    }

    /// Shines the environment, or none.
    pub fn set_environment(&mut self, lighting: Option<&Arc<SceneLighting>>) {
        self.by.set_environment(lighting);
    }

    /// The light of a picture that shows `components`, with bounced light by `solution` if the dataset has it.
    /// Illumination cuts of the solver have at most `illum_cut` nodes.
    pub fn lighting(&mut self, components: Components, solution: Solution, illum_cut: u32) -> LocalLighting {
        self.by.gathering.illum_cut = illum_cut;
        let solver = if components.indirect { self.solved(solution) } else { None };
        LocalLighting {
            bounce: solver.and_then(|solver| solver.light()),
            energy: solver.and_then(|solver| solver.energy()),
            lights: self.lights.clone(),
            suns: self.suns.clone(),
            posed: None,
            components,
        }
    }

    /// The solver of a solution, in the light of the moment and with nothing left to do.
    fn solved(&mut self, solution: Solution) -> Option<&dyn BounceSolver> {
        let (_, told) = self.solvers.iter_mut().find(|(of, _)| *of == solution)?;
        let solver = told.tell(&self.by);
        while solver.advance() {}
        Some(solver)
    }
}

#[cfg(test)]
mod tests;
