//! Splits the polygons of OBJ and PLY files into triangles.
//!
//! A fan around the first corner is right if all its triangles face the same way: for every convex polygon, and for
//! those that the first corner sees whole. Other polygons are projected on the plane of their Newell normal, the sum of
//! the area vectors of the fan, and their ears are clipped by the crate `earcut`. It drops corners on a straight line.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// Polygons with more corners keep the fan: the time of clipping ears may grow with the cube of their number.
const MOST_CORNERS: usize = 2_000;

/// Area of a triangle that counts as reversed, as a fraction of the polygon's. Rounded positions reverse flat ones.
const REVERSED: f64 = 1e-6;

/// Splits polygons, one after the other; keeps its memory.
#[derive(Default)]
pub(super) struct Polygons {
    places: Vec<DVec3>,
    on_plane: Vec<[f64; 2]>,
    ears: Vec<u32>,
    earcut: Earcut<f64>,
}

impl Polygons {
    /// The triangles of the polygon of `corners`, indices of `positions`. Corners out of range make a fan.
    pub fn split<'a>(&'a mut self, corners: &'a [u32], positions: &[Vec3]) -> impl Iterator<Item = [u32; 3]> + use<'a> {
        let is_fan = corners.len() < 4 || self.clip_ears(corners, positions).is_none();
        let ears: &[[u32; 3]] = if is_fan { &[] } else { self.ears.as_chunks().0 };
        let fan = 2..if is_fan { corners.len() } else { 0 };
        let fan = fan.map(move |i| [corners[0], corners[i - 1], corners[i]]);
        fan.chain(ears.iter().map(move |ear| ear.map(|i| corners[i as usize])))
    }

    /// Fills `ears` with indices of `corners`; `None` if the fan is right, or nothing better is known.
    fn clip_ears(&mut self, corners: &[u32], positions: &[Vec3]) -> Option<()> {
        if corners.len() > MOST_CORNERS {
            return None;
        }
        self.places.clear();
        for &corner in corners {
            self.places.push(positions.get(corner as usize)?.as_dvec3());
        }
        let normal: DVec3 = fan_areas(&self.places).sum();
        let reversed = -REVERSED * normal.length_squared();
        if !fan_areas(&self.places).any(|area| area.dot(normal) < reversed) {
            return None;
        }
        let axis = normal.try_normalize()?;
        let (right, up) = axis.any_orthonormal_pair();
        self.on_plane.clear();
        let from = self.places[0];
        self.on_plane.extend(self.places.iter().map(|&p| [(p - from).dot(right), (p - from).dot(up)]));
        self.earcut.earcut_slice(&self.on_plane, &[], &mut self.ears);
        let way = right.cross(up).dot(axis);
        for ear in self.ears.as_chunks_mut::<3>().0 {
            let [a, b, c] = ear.map(|i| DVec2::from(self.on_plane[i as usize]));
            if (b - a).perp_dot(c - a) * way < 0.0 {
                ear.swap(1, 2);
            }
        }
        (!self.ears.is_empty()).then_some(())
    }
}

