//! The radiance of an environment in cells of directions, for bins that are far coarser than its light samples.

use crate::light::environment::SceneLighting;
use glam::{Vec2, Vec3};
use lapidary_core::sphere::octahedral::{direction_from_square, square_from_direction};

/// Cells along each side of the unfolded octahedron.
const SIDE: usize = 48;

/// Mean radiance in the cells of an unfolded octahedron; black without an environment.
pub struct SkyGrid {
    cells: Vec<Vec3>,
}

impl SkyGrid {
    pub fn new(environment: Option<&SceneLighting>) -> Self {
        let Some(lighting) = environment else { return Self { cells: Vec::new() } };
        let leaves = lighting.nodes.radiance.len() / 2;
        let leaf = |leaf: usize| (lighting.nodes.direction[leaves + leaf], lighting.nodes.radiance[leaves + leaf]);
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); SIDE * SIDE];
        for (direction, radiance) in (0..leaves).map(leaf) {
            let (sum, count) = &mut sums[cell_of(direction)];
            (*sum, *count) = (*sum + radiance, *count + 1.0);
        }
        // Some cells are smaller than light samples.
        let nearest = |cell: usize| {
            let direction = direction_of(cell);
            let closeness = |leaf: &(Vec3, Vec3)| leaf.0.dot(direction);
            let nearest = (0..leaves).map(leaf).max_by(|a, b| closeness(a).total_cmp(&closeness(b)));
            nearest.map_or(Vec3::ZERO, |(_, radiance)| radiance)
        };
        let mean = |(cell, &(sum, count)): (usize, &(Vec3, f32))| if count > 0.0 { sum / count } else { nearest(cell) };
        Self { cells: sums.iter().enumerate().map(mean).collect() }
    }

    /// In W/(m² sr), by unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.cells.get(cell_of(direction)).copied().unwrap_or_default()
    }
}

fn cell_of(direction: Vec3) -> usize {
    let place = (SIDE as f32 * square_from_direction(direction)).min(Vec2::splat(SIDE as f32 - 1.0));
    place.y as usize * SIDE + place.x as usize
}

fn direction_of(cell: usize) -> Vec3 {
    let place = Vec2::new((cell % SIDE) as f32 + 0.5, (cell / SIDE) as f32 + 0.5);
    direction_from_square(place / SIDE as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_by_their_directions() {
        for cell in 0..SIDE * SIDE {
            assert_eq!(cell_of(direction_of(cell)), cell);
        }
    }
}
