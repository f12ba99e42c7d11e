//! Hierarchical basis functions around scattered surface points (meshless paper, 2.1 and 2.2).

use super::grid::FunctionGrid;
use crate::{bounds::is_within_reach, mesh::is_unit, sparse::SparseRows, surfel::Surfel, transport::Coefficient};
use glam::Vec3;
use std::{
    fmt,
    ops::{Range, RangeInclusive},
};
use thiserror::Error;

/// Largest number of levels: the finest would have points too close for 32-bit floats.
pub const MOST_LEVELS: usize = 16;
/// Smallest and largest radius of support in meters: their squares, and squared distances, fit 32-bit floats.
const RADII: RangeInclusive<f32> = 1e-15..=4e9;

/// Why points do not form a basis.
#[derive(Debug, Error, PartialEq)]
pub enum BasisError {
    /// Offsets that do not partition the points.
    #[error("the levels of the basis do not match its {points} points; bake it again")]
    Levels {
        /// Number of points.
        points: usize,
    },
    /// Too many or too few sender levels.
    #[error("{sender_levels} of {levels} levels of the basis cannot send; bake it with 1 to {levels} sender levels")]
    SenderLevels {
        /// The requested number of sender levels.
        sender_levels: usize,
        /// Number of levels.
        levels: usize,
    },
    /// A position that is not finite or too far, or a normal that is not of length 1.
    #[error("point {point} of the basis has a position or normal that is not finite or out of range; bake it again")]
    Point {
        /// Index of the point.
        point: usize,
    },
    /// A radius that is not finite, not positive, or whose square is out of range.
    #[error("the radius of level {level} of the basis is {radius}, not a positive number in its range; bake it again")]
    Radius {
        /// The level, from 0.
        level: usize,
        /// Radius of support in meters.
        radius: f32,
    },
}

/// The functions of all levels, coarsest first. A function is centered at a point and has support within a radius around it.
#[derive(Clone)]
pub struct Basis {
    points: Vec<Surfel>,
    /// First function of each level, and the end of the last level.
    offsets: Vec<u32>,
    /// Radius of support in meters, one per level.
    radii: Vec<f32>,
    sender_levels: usize,
    grid: FunctionGrid,
}

impl fmt::Debug for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offsets, radii, sender_levels, .. } = self;
        f.debug_struct("Basis")
            .field("offsets", offsets)
            .field("radii", radii)
            .field("sender_levels", sender_levels)
            .finish_non_exhaustive()
    }
}

impl Basis {
    /// A basis of Poisson-disk sets, coarsest first. `spacing` is the disk radius of the first set in meters; each
    /// further set has half the radius of the one before. The functions of the first `sender_levels` are also senders.
    ///
    /// # Errors
    /// [`BasisError`] if there is no level, if there are fewer levels than `sender_levels`, or if a point is not
    /// finite.
    pub fn new(levels: &[Vec<Surfel>], spacing: f32, sender_levels: usize) -> Result<Self, BasisError> {
        let mut offsets = vec![0];
        levels.iter().for_each(|l| offsets.push(offsets[offsets.len() - 1] + l.len() as u32));
        let radii = (0..levels.len()).map(|level| overlap(level, levels.len()) * spacing * 0.5_f32.powi(level as i32));
        Self::from_parts(levels.concat(), offsets, radii.collect(), sender_levels)
    }

    /// The basis of stored points, offsets of levels (with the end of the last) and radii.
    ///
    /// # Errors
    /// [`BasisError`] if they contradict each other.
    pub fn from_parts(
        points: Vec<Surfel>,
        offsets: Vec<u32>,
        radii: Vec<f32>,
        sender_levels: usize,
    ) -> Result<Self, BasisError> {
        let whole = offsets.first() == Some(&0)
            && offsets.last().is_some_and(|&end| end as usize == points.len())
            && offsets.is_sorted()
            && offsets.len() == radii.len() + 1
            && radii.len() <= MOST_LEVELS;
        if !whole {
            return Err(BasisError::Levels { points: points.len() });
        }
        if !(1..=radii.len()).contains(&sender_levels) {
            return Err(BasisError::SenderLevels { sender_levels, levels: radii.len() });
        }
        check_points(&points)?;
        check_radii(&radii)?;
        let levels: Vec<Range<usize>> = (0..radii.len()).map(|level| range(&offsets, level)).collect();
        let grid = FunctionGrid::new(&points, &levels, &radii);
        Ok(Self { points, offsets, radii, sender_levels, grid })
    }

