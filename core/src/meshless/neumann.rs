//! Several bounces as one operator, `S = T + T² + ...` (meshless paper, 3.2): an option for when colours are final.
//!
//! Unlike the bake and the [`Solver`] it holds the reflectance of the moment: an edited colour needs a new series. The
//! second and later bounces end at the coarsest level, and negligible links are dropped after each bounce, as in the
//! paper.
//!
//! The solver projects radiosity, what is reflected at the points. The series knows projected irradiance alone and multiplies
//! the coefficients by the reflectance at each sender's point. For the bounce of direct light this is exact only where
//! reflectance does not vary within a function.

use super::{MeshlessBake, Solver, solve::usable_reflectance, transport::signed_irradiance};
use glam::{Mat3A, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// All bounces at once: coefficients of vector irradiance from coefficients of direct irradiance.
#[derive(Clone, Debug)]
pub struct Series {
    /// For every receiver: senders, and vector irradiance from unit irradiance there, a column a channel.
    rows: Vec<Vec<(u32, Mat3A)>>,
}

impl Series {
    /// Sums `bounces` bounces with this reflectance at the points of the senders; what is not finite or negative counts as
    /// zero, and above one as one, as in [`Solver::solve`]. Links of a bounce are dropped whose
    /// norm is at most `epsilon` in every channel. `None` if `cancelled` became true.
    ///
    /// # Panics
    /// If there is not one reflectance a sender.
    pub fn new(
        bake: &MeshlessBake,
        solver: &Solver,
        reflectance: &[Vec3],
        bounces: u32,
        epsilon: f32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        assert_eq!(reflectance.len(), bake.basis.senders().len(), "one reflectance a sender");
        let reflectance: Vec<Vec3> = reflectance.iter().copied().map(usable_reflectance).collect();
        let mut rows: Vec<Vec<(u32, Mat3A)>> = vec![Vec::new(); bake.basis.len()];
        for (sender, receiver, vector) in bake.transport.links() {
            let link = channels(vector, reflectance[sender] * FRAC_1_PI);
            if norm(&link) > epsilon {
                rows[receiver].push((sender as u32, link));
            }
        }
        let column = |sender: usize| match cancelled() {
            true => None,
            false => Some(later_bounces(bake, solver, &reflectance, sender, bounces, epsilon)),
        };
        let columns: Option<Vec<_>> = (0..reflectance.len()).into_par_iter().map(column).collect();
        for (sender, column) in columns?.into_iter().enumerate() {
            for (receiver, link) in column {
                add(&mut rows[receiver], sender as u32, link);
            }
        }
        Some(Self { rows })
    }

    /// Vector irradiance of all receivers from coefficients of direct irradiance, as [`super::Projection::pull_push`] of
    /// the samples at the senders gives them.
    pub fn apply(&self, irradiance: &[Vec3]) -> Vec<Mat3A> {
        let term = |sum: Mat3A, &(sender, link): &(u32, Mat3A)| sum + scaled(link, irradiance[sender as usize]);
        self.rows.par_iter().with_min_len(512).map(|row| row.iter().fold(Mat3A::ZERO, term)).collect()
    }

    /// Number of links.
    pub fn links(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        let links = self.links() * size_of::<(u32, Mat3A)>();
        (links + size_of_val(&self.rows[..])) as u64
    }
}

/// What unit irradiance at one sender brings to the coarsest receivers in the second and later bounces.
fn later_bounces(
    bake: &MeshlessBake,
    solver: &Solver,
    reflectance: &[Vec3],
    sender: usize,
    bounces: u32,
    epsilon: f32,
) -> Vec<(usize, Mat3A)> {
    let points = bake.basis.sender_points();
    let coarsest = bake.basis.level(0).len();
    let mut radiance = vec![Vec3::ZERO; points.len()];
    radiance[sender] = reflectance[sender] * FRAC_1_PI;
    let mut received = bake.transport.apply(&radiance, 0.0, 0..points.len());
    let mut sum = vec![Mat3A::ZERO; coarsest];
    for _ in 1..bounces {
        let arriving = solver.at_senders.apply(&received);
        let outgoing = |i: usize| signed_irradiance(&arriving[i], points[i].normal) * reflectance[i] * FRAC_1_PI;
        let samples: Vec<Vec3> = (0..points.len()).map(outgoing).collect();
        received = bake.transport.apply(&solver.projection.pull_push(&samples), 0.0, 0..coarsest);
        received.iter_mut().filter(|link| norm(link) <= epsilon).for_each(|link| *link = Mat3A::ZERO);
        sum.iter_mut().zip(&received).for_each(|(sum, link)| *sum += *link);
        received.resize(points.len(), Mat3A::ZERO);
    }
    sum.into_iter().enumerate().filter(|(_, link)| *link != Mat3A::ZERO).collect()
}

fn add(row: &mut Vec<(u32, Mat3A)>, sender: u32, link: Mat3A) {
    match row.binary_search_by_key(&sender, |l| l.0) {
        Ok(at) => row[at].1 += link,
        Err(at) => row.insert(at, (sender, link)),
    }
}

fn channels(vector: Vec3, color: Vec3) -> Mat3A {
    Mat3A::from_cols((vector * color.x).into(), (vector * color.y).into(), (vector * color.z).into())
}

fn scaled(link: Mat3A, color: Vec3) -> Mat3A {
    Mat3A::from_cols(link.x_axis * color.x, link.y_axis * color.y, link.z_axis * color.z)
}

fn norm(link: &Mat3A) -> f32 {
    link.x_axis.length().max(link.y_axis.length()).max(link.z_axis.length())
}
