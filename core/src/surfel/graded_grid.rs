//! Lookup of the owner of a position among surface points with individual reach.

use super::{Surfel, ball_grid::BallGrid};
use crate::surfel::distance::distance;
use std::collections::BTreeMap;

/// Points that own positions within their own reach, in a grid per octave of reach.
#[derive(Default)]
pub struct GradedGrid {
    layers: BTreeMap<i32, BallGrid>,
    points: Vec<(Surfel, f32)>,
}

impl GradedGrid {
    /// A grid of points with their reach in meters.
    pub fn of(points: impl IntoIterator<Item = (Surfel, f32)>) -> Self {
        let mut grid = Self::default();
        points.into_iter().for_each(|(point, reach)| grid.push(point, reach));
        grid
    }

    /// Adds a point with a reach in meters.
    pub fn push(&mut self, point: Surfel, reach: f32) {
        let reach = reach.max(f32::MIN_POSITIVE);
        let key = reach.log2().floor() as i32;
        // Upper bound of the reach in the layer.
        let layer = self.layers.entry(key).or_insert_with(|| BallGrid::new((key as f32 + 1.0).exp2()));
        layer.push(self.points.len() as u32, point.position, reach);
        self.points.push((point, reach));
    }

    /// All points and their reach, in order of insertion.
    pub fn points(&self) -> &[(Surfel, f32)] {
        &self.points
    }

    /// Returns the points and their reach.
    pub fn into_points(self) -> Vec<(Surfel, f32)> {
        self.points
    }

    /// Whether `test` holds for the index and the distance ([`distance`]) of any point that reaches `place`.
    pub fn any_reaching(&self, place: &Surfel, mut test: impl FnMut(usize, f32) -> bool) -> bool {
        self.layers.values().any(|layer| {
            layer.any_around(place.position, |i, _| {
                let (point, reach) = &self.points[i as usize];
                let d = distance(point, place);
                d < *reach && test(i as usize, d)
            })
        })
    }

    /// The nearest ([`distance`]) of the points that reach a position.
    pub fn nearest(&self, place: &Surfel) -> Option<usize> {
        self.nearest_that(place, |_| true)
    }

    /// The nearest of the points that reach a position and whose index passes `may`.
    pub fn nearest_that(&self, place: &Surfel, may: impl Fn(usize) -> bool) -> Option<usize> {
        let mut nearest = (f32::INFINITY, None);
        for layer in self.layers.values() {
            layer.any_around(place.position, |i, distance_squared| {
                // The distance is never less than the positions' distance.
                if distance_squared <= nearest.0 * nearest.0 {
                    let (point, reach) = &self.points[i as usize];
                    let d = distance(point, place);
                    if d < *reach && d < nearest.0 && may(i as usize) {
                        nearest = (d, Some(i as usize));
                    }
                }
                false
            });
        }
        nearest.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn points() -> Vec<(Surfel, f32)> {
        let mut rng = fastrand::Rng::with_seed(3);
        let mut coordinate = || rng.f32() * 2.0 - 1.0;
        let surfel = |position| Surfel { position, ..Default::default() };
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
            let of_odd = all.clone().filter(|(d, i, reach)| d < reach && i % 2 == 1).min_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(grid.nearest_that(&place, |i| i % 2 == 1), of_odd.map(|n| n.1));
            let any = all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|n| n.1);
            farther += usize::from(any != nearest.map(|n| n.1));
        }
        assert!(farther > 10, "negative control: often the nearest of all does not reach, {farther}");
    }

    #[test]
    fn points_without_reach_are_kept_and_found_nowhere_else() {
        let at = Surfel { position: Vec3::ONE, ..Default::default() };
        let grid = GradedGrid::of([(at, 0.0)]);
        assert_eq!((grid.points().len(), grid.nearest(&at)), (1, Some(0)));
        assert_eq!(grid.nearest(&Surfel { position: Vec3::X, ..at }), None);
    }
}
