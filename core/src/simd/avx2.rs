//! Eight numbers in one register of 256 bits.
//!
//! The operators carry no target feature of their own: they are inlined into a function that does, see
//! [`super::instruction_set`], which alone makes such values, and only where the machine has AVX2.

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

    /// Halves of rows 0 and 4, 1 and 5 and so on share a register, so that no value crosses between halves again.
    #[inline(always)]
    fn transposed(rows: [&[f32; 8]; 8]) -> [Self; 8] {
        // SAFETY: as for the operators; loads of four begin at the first or at the fifth of eight.
        unsafe {
            let half = |row: usize, from: usize| {
                let at = |row: usize| _mm_loadu_ps(rows[row][from..from + 4].as_ptr());
                _mm256_set_m128(at(row + 4), at(row))
            };
            let four = |from: usize| {
                let [r0, r1, r2, r3] = [half(0, from), half(1, from), half(2, from), half(3, from)];
                let (a, b) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
                let (c, d) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
                [
                    _mm256_shuffle_ps::<0b01_00_01_00>(a, c),
                    _mm256_shuffle_ps::<0b11_10_11_10>(a, c),
                    _mm256_shuffle_ps::<0b01_00_01_00>(b, d),
                    _mm256_shuffle_ps::<0b11_10_11_10>(b, d),
                ]
            };
            let ([a, b, c, d], [e, f, g, h]) = (four(0), four(4));
            [Self(a), Self(b), Self(c), Self(d), Self(e), Self(f), Self(g), Self(h)]
        }
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

    /// That of the other machines, to have its bits.
    #[inline(always)]
    fn exp(self) -> Self {
        Self::new(f32x8::new(self.to_array()).exp().to_array())
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
