//! The sphere as a square: an octahedron unfolded (Engelhardt and Dachsbacher, *Octahedron Environment Maps*, 2008).
//!
//! No arctangent is needed. The upper half around +Z is the diamond in the middle, the lower one its corners turned out.

use glam::{Vec2, Vec3};

/// A point of the square from (0, 0) to (1, 1) from a direction, which needs no unit length.
#[inline(always)]
pub fn square_from_direction(d: Vec3) -> Vec2 {
    let sum = d.abs().element_sum();
    let (x, y) = (d.x / sum, d.y / sum);
    let (x, y) = if d.z < 0.0 { ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)) } else { (x, y) };
    0.5 + 0.5 * Vec2::new(x, y)
}

/// A unit direction from a point of the square from (0, 0) to (1, 1).
pub fn direction_from_square(square: Vec2) -> Vec3 {
    let Vec2 { x, y } = 2.0 * square - 1.0;
    let z = 1.0 - x.abs() - y.abs();
    let below = (-z).max(0.0);
    Vec3::new(x - below.copysign(x), y - below.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    #[test]
    fn directions_come_back_from_their_points() {
        let directions = fibonacci_directions(10_000);
        for &direction in &directions {
            let back = direction_from_square(square_from_direction(3.0 * direction));
            assert!(back.distance(direction) < 1e-5, "{direction} {back}");
        }
        let below = directions.iter().filter(|direction| direction.z < 0.0);
        let outside = |d: &&Vec3| (2.0 * square_from_direction(**d) - 1.0).abs().element_sum() > 1.0;
        assert_eq!(below.clone().filter(outside).count(), below.count(), "the lower half is in the corners");
    }

    #[test]
    fn cells_are_of_about_one_size() {
        let mut counts = [0_u32; 64];
        for direction in fibonacci_directions(64_000) {
            let cell = (8.0 * square_from_direction(direction)).min(Vec2::splat(7.0)).as_uvec2();
            counts[(cell.y * 8 + cell.x) as usize] += 1;
        }
        assert!(counts.iter().all(|&count| (500..2200).contains(&count)), "{counts:?}");
    }
}
