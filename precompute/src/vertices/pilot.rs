//! Pilot visibility (paper, 3.4): clusters of bake points, and the fraction of each cluster that sees each light.
//!
//! The paper traces every vertex twice. Here a few members represent each cluster. On the armadillo scene 4 and 8 of
//! some 57 members both gave a mean cut of 160 to 162 nodes (the geometric tree: 216 to 220), so tracing all of them is
//! not worth seven times the rays.

use crate::{
    errors::BakeError,
    observer::{Event, Observer},
    vertices::{
        points::{BakePoint, BakePoints},
        visibility::VisibilitySampler,
    },
};
use glam::Vec3;
use lapidary_core::{
    light_tree::{Features, PilotVisibility, cluster_order},
    ray::BoundaryTracer,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Weight of position against normal in the metric of the clusters (Eq. 10; Hašan et al. 2006).
const K: f32 = 30.0;
/// Points of a cluster whose visibility is averaged.
const MEMBERS: usize = 8;

/// Clusters the points by position and normal and samples each cluster's visibility of the sampler's directions.
pub fn sample_pilot(
    points: &BakePoints,
    sampler: &VisibilitySampler,
    diagonal: f32,
    clusters: usize,
    observer: &dyn Observer,
) -> Result<PilotVisibility, BakeError> {
    let sample = |point: &BakePoint, tracer: &mut BoundaryTracer, visible: &mut [u8]| {
        sampler.sample(point, tracer, visible);
    };
    pilot_of(points, diagonal, sampler.len(), clusters, observer, sample)
}

/// Clusters the points and samples each cluster's visibility of `lights` by `sample`, which sets 0 or 1 for each and has
/// buffers that are kept.
pub fn pilot_of<S: Default>(
    points: &BakePoints,
    diagonal: f32,
    lights: usize,
    clusters: usize,
    observer: &dyn Observer,
    sample: impl Fn(&BakePoint, &mut S, &mut [u8]) + Sync,
) -> Result<PilotVisibility, BakeError> {
    let order = cluster_order(&point_features(&points.points, diagonal));
    let clusters = clusters.min(order.len());
    let done = AtomicU64::new(0);
    let row = |scratch: &mut S, cluster: usize| {
        if observer.cancelled() {
            return Err(BakeError::Cancelled);
        }
        let members = &order[cluster * order.len() / clusters..(cluster + 1) * order.len() / clusters];
        let row = cluster_visibility(|point, visible| sample(point, scratch, visible), &points.points, members, lights);
        observer.event(Event::Advanced { done: done.fetch_add(1, Ordering::Relaxed) + 1 });
        Ok(row)
    };
    let rows = (0..clusters).into_par_iter().map_init(S::default, row).collect::<Result<Vec<_>, _>>()?;
    Ok(PilotVisibility { lights, fractions: rows.concat() })
}

fn point_features(points: &[BakePoint], diagonal: f32) -> Features {
    let scale = K / diagonal.max(f32::MIN_POSITIVE);
    let features = |p: &BakePoint| -> [f32; 6] {
        let (x, n): (Vec3, Vec3) = (p.position * scale, p.normal);
        [x.x, x.y, x.z, n.x, n.y, n.z]
    };
    Features::new(6, points.iter().flat_map(features).collect())
}

fn cluster_visibility(
    mut sample: impl FnMut(&BakePoint, &mut [u8]),
    points: &[BakePoint],
    members: &[u32],
    lights: usize,
) -> Vec<u8> {
    let count = members.len().min(MEMBERS);
    let (mut visible, mut sums) = (vec![0_u8; lights], vec![0_u16; lights]);
    for i in 0..count {
        let member = members[(2 * i + 1) * members.len() / (2 * count)];
        sample(&points[member as usize], &mut visible);
        sums.iter_mut().zip(&visible).for_each(|(s, &v)| *s += u16::from(v));
    }
    sums.iter().map(|&s| (u32::from(s) * 255 / count as u32) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertices::visibility::EXHAUSTIVE;
    use crate::{
        observer::Silent,
        test_scenes::{cuboid, floor, scene_of},
        vertices::sidedness::classify,
    };
    use lapidary_core::{ray::Intersector, sphere::fibonacci_directions};

    #[test]
    fn clusters_hold_points_that_see_alike() {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 1.5, 0.0), Vec3::splat(0.5)));
        let scene = scene_of(&triangles);
        let points = BakePoints::new(&scene.mesh, &classify(&scene));
        let intersector = Intersector::new(&scene.mesh);
        let sampler = VisibilitySampler::of_directions(&intersector, &fibonacci_directions(256), EXHAUSTIVE);
        let pilot = sample_pilot(&points, &sampler, 4.0, 4, &Silent).unwrap();
        assert_eq!((pilot.clusters(), pilot.fractions.len()), (4, 1024));
        // Every cluster sees something and none sees everything; the floor's light comes from above.
        for row in pilot.fractions.chunks(256) {
            assert!(row.iter().any(|&f| f > 0) && row.contains(&0));
        }
        let more = sample_pilot(&points, &sampler, 4.0, 9999, &Silent).unwrap();
        assert_eq!(more.clusters(), points.points.len(), "never more clusters than points");
    }
}
