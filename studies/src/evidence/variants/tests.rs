use super::*;
use lapidary_core::{
    dataset::Dataset,
    ray::OPEN,
    test_scenes::{cuboid, floor, scene_of},
};
use lapidary_precompute::{BakeJob, Silent, bake, resolve};

fn scene() -> Scene {
    let mut triangles = floor(2.0, 0.0).to_vec();
    triangles.extend(cuboid(Vec3::new(0.3, 0.6, 0.2), Vec3::splat(0.25)));
    scene_of(&triangles)
}

fn variant(tree: TreeKind, sigma: f32) -> Variant {
    Variant { tree, beta: 0.5, criterion: CutCriterion { sigma, ..Default::default() } }
}

#[test]
fn each_variant_is_the_bake_with_its_settings() {
    let variants = [variant(TreeKind::Mixed, 1.0), variant(TreeKind::Geometric, 1.0), variant(TreeKind::Mixed, 3.0)];
    let baker = VariantBaker::new(scene(), Some(300), &Silent).unwrap();
    let all = baker.some_points(usize::MAX);
    let made = baker.bake(512, 16, &variants, &all, &Silent).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (dataset, variant) in made.iter().zip(variants) {
        let job = BakeJob::new(resolve(dataset.settings.clone()).unwrap(), folder.path().join("a.cuts"));
        let baked = bake(scene(), &job, &Silent).unwrap();
        assert_eq!(dataset.cuts, baked.cuts, "{variant:?}");
        assert_eq!((&dataset.tree, &dataset.scene_hash), (&baked.tree, &baked.scene_hash));
        let (a, b) = (&dataset.report, &baked.report);
        assert_eq!((a.mean_cut, a.rms_visibility, a.bytes_cuts), (b.mean_cut, b.rms_visibility, b.bytes_cuts));
        assert_eq!((a.bake_points, a.rays_traced, a.sigma), (b.bake_points, b.rays_traced, b.sigma));
    }
    assert_ne!(made[0].cuts, made[1].cuts, "negative control: another tree");
    assert_ne!(made[0].cuts, made[2].cuts, "negative control: another bound");
}

#[test]
fn points_that_are_left_out_see_nothing_and_do_not_count() {
    let baker = VariantBaker::new(scene(), Some(300), &Silent).unwrap();
    let all = baker.some_points(usize::MAX);
    let some = baker.points_of([0, 1, 2, 1]);
    assert!(!some.is_empty() && some.len() <= 3);
    let bake = |points: &[u32]| baker.bake(256, 8, &[variant(TreeKind::Geometric, 1.0)], points, &Silent).unwrap();
    let (whole, part) = (&bake(&all)[0], &bake(&some)[0]);
    let cut = |dataset: &Dataset, vertex| dataset.cuts.cut(8, vertex).to_vec();
    assert_eq!(cut(whole, 1), cut(part, 1));
    let other = (0..part.cuts.len() as u32).find(|&v| baker.points_of([v]).iter().all(|p| !some.contains(p)));
    assert_eq!(cut(part, other.unwrap()), [0]);
    assert_ne!(cut(whole, other.unwrap()), [0], "negative control");
    let lengths = some.iter().map(|p| {
        let vertex = (0..whole.cuts.len() as u32).find(|&v| baker.points_of([v]) == [*p]).unwrap();
        cut(whole, vertex).len() as f64
    });
    assert!((part.report.mean_cut - lengths.sum::<f64>() / some.len() as f64).abs() < 1e-9);
    assert_eq!(baker.some_points(10).len(), 10);
}

#[test]
fn visibility_and_pilot_take_any_directions() {
    let baker = VariantBaker::new(scene(), None, &Silent).unwrap();
    let directions = [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.8, 0.0)];
    let all = baker.some_points(usize::MAX);
    let seen = baker.visibility(&directions, &all, &Silent, <[u8]>::to_vec).unwrap();
    assert_eq!(seen.len(), baker.geometry.bake_points());
    assert!(seen.iter().any(|v| v[0] == OPEN) && seen.iter().any(|v| v[0] == 0));
    let pilot = baker.geometry.pilot(&directions, 4, &Silent).unwrap();
    assert_eq!((pilot.lights, pilot.clusters()), (3, 4));
}
