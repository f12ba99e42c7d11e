//! First hits of many rays from one origin, eight at a time: those of pixels side by side enter the same boxes.

use super::{
    Hit, Intersector,
    batch::{entry_and_exit, nearer_child},
    directions::inverse,
    triangle::TriangleFrom,
};
use crate::simd::{InstructionSet, Kernel, Lanes, Vec3x8};
use glam::Vec3;

impl Intersector {
    /// [`Self::closest_hit`] of many rays from one origin. The nearer the unit directions of eight are to each other, the
    /// faster it is.
    pub fn closest_hits(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[Option<Hit>; 8]> {
        self.closest_hits_in(InstructionSet::widest(), origin, directions)
    }

    /// The same in the instructions of `set`.
    pub(super) fn closest_hits_in(
        &self,
        set: InstructionSet,
        origin: Vec3,
        directions: &[[Vec3; 8]],
    ) -> Vec<[Option<Hit>; 8]> {
        set.run(Eights { scene: self, origin, directions })
    }

    /// A leaf triangle as seen from `origin`.
    #[inline(always)]
    fn leaf_from(&self, origin: Vec3, leaf: u32) -> TriangleFrom {
        TriangleFrom::new(origin, self.leaf_triangles[leaf as usize])
    }
}

/// The first hits of eights of rays.
struct Eights<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    directions: &'a [[Vec3; 8]],
}

impl Kernel for Eights<'_> {
    type Output = Vec<[Option<Hit>; 8]>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (mut hits, mut stack) = (Vec::with_capacity(self.directions.len()), Vec::with_capacity(128));
        for directions in self.directions {
            let nearest = self.nearest::<L>(directions, &mut stack);
            let mut eight = [None; 8];
            for ((hit, leaf), &direction) in eight.iter_mut().zip(nearest.leaves).zip(directions) {
                if let Some(leaf) = leaf {
                    let met = self.scene.leaf_from(self.origin, leaf).hit(direction);
                    *hit = met.map(|hit| Hit { triangle: self.scene.leaf_ids[leaf as usize], ..hit });
                }
            }
            hits.push(eight);
        }
        hits
    }
}

/// The first leaf triangles that eight rays meet, so far.
struct Nearest {
    leaves: [Option<u32>; 8],
    distances: [f32; 8],
}

impl Eights<'_> {
    #[inline(always)]
    fn nearest<L: Lanes>(&self, directions: &[Vec3; 8], stack: &mut Vec<u32>) -> Nearest {
        let mut nearest = Nearest { leaves: [None; 8], distances: [f32::INFINITY; 8] };
        let nodes = &self.scene.bvh.nodes[..];
        let rays: Vec3x8<L> = Vec3x8::from_array(*directions);
        let mut inverses = [Vec3::ZERO; 8];
        for (inverse_ray, &direction) in inverses.iter_mut().zip(directions) {
            *inverse_ray = inverse(direction);
        }
        let (inverses, axis): (Vec3x8<L>, Vec3) = (Vec3x8::from_array(inverses), directions[0] + directions[7]);
        stack.clear();
        stack.extend((!nodes.is_empty()).then_some(0));
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            let (min, max) = (Vec3::from(node.aabb.min) - self.origin, Vec3::from(node.aabb.max) - self.origin);
            let (entry, exit) = entry_and_exit(inverses, Vec3x8::splat(min), Vec3x8::splat(max));
            // The boxes are wider than their triangles by more than what is rounded here.
            let enters = entry.simd_le(exit) & entry.simd_le(L::new(nearest.distances));
            if enters.to_bitmask() == 0 {
                continue;
            }
            if node.prim_count > 0 {
                for leaf in node.first_index..node.first_index + node.prim_count {
                    self.meet(&mut nearest, rays, leaf);
                }
            } else {
                let near = nearer_child(nodes, node.first_index, axis);
                stack.push(node.first_index + 1 - near);
                stack.push(node.first_index + near);
            }
        }
        nearest
    }

    /// Keeps the hits of a leaf triangle that are nearer than those known; the same arithmetic as [`TriangleFrom::hit`].
    #[inline(always)]
    fn meet<L: Lanes>(&self, nearest: &mut Nearest, rays: Vec3x8<L>, leaf: u32) {
        let triangle = self.scene.leaf_from(self.origin, leaf);
        let [a, b, c] = &triangle.edges;
        let (a, b, c) = (Vec3x8::splat(*a).dot(rays), Vec3x8::splat(*b).dot(rays), Vec3x8::splat(*c).dot(rays));
        let zero = L::splat(0.0);
        let inside = a.simd_ge(zero) & b.simd_ge(zero) & c.simd_ge(zero);
        if triangle.side == 0.0 || inside.to_bitmask() == 0 {
            return;
        }
        let distance = L::splat(triangle.plane_distance()) / rays.dot(Vec3x8::splat(triangle.normal));
        let is_hit = inside & (a + b + c).simd_gt(zero) & distance.simd_gt(zero);
        let mut met = (is_hit & distance.simd_le(L::new(nearest.distances))).to_bitmask();
        let distance = distance.to_array();
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let known =
                (nearest.distances[lane], nearest.leaves[lane].map(|known| self.scene.leaf_ids[known as usize]));
            if is_nearer((distance[lane], self.scene.leaf_ids[leaf as usize]), known) {
                (nearest.distances[lane], nearest.leaves[lane]) = (distance[lane], Some(leaf));
            }
        }
    }
}

/// Whether a hit at some distance on a triangle comes before the known one. Of triangles at the same distance the first
/// counts, so that the order in which boxes are entered does not matter.
#[inline(always)]
pub(super) fn is_nearer((distance, triangle): (f32, u32), (known, of): (f32, Option<u32>)) -> bool {
    distance < known || (distance == known && of.is_none_or(|of| triangle < of))
}
