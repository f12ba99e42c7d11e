//! Visibility of all light samples from one bake point: exhaustive batches or boundaries, behind one function.

use crate::vertices::{points::BakePoint, side::Side};
use glam::Vec3;
use lapidary_core::{
    light_tree::LightTree,
    ray::{BoundarySet, BoundaryTracer, DirectionSet, Intersector, OPEN},
};

/// Lights or sources per probe if every one is traced.
pub const EXHAUSTIVE: usize = 1;

/// Usual number of lights or sources per probe in bakes that follow boundaries.
pub const USUAL: usize = 16;
/// Least such number.
pub const FINEST: usize = 8;

/// A scene and the directions to its lights.
pub struct VisibilitySampler<'a> {
    scene: &'a Intersector,
    directions: Directions,
    veils: Veils<'a>,
}

/// The thin surfaces of a scene, and the directions in which they attenuate light.
pub struct Veils<'a> {
    scene: &'a Intersector,
    /// `None` without thin surfaces.
    directions: Option<DirectionSet>,
}

impl<'a> Veils<'a> {
    /// For a scene and any unit directions.
    pub fn new(scene: &'a Intersector, directions: &[Vec3]) -> Self {
        Self { scene, directions: scene.has_veils().then(|| DirectionSet::new(directions)) }
    }

    /// Reduces the visibility past all opaque surfaces by the light that thin ones block.
    pub fn dim(&self, point: &BakePoint, visible: &mut [u8]) {
        let Some(directions) = &self.directions else { return };
        for &side in point.sides() {
            let half = point.half_of(side);
            self.scene.attenuate(point.origin(side), directions, |d| half.has(d), visible);
        }
    }
}

enum Directions {
    All(DirectionSet),
    Boundaries(BoundarySet),
}

impl<'a> VisibilitySampler<'a> {
    /// For the leaves of `tree`, in tree order. Boundaries are followed between probes that each stand for `lights_per_probe`, or
    /// every light is traced ([`EXHAUSTIVE`]).
    pub fn new(scene: &'a Intersector, tree: &LightTree, lights_per_probe: usize) -> Self {
        Self::of_directions(scene, tree.leaf_directions(), lights_per_probe)
    }

    /// For any unit directions in the given order.
    pub fn of_directions(scene: &'a Intersector, directions: &[Vec3], lights_per_probe: usize) -> Self {
        let veils = Veils::new(scene, directions);
        let directions = match lights_per_probe {
            EXHAUSTIVE => Directions::All(DirectionSet::new(directions)),
            _ => Directions::Boundaries(BoundarySet::new(directions, lights_per_probe)),
        };
        Self { scene, directions, veils }
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        match &self.directions {
            Directions::All(set) => set.len(),
            Directions::Boundaries(set) => set.len(),
        }
    }

    /// Sets `visible[leaf]` to the visible share of each light, in units of 1 / [`OPEN`]. Returns the traced rays.
    pub fn sample(&self, point: &BakePoint, tracer: &mut BoundaryTracer, visible: &mut [u8]) -> u64 {
        self.sample_some(point, None, tracer, visible)
    }

    /// [`Self::sample`] for the marked lights, if any are marked; others are dark.
    pub fn sample_some(
        &self,
        point: &BakePoint,
        marked: Option<&[bool]>,
        tracer: &mut BoundaryTracer,
        visible: &mut [u8],
    ) -> u64 {
        visible.fill(0);
        let mut trace = |&side: &Side| {
            let (origin, half) = (point.origin(side), point.half_of(side));
            let wanted = |i: u32, d| half.has(d) && marked.is_none_or(|marked| marked[i as usize]);
            match &self.directions {
                Directions::All(set) => self.scene.trace_batch(origin, set, wanted, &mut *visible),
                Directions::Boundaries(set) => {
                    tracer.trace_some(self.scene, origin, set, (&half, marked), &mut *visible)
                }
            }
        };
        let rays = point.sides().iter().map(&mut trace).sum();
        self.veils.dim(point, visible);
        rays
    }

    /// [`Self::sample`] by single rays without packets, for verification.
    pub fn sample_singly(&self, tree: &LightTree, point: &BakePoint, visible: &mut [u8]) {
        for (v, &d) in visible.iter_mut().zip(tree.leaf_directions()) {
            let side = point.side_of(d);
            let traced = point.sides().contains(&side);
            let passed = if traced { self.scene.transmittance(point.origin(side), d) } else { 0.0 };
            *v = (passed * f32::from(OPEN)).round() as u8;
        }
    }

    /// Repeats [`Self::sample`] for verification: by single rays if every light is traced, else along the same boundaries.
    pub fn sample_again(&self, tree: &LightTree, point: &BakePoint, visible: &mut [u8]) {
        match &self.directions {
            Directions::All(_) => self.sample_singly(tree, point, visible),
            Directions::Boundaries(_) => {
                self.sample(point, &mut BoundaryTracer::default(), visible);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        test_scenes::{cuboid, floor, quad, scene_of},
        vertices::{points::BakePoints, sidedness::classify},
    };

    #[test]
    fn batches_equal_single_rays_and_known_geometry() {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 1.5, 0.0), Vec3::splat(0.5)));
        let p = |x: f32, y: f32| Vec3::new(x, y, 1.7);
        triangles.extend(quad(p(-1.0, 0.5), p(1.0, 0.5), p(1.0, 2.0), p(-1.0, 2.0)));
        let scene = scene_of(&triangles);
        let tree = LightTree::geometric(1024).unwrap();
        let points = BakePoints::new(&scene.mesh, &classify(&scene));
        let intersector = Intersector::new(&scene.mesh);
        let sampler = VisibilitySampler::new(&intersector, &tree, EXHAUSTIVE);
        let mut tracer = BoundaryTracer::default();
        let (mut batch, mut single) = (vec![0; 1024], vec![0; 1024]);
        let mut both_sides = 0;
        for point in &points.points {
            let rays = sampler.sample(point, &mut tracer, &mut batch);
            sampler.sample_singly(&tree, point, &mut single);
            assert_eq!(batch, single);
            assert!(rays <= 1024);
            both_sides += usize::from(rays == 1024);
        }
        assert_eq!(both_sides, 4, "the banner's corners see the whole sphere");
        batch[3] ^= 1;
        assert_ne!(batch, single, "negative control");
    }

    #[test]
    fn a_closed_surface_sees_exactly_its_upper_half() {
        let scene = scene_of(&floor(1.0, 0.0));
        let tree = LightTree::geometric(4096).unwrap();
        let points = BakePoints::new(&scene.mesh, &classify(&scene));
        let intersector = Intersector::new(&scene.mesh);
        let mut visible = vec![0; 4096];
        let sampler = VisibilitySampler::new(&intersector, &tree, EXHAUSTIVE);
        let rays = sampler.sample(&points.points[0], &mut BoundaryTracer::default(), &mut visible);
        assert_eq!(visible.iter().map(|&v| u64::from(v / OPEN)).sum::<u64>(), rays);
        for (v, d) in visible.iter().zip(tree.leaf_directions()) {
            assert_eq!(*v == OPEN, d.y > points.points[0].horizon);
        }
    }
}
