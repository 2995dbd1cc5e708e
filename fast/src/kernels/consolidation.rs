//! Consolidation and development of pixels.

use crate::consolidate::{self, consolidate_group};
use crate::join::{Flux, GroupSums, RadiiSums};
use crate::pixels::{self, GROUP, GroupColumns, PixelRow};
use bytemuck::Zeroable;
use lanes::{Kernel, LaneKind, Lanes, dispatch};
use scene::film::FluxUnit;
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

/// What a pixel gathers in an iteration: as `reference::consolidate::Gathered`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// `M`.
    pub m: u32,
    /// Sums of fluxes.
    pub flux: [u128; 3],
}

/// What a pixel's camera path finds in an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Direct light.
    pub direct: Rgb,
    /// Throughput times BRDF.
    pub beta: Rgb,
    /// Squared search radius.
    pub radius_squared: f32,
}

impl Pixel {
    /// A pixel before the first iteration.
    pub fn new(initial_radius: f32) -> Self {
        Self::of(&pixels::Pixel::new(initial_radius))
    }

    /// Radiance after so many iterations.
    pub fn develop(&self, settings: &Settings, iterations: u32) -> Rgb {
        consolidate::develop(&self.inner(), settings, iterations)
    }

    fn of(pixel: &pixels::Pixel) -> Self {
        let pixels::Pixel { direct, tau, n, radius_squared } = *pixel;
        Self { direct: direct.into(), tau: tau.into(), n, radius_squared }
    }

    fn inner(&self) -> pixels::Pixel {
        let Self { direct, tau, n, radius_squared } = *self;
        pixels::Pixel { direct: direct.into(), tau: tau.into(), n, radius_squared }
    }
}

/// Pixels and what an iteration brings to them, laid out as in the engine.
pub struct Consolidation {
    count: usize,
    pixels: Vec<pixels::Pixel>,
    rows: Vec<PixelRow>,
    columns: Vec<GroupColumns>,
    sums: Vec<GroupSums>,
}

impl Consolidation {
    /// Takes one of each per pixel, and fills up whole groups with pixels that see and gather nothing.
    pub fn new(pixels: &[Pixel], seen: &[Seen], gathered: &[Gathered]) -> Self {
        let slots = pixels.len().next_multiple_of(GROUP);
        let mut this = Self {
            count: pixels.len(),
            pixels: vec![pixels::Pixel::new(1.0); slots],
            rows: vec![PixelRow::NOTHING; slots],
            columns: vec![GroupColumns::zeroed(); slots / GROUP],
            sums: vec![GroupSums::default(); slots / GROUP],
        };
        for (k, ((pixel, seen), gathered)) in pixels.iter().zip(seen).zip(gathered).enumerate() {
            this.pixels[k] = pixel.inner();
            let row = &mut this.rows[k];
            (row.beta, row.radius_squared) = (seen.beta.into(), seen.radius_squared);
            this.columns[k / GROUP].set_direct_light(k % GROUP, seen.direct);
            let sums = &mut this.sums[k / GROUP];
            sums.m[k % GROUP] = gathered.m;
            if gathered.flux.iter().any(|flux| *flux > u128::from(u64::MAX)) {
                sums.add_heavy(0, Flux { units: [0; 3], shift: 0 });
            }
            for (channel, flux) in gathered.flux.into_iter().enumerate() {
                sums.add_flux(channel, k % GROUP, flux);
            }
        }
        this
    }

    /// Consolidates all pixels.
    pub fn run(&mut self, lanes: LaneKind, unit: FluxUnit) {
        dispatch(lanes, ConsolidateAll { this: self, unit });
    }

    /// The pixels as they are now.
    pub fn pixels(&self) -> Vec<Pixel> {
        self.pixels[..self.count].iter().map(Pixel::of).collect()
    }
}

struct ConsolidateAll<'a> {
    this: &'a mut Consolidation,
    unit: FluxUnit,
}

impl Kernel for ConsolidateAll<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Consolidation { pixels, rows, columns, sums, .. } = self.this;
        let (seen, radii) = (rows.chunks(GROUP).zip(&*columns), &mut RadiiSums::default());
        for ((pixels, seen), sums) in pixels.chunks_mut(GROUP).zip(seen).zip(&*sums) {
            consolidate_group::<L>(pixels, seen, sums, self.unit, radii);
        }
    }
}
