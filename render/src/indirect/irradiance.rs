//! Irradiance of surface sources: by local lights through shadow rays, by the environment through cuts.

use crate::lighting::SceneLighting;
use glam::{Vec2, Vec3};
use lapidary_core::{
    cut::{merge::merge, packed::PackedCursor},
    indirect::{IndirectBake, Source},
    lights::Light,
    ray::Intersector,
    source_tree::SourceTree,
};
use rayon::prelude::*;

/// Samples along each side of an area light, in the middles of equal parts: neighbouring sources average what is left.
const AREA_SAMPLES: u32 = 3;

/// Fraction of the distance to a light where nothing hides it any more.
const NEAR_THE_LIGHT: f32 = 1e-3;

/// What `lights` give each source; shadow rays start `offset` metres off its surface.
pub fn light_irradiance(tree: &SourceTree, lights: &[Light], intersector: &Intersector, offset: f32) -> Vec<Vec3> {
    let patterns: Vec<(&Light, Vec<Vec2>)> = lights.iter().map(|light| (light, pattern(light))).collect();
    let of_source = |source: &Source| {
        let received = |(light, pattern): &(&Light, Vec<Vec2>)| {
            let samples = pattern.iter().map(|&u| light_sample(source, light, u, intersector, offset));
            samples.sum::<Vec3>() / pattern.len() as f32
        };
        patterns.iter().map(received).sum()
    };
    tree.sources().par_iter().with_min_len(64).map(of_source).collect()
}

fn pattern(light: &Light) -> Vec<Vec2> {
    let side = if light.is_delta() { 1 } else { AREA_SAMPLES };
    let middle = |i: u32| (i as f32 + 0.5) / side as f32;
    (0..side * side).map(|i| Vec2::new(middle(i % side), middle(i / side))).collect()
}

fn light_sample(source: &Source, light: &Light, u: Vec2, intersector: &Intersector, offset: f32) -> Vec3 {
    let (position, normal) = (source.surfel.position, source.surfel.normal);
    let Some(sample) = light.sample(position, u) else { return Vec3::ZERO };
    let received = sample.irradiance * normal.dot(sample.direction).max(0.0);
    if !(received.max_element() > 0.0) {
        return Vec3::ZERO;
    }
    let origin = position + normal * offset;
    // A light may lie on a surface, which does not hide it.
    let blocked = intersector.occluded_before(origin, sample.direction, (1.0 - NEAR_THE_LIGHT) * sample.distance);
    if blocked { Vec3::ZERO } else { received }
}

/// What the environment gives each source: its cut merged with the illumination cut, times the cosine. `None` if sources
/// have no cuts of it.
pub fn environment_irradiance(bake: &IndirectBake, lighting: &SceneLighting) -> Option<Vec<Vec3>> {
    if bake.environment_cuts.len() != bake.sources.len() {
        return None;
    }
    let height = (lighting.nodes.radiance.len() / 2).ilog2();
    let of_source = |(i, source): (usize, &Source)| {
        let nodes = bake.environment_cuts.nodes_from(i as u32);
        let mut cursors = [PackedCursor::new(height, nodes), PackedCursor::new(height, &lighting.cut)];
        let (mut sum, normal) = (Vec3::ZERO, source.surfel.normal);
        merge(1 << height, &mut cursors, |interval, cursors| {
            let visibility = cursors[0].value();
            if visibility > 0.0 {
                let node = interval.heap_index(1 << height) as usize;
                let cos = lighting.nodes.direction[node].dot(normal).max(0.0);
                sum += lighting.nodes.radiance[node] * (cos * visibility * interval.size() as f32);
            }
        });
        sum * lighting.leaf_solid_angle
    };
    Some(bake.sources.par_iter().enumerate().with_min_len(64).map(of_source).collect())
}
