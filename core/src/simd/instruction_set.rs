//! Instruction sets for kernels.

use super::Lanes;
#[cfg(target_arch = "x86_64")]
use super::avx2::Avx2;
use std::sync::LazyLock;
use wide::f32x8;

/// Work that benefits from a version per instruction set.
pub trait Kernel {
    /// Result of the work.
    type Output;

    /// Does the work. It and everything it calls with [`Lanes`], closures included, must be `#[inline(always)]`:
    /// otherwise each operator is a function call, and the kernel is slower than the plain build. For the same reason
    /// `Lanes` never pass through `map` or `from_fn`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Instructions available on this machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstructionSet(Known);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    /// The instructions of the build.
    Portable,
    /// Registers of 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl InstructionSet {
    /// The instructions of the build, available on every machine.
    pub const PORTABLE: Self = Self(Known::Portable);

    /// All sets of this machine, the widest last.
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

    /// The widest set of this machine.
    pub fn widest() -> Self {
        static WIDEST: LazyLock<InstructionSet> =
            LazyLock::new(|| InstructionSet::available().last().unwrap_or(InstructionSet::PORTABLE));
        *WIDEST
    }

    /// Runs `kernel` with these instructions.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Known::Portable => kernel.run::<f32x8>(),
            // SAFETY: only `available` creates this value, after checking the machine.
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
