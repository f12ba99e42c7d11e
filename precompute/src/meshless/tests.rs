//! A complete bake of a closed room with known bounces.

use super::*;
use crate::{
    errors::PointsError,
    observer::Silent,
    sources::{
        candidates::Candidates,
        disk::{Darts, poisson_disk},
    },
    test_scenes::{Prepared, cuboid, room},
};
use lapidary_core::{
    meshless::{SolveSettings, Solver, irradiance},
    sphere::{cosine_direction, frame_around},
    surfel::Surfel,
};
use rayon::prelude::*;

fn settings() -> MeshlessSettings {
    MeshlessSettings { levels: 3, sender_levels: 2, rays: 256, epsilon: 0.01, ..Default::default() }
}

#[test]
fn a_room_of_uniform_light_stays_uniform_and_fades_by_its_reflectance() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.5)));
    let surface = prepared.surface();
    let (bake, report) = meshless_bake(&surface, Vec3::new(0.1, 0.0, 0.2), &settings(), &Silent).unwrap();
    let coarsest = report.functions[0];
    assert!((200..450).contains(&coarsest), "about {} functions: {coarsest}", MeshlessSettings::COARSEST_FUNCTIONS);
    assert_eq!(report.functions.iter().sum::<usize>(), bake.basis.len());
    let ones = vec![Vec3::ONE; bake.basis.senders().len()];
    let gray = vec![Vec3::new(0.5, 0.8, 0.0); ones.len()];
    let solver = Solver::new(&bake);
    let solution = solver.solve(&bake, &ones, &gray, SolveSettings { bounces: 3, threshold: 0.0 });
    for (bounce, mean) in solution.mean_irradiance.iter().enumerate() {
        let expected = Vec3::new(0.5_f32.powi(bounce as i32), 0.8_f32.powi(bounce as i32), 0.0);
        let expected = if bounce == 0 { Vec3::ONE } else { expected };
        assert!(
            (*mean - expected).abs().max_element() <= (0.02 * bounce as f32 + 1e-3) * expected.max_element(),
            "{bounce}: {mean}"
        );
    }
    let (points, _) = surface.uniform_points(300, 5);
    let sum = 0.5 + 0.25 + 0.125;
    let squares = points.iter().map(|p| {
        let vector = bake.basis.evaluate(3, p.position, p.normal, &solution.coefficients);
        (irradiance(&vector, p.normal).x / sum - 1.0).powi(2)
    });
    let rms = (squares.sum::<f32>() / points.len() as f32).sqrt();
    assert!(rms < 0.06, "{rms}");
}

#[test]
fn a_bake_is_the_same_each_time_and_a_viewpoint_without_view_is_an_error() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let small = MeshlessSettings { levels: 2, sender_levels: 1, rays: 64, coarse_radius: Some(0.5), ..settings() };
    let once = || meshless_bake(&prepared.surface(), Vec3::ZERO, &small, &Silent).unwrap().0;
    let (a, b) = (once(), once());
    assert_eq!((a.basis.points(), &a.transport), (b.basis.points(), &b.transport));
    let outside = meshless_bake(&prepared.surface(), Vec3::splat(5.0), &small, &Silent);
    assert!(matches!(outside, Err(BakeError::Points(PointsError::SeesNothing(_)))));
}

#[test]
fn settings_that_no_basis_can_have_are_named_at_once() {
    let prepared = Prepared::new(&room(Vec3::ZERO, Vec3::ONE));
    let error = |settings| meshless_bake(&prepared.surface(), Vec3::ZERO, &settings, &Silent).unwrap_err();
    for radius in [1e-6, 0.0, -1.0, f32::NAN] {
        let tiny = error(MeshlessSettings { coarse_radius: Some(radius), ..settings() });
        assert!(matches!(tiny, BakeError::Points(PointsError::RadiusTooSmall { .. })), "{tiny}");
    }
    let text = error(MeshlessSettings { coarse_radius: Some(1e-6), ..settings() }).to_string();
    assert!(text.contains("0.000001") && text.contains("3.46") && text.contains("coarse radius"), "{text}");
    let senders = error(MeshlessSettings { sender_levels: 4, coarse_radius: Some(0.5), ..settings() });
    assert!(matches!(senders, BakeError::Basis(_)) && !senders.to_string().contains("viewpoint"), "{senders}");
}

