//! Solid angles in rooms with known form factors.

use super::*;
use crate::{
    observer::Silent,
    sources::{order::order_sources, placement::place_sources},
    test_scenes::{Prepared, cuboid, room},
    vertices::points::BakePoints,
};
use lapidary_core::{dataset::BakeSettings, light_tree::TreeKind};
use std::f32::consts::PI;

const COUNT: usize = 2048;

fn sources_of(prepared: &Prepared) -> Vec<Source> {
    place_sources(&prepared.surface(), Vec3::new(0.1, 0.7, 0.15), COUNT, &[], &Silent).unwrap()
}

/// Sources in tree order, so that neighbors are consecutive.
fn ordered_sources_of(prepared: &Prepared) -> Vec<Source> {
    let settings = BakeSettings { tree: TreeKind::Geometric, ..BakeSettings::default() };
    let points = BakePoints::new(&prepared.scene.mesh, &prepared.sides);
    let (sources, surface) = (sources_of(prepared), prepared.surface());
    order_sources(sources, &points, &prepared.intersector, &surface, &settings, &Silent).unwrap()
}

/// A point of the floor of a room from -1 to 1.
fn floor_point(x: f32, z: f32) -> BakePoint {
    point_at(Vec3::new(x, -1.0, z))
}

fn point_at(position: Vec3) -> BakePoint {
    BakePoint { position, normal: Vec3::Y, offset: 1e-4, horizon: 0.0, two_sided: false, places: [position; 2] }
}

fn sample(prepared: &Prepared, sources: &[Source], point: &BakePoint) -> Vec<f32> {
    let sampler = SourceSampler::new(&prepared.intersector, sources, 1e-4, EXHAUSTIVE);
    let mut seen = vec![0.0; sources.len()];
    sampler.sample(point, &mut SourceScratch::default(), &mut seen);
    seen
}

#[test]
fn a_closed_room_fills_the_hemisphere_over_any_wall() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let sources = sources_of(&prepared);
    for (x, z) in [(0.0, 0.0), (0.4, -0.6), (0.8, 0.8), (0.998, -0.999)] {
        let seen = sample(&prepared, &sources, &floor_point(x, z));
        let total: f32 = seen.iter().sum();
        // In the corner rays count by their cosine.
        assert!((total / (2.0 * PI) - 1.0).abs() < 0.04 || x > 0.9, "{total} sr at {x}, {z}");
        // With the receiver's cosine the integral is a white furnace's.
        let weighted: f32 = seen
            .iter()
            .zip(&sources)
            .map(|(angle, s)| angle * (s.surfel.position - Vec3::new(x, -1.0, z)).normalize_or_zero().y.max(0.0))
            .sum();
        let tolerance = if x > 0.9 { 0.08 } else { 0.03 };
        assert!((weighted / PI - 1.0).abs() < tolerance, "{weighted} at {x}, {z}");
    }
    let left: Vec<Source> = sources.iter().filter(|s| s.surfel.position.x < 0.0).copied().collect();
    let half: f32 = sample(&prepared, &left, &floor_point(0.0, 0.0)).iter().sum();
    assert!(half < 0.7 * 2.0 * PI, "negative control");
}

#[test]
fn a_vertex_takes_no_light_from_faces_that_lean_far_from_its_normal() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let sources = sources_of(&prepared);
    let normal = Vec3::new(0.0, 0.2, -1.0).normalize();
    let floor = |horizon: f32| {
        let point = BakePoint { normal, horizon, offset: 1e-3, ..point_at(Vec3::new(0.1, -0.999, 0.2)) };
        let seen = sample(&prepared, &sources, &point);
        seen.iter().zip(&sources).filter(|(_, s)| s.surfel.normal.y > 0.5).map(|(angle, _)| angle).sum::<f32>()
    };
    let (taken, without) = (floor(-normal.cross(Vec3::Y).length()), floor(0.0));
    assert!(taken < 0.01, "{taken} sr, more than from so far above it");
    assert!(without > 0.5, "{without} sr, negative control: a horizon that leaves the floor out");
}

