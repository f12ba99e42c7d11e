//! Batches, single rays and brute force agree to the bit; closest hits agree with plain geometry.

use super::*;
use crate::{
    ground::add_ground,
    scene::Scene,
    simd::{InstructionSet, Vec3x8},
    sphere::fibonacci_directions,
    test_scenes::soup,
};

#[test]
fn batches_single_rays_and_brute_force_agree_to_the_bit() {
    for (seed, lights) in [(1, 64), (2, 1000), (3, 8192)] {
        let scene = Intersector::new(&soup(seed, 400));
        let directions = fibonacci_directions(lights);
        let set = DirectionSet::new(&directions);
        for origin in [Vec3::ZERO, Vec3::new(2.0, 1.0, -3.0), Vec3::new(0.0, 9.0, 0.0)] {
            let mut visible = vec![0; lights];
            let traced = scene.trace_batch(origin, &set, |_, d| d.x > -0.2, &mut visible);
            assert_eq!(traced, directions.iter().filter(|d| d.x > -0.2).count() as u64);
            let mut blocked = 0;
            for (v, &d) in visible.iter().zip(&directions) {
                let occluded = scene.occluded_by_brute_force(origin, d);
                assert_eq!(scene.occluded(origin, d), occluded);
                assert_eq!(*v == OPEN, d.x > -0.2 && !occluded, "direction {d}");
                blocked += usize::from(occluded);
            }
            let open = lights - blocked;
            assert!(origin.y > 8.0 || (blocked > 0 && open > 0), "a scene that tells them apart");
        }
    }
}

/// Each triangle twice, so that most hits have two triangles at the same distance.
fn doubled(mut mesh: Mesh) -> Mesh {
    mesh.triangles.extend(mesh.triangles.clone());
    mesh
}

#[test]
fn eight_hits_at_a_time_are_those_of_single_rays() {
    let directions = fibonacci_directions(2000);
    // The directions of a spiral lie far apart, but close together at its start.
    let eights: Vec<[Vec3; 8]> = directions.as_chunks().0.to_vec();
    for mesh in [soup(5, 700), doubled(soup(6, 300)), Mesh::default()] {
        let scene = Intersector::new(&mesh);
        for origin in [Vec3::ZERO, Vec3::new(0.0, 9.0, 0.0)] {
            let hits = scene.closest_hits(origin, &eights);
            let single = |&d: &Vec3| scene.closest_hit(origin, d);
            let expected: Vec<_> = directions.iter().map(single).collect();
            assert_eq!(hits.as_flattened(), expected);
            for set in InstructionSet::available() {
                assert_eq!(scene.closest_hits_in(set, origin, &eights), hits, "{set:?}");
            }
            let met = expected.iter().flatten().count();
            assert!(mesh.triangles.is_empty() || met > 10, "{met}");
            let elsewhere = scene.closest_hits(origin + 0.5, &eights);
            assert!(elsewhere != hits || met == 0, "negative control: another origin");
        }
    }
}

#[test]
fn of_triangles_at_the_same_distance_the_first_is_met() {
    let mesh = doubled(soup(6, 300));
    let scene = Intersector::new(&mesh);
    let hits: Vec<Hit> =
        fibonacci_directions(500).into_iter().filter_map(|d| scene.closest_hit(Vec3::ZERO, d)).collect();
    let second = hits.iter().filter(|hit| hit.triangle >= 300).count();
    assert!(hits.len() > 50 && second == 0, "{second} of {}", hits.len());
}

#[test]
fn batches_give_the_same_bits_in_all_instruction_sets() {
    use super::{batch::Walk, directions::GROUPS};
    let scene = Intersector::new(&soup(2, 400));
    let set = DirectionSet::new(&fibonacci_directions(1000));
    let traced = |instructions: InstructionSet| -> Vec<[u8; GROUPS]> {
        let mut stack = Vec::new();
        let mut trace = |packet| {
            let active = [u8::MAX; GROUPS];
            instructions.run(Walk::<false> { scene: &scene, packet, origin: Vec3::ZERO, active, stack: &mut stack })
        };
        set.packets.iter().map(&mut trace).collect()
    };
    let portable = traced(InstructionSet::PORTABLE);
    assert!(portable.iter().flatten().any(|&open| open != 0 && open != u8::MAX), "a scene that tells them apart");
    InstructionSet::available().for_each(|set| assert_eq!(traced(set), portable, "{set:?}"));
}

