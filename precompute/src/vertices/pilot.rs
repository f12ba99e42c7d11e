//! Pilot visibility (paper, 3.4): clusters of bake points, and the fraction of each cluster that sees each light.
//!
//! The paper traces every vertex twice. Here a few members represent each cluster. On the armadillo scene 4 and 8 of some 57
//! members both gave a mean cut of 160 to 162 nodes (216 to 220 with the geometric tree), so tracing all members is not worth seven
//! times the rays.

use crate::{
    errors::{BakeError, cancelled},
    observer::{Event, Observer},
    vertices::{
        points::{BakePoint, BakePoints},
        tracing::ManySampler,
    },
};
use glam::Vec3;
use lapidary_core::light_tree::{Features, PilotVisibility, cluster_order};

/// Weight of position against normal in the metric of the clusters (Eq. 10; Hašan et al. 2006).
const K: f32 = 30.0;
/// Points of a cluster whose visibility is averaged.
const MEMBERS: usize = 8;
/// Clusters between checks for cancellation.
const CLUSTERS_AT_A_TIME: usize = 32;

/// Clusters the points by position and normal and samples each cluster's visibility of the sampler's directions.
pub fn sample_pilot(
    points: &BakePoints,
    sampler: &ManySampler,
    diagonal: f32,
    clusters: usize,
    observer: &dyn Observer,
) -> Result<PilotVisibility, BakeError> {
    let rows = |points: &[&BakePoint]| Ok(sampler.each(points, || (), |(), visible, _| visible.to_vec()));
    pilot_of(points, diagonal, sampler.len(), clusters, observer, rows)
}

/// Clusters the points and samples each cluster's visibility of `lights`. `rows` returns 0 to 255 for each light at each of some
/// points.
pub fn pilot_of(
    points: &BakePoints,
    diagonal: f32,
    lights: usize,
    clusters: usize,
    observer: &dyn Observer,
    rows: impl Fn(&[&BakePoint]) -> Result<Vec<Vec<u8>>, BakeError>,
) -> Result<PilotVisibility, BakeError> {
    let order = cluster_order(&point_features(&points.points, diagonal));
    let clusters = clusters.min(order.len());
    let members_of = |cluster: usize| {
        let all = &order[cluster * order.len() / clusters..(cluster + 1) * order.len() / clusters];
        let count = all.len().min(MEMBERS);
        (0..count).map(move |i| all[(2 * i + 1) * all.len() / (2 * count)])
    };
    let mut fractions = Vec::with_capacity(clusters * lights);
    let numbers: Vec<usize> = (0..clusters).collect();
    for some in numbers.chunks(CLUSTERS_AT_A_TIME) {
        cancelled(observer)?;
        let members: Vec<&BakePoint> =
            some.iter().flat_map(|&c| members_of(c)).map(|member| &points.points[member as usize]).collect();
        let mut rows = rows(&members)?.into_iter();
        for &cluster in some {
            let of_cluster: Vec<Vec<u8>> = rows.by_ref().take(members_of(cluster).count()).collect();
            fractions.extend(mean_of(&of_cluster, lights));
        }
        observer.event(Event::Advanced { done: some.last().map_or(0, |&last| last as u64 + 1) });
    }
    Ok(PilotVisibility { lights, fractions })
}

fn point_features(points: &[BakePoint], diagonal: f32) -> Features {
    let scale = K / diagonal.max(f32::MIN_POSITIVE);
    let features = |p: &BakePoint| -> [f32; 6] {
        let (x, n): (Vec3, Vec3) = (p.position * scale, p.normal);
        [x.x, x.y, x.z, n.x, n.y, n.z]
    };
    Features::new(6, points.iter().flat_map(features).collect())
}

/// Share of the rows that see each light, of 255.
fn mean_of(rows: &[Vec<u8>], lights: usize) -> Vec<u8> {
    let mut sums = vec![0_u32; lights];
    for row in rows {
        sums.iter_mut().zip(row).for_each(|(s, &v)| *s += u32::from(v));
    }
    sums.iter().map(|&s| (s / rows.len() as u32) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertices::{tracing::Tracing, visibility::EXHAUSTIVE};
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
        let tracing = Tracing { lights_per_probe: EXHAUSTIVE, devices: None, observer: &Silent };
        let sampler = ManySampler::new(&intersector, &fibonacci_directions(256), tracing);
        let pilot = sample_pilot(&points, &sampler, 4.0, 4, &Silent).unwrap();
        assert_eq!((pilot.clusters(), pilot.fractions.len()), (4, 1024));
        // Every cluster sees some lights and none sees all; the floor's light comes from above.
        for row in pilot.fractions.chunks(256) {
            assert!(row.iter().any(|&f| f > 0) && row.contains(&0));
        }
        let more = sample_pilot(&points, &sampler, 4.0, 9999, &Silent).unwrap();
        assert_eq!(more.clusters(), points.points.len(), "never more clusters than points");
    }
}
