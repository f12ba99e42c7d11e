//! Eight numbers in one register of 256 bits.
//!
//! The operators have no target feature: they are inlined into a function that has it, see [`super::instruction_set`].
//! Only that module creates such values, and only if the machine has AVX2.

use super::{Lanes, sealed::Sealed};
use std::{
    arch::x86_64::*,
    ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub},
};
use wide::f32x8;

/// Eight `f32` of AVX2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(__m256);

impl Sealed for Avx2 {}

macro_rules! operators {
    ($($trait:ident $name:ident $intrinsic:ident),*) => {$(
        impl $trait for Avx2 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a value of this type exists only where the machine has AVX2.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    )*};
}

operators!(
    Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps,
    BitAnd bitand _mm256_and_ps, BitOr bitor _mm256_or_ps
);

impl Neg for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

macro_rules! comparisons {
    ($($name:ident $predicate:ident),*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            // SAFETY: as for the operators.
            Self(unsafe { _mm256_cmp_ps::<$predicate>(self.0, other.0) })
        }
    )*};
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn splat(v: f32) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_set1_ps(v) })
    }

    #[inline(always)]
    fn new(v: [f32; 8]) -> Self {
        // SAFETY: as for the operators; the array holds the eight that are loaded.
        Self(unsafe { _mm256_loadu_ps(v.as_ptr()) })
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        let mut v = [0.0; 8];
        // SAFETY: as for the operators; the array holds the eight that are stored.
        unsafe { _mm256_storeu_ps(v.as_mut_ptr(), self.0) };
        v
    }

    #[inline(always)]
    fn transposed(rows: [&[f32; 8]; 8]) -> [Self; 8] {
        let [a, b, c, d] = four_columns::<0>(rows);
        let [e, f, g, h] = four_columns::<4>(rows);
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    /// The portable exponential, for equal bits.
    #[inline(always)]
    fn exp(self) -> Self {
        Self::new(f32x8::new(self.to_array()).exp().to_array())
    }

    /// See the exponential.
    #[inline(always)]
    fn ln(self) -> Self {
        Self::new(f32x8::new(self.to_array()).ln().to_array())
    }

    #[inline(always)]
    fn fast_max(self, other: Self) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn fast_min(self, other: Self) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    comparisons!(
        simd_gt _CMP_GT_OQ, simd_ge _CMP_GE_OQ, simd_lt _CMP_LT_OQ, simd_le _CMP_LE_OQ, simd_ne _CMP_NEQ_UQ
    );

    #[inline(always)]
    fn select(self, if_true: Self, if_false: Self) -> Self {
        // SAFETY: as for the operators.
        Self(unsafe { _mm256_blendv_ps(if_false.0, if_true.0, self.0) })
    }

    #[inline(always)]
    fn to_bitmask(self) -> u32 {
        // SAFETY: as for the operators.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

/// Columns `FIRST` to `FIRST + 3`. Rows 0 and 4, 1 and 5 and so on share a register, so no number crosses between its halves.
#[inline(always)]
fn four_columns<const FIRST: usize>(rows: [&[f32; 8]; 8]) -> [Avx2; 4] {
    // SAFETY: as for the operators.
    unsafe {
        let r0 = two_rows::<FIRST>(rows[0], rows[4]);
        let r1 = two_rows::<FIRST>(rows[1], rows[5]);
        let r2 = two_rows::<FIRST>(rows[2], rows[6]);
        let r3 = two_rows::<FIRST>(rows[3], rows[7]);
        let (a, b) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
        let (c, d) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
        [
            Avx2(_mm256_shuffle_ps::<0b01_00_01_00>(a, c)),
            Avx2(_mm256_shuffle_ps::<0b11_10_11_10>(a, c)),
            Avx2(_mm256_shuffle_ps::<0b01_00_01_00>(b, d)),
            Avx2(_mm256_shuffle_ps::<0b11_10_11_10>(b, d)),
        ]
    }
}

/// Four numbers of each row from `FIRST`, 0 or 4.
#[inline(always)]
fn two_rows<const FIRST: usize>(low: &[f32; 8], high: &[f32; 8]) -> __m256 {
    const { assert!(FIRST + 4 <= 8) };
    // SAFETY: as for the operators; four numbers are loaded of the eight, from the first or the fifth.
    unsafe {
        let low = _mm256_castps128_ps256(_mm_loadu_ps(low.as_ptr().add(FIRST)));
        _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(high.as_ptr().add(FIRST)))
    }
}