#[test]
fn opposite_walls_have_their_form_factor() {
    // Two opposite squares of a cube: 0.1998 (Howell's catalog, C-11).
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let sources = sources_of(&prepared);
    let (mut sum, side) = (0.0, 8);
    for i in 0..side * side {
        let at = |i: usize| (i as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        let point = floor_point(at(i % side), at(i / side));
        let seen = sample(&prepared, &sources, &point);
        for (angle, s) in seen.iter().zip(&sources).filter(|(_, s)| s.surfel.normal.y < -0.5) {
            sum += angle * (s.surfel.position - point.position).normalize().y / PI;
        }
    }
    let form_factor = sum / (side * side) as f32;
    assert!((form_factor - 0.1998).abs() < 0.004, "{form_factor}");
}

#[test]
fn hidden_sources_count_for_nothing_and_two_sided_points_see_both_sides() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::ZERO, Vec3::new(0.9, 0.05, 0.9)));
    let prepared = Prepared::new(&triangles);
    let sources = sources_of(&prepared);
    let seen = sample(&prepared, &sources, &floor_point(0.0, 0.0));
    let to_ceiling =
        |s: &Source| s.surfel.position.y > 0.999 && s.surfel.position.abs().with_y(0.0).max_element() < 0.7;
    assert!(sources.iter().any(to_ceiling));
    assert!(seen.iter().zip(&sources).all(|(&angle, s)| !to_ceiling(s) || angle == 0.0));
    let middle = BakePoint { two_sided: true, ..point_at(Vec3::new(0.95, 0.0, 0.0)) };
    let both: f32 = sample(&prepared, &sources, &middle).iter().sum();
    let above: f32 = sample(&prepared, &sources, &BakePoint { two_sided: false, ..middle }).iter().sum();
    assert!(both > 1.8 * above && above > 0.0, "{both} and {above}");
}

#[test]
fn batches_equal_single_segments() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.2, -0.5, 0.1), Vec3::splat(0.3)));
    let prepared = Prepared::new(&triangles);
    let sources = sources_of(&prepared);
    let sampler = SourceSampler::new(&prepared.intersector, &sources, 1e-4, EXHAUSTIVE);
    for point in [floor_point(0.7, 0.2), floor_point(-0.5, -0.9), floor_point(0.6, 0.1)] {
        let batch = sample(&prepared, &sources, &point);
        let mut single = vec![0.0; COUNT];
        sampler.sample_singly(&point, &mut single);
        assert_eq!(batch, single);
        assert!(batch.contains(&0.0) && batch.iter().any(|&angle| angle > 0.0));
    }
}

#[test]
fn boundaries_between_sources_are_hardly_ever_wrong() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.2, -0.5, 0.1), Vec3::splat(0.3)));
    let prepared = Prepared::new(&triangles);
    let sources = ordered_sources_of(&prepared);
    let points = [floor_point(0.7, 0.2), floor_point(-0.5, -0.9), floor_point(0.6, 0.1)];
    let compared = |sources_per_probe| {
        let sampler = SourceSampler::new(&prepared.intersector, &sources, 1e-4, sources_per_probe);
        let (mut wrong, mut rays) = (0, 0);
        for point in &points {
            let [mut seen, mut single, mut again] = [0; 3].map(|_| vec![0.0; COUNT]);
            rays += sampler.sample(point, &mut SourceScratch::default(), &mut seen);
            sampler.sample_singly(point, &mut single);
            sampler.sample_again(point, &mut again);
            assert_eq!(again, seen);
            wrong += seen.iter().zip(&single).filter(|(a, b)| a != b).count();
        }
        (wrong, rays)
    };
    let (wrong, rays) = compared(16);
    let (none, all) = compared(EXHAUSTIVE);
    assert!(wrong <= 3 * COUNT / 200 && none == 0, "{wrong} wrong");
    assert!(rays + 3 * COUNT as u64 / 4 < all, "{rays} of {all} rays, of which some are near the point");
    assert!(compared(1024).0 > 100, "negative control: probes that lie too far apart");
}

#[test]
fn sources_are_dimmed_by_panes_on_the_way() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let sources = sources_of(&prepared);
    let triangles = [room(Vec3::ZERO, Vec3::ONE), crate::test_scenes::floor(0.99, 0.2).to_vec()].concat();
    let mut scene = crate::test_scenes::scene_of(&triangles);
    let panes = scene.mesh.triangles.len() - 2;
    scene.mesh.triangle_material[panes..].fill(1);
    scene.materials.push(scene.materials[0].clone());
    let mut seen_by = |opacity: f32, sources_per_probe: usize| {
        scene.materials[1].parameters.set("geometry_opacity", opacity);
        let intersector = Intersector::of_scene(&scene);
        let sampler = SourceSampler::new(&intersector, &sources, 1e-4, sources_per_probe);
        let [mut seen, mut singly] = [(); 2].map(|()| vec![0.0; sources.len()]);
        let point = floor_point(0.1, -0.2);
        sampler.sample(&point, &mut SourceScratch::default(), &mut seen);
        sampler.sample_singly(&point, &mut singly);
        assert!(sources_per_probe != EXHAUSTIVE || seen == singly);
        let ceiling = seen.iter().zip(&sources).filter(|(_, s)| s.surfel.position.y > 0.999);
        ceiling.map(|(angle, _)| angle).sum::<f32>()
    };
    let open = seen_by(0.0, EXHAUSTIVE);
    for sources_per_probe in [EXHAUSTIVE, 16] {
        let dimmed = seen_by(0.25, sources_per_probe);
        assert!((dimmed / open - 0.75).abs() < 0.01, "{dimmed} of {open}");
    }
    assert!(seen_by(1.0, EXHAUSTIVE) < 0.05 * open, "negative control: a pane that stops all light");
}
