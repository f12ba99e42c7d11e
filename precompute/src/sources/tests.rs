//! Poisson-disk sets on known geometry.

mod areas;

use super::{
    candidates::Candidates,
    disk::{self, Darts, poisson_count, poisson_disk, poisson_levels},
    spacing::Spacing,
    viewpoint::find_viewpoint,
};
use crate::{
    errors::PointsError,
    observer::{Event, Observer, Silent},
    test_scenes::{Prepared, cuboid, floor, room},
};
use glam::Vec3;
use lapidary_core::{
    camera::Camera,
    shot::Shot,
    surfel::{GradedGrid, Surface, Surfel, distance::distance},
};

const INSIDE: Vec3 = Vec3::new(0.1, -0.2, 0.15);

/// A room of 2 m with a closed box on its floor that contains another box.
fn furnished() -> Prepared {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.4, -0.7, 0.3), Vec3::splat(0.3)));
    triangles.extend(cuboid(Vec3::new(0.4, -0.7, 0.3), Vec3::splat(0.1)));
    Prepared::new(&triangles)
}

/// `count` evenly spaced points with their radii.
fn even_points(prepared: &Prepared, count: usize) -> Vec<(Surfel, f32)> {
    let surface = prepared.surface();
    let mut candidates = Candidates::new(&surface, INSIDE, 1, &Silent).unwrap();
    poisson_count(&mut candidates, count, |_, factor| 0.05 * factor).unwrap()
}

/// `count` points placed as sources are.
fn graded_points(prepared: &Prepared, count: usize, shots: &[Shot]) -> Vec<(Surfel, f32)> {
    let surface = prepared.surface();
    let candidates = |seed| Candidates::new(&surface, INSIDE, seed, &Silent).unwrap().for_shots(shots);
    let spacing = Spacing::new(&mut candidates(1), count).unwrap();
    poisson_count(&mut candidates(2), count, |place, factor| spacing.at(place, factor)).unwrap()
}

fn disk(prepared: &Prepared, radius: f32, seed: u64) -> Vec<Surfel> {
    let surface = prepared.surface();
    let mut candidates = Candidates::new(&surface, INSIDE, seed, &Silent).unwrap();
    poisson_disk(&mut candidates, Darts { radius, open_only: false, most: 100_000 }, |_| ()).unwrap()
}

/// Keeps warnings.
#[derive(Default)]
struct Warnings(std::sync::Mutex<String>);

impl Observer for Warnings {
    fn event(&self, event: Event) {
        if let Event::Warning { message } = event {
            self.0.lock().unwrap().push_str(&message.to_string());
        }
    }
}

#[test]
fn no_two_points_are_nearer_than_the_radius_and_none_is_enclosed() {
    let prepared = furnished();
    let points = disk(&prepared, 0.1, 1);
    let nearest = |set: &[Surfel]| {
        let pairs = (0..set.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| distance(&set[i], &set[j])).fold(f32::INFINITY, f32::min)
    };
    assert!(nearest(&points) >= 0.1, "{}", nearest(&points));
    let enclosed = |p: &Surfel| p.position.distance(Vec3::new(0.4, -0.7, 0.3)) < 0.25;
    assert!(!points.iter().any(enclosed));
    let beneath =
        |p: &Surfel| p.position.y < -0.999 && (p.position - Vec3::new(0.4, -1.0, 0.3)).abs().max_element() < 0.3;
    assert!(!points.iter().any(beneath), "the floor under the box and the box's own underside");
    let mut closer = points;
    closer.push(Surfel { position: closer[0].position + Vec3::splat(1e-3), ..closer[0] });
    assert!(nearest(&closer) < 0.1, "negative control");
}

#[test]
fn points_of_faces_at_right_angles_may_be_close_and_those_of_one_face_may_not() {
    let points = disk(&Prepared::new(&room(Vec3::ZERO, Vec3::ONE)), 0.2, 3);
    let closest = |across: bool| {
        let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let other = |&(i, j): &(usize, usize)| (points[i].normal.dot(points[j].normal) < 0.5) == across;
        pairs.filter(other).map(|(i, j)| points[i].position.distance(points[j].position)).fold(9.0, f32::min)
    };
    assert!(closest(true) < 0.08, "{}", closest(true));
    assert!(closest(false) >= 0.2);
}

