//! Viewpoints in analytic rooms, courts and landscapes.

use super::*;
use crate::test_scenes::{Prepared, cuboid, floor, quad, room};

const INSIDE: Vec3 = Vec3::new(0.1, -0.2, 0.15);

fn found(triangles: &[[Vec3; 3]]) -> Vec3 {
    find_viewpoint(&Prepared::new(triangles).surface(), None, &[], &[]).unwrap()
}

fn is_within(p: Vec3, center: Vec3, half: Vec3) -> bool {
    (p - center).abs().cmplt(half).all()
}

/// A room of 2 m with a closed box on its floor.
fn furnished() -> Prepared {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.4, -0.7, 0.3), Vec3::splat(0.3)));
    Prepared::new(&triangles)
}

/// A building: walls that face outward, with a room inside.
fn building(center: Vec3, half: Vec3) -> Vec<[Vec3; 3]> {
    [cuboid(center, half + 0.05), room(center, half)].concat()
}

fn camera(eye: Vec3) -> Camera {
    Camera::look_at(eye, Vec3::new(0.0, -0.9, 0.0), 40.0)
}

fn light(emission: Emission, position: Vec3) -> Light {
    Light { emission, position, target: position + Vec3::NEG_Y, ..Default::default() }
}

#[test]
fn bad_viewpoints_are_named_and_cameras_come_first() {
    let prepared = furnished();
    let surface = prepared.surface();
    let searched = find_viewpoint(&surface, None, &[], &[]).unwrap();
    assert!(is_within(searched, Vec3::ZERO, Vec3::ONE), "inside the room: {searched}");
    let in_box = Vec3::new(0.4, -0.5, 0.3);
    assert_eq!(find_viewpoint(&surface, Some(in_box), &[], &[]), Err(PointsError::InsideSolid(in_box)));
    assert_eq!(find_viewpoint(&surface, None, &[camera(in_box), camera(INSIDE)], &[]), Ok(INSIDE));
    let nan = find_viewpoint(&surface, Some(Vec3::NAN), &[], &[]);
    assert!(matches!(nan, Err(PointsError::SeesNothing(_))));
    let nothing = Prepared::new(&[]);
    assert_eq!(find_viewpoint(&nothing.surface(), None, &[], &[]), Err(PointsError::NoViewpoint));
}

#[test]
fn lights_are_hints_unless_they_are_inside_something() {
    let prepared = furnished();
    let surface = prepared.surface();
    let in_box = light(Emission::Point, Vec3::new(0.4, -0.5, 0.3));
    let inside = light(Emission::Point, INSIDE);
    assert_eq!(find_viewpoint(&surface, None, &[], &[in_box.clone(), inside.clone()]), Ok(INSIDE));
    assert_eq!(find_viewpoint(&surface, None, &[camera(Vec3::splat(0.5))], &[inside]), Ok(Vec3::splat(0.5)));
    let sun = light(Emission::PARALLEL, Vec3::new(0.2, 0.3, 0.4));
    let searched = find_viewpoint(&surface, None, &[], &[sun.clone(), in_box]).unwrap();
    assert!(searched != sun.position && is_within(searched, Vec3::ZERO, Vec3::ONE), "{searched}");
    let in_ceiling = light(Emission::Rectangle { width: 0.2, height: 0.2 }, Vec3::new(0.1, 1.0, 0.1));
    let below = find_viewpoint(&surface, None, &[], &[in_ceiling]).unwrap();
    assert!(below.y < 1.0 && below.y > 0.99, "just below the lamp: {below}");
}

#[test]
fn a_camera_tells_that_walls_which_face_outward_are_those_of_a_room() {
    let cupboard = (Vec3::new(1.4, -0.6, 0.8), Vec3::new(0.5, 0.35, 0.6));
    let hall = cuboid(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.5));
    let mut prepared = Prepared::new(&[hall, room(cupboard.0, cupboard.1)].concat());
    prepared.sides.two_sided.fill(true);
    let find =
        |cameras: &[Camera], lights: &[Light]| find_viewpoint(&prepared.surface(), None, cameras, lights).unwrap();
    let eye = Vec3::new(-1.2, 0.3, -0.4);
    assert!(is_within(find(&[], &[]), cupboard.0, cupboard.1), "negative control: {}", find(&[], &[]));
    assert!(
        is_within(find(&[], &[light(Emission::Point, eye)]), cupboard.0, cupboard.1),
        "lights may be inside anything"
    );
    assert_eq!(find(&[camera(eye)], &[]), eye);
    let outside = Vec3::new(-4.0, 2.0, 0.0);
    assert!(is_within(find(&[camera(outside)], &[]), cupboard.0, cupboard.1), "a camera outside");
}

