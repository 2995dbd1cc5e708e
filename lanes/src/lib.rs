//! Vectors of 8 or 16 lanes: kernels are written once and give the same bits on AVX2, AVX-512 and plain Rust.
//!
//! A kernel is generic over the trait [`Lanes`], whose types and operations are one vector instruction each. [`dispatch`]
//! asks the processor what it has and runs the kernel on that back end:
//!
//! ```
//! use lanes::{Kernel, LaneKind, Lanes, dispatch};
//!
//! /// Square roots of as many numbers as there are lanes.
//! struct Roots([f32; 16]);
//!
//! impl Kernel for Roots {
//!     type Output = [f32; 16];
//!     #[inline(always)]
//!     fn run<L: Lanes>(mut self) -> Self::Output {
//!         for at in (0..16).step_by(L::N) {
//!             let roots = L::sqrt(L::load(&self.0[at..]));
//!             L::store(roots, &mut self.0[at..]);
//!         }
//!         self.0
//!     }
//! }
//!
//! for kind in LaneKind::ALL {
//!     assert_eq!(dispatch(kind, Roots([9.0; 16])), [3.0; 16]);
//! }
//! ```
//!
//! Kernels whose operations wait for each other have [`Lanes::Pair`], two vectors as one, if that takes less time.
//!
//! Two rules hold for every kernel:
//!
//! 1. It is `#[inline(always)]`, as is everything that it calls on lanes, and it has no closures or iterator adaptors
//!    around lane operations. The processor's features are enabled in one function of [`dispatch`] only; operations that
//!    are not inlined into it are calls, and such a loop ran three times slower. The result is the same either way.
//! 2. It uses exact or exactly rounded operations only, so that its bits do not depend on the back end. The exception is
//!    [`Lanes::fused`], for bounds with slack.
//!
//! # Safety
//!
//! All unsafe code of the workspace is in this crate: intrinsics, loads and stores in the back ends, the call into code
//! compiled for more features, and [`prefetch`]. The back ends for AVX2 and AVX-512 are private. A kernel is given one as
//! its parameter `L`, and only by [`dispatch`] or [`on_avx2`], after they have asked the processor: whoever holds the
//! type has the features. So nothing outside can run an instruction that the processor lacks.

// Without it the processor's features do not reach the operations: see rule 1 above.
#![allow(clippy::inline_always)]
// Iterators take closures, and closures do not inherit the features: loops over lanes count.
#![allow(clippy::needless_range_loop)]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod dispatch;
mod emulated;
#[cfg(target_arch = "x86_64")]
mod mask;
#[cfg(target_arch = "x86_64")]
mod masked;
mod operations;
mod paired;
mod prefetch;
mod row;
mod vec3;

pub use dispatch::{LaneKind, dispatch, on_avx2};
pub use emulated::Emulated;
pub use operations::{Kernel, Lanes, MOST_LANES};
pub use prefetch::prefetch;
pub use row::Row;
pub use vec3::V3;
