//! Areas of samples on known geometry.

use super::*;
use crate::sources::areas::sample_areas;

#[test]
fn what_lies_close_under_a_box_is_not_its_surroundings() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.4, -0.698, 0.3), Vec3::splat(0.3)));
    let prepared = Prepared::new(&triangles);
    let points = even_points(&prepared, 2048);
    let is_floor = |p: &Surfel| p.normal.y > 0.9 && p.position.y < -0.999;
    let is_under = |p: &Surfel| (p.position - Vec3::new(0.4, -1.0, 0.3)).abs().max_element() < 0.3;
    let floor_in_sight = |prepared: &Prepared| -> f32 {
        let areas = sample_areas(&prepared.surface(), &points, 2, &Silent).unwrap();
        let floor = points.iter().zip(&areas).filter(|((p, _), _)| is_floor(p) && !is_under(p));
        floor.map(|(_, area)| area).sum()
    };
    let area = floor_in_sight(&prepared);
    assert!((area / (4.0 - 0.36) - 1.0).abs() < 0.02, "{area} m2 of floor in sight for 3.64");
    let bare = floor_in_sight(&Prepared::new(&room(Vec3::ZERO, Vec3::ONE)));
    assert!(bare / (4.0 - 0.36) > 1.02, "negative control: {bare} m2 without the box");
}

#[test]
fn areas_add_up_to_what_light_reaches() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let points = even_points(&prepared, 1024);
    assert_eq!(points.len(), 1024);
    let areas = sample_areas(&prepared.surface(), &points, 2, &Silent).unwrap();
    let total: f32 = areas.iter().sum();
    assert!((total / 24.0 - 1.0).abs() < 0.02, "{total}");
    let mean = total / 1024.0;
    let (least, most) = areas.iter().fold((f32::MAX, 0.0_f32), |(l, m), &a| (l.min(a), m.max(a)));
    assert!(least > 0.2 * mean && most < 3.0 * mean, "{least} and {most} about {mean}");
    // A box of 0.6 m on the floor hides 0.36 m² and shows five faces.
    let furnished = furnished();
    let expected = 24.0 - 0.36 + 5.0 * 0.36;
    for points in [even_points(&furnished, 2048), graded_points(&furnished, 2048, &[])] {
        let total: f32 = sample_areas(&furnished.surface(), &points, 2, &Silent).unwrap().iter().sum();
        assert!((total / expected - 1.0).abs() < 0.02, "{total} for {expected}");
    }
    let walls = room(Vec3::ZERO, Vec3::ONE);
    let doubled = Prepared::new(&[walls.clone(), walls].concat());
    let total: f32 = sample_areas(&doubled.surface(), &points, 2, &Silent).unwrap().iter().sum();
    assert!((total / 24.0 - 1.0).abs() < 0.02, "{total} for walls of two faces in one another");
    let (draws, area) = doubled.surface().uniform_points(1024, 1);
    let of_faces = draws.len() as f32 * area;
    assert!((of_faces / 48.0 - 1.0).abs() < 0.02, "negative control: {of_faces} of all faces");
}

/// Sources 20 cm apart on a floor, and 2 cm apart in one square of it, which get one point per draw.
#[test]
fn fine_samples_have_their_area_as_well() {
    let prepared = Prepared::new(&floor(1.0, 0.0));
    let grid = |first: Vec3, count: i32, cell: f32| {
        let at = move |i: i32| (i as f32 + 0.5) * cell;
        let place = move |(x, z)| first + Vec3::new(at(x), 0.0, at(z));
        let surfel = |position| Surfel { position, ..Default::default() };
        (0..count).flat_map(move |x| (0..count).map(move |z| (x, z))).map(move |i| (surfel(place(i)), cell))
    };
    let is_coarse = |(s, _): &(Surfel, f32)| !(0.0..0.2).contains(&s.position.x) || !(0.0..0.2).contains(&s.position.z);
    let mut samples: Vec<(Surfel, f32)> = grid(Vec3::new(-1.0, 0.0, -1.0), 10, 0.2).filter(is_coarse).collect();
    let fine = samples.len();
    samples.extend(grid(Vec3::ZERO, 10, 0.02));
    let areas = sample_areas(&prepared.surface(), &samples, 2, &Silent).unwrap();
    let inner = (fine..samples.len()).filter(|&i| samples[i].0.position.cmpgt(Vec3::new(0.02, -1.0, 0.02)).all());
    let inner = inner.filter(|&i| samples[i].0.position.cmplt(Vec3::new(0.18, 1.0, 0.18)).all());
    let deviation = |i: usize| (areas[i] / 4e-4 - 1.0).powi(2);
    let (sum, count) = inner.fold((0.0, 0), |(sum, count), i| (sum + deviation(i), count + 1));
    let deviation = (sum / count as f32).sqrt();
    assert!(count == 64 && deviation < 0.4, "{count}, {deviation}");
    assert!((areas.iter().sum::<f32>() / 4.0 - 1.0).abs() < 0.02);
}

