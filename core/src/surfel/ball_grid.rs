//! Balls in space: lookup of those that contain a point.

use glam::Vec3;
use rustc_hash::FxHashMap;

/// A uniform grid. Every cell lists the overlapping balls consecutively, so a point needs one lookup and reads memory in order.
pub struct BallGrid {
    inverse_cell: f32,
    cells: FxHashMap<[i64; 3], Vec<Ball>>,
}

/// A ball in a cell.
struct Ball {
    center: Vec3,
    radius_squared: f32,
    /// The caller's index.
    number: u32,
}

impl BallGrid {
    /// A grid for balls of at most this radius, and not much less.
    pub fn new(largest: f32) -> Self {
        Self { inverse_cell: 1.0 / largest, cells: FxHashMap::default() }
    }

    /// Adds a ball with the caller's index.
    pub fn push(&mut self, number: u32, center: Vec3, radius: f32) {
        let [low, high] = [-radius, radius].map(|side| self.cell(center + side));
        let [xs, ys, zs]: [_; 3] = std::array::from_fn(|axis| low[axis]..=high[axis]);
        for x in xs {
            for y in ys.clone() {
                for z in zs.clone() {
                    let ball = Ball { center, radius_squared: radius * radius, number };
                    self.cells.entry([x, y, z]).or_default().push(ball);
                }
            }
        }
    }

    /// Whether `test` holds for the index of any ball that contains a position, and the squared distance of its center.
    pub fn any_around(&self, position: Vec3, mut test: impl FnMut(u32, f32) -> bool) -> bool {
        // A radius whose square underflows contains its center.
        let holds = |ball: &Ball| {
            let distance_squared = ball.center.distance_squared(position);
            distance_squared <= ball.radius_squared && test(ball.number, distance_squared)
        };
        self.cells.get(&self.cell(position)).is_some_and(|balls| balls.iter().any(holds))
    }

    fn cell(&self, position: Vec3) -> [i64; 3] {
        (position * self.inverse_cell).floor().to_array().map(|x| x as i64)
    }
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
            grid.any_around(position, |ball, distance_squared| {
                assert_eq!(distance_squared, balls[ball as usize].0.distance_squared(position));
                found.push(ball as usize);
                false
            });
            found.sort_unstable();
            let holds = |i: &usize| balls[*i].0.distance(position) < balls[*i].1;
            assert_eq!(found, (0..balls.len()).filter(holds).collect::<Vec<_>>());
            held += found.len();
        }
        // Without the parts of balls outside the cube of 64 m³.
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
            assert!(grid.any_around(Vec3::splat(x), |ball, _| ball == 7), "{radius} at {x}");
        }
    }
}