#[test]
fn density_is_even() {
    let points = disk(&Prepared::new(&room(Vec3::ZERO, Vec3::ONE)), 0.06, 5);
    // 4 x 4 squares on each of the six faces, away from the edges, which crop disks.
    let mut counts = std::collections::HashMap::new();
    for p in &points {
        let key = ((p.position + p.normal * 0.5) * 2.0).floor().as_ivec3();
        *counts.entry((p.normal.round().as_ivec3(), key)).or_insert(0.0_f32) += 1.0;
    }
    assert_eq!(counts.len(), 96);
    let mean = counts.values().sum::<f32>() / 96.0;
    let deviation = (counts.values().map(|c| (c - mean).powi(2)).sum::<f32>() / 96.0).sqrt() / mean;
    assert!(deviation < 0.09, "coefficient of variation {deviation} about {mean}");
    assert!(1.0 / mean.sqrt() > 1.4 * deviation, "random points would vary more than {deviation}");
}

#[test]
fn a_level_that_is_cut_short_is_told() {
    let prepared = furnished();
    let told = |most| {
        let warnings = Warnings::default();
        let levels = disk::levels_of_at_most(most, &prepared.surface(), INSIDE, 0.4, 2, 7, &warnings).unwrap();
        assert!(levels.iter().all(|level| level.len() <= most));
        warnings.0.into_inner().unwrap()
    };
    let text = told(300);
    assert!(text.contains("300 points") && text.contains("coarse radius"), "{text}");
    assert_eq!(told(100_000), "");
}

#[test]
fn levels_halve_the_radius_and_threads_do_not_matter() {
    let prepared = furnished();
    let levels = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| poisson_levels(&prepared.surface(), INSIDE, 0.4, 3, 7, &Silent).unwrap())
    };
    let one = levels(1);
    assert!(one.windows(2).all(|w| (2.5..6.0).contains(&(w[1].len() as f32 / w[0].len() as f32))));
    assert_eq!(one, levels(3));
    let other = poisson_levels(&prepared.surface(), INSIDE, 0.4, 3, 8, &Silent).unwrap();
    assert_ne!(one, other, "negative control");
}

#[test]
fn narrow_places_get_no_coarse_points() {
    // A slot of 1 cm under a plate: no distant surface is visible from the floor beneath.
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.0, -0.89, 0.0), Vec3::new(0.25, 0.1, 0.25)));
    let prepared = Prepared::new(&triangles);
    let in_slot = |open_only| {
        let surface = prepared.surface();
        let mut candidates = Candidates::new(&surface, INSIDE, 1, &Silent).unwrap();
        let points = poisson_disk(&mut candidates, Darts { radius: 0.15, open_only, most: 100_000 }, |_| ()).unwrap();
        points.iter().filter(|p| p.position.y < -0.995 && p.position.abs().with_y(0.0).max_element() < 0.2).count()
    };
    assert_eq!(in_slot(true), 0);
    assert!(in_slot(false) > 0, "negative control");
}

#[test]
fn an_open_scene_still_gets_points() {
    let mut triangles = floor(2.0, 0.0).to_vec();
    triangles.extend(cuboid(Vec3::new(0.0, 0.5, 0.0), Vec3::splat(0.4)));
    let prepared = Prepared::new(&triangles);
    let viewpoint = find_viewpoint(&prepared.surface(), None, &[], &[]).unwrap();
    let surface = prepared.surface();
    let candidates = |seed| Candidates::new(&surface, viewpoint, seed, &Silent).unwrap();
    let spacing = Spacing::new(&mut candidates(1), 512).unwrap();
    let points = poisson_count(&mut candidates(2), 512, |place, factor| spacing.at(place, factor)).unwrap();
    assert!(points.iter().any(|p| p.0.position.y == 0.0) && points.iter().any(|p| p.0.position.y > 0.5));
}

