//! Sample positions of bake points that are hidden from the shots while part of the surrounding surface is visible.
//!
//! A ceiling continues above its cornice, a wall behind its pictures. Vertices there receive no light from the room, but
//! interpolation uses them for the visible part of their triangles. So they sample in the middle of that part.

use crate::vertices::spread::on_triangle;
use glam::Vec3;
use lapidary_core::{
    ray::Intersector,
    scene::Mesh,
    shot::{Frustum, Shot},
};

/// Points tested in each triangle around a hidden point.
const PLACES: u32 = 16;

/// Parts of a mesh around its points that are visible in shots.
pub(super) struct Sight<'a> {
    mesh: &'a Mesh,
    scene: &'a Intersector,
    frustums: Vec<Frustum>,
    /// Triangles around each point, and its corner in each; empty without shots.
    around: Vec<Vec<[u32; 2]>>,
}

impl<'a> Sight<'a> {
    /// For this many points; `of_vertex` gives the point of each vertex.
    pub fn new(mesh: &'a Mesh, scene: &'a Intersector, shots: &[Shot], points: usize, of_vertex: &[u32]) -> Self {
        let mut around = vec![Vec::new(); if shots.is_empty() { 0 } else { points }];
        let triangles = (0..).zip(&mesh.triangles).filter(|_| !shots.is_empty());
        for (triangle, corners) in triangles {
            (0..).zip(corners).for_each(|(corner, &v)| around[of_vertex[v as usize] as usize].push([triangle, corner]));
        }
        Self { mesh, scene, frustums: shots.iter().map(Shot::frustum).collect(), around }
    }

    /// A better sample position than `position`, on the side of a unit normal, where rays start `offset` meters off. It is the
    /// middle of the visible part of its triangles, weighted as in interpolation. `None` if the point is visible to an eye that it
    /// faces (inside or outside the picture), if it faces no eye, or if everything around it is hidden.
    pub fn better_place(&self, point: usize, position: Vec3, normal: Vec3, offset: f32) -> Option<Vec3> {
        let place = position + normal * offset;
        let mut facing = self.frustums.iter().filter(|f| faces(f, place, normal)).peekable();
        let is_hidden = facing.peek().is_some() && facing.all(|f| self.scene.occluded_between(place, f.eye));
        is_hidden.then(|| middle(&self.seen_around(point, normal, offset))).flatten()
    }

    /// Visible points of the triangles around a point, with their weights.
    fn seen_around(&self, point: usize, normal: Vec3, offset: f32) -> Vec<(Vec3, f32)> {
        let mut seen = Vec::new();
        for &[triangle, corner] in &self.around[point] {
            let corners = self.mesh.corners(triangle as usize);
            let [a, b, c] = std::array::from_fn(|i| corners[(corner as usize + i) % 3]);
            let area = self.mesh.area_vector(triangle as usize);
            let face = area.normalize_or_zero();
            let face = if face.dot(normal) < 0.0 { -face } else { face };
            for [u, v] in (0..PLACES).map(on_triangle) {
                let place = a + (b - a) * u + (c - a) * v;
                if self.frustums.iter().any(|frustum| self.sees(frustum, place, face, offset)) {
                    seen.push((place, (1.0 - u - v) * area.length()));
                }
            }
        }
        seen
    }

    fn sees(&self, frustum: &Frustum, place: Vec3, normal: Vec3, offset: f32) -> bool {
        let above = place + normal * offset;
        let in_picture = frustum.magnification(place, normal) > 0.0 && faces(frustum, above, normal);
        in_picture && !self.scene.occluded_between(above, frustum.eye)
    }
}

/// Whether the eye is above a surface.
fn faces(frustum: &Frustum, place: Vec3, normal: Vec3) -> bool {
    (frustum.eye - place).dot(normal) > 0.0
}

