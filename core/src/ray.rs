//! Ray casting against a triangle mesh: closest hits one by one or, from one origin, eight at a time (`ray::closest`),
//! and occlusion of whole direction sets from one origin. Occlusion is the inner loop of every bake, for all directions
//! (`ray::batch`) or along visibility boundaries (`ray::boundaries`).
//!
//! All use one predicate (`ray::triangle`), so a batch equals its single rays bit for bit.

mod batch;
mod boundaries;
mod closest;
mod cones;
mod device;
mod directions;
mod eight;
mod frontier;
mod group;
mod hierarchy;
mod leaves;
mod posable;
mod segments;
mod triangle;
mod veils;

pub use boundaries::{BoundarySet, BoundaryTables, BoundaryTracer, SegmentSet, SegmentTracer, is_number_per_probe};
pub use cones::{Blockers, Cone, EightCones, SeenThrough, wider};
pub use device::{BoxNode, Fan, FanDevice, OpenRays, RayDevice, RayDevices, RayDirections, RayOrigin};
pub use directions::{DirectionSet, HalfSpace, in_eights, spatial_order};
pub use eight::EightRays;
pub use segments::SegmentBatch;

use crate::{
    bounds::Bounds,
    mesh::Mesh,
    opacity::Opacities,
    scene::Scene,
    surfel::{MeshPlace, Surfel},
    threads::on_threads,
};
use closest::is_nearer;
use glam::{Vec2, Vec3, Vec3A};
use leaves::LeafBlocks;
use obvhs::{bvh2::Bvh2, ray::Ray, triangle::Triangle};
pub use posable::Posable;
use rayon::prelude::*;
use std::{
    collections::HashSet,
    panic::resume_unwind,
    sync::atomic::{AtomicU64, Ordering},
};
use triangle::TriangleFrom;
use veils::{Veils, any_threshold};

/// Threads that build a hierarchy.
const BUILDERS: usize = 8;

/// Full visibility in units of stored visibility; 0 means blocked.
pub const OPEN: u8 = u8::MAX;

/// The first hit of a ray with the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle in the mesh.
    pub triangle: u32,
    /// Distance along the unit direction in meters.
    pub distance: f32,
    /// Barycentric weights of the second and third corner.
    pub barycentric: Vec2,
    /// Whether the ray met the back of the triangle.
    pub back_face: bool,
}

/// A mesh prepared for ray casting. Keeps its own copy of the corners, so the mesh may change.
///
/// Surfaces that let light through are kept apart. Occlusion tests ignore them; `transmittance` gives the light they
/// pass. First hits stop at them by chance in proportion to their opacity, or by a threshold.
pub struct Intersector {
    number: HierarchyNumber,
    bvh: Bvh2,
    /// Corners in the order of the leaves of `bvh`.
    leaf_triangles: Vec<[Vec3; 3]>,
    /// Mesh index of each leaf triangle; with spatial splits one triangle may be in several leaves.
    leaf_ids: Vec<u32>,
    /// The leaf triangles, eight at a time.
    blocks: LeafBlocks,
    veils: Option<Box<Veils>>,
}

/// Tells a hierarchy from all others of a run, also after it is gone: devices know by it what they hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HierarchyNumber(u64);

impl HierarchyNumber {
    fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Builds a hierarchy over triangles.
type Build = fn(&[Triangle]) -> Bvh2;

impl Intersector {
    /// Builds a hierarchy optimized for many rays; some seconds for a million triangles. All triangles are opaque.
    pub fn new(mesh: &Mesh) -> Self {
        Self::with_hierarchy(mesh, &Opacities::default(), hierarchy::build)
    }

    /// [`Self::new`] with the materials of a scene.
    pub fn of_scene(scene: &Scene) -> Self {
        Self::with_opacities(&scene.mesh, &Opacities::of_scene(scene))
    }

