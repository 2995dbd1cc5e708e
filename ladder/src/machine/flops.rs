//! The most floating-point operations in a second: fused multiply-adds in chains that do not wait for one another.

use super::best::best_rate;
use lanes::{Emulated, Kernel, Lanes, on_avx2};
use std::hint::black_box;

/// Chains side by side: at least latency times throughput, which is 8 to 10 on processors of today, and few enough for
/// the registers.
const CHAINS: usize = 10;
/// Steps of every chain between two looks of the optimiser's at the values.
const STEPS: usize = 64;
/// Rounds of so many steps: about 2 ms.
const ROUNDS: usize = 20_000;
/// A multiplication and an addition.
const FLOPS: usize = 2;

/// By single floats.
pub(super) fn scalar() -> f64 {
    best_rate((FLOPS * CHAINS * STEPS * ROUNDS) as f64, || {
        black_box(on_avx2(Scalar::<true>).unwrap_or_else(|_| Kernel::run::<Emulated>(Scalar::<false>)));
    })
}

/// By vectors of eight.
pub(super) fn vector() -> f64 {
    best_rate((8 * FLOPS * CHAINS * STEPS * ROUNDS) as f64, || {
        black_box(on_avx2(Vectors).unwrap_or_else(Kernel::run::<Emulated>));
    })
}

/// Factor and addend: x becomes 2, and stays there.
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

/// Where there are fused multiply-adds, they are used; where not, a multiplication and an addition.
struct Scalar<const FUSED: bool>;

impl<const FUSED: bool> Kernel for Scalar<FUSED> {
    type Output = f32;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let [a, b] = factors();
        // Ten variables, each hidden from the optimiser by itself: of an array it would make vectors.
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
