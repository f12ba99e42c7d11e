//! A scene with moving objects: the baked hierarchy without them, and one per moving object, refitted to its triangles.
//!
//! They are joined into one hierarchy per pose, so all rays and batches work on it unchanged. A static scene keeps its hierarchy.

use super::{HierarchyNumber, Intersector, LeafBlocks, Veils, hierarchy, widen_boxes};
use crate::{bounds::Bounds, mesh::Mesh, opacity::Opacities, scene::Scene};
use glam::Vec3;
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Casts rays on a scene under changing poses.
pub struct Posable {
    solid: Layer,
    /// Surfaces that let light through.
    thin: Option<Layer>,
    opacities: Opacities,
}

/// The hierarchies of the solid surfaces, or of the thin ones.
struct Layer {
    /// The baked hierarchy; triangles of moving objects are points, which no ray meets.
    still: Intersector,
    /// Bounds of the whole scene as baked.
    bounds: Bounds,
    /// The hierarchy of each moving object, as baked.
    moving: Vec<Intersector>,
}

impl Posable {
    /// Splits the hierarchy of a scene as baked. `moving` has the indices of moving objects.
    pub fn new(baked: &Intersector, scene: &Scene, moving: &BTreeSet<u32>) -> Self {
        let (mesh, opacities) = (&scene.mesh, Opacities::of_scene(scene));
        // A hidden object is a point as baked, where its triangles cannot be told apart.
        let meshes = [mesh, &*scene.shown_mesh()];
        let thin = opacities.thin();
        let is_thin = |t: u32| thin.get(opacities.material(mesh, t) as usize).is_some_and(Option::is_some);
        let of_thin = |veils: &Veils| Layer::new(&veils.surfaces, meshes, moving, is_thin);
        Self {
            solid: Layer::new(baked, meshes, moving, |t| !is_thin(t)),
            thin: baked.veils.as_ref().map(|veils| of_thin(veils)),
            opacities,
        }
    }

    /// The hierarchy for a `posed` mesh: the same triangles with other corners.
    pub fn posed(&self, posed: &Mesh) -> Intersector {
        let bounds = posed.bounds();
        let veils = self.thin.as_ref().map(|layer| {
            let material = |triangle| self.opacities.material(posed, triangle);
            Box::new(Veils::new(posed, layer.posed(posed, bounds), material, &self.opacities.thin()))
        });
        Intersector { veils, ..self.solid.posed(posed, bounds) }
    }
}

impl Layer {
    /// A layer of the triangles for which `is_part` holds, of a mesh as baked; `shown` has hidden objects where they would be.
    fn new(
        baked: &Intersector,
        [mesh, shown]: [&Mesh; 2],
        moving: &BTreeSet<u32>,
        is_part: impl Fn(u32) -> bool,
    ) -> Self {
        let object = |t: u32| mesh.triangle_object[t as usize];
        let made = |mesh, triangles| Intersector::made(mesh, hierarchy::build_quickly, triangles);
        let still = baked.without(|t| moving.contains(&object(t)));
        // A hierarchy omits copies of triangles: a static triangle may be the copy of a moving one.
        let mut is_known = vec![false; mesh.triangles.len()];
        baked.leaf_ids.iter().for_each(|&t| is_known[t as usize] = true);
        let mut copies = Vec::new();
        let mut of_moving: BTreeMap<u32, Vec<u32>> = moving.iter().map(|&object| (object, Vec::new())).collect();
        for t in (0..mesh.triangles.len() as u32).filter(|&t| is_part(t)) {
            match of_moving.get_mut(&object(t)) {
                Some(triangles) => triangles.push(t),
                None if !is_known[t as usize] => copies.push(t),
                None => {}
            }
        }
        let of_object = of_moving.into_values().filter(|triangles| !triangles.is_empty());
        let moving = of_object.map(|triangles| made(shown, triangles)).collect();
        Self { still: still.joined(&made(mesh, copies)), bounds: mesh.bounds(), moving }
    }

