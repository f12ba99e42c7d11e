//! A minimal solver: the same irradiance everywhere. It shows that a file and a line in the list of solutions add a solver. It
//! takes several steps.

use super::{BounceLight, BounceSolver, rigs::Rigs, solutions::Described};
use crate::light::{
    implicit::Sides,
    situation::{Changes, Situation},
};
use glam::Vec3;
use lapidary_core::{dataset::BakeParts, transport::BounceEnergy};
use std::sync::Arc;

/// Lights all surfaces evenly with the summed intensities of the lights; each step adds half of the remaining light.
#[derive(Default)]
pub struct Even {
    wanted: Vec3,
    steps: u32,
    light: Option<Arc<Sides>>,
}

/// Steps to the full light.
const STEPS: u32 = 3;

impl Described for Even {
    const LABEL: &'static str = "Even";
    const SUMMARY: &'static str = "The same light everywhere.";
    const METHOD: &'static str = "Irradiance of the lights' intensities";
    const BOUNCES: u32 = STEPS;
    const NEEDS: BakeParts = BakeParts::INDIRECT.with(BakeParts::MESHLESS);
}

impl BounceSolver for Even {
    fn advance(&mut self, situation: &Situation, changes: Changes, _: &mut Rigs) -> bool {
        if changes.lights {
            (self.wanted, self.steps) = (situation.lights.iter().map(|light| light.intensity).sum(), 0);
        }
        if self.steps < STEPS {
            self.steps += 1;
            let vertices = situation.scene.dataset.scene.mesh.positions.len();
            let side = vec![self.wanted * (1.0 - 0.5_f32.powi(self.steps as i32)); vertices];
            self.light = Some(Sides { front: side.clone(), back: side }.into());
        }
        self.steps < STEPS
    }

    fn light(&self) -> Option<BounceLight> {
        self.light.clone().map(BounceLight::Vertices)
    }

    fn energy(&self) -> Option<BounceEnergy> {
        let means: Vec<Vec3> = (0..=self.steps).map(|step| self.wanted * 0.5_f32.powi(step as i32)).collect();
        Some(BounceEnergy::of(&means))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Appearance, Backend, Baked, Components, CpuBackend, LitScene, Look, Refined, Solution, View,
        appearance::ResolvedAppearance,
        test_looks::look,
        test_scenes::{from_above, linked_floor_and_wall, point_light},
    };
    use std::f32::consts::FRAC_1_PI;

    #[test]
    fn a_solver_by_its_file_and_its_line_is_seen_in_a_picture() {
        let baked = Baked::from(linked_floor_and_wall());
        let appearance = Appearance::of(&baked.dataset.scene);
        let albedo = ResolvedAppearance::from(appearance.clone()).albedo(&baked.dataset.scene.mesh, Default::default());
        let light = |intensity: f32| point_light(Vec3::new(-1.0, 1.2, 0.1), intensity);
        let mut scene = LitScene::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
        let mut at_center = |solution, intensity| {
            let components = Components { indirect: true, ..Components::NONE };
            let (view, lights) = (View { aa: 1, ..from_above(8) }, [light(intensity)].into());
            let look = Look { appearance: appearance.clone(), lights, components, solution, view, ..look() };
            scene.show_whole(&look).unwrap().image.pixels[27]
        };
        for intensity in [2.0, 4.0] {
            let (found, expected) = (at_center(Solution::Even, intensity), albedo * intensity * 0.875 * FRAC_1_PI);
            assert!((found - expected).length() < 1e-5 * expected.length(), "{found} for {expected}");
            assert!((at_center(Solution::Cuts, intensity) - expected).length() > 0.1 * expected.length(), "control");
        }
    }

    #[test]
    fn a_picture_may_be_shown_between_the_steps_and_is_whole_after_the_last() {
        let baked = Baked::from(linked_floor_and_wall());
        let components = Components { indirect: true, ..Components::NONE };
        let (view, lights) = (View { aa: 1, ..from_above(8) }, [point_light(Vec3::ONE, 2.0)].into());
        let appearance = Appearance::of(&baked.dataset.scene);
        let look = Look { appearance, lights, components, solution: Solution::Even, view, ..look() };
        let begin = || LitScene::new(Box::new(CpuBackend::new()), baked.clone()).unwrap();
        let mut scene = begin();
        let shown = |scene: &mut LitScene<CpuBackend>| {
            scene.resume(&look.view, look.sampling).unwrap();
            scene.render_rows(0, 0..8).unwrap();
            scene.backend().read(1).unwrap().0
        };
        scene.light_soon(&look).unwrap();
        let mut pictures = vec![shown(&mut scene)];
        while scene.is_coarse() {
            assert_eq!(scene.refine(&look).unwrap(), Refined::Light);
            pictures.push(shown(&mut scene));
        }
        let shares: Vec<f32> = pictures.iter().map(|p| p.pixels[27].x / pictures[2].pixels[27].x * 0.875).collect();
        assert!(shares.iter().zip([0.5, 0.75, 0.875]).all(|(a, b)| (a - b).abs() < 1e-5), "{shares:?}");
        assert!(pictures[2] == begin().show_whole(&look).unwrap().image);
        assert_eq!(scene.refine(&look).unwrap(), Refined::Nothing, "nothing is left to do");

        let mut scene = begin();
        scene.light_soon(&look).unwrap();
        let mut aside = look.clone();
        aside.view.camera.eye.x += 0.3;
        scene.light_soon(&aside).unwrap();
        assert!(scene.is_unsolved(), "another view does not end the solution");
        assert!(scene.show_whole(&aside).unwrap().image == begin().show_whole(&aside).unwrap().image);
    }

    #[test]
    fn it_is_listed_as_the_others_are_and_light_may_be_shown_before_it_is_whole() {
        let baked = Baked::from(linked_floor_and_wall());
        assert!(Solution::of(baked.dataset.bounces()).contains(&Solution::Even));
        assert_eq!((Solution::Even.label(), Solution::Even.bounces()), ("Even", STEPS));
        let (mut rigs, mut solver) = (Rigs::new(&baked), Solution::Even.solver());
        let situation = Situation { lights: [point_light(Vec3::ZERO, 8.0)].into(), ..Situation::unlit(&baked) };
        assert!(solver.light().is_none());
        let (mut steps, mut changes) = (Vec::new(), Changes::ALL);
        while {
            let goes_on = solver.advance(&situation, std::mem::take(&mut changes), &mut rigs);
            let Some(BounceLight::Vertices(light)) = solver.light() else { panic!("no light") };
            steps.push(light.front[0].x);
            goes_on
        } {}
        assert_eq!(steps, [4.0, 6.0, 7.0]);
        assert_eq!(solver.energy().unwrap().bounces, STEPS);
    }
}
