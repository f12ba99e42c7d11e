//! Sample positions of bake points in concave edges, for light from close surfaces.
//!
//! At the foot of a wall the floor is seen edge on and fills no solid angle; just above, it fills half of the view. Interpolation
//! uses such a point for the strip of wall around it, so it samples within that strip.

use super::{BakePoint, BakePoints};
use crate::vertices::side::Side;
use glam::Vec3;
use lapidary_core::{ray::Intersector, scene::Mesh};
use rayon::prelude::*;

/// A point stays if it is closer to the center of its triangles than this many offsets.
const LEAST_SHIFT: f32 = 4.0;
/// Smallest cosine between a point's normal and a triangle that counts: below it the point would rise too far.
const LEAST_LEAN: f32 = 0.2;

impl BakePoints {
    /// The points. Those in concave edges move to the centroid of their interpolation area. An edge of a sheet is concave on one
    /// side.
    pub fn off_creases(&self, mesh: &Mesh, scene: &Intersector) -> Vec<BakePoint> {
        let centroids = self.hat_centroids(mesh);
        let rises = self.rises(mesh, &centroids);
        let moved = |((point, &centroid), &[above, below]): ((&BakePoint, &Vec3), &[f32; 2])| {
            let inside = BakePoint { places: [above, -below].map(|rise| centroid + point.normal * rise), ..*point };
            let mut places = [point.position; 2];
            for &side in point.sides() {
                let from = if is_in_crease(point, &inside, scene, side) { &inside } else { point };
                places[side as usize] = from.place(side);
            }
            BakePoint { places, ..*point }
        };
        self.points.par_iter().zip(&centroids).zip(&rises).map(moved).collect()
    }

    /// Distances by which each centroid must rise along its point's normal, and sink against it, to lie on one side of all its
    /// triangles. Around a vertex of a ball the centroid lies inside the ball, and with a leaning normal beside the surface. The
    /// distance is at most the one between centroid and point.
    fn rises(&self, mesh: &Mesh, centroids: &[Vec3]) -> Vec<[f32; 2]> {
        let mut rises = vec![[0.0_f32; 2]; self.points.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let face = mesh.area_vector(t).normalize_or_zero();
            for &v in corners {
                let id = self.of_vertex[v as usize] as usize;
                let (point, [above, below]) = (&self.points[id], &mut rises[id]);
                let lean = face.dot(point.normal);
                if lean.abs() > LEAST_LEAN {
                    let shift = centroids[id] - point.position;
                    let height = (shift.dot(face) / lean).clamp(-shift.length(), shift.length());
                    *above = above.max(-height);
                    *below = below.max(height);
                }
            }
        }
        rises
    }

    /// Centroid of the hat function of each point: one at its vertices, falling to zero at their neighbors.
    fn hat_centroids(&self, mesh: &Mesh) -> Vec<Vec3> {
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); self.points.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let area = mesh.area_vector(t).length();
            let middle = mesh.corners(t).iter().sum::<Vec3>();
            for (&v, corner) in corners.iter().zip(mesh.corners(t)) {
                let (sum, weight) = &mut sums[self.of_vertex[v as usize] as usize];
                *sum += (0.25 * (middle + corner) - corner) * area;
                *weight += area;
            }
        }
        let centroid = |((shift, area), point): (&(Vec3, f32), &BakePoint)| {
            point.position + if *area > 0.0 { *shift / *area } else { Vec3::ZERO }
        };
        sums.iter().zip(&self.points).map(centroid).collect()
    }
}