#[test]
fn closest_hits_lie_on_their_triangle_and_nothing_is_nearer() {
    let mesh = soup(7, 900);
    let scene = Intersector::new(&mesh);
    let mut hits = 0;
    for d in fibonacci_directions(500) {
        let Some(hit) = scene.closest_hit(Vec3::ZERO, d) else {
            assert!(!scene.occluded_by_brute_force(Vec3::ZERO, d));
            continue;
        };
        hits += 1;
        let [a, b, c] = mesh.corners(hit.triangle as usize);
        let (u, v) = (hit.barycentric.x, hit.barycentric.y);
        let point = a * (1.0 - u - v) + b * u + c * v;
        assert!((point - d * hit.distance).length() < 1e-3, "{hit:?}");
        let seen_from_behind = mesh.area_vector(hit.triangle as usize).dot(d) > 0.0;
        assert_eq!(hit.back_face, seen_from_behind);
        let nearest = (0..mesh.triangles.len())
            .filter_map(|t| TriangleFrom::new(Vec3::ZERO, mesh.corners(t)).hit(d))
            .map(|h| h.distance)
            .fold(f32::INFINITY, f32::min);
        assert!((hit.distance - nearest).abs() < 1e-4);
    }
    assert!(hits > 100);
}

#[test]
fn no_ray_slips_between_neighbouring_triangles() {
    // A closed box seen from inside, with rays aimed at its edges, diagonals and corners.
    let p = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0_f32, 1.0] {
            let corner = |u: f32, v: f32| {
                let mut c = [0.0; 3];
                (c[axis], c[(axis + 1) % 3], c[(axis + 2) % 3]) = (side, u, v);
                p(c[0], c[1], c[2])
            };
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    let scene = Intersector::new(&mesh);
    let origin = p(0.137, -0.291, 0.353);
    let mut rng = fastrand::Rng::with_seed(4);
    for _ in 0..20_000 {
        let t = 2.0 * rng.f32() - 1.0;
        for target in [p(t, 1.0, 1.0), p(1.0, t, -1.0), p(-1.0, -1.0, t), p(t, t, 1.0), p(1.0, t, t)] {
            let direction = (target - origin).normalize();
            assert!(scene.occluded_by_brute_force(origin, direction), "toward {target}");
            assert!(scene.occluded(origin, direction), "toward {target}, by the hierarchy");
        }
    }
    let outside = p(0.0, 3.0, 0.0);
    assert!(!scene.occluded(outside, Vec3::Y), "negative control");
}

#[test]
fn a_bounded_ray_is_blocked_by_what_is_nearer_only() {
    let scene = Intersector::new(&soup(11, 500));
    let mut hits = 0;
    for d in fibonacci_directions(400) {
        let Some(hit) = scene.closest_hit(Vec3::ZERO, d) else {
            assert!(!scene.occluded_before(Vec3::ZERO, d, f32::INFINITY));
            continue;
        };
        hits += 1;
        assert!(scene.occluded_before(Vec3::ZERO, d, f32::INFINITY));
        assert!(scene.occluded_before(Vec3::ZERO, d, 1.001 * hit.distance));
        assert!(!scene.occluded_before(Vec3::ZERO, d, 0.999 * hit.distance), "{hit:?}");
    }
    assert!(hits > 50);
}

#[test]
fn segments_are_blocked_by_what_lies_between_their_ends_alone() {
    let mesh = soup(9, 300);
    let scene = Intersector::new(&mesh);
    let (mut blocked, mut open) = (0, 0);
    for d in fibonacci_directions(400) {
        let Some(hit) = scene.closest_hit(Vec3::ZERO, d) else { continue };
        assert!(!scene.occluded_between(Vec3::ZERO, d * (hit.distance * 0.999)), "short of the first hit");
        assert!(scene.occluded_between(Vec3::ZERO, d * (hit.distance * 1.001)), "beyond the first hit");
        let to = d * 3.0;
        let crosses =
            |t: usize| TriangleFrom::new(Vec3::ZERO, mesh.corners(t)).hit(d).is_some_and(|h| h.distance < 3.0);
        let expected = (0..mesh.triangles.len()).any(crosses);
        assert_eq!(scene.occluded_between(Vec3::ZERO, to), expected, "toward {to}");
        assert_eq!(scene.occluded_between(to, Vec3::ZERO), expected, "from the other end");
        *(if expected { &mut blocked } else { &mut open }) += 1;
    }
    assert!(blocked > 10 && open > 10, "a scene that tells them apart: {blocked} and {open}");
}

