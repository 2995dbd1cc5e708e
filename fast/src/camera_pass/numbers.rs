//! The stratified numbers of paths from the eye: Sobol points under a digital shift per tile, moved on with the iteration.

use crate::direct_light::ShadowNumbers;
use crate::pixels::TILE;
use crate::sampling::unit_float;
use lanes::Lanes;
use scene::Settings;
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, morton, moved_on, sobol};

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
            *digits = std::array::from_fn(|index| sobol(index as u32, d));
        }
        table
    }
}

/// The stratified numbers of the pixels of some tiles in one iteration.
pub(crate) struct Numbers {
    iteration: u32,
    light_samples: u32,
    /// Per dimension, the digital shifts of the tiles; a power of two of them.
    shifts: [Vec<u32>; DIMENSIONS],
}

/// The digits of a point's dimensions that shadow rays use, before they are moved on.
pub(crate) struct LightDigits<L: Lanes>([L::U; 3]);

impl Numbers {
    pub(crate) fn new() -> Self {
        Self { iteration: 0, light_samples: 1, shifts: [const { Vec::new() }; DIMENSIONS] }
    }

    /// Makes ready for `count` pixels from slot `first` on, the first of a tile.
    pub(crate) fn begin(&mut self, settings: &Settings, iteration: u32, first: usize, count: usize) {
        (self.iteration, self.light_samples) = (iteration, settings.light_samples);
        let key = StreamKey::new(settings.seed, Family::Tile, 0);
        let tiles = count.div_ceil(TILE);
        for shifts in &mut self.shifts {
            shifts.resize(tiles.next_power_of_two(), 0);
        }
        for tile in 0..tiles {
            let mut stream = key.stream((first / TILE + tile) as u32);
            for shifts in &mut self.shifts {
                shifts[tile] = stream.next_u32();
            }
        }
    }

    /// Two dimensions of the pixels of consecutive slots, the first of them `at` slots after the first of all.
    #[inline(always)]
    pub(crate) fn of_packet<L: Lanes>(
        &self,
        tiles: &TileTable,
        dimensions: [usize; 2],
        at: usize,
    ) -> [L::F; 2] {
        dimensions.map(|d| {
            let shift = L::u(self.shifts[d][at / TILE]);
            let digits = L::load_u(&tiles.digits[d][at % TILE..]) ^ shift;
            unit_float::<L>(digits + L::u(moved_on(self.iteration, d)))
        })
    }

    /// Some dimensions of the pixels that are so many slots after the first.
    #[inline(always)]
    pub(crate) fn of_slots<L: Lanes, const N: usize>(
        &self,
        tiles: &TileTable,
        dimensions: [usize; N],
        slots: L::U,
    ) -> [L::F; N] {
        let digits = self.digits::<L, N>(tiles, dimensions, slots);
        let moved = dimensions.map(|d| L::u(moved_on(self.iteration, d)));
        std::array::from_fn(|k| unit_float::<L>(digits[k] + moved[k]))
    }

    #[inline(always)]
    fn digits<L: Lanes, const N: usize>(
        &self,
        tiles: &TileTable,
        dimensions: [usize; N],
        slots: L::U,
    ) -> [L::U; N] {
        const PLACE_BITS: i32 = TILE.trailing_zeros() as i32;
        let tile = L::shr::<PLACE_BITS>(slots);
        // The place within the tile is what `gather_u` leaves of the slot.
        dimensions.map(|d| L::gather_u(&tiles.digits[d], slots) ^ L::gather_u(&self.shifts[d], tile))
    }

    /// What [`Self::light`] needs of the pixels that are so many slots after the first.
    #[inline(always)]
    pub(crate) fn light_digits<L: Lanes>(&self, tiles: &TileTable, slots: L::U) -> LightDigits<L> {
        let [u, v] = dimension::LIGHT_POINT;
        LightDigits(self.digits::<L, 3>(tiles, [dimension::LIGHT, u, v], slots))
    }

    /// The numbers of shadow ray `sample`, as `reference::camera_pass::CameraNumbers::light`.
    #[inline(always)]
    pub(crate) fn light<L: Lanes>(&self, digits: &LightDigits<L>, sample: u32) -> ShadowNumbers<L> {
        let place = self.iteration.wrapping_mul(self.light_samples).wrapping_add(sample);
        let number = |k: usize, d| unit_float::<L>(digits.0[k] + L::u(moved_on(place, d)));
        let [u, v] = dimension::LIGHT_POINT;
        ShadowNumbers { choice: number(0, dimension::LIGHT), u: number(1, u), v: number(2, v) }
    }
}

const _: () = assert!(TILE.is_power_of_two());
