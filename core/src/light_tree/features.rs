//! Clustering metrics as Euclidean distances between feature vectors (paper, Eq. 10 to 12).
//!
//! There are two departures. The visibility vectors are projected to [`PROJECTED`] random dimensions, which keeps distances to
//! within some percent. A measured constant balances the two metrics: the paper normalizes Eq. 11 by the squared solid angle of a
//! light, which makes it some 10^6 times smaller than Eq. 10, so a literal mixed tree equals the geometric one.

use super::TreeKind;
use crate::surfel::Surfel;
use glam::Vec3;
use rayon::prelude::*;

/// Number of dimensions after the projection of pilot visibility vectors.
const PROJECTED: usize = 48;

/// Squared visibility distance (mean over clusters) that weighs as much as a squared distance of one between
/// directions.
///
/// Measured on the armadillo scene at `beta` 0.5, 32,768 lights, `sigma` 2: mean cuts 203, 195, 178, 160, 161, 161 for scales 0.1,
/// 0.3, 1, 3, 10, 100 (geometric: 216). Nodes of level 8 are wider than in the geometric tree by 14 % at scale 3, 30 % at 10, and
/// 70 % at 100. Wide nodes make long illumination cuts, so the smallest scale with the full gain is best.
const VISIBILITY_SCALE: f32 = 3.0;

/// Weight of position against normal (`K` of Eq. 10; Hašan et al. 2006), for a scene of unit diagonal.
const PLACE_WEIGHT: f32 = 30.0;

/// [`VISIBILITY_SCALE`] for surface sources.
const SOURCE_VISIBILITY_SCALE: f32 = 50.0;

/// Pilot visibility: the fraction of each vertex cluster that sees each light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PilotVisibility {
    /// Number of light samples.
    pub lights: usize,
    /// Visible fraction in units of 1/255, cluster by cluster: `clusters * lights` values.
    pub fractions: Vec<u8>,
}

impl PilotVisibility {
    /// Number of vertex clusters, `M`.
    pub fn clusters(&self) -> usize {
        self.fractions.len() / self.lights
    }
}

/// One feature vector per sample.
#[derive(Clone, Debug)]
pub struct Features {
    dimensions: usize,
    /// `len * dimensions` values, sample by sample.
    values: Vec<f32>,
}

impl Features {
    /// Feature vectors of `dimensions` components each, sample by sample.
    pub fn new(dimensions: usize, values: Vec<f32>) -> Self {
        assert_eq!(values.len() % dimensions, 0, "whole feature vectors");
        Self { dimensions, values }
    }

    /// Features of the geometric metric (Eq. 10). A distant sample's normal points back along its direction, so both
    /// terms of the equation are proportional to one distance.
    pub fn geometric(directions: &[Vec3]) -> Self {
        Self::new(3, directions.iter().flat_map(|d| d.to_array()).collect())
    }

    /// Features of the metric `kind`; `beta` is the weight of the geometric part of a mixed metric (Eq. 12).
    pub fn of_kind(kind: TreeKind, beta: f32, directions: &[Vec3], pilot: &PilotVisibility) -> Self {
        match kind {
            TreeKind::Geometric => Self::geometric(directions),
            TreeKind::DataDriven => Self::mixed(&rows(directions), pilot, 0.0, VISIBILITY_SCALE),
            TreeKind::Mixed => Self::mixed(&rows(directions), pilot, beta, VISIBILITY_SCALE),
        }
    }

    /// Features of surface sources: position in units of the scene's `diagonal` over `PLACE_WEIGHT`, and normal.
    pub fn of_surfels(kind: TreeKind, beta: f32, surfels: &[Surfel], diagonal: f32, pilot: &PilotVisibility) -> Self {
        let scale = PLACE_WEIGHT / diagonal.max(f32::MIN_POSITIVE);
        let row = |s: &Surfel| -> [f32; 6] {
            let (x, n) = (s.position * scale, s.normal);
            [x.x, x.y, x.z, n.x, n.y, n.z]
        };
        let rows: Vec<[f32; 6]> = surfels.iter().map(row).collect();
        match kind {
            TreeKind::Geometric => Self::new(6, rows.concat()),
            TreeKind::DataDriven => Self::mixed(&rows, pilot, 0.0, SOURCE_VISIBILITY_SCALE),
            TreeKind::Mixed => Self::mixed(&rows, pilot, beta, SOURCE_VISIBILITY_SCALE),
        }
    }