/// Whether another surface rises just behind a side of the point, tested from a point further inside its own surface.
fn is_in_crease(point: &BakePoint, inside: &BakePoint, scene: &Intersector, side: Side) -> bool {
    let back = point.position - inside.place(side);
    let origin = inside.origin(side);
    back.length() > LEAST_SHIFT * point.offset && scene.occluded_between(origin, origin + 2.0 * back)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        test_scenes::{cuboid, floor, scene_of},
        vertices::sidedness::classify,
    };
    use std::f32::consts::{PI, TAU};

    #[test]
    fn points_at_the_foot_of_a_box_move_up_and_others_stay() {
        let mut triangles = floor(2.0, 0.0).to_vec();
        triangles.extend(cuboid(Vec3::new(0.0, 0.5, 0.0), Vec3::splat(0.5)));
        let scene = scene_of(&triangles);
        let points = BakePoints::new(&scene.mesh, &classify(&scene));
        let moved = points.off_creases(&scene.mesh, &Intersector::new(&scene.mesh));
        for (before, after) in points.points.iter().zip(&moved) {
            let at_foot = before.position.y == 0.0 && before.normal.y == 0.0;
            assert_eq!(before.position != after.place(Side::Front), at_foot, "{before:?} {after:?}");
            // A square of two triangles: the centroid of a corner is at a quarter of the side with one triangle, at three eighths
            // with two.
            let height = after.place(Side::Front).y;
            assert!(!at_foot || (0.24..0.38).contains(&height), "{height}");
            assert!((after.place(Side::Front) - before.position).dot(before.normal).abs() < 1e-6, "in its own surface");
        }
    }

    #[test]
    fn a_fold_of_a_sheet_is_a_crease_from_one_side() {
        // A sheet along x that descends to a valley at z = 0 and rises again.
        let at = |x: f32, z: f32| Vec3::new(x, z.abs(), z);
        let strip = |from: f32, to: f32| {
            [[at(-1.0, from), at(-1.0, to), at(1.0, to)], [at(-1.0, from), at(1.0, to), at(1.0, from)]]
        };
        let triangles: Vec<_> = [strip(-1.0, 0.0), strip(0.0, 1.0)].concat();
        let mut scene = scene_of(&triangles);
        for flip in [false, true] {
            if flip {
                scene.mesh.normals.iter_mut().for_each(|n| *n = -*n);
                scene.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            let points = BakePoints::new(&scene.mesh, &classify(&scene));
            let moved = points.off_creases(&scene.mesh, &Intersector::new(&scene.mesh));
            let in_valley = |p: &&BakePoint| p.position.z == 0.0;
            assert!(moved.iter().filter(in_valley).count() > 0);
            for point in moved.iter().filter(in_valley) {
                assert!(point.two_sided);
                let (inside, outside) =
                    if point.normal.y > 0.0 { (Side::Front, Side::Back) } else { (Side::Back, Side::Front) };
                assert!(point.place(inside) != point.position, "{point:?}");
                assert_eq!(point.place(outside), point.position, "outside of the fold");
            }
        }
    }

    #[test]
    fn a_normal_that_leans_along_a_ridge_leaves_points_outside() {
        // Long strips bent by 20 degrees, with normals that lean along them, as smoothing leaves them on moldings.
        let at = |x: f32, z: f32| Vec3::new(x, -0.3 * z.abs(), z);
        let strip = |from: f32, to: f32| {
            [[at(-9.0, from), at(-9.0, to), at(9.0, to)], [at(-9.0, from), at(9.0, to), at(9.0, from)]]
        };
        let mut scene = scene_of(&[strip(-1.0, 0.0), strip(0.0, 1.0)].concat());
        scene.mesh.normals.fill(Vec3::new(0.3, 1.0, 0.2).normalize());
        let intersector = Intersector::new(&scene.mesh);
        let points = BakePoints::new(&scene.mesh, &classify(&scene));
        for point in points.off_creases(&scene.mesh, &intersector) {
            let (upper, lower) = (point.origin(Side::Front), point.origin(Side::Back));
            assert!(!intersector.occluded(upper, Vec3::Y), "{point:?}");
            assert!(!intersector.occluded(lower, Vec3::NEG_Y), "{point:?}");
        }
    }

    #[test]
    fn points_of_a_coarse_ball_stay_outside_it() {
        let (rings, sides) = (8, 12);
        let at = |ring: usize, side: usize| {
            let (polar, turn) = (PI * ring as f32 / rings as f32, TAU * side as f32 / sides as f32);
            Vec3::new(polar.sin() * turn.sin(), polar.cos(), polar.sin() * turn.cos())
        };
        let mut triangles = Vec::new();
        for (ring, side) in (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
            let [a, b, c, d] = [at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)];
            triangles.extend(
                [[a, b, c], [a, c, d]].into_iter().filter(|t| (t[1] - t[0]).cross(t[2] - t[0]).length() > 1e-4),
            );
        }
        let mut scene = scene_of(&triangles);
        let mesh = &mut scene.mesh;
        mesh.normals = mesh.positions.iter().map(|p| p.normalize()).collect();
        let points = BakePoints::new(&scene.mesh, &classify(&scene));
        let moved = points.off_creases(&scene.mesh, &Intersector::new(&scene.mesh));
        assert!(points.points.len() > 80);
        for (before, after) in points.points.iter().zip(&moved) {
            assert_eq!(before.origin(Side::Front), after.origin(Side::Front));
            assert!(after.origin(Side::Back).length() < 1.0 || !after.two_sided, "{after:?}");
        }
    }
}
