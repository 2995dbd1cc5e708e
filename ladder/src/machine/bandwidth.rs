//! Measures how many bytes per second one thread can read from each level of memory.

use super::best::best_rate;
use lanes::{Emulated, Kernel, Lanes, Row, on_avx2};
use serde::Serialize;
use std::fs;
use std::hint::black_box;

/// A level of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Level {
    /// The first-level cache.
    L1,
    /// The second-level cache.
    L2,
    /// The third-level cache.
    L3,
    /// Main memory.
    #[serde(rename = "DRAM")]
    Dram,
}

impl Level {
    /// The usual name of the level.
    pub fn name(self) -> &'static str {
        match self {
            Self::L1 => "L1",
            Self::L2 => "L2",
            Self::L3 => "L3",
            Self::Dram => "DRAM",
        }
    }
}

/// The read bandwidth of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// The level.
    pub level: Level,
    /// The size of the data that is read repeatedly, in bytes.
    pub bytes: usize,
    /// Bytes read per second.
    pub bytes_per_second: f64,
}

/// Cache sizes to assume if the system does not provide them.
const USUAL_CACHES: [usize; 3] = [32 << 10, 512 << 10, 16 << 20];
/// The data for main memory is larger than the largest cache by this factor, but not larger than [`MOST`].
const BEYOND_CACHES: usize = 4;
const MOST: usize = 256 << 20;
/// Bytes that a trial reads, at least; all data is read at least once.
const TRIAL: usize = 32 << 20;

/// Measures with data of half the size of each cache, and with data much larger than all of them.
pub(super) fn measure() -> Vec<Bandwidth> {
    let sizes = sizes(caches());
    let data = vec![Row([1.5; 8]); sizes[3].1 / size_of::<Row>()];
    let level = |(level, bytes): (Level, usize)| {
        let passes = TRIAL.div_ceil(bytes);
        let read = || {
            let xor = Xor { rows: &data[..bytes / size_of::<Row>()], passes };
            black_box(on_avx2(xor).unwrap_or_else(Kernel::run::<Emulated>));
        };
        Bandwidth { level, bytes, bytes_per_second: best_rate((passes * bytes) as f64, read) }
    };
    sizes.map(level).into()
}

/// What is measured with data of how many bytes, none of which is more than the last: half of each cache, and much more than all.
fn sizes(caches: [usize; 3]) -> [(Level, usize); 4] {
    let most = (BEYOND_CACHES * caches[2]).min(MOST);
    let [first, second, third] = caches.map(|bytes| (bytes / 2).min(most));
    [(Level::L1, first), (Level::L2, second), (Level::L3, third), (Level::Dram, most)]
}

/// The sizes of the data caches of three levels, in bytes.
fn caches() -> [usize; 3] {
    let mut caches = USUAL_CACHES;
    for index in 0..8 {
        let read = |name: &str| {
            fs::read_to_string(format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{name}")).ok()
        };
        let (Some(level), Some(kind), Some(size)) = (read("level"), read("type"), read("size")) else {
            continue;
        };
        let level = level.trim().parse::<usize>().unwrap_or(0);
        if let (1..=3, "Data" | "Unified", Some(bytes)) = (level, kind.trim(), bytes_of(size.trim())) {
            caches[level - 1] = bytes;
        }
    }
    caches
}

/// Parses a size as the system writes it: `512K`, `32M`.
fn bytes_of(size: &str) -> Option<usize> {
    let (number, unit) = size.split_at(size.find(|c: char| !c.is_ascii_digit()).unwrap_or(size.len()));
    let shift = match unit {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        _ => return None,
    };
    number.parse::<usize>().ok().filter(|n| *n > 0).map(|n| n << shift)
}

/// Reads all rows, `passes` times. Rows are aligned, so that no load straddles two cache lines.
struct Xor<'a> {
    rows: &'a [Row],
    passes: usize,
}

/// Independent loads at a time.
const LOADS: usize = 8;

impl Kernel for Xor<'_> {
    type Output = u32;
    #[inline(always)]
    fn run<L: Lanes>(self) -> u32 {
        let mut sums = [<L::Eight as Lanes>::u(0); LOADS];
        for _ in 0..self.passes {
            for block in black_box(self.rows).chunks_exact(LOADS) {
                for k in 0..LOADS {
                    sums[k] = sums[k] ^ L::Eight::bits(L::Eight::load(&block[k].0));
                }
            }
        }
        let mut total = sums[0];
        for k in 1..LOADS {
            total = total ^ sums[k];
        }
        let mut lanes = [0; lanes::MOST_LANES];
        L::Eight::store_u(total, &mut lanes);
        lanes[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_as_the_system_writes_them() {
        let sizes =
            [("32K", Some(32 << 10)), ("1M", Some(1 << 20)), ("512", Some(512)), ("x", None), ("", None)];
        for (size, bytes) in sizes {
            assert_eq!(bytes_of(size), bytes, "{size}");
        }
    }

    #[test]
    fn data_fits_into_its_cache_and_is_more_than_all_caches() {
        let [l1, l2, l3, dram] = sizes([32 << 10, 1 << 20, 32 << 20]);
        assert_eq!([l1, l2, l3], [(Level::L1, 16 << 10), (Level::L2, 1 << 19), (Level::L3, 16 << 20)]);
        assert_eq!(dram, (Level::Dram, 128 << 20));
        // Of a huge cache, as much as there is data.
        let [.., l3, dram] = sizes([32 << 10, 1 << 20, 2 << 30]);
        assert_eq!([l3, dram], [(Level::L3, MOST), (Level::Dram, MOST)]);
    }

    #[test]
    fn every_word_of_whole_blocks_is_read() {
        let word = |k: u32| f32::from_bits(1 << (k % 31));
        let rows: Vec<Row> =
            (0..128).map(|row| Row(std::array::from_fn(|k| word(8 * row + k as u32)))).collect();
        let expected = rows.iter().fold(0, |sum, row| sum ^ row.0[0].to_bits());
        assert_eq!(Xor { rows: &rows, passes: 1 }.run::<Emulated>(), expected);
        assert_eq!(Xor { rows: &rows, passes: 2 }.run::<Emulated>(), 0);
    }
}
