//! The stratified numbers of paths from the eye: Sobol points under a digital shift per tile, moved on with the iteration.

use crate::direct_light::ShadowNumbers;
use crate::pixels::TILE;
use crate::sampling::unit_float;
use lanes::{Lanes, MOST_LANES};
use scene::Settings;
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, low_digits, morton, moved_on};

/// What the dimensions of a pixel's stratified point are used for; as in `reference::camera_pass`.
pub(crate) mod dimension {
    pub(crate) const PIXEL: [usize; 2] = [0, 1];
    pub(super) const LIGHT_POINT: [usize; 2] = [2, 3];
    pub(super) const LIGHT: usize = 4;
    pub(crate) const LENS: [usize; 2] = [5, 6];
    pub(crate) const LOBES: [usize; 4] = [7, 8, 9, 10];
}

/// The Sobol digits of the pixels of a tile, and their coordinates within it: the same for all tiles and iterations.
pub(crate) struct TileTable {
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
            *digits = low_digits(d);
        }
        table
    }
}

/// The stratified numbers of the pixels of some tiles in one iteration.
pub(crate) struct Numbers {
    iteration: u32,
    light_samples: u32,
    /// The digital shifts of each tile.
    shifts: Vec<[u32; DIMENSIONS]>,
}

/// The digits of a point's dimensions that shadow rays use, before they are moved on.
pub(crate) struct LightDigits<L: Lanes>([L::U; 3]);

impl Numbers {
    pub(crate) fn new() -> Self {
        Self { iteration: 0, light_samples: 1, shifts: Vec::new() }
    }

    /// Makes ready for `count` pixels from slot `first` on, the first of a tile.
    pub(crate) fn begin(&mut self, settings: &Settings, iteration: u32, first: usize, count: usize) {
        (self.iteration, self.light_samples) = (iteration, settings.light_samples);
        let key = StreamKey::new(settings.seed, Family::Tile, 0);
        self.shifts.clear();
        self.shifts.extend((0..count.div_ceil(TILE)).map(|tile| {
            let mut stream = key.stream((first / TILE + tile) as u32);
            [(); DIMENSIONS].map(|()| stream.next_u32())
        }));
    }

    /// Two dimensions of the pixels of consecutive slots, the first of them `at` slots after the first of all.
    #[inline(always)]
    pub(crate) fn of_packet<L: Lanes>(&self, tiles: &TileTable, [a, b]: [usize; 2], at: usize) -> [L::F; 2] {
        [self.one_of_packet::<L>(tiles, a, at), self.one_of_packet::<L>(tiles, b, at)]
    }

    #[inline(always)]
    fn one_of_packet<L: Lanes>(&self, tiles: &TileTable, d: usize, at: usize) -> L::F {
        let digits = L::load_u(&tiles.digits[d][at % TILE..]) ^ L::u(self.shifts[at / TILE][d]);
        unit_float::<L>(digits + L::u(moved_on(self.iteration, d)))
    }

    /// Some dimensions of the pixels that are so many slots after the first, where `m` is true; elsewhere anything.
    #[inline(always)]
    pub(crate) fn of_slots<L: Lanes, const N: usize>(
        &self,
        tiles: &TileTable,
        dimensions: [usize; N],
        (m, slots): (L::M, L::U),
    ) -> [L::F; N] {
        let digits = self.digits::<L, N>(tiles, dimensions, (m, slots));
        let mut numbers = [L::f(0.0); N];
        for k in 0..N {
            numbers[k] = unit_float::<L>(digits[k] + L::u(moved_on(self.iteration, dimensions[k])));
        }
        numbers
    }

    /// The digits of some dimensions, before they are moved on. Of consecutive pixels, as most are where nothing is a mirror or glass,
    /// they are loaded. Others are fetched lane by lane: few lanes need them at a time, and a gather takes as long for one lane as
    /// for all.
    #[inline(always)]
    fn digits<L: Lanes, const N: usize>(
        &self,
        tiles: &TileTable,
        dimensions: [usize; N],
        (m, slots): (L::M, L::U),
    ) -> [L::U; N] {
        let (mut at, mut digits) = ([0; MOST_LANES], [[0; MOST_LANES]; N]);
        let mut words = [L::u(0); N];
        L::store_u(slots, &mut at);
        let mut rest = L::mask_bits(m);
        let is_next = L::eq(slots, L::u(at[0]) + L::iota());
        let (tile, place) = (at[0] as usize / TILE, at[0] as usize % TILE);
        if rest & 1 == 1 && !L::any(m & !is_next) && place + L::N <= TILE {
            for k in 0..N {
                let d = dimensions[k];
                words[k] = L::load_u(&tiles.digits[d][place..]) ^ L::u(self.shifts[tile][d]);
            }
            return words;
        }
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let (tile, place) = (at[lane] as usize / TILE, at[lane] as usize % TILE);
            for (digits, d) in digits.iter_mut().zip(dimensions) {
                digits[lane] = tiles.digits[d][place] ^ self.shifts[tile][d];
            }
        }
        // Not `map`, whose call would pass vectors through memory.
        for k in 0..N {
            words[k] = L::load_u(&digits[k]);
        }
        words
    }

    /// What [`Self::light`] needs of the pixels that are so many slots after the first, where `m` is true.
    #[inline(always)]
    pub(crate) fn light_digits<L: Lanes>(&self, tiles: &TileTable, m: L::M, slots: L::U) -> LightDigits<L> {
        let [u, v] = dimension::LIGHT_POINT;
        LightDigits(self.digits::<L, 3>(tiles, [dimension::LIGHT, u, v], (m, slots)))
    }

    /// The numbers of shadow ray `sample`, as `reference::camera_pass::CameraNumbers::light`.
    #[inline(always)]
    pub(crate) fn light<L: Lanes>(&self, digits: &LightDigits<L>, sample: u32) -> ShadowNumbers<L> {
        let place = self.iteration.wrapping_mul(self.light_samples).wrapping_add(sample);
        let [u, v] = dimension::LIGHT_POINT;
        let moved = [dimension::LIGHT, u, v].map(|d| moved_on(place, d));
        let LightDigits([choice, u, v]) = *digits;
        ShadowNumbers {
            choice: unit_float::<L>(choice + L::u(moved[0])),
            u: unit_float::<L>(u + L::u(moved[1])),
            v: unit_float::<L>(v + L::u(moved[2])),
        }
    }
}
