//! The generators as sequences of 32-bit words, for statistical test suites.

use super::rand::Rand;
use scene::rng::{Family, Stream, StreamKey};

/// A sequence of words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Words {
    /// The C library's `rand`: the upper 16 of its 31 bits, two calls per word.
    Rand,
    /// A single xorshift32 generator. This is also a keyed stream, continued to its full period.
    Xorshift,
    /// xorshift32 as stage 3 uses it: 8 lanes by 8 vectors, one number from each in turn.
    Interleaved,
    /// The first four numbers of the keyed streams of photons 0, 1, 2, ..., which is close to their use in renders.
    Keyed,
    /// The first number of the keyed streams of photons 0, 1, 2, ..., which tests the hash that they start from.
    FirstOfKeyed,
}

impl Words {
    /// All sequences with their names.
    pub const ALL: [(&'static str, Self); 5] = [
        ("rand", Self::Rand),
        ("xorshift32", Self::Xorshift),
        ("xorshift32-lanes", Self::Interleaved),
        ("keyed", Self::Keyed),
        ("keyed-first", Self::FirstOfKeyed),
    ];

    /// The words, as an infinite sequence.
    pub fn from_seed(self, seed: u64) -> Box<dyn Iterator<Item = u32>> {
        match self {
            Self::Rand => {
                let rand = Rand::new(seed as u32);
                Box::new(std::iter::repeat_with(move || {
                    let (high, low) = (rand.next_i31() >> 15, rand.next_i31() >> 15);
                    (high << 16) | low
                }))
            }
            Self::Xorshift => {
                let mut stream = photons(seed, 0).stream(0);
                Box::new(std::iter::repeat_with(move || stream.next_u32()))
            }
            Self::Interleaved => {
                let mut lanes: Vec<Stream> = (0..64).map(|lane| photons(seed, 0).stream(lane)).collect();
                let mut lane = 0;
                Box::new(std::iter::repeat_with(move || {
                    lane = (lane + 1) % lanes.len();
                    lanes[lane].next_u32()
                }))
            }
            Self::Keyed => starts(seed, 4),
            Self::FirstOfKeyed => starts(seed, 1),
        }
    }
}

fn photons(seed: u64, iteration: u32) -> StreamKey {
    StreamKey::new(seed, Family::Photon, iteration)
}

/// The first `count` numbers of every photon's stream, iteration by iteration.
fn starts(seed: u64, count: usize) -> Box<dyn Iterator<Item = u32>> {
    let streams = (0..).flat_map(move |iteration| {
        let key = photons(seed, iteration);
        (0..=u32::MAX).map(move |index| key.stream(index))
    });
    Box::new(streams.flat_map(move |mut stream: Stream| (0..count).map(move |_| stream.next_u32())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    const SEED: u64 = 7;

    fn words(of: Words, count: usize) -> Vec<u32> {
        of.from_seed(SEED).take(count).collect()
    }

    /// The first words of the stream of photon `index` in the first iteration.
    fn of_photon(index: u32, count: usize) -> Vec<u32> {
        let mut stream = photons(SEED, 0).stream(index);
        (0..count).map(|_| stream.next_u32()).collect()
    }

    #[test]
    fn words_of_rand_are_the_upper_halves_of_two_calls() {
        let rand = Rand::new(SEED as u32);
        for word in words(Words::Rand, 10) {
            assert_eq!([word >> 16, word & 0xffff], [rand.next_i31() >> 15, rand.next_i31() >> 15]);
        }
    }

    #[test]
    fn streams_are_one_or_many_of_which_each_gives_its_first_words() {
        assert_eq!(words(Words::Xorshift, 20), of_photon(0, 20));
        assert_eq!(words(Words::Keyed, 12), [0, 1, 2].map(|photon| of_photon(photon, 4)).concat());
        assert_eq!(
            words(Words::FirstOfKeyed, 5),
            [0, 1, 2, 3, 4].map(|photon| of_photon(photon, 1)).concat()
        );
    }

    /// One word of each of 64 streams, and then the next of each.
    #[test]
    fn lanes_take_turns() {
        let interleaved = words(Words::Interleaved, 3 * 64);
        for (round, words) in interleaved.chunks(64).enumerate() {
            let expected: HashSet<u32> = (0..64).map(|lane| of_photon(lane, 3)[round]).collect();
            assert_eq!(words.iter().copied().collect::<HashSet<u32>>(), expected, "round {round}");
        }
    }

    #[test]
    fn sequences_have_names_of_their_own_and_follow_the_seed() {
        let names: HashSet<&str> = Words::ALL.iter().map(|(name, _)| *name).collect();
        assert_eq!(names.len(), Words::ALL.len());
        for (name, sequence) in Words::ALL {
            let [some, others] = [SEED, SEED + 1].map(|seed| sequence.from_seed(seed).nth(200));
            assert_ne!(some, others, "{name}");
        }
    }
}
