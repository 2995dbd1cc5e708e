//! The operations of the lanes themselves.

use super::maps::maps;
use crate::paths::{BATCH, Packet, Paths};
use lanes::{Kernel, LaneKind, Lanes, MOST_LANES, Row, dispatch};

maps! {
    /// `a + b`, `a - b`, `a * b`, `a / b`, `-a`, square root and absolute value of a, maximum and minimum of a and b.
    arithmetic() [a, b] -> 9 {
        [a + b, a - b, a * b, a / b, -a, L::sqrt(a), L::abs(a), L::max(a, b), L::min(a, b)]
    }

    /// `a * b + c`, rounded once or twice.
    fused() [a, b, c] -> 1 {
        [L::fused(a, b, c)]
    }

    /// The floor, the integer toward zero (a word), and the float of that.
    rounding() [a] -> 3 {
        let whole = L::truncate(a);
        [L::floor(a), L::from_bits(whole), L::to_float(whole)]
    }

    /// `a < b` and `a <= b`, as 1 or 0; then a where `a < b`, else b.
    comparison() [a, b] -> 3 {
        let (one, zero) = (L::f(1.0), L::f(0.0));
        let (lt, le) = (L::lt(a, b), L::le(a, b));
        [L::select(lt, one, zero), L::select(le, one, zero), L::select(lt, a, b)]
    }

    /// Of words: sum, product, and, or, exclusive or, minimum, and the left one where they are equal, else 0.
    integers() [a, b] -> 7 {
        let (a, b) = (L::bits(a), L::bits(b));
        let where_equal = L::select_u(L::eq(a, b), a, L::u(0));
        floats::<L, 7>([a + b, a * b, a & b, a | b, a ^ b, L::min_u(a, b), where_equal])
    }

    /// Of words: shifts to the left by 1, 5, 13 and 31, and to the right by 3, 8, 15 and 17.
    shifts() [a] -> 8 {
        let a = L::bits(a);
        let left = [L::shl::<1>(a), L::shl::<5>(a), L::shl::<13>(a), L::shl::<31>(a)];
        let right = [L::shr::<3>(a), L::shr::<8>(a), L::shr::<15>(a), L::shr::<17>(a)];
        floats::<L, 8>([left[0], left[1], left[2], left[3], right[0], right[1], right[2], right[3]])
    }

    /// Of words: a shifted to the right by the lowest five bits of b.
    shifts_by_lanes() [a, b] -> 1 {
        floats::<L, 1>([L::shr_by(L::bits(a), L::bits(b) & L::u(u32::BITS - 1))])
    }

    /// Words `w` with masks p and q (true if not 0): where p and q, p or q, and not p, w is added to itself.
    masks() [p, q, w] -> 3 {
        let (p, q) = (!L::eq(L::bits(p), L::u(0)), !L::eq(L::bits(q), L::u(0)));
        let w = L::bits(w);
        floats::<L, 3>([L::add_where(p & q, w, w), L::add_where(p | q, w, w), L::add_where(!p, w, w)])
    }
}

/// Words as floats of the same bits.
#[inline(always)]
fn floats<L: Lanes, const N: usize>(words: [L::U; N]) -> [L::F; N] {
    let mut floats = [L::f(0.0); N];
    for k in 0..N {
        floats[k] = L::from_bits(words[k]);
    }
    floats
}

/// How many lanes there are.
pub fn count(lanes: LaneKind) -> usize {
    struct Count;
    impl Kernel for Count {
        type Output = usize;
        #[inline(always)]
        fn run<L: Lanes>(self) -> usize {
            L::N
        }
    }
    dispatch(lanes, Count)
}

/// A mask made from bits, and the mask of the first `n` lanes.
pub fn mask(lanes: LaneKind, bits: u32, n: usize) -> MaskFacts {
    struct Mask(u32, usize);
    impl Kernel for Mask {
        type Output = MaskFacts;
        #[inline(always)]
        fn run<L: Lanes>(self) -> MaskFacts {
            let m = L::mask_from_bits(self.0);
            let mut counted = [u32::MAX; MOST_LANES];
            L::store_u(L::iota(), &mut counted);
            MaskFacts {
                bits: L::mask_bits(m),
                any: L::any(m),
                first: L::mask_bits(L::first(self.1)),
                counted,
            }
        }
    }
    dispatch(lanes, Mask(bits, n))
}

/// See [`mask`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaskFacts {
    /// The mask's bits, one per lane.
    pub bits: u32,
    /// True if any is set.
    pub any: bool,
    /// The bits of the first `n` lanes.
    pub first: u32,
    /// 0, 1, 2, ... in the lanes; the words after the last lane are untouched.
    pub counted: [u32; MOST_LANES],
}

/// Operations on memory, each on the first elements of slices.
#[derive(Clone, Copy, Debug)]
pub struct Memory(pub LaneKind);

impl Memory {
    /// Loads a packet of floats and stores it again.
    pub fn copy(self, from: &[f32], to: &mut [f32]) {
        self.run(Operation::Copy { from, to });
    }

    /// Loads a packet of words and stores it again.
    pub fn copy_words(self, from: &[u32], to: &mut [u32]) {
        self.run(Operation::CopyWords { from, to });
    }

