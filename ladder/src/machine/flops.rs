//! Measures the peak rate of floating-point operations, with independent chains of fused multiply-adds.

use super::best::best_rate;
use lanes::{Emulated, Kernel, Lanes, on_avx2};
use std::hint::black_box;

/// Independent chains: at least latency times throughput, which is 8 to 10 on current processors, and few enough for
/// the registers.
const CHAINS: usize = 10;
/// Steps of every chain between two points where values are hidden from the optimiser.
const STEPS: usize = 64;
/// Rounds of [`STEPS`] steps, which take about 2 ms.
const ROUNDS: usize = 20_000;
/// FLOPs of a step: a multiplication and an addition.
const FLOPS: usize = 2;

/// FLOPs per second with single floats.
pub(super) fn scalar() -> f64 {
    best_rate((FLOPS * CHAINS * STEPS * ROUNDS) as f64, || {
        black_box(on_avx2(Scalar::<true>).unwrap_or_else(|_| Kernel::run::<Emulated>(Scalar::<false>)));
    })
}

/// FLOPs per second with vectors of eight floats.
pub(super) fn vector() -> f64 {
    best_rate((8 * FLOPS * CHAINS * STEPS * ROUNDS) as f64, || {
        black_box(on_avx2(Vectors).unwrap_or_else(Kernel::run::<Emulated>));
    })
}

/// Factor and addend of a step. With these x converges to 2, so it neither overflows nor becomes subnormal.
fn factors() -> [f32; 2] {
    black_box([0.5, 1.0])
}

struct Vectors;

impl Kernel for Vectors {
    type Output = f32;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let [a, b] = factors();
        let (a, b) = (L::f(a), L::f(b));
        let mut x = [L::f(0.0); CHAINS];
        for _ in 0..ROUNDS {
            for _ in 0..STEPS {
                for chain in 0..CHAINS {
                    x[chain] = L::fused(x[chain], a, b);
                }
            }
        }
        let mut total = x[0];
        for chain in 1..CHAINS {
            total = total + x[chain];
        }
        let mut lanes = [0.0; lanes::MOST_LANES];
        L::store(total, &mut lanes);
        lanes[0]
    }
}

/// Uses fused multiply-adds if `FUSED`, else a multiplication and an addition.
struct Scalar<const FUSED: bool>;

impl<const FUSED: bool> Kernel for Scalar<FUSED> {
    type Output = f32;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let [a, b] = factors();
        // Ten variables, each hidden from the optimiser separately; it would turn an array into vectors.
        macro_rules! chains {
            ($($x:ident)*) => {{
                $(let mut $x = 0.0_f32;)*
                for _ in 0..ROUNDS {
                    $($x = black_box($x);)*
                    for _ in 0..STEPS {
                        $($x = if FUSED { $x.mul_add(a, b) } else { $x * a + b };)*
                    }
                }
                0.0 $(+ $x)*
            }};
        }
        chains!(c0 c1 c2 c3 c4 c5 c6 c7 c8 c9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_end_at_their_fixed_point() {
        let scalar = Kernel::run::<Emulated>(Scalar::<false>);
        assert_eq!(scalar, 2.0 * CHAINS as f32);
        assert_eq!(Vectors.run::<Emulated>(), scalar);
        if let Ok(fused) = on_avx2(Scalar::<true>) {
            assert_eq!(fused, scalar);
        }
    }
}
