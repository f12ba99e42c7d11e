//! The radiance of an environment in cells of directions, for bins that are far coarser than its light samples.

use crate::light::environment::SceneLighting;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Cells around the horizon, and between the poles.
const COLUMNS: usize = 64;
const ROWS: usize = 32;

/// Mean radiance by latitude and longitude; black without an environment.
pub struct SkyGrid {
    cells: Vec<Vec3>,
}

impl SkyGrid {
    pub fn new(environment: Option<&SceneLighting>) -> Self {
        let Some(lighting) = environment else { return Self { cells: Vec::new() } };
        let leaves = lighting.nodes.radiance.len() / 2;
        let leaf = |leaf: usize| (lighting.nodes.direction[leaves + leaf], lighting.nodes.radiance[leaves + leaf]);
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); COLUMNS * ROWS];
        for (direction, radiance) in (0..leaves).map(leaf) {
            let (sum, count) = &mut sums[cell_of(direction)];
            (*sum, *count) = (*sum + radiance, *count + 1.0);
        }
        // Cells near the poles are smaller than light samples.
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
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.cells.get(cell_of(direction)).copied().unwrap_or_default()
    }
}

fn cell_of(direction: Vec3) -> usize {
    let (longitude, latitude) =
        (direction.z.atan2(direction.x) / TAU + 0.5, direction.y.clamp(-1.0, 1.0).acos() * FRAC_1_PI);
    let along = |part: f32, cells: usize| ((part * cells as f32) as usize).min(cells - 1);
    along(latitude, ROWS) * COLUMNS + along(longitude, COLUMNS)
}

fn direction_of(cell: usize) -> Vec3 {
    let (row, column) = (cell / COLUMNS, cell % COLUMNS);
    let (sin, y) = ((row as f32 + 0.5) / ROWS as f32 * PI).sin_cos();
    let (z, x) = (((column as f32 + 0.5) / COLUMNS as f32 - 0.5) * TAU).sin_cos();
    Vec3::new(sin * x, y, sin * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_found_by_their_directions() {
        for cell in 0..COLUMNS * ROWS {
            assert_eq!(cell_of(direction_of(cell)), cell);
        }
    }
}
