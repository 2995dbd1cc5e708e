//! Lanes that count operations: every operation is forwarded to other lanes and added to counters of this thread.
//!
//! Operations of whole vectors are counted, so a masked lane counts like any other. Bytes are those of loads, stores
//! and gathers of pixels, visible points, bins and tables. Constants, scene values broadcast to all lanes, and
//! registers that the compiler spills are not counted.
//!
//! Nobody times these lanes, and their operations are calls: inlined, they would take half of the crate's time to build.

use lanes::{Lanes, Row};
use serde::Serialize;
use std::cell::Cell;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Counted operations, lane by lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Operations {
    /// Additions and subtractions of floats.
    pub additions: u64,
    /// Multiplications of floats.
    pub multiplications: u64,
    /// Divisions of floats.
    pub divisions: u64,
    /// Square roots.
    pub square_roots: u64,
    /// Comparisons, minima and maxima of floats.
    pub comparisons: u64,
    /// Bytes loaded or gathered.
    pub bytes_loaded: u64,
    /// Bytes stored or scattered.
    pub bytes_stored: u64,
}

impl Operations {
    /// Floating-point operations: additions, multiplications, divisions and square roots, each counted as one.
    pub fn flops(&self) -> u64 {
        self.additions + self.multiplications + self.divisions + self.square_roots
    }

    /// Bytes moved in either direction.
    pub fn bytes(&self) -> u64 {
        self.bytes_loaded + self.bytes_stored
    }
}

impl std::ops::AddAssign for Operations {
    fn add_assign(&mut self, other: Self) {
        self.additions += other.additions;
        self.multiplications += other.multiplications;
        self.divisions += other.divisions;
        self.square_roots += other.square_roots;
        self.comparisons += other.comparisons;
        self.bytes_loaded += other.bytes_loaded;
        self.bytes_stored += other.bytes_stored;
    }
}

thread_local! {
    static ACCOUNT: Account = const { Account::new() };
}

/// The kinds of operations, as indices of the counters.
#[derive(Clone, Copy)]
enum Kind {
    Addition,
    Multiplication,
    Division,
    SquareRoot,
    Comparison,
    Load,
    Store,
}

struct Account([Cell<u64>; 7]);

impl Account {
    const fn new() -> Self {
        Self([const { Cell::new(0) }; 7])
    }
}

#[inline(never)]
fn count(kind: Kind, number: usize) {
    ACCOUNT.with(|account| {
        let place = &account.0[kind as usize];
        place.set(place.get() + number as u64);
    });
}

/// Returns this thread's counts since the last call, and resets them.
pub(crate) fn take() -> Operations {
    let take = |kind: Kind| ACCOUNT.with(|account| account.0[kind as usize].take());
    Operations {
        additions: take(Kind::Addition),
        multiplications: take(Kind::Multiplication),
        divisions: take(Kind::Division),
        square_roots: take(Kind::SquareRoot),
        comparisons: take(Kind::Comparison),
        bytes_loaded: take(Kind::Load),
        bytes_stored: take(Kind::Store),
    }
}

/// The lanes `L` with counted operations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Counted<L>(std::marker::PhantomData<L>);

/// `f32` lanes.
#[derive(Clone, Copy)]
pub(crate) struct Floats<L: Lanes>(L::F);
/// `u32` lanes.
#[derive(Clone, Copy)]
pub(crate) struct Words<L: Lanes>(L::U);
/// Truth values.
#[derive(Clone, Copy)]
pub(crate) struct Masks<L: Lanes>(L::M);

macro_rules! operators {
    ($($on:ident $op:ident $method:ident $(as $kind:ident)?;)*) => {$(
        impl<L: Lanes> $op for $on<L> {
            type Output = Self;
            #[inline(never)]
            fn $method(self, other: Self) -> Self {
                $(count(Kind::$kind, L::N);)?
                Self(self.0.$method(other.0))
            }
        }
    )*};
}

