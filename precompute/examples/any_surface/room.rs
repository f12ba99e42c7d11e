//! The room: a mesh of twelve triangles with colored walls.

use crate::aggregate::passes;
use glam::Vec3;
use lapidary_core::{
    bounds::Bounds,
    ray::Intersector,
    scene::Mesh,
    surfel::{MeshPlace, Surface, Surfel},
};

/// A room two meters wide, high and deep.
pub struct Room {
    mesh: Mesh,
    intersector: Intersector,
}

impl Room {
    pub fn new() -> Self {
        let corner =
            |i: u32| Vec3::new((i & 1) as f32 * 2.0 - 1.0, (i >> 1 & 1) as f32 * 2.0, (i >> 2) as f32 * 2.0 - 1.0);
        // Left, right, floor, ceiling, back, front; all face inward.
        let sides = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = Mesh { positions: (0..8).map(corner).collect(), triangles, ..Default::default() };
        Self { intersector: Intersector::new(&mesh), mesh }
    }
}

impl Surface for Room {
    fn first_hit(&self, origin: Vec3, direction: Vec3) -> Option<Surfel> {
        let hit = self.intersector.closest_hit(origin, direction)?;
        let normal = self.mesh.area_vector(hit.triangle as usize).normalize();
        let place = MeshPlace { triangle: hit.triangle, barycentric: hit.barycentric };
        let normal = if hit.back_face { -normal } else { normal };
        Some(Surfel { position: origin + hit.distance * direction, normal, place })
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        passes(self, from, to)
    }

    fn reflectance(&self, at: &Surfel) -> Vec3 {
        match at.place.triangle / 2 {
            0 => Vec3::new(0.65, 0.06, 0.05),
            1 => Vec3::new(0.10, 0.45, 0.10),
            _ => Vec3::splat(0.7),
        }
    }

    fn bounds(&self) -> Bounds {
        self.mesh.bounds()
    }
}
