//! Irradiance of surface points: from local lights by shadow rays, from the environment by cuts.

use crate::light::environment::SceneLighting;
use glam::{Vec2, Vec3};
use lapidary_core::{
    cut::{merge::merge, packed::PackedCursor},
    dataset::Dataset,
    lights::{Light, LightSample, LightSampler},
    offset,
    ray::{EightRays, Intersector},
    sources::Source,
    surfel::Surfel,
};
use rayon::prelude::*;
use std::array::from_fn;

/// How shadow rays are cast.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRays {
    /// Samples along each side of an area light; averages over neighboring points reduce their error.
    pub area_samples: u32,
    /// Distance in meters of ray origins from the surface.
    pub offset: f32,
}

/// Irradiance of each point from `lights`, by one normal per point. Points that are close together in `order` trace their rays
/// through the same boxes.
pub fn light_irradiance(
    points: &[Surfel],
    normals: &[Vec3],
    order: &[u32],
    lights: &[Light],
    (intersector, rays): (&Intersector, ShadowRays),
) -> Vec<Vec3> {
    let patterns: Vec<(LightSampler, Vec<Vec2>)> =
        lights.iter().map(|light| (light.sampler(), pattern(light, rays.area_samples))).collect();
    let of_eight = |eight: &[u32]| {
        let eight: Vec<(&Surfel, Vec3)> = eight.iter().map(|&i| (&points[i as usize], normals[i as usize])).collect();
        let mut sums = [Vec3::ZERO; 8];
        for (light, pattern) in &patterns {
            let mut received = [Vec3::ZERO; 8];
            for &u in pattern {
                let of_sample = light_sample(&eight, light, u, intersector, rays.offset);
                received.iter_mut().zip(of_sample).for_each(|(received, of_sample)| *received += of_sample);
            }
            sums.iter_mut().zip(received).for_each(|(sum, received)| *sum += received / pattern.len() as f32);
        }
        sums
    };
    let eights: Vec<[Vec3; 8]> = order.par_chunks(8).with_min_len(8).map(of_eight).collect();
    let mut irradiance = vec![Vec3::ZERO; points.len()];
    order.iter().zip(eights.as_flattened()).for_each(|(&i, &received)| irradiance[i as usize] = received);
    irradiance
}

fn pattern(light: &Light, area_samples: u32) -> Vec<Vec2> {
    let side = if light.is_delta() { 1 } else { area_samples };
    // Centers of equal parts, moved apart so that they have the variance of the whole side.
    let apart = 1.0 / (1.0 - 1.0 / (side * side).max(2) as f32).sqrt();
    let middle = |i: u32| 0.5 + ((i as f32 + 0.5) / side as f32 - 0.5) * apart;
    (0..side * side).map(|i| Vec2::new(middle(i % side), middle(i / side))).collect()
}

/// Light of one light sample at up to eight points with their normals.
fn light_sample(
    points: &[(&Surfel, Vec3)],
    light: &LightSampler,
    u: Vec2,
    intersector: &Intersector,
    offset: f32,
) -> [Vec3; 8] {
    let sent: [Option<(Vec3, LightSample, Vec3)>; 8] = from_fn(|i| {
        let (point, normal) = points.get(i)?;
        let sample = light.sample(point.position, u)?;
        let received = sample.irradiance * normal.dot(sample.direction).max(0.0);
        (received.max_element() > 0.0).then_some((point.position + point.normal * offset, sample, received))
    });
    let active = (0..8).map(|i| u8::from(sent[i].is_some()) << i).sum();
    let origins = sent.map(|sent| sent.map_or(Vec3::ZERO, |(origin, ..)| origin));
    let directions = sent.map(|sent| sent.map_or(Vec3::Y, |(_, sample, _)| sample.direction));
    // A light may lie on a surface, which does not block it.
    let reaches = sent.map(|sent| sent.map_or(0.0, |(_, sample, _)| offset::REACH_OF_BOUNCE * sample.distance));
    let passed = intersector.passed_before(&EightRays::new(origins, directions, active), reaches);
    from_fn(|i| sent[i].map_or(Vec3::ZERO, |(.., received)| received * passed[i]))
}

/// Irradiance of each source from the environment: its cut merged with the illumination cut, times the cosine. `None`
/// if sources have no cuts over the environment.
pub fn environment_irradiance(dataset: &Dataset, lighting: &SceneLighting) -> Option<Vec<Vec3>> {
    let (bake, mesh) = (dataset.indirect.as_ref()?, &dataset.scene.mesh);
    if bake.environment_cuts.len() != bake.sources.len() {
        return None;
    }
    let of_source = |(i, source): (usize, &Source)| {
        let visible = [(1.0, bake.environment_cuts.nodes_from(i as u32))];
        received(&visible, mesh.shading_normal(&source.surfel), lighting)
    };
    Some(bake.sources.par_iter().enumerate().with_min_len(64).map(of_source).collect())
}

/// Irradiance of points of a dataset's mesh from the environment, by interpolated cuts of the vertices.
pub fn environment_irradiance_of(points: &[Surfel], dataset: &Dataset, lighting: &SceneLighting) -> Vec<Vec3> {
    let of_point = |point: &Surfel| {
        let mesh = &dataset.scene.mesh;
        let vertices = mesh.triangles[point.place.triangle as usize];
        let weights = dataset.interpolation_weights(vertices, point.place.barycentric);
        let visible: [_; 3] = from_fn(|i| (weights[i], dataset.cuts.nodes_from(vertices[i])));
        received(&visible, mesh.shading_normal(point), lighting)
    };
    points.par_iter().with_min_len(64).map(of_point).collect()
}

/// Irradiance under a weighted sum of visibility cuts.
fn received<const N: usize>(visible: &[(f32, &[u16]); N], normal: Vec3, lighting: &SceneLighting) -> Vec3 {
    let height = lighting.height();
    let mut cursors: Vec<_> = visible.iter().map(|(_, nodes)| PackedCursor::new(height, nodes)).collect();
    cursors.push(PackedCursor::new(height, &lighting.cut));
    let mut sum = Vec3::ZERO;
    merge(1 << height, &mut cursors, |interval, cursors| {
        let visibility: f32 = visible.iter().zip(cursors).map(|((weight, _), cursor)| weight * cursor.value()).sum();
        if visibility > 0.0 {
            let node = interval.heap_index(1 << height) as usize;
            let cos = lighting.nodes.place[node].dot(normal).max(0.0);
            sum += lighting.nodes.radiance[node] * (cos * visibility * interval.size() as f32);
        }
    });
    sum * lighting.lights.leaf_solid_angle
}
