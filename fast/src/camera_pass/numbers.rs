//! The stratified numbers of camera paths: Sobol points under a digital shift per tile, moved on with the iteration.

use crate::paths::{BATCH, Floats, ROOM};
use crate::pixels::TILE;
use crate::sampling::unit_float;
use lanes::{Lanes, MOST_LANES};
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, morton, moved_on, sobol};

/// What the dimensions of a pixel's stratified point are used for; as in `reference::camera_pass`.
pub(super) mod dimension {
    pub(crate) const PIXEL: [usize; 2] = [0, 1];
    pub(crate) const LIGHT_POINT: [usize; 2] = [2, 3];
    pub(crate) const LIGHT: usize = 4;
    pub(crate) const LENS: [usize; 2] = [5, 6];
    /// The dimensions above are drawn for all pixels, these only where a path meets glass.
    pub(crate) const LOBES: [usize; 4] = [7, 8, 9, 10];
}

/// The Sobol digits of the pixels of a tile, and their coordinates within it: the same for all tiles and iterations.
pub(super) struct TileTable {
    digits: [[u32; TILE]; DIMENSIONS],
    pub(super) x: [u32; TILE],
    pub(super) y: [u32; TILE],
}

impl TileTable {
    pub(super) fn new() -> Self {
        let mut table = Self { digits: [[0; TILE]; DIMENSIONS], x: [0; TILE], y: [0; TILE] };
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            let place = morton(x, y) as usize;
            (table.x[place], table.y[place]) = (x, y);
        }
        for (d, digits) in table.digits.iter_mut().enumerate() {
            *digits = std::array::from_fn(|index| sobol(index as u32, d));
        }
        table
    }
}

/// The stratified numbers of a batch.
pub(super) struct Numbers {
    /// The digital shifts of the batch's tiles.
    shifts: [[u32; DIMENSIONS]; BATCH / TILE],
    /// Per dimension before [`dimension::LOBES`], the numbers of all pixels.
    drawn: Box<[Floats; dimension::LOBES[0]]>,
}

impl Numbers {
    pub(super) fn new() -> Self {
        let drawn = Box::new([[0.0; ROOM]; dimension::LOBES[0]]);
        Self { shifts: [[0; DIMENSIONS]; BATCH / TILE], drawn }
    }

    /// Draws the numbers of `count` pixels from slot `first` on.
    #[inline(always)]
    pub(super) fn draw<L: Lanes>(
        &mut self,
        tiles: &TileTable,
        (seed, iteration): (u64, u32),
        first: usize,
        count: usize,
    ) {
        let key = StreamKey::new(seed, Family::Tile, 0);
        for start in (0..count).step_by(TILE) {
            let mut stream = key.stream(((first + start) / TILE) as u32);
            let shifts = std::array::from_fn(|_| stream.next_u32());
            self.shifts[start / TILE] = shifts;
            for (d, numbers) in self.drawn.iter_mut().enumerate() {
                let (shift, moved) = (L::u(shifts[d]), L::u(moved_on(iteration, d)));
                for at in (0..TILE).step_by(L::N) {
                    let word = (L::load_u(&tiles.digits[d][at..]) ^ shift) + moved;
                    L::store(unit_float::<L>(word), &mut numbers[start + at..]);
                }
            }
        }
    }

    /// Dimension `d` of the pixels from `at` on.
    #[inline(always)]
    pub(super) fn load<L: Lanes>(&self, d: usize, at: usize) -> L::F {
        L::load(&self.drawn[d][at..])
    }

    /// Two dimensions of the pixels from `at` on.
    #[inline(always)]
    pub(super) fn load_pair<L: Lanes>(&self, [a, b]: [usize; 2], at: usize) -> [L::F; 2] {
        [self.load::<L>(a, at), self.load::<L>(b, at)]
    }

    /// Dimension `d` of the pixels with these slots.
    #[inline(always)]
    pub(super) fn gather<L: Lanes>(&self, d: usize, slots: &[u32]) -> L::F {
        gather::<L>(&self.drawn[d], slots)
    }

    /// Dimension `d` of the pixels with these slots, computed here and now.
    #[inline(always)]
    pub(super) fn compute<L: Lanes>(&self, tiles: &TileTable, iteration: u32, d: usize, slots: L::U) -> L::F {
        let (mut at, mut words) = ([0; MOST_LANES], [0; MOST_LANES]);
        L::store_u(slots, &mut at);
        for (word, slot) in words.iter_mut().zip(at).take(L::N) {
            let (tile, place) = (slot as usize / TILE % self.shifts.len(), slot as usize % TILE);
            *word = tiles.digits[d][place] ^ self.shifts[tile][d];
        }
        unit_float::<L>(L::load_u(&words) + L::u(moved_on(iteration, d)))
    }
}

/// Lane k of the result is `from[index[k]]`.
#[inline(always)]
pub(super) fn gather<L: Lanes>(from: &Floats, index: &[u32]) -> L::F {
    let mut values = [0.0; MOST_LANES];
    for (value, i) in values.iter_mut().zip(index).take(L::N) {
        *value = from[*i as usize];
    }
    L::load(&values)
}

const _: () = assert!(BATCH.is_multiple_of(TILE));
