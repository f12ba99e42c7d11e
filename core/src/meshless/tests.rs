//! The basis, its projections and the solver on surfaces with known answers.

use super::*;
use crate::{
    sphere::{fibonacci_directions, frame_around},
    surfel::Surfel,
    test_scenes::{random_directions, sphere_basis, sphere_points},
};
use glam::Vec3;
use std::f32::consts::PI;

fn samples<T>(basis: &Basis, f: impl Fn(Vec3) -> T) -> Vec<T> {
    basis.points().iter().map(|p| f(p.position)).collect()
}

fn wavy(p: Vec3) -> f32 {
    1.0 + p.z * (3.0 * p.x).sin() + 0.5 * p.y
}

#[test]
fn values_of_each_level_sum_to_one() {
    let basis = sphere_basis(40, 4, 2, 1.0);
    assert_eq!((basis.len(), basis.levels(), basis.senders()), (40 * 85, 4, 0..200));
    for p in random_directions(300) {
        for level in 0..4 {
            let mut values = Vec::new();
            basis.values(level, p, p, &mut values);
            let sum: f32 = values.iter().map(|v| v.1).sum();
            assert!((sum - 1.0).abs() < 1e-5 && values.iter().all(|v| v.1 > 0.0), "{sum} at {p}");
            assert!(values.iter().all(|v| basis.level(level).contains(&(v.0 as usize))));
        }
        let mut behind = Vec::new();
        basis.values(0, p, -p, &mut behind);
        assert!(behind.iter().all(|v| basis.points()[v.0 as usize].normal.dot(-p) > 0.0), "no light through a wall");
    }
}

#[test]
fn radii_run_from_one_and_a_half_to_two_and_a_half_spacings() {
    let basis = sphere_basis(40, 3, 1, 1.0);
    let spacing = (0.7 * 4.0 * PI / 40.0).sqrt();
    let factors: Vec<f32> = basis.radii().iter().enumerate().map(|(l, r)| r / spacing * (1 << l) as f32).collect();
    assert!(factors.iter().zip([1.5, 2.0, 2.5]).all(|(a, b)| (a - b).abs() < 1e-5), "{factors:?}");
}

#[test]
fn constants_are_exact_and_need_no_fine_levels() {
    let basis = sphere_basis(40, 4, 2, 1.0);
    let projection = Projection::new(&basis, 4);
    let constant = samples(&basis, |_| Vec3::new(1.0, 2.0, 3.0));
    for coefficients in [projection.coarse_to_fine(&constant), projection.pull_push(&constant)] {
        assert!(coefficients[basis.level(0)].iter().all(|c| c.abs_diff_eq(constant[0], 1e-5)));
        assert!(coefficients[40..].iter().all(|c| c.abs().max_element() < 1e-5), "finer coefficients vanish");
        for p in random_directions(100) {
            assert!(basis.evaluate(4, p, p, &coefficients).abs_diff_eq(constant[0], 1e-5));
        }
    }
    let other = projection.coarse_to_fine(&samples(&basis, wavy));
    assert!(other[40..].iter().any(|c| c.abs() > 0.05), "and do not for what varies");
}

fn rms_error(basis: &Basis, levels: usize, coefficients: &[f32]) -> f32 {
    let points = random_directions(500);
    let square = |p: &Vec3| (basis.evaluate(levels, *p, *p, coefficients) - wavy(*p)).powi(2);
    (points.iter().map(square).sum::<f32>() / points.len() as f32).sqrt()
}

#[test]
fn the_error_falls_with_every_level() {
    let basis = sphere_basis(40, 5, 2, 1.0);
    let projection = Projection::new(&basis, 5);
    let sampled = samples(&basis, wavy);
    let mut coefficients = projection.coarse_to_fine(&sampled);
    let errors: Vec<f32> = (1..=5).map(|levels| rms_error(&basis, levels, &coefficients)).collect();
    assert!(errors.windows(2).all(|e| e[1] < 0.6 * e[0]), "{errors:?}");
    assert!(errors[4] < 0.01, "{errors:?}");
    let pulled = rms_error(&basis, 5, &projection.pull_push(&sampled));
    assert!(pulled < 0.02, "averages first converge as well: {pulled}");
    coefficients[basis.level(4)].rotate_left(1);
    assert!(rms_error(&basis, 5, &coefficients) > 1.5 * errors[4], "coefficients at the wrong points show");
}

