//! Leaf triangles eight at a time, and their edge planes from an origin.

use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use obvhs::bvh2::Bvh2;

/// Triangles of all leaves in blocks of eight; a leaf starts a block of its own.
pub(super) struct LeafBlocks {
    /// The corners of eight triangles; unused lanes repeat the first triangle's first corner and cross nothing.
    corners: Vec<[Vec3x8; 3]>,
    /// First block of the leaf whose first triangle is at this position.
    first_block: Vec<u32>,
}

impl LeafBlocks {
    pub fn new(bvh: &Bvh2, triangles: &[[Vec3; 3]]) -> Self {
        let mut blocks = Self { corners: Vec::new(), first_block: vec![0; triangles.len()] };
        for leaf in bvh.nodes.iter().filter(|n| n.prim_count > 0) {
            let first = leaf.first_index as usize;
            blocks.first_block[first] = blocks.corners.len() as u32;
            for eight in triangles[first..first + leaf.prim_count as usize].chunks(8) {
                let corner = |lane: usize, c: usize| eight.get(lane).map_or(eight[0][0], |t| t[c]);
                blocks.corners.push([0, 1, 2].map(|c| Vec3x8::from_array(std::array::from_fn(|lane| corner(lane, c)))));
            }
        }
        blocks
    }

    /// The blocks of one hierarchy followed by those of another.
    pub fn joined(&self, other: &Self) -> Self {
        let first = self.corners.len() as u32;
        Self {
            corners: [&self.corners[..], &other.corners].concat(),
            first_block: self
                .first_block
                .iter()
                .copied()
                .chain(other.first_block.iter().map(|&block| block + first))
                .collect(),
        }
    }

    /// The blocks of a leaf.
    #[inline(always)]
    pub fn of_leaf(&self, first_index: u32, count: u32) -> &[[Vec3x8; 3]] {
        let first = self.first_block[first_index as usize] as usize;
        &self.corners[first..first + count.div_ceil(8) as usize]
    }
}

/// [`super::TriangleFrom`] for eight triangles, by the same arithmetic.
pub(super) struct BlockFrom<L> {
    edges: [Vec3x8<L>; 3],
    /// Normals away from the origin (not unit), and their dot product with a corner relative to it.
    plane: (Vec3x8<L>, L),
    /// Triangles that a ray from the origin can cross at all.
    crossable: u32,
}

impl<L: Lanes> BlockFrom<L> {
    #[inline(always)]
    pub fn new(origin: Vec3, corners: &[Vec3x8; 3]) -> Self {
        let o: Vec3x8<L> = Vec3x8::splat(origin);
        let [p, q, r] = [Vec3x8::load(&corners[0]), Vec3x8::load(&corners[1]), Vec3x8::load(&corners[2])];
        let (a, b, c) = (p - o, q - o, r - o);
        let normal = (q - p).cross(r - p);
        let side = a.dot(normal);
        let sign = side.simd_lt(L::splat(0.0)).select(L::splat(-1.0), L::splat(1.0));
        let crossable = side.simd_ne(L::splat(0.0)).to_bitmask();
        Self {
            edges: [b.cross(c) * sign, c.cross(a) * sign, a.cross(b) * sign],
            plane: (normal * sign, side.abs()),
            crossable,
        }
    }

    /// Triangles that some ray within the cone around `axis` may cross; `sin_sq` is the squared sine of its half-angle.
    ///
    /// A cone lies wholly outside an edge plane if its axis is farther outside than its half-angle.
    #[inline(always)]
    pub fn near_cone(&self, axis: Vec3x8<L>, sin_sq: L) -> u32 {
        let [a, b, c] = self.edges;
        let outside = is_outside(a, axis, sin_sq) | is_outside(b, axis, sin_sq) | is_outside(c, axis, sin_sq);
        self.crossable & !outside.to_bitmask()
    }

    /// The plane of one triangle, eight times: a segment `s` from the origin passes it if `normal · s` exceeds the distance.
    #[inline(always)]
    pub fn plane_of(&self, lane: usize) -> (Vec3x8<L>, L) {
        (Vec3x8::splat(self.plane.0.lane(lane)), L::splat(self.plane.1.to_array()[lane]))
    }

    /// The edge planes of one triangle, eight times each.
    #[inline(always)]
    pub fn edges_of(&self, lane: usize) -> [Vec3x8<L>; 3] {
        let [a, b, c] = &self.edges;
        [Vec3x8::splat(a.lane(lane)), Vec3x8::splat(b.lane(lane)), Vec3x8::splat(c.lane(lane))]
    }
}

/// Mask of edge planes with the whole cone on their outer side.
#[inline(always)]
fn is_outside<L: Lanes>(edge: Vec3x8<L>, axis: Vec3x8<L>, sin_sq: L) -> L {
    let d = edge.dot(axis);
    d.simd_lt(L::splat(0.0)) & (d * d).simd_gt(sin_sq * edge.dot(edge))
}
