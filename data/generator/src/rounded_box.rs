//! Boxes with rounded edges: nothing an artist lights has an edge of zero width.

use glam::{Vec2, Vec3};

use crate::mesh::Mesh;

/// Steps across half of a rounded edge: a bevel for the smallest radius, a smooth curve for upholstery.
fn round_steps(radius: f32) -> usize {
    if radius < 0.01 {
        1
    } else if radius < 0.05 {
        2
    } else {
        3
    }
}

/// A box of `size` meters around the origin with edges rounded to `radius`, its flats cut into cells of at
/// most `cell` meters. Texture coordinates are meters on each face, so one image keeps its scale on all.
pub fn rounded_box(size: Vec3, radius: f32, cell: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            push_face(&mut mesh, size, radius, cell, axis, sign);
        }
    }
    mesh
}

/// A box with sharp edges and flat faces, for walls that abut.
pub fn plain_box(size: Vec3, cell: f32) -> Mesh {
    rounded_box(size, 0.0, cell)
}

fn push_face(mesh: &mut Mesh, size: Vec3, radius: f32, cell: f32, axis: usize, sign: f32) {
    let half = size * 0.5;
    let normal = sign * Vec3::AXES[axis];
    let (right, up) = face_axes(axis, sign);
    let columns = grid_lines(half.dot(right.abs()), radius, cell);
    let rows = grid_lines(half.dot(up.abs()), radius, cell);
    let depth = half.dot(normal.abs());
    let grid: Vec<Vec<u32>> = rows
        .iter()
        .map(|y| {
            let push =
                |x: &f32| push_point(mesh, half, radius, right * *x + up * *y + normal * depth, normal, (right, up));
            columns.iter().map(push).collect()
        })
        .collect();
    for pair in grid.windows(2) {
        for k in 0..columns.len() - 1 {
            mesh.quad(pair[0][k], pair[0][k + 1], pair[1][k + 1], pair[1][k]);
        }
    }
}

/// Axes of a face with `right x up = normal`; `up` is Y on the four sides.
fn face_axes(axis: usize, sign: f32) -> (Vec3, Vec3) {
    match axis {
        0 => (-sign * Vec3::Z, Vec3::Y),
        1 => (sign * Vec3::X, -Vec3::Z),
        _ => (sign * Vec3::X, Vec3::Y),
    }
}

/// Grid lines across a face of half width `half`: dense in the rounded margins, even between them.
fn grid_lines(half: f32, radius: f32, cell: f32) -> Vec<f32> {
    let flat = half - radius;
    let mut lines = even_lines(flat, steps_across(flat, cell));
    if radius > 0.0 {
        // tan of equal angles up to 45 degrees, where the next face takes over.
        let last = round_steps(radius);
        let margin = |k: usize| radius * (std::f32::consts::FRAC_PI_4 * k as f32 / last as f32).tan();
        let outer: Vec<f32> = (1..=last).map(|k| if k == last { half } else { flat + margin(k) }).collect();
        let mirrored = outer.iter().rev().map(|x| -x);
        lines = mirrored.chain(lines).chain(outer.iter().copied()).collect();
    }
    lines
}

/// Steps of at most `cell` meters from `-half` to `half`.
pub fn steps_across(half: f32, cell: f32) -> usize {
    (2.0 * half / cell).ceil().max(1.0) as usize
}

/// Lines from `-half` to `half` in even steps, mirrored to the bit and ending on `half`, so that adjacent surfaces meet exactly.
pub fn even_lines(half: f32, steps: usize) -> Vec<f32> {
    (0..=steps).map(|k| half * (((2 * k) as f32 - steps as f32) / steps as f32)).collect()
}

/// Pulls a point of the sharp box onto the rounded one.
fn push_point(mesh: &mut Mesh, half: Vec3, radius: f32, at: Vec3, face_normal: Vec3, axes: (Vec3, Vec3)) -> u32 {
    let uv = Vec2::new(at.dot(axes.0) + half.dot(axes.0.abs()), half.dot(axes.1.abs()) - at.dot(axes.1));
    if radius == 0.0 {
        return mesh.push(at, face_normal, uv);
    }
    let core = at.clamp(radius - half, half - radius);
    let normal = (at - core).normalize();
    mesh.push(core + normal * radius, normal, uv)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::checks::{assert_closed, assert_sound, volume};

    #[test]
    fn boxes_are_closed() {
        for radius in [0.0, 0.02] {
            let mesh = rounded_box(Vec3::new(0.3, 0.2, 0.41), radius, 0.06);
            assert_sound(&mesh);
            assert_closed(&mesh);
            assert!((volume(&mesh) / (0.3 * 0.2 * 0.41) - 1.0).abs() < 0.03);
        }
    }
}
