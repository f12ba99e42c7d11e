//! A fresh bake passes, and a damaged one does not.

use super::*;
use crate::{
    bake::{
        BakeJob, bake,
        settings::{Preset, resolve},
    },
    observer::Silent,
    test_scenes::{cuboid, floor, room, scene_of},
};
use lapidary_core::{
    cut::{
        CutCriterion, CutSelector, SourceCriterion,
        packed::{PackedCuts, depth, value},
        prune_sources,
    },
    dataset::{BakeParts, BakeSettings, IndirectSettings},
    ray::OPEN,
};

fn box_over_floor(settings: BakeSettings) -> Dataset {
    let mut triangles = floor(2.0, 0.0).to_vec();
    triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
    baked(&triangles, settings)
}

fn baked(triangles: &[[Vec3; 3]], settings: BakeSettings) -> Dataset {
    let folder = tempfile::tempdir().unwrap();
    let job = BakeJob::new(resolve(settings).unwrap(), folder.path().join("a.cuts"));
    bake(scene_of(triangles), &job, &Silent).unwrap()
}

#[test]
fn vertices_are_traced_as_the_bake_did() {
    let settings = BakeSettings { lights: 256, max_vertices: Some(300), ..Preset::Draft.settings() };
    let dataset = box_over_floor(settings);
    let intersector = Intersector::new(&dataset.scene.mesh);
    let sampler = crate::VertexSampler::new(&dataset, &intersector);
    let mut selector = CutSelector::new(8, dataset.settings.criterion);
    let mut selected = |vertex: u32| {
        let (mut visible, mut cut) = (vec![0; 256], Vec::new());
        sampler.sample(vertex, &mut visible);
        selector.select(&visible, &mut cut);
        cut
    };
    let vertices = dataset.scene.mesh.positions.len() as u32;
    assert!((0..vertices).all(|vertex| selected(vertex) == dataset.cuts.cut(8, vertex)));
    assert!((1..vertices).any(|vertex| selected(vertex - 1) != dataset.cuts.cut(8, vertex)), "negative control");
}

#[test]
fn a_fresh_bake_passes_and_a_swapped_cut_does_not() {
    let settings = BakeSettings { lights: 256, max_vertices: Some(300), ..Preset::Draft.settings() };
    let mut dataset = box_over_floor(settings);
    let all = dataset.scene.mesh.positions.len();
    let good = verify(&dataset, all);
    assert!(good.passed, "{good:?}");
    assert!((good.environment.rms_visibility - good.environment.expected_rms).abs() < 0.02, "{good:?}");
    let mut offsets = dataset.cuts.offsets().to_vec();
    offsets.rotate_left(all / 2);
    dataset.cuts = PackedCuts::from_parts(8, dataset.cuts.nodes().to_vec(), offsets).unwrap();
    let bad = verify(&dataset, all);
    assert!(!bad.passed && bad.environment.rms_visibility > 1.7 * good.environment.rms_visibility, "{bad:?}");
    dataset.report.on_device = true;
    assert!(!verify(&dataset, all).passed, "a device is no excuse");
    assert!(!verify(&dataset, 0).passed, "nothing was checked");
}

#[test]
fn a_ray_along_an_edge_may_fall_to_the_other_side_on_a_device_alone() {
    let criterion = CutCriterion { sigma: 0.0, ..Default::default() };
    let settings = BakeSettings { lights: 256, criterion, exhaustive: true, ..Preset::Draft.settings() };
    let mut dataset = box_over_floor(BakeSettings { max_vertices: Some(300), ..settings });
    let all = dataset.scene.mesh.positions.len();
    // One light of one vertex is wrongly visible or blocked: less than one ray in 10,000 of all.
    let mut cuts = PackedCuts::default();
    for vertex in 0..all as u32 {
        let mut leaves: Vec<u8> = Vec::new();
        for &node in dataset.cuts.cut(8, vertex) {
            leaves.extend(std::iter::repeat_n(OPEN * u8::from(value(node) > 0.5), 256 >> depth(node)));
        }
        leaves[100] ^= OPEN * u8::from(vertex == 7);
        let mut cut = Vec::new();
        CutSelector::new(8, criterion).select(&leaves, &mut cut);
        let offset = cuts.push_cut(&cut);
        cuts.push_vertex(offset);
    }
    dataset.cuts = cuts;
    let bad = verify(&dataset, all);
    assert!(!bad.passed && bad.environment.different_cuts == 1, "{bad:?}");
    dataset.report.on_device = true;
    assert!(verify(&dataset, all).passed);
}

