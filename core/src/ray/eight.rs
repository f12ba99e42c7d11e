//! Eight rays with their own origins and directions: rays of neighboring points in one direction enter the same boxes.

use super::{
    Intersector, SeenThrough,
    batch::{entering, entry_and_exit, nearer_child},
    directions::inverse,
};
use crate::simd::{InstructionSet, Kernel, Lanes, Vec3x8};
use glam::Vec3;

/// Eight rays.
#[derive(Clone, Copy, Debug)]
pub struct EightRays {
    origins: Vec3x8,
    directions: Vec3x8,
    inverse_directions: Vec3x8,
    active: u8,
}

impl EightRays {
    /// Rays from `origins` along unit `directions`; `active` has a bit for each that counts.
    pub fn new(origins: [Vec3; 8], directions: [Vec3; 8], active: u8) -> Self {
        Self {
            origins: Vec3x8::from_array(origins),
            directions: Vec3x8::from_array(directions),
            inverse_directions: Vec3x8::from_array(directions.map(inverse)),
            active,
        }
    }

    /// The active rays, one bit each.
    pub fn active(&self) -> u8 {
        self.active
    }
}

impl Intersector {
    /// For each eight rays the active unblocked ones, one bit each, as by [`Self::occluded`].
    pub fn open(&self, rays: &[EightRays]) -> Vec<u8> {
        self.open_in(InstructionSet::widest(), rays)
    }

    pub(super) fn open_in(&self, set: InstructionSet, rays: &[EightRays]) -> Vec<u8> {
        set.run(Open { scene: self, rays })
    }

    /// [`Self::open`], but ignoring thin surfaces that pass most of the light.
    pub fn mostly_open(&self, rays: &[EightRays]) -> Vec<u8> {
        let mut open = self.open(rays);
        if self.has_veils() {
            let passes = |rays: &EightRays, lane: usize| {
                self.past_veils(rays.origins.lane(lane), rays.directions.lane(lane), f32::INFINITY) > 0.5
            };
            open.iter_mut().zip(rays).for_each(|(open, rays)| {
                let stopped = (0..8).filter(|&lane| *open >> lane & 1 == 1 && !passes(rays, lane));
                *open &= !stopped.fold(0, |stopped, lane| stopped | 1 << lane);
            });
        }
        open
    }

    /// Visibility of eight rays before some distances in meters: open rays meet nothing, closed rays meet an opaque
    /// triangle, as by [`Self::occluded_before`]. Thin surfaces dim the others.
    pub fn seen_before(&self, rays: &EightRays, before: [f32; 8]) -> SeenThrough {
        self.seen_before_in(InstructionSet::widest(), rays, before)
    }

    /// Share of the light that passes along eight rays before some distances in meters; zero for inactive ones.
    pub fn passed_before(&self, rays: &EightRays, before: [f32; 8]) -> [f32; 8] {
        let seen = self.seen_before(rays, before);
        std::array::from_fn(|lane| match [seen.open, rays.active & !seen.closed].map(|mask| mask >> lane & 1 == 1) {
            [true, _] => 1.0,
            [_, true] => self.past_veils(rays.origins.lane(lane), rays.directions.lane(lane), before[lane]),
            _ => 0.0,
        })
    }

    pub(super) fn seen_before_in(&self, set: InstructionSet, rays: &EightRays, before: [f32; 8]) -> SeenThrough {
        let open = set.run(OpenBefore { scene: self, rays, before });
        let closed = rays.active & !open;
        let Some(veils) = &self.veils else { return SeenThrough { open, closed } };
        let rays = &EightRays { active: open, ..*rays };
        SeenThrough { open: set.run(OpenBefore { scene: &veils.surfaces, rays, before }), closed }
    }

