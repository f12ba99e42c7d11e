//! Surface points of different reach by place: which of them stands for a place.

use super::{Surfel, grid::SurfelGrid};
use crate::meshless::distance::distance;
use glam::Vec3;
use std::collections::BTreeMap;

/// Octaves of reach that share a grid: fewer are more grids to look in, more are larger cells.
const OCTAVES: f32 = 2.0;

/// Points that each stand for the places within a reach of their own, in a grid for every few octaves of reach.
#[derive(Default)]
pub struct GradedGrid {
    layers: BTreeMap<i32, Layer>,
    points: Vec<(Surfel, f32)>,
}

/// The points whose reach is of the same few octaves.
struct Layer {
    grid: SurfelGrid,
    /// Which of all points they are.
    members: Vec<u32>,
}

impl GradedGrid {
    /// Of points and their reach in metres.
    pub fn of(points: impl IntoIterator<Item = (Surfel, f32)>) -> Self {
        let mut grid = Self::default();
        points.into_iter().for_each(|(point, reach)| grid.push(point, reach));
        grid
    }

    /// Adds a point that reaches so many metres.
    pub fn push(&mut self, point: Surfel, reach: f32) {
        let reach = reach.max(f32::MIN_POSITIVE);
        let key = (reach.log2() / OCTAVES).floor() as i32;
        let layer = self.layers.entry(key).or_insert_with(|| {
            // No point of the layer reaches farther.
            Layer { grid: SurfelGrid::new(((key as f32 + 1.0) * OCTAVES).exp2()), members: Vec::new() }
        });
        layer.grid.push(point);
        layer.members.push(self.points.len() as u32);
        self.points.push((point, reach));
    }

    /// All points and their reach in the order in which they came.
    pub fn points(&self) -> &[(Surfel, f32)] {
        &self.points
    }

    /// The points and their reach alone.
    pub fn into_points(self) -> Vec<(Surfel, f32)> {
        self.points
    }

    /// Whether `test` holds for the index and the distance ([`distance`]) of any point that reaches `place`; some are asked
    /// twice.
    pub fn any_reaching(&self, place: &Surfel, mut test: impl FnMut(usize, f32) -> bool) -> bool {
        self.any_near(place.position, |i, point, reach| {
            let d = distance(point, place);
            d < reach && test(i, d)
        })
    }

    /// The nearest ([`distance`]) of the points that reach a place.
    pub fn nearest(&self, place: &Surfel) -> Option<usize> {
        let mut nearest = (f32::INFINITY, None);
        self.any_reaching(place, |i, d| {
            if d < nearest.0 {
                nearest = (d, Some(i));
            }
            false
        });
        nearest.1
    }

    /// Whether `test` holds for the index, the place and the reach of any point near `position`: all that reach it, some
    /// more, and some of them twice.
    pub fn any_near(&self, position: Vec3, mut test: impl FnMut(usize, &Surfel, f32) -> bool) -> bool {
        self.layers.values().any(|Layer { grid, members }| {
            grid.any_near(position, |i, point| {
                let index = members[i] as usize;
                test(index, point, self.points[index].1)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<(Surfel, f32)> {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut coordinate = || rng.f32() * 2.0 - 1.0;
        let surfel = |position| Surfel { position, normal: Vec3::Y, place: Default::default() };
        let mut point = |i: usize| {
            let reach = 0.005 * (1.0 + (i % 37) as f32);
            (surfel(Vec3::new(coordinate(), 0.0, coordinate())), reach)
        };
        (0..300).map(&mut point).collect()
    }

    #[test]
    fn the_nearest_of_those_that_reach_is_found_as_by_asking_all() {
        let points = points();
        let grid = GradedGrid::of(points.clone());
        let mut farther = 0;
        for (place, _) in points.iter() {
            let place = Surfel { position: place.position + Vec3::new(0.013, 0.002, -0.007), ..*place };
            let all = points.iter().enumerate().map(|(i, (p, reach))| (distance(p, &place), i, *reach));
            let nearest = all.clone().filter(|(d, _, reach)| d < reach).min_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(grid.nearest(&place), nearest.map(|n| n.1));
            let any = all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|n| n.1);
            farther += usize::from(any != nearest.map(|n| n.1));
        }
        assert!(farther > 10, "negative control: often the nearest of all does not reach, {farther}");
    }

    #[test]
    fn points_without_reach_are_kept_and_found_nowhere_else() {
        let at = Surfel { position: Vec3::ONE, normal: Vec3::Y, place: Default::default() };
        let grid = GradedGrid::of([(at, 0.0)]);
        assert_eq!((grid.points().len(), grid.nearest(&at)), (1, Some(0)));
        assert_eq!(grid.nearest(&Surfel { position: Vec3::X, ..at }), None);
    }
}
