//! The bins of the hash grid: linked lists (stage 0), generic growable arrays (stage 1) and typed ones (from stage 2).
//!
//! The cells of a point are entered one after the other. So if two of them share a bin, the point is already the bin's
//! last entry at the second one, and is not entered again. (The published program enters it again and counts it twice.)

use super::tuning::Tuning;
use lanes::{Lanes, MOST_LANES};

/// The bins of a table.
pub(crate) trait Bins {
    /// The entries of a bin that are still to be read.
    type Cursor<'a>
    where
        Self: 'a;
    /// A number of empty bins, for a number of points.
    fn new(bins: usize, points: usize, tuning: &Tuning) -> Self;
    /// Empties all bins.
    fn clear(&mut self);
    /// Appends a point, with the sphere that it lies on, to a bin, unless it is the last entry there.
    fn insert(&mut self, bin: usize, point: u32, sphere: u32);
    /// Begins reading a bin.
    fn open(&self, bin: usize) -> Self::Cursor<'_>;
    /// As `Index::next`.
    fn next<L: Lanes>(cursor: &mut Self::Cursor<'_>) -> Option<(L::U, L::M)>;
    /// As `Index::shared_sphere`.
    #[inline(always)]
    fn shared_sphere(_: &Self::Cursor<'_>) -> Option<u32> {
        None
    }
    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// Stage 0: a linked list per bin. The nodes are allocated one by one, and anew for each iteration. As in the published
/// program, appending a node walks to the end of the list.
pub(crate) struct LinkedBins {
    heads: Vec<Link>,
    nodes: usize,
}

type Link = Option<Box<Node>>;

/// A node of a list.
pub(crate) struct Node {
    point: u32,
    next: Link,
}

impl Bins for LinkedBins {
    type Cursor<'a> = Option<&'a Node>;

    fn new(bins: usize, _: usize, _: &Tuning) -> Self {
        let mut heads = Vec::new();
        heads.resize_with(bins, || None);
        Self { heads, nodes: 0 }
    }

    fn clear(&mut self) {
        let bins = self.heads.len();
        *self = Self::new(bins, 0, &Tuning::PAPER);
    }

    #[inline(always)]
    fn insert(&mut self, bin: usize, point: u32, _: u32) {
        let mut link = &mut self.heads[bin];
        let mut last = None;
        while let Some(node) = link {
            last = Some(node.point);
            link = &mut node.next;
        }
        if last != Some(point) {
            *link = Some(Box::new(Node { point, next: None }));
            self.nodes += 1;
        }
    }

    #[inline(always)]
    fn open(&self, bin: usize) -> Option<&Node> {
        self.heads[bin].as_deref()
    }

    #[inline(always)]
    fn next<L: Lanes>(cursor: &mut Option<&Node>) -> Option<(L::U, L::M)> {
        let node = (*cursor)?;
        *cursor = node.next.as_deref();
        Some((L::load_u(std::slice::from_ref(&node.point)), L::first(1)))
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.heads[..]) + self.nodes * size_of::<Node>()
    }
}

impl Drop for LinkedBins {
    /// Drops node by node. Dropping a list as a whole would recurse once per node.
    fn drop(&mut self) {
        for head in &mut self.heads {
            let mut link = head.take();
            while let Some(mut node) = link {
                link = node.next.take();
            }
        }
    }
}

/// A growable array of items of one size chosen at run time. Items are copied as bytes by functions that are not
/// inlined.
struct ByteArray {
    data: Vec<u8>,
    item_size: usize,
}

impl ByteArray {
    #[inline(never)]
    fn add(&mut self, item: &[u8]) {
        self.data.extend_from_slice(item);
    }
    #[inline(never)]
    fn get(&self, index: usize) -> &[u8] {
        &self.data[index * self.item_size..(index + 1) * self.item_size]
    }
    fn len(&self) -> usize {
        self.data.len() / self.item_size
    }
}

/// Stage 1: a generic array per bin, kept over iterations.
pub(crate) struct ByteBins(Vec<ByteArray>);

/// The entry of a point: its index, as wide as the pointer that the published program stores.
type Item = u64;

#[inline(always)]
fn item(bytes: &[u8]) -> Item {
    Item::from_ne_bytes(bytes.try_into().unwrap_or_default())
}

impl Bins for ByteBins {
    type Cursor<'a> = ByteCursor<'a>;

    fn new(bins: usize, _: usize, tuning: &Tuning) -> Self {
        let item_size = size_of::<Item>();
        let array = || ByteArray { data: Vec::with_capacity(item_size * tuning.first_capacity), item_size };
        Self((0..bins).map(|_| array()).collect())
    }

    fn clear(&mut self) {
        for array in &mut self.0 {
            array.data.clear();
        }
    }

    #[inline(always)]
    fn insert(&mut self, bin: usize, point: u32, _: u32) {
        let array = &mut self.0[bin];
        let len = array.len();
        if len == 0 || item(array.get(len - 1)) != u64::from(point) {
            array.add(&u64::from(point).to_ne_bytes());
        }
    }