    /// [`Self::new`] with an opacity for each material of the mesh.
    pub fn with_opacities(mesh: &Mesh, opacities: &Opacities) -> Self {
        Self::with_hierarchy(mesh, opacities, hierarchy::build)
    }

    /// Builds a hierarchy in a fraction of the time; its rays take up to twice as long. Hits differ only along edges,
    /// by rounding: 2 of 4 million rays onto the armadillo.
    pub fn quick(mesh: &Mesh, opacities: &Opacities) -> Self {
        Self::with_hierarchy(mesh, opacities, hierarchy::build_quickly)
    }

    /// Builds in its own threads, always as many. The calling thread may be one that others wait for, and the sorting
    /// of equal costs may depend on the number of threads.
    fn with_hierarchy(mesh: &Mesh, opacities: &Opacities, build: Build) -> Self {
        let apart = || on_threads(BUILDERS, || Self::parted(mesh, opacities, build));
        std::thread::scope(|scope| scope.spawn(apart).join()).unwrap_or_else(|panic| resume_unwind(panic))
    }

    fn parted(mesh: &Mesh, opacities: &Opacities, build: Build) -> Self {
        let thin = opacities.thin();
        let all = 0..mesh.triangles.len() as u32;
        if thin.iter().all(Option::is_none) {
            return Self::made(mesh, build, all.collect());
        }
        let material = |t: u32| opacities.material(mesh, t);
        let is_thin = |t: u32| thin[material(t) as usize].is_some();
        let (thin_ones, solid) = all.partition(|&t| is_thin(t));
        let veils = Veils::new(mesh, Self::made(mesh, build, thin_ones), material, &thin);
        Self { veils: Some(Box::new(veils)), ..Self::made(mesh, build, solid) }
    }

    /// Builds from some triangles, in ascending order.
    fn made(mesh: &Mesh, build: Build, triangles: Vec<u32>) -> Self {
        let mut distinct = distinct_triangles(mesh, triangles);
        let bounds = mesh.bounds();
        distinct.sort_by_cached_key(|&t| mesh.shell_of_ground(t, bounds));
        let shells = distinct.chunk_by(|&a, &b| mesh.shell_of_ground(a, bounds) == mesh.shell_of_ground(b, bounds));
        let triangle = |&t: &u32| {
            let [v0, v1, v2] = mesh.corners(t as usize).map(Vec3A::from);
            Triangle { v0, v1, v2 }
        };
        let mut bvh = Bvh2::default();
        let mut built = 0;
        for shell in shells {
            let of_shell = build(&shell.par_iter().map(triangle).collect::<Vec<Triangle>>());
            bvh = hierarchy::joined(&bvh, built, &of_shell);
            built += shell.len() as u32;
        }
        widen_boxes(&mut bvh, bounds);
        let leaf_ids: Vec<u32> = bvh.primitive_indices.par_iter().map(|&i| distinct[i as usize]).collect();
        let leaf_triangles: Vec<[Vec3; 3]> = leaf_ids.par_iter().map(|&t| mesh.corners(t as usize)).collect();
        let blocks = LeafBlocks::new(&bvh, &leaf_triangles);
        Self { number: HierarchyNumber::next(), bvh, leaf_triangles, leaf_ids, blocks, veils: None }
    }

    /// The first triangle along a ray, if any. The origin must lie off the surface that the ray starts from.
    pub fn closest_hit(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        self.closest_above(origin, direction, any_threshold(origin, direction))
    }

    /// The first triangle along a ray whose opacity at the hit is above its threshold.
    pub fn closest_above(&self, origin: Vec3, direction: Vec3, threshold: impl Fn(u32) -> f32) -> Option<Hit> {
        let (of, leaf, hit) = self.first(origin, direction, f32::INFINITY, threshold)?;
        Some(Hit { triangle: of.leaf_ids[leaf], ..hit })
    }

