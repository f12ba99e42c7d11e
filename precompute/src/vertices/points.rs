//! Bake points: where visibility is sampled for the vertices, robust against defects of real meshes.

mod creases;
mod sight;

use crate::{
    errors::{BakeError, cancelled},
    observer::Observer,
    vertices::{
        side::Side,
        sidedness::{Sidedness, exact_key},
    },
};
use glam::Vec3;
use lapidary_core::{
    offset,
    ray::{HalfSpace, Intersector},
    scene::Mesh,
    shot::Shot,
    sources::Origin,
    sphere::{fibonacci_directions, frame_around},
    surfel::Surfel,
};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use sight::Sight;

/// Rays that decide whether a point lies inside other geometry.
const BURIAL_RAYS: usize = 48;

/// Largest distance of ray origins from a surface, relative to the least height of its triangles. On a long millimeter-high strip
/// of a molding, rays would otherwise start within the next strip.
const MOST_OFFSET_PER_HEIGHT: f32 = 0.05;

/// A point where visibility is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakePoint {
    /// Position of the vertex in meters.
    pub position: Vec3,
    /// Unit normal, repaired to lie on the side of its triangles.
    pub normal: Vec3,
    /// Distance in meters of ray origins from the surface.
    pub offset: f32,
    /// Height above the tangent plane (as a cosine, at most 0). Every direction below it is below the planes of all adjacent
    /// triangles: a closed surface blocks it, and no ray is needed.
    pub horizon: f32,
    /// Whether the whole sphere is sampled, the lower half from the other side.
    pub two_sided: bool,
    /// Positions in meters where the front and the back are sampled: the vertex position, except in a crease.
    pub places: [Vec3; 2],
}

/// The bake points of a mesh.
#[derive(Clone, Debug, Default)]
pub struct BakePoints {
    /// Distinct points: vertices with the same position, normal and sides share one.
    pub points: Vec<BakePoint>,
    /// The point of each vertex.
    pub of_vertex: Vec<u32>,
}

impl BakePoint {
    /// Point where a surface source samples its visibility of the environment: on its sending side, `offset` meters off.
    pub fn of_surfel(surfel: Surfel, offset: f32) -> Self {
        let Surfel { position, normal, .. } = surfel;
        Self { position, normal, offset, horizon: 0.0, two_sided: false, places: [position; 2] }
    }

    /// Sides on which it samples.
    pub fn sides(&self) -> &'static [Side] {
        if self.two_sided { &Side::BOTH } else { &[Side::Front] }
    }

    /// Origin of rays from a side.
    pub fn origin(&self, side: Side) -> Vec3 {
        self.place(side) + side.normal(self.normal) * self.offset
    }

    /// The point on the surface where a side samples.
    pub fn place(&self, side: Side) -> Vec3 {
        self.places[side as usize]
    }

    /// Smallest cosine between the normal and a face that contains the point, see [`Origin::same_surface_cosine`].
    pub fn same_surface_cosine(&self) -> f32 {
        // The largest tilt of an adjacent face; rounding must not separate that face from its point.
        let tilted = (1.0 - self.horizon * self.horizon).max(0.0).sqrt();
        Origin::SAME_SURFACE_COSINE.min(0.99 * tilted)
    }

    /// The directions sampled from a side. A one-sided point ignores directions behind it.
    pub fn half_of(&self, side: Side) -> HalfSpace {
        // The greatest number below zero: the plane of a two-sided point counts as in front.
        let height = if self.two_sided { 0.0_f32.next_down() } else { self.horizon };
        HalfSpace { normal: self.normal, height, is_above: side == Side::Front }
    }

    /// The side from which a direction is sampled.
    pub fn side_of(&self, direction: Vec3) -> Side {
        if self.half_of(Side::Front).has(direction) { Side::Front } else { Side::Back }
    }
}

impl BakePoints {
    /// One point for each distinct (position, normal, sides) of the mesh's vertices.
    pub fn new(mesh: &Mesh, sides: &Sidedness) -> Self {
        let around = VertexTriangles::new(mesh, sides);
        let diagonal = mesh.bounds().diagonal();
        let mut result = Self::default();
        let mut known = FxHashMap::default();
        for (v, &position) in mesh.positions.iter().enumerate() {
            let normal = around.repaired_normal(v, mesh.normals[v]);
            let point = BakePoint {
                position,
                normal,
                offset: offset::of_baking(around.edge_length[v], MOST_OFFSET_PER_HEIGHT * around.height[v], diagonal),
                horizon: 0.0,
                two_sided: around.two_sided[v],
                places: [position; 2],
            };
            let key = (exact_key(position), exact_key(normal), point.two_sided);
            let id = *known.entry(key).or_insert_with(|| {
                result.points.push(point);
                result.points.len() as u32 - 1
            });
            let shared = &mut result.points[id as usize];
            shared.offset = shared.offset.min(point.offset);
            result.of_vertex.push(id);
        }
        result.lower_horizons(mesh);
        result
    }

