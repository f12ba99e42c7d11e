//! Solves indirect light from direct light, whenever a light moves or a color changes (meshless paper, 3.3).
//!
//! Reflectance is applied only here. Radiosity is sampled at the points of the senders, projected, and sent once
//! through the operator. The light that arrives at the senders is sent again, bounce by bounce. Projecting radiosity
//! rather than irradiance makes a coarse sender carry the mean radiosity below it, not the color of its point.
//!
//! Intermediate bounces are gathered by the functions of the sender levels alone, because senders carry nothing finer. The sum of
//! all sent light then reaches the finer receivers at once. The paper ends the second and later bounces at the coarsest level.

use super::{MeshlessBake, Transport, flatten::Flattening, projection::Projection, transport::irradiance};
use crate::transport::{BounceEnergy, LightTransport, Series, Surfaces};
use glam::{Mat3A, Vec3};
use rayon::prelude::*;
use std::{f32::consts::FRAC_1_PI, ops::Range};

/// Number of bounces and threshold of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveSettings {
    /// Indirect bounces, 1 to [`Self::MOST_BOUNCES`].
    pub bounces: u32,
    /// Senders are skipped if their coefficient is at most this share of the mean over all senders. (The largest would
    /// be no measure: a lamp close to a surface makes one far larger than all others.)
    pub threshold: f32,
}

impl SolveSettings {
    /// In a closed room of reflectance one the light of bounces never decreases. This many suffice for a reflectance of
    /// 0.9, where the 64th bounce carries a thousandth of the first.
    pub const MOST_BOUNCES: u32 = 64;

    /// The paper's four bounces. The paper's threshold is 0.025 of the light's unit; this one causes no visible error.
    pub const DEFAULT: Self = Self { bounces: 4, threshold: 1e-2 };
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Indirect light as coefficients of the basis.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Vector irradiance in W/m², one per function, one column per color channel.
    pub coefficients: Vec<Mat3A>,
    /// Mean irradiance over the surface, in W/m² per channel: of direct light, then of each bounce. It is taken at the
    /// points of the finest senders, weighted by the areas of their functions, because points are denser at edges and
    /// on small objects. So it is proportional to the arriving energy.
    pub mean_irradiance: Vec<Vec3>,
}

impl Solution {
    /// Light per bounce.
    pub fn energy(&self) -> BounceEnergy {
        BounceEnergy::of(&self.mean_irradiance)
    }
}

/// Data for solving in addition to the bake, computed once per bake.
#[derive(Clone, Debug)]
pub struct Solver {
    pub(super) projection: Projection,
    at_senders: Flattening,
    /// Normals at which the points of the senders receive.
    normals: Vec<Vec3>,
}

impl Solver {
    /// A solver for points that receive light at their own normals.
    pub fn new(bake: &MeshlessBake) -> Self {
        Self::receiving_by(bake, bake.basis.sender_points().iter().map(|p| p.normal).collect())
    }

    /// A solver for points of senders that receive light at other unit normals, such as smooth shading normals.
    ///
    /// # Panics
    /// If there is not one normal per sender.
    pub fn receiving_by(bake: &MeshlessBake, normals: Vec<Vec3>) -> Self {
        assert_eq!(normals.len(), bake.basis.sender_points().len(), "one normal per sender");
        let points: Vec<_> = bake.basis.sender_points().iter().map(|p| (p.position, p.normal)).collect();
        let levels = bake.basis.sender_levels();
        Self {
            projection: Projection::new(&bake.basis, levels),
            at_senders: Flattening::of_levels(&bake.basis, &bake.transport, levels, &points),
            normals,
        }
    }

    /// Indirect light from direct light: `irradiance` in W/m² and diffuse `reflectance` of the senders, per channel,
    /// either at their points or as [`super::SenderSamples`] fits them. Values that are not finite count as zero, and
    /// reflectance is clamped to 0 to 1.
    ///
    /// # Panics
    /// If there is not one of each per sender, or if the bake is not the solver's.
    pub fn solve(
        &self,
        bake: &MeshlessBake,
        irradiance: &[Vec3],
        reflectance: &[Vec3],
        settings: SolveSettings,
    ) -> Solution {
        self.solve_with_emission(bake, irradiance, reflectance, &vec![Vec3::ZERO; irradiance.len()], settings)
    }

