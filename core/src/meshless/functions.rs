//! Functions around scattered surface points, in levels that each sum to one, and the grid that finds them.

use super::{BasisError, FunctionGrid, MOST_LEVELS};
use crate::{bounds::is_within_reach, mesh::is_unit, surfel::Surfel, transport::Coefficient};
use glam::Vec3;
use std::ops::{Range, RangeInclusive};

/// Smallest and largest radius of support in meters: their squares, and squared distances, fit 32-bit floats.
const RADII: RangeInclusive<f32> = 1e-15..=4e9;

/// The functions of all levels, coarsest first. A function is centered at a point and has support within a radius around it.
#[derive(Clone, Default)]
pub struct Functions {
    points: Vec<Surfel>,
    /// First function of each level, and the end of the last level.
    offsets: Vec<u32>,
    /// Radius of support in meters, one per level.
    radii: Vec<f32>,
    grid: FunctionGrid,
}

/// A surface point among functions.
#[derive(Clone, Copy, Debug)]
pub struct FunctionPlace {
    /// First key of the grid: its levels are those of the functions that may reach the point.
    pub first_key: usize,
    /// Position in meters.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

impl FunctionPlace {
    /// A point that all functions may reach.
    pub fn new(position: Vec3, normal: Vec3) -> Self {
        Self { first_key: 0, position, normal }
    }
}

impl Functions {
    /// Functions at points, with offsets of the levels (with the end of the last) and radii. `keys` has the functions of each key of
    /// the grid, and its level; a key finds its own functions alone.
    ///
    /// # Errors
    /// [`BasisError`] if they contradict each other.
    pub(super) fn new(
        points: Vec<Surfel>,
        offsets: Vec<u32>,
        radii: Vec<f32>,
        keys: impl FnOnce(&[u32]) -> Vec<(usize, Range<usize>)>,
    ) -> Result<Self, BasisError> {
        let is_whole = offsets.first() == Some(&0)
            && offsets.last().is_some_and(|&end| end as usize == points.len())
            && offsets.is_sorted()
            && offsets.len() == radii.len() + 1
            && radii.len() <= MOST_LEVELS;
        if !is_whole {
            return Err(BasisError::Levels { points: points.len() });
        }
        let usable = |p: &Surfel| is_within_reach(p.position) && is_unit(p.normal);
        if let Some(point) = points.iter().position(|p| !usable(p)) {
            return Err(BasisError::Point { point });
        }
        if let Some(level) = radii.iter().position(|r| !RADII.contains(r)) {
            return Err(BasisError::Radius { level, radius: radii[level] });
        }
        let (of_key, ranges): (Vec<f32>, Vec<Range<usize>>) =
            keys(&offsets).into_iter().map(|(level, functions)| (radii[level], functions)).unzip();
        let grid = FunctionGrid::new(&points, &ranges, &of_key);
        Ok(Self { points, offsets, radii, grid })
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.radii.len()
    }

    /// The functions of a level.
    pub fn level(&self, level: usize) -> Range<usize> {
        self.offsets[level] as usize..self.offsets[level + 1] as usize
    }

    /// First function of each level, and the end of the last.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The points of all functions.
    pub fn points(&self) -> &[Surfel] {
        &self.points
    }

    /// Radius of support of each level in meters.
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// The grid for range queries.
    pub fn grid(&self) -> &FunctionGrid {
        &self.grid
    }

    /// The slot of the grid at a point.
    #[inline]
    pub fn slot_at(&self, level: usize, at: &FunctionPlace) -> usize {
        self.grid.slot_at(at.first_key + level, at.position)
    }

    /// Calls `visit` for all functions of a level with nonzero weight at a point, with that weight before normalization.
    #[inline]
    pub fn for_each_weight(&self, level: usize, at: &FunctionPlace, visit: impl FnMut(u32, f32)) {
        self.grid.for_each_weight(self.slot_at(level, at), self.radii[level], (at.position, at.normal), visit);
    }

    /// Whether any function of a level reaches a point.
    pub fn reaches(&self, level: usize, at: &FunctionPlace) -> bool {
        let mut is_reached = false;
        self.for_each_weight(level, at, |_, _| is_reached = true);
        is_reached
    }

    /// Appends all functions of a level that are nonzero at a point, with their values there (meshless paper, Eq. 2). The values sum
    /// to one, unless no function reaches the point.
    #[inline]
    pub fn values(&self, level: usize, at: &FunctionPlace, out: &mut Vec<(u32, f32)>) {
        let first = out.len();
        self.for_each_weight(level, at, |function, weight| out.push((function, weight)));
        let sum: f32 = out[first..].iter().map(|w| w.1).sum();
        let scale = 1.0 / sum.max(f32::MIN_POSITIVE);
        out[first..].iter_mut().for_each(|w| w.1 *= scale);
    }

    /// The function of a level with these coefficients at a point, whose slot of the grid is known; `None` where no function reaches.
    #[inline]
    pub fn evaluate_in<T: Coefficient>(
        &self,
        slot: usize,
        level: usize,
        at: &FunctionPlace,
        coefficients: &[T],
    ) -> Option<T> {
        let (mut sum, mut weights) = (T::ZERO, 0.0);
        self.grid.for_each_weight(slot, self.radii[level], (at.position, at.normal), |function, weight| {
            sum = sum + coefficients[function as usize] * weight;
            weights += weight;
        });
        (weights > 0.0).then(|| sum * (1.0 / weights.max(f32::MIN_POSITIVE)))
    }
}
