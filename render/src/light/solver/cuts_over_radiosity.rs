//! Many bounces in functions of the objects, added to the surface sources, which cuts gather. Cuts know nothing of a move until they
//! are baked anew: till then functions show the light.

use super::{BounceLight, BounceSolver, radiosity::RadiositySolver, rigs::Rigs, solutions::Described};
use crate::light::{
    bounce::SourceLighting,
    situation::{Changes, Gathering, Situation},
};
use glam::Vec3;
use lapidary_core::{dataset::BakeParts, meshless::RadiositySettings, sources::SourceTree, transport::BounceEnergy};
use std::sync::Arc;

/// Gathers surface sources lit by all bounces of the functions.
#[derive(Default)]
pub struct CutsOverRadiosity {
    solver: RadiositySolver,
    /// The sources, of the present bake.
    tree: Option<Arc<SourceTree>>,
    /// Irradiance of each source from the bounces of the last whole light in W/m², if that was as baked.
    further: Option<Vec<Vec3>>,
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
        self.forget_another_bake(situation, rigs);
        let was_whole = self.solver.is_whole();
        let goes_on = self.solver.advance(situation, changes, rigs);
        let (is_as_baked, is_now_whole) = (situation.poses.is_empty(), !was_whole && self.solver.is_whole());
        if is_now_whole && is_as_baked {
            let tree = self.tree.clone();
            self.further = tree.zip(rigs.radiosity(situation)).map(|(tree, rig)| rig.at_sources(tree.sources()));
        } else if !is_as_baked && (is_now_whole || changes.relight()) {
            self.further = None;
        }
        let changes = is_now_whole || changes.poses || changes.relight() || changes.gathering;
        if is_as_baked && !self.functions_know_more() {
            if changes || self.gathered.is_none() {
                self.gathered = self.gather(situation, rigs);
            }
        } else if self.solver.light().is_some() {
            self.gathered = None;
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
    /// Whether only the functions have a whole light.
    fn functions_know_more(&self) -> bool {
        self.further.is_none() && self.solver.was_ever_whole()
    }

    fn forget_another_bake(&mut self, situation: &Situation, rigs: &mut Rigs) {
        let tree = rigs.sources(situation).map(|rig| rig.tree().clone());
        if tree.as_ref().map(Arc::as_ptr) != self.tree.as_ref().map(Arc::as_ptr) {
            (self.tree, self.further, self.gathered) = (tree, None, None);
        }
    }

    /// The further bounces of the light before stand in until those of the present light are whole.
    fn gather(&self, situation: &Situation, rigs: &mut Rigs) -> Option<Arc<SourceLighting>> {
        let Gathering { illum_cut, tau } = situation.gathering;
        let further = self.further.as_deref().unwrap_or_default();
        Some(rigs.sources(situation)?.lighting_with(further, illum_cut).with_tau(tau).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        baked::Baked,
        test_scenes::{linked_floor_and_wall, point_light},
    };
    use lapidary_core::{
        dataset::Dataset,
        meshless::{ObjectBases, Owner},
        scene::pose::{Pose, Poses},
        surfel::{MeshPlace, Surfel},
    };

    /// A floor and a wall with sources, and with functions on every eighth triangle.
    fn baked() -> Baked {
        let mut dataset: Dataset = linked_floor_and_wall();
        let mesh = &dataset.scene.mesh;
        let function = |triangle: usize| {
            let corners = mesh.triangles[triangle].map(|vertex| mesh.positions[vertex as usize]);
            let place = MeshPlace { triangle: triangle as u32, barycentric: glam::Vec2::splat(1.0 / 3.0) };
            let (position, normal) = (corners.iter().sum::<Vec3>() / 3.0, mesh.area_vector(triangle).normalize());
            let at = Surfel { position, normal, place };
            (at, Owner::on(mesh, &at))
        };
        let functions = (0..mesh.triangles.len()).step_by(8).map(function).collect();
        dataset.object_bases = Some(ObjectBases::new(&[functions], vec![1.0], 0).unwrap().into());
        dataset.into()
    }

    struct Stage {
        baked: Baked,
        rigs: Rigs,
        situation: Situation,
        solver: CutsOverRadiosity,
    }

    impl Stage {
        fn new(intensity: f32) -> Self {
            let baked = baked();
            let mut situation = Situation::unlit(&baked);
            situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), intensity)].into();
            Self { rigs: Rigs::new(&baked), solver: CutsOverRadiosity::default(), situation, baked }
        }

        /// All steps after a change: radiance of the sources where cuts gather, `None` where functions show the light.
        fn steps(&mut self, changes: Changes) -> Vec<Option<f32>> {
            let (mut changes, mut steps) = (changes, Vec::new());
            self.rigs.note(changes);
            loop {
                let goes_on = self.solver.advance(&self.situation, std::mem::take(&mut changes), &mut self.rigs);
                steps.push(match self.solver.light().expect("a light from the first step on") {
                    BounceLight::Sources(light) => Some(light.nodes.radiance.iter().map(|node| node.x).sum()),
                    _ => None,
                });
                if !goes_on {
                    return steps;
                }
            }
        }

        fn pose(&mut self, poses: Poses) -> Vec<Option<f32>> {
            (self.situation.scene, self.situation.poses) = (self.baked.posed(&poses).unwrap(), poses);
            self.steps(Changes { poses: true, ..Changes::NONE })
        }
    }

    #[test]
    fn cuts_gather_as_baked_and_functions_show_what_they_alone_know() {
        let mut stage = Stage::new(3.0);
        let first = stage.steps(Changes::ALL);
        let (one_bounce, all) = (first[0].unwrap(), first[first.len() - 1].unwrap());
        assert!(first.iter().all(Option::is_some) && all > 1.01 * one_bounce, "{first:?}");
        let mut moved = Poses::default();
        moved.set(0, Pose { translate: Vec3::Y * 0.1, ..Pose::AS_BAKED });
        assert!(stage.pose(moved).iter().all(Option::is_none));
        stage.situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), 6.0)].into();
        assert!(stage.steps(Changes { lights: true, ..Changes::NONE }).iter().all(Option::is_none));

        let back = stage.pose(Poses::default());
        let (last, before) = back.split_last().unwrap();
        assert!(before.iter().all(Option::is_none), "cuts would show bounces of another light: {back:?}");
        assert_eq!(*last, *Stage::new(6.0).steps(Changes::ALL).last().unwrap());
        assert!(last.unwrap() > 1.5 * all, "negative control");

        stage.situation.lights = [point_light(Vec3::new(-1.0, 1.2, 0.1), 3.0)].into();
        let dimmed = stage.steps(Changes { lights: true, ..Changes::NONE });
        assert!(dimmed.iter().all(Option::is_some), "the further bounces of before stand in: {dimmed:?}");
        assert_eq!(*dimmed.last().unwrap(), Some(all));
    }

    #[test]
    fn an_object_that_is_moved_before_the_first_bounce_takes_no_light_away() {
        let mut stage = Stage::new(3.0);
        stage.rigs.note(Changes::ALL);
        stage.solver.advance(&stage.situation, Changes::ALL, &mut stage.rigs);
        assert!(stage.solver.solver.light().is_none(), "negative control: no bounce yet");
        let mut moved = Poses::default();
        moved.set(0, Pose { translate: Vec3::Y * 0.1, ..Pose::AS_BAKED });
        let steps = stage.pose(moved);
        assert!(steps[0].is_some() && steps.last().unwrap().is_none(), "{steps:?}");
    }
}
