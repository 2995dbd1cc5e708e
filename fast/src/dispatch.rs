//! The one place where a back end is chosen.

use crate::lanes::{Emulated, Lanes};
#[cfg(target_arch = "x86_64")]
use crate::lanes::{avx2::Avx2, avx512::Avx512};

/// Which vectors the kernels run on. Each gives the same bits. A kind that a processor lacks is emulated there, so that
/// tests reach the kernels at every width on any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaneKind {
    /// Eight lanes of plain Rust; runs anywhere.
    Emulated,
    /// Eight lanes of AVX2 (and FMA, BMI, LZCNT and POPCNT, which came with it).
    Avx2,
    /// Sixteen lanes of AVX-512 (F, BW, DQ, VL).
    Avx512,
}

impl LaneKind {
    /// All kinds, the plainest first.
    pub const ALL: [Self; 3] = [Self::Emulated, Self::Avx2, Self::Avx512];

    /// True if this processor has them.
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Emulated => true,
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && Self::Avx2.is_available()
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            self == Self::Emulated
        }
    }

    /// The fastest kind that this processor has.
    pub fn best() -> Self {
        Self::ALL.into_iter().rev().find(|kind| kind.is_available()).unwrap_or(Self::Emulated)
    }
}

/// Work that can be done on any lanes.
pub trait Kernel {
    /// What comes of it.
    type Output;
    /// Does the work. To be marked `#[inline(always)]`, as all that it calls on lanes, lest the features get lost.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a kernel on lanes of the given kind; on as many emulated ones where the processor lacks it.
pub fn dispatch<K: Kernel>(kind: LaneKind, kernel: K) -> K::Output {
    match kind {
        // SAFETY: the processor has been asked for exactly these features.
        #[cfg(target_arch = "x86_64")]
        LaneKind::Avx2 if kind.is_available() => unsafe { run_on_avx2(kernel) },
        // SAFETY: the processor has been asked for exactly these features.
        #[cfg(target_arch = "x86_64")]
        LaneKind::Avx512 if kind.is_available() => unsafe { run_on_avx512(kernel) },
        LaneKind::Emulated | LaneKind::Avx2 => kernel.run::<Emulated<8>>(),
        LaneKind::Avx512 => kernel.run::<Emulated<16>>(),
    }
}

/// Runs a kernel on lanes of AVX2 alone, which takes one instance of it instead of three.
///
/// # Errors
/// Gives the kernel back where the processor lacks them.
pub fn on_avx2<K: Kernel>(kernel: K) -> Result<K::Output, K> {
    #[cfg(target_arch = "x86_64")]
    if LaneKind::Avx2.is_available() {
        // SAFETY: the processor has been asked for exactly these features.
        return Ok(unsafe { run_on_avx2(kernel) });
    }
    Err(kernel)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_on_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
fn run_on_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx512>()
}