    /// [`Self::solve`] with senders that also emit radiance, `emission` in W/(m² sr).
    ///
    /// # Panics
    /// See [`Self::solve`].
    pub fn solve_with_emission(
        &self,
        bake: &MeshlessBake,
        irradiance: &[Vec3],
        reflectance: &[Vec3],
        emission: &[Vec3],
        settings: SolveSettings,
    ) -> Solution {
        let points = bake.basis.sender_points();
        assert_eq!(emission.len(), points.len(), "one value per sender");
        assert!(irradiance.len() == points.len() && reflectance.len() == points.len(), "one value per sender");
        let direct = irradiance.iter().copied().map(finite).collect();
        let emitted = self.projection.pull_push(&emission.iter().copied().map(usable).collect::<Vec<_>>());
        let transport = BrightSenders { transport: &bake.transport, threshold: settings.threshold };
        let surfaces = SenderSurfaces { solver: self, bake, reflectance };
        let series = Series::new(&transport, &surfaces, direct, Some(emitted))
            .with_bounces(settings.bounces.clamp(1, SolveSettings::MOST_BOUNCES));
        let Series { received: mut coefficients, sent, mean_irradiance, .. } = series;
        coefficients.extend(transport.bounce(&sent, points.len()..bake.basis.len()));
        Solution { coefficients, mean_irradiance }
    }

    /// Coefficients of outgoing radiance, `ρ E / π`, averaged from fine to coarse.
    fn radiance(&self, irradiance: &[Vec3], reflectance: &[Vec3]) -> Vec<Vec3> {
        let outgoing = |(e, rho): (&Vec3, &Vec3)| *e * usable_reflectance(*rho) * FRAC_1_PI;
        let samples: Vec<Vec3> = irradiance.iter().zip(reflectance).map(outgoing).collect();
        self.projection.pull_push(&samples)
    }

    /// Radiance that the points of the senders send after all bounces of a solution, in W/(m² sr): what they reflect of direct light
    /// and of the bounces, and what they emit. Arguments are those of [`Self::solve_with_emission`].
    pub fn sent(&self, solution: &Solution, irradiance: &[Vec3], reflectance: &[Vec3], emission: &[Vec3]) -> Vec<Vec3> {
        let bounced = self.arriving(&solution.coefficients[..irradiance.len()]);
        let received =
            irradiance.iter().zip(&bounced).map(|(&direct, &bounced)| finite(direct) + bounced.max(Vec3::ZERO));
        let surfaces = reflectance.iter().zip(emission);
        let sent = |(received, (&rho, &emitted)): (Vec3, (&Vec3, &Vec3))| {
            received * usable_reflectance(rho) * FRAC_1_PI + usable(emitted)
        };
        received.zip(surfaces).map(sent).collect()
    }

    /// Irradiance at the points of the senders from coefficients of their levels.
    fn arriving(&self, received: &[Mat3A]) -> Vec<Vec3> {
        let at_points = self.at_senders.apply(received);
        at_points.par_iter().zip(&self.normals).with_min_len(512).map(|(v, &normal)| irradiance(v, normal)).collect()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        self.projection.bytes() + self.at_senders.bytes() + size_of_val(&self.normals[..]) as u64
    }
}

/// The operator restricted to senders above the threshold.
struct BrightSenders<'a> {
    transport: &'a Transport,
    /// See [`SolveSettings::threshold`].
    threshold: f32,
}

impl LightTransport for BrightSenders<'_> {
    type Sent = Vec3;
    type Received = Mat3A;

    fn senders(&self) -> usize {
        self.transport.senders()
    }

    fn bounce(&self, sent: &[Vec3], receivers: Range<usize>) -> Vec<Mat3A> {
        let sum: f32 = sent.iter().map(|r| r.abs().max_element()).sum();
        let threshold = self.threshold * sum / sent.len().max(1) as f32;
        self.transport.apply(sent, threshold, receivers)
    }
}