    /// The coordinates of all positions in meters, point by point.
    pub fn coordinates(&self) -> Vec<f32> {
        self.points.iter().flat_map(|point| point.position.to_array()).collect()
    }

    /// The horizon of a point is below every plane of the triangles at its vertices.
    fn lower_horizons(&mut self, mesh: &Mesh) {
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let face = mesh.area_vector(t).normalize_or_zero();
            for &v in corners {
                let point = &mut self.points[self.of_vertex[v as usize] as usize];
                // A direction at angle θ above the tangent plane may rise over a face tilted by δ if θ > -δ.
                let sin_tilt = point.normal.cross(face).length().min(1.0);
                let lowest = if point.normal.dot(face) > 0.0 { -sin_tilt } else { -1.0 };
                point.horizon = point.horizon.min(lowest);
            }
        }
    }

    /// The points, moved to sample light from close surfaces, which varies within their triangles. They move out of concave edges,
    /// and out of hiding from the shots.
    pub fn for_sources(&self, mesh: &Mesh, scene: &Intersector, shots: &[Shot]) -> Vec<BakePoint> {
        let mut points = self.off_creases(mesh, scene);
        let sight = Sight::new(mesh, scene, shots, points.len(), &self.of_vertex);
        points.par_iter_mut().enumerate().for_each(|(i, point)| {
            for &side in point.sides() {
                let normal = side.normal(point.normal);
                if let Some(place) = sight.better_place(i, point.position, normal, point.offset) {
                    point.places[side as usize] = place;
                }
            }
        });
        points
    }

    /// Whether each point lies inside a closed piece, which holds if most of its rays hit back faces of such pieces.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`].
    pub fn buried(
        &self,
        scene: &Intersector,
        sides: &Sidedness,
        observer: &dyn Observer,
    ) -> Result<Vec<bool>, BakeError> {
        let mut upper = fibonacci_directions(2 * BURIAL_RAYS);
        upper.retain(|d| d.z > 0.05);
        let sees_insides = |point: &BakePoint, side: Side| {
            let frame = frame_around(side.normal(point.normal));
            let (mut back, mut others) = (0, 0);
            for &d in &upper {
                let hit = scene.closest_hit(point.origin(side), frame * d);
                match hit.is_some_and(|h| h.back_face && sides.closed[h.triangle as usize]) {
                    true => back += 1,
                    false => others += 1,
                }
                // The remaining rays cannot change the result.
                if 2 * back > upper.len() || 2 * others >= upper.len() {
                    break;
                }
            }
            2 * back > upper.len()
        };
        let buried = |p: &BakePoint| {
            cancelled(observer)?;
            Ok(p.sides().iter().all(|&side| sees_insides(p, side)))
        };
        self.points.par_iter().map(buried).collect()
    }
}

/// Properties of the triangles around each vertex.
struct VertexTriangles {
    area: Vec<Vec3>,
    edge_length: Vec<f32>,
    /// Least height of the nondegenerate triangles.
    height: Vec<f32>,
    two_sided: Vec<bool>,
}

