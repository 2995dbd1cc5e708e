//! Consolidate and develop.

use crate::camera_pass::PixelRows;
use crate::consolidate::{self, consolidate_group};
use crate::dispatch::{Kernel, LaneKind, dispatch};
use crate::join::GROUP;
use crate::join::gather::Sums;
use crate::lanes::{Lanes, Row};
use scene::{Rgb, Settings};

/// What a pixel has gathered over all iterations; as `reference::consolidate::Pixel`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Sum of direct light.
    pub direct: Rgb,
    /// Flux times BRDF within the radius.
    pub tau: Rgb,
    /// `N`.
    pub n: f32,
    /// Squared radius.
    pub radius_squared: f32,
}

/// What an iteration's photons bring to a pixel; as `reference::consolidate::Gathered`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// `M`.
    pub m: u32,
    /// Sums of fluxes.
    pub flux: [u64; 3],
}

/// What an iteration's camera path brings to a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Direct light.
    pub direct: Rgb,
    /// Throughput times BRDF.
    pub beta: Rgb,
}

impl Pixel {
    /// Before the first iteration.
    pub fn new(initial_radius: f32) -> Self {
        Self::of(&consolidate::new_pixel(initial_radius))
    }

    /// Radiance after so many iterations.
    pub fn develop(&self, settings: &Settings, iterations: u32) -> Rgb {
        consolidate::develop(&self.row(), settings, iterations)
    }

    fn of(row: &Row) -> Self {
        let [dr, dg, db, tr, tg, tb, n, radius_squared] = row.0;
        Self { direct: Rgb::new(dr, dg, db), tau: Rgb::new(tr, tg, tb), n, radius_squared }
    }

    fn row(&self) -> Row {
        let (d, t) = (self.direct, self.tau);
        Row([d.x, d.y, d.z, t.x, t.y, t.z, self.n, self.radius_squared])
    }
}

/// Pixels with what an iteration brings to them, laid out as the engine does.
pub struct Consolidation {
    count: usize,
    pixels: Vec<Row>,
    rows: Vec<PixelRows>,
    sums: Vec<Sums>,
}

impl Consolidation {
    /// One of each per pixel; filled up to whole groups by pixels that see and gather nothing.
    pub fn new(pixels: &[Pixel], seen: &[Seen], gathered: &[Gathered]) -> Self {
        let slots = pixels.len().next_multiple_of(GROUP);
        let mut this = Self {
            count: pixels.len(),
            pixels: vec![consolidate::new_pixel(1.0); slots],
            rows: vec![PixelRows::NOTHING; slots],
            sums: vec![Sums::default(); slots / GROUP],
        };
        for (k, ((pixel, seen), gathered)) in pixels.iter().zip(seen).zip(gathered).enumerate() {
            this.pixels[k] = pixel.row();
            let (b, d) = (seen.beta, seen.direct);
            this.rows[k].visible.0[4..7].copy_from_slice(&b.to_array());
            this.rows[k].light.0[3..6].copy_from_slice(&d.to_array());
            let sums = &mut this.sums[k / GROUP];
            sums.m[k % GROUP] = gathered.m;
            for (channel, flux) in gathered.flux.into_iter().enumerate() {
                sums.flux[channel][k % GROUP] = flux;
            }
        }
        this
    }

    /// Consolidates all pixels.
    pub fn run(&mut self, lanes: LaneKind, nominal: f32) {
        dispatch(lanes, ConsolidateAll { this: self, nominal });
    }

    /// The pixels as they stand.
    pub fn pixels(&self) -> Vec<Pixel> {
        self.pixels[..self.count].iter().map(Pixel::of).collect()
    }
}

struct ConsolidateAll<'a> {
    this: &'a mut Consolidation,
    nominal: f32,
}

impl Kernel for ConsolidateAll<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Consolidation { pixels, rows, sums, .. } = self.this;
        for ((pixels, rows), sums) in pixels.chunks_mut(GROUP).zip(rows.chunks(GROUP)).zip(sums.iter()) {
            consolidate_group::<L>(pixels, rows, sums, self.nominal);
        }
    }
}