    /// The first leaf triangle along a ray before `distance` that is above its threshold, with its intersector.
    fn first(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        threshold: impl Fn(u32) -> f32,
    ) -> Option<(&Self, usize, Hit)> {
        let solid = self.closest_leaf(origin, direction, distance, |_, _| true).map(|(leaf, hit)| (self, leaf, hit));
        self.nearer_veil(origin, direction, solid.map_or(distance, |(.., hit)| hit.distance), threshold).or(solid)
    }

    /// The first leaf triangle of the thin surfaces.
    fn nearer_veil(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        threshold: impl Fn(u32) -> f32,
    ) -> Option<(&Self, usize, Hit)> {
        let veils = self.veils.as_ref()?;
        let stops = |leaf, hit: &Hit| veils.stop(leaf, hit, &threshold);
        let (leaf, hit) = veils.surfaces.closest_leaf(origin, direction, distance, stops)?;
        Some((&veils.surfaces, leaf, hit))
    }

    /// The first hit of a ray, skipping the ground of `mesh` if hit from below, or if it should not be hit from above
    /// either. Nothing lies below a ground.
    pub fn past_ground(
        &self,
        mesh: &Mesh,
        hit: Option<Hit>,
        (origin, direction): (Vec3, Vec3),
        from_above: bool,
        threshold: impl Fn(u32) -> f32,
    ) -> Option<Hit> {
        /// Steps behind the plane as shares of the distance, until rounding clears it.
        const STEPS: [f32; 5] = [2e-7, 1e-6, 5e-6, 2.5e-5, 1.25e-4];
        let Some(ground) = hit.filter(|hit| mesh.is_ground(hit.triangle)) else { return hit };
        if !ground.back_face {
            return hit.filter(|_| from_above);
        }
        let behind = |step: f32| {
            let passed = ground.distance * (1.0 + step);
            let hit = self.closest_above(origin + direction * passed, direction, &threshold);
            hit.map(|hit| Hit { distance: hit.distance + passed, ..hit })
        };
        let beyond = STEPS.into_iter().map(behind).find(|hit| hit.is_none_or(|hit| !mesh.is_ground(hit.triangle)));
        beyond.flatten()
    }

    /// The first surface along a ray before `distance` meters, with its normal toward the origin.
    pub fn surfel_before(&self, origin: Vec3, direction: Vec3, distance: f32) -> Option<Surfel> {
        self.surfel_above(origin, direction, distance, any_threshold(origin, direction))
    }

    /// [`Self::surfel_before`] for surfaces whose opacity is above a threshold.
    pub fn surfel_above(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        threshold: impl Fn(u32) -> f32,
    ) -> Option<Surfel> {
        let (of, leaf, hit) = self.first(origin, direction, distance, threshold)?;
        Some(of.surfel(leaf, hit, origin, direction))
    }

    /// The surface point where a ray meets a leaf triangle, with the normal toward the origin.
    fn surfel(&self, leaf: usize, hit: Hit, origin: Vec3, direction: Vec3) -> Surfel {
        let [a, b, c] = self.leaf_triangles[leaf];
        let front = (b - a).cross(c - a).normalize_or_zero();
        Surfel {
            position: origin + direction * hit.distance,
            normal: if hit.back_face { -front } else { front },
            place: MeshPlace { triangle: self.leaf_ids[leaf], barycentric: hit.barycentric },
        }
    }

    /// The first leaf triangle along a ray before `distance` that stops the ray.
    fn closest_leaf(
        &self,
        origin: Vec3,
        direction: Vec3,
        distance: f32,
        stops: impl Fn(usize, &Hit) -> bool,
    ) -> Option<(usize, Hit)> {
        let mut closest = None;
        let mut leaf_hit = obvhs::ray::RayHit::none();
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        self.bvh.ray_traverse(ray, &mut leaf_hit, |ray, leaf| {
            let known = (ray.tmax, closest.map(|(leaf, _): (usize, Hit)| self.leaf_ids[leaf]));
            let triangle = TriangleFrom::unless_missed(origin, self.leaf_triangles[leaf], direction);
            match triangle.and_then(|triangle| triangle.hit(direction)) {
                Some(hit) if is_nearer((hit.distance, self.leaf_ids[leaf]), known) && stops(leaf, &hit) => {
                    closest = Some((leaf, hit));
                    hit.distance
                }
                _ => f32::INFINITY,
            }
        });
        closest
    }

