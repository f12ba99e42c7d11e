//! Eight cones of directions around one axis: from adjacent points to a sun. Where a cone is empty, or one triangle
//! fills it, no ray within it needs tracing.

use super::{
    Intersector,
    batch::{crossings, entering, entry_and_exit, nearer_child},
    directions::inverse,
    leaves::BlockFrom,
};
use crate::simd::{InstructionSet, Kernel, Lanes, Vec3x8};
use glam::Vec3;

/// Cones of at most 45 degrees from the axis to the rim.
#[derive(Clone, Copy, Debug)]
pub struct EightCones {
    /// Apexes of the cones.
    pub origins: [Vec3; 8],
    /// Unit direction of their axes.
    pub axis: Vec3,
    /// Sine of the angle from the axis to the rim.
    pub sine: f32,
    /// Active cones, one bit each.
    pub active: u8,
}

/// A cone of at most 45 degrees from its axis to its rim.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Apex of the cone.
    pub origin: Vec3,
    /// Unit direction of its axis.
    pub axis: Vec3,
    /// Sine of the angle from the axis to the rim.
    pub sine: f32,
}

/// Known visibility of eight cones, one bit each. Rays within the other cones may be blocked or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SeenThrough {
    /// All rays within the cone are unblocked, also by surfaces that let light through.
    pub open: u8,
    /// All rays within the cone meet an opaque triangle.
    pub closed: u8,
}

/// Leaves of triangles that stopped rays of one point. Rays of the next point try them first: in a shadow most block
/// again. They do not affect the result, but belong to one hierarchy.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Blockers {
    leaves: Vec<u32>,
    /// Leaves that stop rays of the current point.
    next: Vec<u32>,
}

impl Blockers {
    fn go_on(&mut self) {
        std::mem::swap(&mut self.leaves, &mut self.next);
        self.next.clear();
    }
}

/// Widening of cones, as a share and in radians; it exceeds the rounding of rays and planes.
const WIDER: (f32, f32) = (1e-4, 1e-6);

impl Intersector {
    /// Open and closed cones among eight, as far as a walk that ends at the first hit determines them.
    pub fn seen_through(&self, cones: &EightCones) -> SeenThrough {
        self.seen_through_in(InstructionSet::widest(), cones)
    }

    /// The unblocked rays of sixteen within a cone, of the `active` ones, one bit each, as by [`Self::occluded`]. The
    /// next point may reuse `blockers`.
    pub fn open_within(
        &self,
        cone: &Cone,
        directions: &[Vec3x8; 2],
        active: [u8; 2],
        blockers: &mut Blockers,
    ) -> [u8; 2] {
        self.open_within_in(InstructionSet::widest(), cone, directions, (active, blockers))
    }

    pub(super) fn open_within_in(
        &self,
        set: InstructionSet,
        cone: &Cone,
        directions: &[Vec3x8; 2],
        (active, blockers): ([u8; 2], &mut Blockers),
    ) -> [u8; 2] {
        if active == [0; 2] {
            return active;
        }
        let open = set.run(Rays { scene: self, cone, directions, active, blockers });
        blockers.go_on();
        open
    }

    pub(super) fn seen_through_in(&self, set: InstructionSet, cones: &EightCones) -> SeenThrough {
        let seen = set.run(Walk { scene: self, cones });
        let Some(veils) = &self.veils else { return seen };
        let past_veils = set.run(Walk { scene: &veils.surfaces, cones: &EightCones { active: seen.open, ..*cones } });
        SeenThrough { open: past_veils.open, ..seen }
    }
}

/// Sine of a cone widened by more than the rounding of rays and planes.
pub fn wider(sine: f32) -> f32 {
    debug_assert!(sine < 0.71, "cones of at most 45 degrees");
    (sine * (1.0 + WIDER.0) + WIDER.1).min(1.0)
}

struct Walk<'a> {
    scene: &'a Intersector,
    cones: &'a EightCones,
}