    #[inline(always)]
    fn open(&self, bin: usize) -> ByteCursor<'_> {
        ByteCursor { array: &self.0[bin], next: 0 }
    }

    #[inline(always)]
    fn next<L: Lanes>(cursor: &mut ByteCursor<'_>) -> Option<(L::U, L::M)> {
        if cursor.next == cursor.array.len() {
            return None;
        }
        let point = item(cursor.array.get(cursor.next)) as u32;
        cursor.next += 1;
        Some((L::load_u(&[point]), L::first(1)))
    }

    fn bytes(&self) -> usize {
        let data: usize = self.0.iter().map(|array| array.data.capacity()).sum();
        size_of_val(&self.0[..]) + data
    }
}

/// The items of a generic array that are still to be read.
pub(crate) struct ByteCursor<'a> {
    array: &'a ByteArray,
    next: usize,
}

/// From stage 2 on: a typed array per bin, kept over iterations.
pub(crate) struct TypedBins(Vec<Vec<u32>>);

/// The next indices of a slice, one per lane.
#[inline(always)]
pub(super) fn next_of_slice<L: Lanes>(rest: &mut &[u32]) -> Option<(L::U, L::M)> {
    if rest.len() >= L::N {
        let (now, later) = rest.split_at(L::N);
        *rest = later;
        return Some((L::load_u(now), L::first(L::N)));
    }
    if rest.is_empty() {
        return None;
    }
    // Lanes without a candidate repeat the first one, so that they too read a valid visible point.
    let mut last = [rest[0]; MOST_LANES];
    for (place, point) in last.iter_mut().zip(*rest) {
        *place = *point;
    }
    let live = L::first(rest.len());
    *rest = &[];
    Some((L::load_u(&last), live))
}

impl TypedBins {
    /// The points in a bin.
    #[inline(always)]
    pub(super) fn points(&self, bin: usize) -> &[u32] {
        &self.0[bin]
    }
}

impl Bins for TypedBins {
    type Cursor<'a> = &'a [u32];

    fn new(bins: usize, _: usize, tuning: &Tuning) -> Self {
        Self((0..bins).map(|_| Vec::with_capacity(tuning.first_capacity)).collect())
    }

    fn clear(&mut self) {
        for points in &mut self.0 {
            points.clear();
        }
    }

    #[inline(always)]
    fn insert(&mut self, bin: usize, point: u32, _: u32) {
        let points = &mut self.0[bin];
        if points.last() != Some(&point) {
            points.push(point);
        }
    }

    #[inline(always)]
    fn open(&self, bin: usize) -> &[u32] {
        self.points(bin)
    }

    #[inline(always)]
    fn next<L: Lanes>(cursor: &mut &[u32]) -> Option<(L::U, L::M)> {
        next_of_slice::<L>(cursor)
    }

    fn bytes(&self) -> usize {
        let points: usize = self.0.iter().map(|points| points.capacity() * size_of::<u32>()).sum();
        size_of_val(&self.0[..]) + points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one::One;

    /// What is found in a bin.
    fn points<B: Bins>(bins: &B, bin: usize) -> Vec<u32> {
        let (mut cursor, mut points) = (bins.open(bin), Vec::new());
        while let Some((point, is_one)) = B::next::<One>(&mut cursor) {
            assert!(is_one);
            points.push(point.0);
        }
        points
    }

    fn check<B: Bins>() {
        let mut bins = B::new(3, 9, &Tuning::PAPER);
        for point in [4, 4, 7, 8, 8, 4] {
            bins.insert(1, point, 0);
        }
        bins.insert(2, 5, 0);
        assert_eq!([0, 1, 2].map(|bin| points(&bins, bin)), [vec![], vec![4, 7, 8, 4], vec![5]]);
        bins.clear();
        assert!([0, 1, 2].iter().all(|bin| points(&bins, *bin).is_empty()));
    }

    /// A point that comes twice in a row has cells that share the bin.
    #[test]
    fn bins_hold_points_in_order_and_none_twice_in_a_row() {
        check::<LinkedBins>();
        check::<ByteBins>();
        check::<TypedBins>();
    }

    /// Arrays have room for as many entries as they are asked for before there are any; lists have none.
    #[test]
    fn bins_tell_all_that_they_hold() {
        let tuning = Tuning { first_capacity: 5, ..Tuning::PAPER };
        assert_eq!(TypedBins::new(4, 9, &tuning).bytes(), 4 * (size_of::<Vec<u32>>() + 5 * 4));
        assert_eq!(ByteBins::new(4, 9, &tuning).bytes(), 4 * (size_of::<ByteArray>() + 5 * 8));
        let mut linked = LinkedBins::new(4, 9, &tuning);
        let empty = 4 * size_of::<Link>();
        assert_eq!(linked.bytes(), empty);
        for (bin, point) in [(0, 1), (0, 2), (0, 2), (3, 1)] {
            linked.insert(bin, point, 0);
        }
        assert_eq!(linked.bytes(), empty + 3 * size_of::<Node>());
        linked.clear();
        assert_eq!(linked.bytes(), empty);
    }
}
