//! The nearest point of a surface, found in a hierarchy of boxes.

use super::surface::Surface;
use glam::Vec3;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2_from_tris},
    triangle::Triangle,
};
use std::time::Duration;

/// Triangles at most this much farther than the nearest one also count as near, relative to the diagonal of the
/// surface: they meet at the point.
const TIE: f32 = 1e-6;

/// Largest difference of a normal's cosine to the requested normal from the best, for facing the same way.
const SAME_WAY: f32 = 1e-3;

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct NearestPoint {
    /// Index of the triangle.
    pub triangle: usize,
    /// Weights of its corners.
    pub weights: [f32; 3],
    /// Distance in meters.
    pub distance: f32,
    /// Cosine between its normal and the requested one.
    agreement: f32,
}

/// Search structure for the points of a surface.
pub struct NearestPoints<'a> {
    surface: &'a Surface,
    triangles: &'a [[u32; 3]],
    hierarchy: Bvh2,
    tie: f32,
}

impl<'a> NearestPoints<'a> {
    /// Indexes the triangles of a surface with normals.
    pub fn new(surface: &'a Surface, triangles: &'a [[u32; 3]]) -> Self {
        let corners: Vec<Triangle> = triangles.iter().map(|&t| triangle(surface.corners(t))).collect();
        let hierarchy = build_bvh2_from_tris(&corners, BvhBuildParams::fast_build(), &mut Duration::default());
        let diagonal = hierarchy.nodes.first().map_or(0.0, |root| root.aabb.diagonal().length());
        Self { surface, triangles, hierarchy, tie: TIE * diagonal }
    }

    /// The point nearest to a place. Where triangles meet, the one whose normal is closest to `normal`. `None` if there
    /// are no triangles.
    pub fn find(&self, place: Vec3, normal: Vec3) -> Option<NearestPoint> {
        let mut found: Option<NearestPoint> = None;
        self.visit(place, |triangle| {
            let point = self.point(triangle, place, normal);
            let is_better = |known: &NearestPoint| {
                point.distance + self.tie < known.distance
                    || (point.distance <= known.distance + self.tie && point.agreement > known.agreement + SAME_WAY)
            };
            if found.as_ref().is_none_or(is_better) {
                found = Some(point);
            }
            found.map_or(f32::INFINITY, |found| found.distance + self.tie)
        });
        found
    }

    /// All points as near as the result of [`Self::find`] that face the same way.
    pub fn meeting(&self, place: Vec3, normal: Vec3) -> Vec<NearestPoint> {
        let Some(nearest) = self.find(place, normal) else { return Vec::new() };
        let (reach, mut meeting) = (nearest.distance + self.tie, Vec::new());
        self.visit(place, |triangle| {
            let point = self.point(triangle, place, normal);
            if point.distance <= reach && point.agreement >= nearest.agreement - SAME_WAY {
                meeting.push(point);
            }
            reach
        });
        meeting
    }

    /// Calls `each` with triangles, the nearest boxes first. It returns the distance up to which others count.
    fn visit(&self, place: Vec3, mut each: impl FnMut(usize) -> f32) {
        let nodes = &self.hierarchy.nodes;
        let mut reach = f32::INFINITY;
        let mut pending: Vec<(f32, usize)> =
            nodes.first().map(|root| (distance_to(&root.aabb, place), 0)).into_iter().collect();
        while let Some((distance, index)) = pending.pop() {
            if distance > reach {
                continue;
            }
            let (node, first) = (&nodes[index], nodes[index].first_index as usize);
            if node.is_leaf() {
                let triangles = &self.hierarchy.primitive_indices[first..first + node.prim_count as usize];
                triangles.iter().for_each(|&triangle| reach = each(triangle as usize));
            } else {
                let mut children = [first, first + 1].map(|child| (distance_to(&nodes[child].aabb, place), child));
                children.sort_by(|a, b| b.0.total_cmp(&a.0));
                pending.extend(children);
            }
        }
    }

    /// The point of a triangle nearest to a place.
    fn point(&self, triangle: usize, place: Vec3, normal: Vec3) -> NearestPoint {
        let corners = self.triangles[triangle];
        let weights = nearest_weights(self.surface.corners(corners), place);
        let distance = self.surface.position(corners, weights).distance(place);
        let agreement = self.surface.normal(corners, weights).dot(normal);
        NearestPoint { triangle, weights, distance, agreement }
    }
}

fn triangle([v0, v1, v2]: [Vec3; 3]) -> Triangle {
    Triangle { v0: v0.into(), v1: v1.into(), v2: v2.into() }
}