#[test]
fn what_boundaries_tell_is_made_again_and_its_error_told() {
    let settings = BakeSettings { lights: 2048, max_vertices: Some(300), ..Preset::Draft.settings() };
    let mut dataset = box_over_floor(settings);
    let all = dataset.scene.mesh.positions.len();
    let good = verify(&dataset, all);
    let mut audit = dataset.report.audit.unwrap();
    assert!(audit.leaves_per_probe > 1 && good.passed && good.environment.different_cuts == 0, "{good:?}");
    assert!(
        good.environment.leaves_wrong < 1e-3
            && good.environment.rms_visibility <= 1.02 * good.environment.exhaustive_rms,
        "{good:?}"
    );
    // Probes so far apart that shadows are missed: the cuts differ.
    audit.leaves_per_probe = 512;
    dataset.report.audit = Some(audit);
    let bad = verify(&dataset, all);
    assert!(
        !bad.passed
            && bad.environment.different_cuts > 0
            && bad.environment.leaves_wrong > good.environment.leaves_wrong,
        "{bad:?}"
    );
}

#[test]
fn what_boundaries_tell_of_sources_is_made_again_and_its_error_told() {
    let indirect = IndirectSettings { sources: 4096, ..Default::default() };
    let settings = BakeSettings { mode: BakeParts::INDIRECT, indirect, lights: 256, ..Preset::Draft.settings() };
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.2, -0.5, 0.1), Vec3::splat(0.3)));
    let mut dataset = baked(&triangles, BakeSettings { max_vertices: Some(300), pilot_clusters: 16, ..settings });
    let good = verify(&dataset, 64);
    assert!(good.passed && good.sources.source_vertices > 0 && good.sources.different_source_cuts == 0, "{good:?}");
    assert!(
        good.sources.sources_wrong < 5e-3 && good.sources.source_error <= 1.02 * good.sources.exhaustive_source_error,
        "{good:?}"
    );
    // Probes so far apart that shadows are missed: the cuts differ.
    let audit = dataset.report.indirect.as_mut().unwrap().audit.as_mut().unwrap();
    assert!(audit.leaves_per_probe > 1);
    audit.leaves_per_probe = 1024;
    let bad = verify(&dataset, 64);
    assert!(
        !bad.passed && bad.sources.different_source_cuts > 0 && bad.sources.sources_wrong > good.sources.sources_wrong,
        "{bad:?}"
    );
}

#[test]
fn source_cuts_that_were_coarsened_to_fit_agree() {
    let criterion = SourceCriterion { sigma: 0.25, contrast: 0.05, ..Default::default() };
    let indirect = IndirectSettings { sources: 256, criterion, ..Default::default() };
    let settings = BakeSettings { mode: BakeParts::INDIRECT, indirect, lights: 256, ..Preset::Draft.settings() };
    let mut dataset = box_over_floor(BakeSettings { max_vertices: None, pilot_clusters: 16, ..settings });
    let coarser = dataset.settings.indirect.criterion.coarser(8.0);
    let baked = dataset.indirect.as_mut().unwrap();
    let mut coarsened = PackedCuts::default();
    for vertex in 0..dataset.scene.mesh.positions.len() as u32 {
        let offset = coarsened.push_cut(&prune_sources(8, coarser, baked.cuts.cut(8, vertex)));
        coarsened.push_vertex(offset);
    }
    assert!(coarsened.nodes().len() < baked.cuts.nodes().len());
    baked.cuts = coarsened;
    assert!(!verify(&dataset, 64).passed, "negative control: nothing says that they were");
    dataset.report.indirect.as_mut().unwrap().coarsened = Some(8.0);
    let good = verify(&dataset, 64);
    assert!(good.passed && good.sources.source_vertices > 0, "{good:?}");
}

#[test]
fn what_sources_see_of_the_environment_is_traced_again() {
    let indirect = IndirectSettings { sources: 256, ..Default::default() };
    let settings = BakeSettings { mode: BakeParts::CUTS, indirect, lights: 256, ..Preset::Draft.settings() };
    let mut dataset = box_over_floor(BakeSettings { max_vertices: None, pilot_clusters: 16, ..settings });
    let good = verify(&dataset, 64);
    assert!(good.passed && good.sources.sources == 64, "{good:?}");
    let indirect = dataset.indirect.as_mut().unwrap();
    let mut offsets = indirect.environment_cuts.offsets().to_vec();
    offsets.rotate_left(1);
    let nodes = indirect.environment_cuts.nodes().to_vec();
    indirect.environment_cuts = PackedCuts::from_parts(8, nodes, offsets).unwrap();
    let bad = verify(&dataset, 64);
    assert!(
        !bad.passed && bad.sources.different_source_environment_cuts > 8 && bad.environment.different_cuts == 0,
        "{bad:?}"
    );
}
