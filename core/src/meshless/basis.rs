//! Hierarchical basis functions around scattered surface points (meshless paper, 2.1 and 2.2).

use super::{FunctionPlace, Functions};
use crate::{sparse::SparseRows, surfel::Surfel, transport::Coefficient};
use glam::Vec3;
use std::{fmt, ops::Range};
use thiserror::Error;

/// Largest number of levels: the finest would have points too close for 32-bit floats.
pub const MOST_LEVELS: usize = 16;

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
    functions: Functions,
    sender_levels: usize,
}

impl fmt::Debug for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Basis")
            .field("offsets", &self.offsets())
            .field("radii", &self.radii())
            .field("sender_levels", &self.sender_levels)
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
        let levels = radii.len();
        let keys = |offsets: &[u32]| (0..levels).map(|level| (level, range(offsets, level))).collect();
        let functions = Functions::new(points, offsets, radii, keys)?;
        match (1..=levels).contains(&sender_levels) {
            true => Ok(Self { functions, sender_levels }),
            false => Err(BasisError::SenderLevels { sender_levels, levels }),
        }
    }

    /// The functions, with range queries.
    pub fn functions(&self) -> &Functions {
        &self.functions
    }

    /// Number of functions of all levels.
    pub fn len(&self) -> usize {
        self.points().len()
    }

    /// Whether there are no functions.
    pub fn is_empty(&self) -> bool {
        self.points().is_empty()
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.functions.levels()
    }

    /// The functions of a level.
    pub fn level(&self, level: usize) -> Range<usize> {
        self.functions.level(level)
    }

    /// First function of each level, and the end of the last.
    pub fn offsets(&self) -> &[u32] {
        self.functions.offsets()
    }

    /// The functions of the first `levels` levels.
    pub fn first_levels(&self, levels: usize) -> Range<usize> {
        0..self.offsets()[levels] as usize
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
        &self.points()[self.senders()]
    }

    /// The points of all functions.
    pub fn points(&self) -> &[Surfel] {
        self.functions.points()
    }

    /// Radius of support of each level in meters.
    pub fn radii(&self) -> &[f32] {
        self.functions.radii()
    }

    /// Bytes of the points as stored.
    pub fn bytes(&self) -> u64 {
        (size_of::<Surfel>() * self.len()) as u64
    }

    /// Appends all functions of a level that are nonzero at a surface point; see [`Functions::values`].
    #[inline]
    pub fn values(&self, level: usize, position: Vec3, normal: Vec3, out: &mut Vec<(u32, f32)>) {
        self.functions.values(level, &FunctionPlace::new(position, normal), out);
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
        let at = FunctionPlace::new(position, normal);
        self.functions.evaluate_in(self.functions.slot_at(level, &at), level, &at, coefficients).unwrap_or(T::ZERO)
    }

    /// Values of the functions of some levels at the points of `functions`, one row per point. A point's parents are
    /// its row over the level before; its children and neighbors are rows of the transpose.
    pub fn values_at(&self, functions: Range<usize>, levels: Range<usize>) -> SparseRows {
        let first = functions.start;
        SparseRows::build(functions.len(), |row, out| {
            let p = &self.points()[first + row];
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

fn range(offsets: &[u32], level: usize) -> Range<usize> {
    offsets[level] as usize..offsets[level + 1] as usize
}

/// Radius of support in units of the disk radius (`C` of the meshless paper, 2.3). Functions overlap little at the
/// coarsest level and much at the finest, which makes the sum smooth.
fn overlap(level: usize, levels: usize) -> f32 {
    1.5 + level as f32 / (levels.max(2) - 1) as f32
}