#[test]
fn batches_of_segments_and_single_ones_agree_to_the_bit() {
    let scene = Intersector::new(&soup(11, 500));
    let mut rng = fastrand::Rng::with_seed(3);
    let mut point = || Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5) * 9.0;
    // In runs of neighbors, as in a tree, and some far apart.
    let ends: Vec<Vec3> = (0..60)
        .flat_map(|_| {
            let center = point();
            (0..25).map(|_| center + point() * 0.1).collect::<Vec<_>>()
        })
        .collect();
    let wanted: Vec<u32> = (0..ends.len() as u32).filter(|i| i % 7 != 0).collect();
    let mut batch = SegmentBatch::default();
    for origin in [Vec3::ZERO, Vec3::new(2.0, 1.0, -3.0), Vec3::new(0.0, 9.0, 0.0)] {
        let mut hidden = Vec::new();
        batch.trace(&scene, origin, &ends, &wanted, |i| hidden.push(i));
        hidden.sort_unstable();
        let expected: Vec<u32> =
            wanted.iter().copied().filter(|&i| scene.occluded_between(origin, ends[i as usize])).collect();
        assert_eq!(hidden, expected);
        assert!(hidden.len() > 100 && hidden.len() + 100 < wanted.len(), "a scene that tells them apart");
        let unbounded = |&&i: &&u32| scene.occluded(origin, ends[i as usize] - origin);
        assert!(wanted.iter().filter(unbounded).count() > hidden.len(), "negative control");
    }
}

#[test]
fn eight_surfels_at_a_time_are_those_of_single_rays() {
    let directions = fibonacci_directions(2003);
    let close_together = spatial_order(&directions).into_iter().map(|i| directions[i as usize]);
    let eights = in_eights(close_together);
    assert_eq!(eights.len(), 251);
    assert_eq!(eights[250][3..], [eights[250][2]; 5], "the last is repeated");
    for mesh in [soup(5, 700), doubled(soup(6, 300)), Mesh::default()] {
        let scene = Intersector::new(&mesh);
        let median = {
            let mut distances: Vec<f32> =
                directions.iter().filter_map(|&d| Some(scene.closest_hit(Vec3::ZERO, d)?.distance)).collect();
            distances.sort_unstable_by(f32::total_cmp);
            distances.get(distances.len() / 2).copied().unwrap_or(1.0)
        };
        // As far as one of the hits, which counts.
        for distance in [median, f32::INFINITY] {
            let met = scene.surfels_before(Vec3::ZERO, &eights, distance);
            let single = |&d: &Vec3| scene.surfel_before(Vec3::ZERO, d, distance);
            assert_eq!(met.as_flattened(), eights.as_flattened().iter().map(single).collect::<Vec<_>>());
        }
        let count =
            |distance| scene.surfels_before(Vec3::ZERO, &eights, distance).as_flattened().iter().flatten().count();
        assert!(mesh.triangles.is_empty() || (10..count(f32::INFINITY) - 10).contains(&count(median)));
    }
}

#[test]
fn surfels_are_closest_hits_with_the_normal_toward_the_origin() {
    let mesh = soup(4, 400);
    let scene = Intersector::new(&mesh);
    let (mut fronts, mut backs) = (0, 0);
    for direction in fibonacci_directions(500) {
        let Some(hit) = scene.closest_hit(Vec3::ZERO, direction) else {
            assert_eq!(scene.surfel_before(Vec3::ZERO, direction, 100.0), None);
            continue;
        };
        let surfel = scene.surfel_before(Vec3::ZERO, direction, 1.01 * hit.distance).unwrap();
        assert_eq!((surfel.place.triangle, surfel.place.barycentric), (hit.triangle, hit.barycentric));
        assert!((surfel.position - direction * hit.distance).length() < 1e-5);
        let front = mesh.area_vector(hit.triangle as usize).normalize();
        assert!(surfel.normal.dot(direction) < 0.0 && (surfel.normal.dot(front).abs() - 1.0).abs() < 1e-4);
        assert_eq!(surfel.normal.dot(front) < 0.0, hit.back_face);
        assert_eq!(scene.surfel_before(Vec3::ZERO, direction, 0.99 * hit.distance), None, "too far");
        *(if hit.back_face { &mut backs } else { &mut fronts }) += 1;
    }
    assert!(fronts > 50 && backs > 50);
}