/// The largest change of a function over steps of `step` along a great circle.
fn largest_step(step: f32, f: impl Fn(Vec3) -> f32) -> f32 {
    let point = |i: usize| {
        let (sin, cos) = (i as f32 * step).sin_cos();
        Vec3::new(cos, 0.6 * sin, 0.8 * sin)
    };
    let values: Vec<f32> = (0..(1.0 / step) as usize).map(|i| f(point(i))).collect();
    values.windows(2).map(|v| (v[1] - v[0]).abs()).fold(0.0, f32::max)
}

#[test]
fn the_sum_is_smooth() {
    let basis = sphere_basis(40, 4, 2, 1.0);
    let coefficients = Projection::new(&basis, 4).coarse_to_fine(&samples(&basis, wavy));
    let smooth = |p: Vec3| basis.evaluate(4, p, p, &coefficients);
    let (coarse, fine) = (largest_step(2e-3, smooth), largest_step(1e-3, smooth));
    assert!(fine < 0.6 * coarse && coarse < 2e-3 * 8.0, "no jumps, and a bounded slope: {coarse} {fine}");
    let nearest = |p: Vec3| {
        let distance = |a: &&Surfel| a.position.distance_squared(p);
        basis.points().iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).map_or(0.0, |s| wavy(s.position))
    };
    let (coarse, fine) = (largest_step(2e-3, nearest), largest_step(1e-3, nearest));
    assert!(fine > 0.6 * coarse, "values of the nearest point jump: {coarse} {fine}");
}

#[test]
fn parents_children_and_neighbours_are_the_same_relation() {
    let basis = sphere_basis(30, 3, 2, 1.0);
    let parents = basis.values_at(basis.level(1), 0..1);
    let children = basis.children(0);
    assert_eq!((parents.len(), children.len()), (120, 30));
    for i in 0..30 {
        assert!(!children.row(i).is_empty());
        for &(child, value) in children.row(i) {
            assert!(parents.row(child as usize - 30).contains(&(i as u32, value)));
        }
    }
    let neighbours = basis.neighbours(1);
    for i in 0..120 {
        assert!(neighbours.row(i).iter().all(|n| n.0 as usize != i + 30 && basis.level(1).contains(&(n.0 as usize))));
        assert!(neighbours.row(i).len() >= 4, "each disk has others around it");
    }
}

#[test]
fn points_that_are_no_basis_are_refused() {
    let points = sphere_points(10, 1.0);
    let parts =
        |offsets: Vec<u32>, radii: Vec<f32>, senders| Basis::from_parts(points.clone(), offsets, radii, senders);
    let good = parts(vec![0, 4, 10], vec![1.0, 0.5], 2).unwrap();
    assert_eq!((good.level(0), good.level(1), good.senders()), (0..4, 4..10, 0..10));
    let levels = BasisError::Levels { points: 10 };
    assert_eq!(parts(vec![0, 4, 9], vec![1.0, 0.5], 2).unwrap_err(), levels, "points left over");
    assert_eq!(parts(vec![0, 11, 10], vec![1.0, 0.5], 2).unwrap_err(), levels, "out of order");
    assert_eq!(parts(vec![0, 4, 10], vec![1.0], 1).unwrap_err(), levels, "a radius too few");
    let senders = BasisError::SenderLevels { sender_levels: 3, levels: 2 };
    assert_eq!(parts(vec![0, 4, 10], vec![1.0, 0.5], 3).unwrap_err(), senders, "more senders than levels");
    let radius = parts(vec![0, 4, 10], vec![1.0, f32::NAN], 2).unwrap_err();
    assert!(matches!(radius, BasisError::Radius { level: 1, .. }), "{radius}");
}

