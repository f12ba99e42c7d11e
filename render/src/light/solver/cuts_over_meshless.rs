//! Many bounces in the meshless basis, added to the surface sources, which cuts gather: the last bounce is as sharp as one bounce
//! by cuts.

use super::{
    BounceLight, BounceSolver, Gathering, Lit, LitBy,
    shared::{Rigs, Shared},
    solutions::{Bounces, Described},
};
use crate::{
    appearance::Appearance,
    baked::Baked,
    light::{
        bounce::{MeshlessRig, SourceLighting, SourceRig},
        environment::SceneLighting,
    },
};
use glam::Vec3;
use lapidary_core::{lights::Light, meshless::SolveSettings, surfel::Surfel, transport::BounceEnergy};
use std::sync::Arc;

/// Gathers the sources under all bounces of the basis.
pub struct CutsOverMeshless {
    sources: Shared<SourceRig>,
    basis: Shared<MeshlessRig>,
    /// Of the sources.
    surfels: Vec<Surfel>,
    by: LitBy,
    further: Option<Further>,
    light: Option<Arc<SourceLighting>>,
}

/// Bounces beyond the direct light of the sources.
struct Further {
    /// Of each source, in W/m².
    irradiance: Vec<Vec3>,
    energy: Option<BounceEnergy>,
}

impl Described for CutsOverMeshless {
    const LABEL: &'static str = "Cuts over meshless";
    const SUMMARY: &'static str = "Many bounces, the last one sharp in glossy and bumped surfaces.";
    const METHOD: &'static str = "Meshless bounces added to the surface sources, gathered by cuts";
    const BOUNCES: u32 = SolveSettings::DEFAULT.bounces + 1;
    const NEEDS: Bounces = Bounces { cuts: true, meshless: true };

    fn new(_: &Baked, rigs: &Rigs) -> Option<Self> {
        let (sources, basis) = (rigs.sources.clone()?, rigs.meshless.clone()?);
        let surfels = |rig: &mut SourceRig| rig.tree().sources().iter().map(|source| source.surfel).collect();
        let surfels = sources.lit(&rigs.nothing, surfels);
        Some(Self { sources, basis, surfels, by: rigs.nothing.clone(), further: None, light: None })
    }
}

impl CutsOverMeshless {
    fn forget(&mut self) {
        (self.further, self.light) = (None, None);
    }
}

impl Lit for CutsOverMeshless {
    fn set_appearance(&mut self, appearance: &Arc<Appearance>) {
        self.by.set_appearance(appearance);
        self.forget();
    }

    fn set_lights(&mut self, lights: &Arc<[Light]>) {
        self.by.set_lights(lights);
        self.forget();
    }

    fn set_environment(&mut self, environment: Option<&Arc<SceneLighting>>) {
        self.by.set_environment(environment);
        self.forget();
    }

    fn set_gathering(&mut self, gathering: Gathering) {
        self.by.set_gathering(gathering);
        self.light = None;
    }
}

impl BounceSolver for CutsOverMeshless {
    fn advance(&mut self) -> bool {
        let Self { sources, basis, surfels, by, further, light } = self;
        let at_sources = |rig: &mut MeshlessRig| {
            Some(Further { irradiance: rig.at_sources(surfels)?, energy: rig.energy().map(BounceEnergy::and_the_next) })
        };
        if further.is_none() {
            *further = basis.lit(by, at_sources);
        }
        if light.is_none() {
            let Gathering { illum_cut, tau } = by.gathering;
            let further = further.as_ref().map_or(&[][..], |further| &further.irradiance);
            *light = Some(sources.lit(by, |rig| rig.lighting_with(further, illum_cut)).with_tau(tau).into());
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Sources)
    }

    /// With the bounce that is gathered.
    fn energy(&self) -> Option<BounceEnergy> {
        self.further.as_ref()?.energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{linked_floor_and_wall, point_light};

    #[test]
    fn another_cut_takes_no_other_bounces_and_another_light_does() {
        let baked = Baked::from(linked_floor_and_wall());
        let rigs = Rigs::new(&baked);
        let mut solver = CutsOverMeshless::new(&baked, &rigs).unwrap();
        let mut by = rigs.nothing.clone();
        let mut shine = |solver: &mut CutsOverMeshless, intensity| {
            by.set_lights(&[point_light(Vec3::new(-1.0, 1.2, 0.1), intensity)].into());
            solver.set_lights(&by.lights);
            by.clone()
        };
        let place = |solver: &CutsOverMeshless| solver.further.as_ref().map(|further| further.irradiance.as_ptr());
        let by = shine(&mut solver, 3.0);
        solver.advance();
        let first = place(&solver);
        solver.set_gathering(Gathering { illum_cut: 16, tau: 0.0 });
        solver.advance();
        assert!(first.is_some() && first == place(&solver));
        let basis = rigs.meshless.as_ref().unwrap();
        let is_solved = |by: &LitBy| basis.lit(by, |rig| rig.energy().is_some());
        assert!(is_solved(&by), "another solver finds the solution");
        let by = shine(&mut solver, 6.0);
        assert!(place(&solver).is_none() && !is_solved(&by), "negative control");
    }
}