#[test]
fn thousands_of_copies_of_a_triangle_are_one_to_the_hierarchy() {
    let mut mesh = soup(3, 200);
    let copies = mesh.triangles[7];
    mesh.triangles.extend(std::iter::repeat_n(copies, 50_000));
    let (scene, alone) = (Intersector::new(&mesh), Intersector::new(&soup(3, 200)));
    assert_eq!((scene.leaf_ids.len(), scene.bvh.nodes.len()), (alone.leaf_ids.len(), alone.bvh.nodes.len()));
    for d in fibonacci_directions(300) {
        assert_eq!(scene.closest_hit(Vec3::ZERO, d), alone.closest_hit(Vec3::ZERO, d));
    }
    // The same corners in another order are another triangle.
    let [a, b, c] = copies;
    mesh.triangles.push([b, c, a]);
    assert!(Intersector::new(&mesh).leaf_ids.contains(&(mesh.triangles.len() as u32 - 1)), "negative control");
}

#[test]
fn eight_rays_from_anywhere_agree_with_single_ones_to_the_bit() {
    for (mesh, seed) in [(soup(7, 500), 1), (doubled(soup(8, 200)), 2), (Mesh::default(), 3)] {
        let scene = Intersector::new(&mesh);
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut point = || Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5);
        // Adjacent in one direction, and scattered.
        let eight = |i: usize| {
            let (at, along) = (6.0 * point(), point().normalize());
            let origins: [Vec3; 8] =
                std::array::from_fn(|_| if i.is_multiple_of(2) { at + 0.1 * point() } else { 6.0 * point() });
            let directions = std::array::from_fn(|_| if i.is_multiple_of(2) { along } else { point().normalize() });
            (origins, directions, 0b1101_1011 | (i % 7) as u8)
        };
        let eights: Vec<([Vec3; 8], [Vec3; 8], u8)> = (0..200).map(eight).collect();
        let rays: Vec<EightRays> = eights.iter().map(|&(o, d, active)| EightRays::new(o, d, active)).collect();
        let (open, distances) = (scene.open(&rays), scene.closest_distances(&rays));
        let before: [f32; 8] = std::array::from_fn(|lane| 0.5 + lane as f32);
        let seen_before: Vec<SeenThrough> = rays.iter().map(|rays| scene.seen_before(rays, before)).collect();
        let mut met = 0;
        for (i, (origins, directions, active)) in eights.iter().enumerate() {
            for lane in 0..8 {
                let is_active = active >> lane & 1 == 1;
                let hit = scene.closest_hit(origins[lane], directions[lane]).filter(|_| is_active);
                let is_open = is_active && !scene.occluded_by_brute_force(origins[lane], directions[lane]);
                assert_eq!(open[i] >> lane & 1 == 1, is_open, "{i}, {lane}");
                assert_eq!(distances[i][lane], hit.map_or(f32::INFINITY, |hit| hit.distance), "{i}, {lane}");
                let is_blocked = is_active && scene.occluded_before(origins[lane], directions[lane], before[lane]);
                let seen = [is_active && !is_blocked, is_blocked];
                assert_eq!([seen_before[i].open, seen_before[i].closed].map(|bits| bits >> lane & 1 == 1), seen);
                met += usize::from(hit.is_some());
            }
        }
        assert!(mesh.triangles.is_empty() || (met > 100 && met < 1400), "{met}");
        for set in InstructionSet::available() {
            assert_eq!(
                (scene.open_in(set, &rays), scene.closest_distances_in(set, &rays)),
                (open.clone(), distances.clone())
            );
            let again = rays.iter().map(|rays| scene.seen_before_in(set, rays, before));
            assert!(again.eq(seen_before.iter().copied()), "{set:?}");
        }
        let elsewhere: Vec<EightRays> =
            eights.iter().map(|&(o, d, active)| EightRays::new(o.map(|o| o + 1.0), d, active)).collect();
        assert!(scene.open(&elsewhere) != open || met == 0, "negative control: other origins");
    }
}