impl Kernel for Walk<'_> {
    type Output = SeenThrough;

    #[inline(always)]
    fn run<L: Lanes>(self) -> SeenThrough {
        let cones = Cones::<L>::new(self.cones);
        let nodes = &self.scene.bvh.nodes[..];
        let (mut open, mut closed) = (self.cones.active, 0);
        let mut stack = Vec::with_capacity(128);
        stack.extend((!nodes.is_empty() && open != 0).then_some(0));
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            if cones.enter(node.aabb.min.into(), node.aabb.max.into()) & open == 0 {
                continue;
            }
            let first = node.first_index;
            if node.prim_count == 0 {
                let near = nearer_child(nodes, first, self.cones.axis);
                stack.extend([first + 1 - near, first + near]);
                continue;
            }
            for &triangle in &self.scene.leaf_triangles[first as usize..(first + node.prim_count) as usize] {
                let (touched, filled) = cones.meet(triangle);
                closed |= open & filled;
                open &= !touched;
            }
            if open == 0 {
                break;
            }
        }
        SeenThrough { open, closed }
    }
}

/// Eight cones in registers.
struct Cones<L> {
    origins: Vec3x8<L>,
    axis: Vec3x8<L>,
    inverse_axis: Vec3x8<L>,
    sine: L,
    /// Extent of the cone across the axis along each axis of space, per unit length.
    widths: Vec3x8<L>,
    axis_lengths: Vec3x8<L>,
}

impl<L: Lanes> Cones<L> {
    #[inline(always)]
    fn new(cones: &EightCones) -> Self {
        let sine = wider(cones.sine);
        let tangent = sine / (1.0 - sine * sine).max(1e-6).sqrt();
        let across = (Vec3::ONE - cones.axis * cones.axis).max(Vec3::ZERO);
        Self {
            origins: Vec3x8::from_array(cones.origins),
            axis: Vec3x8::splat(cones.axis),
            inverse_axis: Vec3x8::splat(inverse(cones.axis)),
            sine: L::splat(sine),
            widths: Vec3x8::splat(tangent * across.map(f32::sqrt)),
            axis_lengths: Vec3x8::splat(cones.axis.abs()),
        }
    }

    /// Mask of cones that may enter a box: their axes enter the box enlarged by their width at its far end.
    #[inline(always)]
    fn enter(&self, min: Vec3, max: Vec3) -> u8 {
        let (middle, half): (Vec3x8<L>, Vec3x8<L>) =
            (Vec3x8::splat(0.5 * (min + max)), Vec3x8::splat(0.5 * (max - min)));
        let middle = middle - self.origins;
        let far = (middle.dot(self.axis) + half.dot(self.axis_lengths)).at_least(0.0);
        let half = half + self.widths * far;
        entering::<false, L>(entry_and_exit(self.inverse_axis, middle - half, middle + half))
    }

    /// Masks of the cones that a triangle may be in, and of those that it fills. A cone is wholly on one side of the
    /// plane through its origin and an edge if its axis is farther from the plane than its rim is from the axis.
    #[inline(always)]
    fn meet(&self, [p, q, r]: [Vec3; 3]) -> (u8, u8) {
        let (a, b, c) = (self.toward(p), self.toward(q), self.toward(r));
        let side = a.dot(Vec3x8::splat((q - p).cross(r - p)));
        let sign = side.simd_lt(L::splat(0.0)).select(L::splat(-1.0), L::splat(1.0));
        let (u, v, w) = (self.beside(b.cross(c), sign), self.beside(c.cross(a), sign), self.beside(a.cross(b), sign));
        // No ray from a triangle's plane meets it.
        let is_seen = side.simd_ne(L::splat(0.0)).to_bitmask();
        let outside = (u.0 | v.0 | w.0).to_bitmask();
        let filled = (u.1 & v.1 & w.1).to_bitmask();
        ((is_seen & !outside) as u8, (is_seen & filled) as u8)
    }

