//! Detects a scene's own floor by the lowest surfaces over its footprint.

use crate::{bounds::Bounds, mesh::Mesh};
use glam::{Vec2, Vec3};

/// Cells along each side of the grid over a scene's footprint.
const CELLS: usize = 64;
/// Smallest share of the footprint that a floor covers.
const FLOOR_COVERS: f32 = 0.5;
/// Largest height of a floor above the lowest point, as a share of the diagonal: slabs are thin.
const FLOOR_HEIGHT: f32 = 0.05;

/// Whether a scene has its own floor: over most of its footprint there is a surface to stand on, close above the lowest
/// point, or in the lower half of the scene with nothing below, such as terrain.
pub fn has_floor(mesh: &Mesh) -> bool {
    let bounds = mesh.bounds();
    let mut cells = vec![Column::default(); CELLS * CELLS];
    (0..mesh.triangles_of_scene()).for_each(|t| Column::add_triangle(&mut cells, mesh, t, bounds));
    let highest = [bounds.min.y + FLOOR_HEIGHT * bounds.diagonal(), bounds.center().y];
    let floors = cells.iter().filter(|column| column.has_floor(highest)).count();
    floors as f32 >= FLOOR_COVERS * cells.len() as f32
}

/// The lowest surfaces over a cell of the footprint, by height.
#[derive(Clone, Copy)]
struct Column {
    facing_up: f32,
    facing_down: f32,
}

impl Default for Column {
    fn default() -> Self {
        Self { facing_up: f32::INFINITY, facing_down: f32::INFINITY }
    }
}

impl Column {
    /// Whether the lowest surface facing up is a floor: below `slab`, or below `land` with no surface under it.
    fn has_floor(&self, [slab, land]: [f32; 2]) -> bool {
        self.facing_up <= slab || self.facing_up <= land && self.facing_up <= self.facing_down
    }

    /// Adds the heights of a triangle over the centers of the cells that it covers.
    fn add_triangle(cells: &mut [Self], mesh: &Mesh, triangle: usize, bounds: Bounds) {
        let extent = (bounds.max - bounds.min).max(Vec3::splat(1e-6 * bounds.diagonal()));
        let corners = mesh.corners(triangle).map(|corner| (corner - bounds.min) / extent * CELLS as f32);
        let [a, b, c] = corners.map(|corner| Vec2::new(corner.x, corner.z));
        let heights = mesh.corners(triangle).map(|corner| corner.y);
        let twice_area = (b - a).perp_dot(c - a);
        if twice_area == 0.0 {
            return;
        }
        let covered = |low: f32, high: f32| {
            (low - 0.5).ceil().max(0.0) as usize..((high - 0.5).floor() + 1.0).clamp(0.0, CELLS as f32) as usize
        };
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for z in covered(low.y, high.y) {
            for x in covered(low.x, high.x) {
                let middle = Vec2::new(x as f32 + 0.5, z as f32 + 0.5);
                let weights =
                    [(c - b).perp_dot(middle - b), (a - c).perp_dot(middle - c), (b - a).perp_dot(middle - a)]
                        .map(|weight| weight / twice_area);
                if weights.iter().all(|&weight| weight >= 0.0) {
                    let height: f32 = weights.iter().zip(heights).map(|(weight, height)| weight * height).sum();
                    // Counter-clockwise in x and z is downward.
                    let cell = &mut cells[z * CELLS + x];
                    let lowest = if twice_area < 0.0 { &mut cell.facing_up } else { &mut cell.facing_down };
                    *lowest = lowest.min(height);
                }
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::Vec4;

    /// A box between two corners, seen from outside, or a floor of zero thickness if its corners have equal height.
    fn block(min: Vec3, max: Vec3) -> Mesh {
        let corner = |i: u32| Vec3::from_array(std::array::from_fn(|k| if i >> k & 1 == 1 { max[k] } else { min[k] }));
        let quads: &[[u32; 4]] = match min.y == max.y {
            true => &[[2, 6, 7, 3]],
            false => &[[2, 6, 7, 3], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6]],
        };
        let triangles: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh {
            positions: (0..8).map(corner).collect(),
            normals: vec![Vec3::Y; 8],
            tangents: vec![Vec4::X; 8],
            uvs: vec![Vec2::ZERO; 8],
            triangle_material: vec![0; triangles.len()],
            triangle_object: vec![0; triangles.len()],
            triangles,
            ..Default::default()
        }
    }

    /// Both as one mesh.
    fn both(mut a: Mesh, b: Mesh) -> Mesh {
        a.append_ground(b);
        Mesh { ground: None, ..a }
    }

    /// A cube of a meter that stands at the origin.
    pub fn cube() -> Mesh {
        block(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5))
    }

    #[test]
    fn a_cube_is_a_lone_object_and_one_on_a_floor_or_slab_is_not() {
        assert!(!has_floor(&cube()));
        for (bottom, name) in [(0.0, "floor"), (-0.1, "slab")] {
            let mut mesh = both(cube(), block(Vec3::new(-2.0, bottom, -2.0), Vec3::new(2.0, 0.0, 2.0)));
            assert!(has_floor(&mesh), "{name}");
            // Upside down it hangs from a ceiling.
            mesh.positions.iter_mut().for_each(|p| *p *= Vec3::new(1.0, -1.0, -1.0));
            assert!(!has_floor(&mesh), "{name}");
        }
        let mut open = cube();
        open.triangles.retain(|corners| corners.iter().any(|&v| open.positions[v as usize].y > 0.0));
        open.triangle_material.truncate(open.triangles.len());
        assert!(open.triangles.len() == 10 && !has_floor(&open), "without a bottom");
        let small = both(cube(), block(Vec3::ZERO, Vec3::new(0.1, 0.0, 0.1)));
        assert!(!has_floor(&small), "negative control");
    }
}
