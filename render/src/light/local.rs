//! Local lights and bounced light of a dataset, prepared repeatedly; results that an edit does not change are kept.

use crate::{
    appearance::Appearance,
    baked::Baked,
    light::{
        bounce::{MeshlessLight, MeshlessRig, SourceLighting, SourceRig},
        components::{Components, Solution},
        environment::{SceneLighting, is_same},
        implicit::PosedLight,
    },
};
use glam::Vec3;
use lapidary_core::{
    cut::lit::DEFAULT_TAU,
    lights::{Emission, Light},
    surfel::Surfel,
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
    pub indirect: Option<Arc<SourceLighting>>,
    /// Bounced light of the meshless basis, in place of [`Self::indirect`].
    pub meshless: Option<Arc<MeshlessLight>>,
    /// What posed objects change of all that.
    pub posed: Option<Arc<PosedLight>>,
    /// The parts that are shown.
    pub components: Components,
    /// Energy of each bounce of the meshless basis, if the picture contains them.
    pub energy: Option<BounceEnergy>,
}

impl LocalLighting {
    /// Whether both are the same light, not only equal.
    pub fn is_same(&self, other: &Self) -> bool {
        is_same(self.indirect.as_ref(), other.indirect.as_ref())
            && is_same(self.meshless.as_ref(), other.meshless.as_ref())
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

    /// Whether any bounced light is shown.
    pub(crate) fn shows_bounces(&self) -> bool {
        self.shown_indirect().is_some() || self.shown_meshless().is_some()
    }

    /// Bounced light of the meshless basis if it is shown.
    pub(crate) fn shown_meshless(&self) -> Option<&Arc<MeshlessLight>> {
        self.meshless.as_ref().filter(|_| self.components.indirect)
    }

    /// Bounced light if it is shown.
    pub(crate) fn shown_indirect(&self) -> Option<&Arc<SourceLighting>> {
        self.indirect.as_ref().filter(|_| self.components.indirect)
    }
}

/// Makes the [`LocalLighting`] of a picture.
pub struct LocalRig {
    lights: Arc<[Light]>,
    /// Of the environment.
    suns: Vec<Light>,
    environment: Option<Arc<SceneLighting>>,
    /// `None` for a dataset without sources.
    sources: Option<SourceRig>,
    /// `None` for a dataset without a meshless basis.
    meshless: Option<MeshlessRig>,
    /// Of the sources.
    surfels: Vec<Surfel>,
    /// The environment that lights the sources, and the senders of the basis.
    on_sources: Option<Arc<SceneLighting>>,
    on_senders: Option<Arc<SceneLighting>>,
    /// Of the lit cuts over the sources.
    tau: f32,
    /// The last gathered light, with its solution and size of the illumination cut; `None` after any change.
    gathered: Option<(Solution, u32, Arc<SourceLighting>)>,
    /// The last solution in the basis; `None` after any change.
    solved: Option<Arc<MeshlessLight>>,
    /// The last irradiance of the sources from further bounces; `None` after any change.
    further: Option<Vec<Vec3>>,
}

impl LocalRig {
    /// For a dataset with the materials of its bake and without light.
    pub fn new(baked: &Baked) -> Self {
        let sources = SourceRig::new(baked);
        let surfels = sources.iter().flat_map(|rig| rig.tree().sources()).map(|source| source.surfel).collect();
        let (lights, meshless) = (Arc::default(), MeshlessRig::new(baked));
        Self {
            lights,
            suns: Vec::new(),
            environment: None,
            sources,
            meshless,
            surfels,
            on_sources: None,
            on_senders: None,
            tau: DEFAULT_TAU,
            gathered: None,
            solved: None,
            further: None,
        }
    }

    /// Gives the scene other materials.
    pub fn set_appearance(&mut self, appearance: &Appearance) {
        self.sources.iter_mut().for_each(|rig| rig.set_appearance(appearance));
        self.meshless.iter_mut().for_each(|rig| rig.set_appearance(appearance));
        self.forget();
    }

    /// Sets the local lights; those that have changed cast rays when bounced light is needed.
    pub fn set_lights(&mut self, lights: &Arc<[Light]>) {
        if !Arc::ptr_eq(&self.lights, lights) {
            self.lights = lights.clone();
            self.forget();
        }
    }

    /// Sets the suns of the environment, as [`Self::set_lights`].
    pub fn set_suns(&mut self, suns: Vec<Light>) {
        if self.suns != suns {
            self.suns = suns;
            self.forget();
        }
    }

    /// The lights that bounce: of a sun the middle, for its penumbra is lost between the points that it lights.
    fn bouncing(&self) -> Vec<Light> {
        let middle = |sun: &Light| Light { emission: Emission::PARALLEL, ..sun.clone() };
        self.lights.iter().cloned().chain(self.suns.iter().map(middle)).collect()
    }

