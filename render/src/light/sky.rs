//! Radiance of an environment in cells of directions, for bins far coarser than its light samples.

use crate::light::{environment::SceneLighting, situation::Situation};
use glam::Vec3;
use lapidary_core::sphere::octahedron::{CELLS, cell_of, direction_of};

/// Mean radiance by cell of an octahedron, with the same cells in the kernels; black without an environment.
pub struct SkyGrid {
    cells: Vec<Vec3>,
}

impl SkyGrid {
    /// The environment of a situation, if its visibility is baked.
    pub fn of(situation: &Situation) -> Self {
        let is_baked = situation.scene.dataset.settings.mode.environment();
        Self::new(situation.environment.as_ref().filter(|_| is_baked).map(|light| &***light))
    }

    pub fn new(environment: Option<&SceneLighting>) -> Self {
        let Some(lighting) = environment else { return Self { cells: Vec::new() } };
        let leaves = lighting.leaves();
        let leaf = |leaf: usize| (lighting.nodes.place[leaves + leaf], lighting.nodes.radiance[leaves + leaf]);
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); CELLS];
        for (direction, radiance) in (0..leaves).map(leaf) {
            let (sum, count) = &mut sums[cell_of(direction)];
            (*sum, *count) = (*sum + radiance, *count + 1.0);
        }
        // A sparse set of light samples leaves cells empty.
        let nearest = |cell: usize| {
            let direction = direction_of(cell);
            let closeness = |leaf: &(Vec3, Vec3)| leaf.0.dot(direction);
            let nearest = (0..leaves).map(leaf).max_by(|a, b| closeness(a).total_cmp(&closeness(b)));
            nearest.map_or(Vec3::ZERO, |(_, radiance)| radiance)
        };
        let mean = |(cell, &(sum, count)): (usize, &(Vec3, f32))| if count > 0.0 { sum / count } else { nearest(cell) };
        Self { cells: sums.iter().enumerate().map(mean).collect() }
    }

    /// Whether there is an environment.
    pub fn shines(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Radiance in W/(m² sr) by unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.cells.get(cell_of(direction)).copied().unwrap_or_default()
    }
}
