//! Stage 3: xorshift32 in eight lanes, several vectors at a time. It fills a pool from which numbers are taken.

use lanes::{Kernel, LaneKind, Lanes, dispatch};
use scene::rng::{Family, StreamKey, UNIT};

/// Lanes of a vector.
const LANES: usize = 8;
/// The largest number of vectors per refill.
const MOST: usize = 16;

/// A pool of random numbers, generated in advance.
pub(crate) struct Pool {
    state: [u32; LANES * MOST],
    values: [f32; LANES * MOST + LANES],
    next: usize,
    unroll: usize,
}

impl Pool {
    /// The choices of vectors per refill. The paper found 8 to be the best.
    pub(crate) const UNROLLS: [usize; 5] = [1, 2, 4, 8, 16];

    pub(crate) fn new(seed: u64, unroll: usize) -> Self {
        assert!(Self::UNROLLS.contains(&unroll), "no refill of {unroll} vectors");
        let key = StreamKey::new(seed, Family::Photon, 0);
        let state = std::array::from_fn(|lane| key.state(lane as u32));
        Self { state, values: [0.0; LANES * MOST + LANES], next: LANES * unroll, unroll }
    }

    /// A slice that begins with the next `lanes` numbers; the rest of it is not consumed.
    #[inline(always)]
    pub(crate) fn take(&mut self, lanes: usize) -> &[f32] {
        if self.next + lanes > LANES * self.unroll {
            self.refill();
        }
        let at = self.next;
        self.next += lanes;
        &self.values[at..]
    }

    #[inline(never)]
    fn refill(&mut self) {
        self.next = 0;
        dispatch(LaneKind::Avx2, Refill(self));
    }
}

struct Refill<'a>(&'a mut Pool);

impl Kernel for Refill<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        refill::<L>(self.0);
    }
}

/// Replaces all numbers of the pool by new ones.
#[inline(always)]
pub(super) fn refill<L: Lanes>(pool: &mut Pool) {
    match pool.unroll {
        1 => step::<L, 1>(pool),
        2 => step::<L, 2>(pool),
        4 => step::<L, 4>(pool),
        8 => step::<L, 8>(pool),
        _ => step::<L, 16>(pool),
    }
}

/// Steps `UNROLL` vectors side by side, so that their chains of operations overlap.
#[inline(always)]
fn step<L: Lanes, const UNROLL: usize>(pool: &mut Pool) {
    let mut x = [L::u(0); UNROLL];
    for k in 0..UNROLL {
        x[k] = L::load_u(&pool.state[LANES * k..]);
    }
    for k in 0..UNROLL {
        x[k] = x[k] ^ L::shl::<13>(x[k]);
    }
    for k in 0..UNROLL {
        x[k] = x[k] ^ L::shr::<17>(x[k]);
    }
    for k in 0..UNROLL {
        x[k] = x[k] ^ L::shl::<5>(x[k]);
    }
    for k in 0..UNROLL {
        L::store_u(x[k], &mut pool.state[LANES * k..]);
        L::store(L::to_float(L::shr::<8>(x[k])) * L::f(UNIT), &mut pool.values[LANES * k..]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unroll_factor_gives_each_lane_its_own_xorshift_sequence() {
        for unroll in Pool::UNROLLS {
            let key = StreamKey::new(5, Family::Photon, 0);
            let mut streams: Vec<_> = (0..LANES * unroll).map(|lane| key.stream(lane as u32)).collect();
            let mut pool = Pool::new(5, unroll);
            for draw in 0..5 * LANES * unroll {
                let lane = draw % (LANES * unroll);
                assert_eq!(pool.take(1)[0], streams[lane].next_f32(), "factor {unroll}, draw {draw}");
            }
        }
    }

    #[test]
    fn eight_at_a_time_come_whole() {
        let (mut ones, mut eights) = (Pool::new(7, 8), Pool::new(7, 8));
        for _ in 0..40 {
            let eight: Vec<f32> = eights.take(8)[..8].to_vec();
            for value in eight {
                assert_eq!(ones.take(1)[0], value);
            }
        }
    }
}
