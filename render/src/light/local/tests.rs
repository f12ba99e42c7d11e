//! Which edits recompute bounced light.

use super::*;
use crate::test_scenes::{Edited, linked_floor_and_wall, point_light};
use glam::Vec3;
use lapidary_core::{dataset::Dataset, meshless::Transport};

fn lamp(intensity: f32) -> Arc<[Light]> {
    [point_light(Vec3::new(-1.0, 1.2, 0.1), intensity)].into()
}

/// The floor also lights the wall, where the sources are.
fn linked_both_ways() -> Dataset {
    let mut dataset = linked_floor_and_wall();
    let rows = [vec![(1, Vec3::new(0.3, -0.2, 0.0))], vec![(0, Vec3::new(-0.3, 0.2, 0.05))]];
    Arc::make_mut(dataset.meshless.as_mut().unwrap()).transport = Transport::from_rows(&rows, 2);
    dataset
}

fn rig(dataset: Dataset) -> Edited<LocalRig> {
    let baked = Baked::from(dataset);
    Edited::new(&baked, LocalRig::new(&baked))
}

fn sources(rig: &mut Edited<LocalRig>, solution: Solution, illum_cut: u32) -> Arc<SourceLighting> {
    rig.lighting(Components::ALL, solution, illum_cut).sources().unwrap().clone()
}

#[test]
fn each_solution_keeps_its_light_until_it_is_lit_otherwise() {
    let mut rig = rig(linked_both_ways());
    rig.set_lights(&lamp(3.0));
    let first = sources(&mut rig, Solution::CutsMeshless, 64);
    let basis = |rig: &mut Edited<LocalRig>, illum_cut| {
        let Some(BounceLight::Functions(light)) = rig.lighting(Components::ALL, Solution::Meshless, illum_cut).bounce
        else {
            panic!("no functions")
        };
        light
    };
    let functions = basis(&mut rig, 64);
    let one = sources(&mut rig, Solution::Cuts, 64);
    assert!(Arc::ptr_eq(&first, &sources(&mut rig, Solution::CutsMeshless, 64)), "and back");
    assert!(Arc::ptr_eq(&functions, &basis(&mut rig, 16)), "it has no cuts");
    let coarser = sources(&mut rig, Solution::CutsMeshless, 16);
    assert_eq!((first.max_nodes, coarser.max_nodes), (64, 16));
    assert!(first.nodes.radiance == coarser.nodes.radiance && first.nodes.radiance != one.nodes.radiance);
    rig.set_lights(&lamp(6.0));
    let brighter = sources(&mut rig, Solution::CutsMeshless, 16);
    assert!(coarser.nodes.radiance != brighter.nodes.radiance, "negative control");
    rig.set_lights(&lamp(3.0));
    assert!(sources(&mut rig, Solution::Cuts, 16).nodes.radiance == one.nodes.radiance, "in the light of now");
    assert!(sources(&mut rig, Solution::CutsMeshless, 64).nodes.radiance == first.nodes.radiance);
}

#[test]
fn the_gathered_bounce_counts() {
    let mut rig = rig(linked_floor_and_wall());
    rig.set_lights(&lamp(3.0));
    let mut bounces = |solution| {
        let energy = rig.lighting(Components::ALL, solution, 16).energy;
        assert!(energy.is_none_or(|energy| energy.bounces == Solution::bounces(solution)));
        energy.map(|energy| energy.bounces)
    };
    let found = [Solution::Cuts, Solution::Meshless, Solution::CutsMeshless].map(&mut bounces);
    assert_eq!(found, [None, Some(4), Some(5)]);
    assert!(rig.lighting(Components::UNBOUNCED, Solution::Meshless, 16).energy.is_none(), "not in the picture");
}

#[test]
fn a_dataset_without_what_a_solution_needs_has_no_light_by_it() {
    let mut dataset = linked_floor_and_wall();
    dataset.meshless = None;
    let mut rig = rig(dataset);
    rig.set_lights(&lamp(3.0));
    let mut shows = |solution| rig.lighting(Components::ALL, solution, 16).shown_bounce().is_some();
    assert_eq!([Solution::Cuts, Solution::Meshless, Solution::CutsMeshless].map(&mut shows), [true, false, false]);
}
