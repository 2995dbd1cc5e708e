//! The operations of the lanes, compared with plain Rust. All kernels depend on them.

use super::inputs::numbers;
use super::{GUARD, check_map, lane_kinds, tell};
use fast::kernels::operations::{
    Memory, arithmetic, comparison, count, fused, integers, mask, masks, rounding, shifts, shifts_by_lanes,
};
use std::panic::catch_unwind;

/// Special values: zeros, subnormals, ties of rounding, infinities, NaN.
const FLOATS: [f32; 22] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1.5,
    -1.5,
    2.5,
    0.999_999_94,
    -0.999_999_94,
    1e-45,
    -1e-45,
    f32::MIN_POSITIVE,
    8_388_607.5,
    -8_388_607.5,
    16_777_217.0,
    3e38,
    -3e38,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1e-20,
];

const WORDS: [u32; 10] =
    [0, 1, 2, 255, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0xaaaa_aaaa, 0x5555_5555, 0x1234_5678];

fn pairs<T: Copy>(of: &[T]) -> impl Iterator<Item = [T; 2]> {
    of.iter().flat_map(|a| of.iter().map(|b| [*a, *b]))
}

/// Pairs of floats: all pairs of special values, and random bits.
fn float_pairs() -> Vec<[f32; 2]> {
    let mut stream = numbers(1);
    let random = (0..20_000).map(|_| [stream.next_u32(), stream.next_u32()].map(f32::from_bits));
    pairs(&FLOATS).chain(random.collect::<Vec<_>>()).collect()
}

/// Pairs of words, as floats with the same bits.
fn word_pairs() -> Vec<[f32; 2]> {
    let mut stream = numbers(2);
    let random = (0..20_000).map(|_| [stream.next_u32(), stream.next_u32()]);
    pairs(&WORDS).chain(random.collect::<Vec<_>>()).map(|pair| pair.map(f32::from_bits)).collect()
}

#[test]
fn arithmetic_is_that_of_ieee_754() {
    let definition = |[a, b]: [f32; 2]| {
        let (max, min) = (if a > b { a } else { b }, if a < b { a } else { b });
        [a + b, a - b, a * b, a / b, -a, a.sqrt(), a.abs(), max, min]
    };
    tell(check_map("arithmetic", &float_pairs(), arithmetic, definition), "arithmetic");
}

#[test]
fn comparisons_are_false_for_nan() {
    let definition = |[a, b]: [f32; 2]| {
        [f32::from(u8::from(a < b)), f32::from(u8::from(a <= b)), if a < b { a } else { b }]
    };
    tell(check_map("comparison", &float_pairs(), comparison, definition), "comparisons");
}

#[test]
fn floats_round_to_integers_and_back() {
    // The operation is defined only in the range of an i32.
    let fits = |[a, _]: &[f32; 2]| a.abs() < 2_147_483_648.0;
    let rows: Vec<[f32; 1]> = float_pairs().into_iter().filter(fits).map(|[a, _]| [a]).collect();
    let definition = |[a]: [f32; 1]| [a.floor(), f32::from_bits(a as i32 as u32), (a as i32) as f32];
    tell(check_map("rounding", &rows, rounding, definition), "rounding");
}

#[test]
fn integers_wrap() {
    let definition = |row: [f32; 2]| {
        let [a, b] = row.map(f32::to_bits);
        let where_equal = if a == b { a } else { 0 };
        [a.wrapping_add(b), a.wrapping_mul(b), a & b, a | b, a ^ b, a.min(b), where_equal].map(f32::from_bits)
    };
    tell(check_map("integers", &word_pairs(), integers, definition), "integer operations");
}

#[test]
fn shifts_drop_bits_that_overflow() {
    let definition = |[a]: [f32; 1]| {
        let a = a.to_bits();
        [a << 1, a << 5, a << 13, a << 31, a >> 3, a >> 8, a >> 15, a >> 17].map(f32::from_bits)
    };
    let rows: Vec<[f32; 1]> = word_pairs().into_iter().map(|[a, _]| [a]).collect();
    tell(check_map("shifts", &rows, shifts, definition), "shifts");
}

#[test]
fn lanes_are_shifted_each_by_its_own_bits() {
    let definition = |row: [f32; 2]| {
        let [a, b] = row.map(f32::to_bits);
        [f32::from_bits(a >> (b % 32))]
    };
    let rows: Vec<[f32; 2]> =
        word_pairs().into_iter().flatten().enumerate().map(|(k, a)| [a, f32::from_bits(k as u32)]).collect();
    tell(check_map("shifts_by_lanes", &rows, shifts_by_lanes, definition), "shifts by lanes");
}

