//! Pixels in memory: in tiles of 8x8, along the Z curve within a tile.
//!
//! Neighbours in memory are neighbours in the picture, so they see the same things, and they gather photons in groups
//! ([`GROUP`]).

use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::ray::{NO_SPHERE, SphereId};
use scene::sobol::morton;
use scene::{Rgb, Settings, Vec3};

/// Pixels of a tile.
pub(crate) const TILE: usize = 64;
/// Pixels of a group, which gather photons together: a block of 4x4.
pub(crate) const GROUP: usize = 16;

/// The number of slots for the pixels of an image: those of whole tiles.
pub(crate) fn slots(settings: &Settings) -> usize {
    settings.width.div_ceil(8) as usize * settings.height.div_ceil(8) as usize * TILE
}

/// The slot of pixel (x, y).
pub(crate) fn slot_of(width: u32, x: u32, y: u32) -> usize {
    let tile = (y / 8) as usize * width.div_ceil(8) as usize + (x / 8) as usize;
    tile * TILE + morton(x & 7, y & 7) as usize
}

/// What a pixel has gathered over all iterations: `reference::consolidate::Pixel`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Pixel {
    /// Sum of direct light.
    pub(crate) direct: [f32; 3],
    /// Flux times BRDF within the radius.
    pub(crate) tau: [f32; 3],
    /// Photons counted: `N`.
    pub(crate) n: f32,
    pub(crate) radius_squared: f32,
}

impl Pixel {
    /// A pixel before the first iteration.
    pub(crate) fn new(initial_radius: f32) -> Self {
        Self { radius_squared: initial_radius * initial_radius, ..Self::zeroed() }
    }

    /// The search radius.
    pub(crate) fn radius(&self) -> f32 {
        self.radius_squared.sqrt()
    }

    /// The words that are saved.
    pub(crate) fn words(self) -> [u32; 8] {
        bytemuck::cast(self)
    }

    /// From words that were saved.
    pub(crate) fn from_words(words: [u32; 8]) -> Self {
        bytemuck::cast(words)
    }
}

/// [`Pixel`]s in lanes.
pub(crate) struct PixelLanes<L: Lanes> {
    pub(crate) direct: V3<L>,
    pub(crate) tau: V3<L>,
    pub(crate) n: L::F,
    pub(crate) radius_squared: L::F,
}

impl<L: Lanes> PixelLanes<L> {
    /// The first `L::N` pixels.
    #[inline(always)]
    pub(crate) fn load(pixels: &[Pixel]) -> Self {
        let [dr, dg, db, tr, tg, tb, n, radius_squared] = L::load_rows(bytemuck::cast_slice(pixels));
        Self { direct: V3::new(dr, dg, db), tau: V3::new(tr, tg, tb), n, radius_squared }
    }

    /// Writes the first `L::N` pixels.
    #[inline(always)]
    pub(crate) fn store(self, pixels: &mut [Pixel]) {
        let Self { direct: d, tau: t, n, radius_squared } = self;
        L::transpose([d.x, d.y, d.z, t.x, t.y, t.z, n, radius_squared], bytemuck::cast_slice_mut(pixels));
    }
}

/// What a pixel's camera path has found in this iteration: the visible point and direct light.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct PixelRows {
    /// The visible point.
    pub(crate) point: [f32; 3],
    /// The sphere that it lies on; [`NO_SPHERE`] if there is no visible point.
    pub(crate) sphere: SphereId,
    /// Throughput times BRDF.
    pub(crate) beta: [f32; 3],
    /// The squared search radius of the iteration.
    pub(crate) radius_squared: f32,
    /// Unit normal on the visible side.
    pub(crate) normal: [f32; 3],
    pub(crate) direct: [f32; 3],
    unused: [f32; 2],
}

impl PixelRows {
    /// A pixel that sees nothing.
    pub(crate) const NOTHING: Self = Self {
        point: [0.0; 3],
        sphere: NO_SPHERE,
        beta: [0.0; 3],
        radius_squared: 0.0,
        normal: [0.0; 3],
        direct: [0.0; 3],
        unused: [0.0; 2],
    };