    /// Geometric features of `G` components, and projected visibility scaled so that a squared distance of `scale`
    /// counts as one.
    fn mixed<const G: usize>(rows: &[[f32; G]], pilot: &PilotVisibility, beta: f32, scale: f32) -> Self {
        let projection = random_projection(pilot.clusters());
        let geometric = beta.sqrt();
        let visibility = ((1.0 - beta) * scale / pilot.clusters().max(1) as f32).sqrt() / 255.0;
        let row = |(s, g): (usize, &[f32; G])| {
            let seen = project(pilot, s, &projection).map(|x| x * visibility);
            g.map(|x| x * geometric).into_iter().chain(seen)
        };
        let values = rows.par_iter().enumerate().flat_map_iter(row).collect();
        Self::new(G + PROJECTED, values)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.values.len() / self.dimensions
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Length of a feature vector.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The feature vector of a sample.
    pub fn row(&self, sample: u32) -> &[f32] {
        let start = sample as usize * self.dimensions;
        &self.values[start..start + self.dimensions]
    }
}

fn rows(directions: &[Vec3]) -> Vec<[f32; 3]> {
    directions.iter().map(Vec3::to_array).collect()
}

/// Rows of random signs (Achlioptas 2003), scaled to keep expected squared lengths.
fn random_projection(clusters: usize) -> Vec<[f32; PROJECTED]> {
    let mut rng = fastrand::Rng::with_seed(0x6c61_7069_6461_7279);
    let unit = 1.0 / (PROJECTED as f32).sqrt();
    (0..clusters).map(|_| std::array::from_fn(|_| if rng.bool() { unit } else { -unit })).collect()
}

fn project(pilot: &PilotVisibility, sample: usize, projection: &[[f32; PROJECTED]]) -> [f32; PROJECTED] {
    let mut out = [0.0; PROJECTED];
    for (cluster, signs) in projection.iter().enumerate() {
        let seen = f32::from(pilot.fractions[cluster * pilot.lights + sample]);
        for (o, s) in out.iter_mut().zip(signs) {
            *o += seen * s;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    fn distance_sq(f: &Features, a: u32, b: u32) -> f32 {
        f.row(a).iter().zip(f.row(b)).map(|(x, y)| (x - y).powi(2)).sum()
    }

    #[test]
    fn projection_keeps_visibility_distances() {
        let lights = 32;
        let mut rng = fastrand::Rng::with_seed(1);
        let fractions: Vec<u8> = (0..lights * 512).map(|_| if rng.bool() { 255 } else { 0 }).collect();
        let pilot = PilotVisibility { lights, fractions };
        let features = Features::of_kind(TreeKind::DataDriven, 0.5, &fibonacci_directions(lights), &pilot);
        let exact = |a: usize, b: usize| -> f32 {
            let at = |c: usize, l: usize| f32::from(pilot.fractions[c * lights + l]) / 255.0;
            (0..512).map(|c| (at(c, a) - at(c, b)).powi(2)).sum::<f32>() / 512.0
        };
        let pairs: Vec<(usize, usize)> = (0..lights).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
        let ratio =
            |&(a, b): &(usize, usize)| distance_sq(&features, a as u32, b as u32) / (VISIBILITY_SCALE * exact(a, b));
        let mean = pairs.iter().map(ratio).sum::<f32>() / pairs.len() as f32;
        assert!((mean - 1.0).abs() < 0.1, "mean ratio of squared distances {mean}");
    }

    #[test]
    fn mixed_features_add_both_distances() {
        let directions = fibonacci_directions(8);
        let pilot = PilotVisibility { lights: 8, fractions: vec![0; 8 * 4] };
        let features = Features::of_kind(TreeKind::Mixed, 0.25, &directions, &pilot);
        let expected = 0.25 * directions[0].distance_squared(directions[5]);
        assert!((distance_sq(&features, 0, 5) - expected).abs() < 1e-6);
    }
}