    /// Moves the lanes that the bits name to the front.
    pub fn compress(self, bits: u32, from: &[f32], to: &mut [f32]) {
        self.run(Operation::Compress { bits, from, to });
    }

    /// As [`Memory::compress`], of words.
    pub fn compress_words(self, bits: u32, from: &[u32], to: &mut [u32]) {
        self.run(Operation::CompressWords { bits, from, to });
    }

    /// `to[k] = table[index[k] % table.len()]`, of a table whose length is a power of two.
    pub fn gather(self, table: &[u32], index: &[u32], to: &mut [u32]) {
        self.run(Operation::Gather { table, index, to });
    }

    /// Rows `index` of a table, turned into columns and back.
    pub fn gather_rows(self, table: &[[f32; 8]], index: &[u32], to: &mut [[f32; 8]]) {
        let table: Vec<Row> = table.iter().map(|row| Row(*row)).collect();
        let mut rows: Vec<Row> = to.iter().map(|row| Row(*row)).collect();
        self.run(Operation::GatherRows { table: &table, index, to: &mut rows });
        for (to, row) in to.iter_mut().zip(&rows) {
            *to = row.0;
        }
    }

    /// Consecutive rows as columns, one column after the other.
    pub fn columns(self, rows: &[[f32; 8]]) -> [Vec<f32>; 8] {
        let rows: Vec<Row> = rows.iter().map(|row| Row(*row)).collect();
        let mut to = [[0.0; MOST_LANES]; 8];
        self.run(Operation::Columns { rows: &rows, to: &mut to });
        to.map(|column| column[..count(self.0)].to_vec())
    }

    /// The lane with the smallest value.
    pub fn min_lane(self, from: &[f32]) -> u32 {
        let mut lane = 0;
        self.run(Operation::MinLane { from, lane: &mut lane });
        lane
    }

    /// Compacts a batch as the passes do: moves the lanes that are kept to the front of the same arrays.
    ///
    /// # Panics
    /// If there are more than a batch holds.
    pub fn compact(self, keep: &[bool]) -> Vec<[u32; 4]> {
        assert!(keep.len() <= BATCH);
        let mut paths = Paths::new();
        for k in 0..keep.len() {
            let value = k as u32;
            (paths.origin.x[k], paths.direction.y[k], paths.weight.z[k]) = (k as f32, k as f32, k as f32);
            (paths.leaves[k], paths.stream[k], paths.slot[k]) = (value, value, value);
        }
        let mut kept = 0;
        self.run(Operation::Compact { keep, paths: &mut paths, kept: &mut kept });
        let row = |k: usize| {
            let floats = [paths.origin.x[k], paths.direction.y[k], paths.weight.z[k]];
            assert!(floats.iter().all(|x| *x == floats[0]), "the arrays differ: {floats:?}");
            [floats[0] as u32, paths.leaves[k], paths.stream[k], paths.slot[k]]
        };
        (0..kept).map(row).collect()
    }

    fn run(self, operation: Operation) {
        dispatch(self.0, operation);
    }
}

enum Operation<'a> {
    Copy { from: &'a [f32], to: &'a mut [f32] },
    CopyWords { from: &'a [u32], to: &'a mut [u32] },
    Compress { bits: u32, from: &'a [f32], to: &'a mut [f32] },
    CompressWords { bits: u32, from: &'a [u32], to: &'a mut [u32] },
    Gather { table: &'a [u32], index: &'a [u32], to: &'a mut [u32] },
    GatherRows { table: &'a [Row], index: &'a [u32], to: &'a mut [Row] },
    Columns { rows: &'a [Row], to: &'a mut [[f32; MOST_LANES]; 8] },
    MinLane { from: &'a [f32], lane: &'a mut u32 },
    Compact { keep: &'a [bool], paths: &'a mut Paths, kept: &'a mut usize },
}

impl Kernel for Operation<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        match self {
            Self::Copy { from, to } => L::store(L::load(from), to),
            Self::CopyWords { from, to } => L::store_u(L::load_u(from), to),
            Self::Compress { bits, from, to } => L::compress(L::mask_from_bits(bits), L::load(from), to),
            Self::CompressWords { bits, from, to } => {
                L::compress_u(L::mask_from_bits(bits), L::load_u(from), to);
            }
            Self::Gather { table, index, to } => L::store_u(L::gather_u(table, L::load_u(index)), to),
            Self::GatherRows { table, index, to } => L::transpose(L::gather_rows(table, index), to),
            Self::Columns { rows, to } => {
                let columns = L::load_rows(rows);
                for k in 0..8 {
                    L::store(columns[k], &mut to[k]);
                }
            }
            Self::MinLane { from, lane } => *lane = L::min_lane(L::load(from)),
            Self::Compact { keep, paths, kept } => compact::<L>(keep, paths, kept),
        }
    }
}

#[inline(always)]
fn compact<L: Lanes>(keep: &[bool], paths: &mut Paths, kept: &mut usize) {
    for at in (0..keep.len()).step_by(L::N) {
        let packet: Packet<L> = paths.load(at);
        let mut bits = 0;
        for (lane, keep) in keep[at..].iter().take(L::N).enumerate() {
            bits |= u32::from(*keep) << lane;
        }
        *kept = paths.append(*kept, L::mask_from_bits(bits), &packet);
    }
}