    /// The visible point, if there is one.
    #[inline(always)]
    pub(crate) fn visible(&self) -> Option<Vec3> {
        (self.sphere != NO_SPHERE).then_some(Vec3::from_array(self.point))
    }

    /// Direct light as a colour.
    pub(crate) fn direct_light(&self) -> Rgb {
        self.direct.into()
    }
}

/// The first halves of [`PixelRows`] among rows of lanes' memory.
const FIRST: [u32; MOST_LANES] = evens(0);
/// The second halves.
const SECOND: [u32; MOST_LANES] = evens(1);

/// Every second number.
const fn evens(first: u32) -> [u32; MOST_LANES] {
    let mut numbers = [first; MOST_LANES];
    let mut k = 0;
    while k < MOST_LANES {
        numbers[k] += 2 * k as u32;
        k += 1;
    }
    numbers
}

/// The first halves of [`PixelRows`] in lanes: what photons are sought by.
pub(crate) struct FoundLanes<L: Lanes> {
    pub(crate) point: V3<L>,
    pub(crate) sphere: L::U,
    pub(crate) beta: V3<L>,
    pub(crate) radius_squared: L::F,
}

impl<L: Lanes> FoundLanes<L> {
    /// Those of the first `L::N` pixels.
    #[inline(always)]
    pub(crate) fn load(rows: &[PixelRows]) -> Self {
        let [px, py, pz, sphere, br, bg, bb, radius_squared] =
            L::gather_rows(bytemuck::cast_slice(rows), &FIRST);
        let (point, beta) = (V3::new(px, py, pz), V3::new(br, bg, bb));
        Self { point, sphere: L::bits(sphere), beta, radius_squared }
    }
}

/// The normals of the first `L::N` pixels.
#[inline(always)]
pub(crate) fn normals<L: Lanes>(rows: &[PixelRows]) -> V3<L> {
    let [nx, ny, nz, ..] = L::gather_rows(bytemuck::cast_slice(rows), &SECOND);
    V3::new(nx, ny, nz)
}

/// [`PixelRows`] in lanes.
pub(crate) struct PixelRowsLanes<L: Lanes> {
    pub(crate) point: V3<L>,
    pub(crate) sphere: L::U,
    pub(crate) beta: V3<L>,
    pub(crate) radius_squared: L::F,
    pub(crate) normal: V3<L>,
    pub(crate) direct: V3<L>,
}

impl<L: Lanes> PixelRowsLanes<L> {
    /// The first `L::N` pixels.
    #[inline(always)]
    pub(crate) fn load(rows: &[PixelRows]) -> Self {
        let FoundLanes { point, sphere, beta, radius_squared } = FoundLanes::load(rows);
        let [nx, ny, nz, dr, dg, db, ..] = L::gather_rows(bytemuck::cast_slice(rows), &SECOND);
        let (normal, direct) = (V3::new(nx, ny, nz), V3::new(dr, dg, db));
        Self { point, sphere, beta, radius_squared, normal, direct }
    }

    /// Writes lane k to the slot `slots[k]`, for the first `count` lanes.
    #[inline(always)]
    pub(crate) fn scatter(&self, slots: &[u32], count: usize, rows: &mut [PixelRows]) {
        let Self { point: p, sphere, beta: b, radius_squared, normal: n, direct: d } = self;
        let zero = L::f(0.0);
        let mut transposed = [[Row::default(); MOST_LANES]; 2];
        L::transpose(
            [p.x, p.y, p.z, L::from_bits(*sphere), b.x, b.y, b.z, *radius_squared],
            &mut transposed[0],
        );
        L::transpose([n.x, n.y, n.z, d.x, d.y, d.z, zero, zero], &mut transposed[1]);
        // By halves: a copy of both at once would wait until the halves are in memory.
        let rows: &mut [Row] = bytemuck::cast_slice_mut(rows);
        for (lane, slot) in slots.iter().enumerate().take(count) {
            rows[2 * *slot as usize] = transposed[0][lane];
            rows[2 * *slot as usize + 1] = transposed[1][lane];
        }
    }
}