    /// Masks of the cones that lie wholly outside a plane through their origin, and of those wholly inside.
    #[inline(always)]
    fn beside(&self, normal: Vec3x8<L>, sign: L) -> (L, L) {
        let distance = normal.dot(self.axis) * sign;
        let is_beyond = (distance * distance).simd_gt(self.sine * self.sine * normal.dot(normal));
        let zero = L::splat(0.0);
        (distance.simd_lt(zero) & is_beyond, distance.simd_gt(zero) & is_beyond)
    }

    #[inline(always)]
    fn toward(&self, point: Vec3) -> Vec3x8<L> {
        let point: Vec3x8<L> = Vec3x8::splat(point);
        point - self.origins
    }
}

/// Rays within a cone: leaves are tested eight triangles and then eight rays at a time.
struct Rays<'a> {
    scene: &'a Intersector,
    cone: &'a Cone,
    directions: &'a [Vec3x8; 2],
    active: [u8; 2],
    blockers: &'a mut Blockers,
}

impl Kernel for Rays<'_> {
    type Output = [u8; 2];

    #[inline(always)]
    fn run<L: Lanes>(mut self) -> [u8; 2] {
        let nodes = &self.scene.bvh.nodes[..];
        let origin = Vec3x8::splat(self.cone.origin);
        let sine = wider(self.cone.sine);
        let (axis, sin_sq): (Vec3x8<L>, L) = (Vec3x8::splat(self.cone.axis), L::splat(sine * sine));
        let rays: [Vec3x8<L>; 2] = [Vec3x8::load(&self.directions[0]), Vec3x8::load(&self.directions[1])];
        let inverse_rays = [inverses(rays[0]), inverses(rays[1])];
        let mut stack = Vec::with_capacity(128);
        stack.extend((!nodes.is_empty()).then_some(0));
        // Leaves that stopped the last point's rays lie on top.
        stack.extend(self.blockers.leaves.iter().filter(|&&leaf| (leaf as usize) < nodes.len()));
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            let (min, max): (Vec3x8<L>, Vec3x8<L>) =
                (Vec3x8::splat(node.aabb.min.into()), Vec3x8::splat(node.aabb.max.into()));
            let (min, max) = (min - origin, max - origin);
            let one = entering::<false, L>(entry_and_exit(inverse_rays[0], min, max)) & self.active[0];
            if one == 0 && entering::<false, L>(entry_and_exit(inverse_rays[1], min, max)) & self.active[1] == 0 {
                continue;
            }
            let first = node.first_index;
            if node.prim_count == 0 {
                let near = nearer_child(nodes, first, self.cone.axis);
                stack.extend([first + 1 - near, first + near]);
                continue;
            }
            let before = self.active;
            for corners in self.scene.blocks.of_leaf(first, node.prim_count) {
                let triangles = BlockFrom::<L>::new(self.cone.origin, corners);
                let mut near = triangles.near_cone(axis, sin_sq);
                while near != 0 {
                    let edges = triangles.edges_of(near.trailing_zeros() as usize);
                    near &= near - 1;
                    self.active[0] &= !crossings(rays[0], &edges);
                    self.active[1] &= !crossings(rays[1], &edges);
                }
            }
            if self.active != before {
                self.blockers.next.push(index);
            }
            if self.active == [0; 2] {
                break;
            }
        }
        self.active
    }
}

/// Inverses of the components, none of them infinite; see [`inverse`].
#[inline(always)]
fn inverses<L: Lanes>(v: Vec3x8<L>) -> Vec3x8<L> {
    Vec3x8 { x: inverse_x8(v.x), y: inverse_x8(v.y), z: inverse_x8(v.z) }
}

#[inline(always)]
fn inverse_x8<L: Lanes>(c: L) -> L {
    let least = c.simd_lt(L::splat(0.0)).select(L::splat(-1e-18), L::splat(1e-18));
    L::splat(1.0) / c.abs().simd_lt(L::splat(1e-18)).select(least, c)
}