/// The surfaces at the senders.
struct SenderSurfaces<'a> {
    solver: &'a Solver,
    bake: &'a MeshlessBake,
    reflectance: &'a [Vec3],
}

impl Surfaces<BrightSenders<'_>> for SenderSurfaces<'_> {
    /// Irradiance at the points of the senders.
    type Arriving = Vec<Vec3>;

    fn arriving(&self, received: Vec<Mat3A>) -> Vec<Vec3> {
        self.solver.arriving(&received)
    }

    fn reflected(&self, irradiance: &Vec<Vec3>) -> Vec<Vec3> {
        self.solver.radiance(irradiance, self.reflectance)
    }

    fn mean_irradiance(&self, irradiance: &Vec<Vec3>) -> Vec3 {
        let basis = &self.bake.basis;
        let finest = basis.level(basis.sender_levels() - 1);
        let areas = &self.solver.projection.areas()[finest.clone()];
        let energy: Vec3 = irradiance[finest].iter().zip(areas).map(|(e, &area)| *e * area).sum();
        energy / areas.iter().sum::<f32>().max(f32::MIN_POSITIVE)
    }
}

/// Reflectance clamped to 0 to 1 per channel; 0 if not finite.
pub(super) fn usable_reflectance(rho: Vec3) -> Vec3 {
    usable(rho).min(Vec3::ONE)
}

pub(super) fn usable(v: Vec3) -> Vec3 {
    finite(v).max(Vec3::ZERO)
}

fn finite(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        meshless::{Basis, Transport},
        surfel::Surfel,
    };
    use std::f32::consts::PI;

    #[test]
    fn means_are_over_area_and_not_over_points() {
        let at = |x: f32, z: f32| Surfel { position: Vec3::new(x, 0.0, z), ..Default::default() };
        // One coarse function above nine finer ones, and another above one.
        let mut fine: Vec<Surfel> =
            (0..9).map(|i| at(0.1 * (i % 3) as f32 - 0.1, 0.1 * (i / 3) as f32 - 0.1)).collect();
        fine.push(at(10.0, 0.0));
        let points = [vec![at(0.0, 0.0), at(10.0, 0.0)], fine].concat();
        let basis = Basis::from_parts(points, vec![0, 2, 12], vec![1.0, 0.15], 1).unwrap();
        let transport = Transport::from_rows(&vec![Vec::new(); 12], 2);
        let bake = MeshlessBake { basis, transport };
        let solver = Solver::new(&bake);
        let mean = |direct: [Vec3; 2]| {
            solver.solve(&bake, &direct, &[Vec3::ONE; 2], SolveSettings::default()).mean_irradiance[0]
        };
        assert!((mean([Vec3::ONE, Vec3::ZERO]) - 0.9).abs().max_element() < 1e-5);
        assert!((mean([Vec3::ZERO, Vec3::X]) - Vec3::X * 0.1).abs().max_element() < 1e-5);
        assert!((mean([Vec3::ONE; 2]) - 1.0).abs().max_element() < 1e-6);
    }

    #[test]
    fn bounces_arrive_by_the_normals_that_are_given() {
        let at = |x: f32| Surfel { position: Vec3::X * x, ..Default::default() };
        let basis = Basis::new(&[vec![at(0.0), at(10.0)]], 1.0, 1).unwrap();
        let vector = Vec3::new(0.8, 0.5, 0.0);
        let transport = Transport::from_rows(&[Vec::new(), vec![(0, vector)]], 2);
        let bake = MeshlessBake { basis, transport };
        let arrived = |solver: Solver| {
            let found = solver.solve(&bake, &[Vec3::splat(PI), Vec3::ZERO], &[Vec3::ONE; 2], SolveSettings::default());
            2.0 * found.mean_irradiance[1].x
        };
        assert!((arrived(Solver::new(&bake)) - 0.5).abs() < 1e-4);
        let tilted = Vec3::new(0.6, 0.8, 0.0);
        let by_tilted = arrived(Solver::receiving_by(&bake, vec![Vec3::Y, tilted]));
        assert!((by_tilted - vector.dot(tilted)).abs() < 1e-4, "{by_tilted}");
    }
}
