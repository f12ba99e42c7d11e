//! Eight numbers and eight vectors at once, in the instructions of the machine.
//!
//! A plain build may use only 128 bits on x86-64. Code worth 256 bits is a [`Kernel`], generic over [`Lanes`], which an
//! [`InstructionSet`] runs. All sets give the same bits: they round each operation by IEEE 754, and none fuses a
//! product with a sum.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod instruction_set;

pub use instruction_set::{InstructionSet, Kernel};

use glam::Vec3;
use std::{
    fmt::Debug,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub},
};
use wide::f32x8;

/// Eight `f32`. Comparisons give masks: all bits of a lane, or none.
pub trait Lanes:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + sealed::Sealed
{
    /// The same number eight times.
    fn splat(v: f32) -> Self;
    /// Eight numbers.
    fn new(v: [f32; 8]) -> Self;
    /// The eight numbers.
    fn to_array(self) -> [f32; 8];
    /// Columns of eight rows.
    fn transposed(rows: [&[f32; 8]; 8]) -> [Self; 8];
    /// Square roots.
    fn sqrt(self) -> Self;
    /// Absolute values.
    fn abs(self) -> Self;
    /// Exponentials.
    fn exp(self) -> Self;
    /// Natural logarithms.
    fn ln(self) -> Self;
    /// The larger of each pair. `other` where one is NaN.
    fn fast_max(self, other: Self) -> Self;
    /// The smaller of each pair. `other` where one is NaN.
    fn fast_min(self, other: Self) -> Self;
    /// A mask of `self > other`.
    fn simd_gt(self, other: Self) -> Self;
    /// A mask of `self >= other`.
    fn simd_ge(self, other: Self) -> Self;
    /// A mask of `self < other`.
    fn simd_lt(self, other: Self) -> Self;
    /// A mask of `self <= other`.
    fn simd_le(self, other: Self) -> Self;
    /// A mask of `self != other`.
    fn simd_ne(self, other: Self) -> Self;
    /// For a mask: `if_true` where it is set, else `if_false`.
    fn select(self, if_true: Self, if_false: Self) -> Self;
    /// For a mask: one bit per lane.
    fn to_bitmask(self) -> u32;

    /// The larger of each number and `least`, which is not NaN; NaN becomes `least`.
    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        self.fast_max(Self::splat(least))
    }

    /// The same numbers for any other instruction set.
    #[inline(always)]
    fn portable(self) -> f32x8 {
        f32x8::new(self.to_array())
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for wide::f32x8 {}
}

/// For every machine: 128-bit vectors, or more if the build allows.
impl Lanes for f32x8 {
    #[inline(always)]
    fn splat(v: f32) -> Self {
        f32x8::splat(v)
    }

    #[inline(always)]
    fn new(v: [f32; 8]) -> Self {
        f32x8::new(v)
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        f32x8::to_array(self)
    }

    #[inline(always)]
    fn transposed(rows: [&[f32; 8]; 8]) -> [Self; 8] {
        std::array::from_fn(|column| f32x8::new(std::array::from_fn(|row| rows[row][column])))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x8::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32x8::abs(self)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        f32x8::exp(self)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        f32x8::ln(self)
    }

    #[inline(always)]
    fn fast_max(self, other: Self) -> Self {
        f32x8::fast_max(self, other)
    }

    #[inline(always)]
    fn fast_min(self, other: Self) -> Self {
        f32x8::fast_min(self, other)
    }

    #[inline(always)]
    fn simd_gt(self, other: Self) -> Self {
        f32x8::simd_gt(self, other)
    }

    #[inline(always)]
    fn simd_ge(self, other: Self) -> Self {
        f32x8::simd_ge(self, other)
    }

    #[inline(always)]
    fn simd_lt(self, other: Self) -> Self {
        f32x8::simd_lt(self, other)
    }

    #[inline(always)]
    fn simd_le(self, other: Self) -> Self {
        f32x8::simd_le(self, other)
    }

    #[inline(always)]
    fn simd_ne(self, other: Self) -> Self {
        f32x8::simd_ne(self, other)
    }

    #[inline(always)]
    fn select(self, if_true: Self, if_false: Self) -> Self {
        f32x8::select(self, if_true, if_false)
    }

    #[inline(always)]
    fn to_bitmask(self) -> u32 {
        f32x8::to_bitmask(self)
    }

    /// With NEON, the minimum and maximum of the library keep NaN.
    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        f32x8::max(self, f32x8::splat(least))
    }
}

/// Eight 3D vectors, component by component.
#[derive(Clone, Copy, Debug)]
pub struct Vec3x8<L = f32x8> {
    /// X components.
    pub x: L,
    /// Y components.
    pub y: L,
    /// Z components.
    pub z: L,
}

impl<L: Lanes> Vec3x8<L> {
    /// The same vector eight times.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self { x: L::splat(v.x), y: L::splat(v.y), z: L::splat(v.z) }
    }

    /// Eight vectors.
    #[inline(always)]
    pub fn from_array(v: [Vec3; 8]) -> Self {
        let [mut x, mut y, mut z] = [[0.0; 8]; 3];
        for (i, v) in v.iter().enumerate() {
            (x[i], y[i], z[i]) = (v.x, v.y, v.z);
        }
        Self { x: L::new(x), y: L::new(y), z: L::new(z) }
    }

    /// The same vectors, from memory that all instruction sets share.
    #[inline(always)]
    pub fn load(v: &Vec3x8) -> Self {
        Self { x: L::new(v.x.to_array()), y: L::new(v.y.to_array()), z: L::new(v.z.to_array()) }
    }

    /// The same vectors for any other instruction set.
    #[inline(always)]
    pub fn portable(self) -> Vec3x8 {
        Vec3x8 { x: self.x.portable(), y: self.y.portable(), z: self.z.portable() }
    }

    /// Vector `i`.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Vec3 {
        Vec3::new(self.x.to_array()[i], self.y.to_array()[i], self.z.to_array()[i])
    }

    /// Dot products.
    #[inline(always)]
    pub fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Cross products.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Component-wise product, as for colors.
    #[inline(always)]
    pub fn scale(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    /// The sum of the eight vectors, in the same order for all instruction sets.
    #[inline(always)]
    pub fn reduce_add(self) -> Vec3 {
        Vec3::new(self.x.portable().reduce_add(), self.y.portable().reduce_add(), self.z.portable().reduce_add())
    }
}

impl<L: Lanes> Add for Vec3x8<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<L: Lanes> Sub for Vec3x8<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<L: Lanes> Mul<L> for Vec3x8<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: L) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

#[cfg(test)]
mod tests;
