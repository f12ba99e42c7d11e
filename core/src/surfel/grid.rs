//! Surface points by place, for range queries.

use super::Surfel;
use glam::Vec3;

/// Buckets; cells that share one cost a few tests more.
const BUCKETS: usize = 1 << 18;
const NONE: u32 = u32::MAX;

/// A uniform hash grid of surface points.
pub struct SurfelGrid {
    inverse_cell: f32,
    /// Last point of each bucket.
    heads: Vec<u32>,
    /// The point before, in the same bucket.
    before: Vec<u32>,
    points: Vec<Surfel>,
}

impl SurfelGrid {
    /// For queries of points no farther than `reach` metres.
    pub fn new(reach: f32) -> Self {
        Self { inverse_cell: 1.0 / reach, heads: vec![NONE; BUCKETS], before: Vec::new(), points: Vec::new() }
    }

    /// Adds a point.
    pub fn push(&mut self, point: Surfel) {
        let bucket = bucket(self.cell(point.position));
        self.before.push(std::mem::replace(&mut self.heads[bucket], self.points.len() as u32));
        self.points.push(point);
    }

    /// Whether `test` holds for any point near `position`: all within reach, some more, and some of them twice.
    pub fn any_near(&self, position: Vec3, mut test: impl FnMut(usize, &Surfel) -> bool) -> bool {
        let center = self.cell(position);
        for i in 0..27 {
            let steps = [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
            let neighbour = std::array::from_fn(|axis| center[axis].saturating_add(steps[axis]));
            let mut at = self.heads[bucket(neighbour)];
            while at != NONE {
                if test(at as usize, &self.points[at as usize]) {
                    return true;
                }
                at = self.before[at as usize];
            }
        }
        false
    }

    fn cell(&self, position: Vec3) -> [i64; 3] {
        (position * self.inverse_cell).floor().to_array().map(|x| x as i64)
    }
}

/// The hash of Teschner et al. 2003.
fn bucket(cell: [i64; 3]) -> usize {
    let [x, y, z] = cell.map(|c| c as u32);
    let hash = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    (hash ^ hash >> 15) as usize % BUCKETS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_finds_neighbours_however_small_its_cells() {
        let at = |x: f32| Surfel { position: Vec3::splat(x), normal: Vec3::Y, place: Default::default() };
        for (reach, x) in [(1e-30, 3e8), (1e-12, -1e12), (1e-6, 4e3)] {
            let mut grid = SurfelGrid::new(reach);
            grid.push(at(x));
            assert!(grid.any_near(Vec3::splat(x), |i, _| i == 0), "{reach} at {x}");
        }
    }
}
