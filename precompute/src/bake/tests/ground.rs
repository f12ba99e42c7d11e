//! Bakes of a single object on a ground.

use super::{job, settings, with};
use crate::{
    bake,
    errors::BakeError,
    observer::Silent,
    test_scenes::{cuboid, scene_of},
};
use glam::Vec3;
use lapidary_core::{
    cut::packed::{depth, value},
    dataset::{BakeParts, Dataset, scene_hash},
    ground::Ground,
    scene::Scene,
};

/// A cube of half a meter that stands at the origin.
fn cube() -> Scene {
    scene_of(&cuboid(Vec3::new(0.0, 0.25, 0.0), Vec3::splat(0.25)))
}

fn baked(ground: Ground, mode: BakeParts) -> Result<Dataset, BakeError> {
    let folder = tempfile::tempdir().unwrap();
    let job = with(job(folder.path(), "cube.cuts"), |s| (s.ground, s.mode, s.indirect.sources) = (ground, mode, 256));
    bake(cube(), &job, &Silent)
}

/// Share of all directions visible from a vertex.
fn seen(dataset: &Dataset, vertex: u32) -> f32 {
    let height = dataset.tree.height();
    let share = |&node: &u16| (0.5_f32).powi(depth(node) as i32) * value(node);
    dataset.cuts.cut(height, vertex).iter().map(share).sum()
}

/// Vertices whose position and normal satisfy `holds`.
fn vertices(dataset: &Dataset, holds: impl Fn(Vec3, Vec3) -> bool) -> Vec<u32> {
    let mesh = &dataset.scene.mesh;
    let is_wanted = |&v: &u32| holds(mesh.positions[v as usize], mesh.normals[v as usize]);
    (0..mesh.positions.len() as u32).filter(is_wanted).collect()
}

#[test]
fn a_ground_blocks_the_light_from_below_and_receives_that_from_above() {
    let [with, without] = [Ground::Shadow, Ground::Off].map(|ground| baked(ground, BakeParts::ENVIRONMENT).unwrap());
    assert_eq!(with.scene_hash, scene_hash(&cube()), "the same scene as without");
    let mean = |dataset: &Dataset, of: &[u32]| of.iter().map(|&v| seen(dataset, v)).sum::<f32>() / of.len() as f32;
    let sides = |dataset: &Dataset| vertices(dataset, |p, n| n.y.abs() < 0.1 && p.y < 0.3);
    let (above, hovering) = (mean(&with, &sides(&with)), mean(&without, &sides(&without)));
    assert!((above - 0.25).abs() < 0.02, "half of a side's hemisphere is above the ground: {above}");
    assert!((hovering - 0.5).abs() < 0.02, "negative control: {hovering}");
    let ground = |range: std::ops::Range<f32>| {
        vertices(&with, |p, _| p.y < 0.0 && range.contains(&p.with_y(0.0).length()) && p.x.abs().max(p.z.abs()) > 0.26)
    };
    let far = mean(&with, &ground(20.0..f32::INFINITY));
    assert!((far - 0.5).abs() < 0.01, "the ground is open far away: {far}");
    let near = mean(&with, &ground(0.0..0.5));
    assert!(near < 0.47, "the cube hides a part of the sky near it: {near}");
}

#[test]
fn a_ground_takes_at_most_a_fifth_more_vertices() {
    let dataset = baked(Ground::On, BakeParts::ENVIRONMENT).unwrap();
    let (all, most) = (dataset.scene.mesh.positions.len(), settings().max_vertices.unwrap());
    let of_scene = dataset.scene.mesh.ground.unwrap().vertex as usize;
    assert!(of_scene <= most && all - of_scene <= most / 5, "{of_scene} and {} of {most}", all - of_scene);
    assert!(all - of_scene > most / 10, "and uses them: {}", all - of_scene);
    assert_eq!(dataset.report.source_vertices, cube().mesh.positions.len());
}

#[test]
fn near_ground_reflects_light_and_far_ground_takes_no_sources() {
    let dataset = baked(Ground::Shadow, BakeParts::CUTS).unwrap();
    let (mesh, bounds) = (&dataset.scene.mesh, dataset.scene.mesh.bounds());
    let sources = &dataset.indirect.as_ref().unwrap().sources;
    let on_ground: Vec<_> = sources.iter().filter(|s| mesh.is_ground(s.surfel.place.triangle)).collect();
    assert!(on_ground.len() > sources.len() / 4, "{} of {}", on_ground.len(), sources.len());
    assert!(on_ground.iter().all(|s| !mesh.is_far_ground(s.surfel.place.triangle, bounds)));
    let farthest = on_ground.iter().map(|s| s.surfel.position.length()).fold(0.0, f32::max);
    assert!(farthest > bounds.diagonal(), "{farthest}");
}