/// Most paths from a box end nearby and the ground is wide, so few segments determine its width.
#[test]
fn wide_ground_around_a_house_is_covered_by_its_points() {
    for half_width in [40.0, 400.0] {
        let mut triangles = floor(half_width, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 0.5, 0.0), Vec3::splat(0.4)));
        let prepared = Prepared::new(&triangles);
        let surface = prepared.surface();
        let candidates = |seed| Candidates::new(&surface, Vec3::new(0.0, 1.5, 1.5), seed, &Silent).unwrap();
        let spacing = Spacing::new(&mut candidates(1), 1024).unwrap();
        let points = poisson_count(&mut candidates(2), 1024, |place, factor| spacing.at(place, factor)).unwrap();
        assert_eq!(points.len(), 1024);
        let bare = |radii: f32| {
            let grid = GradedGrid::of(points.iter().map(|&(point, radius)| (point, radii * radius)));
            let mut fresh = candidates(3);
            (0..5000).filter(|_| grid.nearest(&fresh.draw().unwrap().unwrap()).is_none()).count()
        };
        assert!(bare(2.0) < 20, "{}", bare(2.0));
        assert!(bare(0.5) > 200, "negative control: half as wide as they are apart, {}", bare(0.5));
    }
}

#[test]
fn surfaces_without_area_and_cancelled_jobs_end() {
    let speck = Prepared::new(&[[Vec3::ZERO, Vec3::X * 1e-20, Vec3::Z * 1e-20], [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X]]);
    let surface = speck.surface();
    assert!(find_viewpoint(&surface, None, &[], &[]).is_err());
    assert!(surface.bounds().diagonal() > 1.0);
    struct Stop;
    impl Observer for Stop {
        fn event(&self, _: Event) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let prepared = furnished();
    let surface = prepared.surface();
    let mut stopped = Candidates::new(&surface, INSIDE, 1, &Stop).unwrap();
    assert_eq!(poisson_count(&mut stopped, 512, |_, factor| factor), Err(PointsError::Cancelled));
    assert_eq!(Spacing::new(&mut stopped, 512).err(), Some(PointsError::Cancelled));
}

/// A plate of 0.8 m that floats 4 cm over the floor of the room.
fn plate_over_floor() -> Prepared {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(0.3, -0.94, 0.2), Vec3::new(0.4, 0.02, 0.4)));
    Prepared::new(&triangles)
}

/// Points in the gap beneath the plate, on the floor and on the plate.
fn in_gap(points: &[(Surfel, f32)]) -> usize {
    let is_in = |p: &Surfel| {
        p.position.y < -0.959 && (p.position - Vec3::new(0.3, -1.0, 0.2)).abs().with_y(0.0).max_element() < 0.4
    };
    points.iter().filter(|p| is_in(&p.0)).count()
}

#[test]
fn sources_are_closer_together_where_surfaces_are_and_nowhere_too_far_apart() {
    let prepared = plate_over_floor();
    let (even, graded) = (even_points(&prepared, 2048), graded_points(&prepared, 2048, &[]));
    assert_eq!(graded.len(), 2048);
    // 1.28 of 26 m² are the gap's.
    assert!((60..160).contains(&in_gap(&even)), "negative control: {}", in_gap(&even));
    assert!(in_gap(&graded) > 2 * in_gap(&even), "{} and {}", in_gap(&graded), in_gap(&even));
    let widest = graded.iter().map(|p| p.1).fold(0.0, f32::max);
    assert!((1.2..2.5).contains(&(widest / even[0].1)), "{widest} and {}", even[0].1);
    let pairs = (0..graded.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let keeps_off = |(i, j): (usize, usize)| {
        let ((p, r), (q, s)) = (graded[i], graded[j]);
        distance(&p, &q) >= r.min(s)
    };
    assert!(pairs.into_iter().all(keeps_off), "no two are nearer than the smaller of their radii");
}

#[test]
fn what_lies_close_to_what_a_shot_sees_has_more_sources_than_what_none_sees() {
    let prepared = plate_over_floor();
    let at_plate = Camera::look_at(Vec3::new(-0.9, -0.98, -0.7), Vec3::new(0.3, -0.98, 0.2), 20.0);
    let at_ceiling = Camera::look_at(Vec3::new(-0.9, -0.5, -0.7), Vec3::new(0.0, 1.0, 0.0), 40.0);
    let shot = |camera| [Shot { camera, aspect: 1.5 }];
    let counts = [at_plate, at_ceiling].map(|camera| in_gap(&graded_points(&prepared, 2048, &shot(camera))));
    assert!(counts[0] > 2 * counts[1], "{counts:?}");
    let all = in_gap(&graded_points(&prepared, 2048, &[]));
    assert!(counts[1] < all && all < counts[0], "{all} for all views, {counts:?}");
}
