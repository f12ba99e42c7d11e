//! Boundaries against single rays and segments.

use super::*;
use crate::{
    mesh::Mesh,
    ray::{HalfSpace, Intersector, OPEN},
    sphere::fibonacci_directions,
    test_scenes::soup,
};
use glam::Vec3;
use std::collections::HashSet;

/// Visibility by boundaries, and by single rays.
fn seen_along_boundaries(
    scene: &Intersector,
    directions: &[Vec3],
    directions_per_probe: usize,
    half: &HalfSpace,
) -> (Vec<u8>, Vec<u8>, u64) {
    let set = BoundarySet::new(directions, directions_per_probe);
    let mut seen = vec![0; directions.len()];
    let mut tracer = BoundaryTracer::default();
    let rays = tracer.trace(scene, Vec3::ZERO, &set, half, &mut seen);
    let single = |&d: &Vec3| OPEN * u8::from(half.has(d) && !scene.occluded(Vec3::ZERO, d));
    (seen, directions.iter().map(single).collect(), rays)
}

/// A disc with a hole around an axis, at distance 2 from the origin: triangles between rings.
fn disc(axis: Vec3, [inner, outer]: [f32; 2]) -> Mesh {
    let (u, v) = axis.any_orthonormal_pair();
    let mut mesh = Mesh::default();
    for step in 0..64 {
        let at = |step: u32, radius: f32| {
            let (sin, cos) = (std::f32::consts::TAU * step as f32 / 64.0).sin_cos();
            2.0 * axis + radius * (cos * u + sin * v)
        };
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([at(step, inner), at(step, outer), at(step + 1, outer), at(step + 1, inner)]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

const ABOVE: HalfSpace = HalfSpace { normal: Vec3::Y, height: 0.0, is_above: true };

#[test]
fn boundaries_lead_around_all_that_probes_meet() {
    let directions = fibonacci_directions(8192);
    for axis in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::X, Vec3::new(0.3, 0.2, -0.9).normalize()] {
        // Wide enough to have probes inside and outside.
        let scene = Intersector::new(&disc(axis, [0.7, 1.3]));
        let (seen, expected, rays) = seen_along_boundaries(&scene, &directions, 16, &ABOVE);
        assert!(seen == expected, "around {axis}");
        assert!(seen.contains(&OPEN) && rays < 8192 / 5, "{rays}");
        let below = HalfSpace { is_above: false, ..ABOVE };
        let (seen, expected, _) = seen_along_boundaries(&scene, &directions, 16, &below);
        assert!(seen == expected, "below, around {axis}");
    }
}

#[test]
fn what_no_probe_meets_is_missed_and_finer_probes_find_it() {
    let directions = fibonacci_directions(8192);
    // About twenty directions meet it.
    let small = Intersector::new(&disc(Vec3::new(0.35, 0.9, 0.2).normalize(), [0.0, 0.22]));
    let wrong = |directions_per_probe| {
        let (seen, expected, _) = seen_along_boundaries(&small, &directions, directions_per_probe, &ABOVE);
        assert!(
            (10..40).contains(&expected.iter().zip(&directions).filter(|(e, d)| **e == 0 && ABOVE.has(**d)).count())
        );
        seen.iter().zip(&expected).filter(|(a, b)| a != b).count()
    };
    assert_eq!([wrong(8), wrong(16)], [0, 0]);
    assert!(wrong(512) >= 10, "negative control");
}

#[test]
fn hardly_any_direction_is_wrong_even_among_small_triangles_and_fewer_with_more_probes() {
    let directions = fibonacci_directions(8192);
    for seed in 1..5 {
        let scene = Intersector::new(&soup(seed, 400));
        let wrong = |directions_per_probe| {
            let (seen, expected, rays) = seen_along_boundaries(&scene, &directions, directions_per_probe, &ABOVE);
            assert!(rays < 4096, "{rays} for half of the directions");
            seen.iter().zip(&expected).filter(|(a, b)| a != b).count()
        };
        let [fine, usual, coarse] = [8, 16, 256].map(wrong);
        assert!(fine <= usual && usual <= coarse && coarse > 60, "{fine}, {usual}, {coarse}");
        assert!(usual < 82, "1 %: {usual}");
        let (seen, ..) = seen_along_boundaries(&scene, &directions, 16, &ABOVE);
        let below = HalfSpace { is_above: false, ..ABOVE };
        assert_ne!(seen_along_boundaries(&scene, &directions, 16, &below).0, seen, "negative control");
    }
}

#[test]
fn few_directions_and_an_empty_scene_have_boundaries_too() {
    let nothing = Intersector::new(&Mesh::default());
    let scene = Intersector::new(&soup(3, 400));
    for count in [1, 2, 7, 9, 64, 100] {
        let directions = fibonacci_directions(count);
        for scene in [&nothing, &scene] {
            // Every group has its own probe: it is blocked or traced.
            let (seen, expected, _) = seen_along_boundaries(scene, &directions, 8, &ABOVE);
            assert!(
                seen.iter().zip(&expected).zip(&directions).all(|((a, b), d)| a == b || !ABOVE.has(*d) || count > 8)
            );
            assert!(seen.iter().zip(&directions).all(|(seen, d)| ABOVE.has(*d) || *seen == 0));
        }
        let open = seen_along_boundaries(&nothing, &directions, 16, &ABOVE);
        assert_eq!(open.0, open.1);
    }
}

/// A level disc with a hole.
fn plate(center: Vec3, radii: [f32; 2]) -> Intersector {
    let mut mesh = disc(Vec3::Y, radii);
    mesh.positions.iter_mut().for_each(|p| *p += center - 2.0 * Vec3::Y);
    Intersector::new(&mesh)
}

/// Points of a square of two meters at height 1, row by row in blocks of 2 x 4, with the neighbors of each.
fn ceiling(side: u32) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let blocks = (0..side / 4).flat_map(|z| (0..side / 2).map(move |x| (2 * x, 4 * z)));
    let places: Vec<(u32, u32)> = blocks.flat_map(|(x, z)| (0..8).map(move |i| (x + i % 2, z + i / 2))).collect();
    let at = |i: u32| 2.0 * (i as f32 + 0.5) / side as f32 - 1.0;
    let beside = |&(x, z): &(u32, u32)| {
        let touches = |&(_, &(u, v)): &(u32, &(u32, u32))| x.abs_diff(u) + z.abs_diff(v) == 1;
        (0..).zip(&places).filter(touches).map(|(i, _)| i).collect()
    };
    (places.iter().map(|&(x, z)| Vec3::new(at(x), 1.0, at(z))).collect(), places.iter().map(beside).collect())
}

/// Points hidden by boundaries, points hidden by single segments, and the segments traced.
fn hidden_along_boundaries(scene: &Intersector, points_per_probe: usize, asks: fn(Vec3) -> bool) -> [Vec<u32>; 3] {
    let (ends, neighbours) = ceiling(64);
    let wanted: Vec<u32> = (0..ends.len() as u32).filter(|&i| asks(ends[i as usize])).collect();
    let set = SegmentSet::new(ends.clone(), &neighbours, points_per_probe);
    let origin = Vec3::new(0.1, -1.0, 0.2);
    let mut hidden = Vec::new();
    let traced = SegmentTracer::default().trace(scene, origin, &set, &wanted, |i| hidden.push(i));
    hidden.sort_unstable();
    let is_hidden = |i: &u32| scene.occluded_between(origin, ends[*i as usize]);
    [hidden, wanted.iter().copied().filter(is_hidden).collect(), vec![traced as u32, wanted.len() as u32]]
}

#[test]
fn boundaries_lead_around_all_that_hides_points() {
    // Below the ceiling, and beyond it, where it hides nothing.
    let below = plate(Vec3::new(0.0, 0.4, 0.1), [0.15, 0.3]);
    let beyond = plate(Vec3::new(0.0, 1.2, 0.1), [0.0, 0.3]);
    for asks in [|_| true, |end: Vec3| end.x > 0.05] {
        let [hidden, expected, counts] = hidden_along_boundaries(&below, 16, asks);
        assert_eq!(hidden, expected);
        assert!(hidden.len() > 100 && 3 * counts[0] < counts[1], "{} hidden, {counts:?}", hidden.len());
        let [hidden, ..] = hidden_along_boundaries(&beyond, 16, asks);
        assert!(hidden.is_empty(), "{hidden:?}");
    }
    let (ends, origin) = (ceiling(64).0, Vec3::new(0.1, -1.0, 0.2));
    let beyond_its_end = ends.iter().filter(|&&end| beyond.occluded(origin, end - origin)).count();
    assert!(beyond_its_end > 100, "negative control: rays without an end are blocked, {beyond_its_end}");
}

#[test]
fn few_points_and_an_empty_scene_have_boundaries_too() {
    let scenes = [Intersector::new(&Mesh::default()), plate(Vec3::new(0.0, 0.4, 0.0), [0.0, 9.0])];
    let points = ceiling(64).0;
    for count in [1, 2, 9, 100] {
        let set = SegmentSet::new(points[..count].to_vec(), &vec![Vec::new(); count], 16);
        let all: Vec<u32> = (0..count as u32).collect();
        let mut tracer = SegmentTracer::default();
        for wanted in [&all[..], &all[count - 1..], &[]] {
            let mut hidden = |scene| {
                let mut hidden = Vec::new();
                tracer.trace(scene, Vec3::NEG_Y, &set, wanted, |i| hidden.push(i));
                hidden.sort_unstable();
                hidden
            };
            assert!(hidden(&scenes[0]).is_empty());
            assert_eq!(hidden(&scenes[1]), wanted);
        }
    }
}

#[test]
fn points_that_no_probe_tells_of_are_missed_and_finer_probes_find_them() {
    let small = plate(Vec3::new(0.1, 0.4, 0.05), [0.0, 0.07]);
    let wrong = |points_per_probe| {
        let [hidden, expected, _] = hidden_along_boundaries(&small, points_per_probe, |_| true);
        assert!((10..200).contains(&expected.len()), "{}", expected.len());
        (hidden.len() as i64 - expected.len() as i64).unsigned_abs()
    };
    assert_eq!([wrong(8), wrong(16)], [0, 0]);
    assert!(wrong(1024) >= 10, "negative control");
}

#[test]
fn segments_along_boundaries_are_hardly_ever_wrong_among_small_triangles() {
    for seed in 1..5 {
        let mut mesh = soup(seed, 150);
        mesh.positions.iter_mut().for_each(|p| *p *= 0.25);
        let scene = Intersector::new(&mesh);
        let wrong = |points_per_probe| {
            let [hidden, expected, _] = hidden_along_boundaries(&scene, points_per_probe, |_| true);
            assert!(expected.len() > 100);
            let hidden: HashSet<u32> = hidden.into_iter().collect();
            hidden.symmetric_difference(&expected.into_iter().collect()).count()
        };
        let [usual, coarse] = [16, 1024].map(wrong);
        assert!(usual < 82, "2 %: {usual}");
        assert!(coarse > 2 * usual, "negative control: {coarse}, {usual}");
    }
}

#[test]
fn tables_tell_of_each_direction_its_group_its_probe_and_what_touches_it() {
    for (count, per_probe) in [(1, 8), (100, 16), (1000, 64)] {
        let directions = fibonacci_directions(count);
        let tables = BoundarySet::new(&directions, per_probe).tables();
        let [groups, blocks] = [GROUP, per_probe].map(|size| count.div_ceil(size));
        assert_eq!(
            (tables.touching.len(), tables.probes.len(), tables.groups_per_block),
            (groups, blocks, per_probe / 8)
        );
        let targets: HashSet<u32> = tables.targets.iter().copied().collect();
        assert!(targets.len() == count && tables.targets.len() == count);
        assert!(tables.directions.iter().zip(&tables.targets).all(|(d, &target)| *d == directions[target as usize]));
        let is_in_block = |(block, &probe): (usize, &u32)| probe as usize / per_probe == block;
        assert!(tables.probes.iter().enumerate().all(is_in_block));
        let lanes = |from: usize, to: u32| tables.touching[from].iter().find(|(group, _)| *group == to).map(|of| of.1);
        for (from, touching) in tables.touching.iter().enumerate() {
            assert!(touching.iter().all(|&(to, lanes_from)| {
                lanes_from != 0 && to as usize != from && lanes(to as usize, from as u32).is_some()
            }));
        }
        assert!(count < 100 || !is_in_block((0, &tables.probes[1])), "negative control");
    }
}