    /// For each eight rays the distances in meters of their closest hits, as by [`Self::closest_hit`]; infinite for
    /// rays that hit nothing or are inactive.
    pub fn closest_distances(&self, rays: &[EightRays]) -> Vec<[f32; 8]> {
        self.closest_distances_in(InstructionSet::widest(), rays)
    }

    pub(super) fn closest_distances_in(&self, set: InstructionSet, rays: &[EightRays]) -> Vec<[f32; 8]> {
        set.run(Closest { scene: self, rays })
    }
}

/// Unblocked rays.
struct Open<'a> {
    scene: &'a Intersector,
    rays: &'a [EightRays],
}

impl Kernel for Open<'_> {
    type Output = Vec<u8>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<u8> {
        let (mut open, mut stack) = (Vec::with_capacity(self.rays.len()), Vec::with_capacity(128));
        for eight in self.rays {
            let rays = Rays::<L>::new(eight);
            let mut active = eight.active;
            stack.clear();
            stack.extend((!self.scene.bvh.nodes.is_empty() && active != 0).then_some(0));
            while let Some(index) = stack.pop() {
                let entered = rays.enter(self.scene, index, L::splat(f32::INFINITY)) & active;
                if entered == 0 {
                    continue;
                }
                for leaf in rays.leaves_or_children(self.scene, index, &mut stack) {
                    active &= !(rays.crosses(self.scene.leaf_triangles[leaf as usize]).to_bitmask() as u8);
                }
                if active == 0 {
                    break;
                }
            }
            open.push(active);
        }
        open
    }
}

/// Rays unblocked before some distances.
struct OpenBefore<'a> {
    scene: &'a Intersector,
    rays: &'a EightRays,
    before: [f32; 8],
}

impl Kernel for OpenBefore<'_> {
    type Output = u8;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u8 {
        let (rays, before) = (Rays::<L>::new(self.rays), L::new(self.before));
        let (mut active, mut stack) = (self.rays.active, Vec::with_capacity(128));
        stack.extend((!self.scene.bvh.nodes.is_empty() && active != 0).then_some(0));
        while let Some(index) = stack.pop() {
            if rays.enter(self.scene, index, before) & active == 0 {
                continue;
            }
            for leaf in rays.leaves_or_children(self.scene, index, &mut stack) {
                let nearest = rays.nearest(self.scene.leaf_triangles[leaf as usize], before);
                active &= !(nearest.simd_lt(before).to_bitmask() as u8);
            }
            if active == 0 {
                break;
            }
        }
        active
    }
}

/// Distances of first hits.
struct Closest<'a> {
    scene: &'a Intersector,
    rays: &'a [EightRays],
}

impl Kernel for Closest<'_> {
    type Output = Vec<[f32; 8]>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<[f32; 8]> {
        let (mut distances, mut stack) = (Vec::with_capacity(self.rays.len()), Vec::with_capacity(128));
        for eight in self.rays {
            let rays = Rays::<L>::new(eight);
            let mut nearest = L::splat(f32::INFINITY);
            stack.clear();
            stack.extend((!self.scene.bvh.nodes.is_empty() && eight.active != 0).then_some(0));
            while let Some(index) = stack.pop() {
                if rays.enter(self.scene, index, nearest) & eight.active == 0 {
                    continue;
                }
                for leaf in rays.leaves_or_children(self.scene, index, &mut stack) {
                    nearest = rays.nearest(self.scene.leaf_triangles[leaf as usize], nearest);
                }
            }
            let mut eight_distances = nearest.to_array();
            for (lane, distance) in eight_distances.iter_mut().enumerate() {
                if eight.active >> lane & 1 == 0 {
                    *distance = f32::INFINITY;
                }
            }
            distances.push(eight_distances);
        }
        distances
    }
}

/// Eight rays in registers.
struct Rays<L> {
    origins: Vec3x8<L>,
    directions: Vec3x8<L>,
    inverse_directions: Vec3x8<L>,
    /// Mean direction; near boxes along it are visited first.
    axis: Vec3,
}

