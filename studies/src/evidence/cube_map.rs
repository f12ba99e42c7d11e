//! Directions of the texels of a cube map.

use glam::Vec3;

/// Faces of a cube.
pub const FACES: usize = 6;

/// Unit directions through the centers of the `side * side` texels of each of six faces: +X, -X, +Y, -Y, +Z, -Z, row by row.
pub fn directions(side: usize) -> Vec<Vec3> {
    let at = |i: usize| (2 * i + 1) as f32 / side as f32 - 1.0;
    let texels = |face: usize| (0..side * side).map(move |i| direction(face, at(i % side), at(i / side)));
    (0..FACES).flat_map(texels).collect()
}

/// Direction through a point of a face, each coordinate from -1 to 1.
fn direction(face: usize, u: f32, v: f32) -> Vec3 {
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let place = match face / 2 {
        0 => Vec3::new(sign, v, u),
        1 => Vec3::new(u, sign, v),
        _ => Vec3::new(u, v, sign),
    };
    place.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_cover_the_sphere_evenly_and_once() {
        let side = 8;
        let all = directions(side);
        assert_eq!(all.len(), FACES * side * side);
        let mean: Vec3 = all.iter().sum::<Vec3>() / all.len() as f32;
        assert!(mean.length() < 1e-5 && all.iter().all(|d| (d.length() - 1.0).abs() < 1e-5));
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a.dot(*b) < 1.0 - 1e-4), "texel {i} stands twice");
            let face = i / (side * side);
            assert_eq!(a.abs().max_position(), face / 2, "the axis of its face is its largest part");
            assert_eq!(a[face / 2] > 0.0, face.is_multiple_of(2));
        }
    }
}
