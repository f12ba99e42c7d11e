//! Visibility of all light samples from one bake point: one batch behind one function.

use crate::vertices::{points::BakePoint, side::Side};
use glam::Vec3;
use lapidary_core::{
    light_tree::LightTree,
    ray::{DirectionSet, Intersector},
};

/// A scene and the directions to its lights.
pub struct VisibilitySampler<'a> {
    scene: &'a Intersector,
    directions: DirectionSet,
}

impl<'a> VisibilitySampler<'a> {
    /// For the leaves of `tree`, in tree order.
    pub fn new(scene: &'a Intersector, tree: &LightTree) -> Self {
        Self::of_directions(scene, tree.leaf_directions())
    }

    /// For any unit directions, in the order given.
    pub fn of_directions(scene: &'a Intersector, directions: &[Vec3]) -> Self {
        Self { scene, directions: DirectionSet::new(directions) }
    }

    /// Sets `visible[leaf]` to 1 for every light that the point sees and to 0 for all others. Returns the rays traced.
    pub fn sample(&self, point: &BakePoint, visible: &mut [u8]) -> u64 {
        visible.fill(0);
        let trace = |&side: &Side| {
            self.scene.trace_batch(point.origin(side), &self.directions, |d| point.side_of(d) == side, &mut *visible)
        };
        point.sides().iter().map(trace).sum()
    }

    /// [`Self::sample`] ray by ray and without packets, for verification.
    pub fn sample_singly(&self, tree: &LightTree, point: &BakePoint, visible: &mut [u8]) {
        for (v, &d) in visible.iter_mut().zip(tree.leaf_directions()) {
            let side = point.side_of(d);
            let traced = point.sides().contains(&side);
            *v = u8::from(traced && !self.scene.occluded(point.origin(side), d));
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
        let sampler = VisibilitySampler::new(&intersector, &tree);
        let (mut batch, mut single) = (vec![0; 1024], vec![0; 1024]);
        let mut both_sides = 0;
        for point in &points.points {
            let rays = sampler.sample(point, &mut batch);
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
        let rays = VisibilitySampler::new(&intersector, &tree).sample(&points.points[0], &mut visible);
        assert_eq!(visible.iter().map(|&v| u64::from(v)).sum::<u64>(), rays);
        for (v, d) in visible.iter().zip(tree.leaf_directions()) {
            assert_eq!(*v == 1, d.y > points.points[0].horizon);
        }
    }
}
