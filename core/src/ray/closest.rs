//! First hits of many rays from one origin, eight at a time: rays of adjacent pixels enter the same boxes.

use super::{
    Hit, Intersector,
    batch::{crossings, entry_and_exit, nearer_child},
    directions::GROUP,
    frontier::Frontier,
    group::RayGroup,
    leaves::BlockFrom,
    triangle::TriangleFrom,
    veils::any_threshold,
};
use crate::{
    simd::{InstructionSet, Kernel, Lanes, Vec3x8},
    surfel::Surfel,
};
use glam::Vec3;

/// The first leaf triangle that a ray meets.
type LeafHit = Option<(usize, Hit)>;

impl Intersector {
    /// [`Self::closest_hit`] of many rays from one origin. Eights of nearby unit directions are fastest.
    pub fn closest_hits(&self, origin: Vec3, directions: &[[Vec3; 8]]) -> Vec<[Option<Hit>; 8]> {
        let by_chance = |ray: usize, triangle| any_threshold(origin, directions[ray / 8][ray % 8])(triangle);
        self.closest_hits_above(origin, directions, by_chance)
    }

    /// [`Self::closest_above`] of many rays from one origin; `threshold` gets the index of the ray and a triangle.
    pub fn closest_hits_above(
        &self,
        origin: Vec3,
        directions: &[[Vec3; 8]],
        threshold: impl Fn(usize, u32) -> f32,
    ) -> Vec<[Option<Hit>; 8]> {
        let mut hits = self.closest_hits_in(InstructionSet::widest(), origin, directions);
        if self.has_veils() {
            let rays = hits.as_flattened_mut().iter_mut().zip(directions.as_flattened()).enumerate();
            rays.for_each(|(ray, (hit, &direction))| {
                let distance = hit.map_or(f32::INFINITY, |hit| hit.distance);
                let nearer = self.nearer_veil(origin, direction, distance, |triangle| threshold(ray, triangle));
                *hit = nearer.map(|(of, leaf, hit)| Hit { triangle: of.leaf_ids[leaf], ..hit }).or(*hit);
            });
        }
        hits
    }

    /// [`Self::closest_hits_above`] with the instructions of `set`.
    pub(super) fn closest_hits_in(
        &self,
        set: InstructionSet,
        origin: Vec3,
        directions: &[[Vec3; 8]],
    ) -> Vec<[Option<Hit>; 8]> {
        let of_mesh = |(leaf, hit)| Hit { triangle: self.leaf_ids[leaf], ..hit };
        let hits = set.run(Eights { scene: self, origin, directions, before: f32::INFINITY });
        hits.into_iter().map(|eight| eight.map(|hit| hit.map(of_mesh))).collect()
    }

    /// [`Self::surfel_before`] of many rays from one origin, up to `distance` meters, in eights as for [`Self::closest_hits`].
    pub fn surfels_before(&self, origin: Vec3, directions: &[[Vec3; 8]], distance: f32) -> Vec<[Option<Surfel>; 8]> {
        let hits = InstructionSet::widest().run(Eights { scene: self, origin, directions, before: distance });
        let surfel =
            |(hit, direction): (&LeafHit, Vec3)| hit.map(|(leaf, hit)| self.surfel(leaf, hit, origin, direction));
        let nearest = |hit: &LeafHit, direction| {
            let distance = hit.map_or(distance, |(_, hit)| hit.distance);
            let veil = self.nearer_veil(origin, direction, distance, any_threshold(origin, direction));
            veil.map(|(of, leaf, hit)| of.surfel(leaf, hit, origin, direction)).or_else(|| surfel((hit, direction)))
        };
        let eight = |(hits, directions): (&[LeafHit; 8], &[Vec3; 8])| {
            std::array::from_fn(|lane| nearest(&hits[lane], directions[lane]))
        };
        hits.iter().zip(directions).map(eight).collect()
    }

    /// A leaf triangle as seen from `origin`.
    #[inline(always)]
    fn leaf_from(&self, origin: Vec3, leaf: u32) -> TriangleFrom {
        TriangleFrom::new(origin, self.leaf_triangles[leaf as usize])
    }
}

/// The first hits of eights of rays, up to the distance `before`.
struct Eights<'a> {
    scene: &'a Intersector,
    origin: Vec3,
    directions: &'a [[Vec3; 8]],
    before: f32,
}