#[test]
fn a_court_without_a_roof_is_lit_from_within() {
    // Two-sided walls: visible from outside as well.
    let walls = room(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.5));
    let open: Vec<_> = walls.into_iter().filter(|t| !t.iter().all(|p| p.y > 0.9)).collect();
    assert_eq!(open.len(), 10);
    let found = found(&open);
    assert!(is_within(found, Vec3::ZERO, Vec3::new(2.0, 1.0, 1.5)), "{found}");
}

#[test]
fn of_a_room_in_a_room_the_larger_is_lit() {
    let (center, half) = (Vec3::new(-0.7, -0.6, 0.4), Vec3::new(0.25, 0.35, 0.3));
    let found = found(&[room(Vec3::ZERO, Vec3::new(1.5, 1.0, 1.2)), building(center, half)].concat());
    assert!(is_within(found, Vec3::ZERO, Vec3::new(1.5, 1.0, 1.2)), "{found}");
    assert!(!is_within(found, center, half + 0.1), "{found}");
}

#[test]
fn of_two_rooms_the_larger_is_lit_and_no_place_outside() {
    let (small, large) = (Vec3::new(-2.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
    let half = Vec3::new(1.5, 0.9, 1.2);
    let rooms = [building(small, Vec3::splat(0.6)), building(large, half)].concat();
    let alone = found(&rooms);
    assert!(is_within(alone, large, half), "{alone}");
    let hollow = [cuboid(small, Vec3::splat(0.6)), building(large, half)].concat();
    let alone = found(&hollow);
    assert!(is_within(alone, large, half), "a solid is no room: {alone}");
}

#[test]
fn a_low_attic_does_not_win_over_the_hall_below() {
    // A hall with a hole in its roof, under a closed attic of the same floor area.
    let hall: Vec<_> =
        room(Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0)).into_iter().filter(|t| !t.iter().all(|p| p.y > 0.9)).collect();
    let p = |x: f32, z: f32| Vec3::new(x, 1.0, z);
    let roof = [
        quad(p(-2.0, -2.0), p(2.0, -2.0), p(2.0, 1.4), p(-2.0, 1.4)),
        quad(p(-2.0, 1.4), p(1.2, 1.4), p(1.2, 2.0), p(-2.0, 2.0)),
    ]
    .concat();
    let attic = room(Vec3::new(0.0, 1.12, -0.3), Vec3::new(2.0, 0.1, 1.7));
    let found = found(&[hall, roof, attic].concat());
    assert!(is_within(found, Vec3::ZERO, Vec3::new(2.0, 1.0, 2.0)), "{found}");
}

#[test]
fn open_country_is_seen_from_above() {
    assert!(found(&floor(1.0, 0.0)).y > 0.0);
    let height = |x: f32, z: f32| 0.4 * (0.9 * x).sin() * (0.7 * z).cos();
    let p = |i: usize, j: usize| {
        let (x, z) = (i as f32 * 0.5 - 5.0, j as f32 * 0.5 - 5.0);
        Vec3::new(x, height(x, z), z)
    };
    let tiles = (0..400).flat_map(|k| {
        let (i, j) = (k % 20, k / 20);
        quad(p(i, j), p(i, j + 1), p(i + 1, j + 1), p(i + 1, j))
    });
    let terrain: Vec<_> = tiles.collect();
    let over = found(&terrain);
    assert!(over.y > height(over.x, over.z) && over.abs().max_element() < 9.0, "above the ground: {over}");
    // A shed is closed, but the surrounding country is the larger space.
    let shed = building(Vec3::new(0.0, 0.9, 0.0), Vec3::splat(0.4));
    let with_shed = found(&[terrain, shed].concat());
    assert!(!is_within(with_shed, Vec3::new(0.0, 0.9, 0.0), Vec3::splat(0.5)), "{with_shed}");
}

#[test]
fn what_sees_nothing_is_refused() {
    let plane = Prepared::new(&floor(1.0, 0.0));
    let below = Vec3::new(0.0, -1.0, 0.0);
    assert_eq!(check_viewpoint(&plane.surface(), below), Err(PointsError::SeesNothing(below)));
    let asked = find_viewpoint(&plane.surface(), Some(below), &[], &[]);
    assert_eq!(asked, Err(PointsError::InsideSolid(below)), "the back of the ground");
}