/// The weighted point closest to the mean.
fn middle(places: &[(Vec3, f32)]) -> Option<Vec3> {
    let weight: f32 = places.iter().map(|p| p.1).sum();
    let mean = places.iter().map(|&(place, weight)| place * weight).sum::<Vec3>() / weight;
    let distance_sq = |(place, _): &(Vec3, f32)| place.distance_squared(mean);
    places.iter().min_by(|a, b| distance_sq(a).total_cmp(&distance_sq(b))).map(|p| p.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lapidary_core::camera::Camera;

    /// Distance of vertices in meters.
    const CELL: f32 = 0.5;
    const SIDE: i32 = 6;

    /// A floor in cells, and a plate over its half with negative x.
    fn floor_under_plate() -> Mesh {
        let mut mesh = Mesh::default();
        let width = 2 * SIDE + 1;
        let at = |i: i32| ((i % width - SIDE) as f32, (i / width - SIDE) as f32);
        mesh.positions = (0..width * width).map(|i| Vec3::new(at(i).0, 0.0, at(i).1) * CELL).collect();
        for corner in (0..width * (width - 1)).filter(|i| i % width < width - 1) {
            let [a, b, c, d] = [corner, corner + width, corner + width + 1, corner + 1].map(|i| i as u32);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        let first = mesh.positions.len() as u32;
        let plate = [(-3.0, -4.0), (-3.0, 4.0), (0.2, 4.0), (0.2, -4.0)];
        mesh.positions.extend(plate.map(|(x, z)| Vec3::new(x, 0.3, z)));
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh
    }

    fn shot(eye: Vec3, target: Vec3) -> Shot {
        Shot { camera: Camera::look_at(eye, target, 90.0), aspect: 1.5 }
    }

    /// Vertices of the floor, and their better places.
    fn places(shots: &[Shot]) -> Vec<(Vec3, Option<Vec3>)> {
        let mesh = floor_under_plate();
        let scene = Intersector::new(&mesh);
        let of_vertex: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        let sight = Sight::new(&mesh, &scene, shots, of_vertex.len(), &of_vertex);
        let floor = mesh.positions.iter().enumerate().filter(|(_, p)| p.y == 0.0);
        floor.map(|(v, &p)| (p, sight.better_place(v, p, Vec3::Y, 1e-4))).collect()
    }

    #[test]
    fn hidden_points_have_a_better_place_in_what_is_seen_of_their_triangles() {
        let places = places(&[shot(Vec3::new(3.0, 3.0, 0.0), Vec3::ZERO)]);
        // The line from the eye past the plate's edge meets the floor here.
        let first_seen = 0.2 - 0.3 * 2.8 / 2.7;
        let (at_edge, others): (Vec<_>, Vec<_>) =
            places.into_iter().partition(|(p, _)| p.x == -CELL && p.z.abs() < 1.0);
        assert_eq!(at_edge.len(), 3);
        for (position, better) in at_edge {
            let better = better.unwrap();
            assert!((first_seen..0.0).contains(&better.x), "{position} to {better}");
            assert!(better.y.abs() < 1e-6 && (better.z - position.z).abs() < CELL, "in its triangles: {better}");
        }
        let away = others.iter().filter(|(p, _)| p.x != -CELL);
        assert!(away.clone().count() > 100, "what is seen, and what is hidden with all around it");
        assert!(away.clone().all(|(_, better)| better.is_none()));
    }

    #[test]
    fn there_is_none_without_a_shot_of_the_surroundings() {
        let has_none = |shots: &[Shot]| places(shots).iter().all(|(_, better)| better.is_none());
        let (eye, below) = (Vec3::new(3.0, 3.0, 0.0), Vec3::new(3.0, 0.1, 0.0));
        assert!(has_none(&[]));
        assert!(has_none(&[shot(eye, Vec3::new(6.0, 3.0, 0.0))]), "a shot of something else");
        assert!(has_none(&[shot(eye, Vec3::ZERO), shot(below, Vec3::ZERO)]), "another shot sees all of them");
        assert!(has_none(&[shot(-eye, Vec3::NEG_Y)]), "a shot of the floor from below");
        assert!(!has_none(&[shot(eye, Vec3::ZERO)]), "negative control");
    }
}