#[test]
fn masks_are_truth_values() {
    let rows: Vec<[f32; 3]> = word_pairs()
        .into_iter()
        .enumerate()
        .map(|(k, [w, _])| [f32::from_bits(k as u32 & 1), f32::from_bits((k as u32 >> 1) & 1), w])
        .collect();
    let definition = |row: [f32; 3]| {
        let [p, q, w] = row.map(f32::to_bits);
        let doubled = |m: bool| f32::from_bits(if m { w.wrapping_add(w) } else { w });
        [doubled(p != 0 && q != 0), doubled(p != 0 || q != 0), doubled(p == 0)]
    };
    tell(check_map("masks", &rows, masks, definition), "masks");
}

#[test]
fn fused_rounds_once_or_twice() {
    let mut stream = numbers(3);
    let mut number = || stream.next_f32() * 4.0 - 2.0;
    let rows: Vec<[f32; 3]> = (0..10_000).map(|_| [number(), number(), number()]).collect();
    for lanes in lane_kinds() {
        let columns: [Vec<f32>; 3] = std::array::from_fn(|k| rows.iter().map(|row| row[k]).collect());
        let mut out = vec![0.0; rows.len()];
        fused(lanes, columns.each_ref().map(|column| &column[..]), [&mut out]);
        for ([a, b, c], r) in rows.iter().zip(&out) {
            assert!(*r == a * b + c || *r == a.mul_add(*b, *c), "{lanes:?}: {a} * {b} + {c} is {r}");
        }
    }
    tell(rows.len(), "fused products");
}

/// Sets of lanes as bits: all sets of 8 lanes, and those of 16 whose halves are equal or complementary.
fn lane_bits(lanes: usize) -> impl Iterator<Item = u32> {
    let all = (1_u32 << lanes) - 1;
    (0..256_u32).flat_map(move |low| [low, low << 8 | low, low << 8 | (low ^ 255)].map(|bits| bits & all))
}

#[test]
fn masks_are_bits() {
    let mut cases = 0;
    for lanes in lane_kinds() {
        let n = count(lanes);
        let all = (1_u32 << n) - 1;
        assert!(n == 8 || n == 16);
        for bits in lane_bits(n) {
            for first in 0..=40 {
                let facts = mask(lanes, bits, first);
                assert_eq!(facts.bits, bits, "{lanes:?}");
                assert_eq!(facts.any, bits != 0, "{lanes:?} {bits:#b}");
                let expected = if first >= n { all } else { (1 << first) - 1 };
                assert_eq!(facts.first, expected, "{lanes:?}, first {first}");
                for (lane, counted) in facts.counted.into_iter().enumerate() {
                    assert_eq!(counted, if lane < n { lane as u32 } else { u32::MAX }, "{lanes:?}");
                }
                cases += 1;
            }
        }
        // Bits beyond the last lane are ignored.
        assert_eq!(mask(lanes, u32::MAX, 0).bits, all, "{lanes:?}");
    }
    tell(cases, "masks and bits");
}

/// Test values: floats, and their bits as words.
fn source() -> ([f32; 32], [u32; 32]) {
    let word = |k: usize| 0x3f80_0000 + 77 * k as u32;
    (std::array::from_fn(|k| f32::from_bits(word(k))), std::array::from_fn(word))
}

#[test]
fn loads_and_stores_keep_to_their_lanes() {
    let (floats, words) = source();
    let mut cases = 0;
    for lanes in lane_kinds() {
        let n = count(lanes);
        for at in 0..16 {
            let (mut to, mut to_words) = ([GUARD; 40], [7; 40]);
            Memory(lanes).copy(&floats[at..], &mut to[at + 1..]);
            Memory(lanes).copy_words(&words[at..], &mut to_words[at + 1..]);
            for k in 0..40 {
                let is_copied = (at + 1..at + 1 + n).contains(&k);
                let (float, word) = if is_copied { (floats[k - 1], words[k - 1]) } else { (GUARD, 7) };
                assert_eq!((to[k].to_bits(), to_words[k]), (float.to_bits(), word), "{lanes:?}, {k} of {at}");
            }
            cases += 2;
        }
    }
    tell(cases, "loads and stores");
}

#[test]
fn compression_moves_lanes_to_the_front_in_order() {
    let (floats, words) = source();
    let mut cases = 0;
    for lanes in lane_kinds() {
        let n = count(lanes);
        for bits in lane_bits(n) {
            let (mut to, mut to_words) = ([GUARD; 32], [7; 32]);
            Memory(lanes).compress(bits, &floats, &mut to);
            Memory(lanes).compress_words(bits, &words, &mut to_words);
            let chosen: Vec<usize> = (0..n).filter(|k| bits >> k & 1 == 1).collect();
            for (place, k) in chosen.iter().enumerate() {
                assert_eq!(to[place].to_bits(), floats[*k].to_bits(), "{lanes:?} {bits:#b}");
                assert_eq!(to_words[place], words[*k], "{lanes:?} {bits:#b}");
            }
            assert!(to[n..].iter().all(|x| x.to_bits() == GUARD.to_bits()), "{lanes:?}: past the lanes");
            assert!(to_words[n..].iter().all(|x| *x == 7), "{lanes:?}: past the lanes");
            cases += 2;
        }
    }
    tell(cases, "compressions");
}