/// A tile of 1.6 m stands 5 mm out of a wall, whose hidden part faces the same way; radii are ten times as large.
#[test]
fn a_wall_close_behind_a_tile_has_no_part_in_the_tiles_area() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.8, 0.8, 0.005)));
    let tiled = Prepared::new(&triangles);
    let points = even_points(&tiled, 2048);
    assert!(points[0].1 > 0.05, "{}", points[0].1);
    let total: f32 = sample_areas(&tiled.surface(), &points, 2, &Silent).unwrap().iter().sum();
    // The tile's face replaces the wall behind it; its narrow sides are added.
    assert!((total / (24.0 + 4.0 * 1.6 * 0.005) - 1.0).abs() < 0.02, "{total}; 26.5 with the wall");
}

/// Nine screens of 1 cm stand on the floor: many points at their feet are nearest to a sample behind the screen.
#[test]
fn a_point_whose_nearest_sample_is_hidden_belongs_to_the_next() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    let screen = |i: i32| cuboid(Vec3::new(0.0, -0.7, 0.2 * i as f32), Vec3::new(0.6, 0.3, 0.005));
    triangles.extend((-4..=4).flat_map(screen));
    let parted = Prepared::new(&triangles);
    let surface = parted.surface();
    let mut candidates = Candidates::new(&surface, INSIDE + Vec3::Y * 0.5, 1, &Silent).unwrap();
    let points = poisson_count(&mut candidates, 512, |_, factor| 0.05 * factor).unwrap();
    let total: f32 = sample_areas(&surface, &points, 2, &Silent).unwrap().iter().sum();
    // Tops replace the floor beneath; two faces and two edges of each are added.
    let expected = 24.0 + 9.0 * 2.0 * (1.2 + 0.01) * 0.6;
    assert!((total / expected - 1.0).abs() < 0.02, "{total} for {expected}");
}

#[test]
fn areas_of_a_small_room_of_a_large_building_are_as_even_as_those_of_the_room_alone() {
    let deviation = |building: &[[Vec3; 3]]| {
        let mut triangles = room(Vec3::ZERO, Vec3::ONE);
        triangles.extend(building);
        let prepared = Prepared::new(&triangles);
        let points = even_points(&prepared, 512);
        let warnings = Warnings::default();
        let areas = sample_areas(&prepared.surface(), &points, 2, &warnings).unwrap();
        let total: f32 = areas.iter().sum();
        let mean = total / 512.0;
        let squares: f32 = areas.iter().map(|a| (a / mean - 1.0).powi(2)).sum();
        (total, (squares / 512.0).sqrt(), warnings.0.into_inner().unwrap())
    };
    let (total, alone, remarks) = deviation(&[]);
    assert!((total / 24.0 - 1.0).abs() < 0.02 && remarks.is_empty(), "{total} {remarks}");
    // 2,400 m² beside 24: one draw alone would give a sample 0.6 points, and a deviation above 1.
    let (total, beside, remarks) = deviation(&room(Vec3::X * 30.0, Vec3::splat(10.0)));
    assert!((total / 24.0 - 1.0).abs() < 0.03, "{total}");
    assert!(beside < 1.3 * alone && alone < 0.4, "{beside} and {alone}");
    assert!(remarks.is_empty(), "{remarks}");
    let (_, far, remarks) = deviation(&room(Vec3::X * 300.0, Vec3::splat(100.0)));
    assert!(
        far > 1.0 && remarks.contains("points estimate the area") && remarks.contains("no area"),
        "{far} {remarks}"
    );
}
