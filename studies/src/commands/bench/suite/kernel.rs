//! A fixed piece of work that figures are measured in: like shading a picture, it merges two cuts at every pixel,
//! evaluates a GGX lobe at the nodes, and reads their radiance from a table larger than the caches of a core.
//!
//! It shares no code with the renderer, so that a change of the renderer moves the figures and not their unit. A change of
//! this file changes the unit: raise [`VERSION`] with it, and take the baseline anew.

use glam::Vec3;
use rayon::prelude::*;
use std::{
    f32::consts::{FRAC_1_PI, TAU},
    hint::black_box,
    time::{Duration, Instant},
};

/// Number of the unit; baselines of another one cannot be compared.
pub const VERSION: u32 = 1;

/// Pixels that take about 0.3 s on two cores.
pub const PIXELS: u32 = 32_000;

/// Leaves of the tree.
const LEAVES: u32 = 1 << 15;
/// Cuts, from which each pixel merges two.
const CUTS: u32 = 64;
/// Nodes of the table of radiance, 16 MB.
const TABLE: u32 = 1 << 20;
/// Square of the lobe's alpha.
const ALPHA_SQ: f32 = 0.04;
/// Reflectance at normal incidence.
const F0: f32 = 0.04;

/// The work, with what it reads.
pub struct Kernel {
    /// One past the last leaf of each node, cut by cut.
    cuts: Vec<Vec<u32>>,
    radiance: Vec<[f32; 4]>,
    directions: Vec<Vec3>,
    pixels: u32,
}

impl Kernel {
    /// For a number of pixels.
    pub fn new(pixels: u32) -> Self {
        let radiance = (0..TABLE).map(|i| [0, 1, 2, 3].map(|c| unit(4 * i + c))).collect();
        let directions = (0..LEAVES).map(direction).collect();
        Self { cuts: (0..CUTS).map(cut).collect(), radiance, directions, pixels }
    }

    /// How long it takes on all cores.
    pub fn time(&self) -> Duration {
        let start = Instant::now();
        black_box((0..self.pixels).into_par_iter().map(|pixel| self.pixel(pixel)).sum::<f32>());
        start.elapsed()
    }

    /// Reflected radiance of a pixel.
    fn pixel(&self, pixel: u32) -> f32 {
        let cuts = [hash(pixel), hash(pixel + 1)].map(|h| &*self.cuts[(h % CUTS) as usize]);
        let wo = direction(hash(pixel) % LEAVES);
        let (mut positions, mut first, mut sum) = ([0, 0], 0, 0.0);
        while first < LEAVES {
            let ends = [0, 1].map(|i| cuts[i][positions[i]]);
            let end = ends[0].min(ends[1]);
            let node = hash(first ^ end.rotate_left(16) ^ pixel) % TABLE;
            let [r, g, b, visible] = self.radiance[node as usize];
            let wi = self.directions[((first + end) / 2) as usize];
            sum += ggx(wi, wo) * visible * (0.2126 * r + 0.7152 * g + 0.0722 * b) * (end - first) as f32;
            (0..2).for_each(|i| positions[i] += usize::from(ends[i] == end));
            first = end;
        }
        sum * TAU / LEAVES as f32
    }
}

/// A well mixed number for each number.
fn hash(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// From 0 to 1.
fn unit(i: u32) -> f32 {
    hash(i) as f32 * (1.0 / u32::MAX as f32)
}

/// A direction of the upper hemisphere.
fn direction(i: u32) -> Vec3 {
    let (z, angle) = (unit(2 * i), TAU * unit(2 * i + 1));
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * angle.cos(), r * angle.sin(), z)
}

/// Ends of the nodes of a cut: subtrees are halved while chance has it, 200 nodes in the mean.
fn cut(number: u32) -> Vec<u32> {
    let (mut ends, mut open) = (Vec::new(), vec![(0, LEAVES)]);
    while let Some((first, end)) = open.pop() {
        let size = end - first;
        let wide = size > LEAVES / 64;
        if wide || size > 64 && unit(hash(first ^ number << 16) ^ size) < 0.6 {
            open.extend([(first + size / 2, end), (first, first + size / 2)]);
        } else {
            ends.push(end);
        }
    }
    ends
}

/// Reflected radiance per radiance and solid angle about the normal +Z.
fn ggx(wi: Vec3, wo: Vec3) -> f32 {
    let half = (wi + wo).normalize();
    let fresnel = F0 + (1.0 - F0) * (1.0 - wi.dot(half)).powi(5);
    let d = half.z * half.z * (ALPHA_SQ - 1.0) + 1.0;
    let smith = |a: Vec3, b: Vec3| a.z * (ALPHA_SQ + (1.0 - ALPHA_SQ) * b.z * b.z).sqrt();
    let masking = 0.5 / (smith(wi, wo) + smith(wo, wi)).max(1e-6);
    fresnel * ALPHA_SQ * FRAC_1_PI / (d * d) * masking * wi.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_is_what_it_was() {
        let kernel = Kernel::new(8);
        let nodes: usize = kernel.cuts.iter().map(Vec::len).sum();
        let sum: f32 = (0..8).map(|pixel| kernel.pixel(pixel)).sum();
        let as_it_was = nodes == 12_864 && (sum - 0.216_709).abs() < 1e-5;
        assert!(as_it_was, "a change of the kernel needs another VERSION and a new baseline: {nodes} {sum}");
    }

    #[test]
    fn cuts_end_at_the_last_leaf() {
        for number in 0..CUTS {
            let ends = cut(number);
            assert!(ends.is_sorted_by(|a, b| a < b) && ends.last() == Some(&LEAVES), "{ends:?}");
        }
    }
}
