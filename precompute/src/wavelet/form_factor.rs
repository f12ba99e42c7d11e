//! Form factor of a polygon from a point, without what stands between (Lambert's formula).

use glam::Vec3;
use std::f32::consts::TAU;

/// Share of the cosine-weighted hemisphere around the unit `normal` at `point` that a convex polygon covers, seen from its front:
/// its corners go counter-clockwise.
pub fn from_point(point: Vec3, normal: Vec3, corners: &[Vec3; 4]) -> f32 {
    let above = above_horizon(corners.map(|corner| corner - point), normal);
    let edges = above.as_slice().iter().zip(above.as_slice().iter().cycle().skip(1));
    let of_edge = |(&from, &to): (&Vec3, &Vec3)| {
        let across = from.cross(to);
        // Parallel ends span no angle. An arccosine would lose small angles.
        across.try_normalize().map_or(0.0, |axis| across.length().atan2(from.dot(to)) * axis.dot(normal))
    };
    // Seen from the front, the edges turn clockwise.
    -edges.map(of_edge).sum::<f32>() / TAU
}

/// A polygon of at most five corners.
struct Clipped {
    corners: [Vec3; 5],
    len: usize,
}

impl Clipped {
    fn as_slice(&self) -> &[Vec3] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: Vec3) {
        self.corners[self.len] = corner;
        self.len += 1;
    }
}

/// The part of a convex quad above a plane through the origin.
fn above_horizon(corners: [Vec3; 4], normal: Vec3) -> Clipped {
    let mut clipped = Clipped { corners: [Vec3::ZERO; 5], len: 0 };
    for i in 0..4 {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        let (height, next) = (from.dot(normal), to.dot(normal));
        if height >= 0.0 {
            clipped.push(from);
        }
        if (height >= 0.0) != (next >= 0.0) && clipped.len < 5 {
            clipped.push(from.lerp(to, height / (height - next)));
        }
    }
    clipped
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of half-width 0.5 at a height, facing down.
    fn ceiling(height: f32) -> [Vec3; 4] {
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, z]| Vec3::new(x, height, z))
    }

    #[test]
    fn a_square_above_a_point_covers_what_the_integral_says() {
        // Four times that of a rectangle over its corner, Howell's C-4, a = b = 0.5.
        let (a, c) = (0.5_f32, (1.25_f32).sqrt());
        let expected = 4.0 * (a / c * (a / c).atan() * 2.0) / TAU;
        let found = from_point(Vec3::ZERO, Vec3::Y, &ceiling(1.0));
        assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
        assert!((from_point(Vec3::ZERO, Vec3::Y, &ceiling(1.1)) - expected).abs() > 0.01, "negative control: farther");
        let mut turned = ceiling(1.0);
        turned.reverse();
        assert!(from_point(Vec3::ZERO, Vec3::Y, &turned) < 0.0, "from behind");
    }

    #[test]
    fn a_small_square_covers_its_area() {
        let small = ceiling(1.0).map(|corner| Vec3::new(1e-2 * corner.x, corner.y, 1e-2 * corner.z));
        let found = from_point(Vec3::ZERO, Vec3::Y, &small);
        let expected = 1e-4 / std::f32::consts::PI;
        assert!((found / expected - 1.0).abs() < 0.02, "{found} for {expected}");
        let farther = small.map(|corner| corner + 0.05 * Vec3::Y);
        assert!((from_point(Vec3::ZERO, Vec3::Y, &farther) / expected - 1.0).abs() > 0.05, "negative control: farther");
    }

    #[test]
    fn what_lies_below_the_horizon_is_not_seen() {
        // A wall through the point's plane, half of it above.
        let wall = [[0.5, 1.0], [-0.5, 1.0], [-0.5, -1.0], [0.5, -1.0]].map(|[x, y]| Vec3::new(x, y, -0.3));
        let upper = [[0.5, 1.0], [-0.5, 1.0], [-0.5, 0.0], [0.5, 0.0]].map(|[x, y]| Vec3::new(x, y, -0.3));
        let [whole, upper] = [wall, upper].map(|corners| from_point(Vec3::ZERO, Vec3::Y, &corners).abs());
        assert!((whole - upper).abs() < 1e-5 && upper > 0.1, "{whole} {upper}");
        let below = wall.map(|corner| corner - Vec3::Y * 1.5);
        assert_eq!(from_point(Vec3::ZERO, Vec3::Y, &below), 0.0);
    }
}
