//! Samples of the kernel of transport between two parts of patches, and the decision to refine them (wavelet paper, Eq. 4 and 4.3.2).

use glam::{Vec2, Vec3};
use lapidary_core::{
    ray::Intersector,
    wavelet::{reflecting::ReflectingPatch, square::Node},
};

/// Samples of each pair of nodes.
pub const SAMPLES: u32 = 32;

/// Two patches with the scene between them.
pub struct Pair<'a> {
    pub receiver: &'a ReflectingPatch,
    pub sender: &'a ReflectingPatch,
    pub rays: &'a Intersector,
    /// Distance of the ends of rays from surfaces, in meters.
    pub offset: f32,
    /// Seed of the samples.
    pub seed: u32,
}

/// The kernel between a point of the receiver and one of the sender.
pub struct KernelSample {
    /// Point of the receiver.
    pub at: Vec3,
    /// Direction from the receiver to the sender, as a point of the receiver's square of directions.
    pub arrives: Vec2,
    /// Both cosines over the squared distance, whatever stands between, in 1/m². Zero where a side faces away.
    pub unblocked: f32,
    /// Mean BRDF of the sender toward the receiver over each of its cells of directions; empty where the points do not see each other.
    pub reflected: Vec<Vec3>,
}

impl KernelSample {
    /// Whether the points see each other.
    pub fn is_seen(&self) -> bool {
        !self.reflected.is_empty()
    }
}

impl Pair<'_> {
    /// Kernel samples at quasi-random points of two nodes.
    pub fn samples(&self, receiver: Node, sender: Node) -> Vec<KernelSample> {
        let seed = self.seed ^ scrambled(receiver, sender);
        let sample = |i: u32| {
            let [x, y, z, w] = sobol_burley::sample_4d(i, 0, seed);
            let [u, v, ..] = sobol_burley::sample_4d(i, 1, seed);
            let at = self.receiver.patch.point(receiver.point(Vec2::new(x, y)));
            let from = self.sender.patch.point(sender.point(Vec2::new(z, w)));
            self.between(at, from, Vec2::new(u, v))
        };
        (0..SAMPLES).map(sample).collect()
    }

    /// The kernel between two points; `place` tells where in each cell of directions the BRDF is sampled.
    fn between(&self, at: Vec3, from: Vec3, place: Vec2) -> KernelSample {
        let (receiver, sender) = (&self.receiver.patch, &self.sender.patch);
        let to_sender = from - at;
        let distance_sq = to_sender.length_squared();
        let direction = to_sender / distance_sq.sqrt();
        let cosines = [direction.dot(receiver.normal()), -direction.dot(sender.normal())];
        let is_facing = cosines[0] > 0.0 && cosines[1] > 0.0;
        let ends = [at + receiver.normal() * self.offset, from + sender.normal() * self.offset];
        let is_seen = is_facing && !self.rays.occluded_between(ends[0], ends[1]);
        KernelSample {
            at,
            arrives: receiver.square_of_direction(direction),
            unblocked: if is_facing { cosines[0] * cosines[1] / distance_sq } else { 0.0 },
            reflected: if is_seen { self.sender.reflected(-direction, place) } else { Vec::new() },
        }
    }
}

/// Largest difference of the kernel between two samples, in 1/m² (4.3.2): its mean over the cells of directions, as all of them may
/// get light.
pub fn deviation(samples: &[KernelSample], cells: usize) -> f32 {
    let of_cell = |cell: usize| {
        let value = |sample: &KernelSample| {
            sample.reflected.get(cell).map_or(0.0, |reflected| sample.unblocked * reflected.max_element())
        };
        let range = |(least, most): (f32, f32), value: f32| (least.min(value), most.max(value));
        let (least, most) = samples.iter().map(value).fold((f32::INFINITY, 0.0), range);
        most - least
    };
    (0..cells).map(of_cell).sum::<f32>() / cells as f32
}

fn scrambled(receiver: Node, sender: Node) -> u32 {
    let of = |node: Node| (node.level() << 28) ^ (node.cell().x << 14) ^ node.cell().y;
    of(receiver).wrapping_mul(0x9E37_79B9) ^ of(sender).wrapping_mul(0x85EB_CA6B).rotate_left(16)
}