/// Directions from the middle of a disc around `axis` to its rim, whose sine is `sine`.
fn directions_within(axis: Vec3, sine: f32) -> Vec<Vec3> {
    let (right, up) = axis.any_orthonormal_pair();
    let at = |i: u32| {
        let (radius, angle) = (sine * (i as f32 / 127.0).sqrt(), 2.4 * i as f32);
        let height = (1.0 - radius * radius).sqrt();
        axis * height + (right * angle.cos() + up * angle.sin()) * radius
    };
    (0..128).map(at).collect()
}

#[test]
fn no_ray_of_an_open_cone_meets_anything_and_all_of_a_closed_one_do() {
    let scene = Intersector::new(&soup(9, 60));
    let mut rng = fastrand::Rng::with_seed(4);
    let mut point = || Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5);
    let (mut known, mut wrong_if_wider) = ([0; 2], 0);
    for i in 0..400 {
        let axis = if i % 8 == 0 { Vec3::Y } else { point().normalize() };
        let sine = [0.0, 0.0047, 0.05, 0.3][i % 4];
        let at = 6.0 * point();
        let cones = EightCones { origins: std::array::from_fn(|_| at + 0.3 * point()), axis, sine, active: !(i as u8) };
        let seen = scene.seen_through(&cones);
        assert_eq!((seen.open | seen.closed) & !cones.active, 0);
        InstructionSet::available().for_each(|set| assert_eq!(scene.seen_through_in(set, &cones), seen, "{set:?}"));
        for (lane, &origin) in cones.origins.iter().enumerate() {
            let has = |bits: u8| bits >> lane & 1 == 1;
            let occluded = |sine| {
                let rays = directions_within(axis, sine);
                rays.iter().filter(|&&d| scene.occluded_by_brute_force(origin, d)).count()
            };
            let (met, wider) = (occluded(sine), occluded(sine + 0.1));
            assert!(!has(seen.open) || met == 0, "{i}, {lane}: {met} of an open one");
            assert!(!has(seen.closed) || met == 128, "{i}, {lane}: {met} of a closed one");
            // For a single ray, visibility is known.
            assert!(sine > 0.0 || !has(cones.active) || has(seen.open | seen.closed), "{i}, {lane}");
            known[0] += usize::from(has(seen.open));
            known[1] += usize::from(has(seen.closed));
            wrong_if_wider += usize::from(has(seen.open) && wider > 0 || has(seen.closed) && wider < 128);
        }
    }
    assert!(known.iter().all(|&known| known > 30), "{known:?}");
    assert!(wrong_if_wider > 20, "negative control, wider cones: {wrong_if_wider}");
}

#[test]
fn rays_within_a_cone_agree_with_single_ones_whatever_stopped_others() {
    let scene = Intersector::new(&soup(11, 400));
    let mut rng = fastrand::Rng::with_seed(6);
    let mut point = || Vec3::new(rng.f32() - 0.5, rng.f32() - 0.5, rng.f32() - 0.5);
    let (mut blockers, mut met, mut remembered) = (Blockers::default(), 0, 0);
    for i in 0..300 {
        let axis = if i % 8 == 0 { Vec3::Y } else { point().normalize() };
        let cone = Cone { origin: 6.0 * point(), axis, sine: [0.0, 0.0047, 0.05, 0.3][i % 4] };
        let within = directions_within(axis, cone.sine);
        let rays: [[Vec3; 8]; 2] = std::array::from_fn(|eight| std::array::from_fn(|lane| within[16 * lane + eight]));
        let (directions, active) = (rays.map(Vec3x8::from_array), [!(i as u8), 0xf7]);
        let open = scene.open_within(&cone, &directions, active, &mut blockers);
        for (ray, &direction) in rays.as_flattened().iter().enumerate() {
            let is_active = active[ray / 8] >> (ray % 8) & 1 == 1;
            let is_open = is_active && !scene.occluded_by_brute_force(cone.origin, direction);
            assert_eq!(open[ray / 8] >> (ray % 8) & 1 == 1, is_open, "{i}, {ray}");
            met += usize::from(is_active && !is_open);
        }
        remembered += usize::from(blockers != Blockers::default());
        for set in InstructionSet::available() {
            let again = scene.open_within_in(set, &cone, &directions, (active, &mut Blockers::default()));
            assert_eq!(again, open, "{set:?}");
        }
    }
    assert!((500..3500).contains(&met), "a scene that tells them apart: {met}");
    assert!(remembered > 50, "{remembered}");
    let nothing = Intersector::new(&Mesh::default());
    let cone = Cone { origin: Vec3::ZERO, axis: Vec3::Y, sine: 0.1 };
    let up = [Vec3x8::splat(Vec3::Y); 2];
    assert_eq!(nothing.open_within(&cone, &up, [3, 5], &mut blockers), [3, 5], "with what another scene left");
}

