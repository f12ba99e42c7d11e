//! Balls by place: which of them hold a point.

use glam::Vec3;

/// Buckets; cells that share one cost a few tests more.
const BUCKETS: usize = 1 << 18;
const NONE: u32 = u32::MAX;

/// A uniform hash grid. Every cell lists the balls that overlap it, so that a point needs a lookup in one cell only.
pub struct BallGrid {
    inverse_cell: f32,
    /// Last entry of each bucket.
    heads: Vec<u32>,
    entries: Vec<Entry>,
}

/// A ball in a cell.
struct Entry {
    center: Vec3,
    radius_sq: f32,
    ball: u32,
    /// The entry before, in the same bucket.
    before: u32,
}

impl BallGrid {
    /// For balls of at most this radius, and not much less.
    pub fn new(largest: f32) -> Self {
        Self { inverse_cell: 1.0 / largest, heads: vec![NONE; BUCKETS], entries: Vec::new() }
    }

    /// Adds a ball with a number of the caller's.
    pub fn push(&mut self, ball: u32, center: Vec3, radius: f32) {
        let [low, high] = [-radius, radius].map(|side| self.cell(center + side));
        let [xs, ys, zs]: [_; 3] = std::array::from_fn(|axis| low[axis]..=high[axis]);
        for x in xs {
            for y in ys.clone() {
                for z in zs.clone() {
                    let head = &mut self.heads[bucket([x, y, z])];
                    let before = std::mem::replace(head, self.entries.len() as u32);
                    self.entries.push(Entry { center, radius_sq: radius * radius, ball, before });
                }
            }
        }
    }

    /// Whether `test` holds for the number of any ball that contains a position; some are tested more than once.
    pub fn any_around(&self, position: Vec3, mut test: impl FnMut(u32) -> bool) -> bool {
        let mut at = self.heads[bucket(self.cell(position))];
        while at != NONE {
            let Entry { center, radius_sq, ball, before } = self.entries[at as usize];
            // A radius whose square is too small for a number holds its center.
            if center.distance_squared(position) <= radius_sq && test(ball) {
                return true;
            }
            at = before;
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
    fn balls_are_found_where_they_reach_and_nowhere_else() {
        let mut rng = fastrand::Rng::with_seed(5);
        let mut coordinate = || 4.0 * rng.f32() - 2.0;
        let mut place = || Vec3::new(coordinate(), coordinate(), coordinate());
        let balls: Vec<(Vec3, f32)> = (0..500).map(|i| (place(), 0.1 + 0.02 * (i % 16) as f32)).collect();
        let mut grid = BallGrid::new(0.4);
        balls.iter().enumerate().for_each(|(i, &(center, radius))| grid.push(i as u32, center, radius));
        let mut held = 0;
        for _ in 0..1000 {
            let position = place();
            let mut found = Vec::new();
            grid.any_around(position, |ball| {
                found.push(ball as usize);
                false
            });
            found.sort_unstable();
            found.dedup();
            let holds = |i: &usize| balls[*i].0.distance(position) < balls[*i].1;
            assert_eq!(found, (0..balls.len()).filter(holds).collect::<Vec<_>>());
            held += found.len();
        }
        // Without what balls lose at the faces of the cube of 64 m³.
        let volume: f32 = balls.iter().map(|ball| 4.0 / 3.0 * std::f32::consts::PI * ball.1.powi(3)).sum();
        let expected = 1000.0 * volume / 64.0;
        let share = held as f32 / expected;
        assert!(share > 0.8 && share < 1.0, "{held} of {expected}");
    }

    #[test]
    fn balls_are_found_however_small_they_are() {
        for (radius, x) in [(1e-30, 3e8), (1e-12, -1e12), (1e-6, 4e3)] {
            let mut grid = BallGrid::new(radius);
            grid.push(7, Vec3::splat(x), radius);
            assert!(grid.any_around(Vec3::splat(x), |ball| ball == 7), "{radius} at {x}");
        }
    }
}
