//! Eight nearby rays or segments from one origin: smaller than a packet, for scattered requests.

use super::{
    Intersector,
    batch::{crossings, entering, entry_and_exit, nearer_child, passing},
    directions::{GROUP, HalfSpace, cone_sin_sq, inverse},
    frontier::Frontier,
    leaves::BlockFrom,
};
use crate::simd::{Lanes, Vec3x8};
use glam::Vec3;
use obvhs::bvh2::node::Bvh2Node;

/// Eight directions, or eight segments. Unused lanes repeat the first.
#[derive(Clone)]
pub(super) struct RayGroup {
    pub rays: Vec3x8,
    pub inverse_rays: Vec3x8,
    /// Mean direction; near boxes along it are visited first.
    pub axis: Vec3,
    /// Squared sine of the half-angle of the cone around `axis` that contains all; 1 if there is no such cone.
    pub sin_sq: f32,
    /// Least and greatest inverses of the components; arbitrary where the directions have both signs.
    pub inverse_bounds: [Vec3; 2],
}

impl RayGroup {
    /// A group of one to eight unit directions.
    pub fn new(directions: &[Vec3]) -> Self {
        let rays = std::array::from_fn(|lane| *directions.get(lane).unwrap_or(&directions[0]));
        Self::of(rays, rays)
    }

    /// A group of eight non-null segments.
    pub fn of_segments(segments: [Vec3; GROUP]) -> Self {
        Self::of(segments, segments.map(|segment| segment.normalize_or(Vec3::Y)))
    }

    fn of(rays: [Vec3; GROUP], directions: [Vec3; GROUP]) -> Self {
        let axis = directions.iter().sum::<Vec3>().normalize_or(Vec3::Y);
        let inverses = rays.map(inverse);
        Self {
            rays: Vec3x8::from_array(rays),
            inverse_rays: Vec3x8::from_array(inverses),
            axis,
            sin_sq: cone_sin_sq(axis, &directions),
            inverse_bounds: inverse_bounds(inverses),
        }
    }

    /// Mask of directions within a half-space.
    #[inline(always)]
    pub fn within<L: Lanes>(&self, half: &HalfSpace) -> u8 {
        let heights = Vec3x8::<L>::load(&self.rays).dot(Vec3x8::splat(half.normal));
        let above = heights.simd_gt(L::splat(half.height)).to_bitmask() as u8;
        if half.is_above { above } else { !above }
    }

    /// The unblocked rays of `active`, one bit each, as by [`Intersector::occluded`], or
    /// [`Intersector::occluded_between`] if they are `SEGMENTS`. `frontier` belongs to the origin.
    #[inline(always)]
    pub fn open<const SEGMENTS: bool, L: Lanes>(
        &self,
        scene: &Intersector,
        frontier: &Frontier,
        origin: Vec3,
        mut active: u8,
        stack: &mut Vec<(u32, u8)>,
    ) -> u8 {
        let nodes = &scene.bvh.nodes[..];
        let (from, inverse_rays): (Vec3x8<L>, Vec3x8<L>) = (Vec3x8::splat(origin), Vec3x8::load(&self.inverse_rays));
        let mut reached = frontier.reached::<SEGMENTS, L>(self.inverse_bounds);
        while reached != 0 {
            let root = frontier.roots[reached.trailing_zeros() as usize];
            reached &= reached - 1;
            let entered = enters::<SEGMENTS, L>(inverse_rays, &nodes[root as usize], from);
            stack.clear();
            stack.push((root, entered));
            while let Some((mut index, entered)) = stack.pop() {
                if entered & active == 0 {
                    continue;
                }
                loop {
                    let node = &nodes[index as usize];
                    let first = node.first_index;
                    if node.prim_count > 0 {
                        for corners in scene.blocks.of_leaf(first, node.prim_count) {
                            active &= !self.crossing::<SEGMENTS, L>(&BlockFrom::new(origin, corners));
                        }
                        break;
                    }
                    let one = enters::<SEGMENTS, L>(inverse_rays, &nodes[first as usize], from) & active;
                    let other = enters::<SEGMENTS, L>(inverse_rays, &nodes[first as usize + 1], from) & active;
                    if one != 0 && other != 0 {
                        let near = nearer_child(nodes, first, self.axis);
                        stack.push((first + 1 - near, if near == 0 { other } else { one }));
                        index = first + near;
                    } else if one != 0 {
                        index = first;
                    } else if other != 0 {
                        index = first + 1;
                    } else {
                        break;
                    }
                }
            }
            if active == 0 {
                break;
            }
        }
        active
    }

    /// Mask of rays that cross any of eight triangles.
    #[inline(always)]
    fn crossing<const SEGMENTS: bool, L: Lanes>(&self, triangles: &BlockFrom<L>) -> u8 {
        let mut near = triangles.near_cone(Vec3x8::splat(self.axis), L::splat(self.sin_sq));
        let (rays, mut crossing) = (Vec3x8::load(&self.rays), 0);
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            let mut crossed = crossings(rays, &triangles.edges_of(lane));
            if SEGMENTS && crossed != 0 {
                crossed &= passing(rays, &triangles.plane_of(lane));
            }
            crossing |= crossed;
        }
        crossing
    }
}

/// Bounds of the inverses of directions: infinite along axes with both signs.
fn inverse_bounds(inverses: [Vec3; GROUP]) -> [Vec3; 2] {
    let least = inverses.into_iter().fold(Vec3::INFINITY, Vec3::min);
    let most = inverses.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
    let mixed = least.cmplt(Vec3::ZERO) & most.cmpgt(Vec3::ZERO);
    // Finite, so that zero times it is zero.
    [Vec3::select(mixed, Vec3::splat(-1e30), least), Vec3::select(mixed, Vec3::splat(1e30), most)]
}

/// Mask of eight rays that enter the box of a node.
#[inline(always)]
fn enters<const SEGMENTS: bool, L: Lanes>(inverse_rays: Vec3x8<L>, node: &Bvh2Node, from: Vec3x8<L>) -> u8 {
    let (min, max): (Vec3x8<L>, Vec3x8<L>) = (Vec3x8::splat(node.aabb.min.into()), Vec3x8::splat(node.aabb.max.into()));
    entering::<SEGMENTS, L>(entry_and_exit(inverse_rays, min - from, max - from))
}