/// Irradiance of a unit point light.
fn direct(surface: &dyn Surface, light: Vec3, at: &Surfel) -> f32 {
    let to_light = light - at.position;
    let cosine = to_light.normalize().dot(at.normal).max(0.0);
    let lit = cosine > 0.0 && surface.sees(at.position + at.normal * surface.offset(), light);
    if lit { cosine / to_light.length_squared() } else { 0.0 }
}

/// Its first bounce on half-gray surfaces, by rays.
fn bounced(surface: &dyn Surface, light: Vec3, at: &Surfel) -> f32 {
    const RAYS: usize = 512;
    let (frame, origin) = (frame_around(at.normal), at.position + at.normal * surface.offset());
    let mut random = fastrand::Rng::with_seed(at.place.triangle.into());
    let ray = |i: usize| {
        let direction = frame * cosine_direction((i as f32 + random.f32()) / RAYS as f32, random.f32());
        surface.first_hit(origin, direction).map_or(0.0, |hit| 0.5 * direct(surface, light, &hit))
    };
    (0..RAYS).map(ray).sum::<f32>() / RAYS as f32
}

/// Relative RMSE and ratio of means, from pairs of reference and estimate.
fn compare(pairs: &[(f32, f32)]) -> (f32, f32) {
    let sum = |f: &dyn Fn(&(f32, f32)) -> f32| pairs.iter().map(f).sum::<f32>();
    let square = sum(&|(truth, estimate)| (truth - estimate).powi(2)) / sum(&|p| p.0 * p.0);
    (square.sqrt(), sum(&|p| p.1) / sum(&|p| p.0))
}

#[test]
fn one_bounce_between_boxes_agrees_with_rays() {
    let mut triangles = room(Vec3::ZERO, Vec3::ONE);
    triangles.extend(cuboid(Vec3::new(-0.4, -0.4, -0.4), Vec3::new(0.25, 0.6, 0.25)));
    triangles.extend(cuboid(Vec3::new(0.4, -0.7, 0.4), Vec3::new(0.3, 0.3, 0.3)));
    let prepared = Prepared::new(&triangles);
    let (surface, light) = (prepared.surface(), Vec3::new(0.1, 0.3, 0.1));
    let settings = MeshlessSettings { epsilon: 0.025, sender_levels: 3, ..settings() };
    let (bake, report) = meshless_bake(&surface, light, &settings, &Silent).unwrap();
    let senders = bake.basis.sender_points();
    let lit: Vec<Vec3> = senders.par_iter().map(|p| Vec3::splat(direct(&surface, light, p))).collect();
    let gray = vec![Vec3::splat(0.5); lit.len()];
    let once = SolveSettings { bounces: 1, threshold: 0.0 };
    let coefficients = Solver::new(&bake).solve(&bake, &lit, &gray, once).coefficients;
    let darts = Darts { radius: 0.05 * report.coarse_radius, open_only: false, most: 400 };
    let points = poisson_disk(&mut Candidates::new(&surface, light, 77, &Silent).unwrap(), darts, |_| ()).unwrap();
    let pair = |p: &Surfel| {
        let vector = bake.basis.evaluate(3, p.position, p.normal, &coefficients);
        (bounced(&surface, light, p), irradiance(&vector, p.normal).x)
    };
    let mut pairs: Vec<(f32, f32)> = points.par_iter().map(pair).collect();
    let (error, ratio) = compare(&pairs);
    assert!(error < 0.08 && (ratio - 1.0).abs() < 0.02, "error {error}, energy {ratio}: {report:?}");
    let estimates: Vec<f32> = pairs.iter().map(|p| p.1).collect();
    pairs.iter_mut().zip(estimates.iter().cycle().skip(7)).for_each(|(p, other)| p.1 = *other);
    assert!(compare(&pairs).0 > 0.2, "light at the wrong points shows");
}
