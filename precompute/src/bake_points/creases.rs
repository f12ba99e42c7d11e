//! Where bake points in concave edges sample light from surfaces near by.
//!
//! At the foot of a wall the floor is seen edge on and fills no solid angle, and just above it fills half of the view.
//! Interpolation between vertices takes such a point for the strip of wall around it, so it samples in that strip.

use super::{BakePoint, BakePoints};
use glam::Vec3;
use lapidary_core::{ray::Intersector, scene::Mesh};
use rayon::prelude::*;

/// A point that lies nearer to the middle of its triangles than this many offsets stays.
const LEAST_SHIFT: f32 = 4.0;

impl BakePoints {
    /// The points, those in concave edges moved to the centroid of what interpolation takes them for.
    pub fn off_creases(&self, mesh: &Mesh, scene: &Intersector) -> Vec<BakePoint> {
        let centroids = self.hat_centroids(mesh);
        let moved = |(point, &centroid): (&BakePoint, &Vec3)| {
            // Around a vertex of a ball it lies inside the ball.
            let below = (centroid - point.position).dot(point.normal).min(0.0);
            let inside = BakePoint { position: centroid - point.normal * below, ..*point };
            if is_in_crease(point, &inside, scene) { inside } else { *point }
        };
        self.points.par_iter().zip(&centroids).map(moved).collect()
    }

    /// Centroid of the hat function of each point: one at its vertices, falling to nil at their neighbours.
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

/// Whether another surface rises just behind the point, seen from further inside its own.
fn is_in_crease(point: &BakePoint, inside: &BakePoint, scene: &Intersector) -> bool {
    let back = point.position - inside.position;
    // On the lower side of a sheet what curves away above comes closer.
    let origin = inside.origin(true);
    back.length() > LEAST_SHIFT * point.offset && scene.occluded_between(origin, origin + 2.0 * back)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sidedness::{
        classify,
        tests::{cuboid, floor, scene_of},
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
            assert_eq!(before.position != after.position, at_foot, "{before:?} {after:?}");
            // A square of two triangles: a corner of one has its centroid at a quarter of the side, of two at three eighths.
            let height = after.position.y;
            assert!(!at_foot || (0.24..0.38).contains(&height), "{height}");
            assert!((after.position - before.position).dot(before.normal).abs() < 1e-6, "in its own surface");
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
            assert_eq!(before, after);
        }
    }
}
