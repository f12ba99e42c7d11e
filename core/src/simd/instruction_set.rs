//! Which instructions a kernel runs in.

use super::Lanes;
#[cfg(target_arch = "x86_64")]
use super::avx2::Avx2;
use std::sync::LazyLock;
use wide::f32x8;

/// Work that is worth a path for each instruction set.
pub trait Kernel {
    /// Its result.
    type Output;

    /// Does the work. This and all that it calls with [`Lanes`], closures too, must be `#[inline(always)]`: in what is not
    /// inlined each operator is a call of a function, and the whole is slower than the plain build. For the same reason
    /// `Lanes` go through no `map` and no `from_fn`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Instructions that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstructionSet(Known);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    /// Those of the build.
    Portable,
    /// Registers of 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl InstructionSet {
    /// Those of the build, which every machine has.
    pub const PORTABLE: Self = Self(Known::Portable);

    /// All that this machine has, the widest last.
    pub fn available() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let known = {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            [Some(Known::Portable), avx2.then_some(Known::Avx2)]
        };
        #[cfg(not(target_arch = "x86_64"))]
        let known = [Some(Known::Portable)];
        known.into_iter().flatten().map(Self)
    }

    /// The widest that this machine has.
    pub fn widest() -> Self {
        static WIDEST: LazyLock<InstructionSet> =
            LazyLock::new(|| InstructionSet::available().last().unwrap_or(InstructionSet::PORTABLE));
        *WIDEST
    }

    /// Runs `kernel` in these instructions.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Known::Portable => kernel.run::<f32x8>(),
            // SAFETY: only `available` makes these values, and it asks the machine first.
            #[cfg(target_arch = "x86_64")]
            Known::Avx2 => unsafe { in_avx2(kernel) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn in_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}
