//! Rays on an adapter against those on the cores.

use super::*;
use crate::device::test_adapter::{on_adapter, shared_device};
use lapidary_core::{
    ray::{BoundaryTracer, DirectionSet, HalfSpace, OPEN},
    sphere::fibonacci_directions,
    test_scenes::soup,
};

/// Origins in a soup, with half-spaces above and below.
fn origins(count: usize) -> Vec<RayOrigin> {
    let at = |i: usize| RayOrigin {
        origin: 0.05 * Vec3::new((i % 70) as f32, -0.7 * (i % 70) as f32, 0.3 + (i / 70) as f32),
        half: HalfSpace { normal: Vec3::new(0.6, 0.8, 0.0), height: -0.1, is_above: !i.is_multiple_of(3) },
    };
    (0..count).map(at).collect()
}

/// Bits of a row that differ from `visible`.
fn ties(row: &[u32], visible: &[u8]) -> usize {
    let differs = |(i, v): &(usize, &u8)| row[i / 32] >> (i % 32) & 1 != u32::from(**v / OPEN);
    visible.iter().enumerate().filter(differs).count()
}

#[test]
fn rays_on_the_gpu_agree_with_those_on_the_processor() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let rays = GpuRays::on(&device, true).unwrap();
    for (triangles, lights) in [(600, 32_768), (600, 4096), (3, 64), (0, 32)] {
        let scene = Intersector::new(&soup(5, triangles));
        let directions = fibonacci_directions(lights);
        let device = rays.device(&scene, RayDirections::All(&directions)).unwrap().expect("it takes a small scene");
        // More than one piece of work with most directions.
        let origins = origins(70);
        let open = device.open(&origins).unwrap();
        let set = DirectionSet::new(&directions);
        let (mut differing, mut seen) = (0, 0);
        for ((row, at), &count) in open.rows.chunks(lights.div_ceil(32)).zip(&origins).zip(&open.counts) {
            let mut visible = vec![0; lights];
            let traced = scene.trace_batch(at.origin, &set, |_, d| at.half.has(d), &mut visible);
            assert_eq!(traced, u64::from(count));
            differing += ties(row, &visible);
            seen += visible.iter().filter(|v| **v == OPEN).count();
        }
        // A driver may fuse products and sums: rays along an edge then fall to either side.
        assert!(differing * 100_000 <= 70 * lights, "{differing} of {}", 70 * lights);
        assert!(seen > 0);
        let moved: Vec<RayOrigin> = origins.iter().map(|at| RayOrigin { origin: at.origin + 1.0, ..*at }).collect();
        assert!(device.open(&moved).unwrap() != open || triangles == 0, "negative control: other origins");
    }
}

/// Bits that differ from those along the boundaries of `set` on the cores, origins with another number of rays, and all rays.
fn differing_along(set: &BoundarySet, scene: &Intersector, origins: &[RayOrigin], open: &OpenRays) -> [usize; 3] {
    let mut tracer = BoundaryTracer::default();
    let mut sums = [0; 3];
    assert_eq!((open.counts.len(), open.rows.len()), (origins.len(), origins.len() * set.len().div_ceil(32)));
    for ((row, at), &count) in open.rows.chunks(set.len().div_ceil(32)).zip(origins).zip(&open.counts) {
        let mut visible = vec![0; set.len()];
        let rays = tracer.trace(scene, at.origin, set, &at.half, &mut visible);
        let own = [ties(row, &visible), usize::from(u64::from(count) != rays), count as usize];
        sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    sums
}

#[test]
fn boundaries_on_the_gpu_are_those_on_the_processor() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let rays = GpuRays::on(&device, true).unwrap();
    let origins = origins(90);
    for (triangles, lights, per_probe) in
        [(600, 8192, 16), (600, 4096, 8), (60, 1000, 64), (3, 64, 16), (600, 9, 8), (5, 1, 16), (0, 300, 16)]
    {
        let scene = Intersector::new(&soup(5, triangles));
        let directions = fibonacci_directions(lights);
        let set = BoundarySet::new(&directions, per_probe);
        let device = rays.device(&scene, RayDirections::Along(&set)).unwrap().expect("it takes a small scene");
        let open = device.open(&origins).unwrap();
        let [differing, other_counts, count] = differing_along(&set, &scene, &origins, &open);
        let all = origins.len() * lights;
        // A driver may fuse products and sums: rays along an edge then fall to either side.
        assert!(differing * 100_000 <= all, "{differing} of {all}");
        // A probe along an edge may change what is traced without changing the result.
        assert!(other_counts <= differing + 1, "{other_counts} origins with other rays, {differing} ties");
        assert!(lights < 4096 || 2 * count < all, "{count} rays of {all}");
        if lights >= 1000 && triangles > 0 {
            let other = BoundarySet::new(&directions, 4 * per_probe);
            let [missed, others, _] = differing_along(&other, &scene, &origins, &open);
            assert!(missed * 10_000 > all && others > 45, "negative control: {missed} with fewer probes, {others}");
        }
    }
}

#[test]
fn more_origins_than_one_piece_of_work_have_their_own_rows() {
    let Some((_one_at_a_time, device)) = on_adapter(shared_device) else { return };
    let rays = GpuRays::on(&device, true).unwrap();
    let scene = Intersector::new(&soup(5, 60));
    let directions = fibonacci_directions(64);
    let set = BoundarySet::new(&directions, 16);
    for (of, at_a_time) in [(RayDirections::All(&directions), 32_768), (RayDirections::Along(&set), MOST_WORKGROUPS)] {
        let device = rays.device(&scene, of).unwrap().expect("it takes a small scene");
        let origins = origins(at_a_time + 70);
        let open = device.open(&origins).unwrap();
        let of_last = device.open(&origins[at_a_time..]).unwrap();
        assert_eq!((open.counts.len(), open.rows.len()), (origins.len(), 2 * origins.len()));
        assert!(open.rows[2 * at_a_time..] == of_last.rows && open.counts[at_a_time..] == of_last.counts);
        assert!(open.rows[..140] != of_last.rows, "negative control");
    }
}