/// Distance of a point from a box; 0 inside.
fn distance_to(aabb: &Aabb, point: Vec3) -> f32 {
    let (least, most): (Vec3, Vec3) = (aabb.min.into(), aabb.max.into());
    (least - point).max(point - most).max(Vec3::ZERO).length()
}

/// Weights of the corners of a triangle at its point nearest to `p` (Ericson 2005, *Real-Time Collision Detection*, 5.1.5).
fn nearest_weights([a, b, c]: [Vec3; 3], p: Vec3) -> [f32; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let [va, vb, vc] = [d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2];
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return along([0, 1], d1, d1 - d3);
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return along([0, 2], d2, d2 - d6);
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return along([1, 2], d4 - d3, (d4 - d3) + (d5 - d6));
    }
    let sum = va + vb + vc;
    if sum > 0.0 { [va / sum, vb / sum, vc / sum] } else { [1.0, 0.0, 0.0] }
}

/// Weights on the edge between two corners.
fn along([from, to]: [usize; 2], part: f32, whole: f32) -> [f32; 3] {
    let share = if whole > 0.0 { part / whole } else { 0.0 };
    let mut weights = [0.0; 3];
    (weights[from], weights[to]) = (1.0 - share, share);
    weights
}

impl Surface {
    fn corners(&self, corners: [u32; 3]) -> [Vec3; 3] {
        corners.map(|corner| self.positions[corner as usize])
    }

    fn position(&self, corners: [u32; 3], weights: [f32; 3]) -> Vec3 {
        blend(&self.positions, corners, weights)
    }

    fn normal(&self, corners: [u32; 3], weights: [f32; 3]) -> Vec3 {
        blend(&self.normals, corners, weights).normalize_or_zero()
    }
}

/// The mean of values at the corners of a triangle.
#[inline]
pub fn blend(values: &[Vec3], corners: [u32; 3], weights: [f32; 3]) -> Vec3 {
    let [a, b, c] = corners.map(|corner| values[corner as usize]);
    a * weights[0] + b * weights[1] + c * weights[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    /// A ball of triangles, each with its own corners and normal.
    fn ball() -> (Surface, Vec<[u32; 3]>) {
        let points = fibonacci_directions(600);
        let corners = |i: usize| [points[i], points[i + 5], points[i + 8]];
        let positions: Vec<Vec3> = (0..592).flat_map(corners).collect();
        let normals = positions.iter().map(|p| p.normalize()).collect();
        let triangles = (0..592).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        (Surface { positions, normals, tangents: Vec::new() }, triangles)
    }

    #[test]
    fn the_nearest_point_is_that_of_a_search_through_all_triangles() {
        let (surface, triangles) = ball();
        let points = NearestPoints::new(&surface, &triangles);
        for (i, direction) in fibonacci_directions(300).into_iter().enumerate() {
            let place = direction * [0.3, 1.0, 2.5][i % 3];
            let found = points.find(place, direction).unwrap();
            let distances = triangles.iter().map(|&corners| {
                surface.position(corners, nearest_weights(surface.corners(corners), place)).distance(place)
            });
            let nearest = distances.fold(f32::INFINITY, f32::min);
            assert!((found.distance - nearest).abs() < 1e-5, "{} {nearest}", found.distance);
        }
        assert!(NearestPoints::new(&surface, &[]).find(Vec3::ZERO, Vec3::Y).is_none());
    }

    #[test]
    fn weights_are_those_of_no_nearer_point_of_the_triangle() {
        let corners = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.3), Vec3::new(0.5, 1.0, -0.2)];
        for place in fibonacci_directions(200).into_iter().map(|d| 2.0 * d + Vec3::new(0.8, 0.3, 0.0)) {
            let at = |w: [f32; 3]| corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
            let nearest = at(nearest_weights(corners, place)).distance(place);
            let all = (0..=40).flat_map(|i| (0..=40 - i).map(move |j| [i, j, 40 - i - j].map(|k| k as f32 / 40.0)));
            let least = all.map(|weights| at(weights).distance(place)).fold(f32::INFINITY, f32::min);
            assert!(nearest <= least + 1e-5 && nearest > least - 0.05, "{nearest} {least}");
        }
    }

    #[test]
    fn where_two_surfaces_touch_the_normal_decides() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Z].repeat(2);
        let normals = [[Vec3::NEG_Y; 3], [Vec3::Y; 3]].concat();
        let surface = Surface { positions, normals, tangents: Vec::new() };
        let triangles = [[0, 1, 2], [3, 5, 4]];
        let points = NearestPoints::new(&surface, &triangles);
        let find = |normal| points.find(Vec3::new(0.2, 0.0, 0.2), normal).unwrap().triangle;
        assert_eq!((find(Vec3::NEG_Y), find(Vec3::Y)), (0, 1));
    }
}
