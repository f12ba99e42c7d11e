//! Nodes of a tree of lights, laid out so that any eight can be read at once.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lapidary_core::{
    brdf::LobeMomentsX8,
    simd::{Lanes, Vec3x8},
};
use rayon::prelude::*;
use wide::f32x8;

/// Properties that a pixel reads of a summed node: 32 bytes, half a cache line.
///
/// Eight rows are two loads each and a transposition in registers. With one array per property, each number was a load and a
/// shuffle.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct NodeRow {
    /// Bytes 0 to 11: unit direction, or position in meters.
    pub place: Vec3,
    /// Bytes 12 to 15: spread of the light, as an inverse concentration or as a radius in meters.
    pub spread: f32,
    /// Bytes 16 to 27: mean radiance.
    pub radiance: Vec3,
    /// Bytes 28 to 31: length of the mean direction at that inverse concentration.
    pub resultant: f32,
}

/// Properties that refinement reads besides the place: 8 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeExtent {
    /// Half-angle in radians of the cone of directions, or radius in meters.
    pub radius: f32,
    /// Brightness relative to the mean of the whole tree, at least 1: the root mean square of the leaves' intensities. A lobe that
    /// barely covers a node still shows it, in proportion to its light.
    pub brightness: f32,
}

/// Eight nodes, property by property.
pub(crate) struct EightNodes<L> {
    /// Places; see [`NodeRow`].
    pub place: Vec3x8<L>,
    /// Spreads.
    pub spread: L,
    /// Mean radiances.
    pub radiance: Vec3x8<L>,
    /// Lengths of mean directions.
    pub resultant: L,
}

impl NodeRow {
    /// Rows of all nodes, from one array per property.
    pub fn of_all(places: &[Vec3], spreads: &[f32], radiance: &[Vec3]) -> Vec<Self> {
        let resultants = resultants(spreads);
        let row = |i| Self { place: places[i], spread: spreads[i], radiance: radiance[i], resultant: resultants[i] };
        (0..places.len()).into_par_iter().with_min_len(1024).map(row).collect()
    }

    /// Gathers eight of `rows`.
    #[inline(always)]
    pub fn eight<L: Lanes>(rows: &[Self], nodes: [usize; 8]) -> EightNodes<L> {
        let mut eight = [&[0.0; 8]; 8];
        for (row, node) in eight.iter_mut().zip(nodes) {
            *row = bytemuck::cast_ref(&rows[node]);
        }
        let [px, py, pz, spread, rx, ry, rz, resultant] = L::transposed(eight);
        let (place, radiance) = (Vec3x8 { x: px, y: py, z: pz }, Vec3x8 { x: rx, y: ry, z: rz });
        EightNodes { place, spread, radiance, resultant }
    }
}

impl NodeExtent {
    /// Extents of all nodes, from their radii and the means of their leaves' intensities and squared intensities.
    pub fn of_all(radii: &[f32], means: &[f32], means_sq: &[f32]) -> Vec<Self> {
        let extent = |(&radius, sq): (&f32, &f32)| {
            let ratio = sq.sqrt() / means[1];
            Self { radius, brightness: if ratio.is_finite() { ratio.max(1.0) } else { 1.0 } }
        };
        radii.iter().zip(means_sq).map(extent).collect()
    }

    /// Radii and brightnesses of eight of `extents`.
    #[inline(always)]
    pub fn eight<L: Lanes>(extents: &[Self], nodes: [usize; 8]) -> [L; 2] {
        let (mut radii, mut brightness) = ([0.0; 8], [0.0; 8]);
        for ((radius, brightness), node) in radii.iter_mut().zip(&mut brightness).zip(nodes) {
            (*radius, *brightness) = (extents[node].radius, extents[node].brightness);
        }
        [L::new(radii), L::new(brightness)]
    }
}

/// Lengths of the mean directions of lights of these inverse concentrations.
fn resultants(inv_kappas: &[f32]) -> Vec<f32> {
    let eight = |inv_kappas: &[f32]| {
        let mut padded = [0.0; 8];
        padded[..inv_kappas.len()].copy_from_slice(inv_kappas);
        LobeMomentsX8::new(f32x8::new(padded)).resultant().to_array()
    };
    let all: Vec<[f32; 8]> = inv_kappas.par_chunks(8).with_min_len(128).map(eight).collect();
    let mut resultants = all.into_flattened();
    resultants.truncate(inv_kappas.len());
    resultants
}