    fn posed(&self, posed: &Mesh, bounds: Bounds) -> Intersector {
        let widened = self.still.widened(self.bounds, bounds);
        let still = widened.as_ref().unwrap_or(&self.still);
        let moved: Vec<Intersector> = self.moving.par_iter().map(|object| object.refitted(posed, bounds)).collect();
        match all_joined(moved) {
            Some(moved) => still.joined(&moved),
            None => still.copied(),
        }
    }
}

/// Joins hierarchies in pairs: each is copied once per level of the tree over them.
fn all_joined(mut hierarchies: Vec<Intersector>) -> Option<Intersector> {
    while hierarchies.len() > 1 {
        let pairs = hierarchies.par_chunks(2);
        hierarchies = pairs.map(|pair| pair.get(1).map_or_else(|| pair[0].copied(), |b| pair[0].joined(b))).collect();
    }
    hierarchies.pop()
}

impl Intersector {
    fn copied(&self) -> Self {
        self.without(|_| false)
    }

    /// The same hierarchy for rays that begin in `now`; `None` if its boxes, widened for rays that begin in `before`, suffice.
    fn widened(&self, before: Bounds, now: Bounds) -> Option<Self> {
        if before.min.cmple(now.min).all() && before.max.cmpge(now.max).all() {
            return None;
        }
        let mut wide = self.copied();
        widen_boxes(&mut wide.bvh, now);
        Some(wide)
    }

    /// The same hierarchy with some triangles collapsed to points.
    fn without(&self, is_left_out: impl Fn(u32) -> bool) -> Self {
        let kept = |(&[a, b, c], &t): (&[Vec3; 3], &u32)| if is_left_out(t) { [a; 3] } else { [a, b, c] };
        let leaf_triangles: Vec<_> = self.leaf_triangles.iter().zip(&self.leaf_ids).map(kept).collect();
        let (bvh, leaf_ids) = (self.bvh.clone(), self.leaf_ids.clone());
        let (number, blocks) = (HierarchyNumber::next(), LeafBlocks::new(&bvh, &leaf_triangles));
        Self { number, blocks, bvh, leaf_triangles, leaf_ids, veils: None }
    }

    /// Refits the boxes to the same triangles with other corners.
    fn refitted(&self, mesh: &Mesh, bounds: Bounds) -> Self {
        let (mut bvh, leaf_ids) = (self.bvh.clone(), self.leaf_ids.clone());
        let leaf_triangles: Vec<_> = leaf_ids.iter().map(|&t| mesh.corners(t as usize)).collect();
        for node in bvh.nodes.iter_mut().filter(|node| node.is_leaf()) {
            let first = node.first_index as usize;
            let corners = leaf_triangles[first..first + node.prim_count as usize].as_flattened();
            node.aabb = corners.iter().fold(Aabb::empty(), |mut aabb, &corner| *aabb.extend(corner.into()));
        }
        bvh.refit_all();
        widen_boxes(&mut bvh, bounds);
        let (number, blocks) = (HierarchyNumber::next(), LeafBlocks::new(&bvh, &leaf_triangles));
        Self { number, blocks, bvh, leaf_triangles, leaf_ids, veils: None }
    }

