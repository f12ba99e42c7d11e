//! One bounce: surface sources under direct light, gathered by cuts (paper, 4.1).

use super::{
    BounceLight, BounceSolver, Gathering, Lit, LitBy,
    shared::{Rigs, Shared},
    solutions::{Bounces, Described},
};
use crate::{
    appearance::Appearance,
    baked::Baked,
    light::{
        bounce::{SourceLighting, SourceRig},
        environment::SceneLighting,
    },
};
use lapidary_core::lights::Light;
use std::sync::Arc;

/// Gathers the sources.
pub struct CutsSolver {
    sources: Shared<SourceRig>,
    by: LitBy,
    light: Option<Arc<SourceLighting>>,
}

impl Described for CutsSolver {
    const LABEL: &'static str = "Cuts";
    const SUMMARY: &'static str = "One bounce, sharp in glossy and bumped surfaces.";
    const METHOD: &'static str = "One bounce, by cuts over surface sources";
    const BOUNCES: u32 = 1;
    const NEEDS: Bounces = Bounces { cuts: true, meshless: false };

    fn new(_: &Baked, rigs: &Rigs) -> Option<Self> {
        Some(Self { sources: rigs.sources.clone()?, by: rigs.nothing.clone(), light: None })
    }
}

impl Lit for CutsSolver {
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

    fn set_gathering(&mut self, gathering: Gathering) {
        self.by.set_gathering(gathering);
        self.light = None;
    }
}

impl BounceSolver for CutsSolver {
    fn advance(&mut self) -> bool {
        if self.light.is_none() {
            let Gathering { illum_cut, tau } = self.by.gathering;
            let light = self.sources.lit(&self.by, |rig| rig.lighting(illum_cut));
            self.light = Some(light.with_tau(tau).into());
        }
        false
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Sources)
    }
}