impl Kernel for Eights<'_> {
    type Output = Vec<[LeafHit; 8]>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (mut hits, mut stack) = (Vec::with_capacity(self.directions.len()), Vec::with_capacity(128));
        let mut frontier = Frontier::default();
        frontier.move_to(self.scene, self.origin);
        for directions in self.directions {
            let nearest = self.nearest::<L>(&frontier, &RayGroup::new(directions), &mut stack);
            let mut eight = [None; 8];
            for ((hit, leaf), &direction) in eight.iter_mut().zip(nearest.leaves).zip(directions) {
                if let Some(leaf) = leaf {
                    let met = self.scene.leaf_from(self.origin, leaf).hit(direction);
                    *hit = met.map(|hit| (leaf as usize, hit));
                }
            }
            hits.push(eight);
        }
        hits
    }
}

/// The first leaf triangles of eight rays so far.
struct Nearest {
    leaves: [Option<u32>; 8],
    distances: [f32; 8],
}

impl Eights<'_> {
    #[inline(always)]
    fn nearest<L: Lanes>(&self, frontier: &Frontier, group: &RayGroup, stack: &mut Vec<u32>) -> Nearest {
        let mut nearest = Nearest { leaves: [None; 8], distances: [self.before; 8] };
        let nodes = &self.scene.bvh.nodes[..];
        let inverse_rays: Vec3x8<L> = Vec3x8::load(&group.inverse_rays);
        let mut reached = frontier.reached::<false, L>(group.inverse_bounds);
        while reached != 0 {
            stack.clear();
            stack.push(frontier.roots[reached.trailing_zeros() as usize]);
            reached &= reached - 1;
            while let Some(index) = stack.pop() {
                let node = &nodes[index as usize];
                let (min, max) = (Vec3::from(node.aabb.min) - self.origin, Vec3::from(node.aabb.max) - self.origin);
                let (entry, exit) = entry_and_exit(inverse_rays, Vec3x8::splat(min), Vec3x8::splat(max));
                // Boxes are widened by more than the rounding here.
                let enters = entry.simd_le(exit) & entry.simd_le(L::new(nearest.distances));
                if enters.to_bitmask() == 0 {
                    continue;
                }
                if node.prim_count > 0 {
                    self.meet_leaf::<L>(&mut nearest, group, node.first_index, node.prim_count);
                } else {
                    let near = nearer_child(nodes, node.first_index, group.axis);
                    stack.push(node.first_index + 1 - near);
                    stack.push(node.first_index + near);
                }
            }
        }
        nearest
    }

    /// Keeps hits of a leaf that are nearer than the known ones. Most triangles lie outside the cone of the rays.
    #[inline(always)]
    fn meet_leaf<L: Lanes>(&self, nearest: &mut Nearest, group: &RayGroup, first: u32, count: u32) {
        let rays = Vec3x8::load(&group.rays);
        for (corners, leaves) in self.scene.blocks.of_leaf(first, count).iter().zip((first..).step_by(GROUP)) {
            let triangles: BlockFrom<L> = BlockFrom::new(self.origin, corners);
            let mut near = triangles.near_cone(Vec3x8::splat(group.axis), L::splat(group.sin_sq));
            while near != 0 {
                let lane = near.trailing_zeros();
                near &= near - 1;
                if crossings(rays, &triangles.edges_of(lane as usize)) != 0 {
                    self.meet(nearest, rays, leaves + lane);
                }
            }
        }
    }

    /// Keeps hits of a leaf triangle that are nearer than the known ones, by the arithmetic of [`TriangleFrom::hit`].
    #[inline(always)]
    fn meet<L: Lanes>(&self, nearest: &mut Nearest, rays: Vec3x8<L>, leaf: u32) {
        let triangle = self.scene.leaf_from(self.origin, leaf);
        let [a, b, c] = &triangle.edges;
        let (a, b, c) = (Vec3x8::splat(*a).dot(rays), Vec3x8::splat(*b).dot(rays), Vec3x8::splat(*c).dot(rays));
        let zero = L::splat(0.0);
        let inside = a.simd_ge(zero) & b.simd_ge(zero) & c.simd_ge(zero);
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

/// Whether a hit at some distance on a triangle comes before the known one. At equal distance the first triangle
/// counts, so the order of entering boxes does not matter.
#[inline(always)]
pub(super) fn is_nearer((distance, triangle): (f32, u32), (known, of): (f32, Option<u32>)) -> bool {
    distance < known || (distance == known && of.is_none_or(|of| triangle < of))
}
