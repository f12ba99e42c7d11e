//! Error of one bounce at points that were not used in the bake.

use crate::prepared::{GREY, Lamp, gathered, lit};
use glam::{Mat3A, Vec3};
use lapidary_core::{
    mesh_surface::MeshSurface,
    meshless::{MeshlessBake, Projection, SenderSamples, SolveSettings, Solver, irradiance},
    surfel::Surfel,
};
use lapidary_precompute::{Candidates, Darts, Silent, poisson_disk};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Rays from each point, for the reference and for the gather.
const RAYS: usize = 1024;

/// Prints relative RMSE and ratio of means for projected direct light, a gather of it, and the operator.
pub fn print(bake: &MeshlessBake, solver: &Solver, surface: &MeshSurface, lamp: &Lamp, viewpoint: Vec3, count: usize) {
    // A coarsest function reaches 1.5 disk radii. A fourteenth of such a radius gives three quarters of the points of a fifth
    // level, whose radius is a sixteenth.
    let radius = bake.basis.radii()[0] / (1.5 * 14.0);
    let Some(points) = test_points(surface, viewpoint, radius, count) else {
        println!("no points to compare at");
        return;
    };
    let radiance = |p: &Surfel| lamp.direct(surface, p) * GREY * FRAC_1_PI;
    let test = OneBounce::new(bake, solver, surface, lamp);
    let at = |p: &Surfel| {
        let truth = gathered(surface, p, RAYS, radiance);
        let gather = gathered(surface, p, RAYS, |hit| test.sent(hit));
        [truth, gather, test.received(p), radiance(p), test.sent(p)]
    };
    let values: Vec<[f32; 5]> = points.par_iter().map(at).collect();
    println!("one bounce at {} points, relative RMSE and ratio of means:", points.len());
    for (what, test, truth) in [
        ("projected direct light against direct light", 4, 3),
        ("gather of projected light against rays", 1, 0),
        ("operator against gather of projected light", 2, 1),
        ("operator against rays", 2, 0),
    ] {
        let pairs: Vec<(f32, f32)> = values.iter().map(|v| (v[truth], v[test])).collect();
        println!("  {what}: {}", Comparison::of(&pairs));
    }
}

/// Projected direct light and its first bounce at a point.
struct OneBounce<'a> {
    bake: &'a MeshlessBake,
    sent: Vec<f32>,
    received: Vec<Mat3A>,
}

impl<'a> OneBounce<'a> {
    fn new(bake: &'a MeshlessBake, solver: &Solver, surface: &MeshSurface, lamp: &Lamp) -> Self {
        let (irradiance, gray) = lit(&SenderSamples::on_surface(&bake.basis, solver, surface), solver, surface, lamp);
        let outgoing: Vec<f32> = irradiance.iter().map(|e| e.x * GREY * FRAC_1_PI).collect();
        let projection = Projection::new(&bake.basis, bake.basis.sender_levels());
        let once = SolveSettings { bounces: 1, ..Default::default() };
        let received = solver.solve(bake, &irradiance, &gray, once).coefficients;
        Self { bake, sent: projection.pull_push(&outgoing), received }
    }

    fn sent(&self, at: &Surfel) -> f32 {
        self.bake.basis.evaluate(self.bake.basis.sender_levels(), at.position, at.normal, &self.sent)
    }

    fn received(&self, at: &Surfel) -> f32 {
        let vector = self.bake.basis.evaluate(self.bake.basis.levels(), at.position, at.normal, &self.received);
        irradiance(&vector, at.normal).x
    }
}

/// Points of a Poisson-disk set that no bake uses, spread evenly over all reachable surfaces, including small ones.
fn test_points(surface: &MeshSurface, viewpoint: Vec3, radius: f32, count: usize) -> Option<Vec<Surfel>> {
    const SEED: u64 = 77;
    const SET: usize = 20_000;
    let mut candidates = Candidates::new(surface, viewpoint, SEED, &Silent).ok()?;
    let points = poisson_disk(&mut candidates, Darts { radius, open_only: false, most: SET }, |_| ()).ok()?;
    let step = (points.len() / count.max(1)).max(1);
    Some(points.into_iter().step_by(step).collect()).filter(|points: &Vec<_>| !points.is_empty())
}

/// Error of estimates.
pub struct Comparison {
    error: f32,
    ratio: f32,
    /// Share of the squared error in the worst twentieth.
    worst: f32,
}

impl Comparison {
    /// From pairs of reference and estimate.
    pub fn of(pairs: &[(f32, f32)]) -> Self {
        let sum = |f: &dyn Fn(&(f32, f32)) -> f32| pairs.iter().map(f).sum::<f32>();
        let mut squares: Vec<f32> = pairs.iter().map(|(truth, estimate)| (truth - estimate).powi(2)).collect();
        squares.sort_unstable_by(|a, b| b.total_cmp(a));
        let total: f32 = squares.iter().sum();
        let worst: f32 = squares[..pairs.len().div_ceil(20)].iter().sum();
        Self {
            error: (total / sum(&|p| p.0 * p.0)).sqrt(),
            ratio: sum(&|p| p.1) / sum(&|p| p.0),
            worst: worst / total.max(f32::MIN_POSITIVE),
        }
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { error, ratio, worst } = self;
        write!(f, "{error:.4}, {ratio:.4} (worst twentieth of the points: {:.0} % of the squared error)", 100.0 * worst)
    }
}
