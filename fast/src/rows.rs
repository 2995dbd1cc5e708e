//! Rows of tables, as lanes fetch them.

use lanes::{Lanes, Row};

/// The rows with these numbers as eight columns, as [`Lanes::gather_rows`].
///
/// Where rays run close together all lanes mostly ask for the same row, which is broadcast: a tenth of the instructions of a
/// fetch, for three more where they do not.
#[inline(always)]
pub(crate) fn gather<L: Lanes>(table: &[Row], index: &[u32]) -> [L::F; 8] {
    let first = index[0];
    if L::any(!L::eq(L::load_u(index), L::u(first))) {
        return L::gather_rows(table, index);
    }
    let Row([a, b, c, d, e, f, g, h]) = table[first as usize];
    [L::f(a), L::f(b), L::f(c), L::f(d), L::f(e), L::f(f), L::f(g), L::f(h)]
}
