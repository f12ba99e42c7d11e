//! Nodes of a tree of lights, laid out for reading eight that lie anywhere.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lapidary_core::simd::{Lanes, Vec3x8};

/// What a pixel reads of a node: 32 bytes, half a line of the cache.
///
/// Eight rows are two loads each and a transposition in registers. From an array a property, each number was a load and
/// a shuffle of its own.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct NodeRow {
    /// Bytes 0 to 11: unit direction, or position in metres.
    pub place: Vec3,
    /// Bytes 12 to 15: spread of the light, as an inverse concentration or as a radius in metres.
    pub spread: f32,
    /// Bytes 16 to 27: mean radiance.
    pub radiance: Vec3,
    /// Bytes 28 to 31: how bright the node is somewhere, see [`brightness`](crate::light::brightness).
    pub brightness: f32,
}

/// Eight nodes, property by property.
pub(crate) struct EightNodes<L> {
    /// Places, see [`NodeRow`].
    pub place: Vec3x8<L>,
    /// Spreads.
    pub spread: L,
    /// Mean radiances.
    pub radiance: Vec3x8<L>,
}

impl NodeRow {
    /// Rows of all nodes, from an array a property.
    pub fn of_all(places: &[Vec3], spreads: &[f32], radiance: &[Vec3], brightness: &[f32]) -> Vec<Self> {
        let row = |i| Self { place: places[i], spread: spreads[i], radiance: radiance[i], brightness: brightness[i] };
        (0..places.len()).map(row).collect()
    }

    /// Eight of `rows`.
    #[inline(always)]
    pub fn eight<L: Lanes>(rows: &[Self], nodes: [usize; 8]) -> EightNodes<L> {
        let mut eight = [&[0.0; 8]; 8];
        for (row, node) in eight.iter_mut().zip(nodes) {
            *row = bytemuck::cast_ref(&rows[node]);
        }
        let [px, py, pz, spread, rx, ry, rz, _] = L::transposed(eight);
        EightNodes { place: Vec3x8 { x: px, y: py, z: pz }, spread, radiance: Vec3x8 { x: rx, y: ry, z: rz } }
    }
}
