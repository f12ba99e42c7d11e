//! Many bounces in the meshless basis (Lehtinen et al. 2008).

use super::{
    BounceLight, BounceSolver, Lit, LitBy,
    shared::{Rigs, Shared},
    solutions::{Bounces, Described},
};
use crate::{
    appearance::Appearance,
    baked::Baked,
    light::{
        bounce::{MeshlessLight, MeshlessRig},
        environment::SceneLighting,
    },
};
use lapidary_core::{lights::Light, meshless::SolveSettings, transport::BounceEnergy};
use std::sync::Arc;

/// Solves in the basis.
pub struct MeshlessSolver {
    basis: Shared<MeshlessRig>,
    by: LitBy,
    light: Option<(Arc<MeshlessLight>, Option<BounceEnergy>)>,
}

impl Described for MeshlessSolver {
    const LABEL: &'static str = "Meshless";
    const SUMMARY: &'static str = "Many bounces, soft: the fastest while a light moves.";
    const METHOD: &'static str = "Many bounces, in the meshless basis";
    const BOUNCES: u32 = SolveSettings::DEFAULT.bounces;
    const NEEDS: Bounces = Bounces { cuts: false, meshless: true };

    fn new(_: &Baked, rigs: &Rigs) -> Option<Self> {
        Some(Self { basis: rigs.meshless.clone()?, by: rigs.nothing.clone(), light: None })
    }
}

impl Lit for MeshlessSolver {
    fn set_appearance(&mut self, appearance: &Arc<Appearance>) {
        self.by.set_appearance(appearance);
        self.light = None;
    }

    fn set_lights(&mut self, lights: &Arc<[Light]>) {
        self.by.set_lights(lights);
        self.light = None;
    }

    fn set_environment(&mut self, environment: Option<&Arc<SceneLighting>>) {
        self.by.set_environment(environment);
        self.light = None;
    }
}

impl BounceSolver for MeshlessSolver {
    fn advance(&mut self) -> bool {
        if self.light.is_none() {
            let solve = |rig: &mut MeshlessRig| Some((Arc::new(rig.light()?), rig.energy()));
            self.light = self.basis.lit(&self.by, solve);
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.as_ref().map(|(light, _)| BounceLight::Functions(light.clone()))
    }

    fn energy(&self) -> Option<BounceEnergy> {
        self.light.as_ref()?.1
    }
}