    /// Gives the lit cuts over the sources another `tau`, see [`SourceLighting::with_tau`].
    pub fn set_tau(&mut self, tau: f32) {
        if self.tau != tau {
            (self.tau, self.gathered) = (tau, None);
        }
    }

    /// Shines the environment, or none.
    pub fn set_environment(&mut self, lighting: Option<&Arc<SceneLighting>>) {
        if !is_same(self.environment.as_ref(), lighting) {
            self.environment = lighting.cloned();
            self.forget();
        }
    }

    fn forget(&mut self) {
        (self.gathered, self.solved, self.further) = (None, None, None);
    }

    /// The light of a picture that shows `components`, with bounced light by `solution` as far as the dataset has it.
    /// The illumination cut of the sources has at most `illum_cut` nodes.
    pub fn lighting(&mut self, components: Components, solution: Solution, illum_cut: u32) -> LocalLighting {
        let (lights, suns) = (self.lights.clone(), self.suns.clone());
        let (indirect, meshless) = match solution {
            _ if !components.indirect => (None, None),
            Solution::Meshless => (None, self.solve()),
            Solution::Cuts | Solution::CutsMeshless => (self.gather(solution, illum_cut), None),
        };
        let solved = self.meshless.as_ref().filter(|_| components.indirect && solution != Solution::Cuts);
        let energy = solved.and_then(MeshlessRig::energy);
        LocalLighting { lights, suns, indirect, meshless, posed: None, components, energy }
    }

    fn gather(&mut self, solution: Solution, illum_cut: u32) -> Option<Arc<SourceLighting>> {
        let known = self.gathered.as_ref().filter(|(s, cut, _)| (*s, *cut) == (solution, illum_cut));
        if let Some((.., lighting)) = known {
            return Some(lighting.clone());
        }
        let further = if solution == Solution::CutsMeshless { self.further() } else { None };
        let lights = self.bouncing();
        let sources = self.sources.as_mut()?;
        sources.set_lights(&lights);
        if !is_same(self.on_sources.as_ref(), self.environment.as_ref()) {
            sources.set_environment(self.environment.as_deref());
            self.on_sources = self.environment.clone();
        }
        sources.set_further(further);
        let lighting = Arc::new(sources.lighting(illum_cut).with_tau(self.tau));
        self.gathered = Some((solution, illum_cut, lighting.clone()));
        Some(lighting)
    }

    fn solve(&mut self) -> Option<Arc<MeshlessLight>> {
        if self.solved.is_none() {
            self.solved = self.lit_meshless()?.light().map(Arc::new);
        }
        self.solved.clone()
    }

    /// Bounces on the sources beyond the direct light.
    fn further(&mut self) -> Option<Vec<Vec3>> {
        if self.further.is_none() {
            let surfels = std::mem::take(&mut self.surfels);
            self.further = self.lit_meshless().and_then(|rig| rig.at_sources(&surfels));
            self.surfels = surfels;
        }
        self.further.clone()
    }

    fn lit_meshless(&mut self) -> Option<&mut MeshlessRig> {
        let lights = self.bouncing();
        let rig = self.meshless.as_mut()?;
        rig.set_lights(&lights);
        if !is_same(self.on_senders.as_ref(), self.environment.as_ref()) {
            rig.set_environment(self.environment.as_deref());
            self.on_senders = self.environment.clone();
        }
        Some(rig)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{linked_floor_and_wall, point_light};

    #[test]
    fn another_cut_or_solution_takes_no_other_bounces_and_another_light_does() {
        let mut rig = LocalRig::new(&Baked::from(linked_floor_and_wall()));
        rig.set_lights(&[point_light(Vec3::new(-1.0, 1.2, 0.1), 3.0)].into());
        let place = |rig: &mut LocalRig, solution, illum_cut| {
            let lighting = rig.lighting(Components::ALL, solution, illum_cut);
            let place = rig.further.as_ref().map(|further| further.as_ptr());
            (place, lighting.indirect, lighting.energy)
        };
        let (further, first, _) = place(&mut rig, Solution::CutsMeshless, 64);
        let (kept, coarser, energy) = place(&mut rig, Solution::CutsMeshless, 16);
        assert!(further.is_some() && further == kept && energy.is_some());
        assert_eq!((first.unwrap().max_nodes, coarser.unwrap().max_nodes), (64, 16));
        let (kept, _, energy) = place(&mut rig, Solution::Meshless, 16);
        assert!(kept == further && energy.is_some());
        place(&mut rig, Solution::Cuts, 16);
        assert!(place(&mut rig, Solution::CutsMeshless, 16).0 == further, "and back");
        rig.set_lights(&[point_light(Vec3::new(-1.0, 1.2, 0.1), 6.0)].into());
        assert!(rig.further.is_none(), "negative control");
    }
}