    /// Whether an opaque triangle lies along a ray.
    pub fn occluded(&self, origin: Vec3, direction: Vec3) -> bool {
        let ray = Ray::new_inf(origin.into(), direction.into());
        !self.bvh.ray_traverse_miss(ray, |_, leaf| {
            let triangle = TriangleFrom::unless_missed(origin, self.leaf_triangles[leaf], direction);
            if triangle.is_some_and(|triangle| triangle.crosses(direction)) { 0.0 } else { f32::INFINITY }
        })
    }

    /// Whether an opaque triangle lies along a ray before `distance` meters.
    pub fn occluded_before(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        !self.bvh.ray_traverse_miss(ray, |_, leaf| {
            let triangle = TriangleFrom::unless_missed(origin, self.leaf_triangles[leaf], direction);
            let hit = triangle.and_then(|triangle| triangle.hit(direction));
            if hit.is_some_and(|h| h.distance < distance) { 0.0 } else { f32::INFINITY }
        })
    }

    /// Whether an opaque triangle lies strictly between two points. Both lie off any surface.
    pub fn occluded_between(&self, from: Vec3, to: Vec3) -> bool {
        let segment = to - from;
        let ray = Ray::new(from.into(), segment.into(), 0.0, 1.0);
        !self.bvh.ray_traverse_miss(ray, |_, leaf| {
            let triangle = TriangleFrom::unless_missed(from, self.leaf_triangles[leaf], segment);
            if triangle.is_some_and(|triangle| triangle.crosses_before(segment)) { 0.0 } else { f32::INFINITY }
        })
    }

    /// [`Self::occluded`] by testing every triangle: the oracle of the tests.
    #[cfg(test)]
    pub(crate) fn occluded_by_brute_force(&self, origin: Vec3, direction: Vec3) -> bool {
        self.leaf_triangles.iter().any(|&t| TriangleFrom::new(origin, t).crosses(direction))
    }
}

/// The triangles without later copies: at equal distance the first triangle counts, so no ray distinguishes them. The
/// time of a build grows with the square of the copies in one place.
fn distinct_triangles(mesh: &Mesh, part: Vec<u32>) -> Vec<u32> {
    let corners = |t: u32| mesh.corners(t as usize).map(|corner| corner.to_array().map(f32::to_bits));
    let mix = |hash: u64, bits: u32| (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    let hash = |t: u32| (corners(t).as_flattened().iter().fold(0, |h, &bits| mix(h, bits)), t);
    let mut hashed: Vec<(u64, u32)> = part.par_iter().map(|&t| hash(t)).collect();
    hashed.par_sort_unstable();
    let mut copies = HashSet::new();
    // Equal triangles have equal hashes and are adjacent, the first before its copies.
    for alike in hashed.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
        let mut known = HashSet::new();
        copies.extend(alike.iter().map(|&(_, t)| t).filter(|&t| !known.insert(corners(t))));
    }
    part.into_iter().filter(|t| !copies.contains(t)).collect()
}

/// Widens all boxes by more than the rounding of a slab test, which could otherwise miss a grazed box. Rays begin in
/// the bounds of the scene, or as far out on its ground as their hits.
fn widen_boxes(bvh: &mut Bvh2, bounds: Bounds) {
    const SLACK: f32 = 4e-6;
    let scene = bounds.min.abs().max(bounds.max.abs()).max_element();
    for node in &mut bvh.nodes {
        let slack = SLACK * node.aabb.min.abs().max(node.aabb.max.abs()).max_element().max(scene);
        node.aabb.min -= slack;
        node.aabb.max += slack;
    }
}

#[cfg(test)]
mod tests;