impl<L: Lanes> Rays<L> {
    #[inline(always)]
    fn new(eight: &EightRays) -> Self {
        Self {
            origins: Vec3x8::load(&eight.origins),
            directions: Vec3x8::load(&eight.directions),
            inverse_directions: Vec3x8::load(&eight.inverse_directions),
            axis: eight.directions.lane(0) + eight.directions.lane(7),
        }
    }

    /// Mask of rays that enter the box of a node before `nearest`.
    #[inline(always)]
    fn enter(&self, scene: &Intersector, index: u32, nearest: L) -> u8 {
        let aabb = &scene.bvh.nodes[index as usize].aabb;
        let (min, max): (Vec3x8<L>, Vec3x8<L>) = (Vec3x8::splat(aabb.min.into()), Vec3x8::splat(aabb.max.into()));
        let (entry, exit) = entry_and_exit(self.inverse_directions, min - self.origins, max - self.origins);
        entering::<false, L>((entry, exit)) & entry.simd_le(nearest).to_bitmask() as u8
    }

    /// The triangles of a leaf. For an inner node, pushes the children and returns none.
    #[inline(always)]
    fn leaves_or_children(&self, scene: &Intersector, index: u32, stack: &mut Vec<u32>) -> std::ops::Range<u32> {
        let node = &scene.bvh.nodes[index as usize];
        let first = node.first_index;
        if node.prim_count == 0 {
            let near = nearer_child(&scene.bvh.nodes, first, self.axis);
            stack.extend([first + 1 - near, first + near]);
        }
        first..first + node.prim_count
    }

    /// Mask of rays that cross a triangle, by the arithmetic of [`super::triangle::TriangleFrom::crosses`].
    #[inline(always)]
    fn crosses(&self, corners: [Vec3; 3]) -> L {
        self.crossing(corners).0
    }

    /// Mask of rays that cross a triangle, and the sums of their weights, valid where they cross.
    #[inline(always)]
    fn crossing(&self, [p, q, r]: [Vec3; 3]) -> (L, L) {
        let zero = L::splat(0.0);
        let (a, b, c) = (self.toward(p), self.toward(q), self.toward(r));
        // All edge planes point inward or all outward: multiplying by -1, which is exact, flips them.
        let (u, v) = (b.cross(c).dot(self.directions), c.cross(a).dot(self.directions));
        let (inward, outward) = (u.simd_ge(zero) & v.simd_ge(zero), u.simd_le(zero) & v.simd_le(zero));
        if (inward | outward).to_bitmask() == 0 {
            return (zero, zero);
        }
        let w = a.cross(b).dot(self.directions);
        let side = a.dot(Vec3x8::splat((q - p).cross(r - p)));
        let inward = inward & w.simd_ge(zero) & side.simd_gt(zero);
        let outward = outward & w.simd_le(zero) & side.simd_lt(zero);
        (inward | outward, (u + v + w).abs())
    }

    /// `nearest`, or the distance of a nearer hit on a triangle, as by [`super::triangle::TriangleFrom::hit`].
    #[inline(always)]
    fn nearest(&self, corners: [Vec3; 3], nearest: L) -> L {
        let zero = L::splat(0.0);
        let (crosses, weights) = self.crossing(corners);
        if crosses.to_bitmask() == 0 {
            return nearest;
        }
        let [p, q, r] = corners;
        let normal = Vec3x8::splat((q - p).cross(r - p));
        let distance = self.toward(p).dot(normal) / self.directions.dot(normal);
        let is_hit = crosses & weights.simd_gt(zero) & distance.simd_gt(zero) & distance.simd_lt(nearest);
        is_hit.select(distance, nearest)
    }

    #[inline(always)]
    fn toward(&self, point: Vec3) -> Vec3x8<L> {
        let point: Vec3x8<L> = Vec3x8::splat(point);
        point - self.origins
    }
}