    /// Joins this hierarchy and another.
    fn joined(&self, other: &Self) -> Self {
        if other.leaf_ids.is_empty() {
            return self.copied();
        }
        let places = self.leaf_ids.len() as u32;
        Self {
            number: HierarchyNumber::next(),
            blocks: self.blocks.joined(&other.blocks),
            bvh: hierarchy::joined(&self.bvh, places, &other.bvh),
            leaf_triangles: [&self.leaf_triangles[..], &other.leaf_triangles].concat(),
            leaf_ids: [&self.leaf_ids[..], &other.leaf_ids].concat(),
            veils: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        material::Material,
        ray::DirectionSet,
        scene::{
            Scene,
            pose::{Objects, Pose, Poses},
        },
        sphere::fibonacci_directions,
        test_scenes::cubes,
    };

    const ORIGIN: Vec3 = Vec3::new(0.3, 2.4, 0.1);

    fn moved(of: &[(u32, Pose)]) -> Poses {
        let mut poses = Poses::default();
        of.iter().for_each(|&(object, pose)| poses.set(object, pose));
        poses
    }

    fn pose(x: f32, degrees: f32, scale: f32) -> Pose {
        Pose {
            translate: Vec3::new(x, 0.2, -0.3),
            rotate_degrees: Vec3::new(degrees, 2.0 * degrees, 0.0),
            scale,
            ..Pose::AS_BAKED
        }
    }

    /// Hits of rays in all directions: triangles and distances.
    fn met(rays: &Intersector) -> Vec<Option<(u32, u32)>> {
        let met = |&d: &Vec3| rays.closest_hit(ORIGIN, d).map(|hit| (hit.triangle, hit.distance.to_bits()));
        fibonacci_directions(20_000).iter().map(met).collect()
    }

    fn differ<T: PartialEq>(a: &[T], b: &[T]) -> usize {
        a.iter().zip(b).filter(|(a, b)| a != b).count()
    }

    #[test]
    fn rays_meet_all_of_an_object_that_was_hidden_and_is_shown_again() {
        let with_all = cubes(4);
        let mut baked = with_all.clone();
        let hidden =
            moved(&[(2, Pose { hidden: true, ..Pose::AS_BAKED }), (3, Pose { hidden: true, ..Pose::AS_BAKED })]);
        baked.place(&hidden).unwrap();
        let shown = moved(&[(3, Pose { hidden: true, ..Pose::AS_BAKED })]);
        let since = baked.poses_since_baked(&shown);
        let mesh = since.pose(&baked.mesh, &Objects::of(&baked)).unwrap();
        let posable = Posable::new(&Intersector::of_scene(&baked), &baked, &since.moved().collect());
        let mut expected = with_all.clone();
        expected.place(&shown).unwrap();
        let [found, expected, without] =
            [posable.posed(&mesh), Intersector::of_scene(&expected), Intersector::of_scene(&baked)]
                .map(|rays| met(&rays));
        assert_eq!(differ(&found, &expected), 0);
        assert!(differ(&found, &without) > 100, "negative control: it is hidden");
    }

    #[test]
    fn rays_meet_the_posed_scene_as_if_it_had_been_built_so() {
        let mut scene = cubes(4);
        scene.materials.push(Material::default());
        scene.materials[1].parameters.set("geometry_opacity", 0.5);
        for (t, object) in scene.mesh.triangle_object.iter().enumerate() {
            scene.mesh.triangle_material[t] = object % 2;
        }
        let (objects, opacities) = (Objects::of(&scene), Opacities::of_scene(&scene));
        let baked = Intersector::of_scene(&scene);
        let posable = Posable::new(&baked, &scene, &[1, 2].into());
        let directions = DirectionSet::new(&fibonacci_directions(512));
        for poses in
            [moved(&[(1, pose(0.4, 30.0, 1.3)), (2, pose(-0.5, 75.0, 0.5))]), moved(&[(2, pose(1.0, 0.0, 1.0))])]
        {
            let mesh = poses.pose(&scene.mesh, &objects).unwrap();
            let (posed, built) = (posable.posed(&mesh), Intersector::with_opacities(&mesh, &opacities));
            let expected = met(&built);
            assert_eq!(differ(&met(&posed), &expected), 0);
            assert!(differ(&met(&baked), &expected) > 500, "negative control: without the pose");
            let seen = |rays: &Intersector| {
                let mut seen = vec![0; 512];
                rays.trace_batch(ORIGIN, &directions, |_, _| true, &mut seen);
                seen
            };
            assert_eq!(seen(&posed), seen(&built), "in batches, through thin surfaces");
        }
    }

    fn depth(rays: &Intersector, node: usize) -> usize {
        let of = &rays.bvh.nodes[node];
        let below = |child: usize| depth(rays, of.first_index as usize + child);
        if of.is_leaf() { 1 } else { 1 + below(0).max(below(1)) }
    }

    #[test]
    fn many_objects_are_met_as_few_are() {
        let scene: Scene = cubes(40);
        let objects = Objects::of(&scene);
        let all: Vec<(u32, Pose)> = (0..40).map(|object| (object, pose(0.01 * object as f32, 9.0, 1.1))).collect();
        let mesh = moved(&all).pose(&scene.mesh, &objects).unwrap();
        let posable = Posable::new(&Intersector::of_scene(&scene), &scene, &(0..39).collect());
        let still_one = moved(&all[..39]).pose(&scene.mesh, &objects).unwrap();
        let (posed, built) = (posable.posed(&still_one), Intersector::new(&still_one));
        assert_eq!(differ(&met(&posed), &met(&built)), 0);
        assert!(differ(&met(&posed), &met(&Intersector::new(&mesh))) > 0, "negative control: one more has moved");
        assert!(depth(&posed, 0) < 25, "the tree over them is no chain: {}", depth(&posed, 0));
    }

    #[test]
    fn boxes_are_as_wide_as_rays_from_far_away_ask() {
        let scene = cubes(2);
        let posable = Posable::new(&Intersector::of_scene(&scene), &scene, &[0].into());
        let least_margin = |x: f32| {
            let mesh = moved(&[(0, pose(x, 0.0, 1.0))]).pose(&scene.mesh, &Objects::of(&scene)).unwrap();
            let rays = posable.posed(&mesh);
            let margin = |node: &obvhs::bvh2::node::Bvh2Node| {
                let first = node.first_index as usize;
                let corners = rays.leaf_triangles[first..first + node.prim_count as usize].as_flattened();
                let least = corners.iter().copied().reduce(Vec3::min).unwrap();
                (least - Vec3::from(node.aabb.min)).min_element()
            };
            rays.bvh.nodes.iter().filter(|node| node.is_leaf()).map(margin).fold(f32::INFINITY, f32::min)
        };
        assert!(least_margin(1000.0) > 3e-3);
        assert!(least_margin(0.1) < 1e-4, "negative control");
    }

    #[test]
    fn an_object_that_is_where_it_was_is_met_as_before() {
        let scene: Scene = cubes(3);
        let baked = Intersector::of_scene(&scene);
        let posable = Posable::new(&baked, &scene, &[0, 2].into());
        assert!(met(&posable.posed(&scene.mesh)) == met(&baked));
    }

    #[test]
    fn what_stays_is_met_where_its_copy_has_moved_away() {
        let mut scene = cubes(1);
        let [triangles, vertices] = [scene.mesh.triangles.len(), scene.mesh.positions.len()];
        let mesh = &mut scene.mesh;
        mesh.triangles.extend_from_within(..);
        mesh.triangles[triangles..].as_flattened_mut().iter_mut().for_each(|v| *v += vertices as u32);
        mesh.triangle_material.extend_from_within(..);
        mesh.triangle_object.extend(vec![1; triangles]);
        mesh.positions.extend_from_within(..);
        mesh.normals.extend_from_within(..);
        mesh.tangents.extend_from_within(..);
        mesh.uvs.extend_from_within(..);
        scene.objects.extend_from_within(..);
        let baked = Intersector::of_scene(&scene);
        let posable = Posable::new(&baked, &scene, &[0].into());
        let posed = moved(&[(0, pose(50.0, 0.0, 1.0))]).pose(&scene.mesh, &Objects::of(&scene)).unwrap();
        let distances = |rays: &Intersector| {
            let distance = |&d: &Vec3| rays.closest_hit(ORIGIN, d).map(|hit| hit.distance.to_bits());
            fibonacci_directions(2000).iter().map(distance).collect::<Vec<_>>()
        };
        assert!(distances(&baked).iter().any(Option::is_some));
        assert_eq!(differ(&distances(&posable.posed(&posed)), &distances(&Intersector::new(&posed))), 0);
    }
}