#[test]
fn gathers_take_indices_modulo_the_length() {
    let mut cases = 0;
    let mut stream = numbers(4);
    for lanes in lane_kinds() {
        for bits in 0..12 {
            let table: Vec<u32> = (0..1_u32 << bits).map(|k| k.wrapping_mul(0x9e37_79b9) ^ 5).collect();
            for _ in 0..50 {
                let index: [u32; 16] = std::array::from_fn(|_| stream.next_u32());
                let mut to = [7; 24];
                Memory(lanes).gather(&table, &index, &mut to);
                for k in 0..24 {
                    let expected = if k < count(lanes) { table[index[k] as usize % table.len()] } else { 7 };
                    assert_eq!(to[k], expected, "{lanes:?}, {} words", table.len());
                }
                cases += 1;
            }
        }
    }
    tell(cases, "gathers");
}

#[test]
fn rows_become_columns_and_rows_again() {
    let row = |k: u32| std::array::from_fn(|j| f32::from_bits(0x4000_0000 + 8 * k + j as u32));
    let table: Vec<[f32; 8]> = (0..100).map(row).collect();
    let mut stream = numbers(5);
    let mut cases = 0;
    for lanes in lane_kinds() {
        let n = count(lanes);
        for _ in 0..200 {
            let index: [u32; 16] = std::array::from_fn(|_| stream.next_u32() % 100);
            let mut to = [[GUARD; 8]; 20];
            Memory(lanes).gather_rows(&table, &index, &mut to);
            for (k, row) in to.iter().enumerate() {
                let expected = if k < n { table[index[k] as usize] } else { [GUARD; 8] };
                assert_eq!(row.map(f32::to_bits), expected.map(f32::to_bits), "{lanes:?}, row {k}");
            }
            let first = index[0] as usize % 80;
            let columns = Memory(lanes).columns(&table[first..]);
            for (j, column) in columns.iter().enumerate() {
                for (k, value) in column.iter().enumerate() {
                    assert_eq!(
                        value.to_bits(),
                        table[first + k][j].to_bits(),
                        "{lanes:?}, row {k}, column {j}"
                    );
                }
                assert_eq!(column.len(), n);
            }
            cases += 2;
        }
    }
    tell(cases, "transpositions");
}

/// The last row of a table can be fetched into any lane, and the one after it into none.
#[test]
fn rows_beyond_the_end_of_a_table_are_refused() {
    let table = [[1.0; 8]; 100];
    let mut cases = 0;
    for lanes in lane_kinds() {
        for (lane, beyond) in (0..count(lanes)).flat_map(|lane| [0, 1, u32::MAX - 99].map(|b| (lane, b))) {
            let mut index = [99; 16];
            index[lane] += beyond;
            let fetch = || Memory(lanes).gather_rows(&table, &index, &mut [[0.0; 8]; 20]);
            assert_eq!(catch_unwind(fetch).is_err(), beyond > 0, "{lanes:?}, lane {lane}, {beyond} beyond");
            cases += 1;
        }
    }
    tell(cases, "rows at and beyond the end of a table");
}

#[test]
fn the_least_lane_is_one_with_the_least_value() {
    let mut stream = numbers(6);
    let mut cases = 0;
    for lanes in lane_kinds() {
        let n = count(lanes);
        for round in 0..2000 {
            // Few values, so that there are ties; infinities too.
            let values: [f32; 16] = std::array::from_fn(|_| match stream.next_u32() >> 8 & 7 {
                0 => f32::INFINITY,
                k => (k + round % 3) as f32 - 3.0,
            });
            let lane = Memory(lanes).min_lane(&values) as usize;
            let least = values[..n].iter().copied().fold(f32::INFINITY, f32::min);
            assert!(lane < n && values[lane] == least, "{lanes:?}: lane {lane} of {values:?}");
            cases += 1;
        }
    }
    tell(cases, "least lanes");
}

#[test]
fn batches_are_compacted_in_order() {
    let mut stream = numbers(7);
    let mut cases = 0;
    for lanes in lane_kinds() {
        for length in (0..=80).chain([255, 256]) {
            for share in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let keep: Vec<bool> = (0..length).map(|_| stream.next_f32() < share).collect();
                let expected: Vec<[u32; 4]> =
                    (0..length as u32).filter(|k| keep[*k as usize]).map(|k| [k; 4]).collect();
                assert_eq!(Memory(lanes).compact(&keep), expected, "{lanes:?}, {length} paths");
                cases += 1;
            }
        }
    }
    tell(cases, "compacted batches");
}
