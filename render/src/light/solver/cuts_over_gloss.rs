//! Many bounces in the meshless basis, added to surface sources that send by direction: gloss shows in what gloss and walls reflect.

use super::{BounceLight, BounceSolver, cuts_over_meshless::Further, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::SourceLighting,
    sent::SentByDirection,
    situation::{Changes, Gathering, Situation},
};
use lapidary_core::{dataset::BakeParts, meshless::SolveSettings, transport::BounceEnergy};
use std::sync::Arc;

/// Gathers glossy sources lit by all bounces of the basis.
#[derive(Default)]
pub struct CutsOverGloss {
    further: Further,
    sent: Option<Arc<SentByDirection>>,
    /// Whether the present light has not been sent by direction yet.
    is_stale: bool,
    light: Option<Arc<SourceLighting>>,
}

impl Described for CutsOverGloss {
    const LABEL: &'static str = "Glossy";
    const SUMMARY: &'static str =
        "Many bounces, glossy ones too: gloss brightens what it shines on. Lobes are widened to a roughness of 0.32.";
    const METHOD: &'static str = "Meshless bounces added to surface sources that send by direction, gathered by cuts";
    const BOUNCES: u32 = SolveSettings::DEFAULT.bounces + 1;
    const NEEDS: BakeParts = BakeParts::INDIRECT.with(BakeParts::MESHLESS);
}

impl BounceSolver for CutsOverGloss {
    /// The first steps trace rays, and show diffuse sources meanwhile.
    fn advance(&mut self, situation: &Situation, changes: Changes, rigs: &mut Rigs) -> bool {
        if changes.relight() {
            self.further = Further::of(situation, rigs).unwrap_or_default();
            self.is_stale = true;
        }
        let lacks_rays = rigs.gloss(situation).is_some_and(|(gloss, _)| gloss.trace_some());
        let is_due = self.is_stale && !lacks_rays;
        if is_due {
            self.sent = self.sent_now(situation, rigs).map(Arc::new);
            self.is_stale = false;
        }
        if is_due || changes.relight() || changes.gathering {
            let (Gathering { illum_cut, tau }, further) = (situation.gathering, &self.further.irradiance);
            let gathered = rigs.sources(situation).map(|rig| rig.lighting_with(further, illum_cut).with_tau(tau));
            self.light = gathered.map(|light| light.with_sent(self.sent.clone()).into());
        }
        lacks_rays
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Sources)
    }

    fn energy(&self) -> Option<BounceEnergy> {
        self.further.energy
    }
}

impl CutsOverGloss {
    fn sent_now(&self, situation: &Situation, rigs: &mut Rigs) -> Option<SentByDirection> {
        let (gloss, sources) = rigs.gloss(situation)?;
        Some(gloss.sent(sources, &self.further.irradiance, situation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Solution,
        baked::Baked,
        light::solver::cuts_over_meshless::CutsOverMeshless,
        test_scenes::{linked_floor_and_wall, point_light},
    };
    use glam::Vec3;
    use lapidary_core::{brdf::GgxParameters, material::BrdfModel};

    struct Stage<S> {
        rigs: Rigs,
        situation: Situation,
        solver: S,
    }

    impl<S: BounceSolver + Default> Stage<S> {
        fn new() -> Self {
            let baked = Baked::from(linked_floor_and_wall());
            let mut situation = Situation::unlit(&baked);
            situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), 3.0)].into();
            Self { rigs: Rigs::new(&baked), situation, solver: S::default() }
        }

        /// The light after all steps.
        fn light(&mut self, changes: Changes) -> Arc<SourceLighting> {
            self.rigs.note(changes);
            let mut changes = changes;
            while self.solver.advance(&self.situation, std::mem::take(&mut changes), &mut self.rigs) {
                assert!(self.solver.light().is_some(), "diffuse light meanwhile");
            }
            let Some(BounceLight::Sources(light)) = self.solver.light() else { panic!("sources") };
            light
        }
    }

    #[test]
    fn its_sources_are_those_of_cuts_over_meshless_and_send_by_direction() {
        let (mut gloss, mut meshless) = (Stage::<CutsOverGloss>::new(), Stage::<CutsOverMeshless>::new());
        let diffuse = gloss.light(Changes::ALL);
        assert!(diffuse.nodes.radiance == meshless.light(Changes::ALL).nodes.radiance);
        let sent = |light: &Arc<SourceLighting>| light.sent.clone().expect("sent by direction");
        gloss.situation.gathering = Gathering { illum_cut: 16, tau: 0.0 };
        let coarser = gloss.light(Changes { gathering: true, ..Changes::NONE });
        assert_eq!(coarser.max_nodes, 16);
        assert!(Arc::ptr_eq(&sent(&diffuse), &sent(&coarser)), "another cut sends the same light");
        let mut appearance = (*gloss.situation.appearance).clone();
        appearance.materials[1].model = BrdfModel::Ggx;
        appearance.materials[1].parameters =
            GgxParameters { base_color: Vec3::ONE, roughness: 0.4, metalness: 1.0, ..Default::default() }.into();
        gloss.situation.appearance = appearance.into();
        let metal = gloss.light(Changes { appearance: true, ..Changes::NONE });
        assert!(sent(&metal).codes() != sent(&diffuse).codes(), "negative control");
        assert!(metal.extents.iter().zip(&diffuse.extents).any(|(a, b)| a.brightness > 2.0 * b.brightness));
    }

    #[test]
    fn its_view_has_its_solution() {
        let look = crate::test_looks::look();
        let view = crate::View { mode: crate::ViewMode::Gloss, ..look.view.clone() };
        assert_eq!(crate::Look { view, ..look }.shown_solution(), Solution::CutsGloss);
    }
}