impl VertexTriangles {
    fn new(mesh: &Mesh, sides: &Sidedness) -> Self {
        let n = mesh.positions.len();
        let (mut area, mut length, mut uses) = (vec![Vec3::ZERO; n], vec![0.0_f32; n], vec![0.0_f32; n]);
        let (mut two_sided, mut height) = (vec![false; n], vec![f32::INFINITY; n]);
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(t);
            let edges = [a.distance(b), b.distance(c), c.distance(a)];
            let mean_edge = edges.iter().sum::<f32>() / 3.0;
            let height_of_triangle = mesh.area_vector(t).length() / edges.into_iter().fold(0.0, f32::max);
            for &v in corners {
                let v = v as usize;
                area[v] += mesh.area_vector(t);
                length[v] += mean_edge;
                uses[v] += 1.0;
                if height_of_triangle > 0.0 {
                    height[v] = height[v].min(height_of_triangle);
                }
                two_sided[v] |= sides.two_sided[t];
            }
        }
        let edge_length = length.iter().zip(&uses).map(|(l, u)| l / u.max(1.0)).collect();
        Self { area, edge_length, height, two_sided }
    }

    /// The vertex normal, or its faces' mean normal if it is unusable or points away from them.
    fn repaired_normal(&self, vertex: usize, normal: Vec3) -> Vec3 {
        let face = self.area[vertex].normalize_or_zero();
        let normal = normal.normalize_or_zero();
        if normal == Vec3::ZERO || normal.dot(face) < 0.0 { face.try_normalize().unwrap_or(Vec3::Y) } else { normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        observer::Silent,
        test_scenes::{cuboid, floor, scene_of},
        vertices::sidedness::classify,
    };
    use lapidary_core::{camera::Camera, scene::Scene};

    #[test]
    fn for_sources_points_that_a_shot_does_not_see_sample_where_it_sees_their_triangles() {
        // A box stands on a floor of two triangles; one corner of the floor is behind it.
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(-1.5, 0.5, -1.5), Vec3::splat(0.4)));
        let scene = scene_of(&triangles);
        let (points, intersector) = (points(&scene).0, Intersector::new(&scene.mesh));
        let camera = Camera::look_at(Vec3::new(2.0, 1.0, 2.0), Vec3::ZERO, 90.0);
        let shots = [Shot { camera, aspect: 1.0 }];
        let places = |shots: &[Shot]| points.for_sources(&scene.mesh, &intersector, shots);
        let corner = points.points.iter().position(|p| p.position == Vec3::new(-2.0, 0.0, -2.0)).unwrap();
        let [moved, still] = [places(&shots), places(&[])].map(|points| points[corner]);
        assert!(moved.place(Side::Front).distance(Vec3::new(-2.0, 0.0, -2.0)) > 0.5, "{moved:?}");
        assert_eq!(still.place(Side::Front), still.position, "negative control: no shot");
        let seen = points.points.iter().position(|p| p.position == Vec3::new(2.0, 0.0, -2.0)).unwrap();
        assert_eq!(places(&shots)[seen], places(&[])[seen]);
    }

    fn points(scene: &Scene) -> (BakePoints, Vec<bool>) {
        let sides = classify(scene);
        let points = BakePoints::new(&scene.mesh, &sides);
        let buried = points.buried(&Intersector::new(&scene.mesh), &sides, &Silent).unwrap();
        (points, buried)
    }

    #[test]
    fn a_corner_of_a_cube_is_one_point_a_face() {
        let (points, buried) = points(&scene_of(&cuboid(Vec3::ZERO, Vec3::ONE)));
        assert_eq!(points.of_vertex.len(), 36);
        assert_eq!(points.points.len(), 24);
        assert!(buried.iter().all(|b| !b));
        assert!(points.points.iter().all(|p| !p.two_sided && p.horizon > -1e-3));
    }

    #[test]
    fn floor_vertices_inside_a_box_are_buried_and_those_beside_it_are_not() {
        let mut triangles = floor(0.2, 0.0).to_vec();
        triangles.extend(floor(4.0, 0.0));
        triangles.extend(cuboid(Vec3::ZERO, Vec3::splat(0.5)));
        let (points, buried) = points(&scene_of(&triangles));
        for (point, buried) in points.points.iter().zip(buried) {
            let inside = point.position.abs().max_element() < 0.4;
            assert_eq!(buried, inside, "{point:?}");
        }
    }

    #[test]
    fn rays_from_a_thin_strip_start_within_it() {
        // A ledge 1 mm deep and 1 m long.
        let quad = |y: [f32; 2], z: [f32; 2]| {
            let at = |x: f32, i: usize| Vec3::new(x, y[i], z[i]);
            [[at(0.0, 0), at(1.0, 0), at(1.0, 1)], [at(0.0, 0), at(1.0, 1), at(0.0, 1)]]
        };
        let ledge = quad([0.0, 0.0], [0.001, 0.0]);
        let (points, _) = points(&scene_of(&ledge));
        assert!(points.points.iter().all(|p| p.offset < 1e-4), "{:?}", points.points);
        for order in [[0.001, 1.0], [1.0, 0.001]] {
            // Strips of both depths meet in an edge, and its vertices share their points.
            let strips = order.map(|depth| quad([0.0, 0.0], if depth < 0.5 { [depth, 0.0] } else { [0.0, -depth] }));
            let (points, _) = self::points(&scene_of(&strips.concat()));
            assert!(points.points.iter().filter(|p| p.position.z == 0.0).all(|p| p.offset < 1e-4));
        }
        let (wide, _) = self::points(&scene_of(&quad([0.0, 0.0], [1.0, 0.0])));
        assert!(wide.points.iter().all(|p| p.offset > 2e-4), "negative control: {:?}", wide.points);
    }

    #[test]
    fn a_normal_that_points_inward_is_replaced() {
        let mut scene = scene_of(&floor(1.0, 0.0));
        scene.mesh.normals[0] = Vec3::NEG_Y;
        scene.mesh.normals[1] = Vec3::ZERO;
        let (points, _) = points(&scene);
        assert!(points.points.iter().all(|p| p.normal.dot(Vec3::Y) > 0.999));
    }
}