/// Area vectors, doubled, of the triangles of a fan around the first place.
fn fan_areas(places: &[DVec3]) -> impl Iterator<Item = DVec3> {
    places[1..].windows(2).map(move |pair| (pair[0] - places[0]).cross(pair[1] - places[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(polygon: &[Vec3]) -> Vec<[u32; 3]> {
        let corners: Vec<u32> = (0..polygon.len() as u32).collect();
        Polygons::default().split(&corners, polygon).collect()
    }

    fn fan(count: usize) -> Vec<[u32; 3]> {
        (2..count as u32).map(|i| [0, i - 1, i]).collect()
    }

    /// The sum of the areas and the length of the sum of the area vectors: they agree if nothing overlaps.
    fn areas(polygon: &[Vec3], triangles: &[[u32; 3]]) -> [f32; 2] {
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|i| polygon[i as usize]);
            0.5 * (b - a).cross(c - a)
        };
        [
            triangles.iter().map(|corners| area(corners).length()).sum(),
            triangles.iter().map(area).sum::<Vec3>().length(),
        ]
    }

    /// A polygon of the plane, in a plane with the normal (1, 2, 3).
    fn tilted(polygon: &[[f32; 2]]) -> Vec<Vec3> {
        let turn = glam::Quat::from_rotation_arc(Vec3::Z, Vec3::new(1.0, 2.0, 3.0).normalize());
        polygon.iter().map(|p| turn * Vec3::new(p[0], p[1], 0.0) + Vec3::new(5.0, -3.0, 2.0)).collect()
    }

    const C: [[f32; 2]; 8] =
        [[1.5, -0.5], [-0.5, -0.5], [-0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [-1.5, 1.5], [-1.5, -1.5], [1.5, -1.5]];
    const ARROW: [[f32; 2]; 4] = [[-1.0, -1.0], [0.0, -0.4], [1.0, -1.0], [0.0, 1.0]];

    #[test]
    fn concave_polygons_are_covered_once_from_every_first_corner_and_both_sides() {
        for (polygon, area) in [(&C[..], 7.0), (&ARROW[..], 1.4)] {
            for first in 0..polygon.len() {
                let mut polygon = tilted(polygon);
                polygon.rotate_left(first);
                for _ in 0..2 {
                    let [sum, of_sum] = areas(&polygon, &triangles(&polygon));
                    assert!((sum - area).abs() < 1e-4 && (of_sum - area).abs() < 1e-4, "{first}: {sum} {of_sum}");
                    let newell: Vec3 =
                        fan_areas(&polygon.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>()).sum::<DVec3>().as_vec3();
                    for [a, b, c] in triangles(&polygon).iter().map(|t| t.map(|i| polygon[i as usize])) {
                        assert!((b - a).cross(c - a).dot(newell) >= -1e-4, "all face the way of the polygon");
                    }
                    polygon.reverse();
                }
            }
        }
        let (c, arrow) = (tilted(&C), tilted(&ARROW));
        assert!(areas(&c, &fan(8))[0] > 9.0 && areas(&arrow, &fan(4))[0] > 1.9, "negative control: the fan overlaps");
    }

    #[test]
    fn corners_on_a_straight_line_cost_no_area() {
        // The letter L with corners in the middle of its sides, from each first corner.
        let polygon: [[f32; 2]; 10] = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.5],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.5, 2.0],
            [0.0, 2.0],
            [0.0, 1.0],
        ];
        for first in 0..polygon.len() {
            let mut polygon = tilted(&polygon);
            polygon.rotate_left(first);
            let [sum, of_sum] = areas(&polygon, &triangles(&polygon));
            assert!((sum - 3.0).abs() < 1e-4 && (of_sum - 3.0).abs() < 1e-4, "{first}: {sum} {of_sum}");
        }
    }

    #[test]
    fn triangles_convex_polygons_and_polygons_without_a_plane_keep_the_fan() {
        let circle: Vec<[f32; 2]> = (0..40).map(|i| (i as f32 * 0.157).sin_cos().into()).collect();
        let not_finite = [[0.0, 0.0], [f32::NAN, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for polygon in [&circle[..3], &circle[..4], &circle[..], &[[0.0, 0.0]; 5][..], &not_finite[..]] {
            assert_eq!(triangles(&tilted(polygon)), fan(polygon.len()));
        }
        let mut polygons = Polygons::default();
        let out_of_range = polygons.split(&[0, 9, 1, 2], &tilted(&ARROW)).collect::<Vec<_>>();
        assert_eq!(out_of_range, [[0, 9, 1], [0, 1, 2]]);
        for none in 0..3 {
            assert_eq!(triangles(&tilted(&ARROW[..none])), fan(none));
        }
    }

    #[test]
    fn tangled_polygons_end() {
        let mut random = fastrand::Rng::with_seed(7);
        for (count, rounds) in [(4, 20), (5, 20), (9, 20), (30, 20), (300, 20), (MOST_CORNERS, 1)] {
            for _ in 0..rounds {
                let polygon: Vec<[f32; 2]> = (0..count).map(|_| [random.f32(), random.f32()]).collect();
                assert!(triangles(&tilted(&polygon)).len() <= 2 * count);
            }
        }
    }
}
