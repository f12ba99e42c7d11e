//! The operator for a known answer: inside a sphere, irradiance is uniform.

use super::*;
use crate::observer::Silent;
use glam::Vec3;
use lapidary_core::threads::on_threads;
use lapidary_core::{
    bounds::Bounds,
    meshless::{MeshlessBake, SolveSettings, Solver, irradiance},
    sphere::{fibonacci_directions, uniform_direction},
    surfel::Surfel,
};
use std::f32::consts::PI;

/// The inside of a unit sphere.
struct Hollow;

impl Surface for Hollow {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        let b = origin.dot(direction);
        let root = (b * b - origin.length_squared() + 1.0).sqrt();
        let position = (origin + (root - b) * direction).normalize();
        Some(Surfel { position, normal: -position, ..Default::default() })
    }

    fn sees(&self, _: Vec3, _: Vec3) -> bool {
        true
    }

    fn reflectance(&self, _: &Surfel) -> Vec3 {
        Vec3::splat(0.5)
    }

    fn bounds(&self) -> Bounds {
        Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE }
    }
}

fn basis() -> Basis {
    let point = |d: Vec3| Surfel { position: d, normal: -d, ..Default::default() };
    let level = |l: usize| fibonacci_directions(100 << (2 * l)).into_iter().map(point).collect();
    let levels: Vec<Vec<Surfel>> = (0..3).map(level).collect();
    Basis::new(&levels, (0.7 * 4.0 * PI / 100.0_f32).sqrt(), 2).unwrap()
}

fn operator(epsilon: f32) -> (Transport, MeshlessReport) {
    transport_operator(&Hollow, &basis(), &MeshlessSettings { epsilon, ..Default::default() }, &Silent).unwrap()
}

/// RMS over random points of irradiance minus `expected`, with direct irradiance `1 + z` and half-gray surfaces.
fn error(transport: Transport, expected: f32) -> f32 {
    let bake = MeshlessBake { basis: basis(), transport };
    let senders = bake.basis.sender_points();
    let direct: Vec<Vec3> = senders.iter().map(|p| Vec3::splat(1.0 + p.position.z)).collect();
    let gray = vec![Vec3::splat(0.5); direct.len()];
    let settings = SolveSettings { bounces: 1, threshold: 0.0 };
    let coefficients = Solver::new(&bake).solve(&bake, &direct, &gray, settings).coefficients;
    let mut random = fastrand::Rng::with_seed(6);
    let squares = (0..500).map(|_| {
        let p = uniform_direction(random.f32(), random.f32());
        let vector = bake.basis.evaluate(3, p, -p, &coefficients);
        (irradiance(&vector, -p).x - expected).powi(2)
    });
    (squares.sum::<f32>() / 500.0).sqrt()
}

#[test]
fn a_bounce_inside_a_sphere_is_uniform_and_refinement_saves_links() {
    let (full, all) = operator(0.0);
    let (refined, report) = operator(0.0125);
    assert!(all.links > 2 * report.links && report.links > 0, "{all:?}\n{report:?}");
    assert_eq!(report.functions, [100, 400, 1600]);
    assert_eq!(all.gathered, report.functions, "without a threshold every receiver is examined");
    assert_eq!(report.rays_traced, 512 * report.gathered.iter().sum::<usize>() as u64);
    let of_receiver = |level: usize| report.links_of_level[level] / report.functions[level];
    assert!(of_receiver(2) < of_receiver(0) / 20, "little is left for fine receivers: {report:?}");
    let (full, refined) = (error(full, 0.5), error(refined.clone(), 0.5));
    assert!(full < 0.006 && refined < 0.03, "{full} {refined}");
    assert!(error(operator(0.0125).0, 0.55) > 0.04, "a wrong expectation shows");
}

#[test]
fn links_from_the_coarsest_senders_sum_to_the_hemisphere() {
    let (transport, _) = operator(0.0);
    let mut sums = vec![Vec3::ZERO; 100];
    let coarsest = transport.links().filter(|&(sender, receiver, _)| sender < 100 && receiver < 100);
    coarsest.for_each(|(_, receiver, vector)| sums[receiver] += vector);
    let basis = basis();
    for (point, sum) in basis.points().iter().zip(&sums) {
        assert!((*sum - PI * point.normal).length() < 0.02 * PI, "{sum} at {}", point.position);
    }
}

#[test]
fn the_operator_does_not_depend_on_threads_and_can_be_cancelled() {
    let one = on_threads(1, || operator(0.005).0);
    assert_eq!(one, on_threads(3, || operator(0.005).0));
    assert!(
        operator(0.006).0.packed().len() < one.packed().len(),
        "negative control: a larger error needs fewer links"
    );
    struct Stop;
    impl Observer for Stop {
        fn event(&self, _: Event) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let stopped = transport_operator(&Hollow, &basis(), &MeshlessSettings::default(), &Stop);
    assert!(matches!(stopped, Err(BakeError::Cancelled)));
}
