//! The test scene for the paper's links: any number of vertices, and known form factors.

use crate::mesh::Mesh;
use glam::Vec3;

/// An empty closed room of 2 m around the origin, seen from inside. Each of its six walls is a grid of `side` x `side` squares that
/// share vertices, 6 (side + 1)² in all.
pub fn room_of_grids(side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for inward in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        add_wall(&mut mesh, inward, side);
    }
    mesh
}

fn add_wall(mesh: &mut Mesh, inward: Vec3, side: u32) {
    let (u, v) = inward.any_orthonormal_pair();
    let (u, v) = if u.cross(v).dot(inward) > 0.0 { (u, v) } else { (v, u) };
    let first = mesh.positions.len() as u32;
    let across = |i: u32| 2.0 * i as f32 / side as f32 - 1.0;
    for (i, j) in (0..=side).flat_map(|i| (0..=side).map(move |j| (i, j))) {
        mesh.positions.push(u * across(i) + v * across(j) - inward);
        mesh.normals.push(inward);
    }
    let vertex = |i: u32, j: u32| first + i * (side + 1) + j;
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        mesh.triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)]);
        mesh.triangles.push([vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_face_inward_and_close_the_room() {
        let mesh = room_of_grids(3);
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (6 * 16, 6 * 18));
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            let inward = mesh.normals[corners[0] as usize];
            assert!(mesh.area_vector(triangle).normalize().dot(inward) > 0.999);
            assert!(mesh.positions[corners[0] as usize].dot(inward) < 0.0);
        }
        let area: f32 = (0..mesh.triangles.len()).map(|t| 0.5 * mesh.area_vector(t).length()).sum();
        assert!((area - 24.0).abs() < 1e-3, "{area}");
    }
}
