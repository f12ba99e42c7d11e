//! A whole bake of a closed room, whose bounces are known.

use super::*;
use crate::{
    Silent,
    mesh_surface::tests::{Prepared, room},
};
use lapidary_core::meshless::{SolveSettings, Solver, irradiance};

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
    let grey = vec![Vec3::new(0.5, 0.8, 0.0); ones.len()];
    let solver = Solver::new(&bake);
    let solution = solver.solve(&bake, &ones, &grey, SolveSettings { bounces: 3, threshold: 0.0 });
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