    /// Number of functions of all levels.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are no functions.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.radii.len()
    }

    /// The functions of a level.
    pub fn level(&self, level: usize) -> Range<usize> {
        range(&self.offsets, level)
    }

    /// First function of each level, and the end of the last.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// The functions of the first `levels` levels.
    pub fn first_levels(&self, levels: usize) -> Range<usize> {
        0..self.offsets[levels] as usize
    }

    /// Number of sender levels, which are the first.
    pub fn sender_levels(&self) -> usize {
        self.sender_levels
    }

    /// The functions that are senders.
    pub fn senders(&self) -> Range<usize> {
        self.first_levels(self.sender_levels)
    }

    /// The points of the senders.
    pub fn sender_points(&self) -> &[Surfel] {
        &self.points[self.senders()]
    }

    /// The points of all functions.
    pub fn points(&self) -> &[Surfel] {
        &self.points
    }

    /// Radius of support of each level in meters.
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// Bytes of the points as stored.
    pub fn bytes(&self) -> u64 {
        (size_of::<Surfel>() * self.points.len()) as u64
    }

    /// The grid for range queries.
    pub fn grid(&self) -> &FunctionGrid {
        &self.grid
    }

    /// Calls `visit` for all functions of a level with nonzero weight at a surface point, with that weight before normalization.
    #[inline]
    pub fn for_each_weight(&self, level: usize, position: Vec3, normal: Vec3, visit: impl FnMut(u32, f32)) {
        let slot = self.grid.slot_at(level, position);
        self.grid.for_each_weight(slot, self.radii[level], (position, normal), visit);
    }

    /// Whether any function of a level reaches a surface point.
    pub fn reaches(&self, level: usize, position: Vec3, normal: Vec3) -> bool {
        let mut is_reached = false;
        self.for_each_weight(level, position, normal, |_, _| is_reached = true);
        is_reached
    }

    /// Appends all functions of a level that are nonzero at a surface point, with their values there (meshless paper,
    /// Eq. 2). The values sum to one, unless no function reaches the point.
    #[inline]
    pub fn values(&self, level: usize, position: Vec3, normal: Vec3, out: &mut Vec<(u32, f32)>) {
        let first = out.len();
        self.for_each_weight(level, position, normal, |function, weight| out.push((function, weight)));
        let sum: f32 = out[first..].iter().map(|w| w.1).sum();
        let scale = 1.0 / sum.max(f32::MIN_POSITIVE);
        out[first..].iter_mut().for_each(|w| w.1 *= scale);
    }

    /// The function with these coefficients at a surface point, summed over the first `levels` levels (meshless paper,
    /// Eq. 6).
    #[inline]
    pub fn evaluate<T: Coefficient>(&self, levels: usize, position: Vec3, normal: Vec3, coefficients: &[T]) -> T {
        (0..levels).fold(T::ZERO, |sum, level| sum + self.evaluate_level(level, position, normal, coefficients))
    }

    /// The part of one level in [`Self::evaluate`].
    #[inline]
    pub fn evaluate_level<T: Coefficient>(&self, level: usize, position: Vec3, normal: Vec3, coefficients: &[T]) -> T {
        self.evaluate_in(self.grid.slot_at(level, position), level, (position, normal), coefficients)
    }

    /// [`Self::evaluate_level`] at a position with a known slot of the grid, and a unit normal.
    #[inline]
    pub fn evaluate_in<T: Coefficient>(&self, slot: usize, level: usize, point: (Vec3, Vec3), coefficients: &[T]) -> T {
        let (mut sum, mut weights) = (T::ZERO, 0.0);
        self.grid.for_each_weight(slot, self.radii[level], point, |function, weight| {
            sum = sum + coefficients[function as usize] * weight;
            weights += weight;
        });
        sum * (1.0 / weights.max(f32::MIN_POSITIVE))
    }

    /// Values of the functions of some levels at the points of `functions`, one row per point. A point's parents are
    /// its row over the level before; its children and neighbors are rows of the transpose.
    pub fn values_at(&self, functions: Range<usize>, levels: Range<usize>) -> SparseRows {
        let first = functions.start;
        SparseRows::build(functions.len(), |row, out| {
            let p = &self.points[first + row];
            levels.clone().for_each(|level| self.values(level, p.position, p.normal, out));
        })
    }

    /// For every function of a level: the other functions of that level whose points it reaches. Rows count from the
    /// level's first function, columns from the basis's first.
    pub fn neighbours(&self, level: usize) -> SparseRows {
        let (range, reached) = (self.level(level), self.reached(level, level));
        SparseRows::build(range.len(), |row, out| {
            let itself = (range.start + row) as u32;
            out.extend(reached.row(row).iter().filter(|c| c.0 != itself));
        })
    }

    /// For every function of a level: the functions of the next level whose points it reaches. Rows count from the
    /// level's first function, columns from the basis's first.
    pub fn children(&self, level: usize) -> SparseRows {
        self.reached(level, level + 1)
    }

    fn reached(&self, level: usize, of: usize) -> SparseRows {
        let (range, others) = (self.level(level), self.level(of));
        let by_point = self.values_at(others.clone(), level..level + 1);
        let by_function = by_point.transposed(range.end);
        SparseRows::build(range.len(), |row, out| {
            let shifted = |&(point, value): &(u32, f32)| (point + others.start as u32, value);
            out.extend(by_function.row(range.start + row).iter().map(shifted));
        })
    }
}

/// Checks that points are on a scene.
pub(super) fn check_points(points: &[Surfel]) -> Result<(), BasisError> {
    let usable = |p: &Surfel| is_within_reach(p.position) && is_unit(p.normal);
    points.iter().position(|p| !usable(p)).map_or(Ok(()), |point| Err(BasisError::Point { point }))
}

/// Checks that squares of radii are in range.
pub(super) fn check_radii(radii: &[f32]) -> Result<(), BasisError> {
    match radii.iter().position(|r| !RADII.contains(r)) {
        Some(level) => Err(BasisError::Radius { level, radius: radii[level] }),
        None => Ok(()),
    }
}

fn range(offsets: &[u32], level: usize) -> Range<usize> {
    offsets[level] as usize..offsets[level + 1] as usize
}

/// Radius of support in units of the disk radius (`C` of the meshless paper, 2.3). Functions overlap little at the
/// coarsest level and much at the finest, which makes the sum smooth.
fn overlap(level: usize, levels: usize) -> f32 {
    1.5 + level as f32 / (levels.max(2) - 1) as f32
}
