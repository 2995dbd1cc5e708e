//! The random streams and stratified points of the reference, for one path per lane.

use lanes::MOST_LANES;
use scene::Settings;
use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::{DIMENSIONS, morton, moved_on, sobol};

/// The numbers of the current paths.
pub(crate) struct Keyed {
    seed: u64,
    width: u32,
    pixels: u32,
    /// The iteration of camera paths; 0 for photons, which get new digital shifts in each iteration.
    moves: u32,
    index: [u32; MOST_LANES],
    shifts: [[u32; DIMENSIONS]; MOST_LANES],
    streams: [Stream; MOST_LANES],
    values: [f32; MOST_LANES],
}

impl Keyed {
    pub(super) fn new(settings: &Settings) -> Self {
        let stream = StreamKey::new(settings.seed, Family::Camera, 0).stream(0);
        Self {
            seed: settings.seed,
            width: settings.width,
            pixels: settings.pixels() as u32,
            moves: 0,
            index: [0; MOST_LANES],
            shifts: [[0; DIMENSIONS]; MOST_LANES],
            streams: [stream; MOST_LANES],
            values: [0.0; MOST_LANES],
        }
    }

    pub(super) fn begin_camera_paths(&mut self, iteration: u32, at: usize, lanes: usize) {
        self.moves = iteration;
        let tiles = StreamKey::new(self.seed, Family::Tile, 0);
        let key = StreamKey::new(self.seed, Family::Camera, iteration);
        for lane in 0..lanes {
            // Lanes past the last pixel repeat it; their results are ignored.
            let pixel = (at as u32 + lane as u32).min(self.pixels - 1);
            let (x, y) = (pixel % self.width, pixel / self.width);
            let mut tile = tiles.stream((y / 8) * self.width.div_ceil(8) + x / 8);
            self.index[lane] = morton(x & 7, y & 7);
            self.shifts[lane] = std::array::from_fn(|_| tile.next_u32());
            self.streams[lane] = key.stream(pixel);
        }
    }

    pub(super) fn begin_photon_paths(&mut self, iteration: u32, at: u32, lanes: usize) {
        self.moves = 0;
        let mut emission = StreamKey::new(self.seed, Family::Emission, iteration).stream(0);
        let shifts = std::array::from_fn(|_| emission.next_u32());
        let key = StreamKey::new(self.seed, Family::Photon, iteration);
        for lane in 0..lanes {
            self.index[lane] = at + lane as u32;
            self.shifts[lane] = shifts;
            self.streams[lane] = key.stream(at + lane as u32);
        }
    }

    pub(super) fn stratified(&mut self, dimension: usize, lanes: usize) -> &[f32; MOST_LANES] {
        for lane in 0..lanes {
            let shifted = sobol(self.index[lane], dimension) ^ self.shifts[lane][dimension];
            self.values[lane] = unit_float(shifted.wrapping_add(moved_on(self.moves, dimension)));
        }
        &self.values
    }

    pub(super) fn next(&mut self, lanes: usize) -> &[f32; MOST_LANES] {
        for lane in 0..lanes {
            self.values[lane] = self.streams[lane].next_f32();
        }
        &self.values
    }
}
