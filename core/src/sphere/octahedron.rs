//! All directions as a square: an octahedron unfolded around its +Z corner.
//!
//! Finding the cell of a direction takes one division and no functions, so all machines agree. Edges of the middle row
//! of cells lie on the horizon, in front and behind.

use glam::{Vec2, Vec3};

/// Cells along an edge of the square; even, for the horizon.
pub const SIDE: usize = 48;
/// Number of cells.
pub const CELLS: usize = SIDE * SIDE;

/// The cell of a nonzero direction, row by row.
pub fn cell_of(direction: Vec3) -> usize {
    let p = direction.truncate() / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    let place = if direction.z >= 0.0 { p } else { folded(p) };
    let cell = |at: f32| (((0.5 + 0.5 * at) * SIDE as f32) as usize).min(SIDE - 1);
    cell(place.y) * SIDE + cell(place.x)
}

/// The unit direction at the center of a cell.
pub fn direction_of(cell: usize) -> Vec3 {
    let middle = Vec2::new((cell % SIDE) as f32, (cell / SIDE) as f32) + 0.5;
    let place = middle / SIDE as f32 * 2.0 - 1.0;
    let z = 1.0 - place.x.abs() - place.y.abs();
    let p = if z >= 0.0 { place } else { folded(place) };
    p.extend(z).normalize()
}

/// Maps a place of the square to its point in the lower half, and back.
fn folded(p: Vec2) -> Vec2 {
    let sign = |of: f32| if of >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::fibonacci_directions;

    #[test]
    fn cells_are_found_by_their_directions() {
        for cell in 0..CELLS {
            assert_eq!(cell_of(direction_of(cell)), cell);
            assert!(direction_of(cell).is_normalized());
        }
    }

    #[test]
    fn directions_lie_near_the_middle_of_their_cell_and_on_its_side_of_the_horizon() {
        for direction in fibonacci_directions(20_000) {
            let middle = direction_of(cell_of(direction));
            assert!(middle.dot(direction) > 0.995, "{direction}");
            assert_eq!(middle.y > 0.0, direction.y > 0.0, "{direction}");
        }
    }

    #[test]
    fn cells_are_of_similar_size() {
        let mut counts = [0_u32; CELLS];
        fibonacci_directions(CELLS * 100).into_iter().for_each(|direction| counts[cell_of(direction)] += 1);
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*least > 30 && *most < 250, "{least} to {most} in place of 100");
    }
}