operators! {
    Floats Add add as Addition;
    Floats Sub sub as Addition;
    Floats Mul mul as Multiplication;
    Floats Div div as Division;
    Words Add add;
    Words Mul mul;
    Words BitAnd bitand;
    Words BitOr bitor;
    Words BitXor bitxor;
    Masks BitAnd bitand;
    Masks BitOr bitor;
}

impl<L: Lanes> Neg for Floats<L> {
    type Output = Self;
    #[inline(never)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<L: Lanes> Not for Masks<L> {
    type Output = Self;
    #[inline(never)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Bytes of a word in every lane.
#[inline(never)]
const fn words<L: Lanes>(number: usize) -> usize {
    4 * L::N * number
}

#[inline(never)]
fn wrap<L: Lanes>(columns: [L::F; 8]) -> [Floats<L>; 8] {
    let [a, b, c, d, e, f, g, h] = columns;
    [Floats(a), Floats(b), Floats(c), Floats(d), Floats(e), Floats(f), Floats(g), Floats(h)]
}

impl<L: Lanes> Lanes for Counted<L> {
    const N: usize = L::N;
    type Eight = L::Eight;
    type Pair = Self;
    type F = Floats<L>;
    type U = Words<L>;
    type M = Masks<L>;

    #[inline(never)]
    fn f(x: f32) -> Floats<L> {
        Floats(L::f(x))
    }
    #[inline(never)]
    fn load(from: &[f32]) -> Floats<L> {
        count(Kind::Load, words::<L>(1));
        Floats(L::load(from))
    }
    #[inline(never)]
    fn store(v: Floats<L>, to: &mut [f32]) {
        count(Kind::Store, words::<L>(1));
        L::store(v.0, to);
    }
    #[inline(never)]
    fn sqrt(v: Floats<L>) -> Floats<L> {
        count(Kind::SquareRoot, L::N);
        Floats(L::sqrt(v.0))
    }
    #[inline(never)]
    fn abs(v: Floats<L>) -> Floats<L> {
        Floats(L::abs(v.0))
    }
    #[inline(never)]
    fn max(a: Floats<L>, b: Floats<L>) -> Floats<L> {
        count(Kind::Comparison, L::N);
        Floats(L::max(a.0, b.0))
    }
    #[inline(never)]
    fn min(a: Floats<L>, b: Floats<L>) -> Floats<L> {
        count(Kind::Comparison, L::N);
        Floats(L::min(a.0, b.0))
    }
    #[inline(never)]
    fn min_lane(v: Floats<L>) -> u32 {
        count(Kind::Comparison, L::N);
        L::min_lane(v.0)
    }
    #[inline(never)]
    fn fused(a: Floats<L>, b: Floats<L>, c: Floats<L>) -> Floats<L> {
        count(Kind::Addition, L::N);
        count(Kind::Multiplication, L::N);
        Floats(L::fused(a.0, b.0, c.0))
    }
    #[inline(never)]
    fn floor(v: Floats<L>) -> Floats<L> {
        Floats(L::floor(v.0))
    }
    #[inline(never)]
    fn lt(a: Floats<L>, b: Floats<L>) -> Masks<L> {
        count(Kind::Comparison, L::N);
        Masks(L::lt(a.0, b.0))
    }
    #[inline(never)]
    fn le(a: Floats<L>, b: Floats<L>) -> Masks<L> {
        count(Kind::Comparison, L::N);
        Masks(L::le(a.0, b.0))
    }
    #[inline(never)]
    fn truncate(v: Floats<L>) -> Words<L> {
        Words(L::truncate(v.0))
    }
    #[inline(never)]
    fn to_float(v: Words<L>) -> Floats<L> {
        Floats(L::to_float(v.0))
    }
    #[inline(never)]
    fn bits(v: Floats<L>) -> Words<L> {
        Words(L::bits(v.0))
    }
    #[inline(never)]
    fn from_bits(v: Words<L>) -> Floats<L> {
        Floats(L::from_bits(v.0))
    }
    #[inline(never)]
    fn select(m: Masks<L>, a: Floats<L>, b: Floats<L>) -> Floats<L> {
        Floats(L::select(m.0, a.0, b.0))
    }
    #[inline(never)]
    fn u(x: u32) -> Words<L> {
        Words(L::u(x))
    }
    #[inline(never)]
    fn load_u(from: &[u32]) -> Words<L> {
        count(Kind::Load, words::<L>(1));
        Words(L::load_u(from))
    }
    #[inline(never)]
    fn store_u(v: Words<L>, to: &mut [u32]) {
        count(Kind::Store, words::<L>(1));
        L::store_u(v.0, to);
    }
    #[inline(never)]
    fn shl<const K: i32>(v: Words<L>) -> Words<L> {
        Words(L::shl::<K>(v.0))
    }
    #[inline(never)]
    fn shr<const K: i32>(v: Words<L>) -> Words<L> {
        Words(L::shr::<K>(v.0))
    }
    #[inline(never)]
    fn shr_by(v: Words<L>, by: Words<L>) -> Words<L> {
        Words(L::shr_by(v.0, by.0))
    }
    #[inline(never)]
    fn eq(a: Words<L>, b: Words<L>) -> Masks<L> {
        Masks(L::eq(a.0, b.0))
    }
    #[inline(never)]
    fn add_where(m: Masks<L>, a: Words<L>, b: Words<L>) -> Words<L> {
        Words(L::add_where(m.0, a.0, b.0))
    }
    #[inline(never)]
    fn min_u(a: Words<L>, b: Words<L>) -> Words<L> {
        Words(L::min_u(a.0, b.0))
    }
    #[inline(never)]
    fn select_u(m: Masks<L>, a: Words<L>, b: Words<L>) -> Words<L> {
        Words(L::select_u(m.0, a.0, b.0))
    }
    #[inline(never)]
    fn mask_bits(m: Masks<L>) -> u32 {
        L::mask_bits(m.0)
    }
    #[inline(never)]
    fn mask_from_bits(bits: u32) -> Masks<L> {
        Masks(L::mask_from_bits(bits))
    }
    #[inline(never)]
    fn gather_u(table: &[u32], index: Words<L>) -> Words<L> {
        count(Kind::Load, words::<L>(1));
        Words(L::gather_u(table, index.0))
    }
    #[inline(never)]
    fn gather_rows(table: &[Row], index: &[u32]) -> [Floats<L>; 8] {
        count(Kind::Load, words::<L>(8));
        wrap(L::gather_rows(table, index))
    }
    #[inline(never)]
    fn transpose(columns: [Floats<L>; 8], to: &mut [Row]) {
        count(Kind::Store, words::<L>(8));
        let [a, b, c, d, e, f, g, h] = columns;
        L::transpose([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0], to);
    }
    #[inline(never)]
    fn load_rows(rows: &[Row]) -> [Floats<L>; 8] {
        count(Kind::Load, words::<L>(8));
        wrap(L::load_rows(rows))
    }
    #[inline(never)]
    fn compress(m: Masks<L>, v: Floats<L>, to: &mut [f32]) {
        count(Kind::Store, words::<L>(1));
        L::compress(m.0, v.0, to);
    }
    #[inline(never)]
    fn compress_u(m: Masks<L>, v: Words<L>, to: &mut [u32]) {
        count(Kind::Store, words::<L>(1));
        L::compress_u(m.0, v.0, to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one::One;
    use lanes::{Emulated, MOST_LANES};

    /// Expects what `run` counts to be `expected`.
    fn assert_counts(what: &str, expected: Operations, mut run: impl FnMut()) {
        take();
        run();
        assert_eq!(take(), expected, "{what}");
        assert_eq!(take(), Operations::default(), "{what} is told once");
    }

    /// Operations on whole vectors, of the lanes `L`.
    fn check<L: Lanes>() {
        let (n, none) = (L::N as u64, Operations::default());
        let (a, b) = (Counted::<L>::f(2.0), Counted::<L>::f(3.0));
        let (word, other, mask) = (Counted::<L>::u(1), Counted::<L>::u(2), Counted::<L>::first(1));
        let (sum, product) = (Operations { additions: n, ..none }, Operations { multiplications: n, ..none });
        assert_counts("a sum", sum, || _ = a + b);
        assert_counts("a difference", sum, || _ = a - b);
        assert_counts("a product", product, || _ = a * b);
        assert_counts("a quotient", Operations { divisions: n, ..none }, || _ = a / b);
        assert_counts("a root", Operations { square_roots: n, ..none }, || _ = Counted::<L>::sqrt(a));
        let both = Operations { multiplications: n, ..sum };
        assert_counts("a sum and a product", both, || _ = Counted::<L>::fused(a, b, a));
        let comparison = Operations { comparisons: n, ..none };
        assert_counts("less", comparison, || _ = Counted::<L>::lt(a, b));
        assert_counts("less or equal", comparison, || _ = Counted::<L>::le(a, b));
        assert_counts("a minimum", comparison, || _ = Counted::<L>::min(a, b));
        assert_counts("a maximum", comparison, || _ = Counted::<L>::max(a, b));
        assert_counts("the least lane", comparison, || _ = Counted::<L>::min_lane(a));
        // What moves and changes bits is no arithmetic of floats.
        assert_counts("bits", none, || {
            _ = (-a, Counted::<L>::abs(a), Counted::<L>::select(mask, a, b), word + other, word ^ other);
        });

        let (mut floats, mut words) = ([0.0; MOST_LANES], [0; MOST_LANES]);
        let mut rows = [Row::default(); MOST_LANES];
        let loaded = |words: u64| Operations { bytes_loaded: 4 * n * words, ..none };
        assert_counts("floats read", loaded(1), || _ = Counted::<L>::load(&floats));
        assert_counts("words read", loaded(1), || _ = Counted::<L>::load_u(&words));
        assert_counts("words gathered", loaded(1), || _ = Counted::<L>::gather_u(&words, word));
        assert_counts("rows gathered", loaded(8), || _ = Counted::<L>::gather_rows(&rows, &words));
        assert_counts("rows read", loaded(8), || _ = Counted::<L>::load_rows(&rows));
        let stored = |words: u64| Operations { bytes_stored: 4 * n * words, ..none };
        assert_counts("floats written", stored(1), || Counted::<L>::store(a, &mut floats));
        assert_counts("words written", stored(1), || Counted::<L>::store_u(word, &mut words));
        assert_counts("rows written", stored(8), || Counted::<L>::transpose([a; 8], &mut rows));
        assert_counts("lanes of floats", stored(1), || Counted::<L>::compress(mask, a, &mut floats));
        assert_counts("lanes of words", stored(1), || Counted::<L>::compress_u(mask, word, &mut words));
    }

    #[test]
    fn every_operation_counts_once_in_each_lane_as_what_it_is() {
        check::<One>();
        check::<Emulated>();
    }

    #[test]
    fn operations_add_up_kind_by_kind() {
        let of = |unit: u64| Operations {
            additions: unit,
            multiplications: 2 * unit,
            divisions: 4 * unit,
            square_roots: 8 * unit,
            comparisons: 16 * unit,
            bytes_loaded: 32 * unit,
            bytes_stored: 64 * unit,
        };
        let mut sum = of(1);
        sum += of(2);
        assert_eq!(sum, of(3));
        // A comparison is no floating-point operation.
        assert_eq!((sum.flops(), sum.bytes()), (3 * 15, 3 * 96));
    }
}
