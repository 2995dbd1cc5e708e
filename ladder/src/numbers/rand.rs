//! The generator `rand` of the GNU C library: the additive feedback generator of its `random` (type 3), behind a lock.

use scene::rng::unit_float;
use std::sync::Mutex;

/// Words of the state.
const DEGREE: usize = 31;
/// `r[i] = r[i - 31] + r[i - 3]`.
const SEPARATION: usize = 3;

/// The generator. The library has one per process and locks it on every call, which is a large part of the cost of a
/// call. This one locks too, although every render has its own.
pub(crate) struct Rand {
    state: Mutex<State>,
}

struct State {
    words: [u32; DEGREE],
    /// The index of the word to change next.
    front: usize,
}

impl Rand {
    /// The state after `srand(seed)`.
    pub(crate) fn new(seed: u32) -> Self {
        /// Parameters of the "minimal standard" generator (Park and Miller 1988) that fills the state.
        const MULTIPLIER: i64 = 16_807;
        const MODULUS: i64 = 2_147_483_647;
        let mut words = [0; DEGREE];
        // The library treats the seed as a signed number, and replaces 0 by 1.
        let mut word = i64::from(if seed == 0 { 1 } else { seed as i32 });
        for place in &mut words {
            *place = word as u32;
            word = (word * MULTIPLIER) % MODULUS;
            if word < 0 {
                word += MODULUS;
            }
        }
        let mut state = State { words, front: SEPARATION };
        for _ in 0..10 * DEGREE {
            state.step();
        }
        Self { state: Mutex::new(state) }
    }

    /// The result of `rand()`: 31 random bits.
    #[inline(never)]
    pub(crate) fn next_i31(&self) -> u32 {
        // If a thread panicked, its state is still valid.
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner).step()
    }

    /// A uniform float in [0, 1).
    #[inline(always)]
    pub(crate) fn next_f32(&self) -> f32 {
        unit_float(self.next_i31() << 1)
    }
}

impl State {
    #[inline(always)]
    fn step(&mut self) -> u32 {
        let rear =
            if self.front < SEPARATION { self.front + DEGREE - SEPARATION } else { self.front - SEPARATION };
        let word = self.words[self.front].wrapping_add(self.words[rear]);
        self.words[self.front] = word;
        self.front = if self.front + 1 == DEGREE { 0 } else { self.front + 1 };
        word >> 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_c_library() {
        // Printed by C programs that call srand(seed) and rand().
        let known: [(u32, [u32; 4]); 4] = [
            (1, [1_804_289_383, 846_930_886, 1_681_692_777, 1_714_636_915]),
            (42, [71_876_166, 708_592_740, 1_483_128_881, 907_283_241]),
            (0, [1_804_289_383, 846_930_886, 1_681_692_777, 1_714_636_915]),
            (4_000_000_000, [1_111_130_805, 1_380_198_982, 1_306_113_867, 1_557_021_840]),
        ];
        for (seed, expected) in known {
            let rand = Rand::new(seed);
            assert_eq!(expected.map(|_| rand.next_i31()), expected, "seed {seed}");
        }
    }
}