/// A soup over its ground, in radii of 6 or so.
fn grounded_soup() -> Mesh {
    let mut scene = Scene { mesh: soup(5, 400), ..Scene::default() };
    add_ground(&mut scene);
    scene.mesh
}

#[test]
fn over_a_ground_rays_meet_what_they_meet_by_brute_force() {
    let mesh = grounded_soup();
    let scene = Intersector::new(&mesh);
    let directions = fibonacci_directions(2000);
    let set = DirectionSet::new(&directions);
    let low = mesh.bounds().min.y;
    for origin in [Vec3::ZERO, Vec3::new(3.0, low, 2.0), Vec3::new(90.0, low, -60.0), Vec3::new(0.0, low - 4.0, 0.0)] {
        let mut visible = vec![0; directions.len()];
        scene.trace_batch(origin, &set, |_, _| true, &mut visible);
        for (v, &d) in visible.iter().zip(&directions) {
            let occluded = scene.occluded_by_brute_force(origin, d);
            assert_eq!((scene.occluded(origin, d), *v == 0), (occluded, occluded), "{origin} {d}");
        }
        let blocked = visible.iter().filter(|v| **v == 0).count();
        assert!((900..1600).contains(&blocked), "half of the sphere is ground: {blocked}");
    }
}

#[test]
fn from_below_rays_pass_the_ground_however_far_they_begin() {
    let mesh = grounded_soup();
    let of_soup = 0..mesh.ground.unwrap().triangle;
    let scene = Intersector::new(&mesh);
    let (mut met, mut differing) = (0, 0);
    for distance in [10.0, 100.0, 1000.0] {
        let origin = Vec3::new(0.3, -1.0, 0.2).normalize() * distance;
        for target in fibonacci_directions(200).into_iter().map(|d| d * 3.0) {
            let ray = (origin, (target - origin).normalize());
            let first = scene.closest_hit(ray.0, ray.1);
            assert!(first.is_some_and(|hit| mesh.is_ground(hit.triangle) && hit.back_face), "negative control");
            let triangle = |hit: Option<Hit>| hit.map(|hit| hit.triangle);
            let of_triangle =
                |t: u32| Some((TriangleFrom::new(ray.0, mesh.corners(t as usize)).hit(ray.1)?.distance, t));
            let nearest = of_soup.clone().filter_map(of_triangle).min_by(|a, b| a.0.total_cmp(&b.0));
            let expected = nearest.map(|(_, triangle)| triangle);
            for from_above in [false, true] {
                let found = triangle(scene.past_ground(&mesh, first, ray, from_above, |_| 0.0));
                // From a hundred diagonals away edges are rounded to either side, most of all in the oracle.
                assert!(found == expected || distance > 100.0, "{distance}: {found:?} and {expected:?}");
                differing += usize::from(found != expected);
            }
            met += usize::from(expected.is_some());
        }
    }
    assert!(met > 150 && differing < 40, "{met} met, {differing} of 1200 differ");
    let down = (Vec3::new(0.0, 20.0, 40.0), Vec3::NEG_Y);
    let first = scene.closest_hit(down.0, down.1);
    assert!(scene.past_ground(&mesh, first, down, true, |_| 0.0) == first && first.is_some());
    assert_eq!(scene.past_ground(&mesh, first, down, false, |_| 0.0), None);
}