/// The operator of the inside of a sphere, by brute force, with links to and from the coarsest level only.
fn inside_of_a_sphere() -> MeshlessBake {
    let basis = sphere_basis(240, 2, 2, -1.0);
    let directions = fibonacci_directions(2000);
    let rows = basis.points().iter().enumerate().map(|(i, p)| {
        let frame = frame_around(p.normal);
        let coarse = i < basis.level(0).len();
        let directions = if coarse { &directions[..] } else { &[] };
        let mut sums = vec![Vec3::ZERO; basis.len()];
        for d in directions.iter().filter(|d| d.z > 0.0).map(|d| frame * *d) {
            let hit = p.position - 2.0 * p.position.dot(d) * d;
            let mut values = Vec::new();
            (0..2).for_each(|level| basis.values(level, hit, -hit, &mut values));
            values.iter().for_each(|&(j, value)| sums[j as usize] += d * value * (4.0 * PI / 2000.0));
        }
        sums.into_iter().enumerate().filter(|(_, v)| *v != Vec3::ZERO).map(|(j, v)| (j as u32, v)).collect()
    });
    let rows: Vec<_> = rows.collect();
    let transport = Transport::from_rows(&rows, basis.len());
    MeshlessBake { basis, transport }
}

#[test]
fn inside_a_sphere_each_bounce_is_the_mean_times_the_reflectance() {
    let bake = inside_of_a_sphere();
    let solver = Solver::new(&bake);
    let direct = samples(&bake.basis, |p| Vec3::splat(1.0 + p.z));
    let half = vec![Vec3::new(0.5, 0.25, 0.0); direct.len()];
    let solution = solver.solve(&bake, &direct, &half, SolveSettings { bounces: 3, threshold: 0.0 });
    for (bounce, mean) in solution.mean_irradiance.iter().enumerate() {
        let expected = Vec3::new(0.5_f32, 0.25, 0.0).powf(bounce as f32);
        let expected = if bounce == 0 { Vec3::ONE } else { expected };
        // Vector irradiance of neighbors with other normals is a percent short each bounce, without finer receivers.
        let tolerance = 0.012 * bounce as f32 + 1e-3;
        assert!((*mean - expected).abs().max_element() <= tolerance * expected.max_element(), "{bounce}: {mean}");
    }
    let all = 0.5 + 0.25 + 0.125;
    for p in random_directions(100) {
        let vector = bake.basis.evaluate(2, p, -p, &solution.coefficients);
        let e = irradiance(&vector, -p).x;
        assert!((e / all - 1.0).abs() < 0.04, "irradiance is the same everywhere: {e} at {p}");
    }
}

#[test]
fn a_white_sphere_keeps_its_energy_and_bad_numbers_stay_out() {
    let bake = inside_of_a_sphere();
    let solver = Solver::new(&bake);
    let mut direct = vec![Vec3::ONE; bake.basis.senders().len()];
    direct[0] = Vec3::NAN;
    direct[1] = Vec3::new(f32::INFINITY, -1.0, 0.0);
    let white = vec![Vec3::new(1.0, 7.0, f32::NAN); direct.len()];
    let settings = SolveSettings { bounces: 1_000_000, ..Default::default() };
    let solution = solver.solve(&bake, &direct, &white, settings);
    assert_eq!(solution.mean_irradiance.len(), 1 + SolveSettings::MOST_BOUNCES as usize, "bounces are bounded");
    let all_finite = solution.coefficients.iter().all(|m| m.is_finite());
    assert!(all_finite && solution.mean_irradiance.iter().all(|e| e.is_finite() && e.max_element() < 1.3));
    let white = vec![Vec3::ONE; direct.len()];
    let ones = vec![Vec3::ONE; direct.len()];
    let solution = solver.solve(&bake, &ones, &white, SolveSettings { bounces: 10, threshold: 0.0 });
    assert!((solution.mean_irradiance[10].x - 1.0).abs() < 0.1, "{:?}", solution.mean_irradiance[10]);
}

#[test]
fn flattening_is_evaluation_at_the_points() {
    let bake = inside_of_a_sphere();
    let solver = Solver::new(&bake);
    let direct = samples(&bake.basis, |p| Vec3::splat(1.0 + p.x));
    let reflectance = vec![Vec3::splat(0.5); direct.len()];
    let solution = solver.solve(&bake, &direct, &reflectance, SolveSettings::default());
    let points: Vec<_> = random_directions(2000).into_iter().map(|p| (p, -p)).collect();
    let flattening = Flattening::new(&bake.basis, &bake.transport, &points);
    let flat = flattening.apply(&solution.coefficients);
    for (&(position, normal), flat) in points.iter().zip(&flat) {
        let direct = bake.basis.evaluate(2, position, normal, &solution.coefficients);
        assert!(direct.abs_diff_eq(*flat, 1e-5));
    }
    assert!(flattening.weights() < 2000 * 12, "functions without links take no weights");
}
