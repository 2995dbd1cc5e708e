//! Times generators of random numbers: their latency, their throughput, and the time to take numbers from a pool as the
//! stages do.

use super::rand::Rand;
use super::xorshift::{Pool, refill};
use crate::machine::best_seconds;
use fast::kernels::{next_uniform, stream_state};
use lanes::{Emulated, Kernel, LaneKind, Lanes, on_avx2};
use scene::rng::{Family, StreamKey};
use std::hint::black_box;

/// The times of a generator, in nanoseconds.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberTimes {
    /// The name of the generator.
    pub name: String,
    /// From a state to the next, with nothing to overlap; `None` if there is no chain of states.
    pub latency: Option<f64>,
    /// Per number, when many are generated.
    pub throughput: f64,
    /// Per number, when numbers are generated in advance and taken one at a time; `None` if they are not.
    pub taken: Option<f64>,
}

/// Numbers per measurement, which take about 2 ms with the slowest generator.
const COUNT: u32 = 1 << 18;

/// Times all generators.
pub fn time_numbers() -> Vec<NumberTimes> {
    let mut times = vec![rand(), scalar()];
    times.extend(Pool::UNROLLS.map(vectors));
    times.push(keyed());
    times.push(keyed_in_lanes());
    times
}

/// Nanoseconds per item, if `run` processes `count` items.
fn each(count: u32, run: impl FnMut()) -> f64 {
    best_seconds(run) * 1e9 / f64::from(count)
}

/// Each call waits for the one before, as the state is behind a lock. So latency and throughput are the same.
fn rand() -> NumberTimes {
    let rand = Rand::new(1);
    let call = each(COUNT, || {
        let mut total = 0.0;
        for _ in 0..COUNT {
            total += rand.next_f32();
        }
        black_box(total);
    });
    NumberTimes {
        name: "rand of the C library (our copy of it)".into(),
        latency: Some(call),
        throughput: call,
        taken: None,
    }
}

fn scalar() -> NumberTimes {
    let mut stream = StreamKey::new(1, Family::Photon, 0).stream(0);
    let step = each(COUNT, || {
        let mut total = 0.0;
        for _ in 0..COUNT {
            total += stream.next_f32();
        }
        black_box(total);
    });
    NumberTimes { name: "xorshift32, scalar".into(), latency: Some(step), throughput: step, taken: None }
}

/// xorshift32 in eight lanes, `unroll` vectors at a time. The latency is that of a refill, which passes its state
/// through memory.
fn vectors(unroll: usize) -> NumberTimes {
    let refills = COUNT / (8 * unroll as u32);
    let mut pool = Pool::new(1, unroll);
    let refill = each(refills, || {
        let pool = &mut pool;
        on_avx2(Refills { pool, refills }).unwrap_or_else(Kernel::run::<Emulated>);
    });
    let mut pool = Pool::new(1, unroll);
    let taken = each(COUNT, || {
        let mut total = 0.0;
        for _ in 0..COUNT {
            total += pool.take(1)[0];
        }
        black_box(total);
    });
    NumberTimes {
        name: format!("xorshift32, 8 lanes, {unroll} at a time"),
        latency: Some(refill),
        throughput: refill / (8 * unroll) as f64,
        taken: Some(taken),
    }
}

/// A kernel that only refills a pool.
struct Refills<'a> {
    pool: &'a mut Pool,
    refills: u32,
}

impl Kernel for Refills<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for _ in 0..self.refills {
            refill::<L>(black_box(&mut *self.pool));
        }
    }
}

/// Numbers drawn from each stream, about as many as a photon's path draws.
const DRAWS: u32 = 4;

fn keyed() -> NumberTimes {
    let key = StreamKey::new(1, Family::Photon, 0);
    let throughput = each(COUNT, || {
        let mut total = 0.0;
        for index in 0..COUNT / DRAWS {
            let mut stream = key.stream(index);
            for _ in 0..DRAWS {
                total += stream.next_f32();
            }
        }
        black_box(total);
    });
    NumberTimes {
        name: format!("keyed streams, scalar, {DRAWS} numbers of each"),
        latency: None,
        throughput,
        taken: None,
    }
}

/// Streams that are stepped together; their states fit the first-level cache.
const BLOCK: usize = 256;

fn keyed_in_lanes() -> NumberTimes {
    let key = StreamKey::new(1, Family::Photon, 0);
    let index: Vec<f32> = (0..BLOCK as u32).map(f32::from_bits).collect();
    let (mut states, mut after, mut values) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
    let throughput = each(COUNT, || {
        for _ in 0..COUNT / DRAWS / BLOCK as u32 {
            stream_state(LaneKind::Avx2, key, [black_box(&index)], [&mut states]);
            for _ in 0..DRAWS {
                next_uniform(LaneKind::Avx2, [&states], [&mut after, black_box(&mut values)]);
                std::mem::swap(&mut states, &mut after);
            }
        }
    });
    NumberTimes {
        name: format!("keyed streams, 8 lanes, {DRAWS} numbers of each"),
        latency: None,
        throughput,
        taken: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// Nobody wakes up too early, and of many trials one is hardly late.
    #[test]
    fn times_are_nanoseconds_of_one_item() {
        let sleep = each(1000, || std::thread::sleep(Duration::from_millis(1)));
        assert!((1000.0..100_000.0).contains(&sleep), "{sleep} ns");
    }

    /// A refill makes as many numbers as its vectors have lanes, and takes as long as all of them.
    #[test]
    fn the_latency_of_vectors_is_that_of_all_their_numbers() {
        let times = vectors(4);
        assert_eq!(times.name, "xorshift32, 8 lanes, 4 at a time");
        let of_all = times.latency.unwrap() / times.throughput;
        approx::assert_relative_eq!(of_all, 32.0, max_relative = 1e-9);
        assert!(times.taken.is_some(), "{times:?}");
    }

    /// A scalar generator waits for itself, so each of its numbers takes as long as a step.
    #[test]
    fn a_scalar_generator_takes_its_latency_for_each_number() {
        let times = scalar();
        assert_eq!((times.latency, times.taken), (Some(times.throughput), None));
    }
}
