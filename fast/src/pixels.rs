//! Pixels in memory: in tiles of 8x8, along the Z curve within a tile.
//!
//! Neighbours in memory are neighbours in the picture, so they see the same things, and they gather photons in groups
//! ([`GROUP`]).

use crate::pages::Pages;
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3, prefetch};
use scene::film::TILE_SIDE as SIDE;
use scene::ray::{NO_SPHERE, SphereId};
use scene::sobol::morton;
use scene::{Rgb, Settings, Vec3};

/// Pixels of a tile.
pub(crate) const TILE: usize = (SIDE * SIDE) as usize;
/// Pixels of a group, which gather photons together: a block of 4x4.
pub(crate) const GROUP: usize = 16;

/// The number of slots for the pixels of an image: those of whole tiles.
pub(crate) fn slots(settings: &Settings) -> usize {
    settings.width.div_ceil(SIDE) as usize * settings.height.div_ceil(SIDE) as usize * TILE
}

/// The slot of pixel (x, y).
pub(crate) fn slot_of(width: u32, x: u32, y: u32) -> usize {
    let tile = (y / SIDE) as usize * width.div_ceil(SIDE) as usize + (x / SIDE) as usize;
    tile * TILE + morton(x % SIDE, y % SIDE) as usize
}

/// Pixels or rows of pixels in a cache line.
pub(crate) const PER_LINE: usize = 2;

// As they are asked for from memory.
const _: () = assert!(PER_LINE * size_of::<Pixel>() == 64 && PER_LINE * size_of::<PixelRow>() == 64);

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

/// What the camera paths of all pixels have found in this iteration, in tile order.
pub(crate) struct Seen {
    pub(crate) rows: Pages<PixelRow>,
    /// Of each group.
    pub(crate) columns: Pages<GroupColumns>,
}

impl Seen {
    /// For a camera pass to write to, in the memory of `old` if that is of as many pixels. Slots outside of the image have no visible
    /// point, and any columns.
    pub(crate) fn new(old: Option<Self>, settings: &Settings) -> Self {
        let (rows, columns) = old.map(|Self { rows, columns }| (rows, columns)).unzip();
        let slots = slots(settings);
        let rows = if slots == settings.pixels() {
            Pages::reused(rows, slots)
        } else {
            Pages::refilled(rows, PixelRow::NOTHING, slots)
        };
        Self { rows, columns: Pages::reused(columns, slots / GROUP) }
    }

    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.rows[..]) + size_of_val(&self.columns[..])
    }
}

/// What photons are sought by at a pixel: the visible point that its camera path has found in this iteration.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct PixelRow {
    /// The visible point.
    pub(crate) point: [f32; 3],
    /// The sphere that it lies on; [`NO_SPHERE`] if there is no visible point.
    pub(crate) sphere: SphereId,
    /// Throughput times BRDF.
    pub(crate) beta: [f32; 3],
    /// The squared search radius of the iteration.
    pub(crate) radius_squared: f32,
}

impl PixelRow {
    /// A pixel that sees nothing.
    pub(crate) const NOTHING: Self =
        Self { point: [0.0; 3], sphere: NO_SPHERE, beta: [0.0; 3], radius_squared: 0.0 };

    /// The visible point, if there is one.
    #[inline(always)]
    pub(crate) fn visible(&self) -> Option<Vec3> {
        (self.sphere != NO_SPHERE).then_some(Vec3::from_array(self.point))
    }
}

/// [`PixelRow`]s in lanes.
pub(crate) struct PixelRowLanes<L: Lanes> {
    pub(crate) point: V3<L>,
    pub(crate) sphere: L::U,
    pub(crate) beta: V3<L>,
    pub(crate) radius_squared: L::F,
}

impl<L: Lanes> PixelRowLanes<L> {
    /// The first `L::N` pixels.
    #[inline(always)]
    pub(crate) fn load(rows: &[PixelRow]) -> Self {
        let [px, py, pz, sphere, br, bg, bb, radius_squared] = L::load_rows(bytemuck::cast_slice(rows));
        let (point, beta) = (V3::new(px, py, pz), V3::new(br, bg, bb));
        Self { point, sphere: L::bits(sphere), beta, radius_squared }
    }

    /// Writes lane k to the slot `slots[k]`, for the first `count` lanes.
    #[inline(always)]
    pub(crate) fn scatter(&self, slots: &[u32], count: usize, rows: &mut [PixelRow]) {
        let Self { point: p, sphere, beta: b, radius_squared } = self;
        let mut transposed = [Row::default(); MOST_LANES];
        let columns = [p.x, p.y, p.z, L::from_bits(*sphere), b.x, b.y, b.z, *radius_squared];
        L::transpose(columns, &mut transposed);
        let rows: &mut [Row] = bytemuck::cast_slice_mut(rows);
        for (row, slot) in transposed.iter().zip(slots).take(count) {
            rows[*slot as usize] = *row;
        }
    }
}

/// What else the camera paths of a group's pixels have found, in columns. It is read far less often.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct GroupColumns {
    direct: [[f32; GROUP]; 3],
    /// Unit normals on the visible side.
    normal: [[f32; GROUP]; 3],
}

impl GroupColumns {
    /// Asks for direct light before it is read.
    #[inline(always)]
    pub(crate) fn prefetch(groups: &[Self], number: usize) {
        let columns: &[[f32; GROUP]] = bytemuck::cast_slice(groups);
        for column in 0..3 {
            prefetch(columns, 6 * number + column);
        }
    }

    /// Normals of the `L::N` pixels from `at` on.
    #[inline(always)]
    pub(crate) fn normals<L: Lanes>(&self, at: usize) -> V3<L> {
        load_columns(&self.normal, at)
    }

    /// Direct light of the `L::N` pixels from `at` on.
    #[inline(always)]
    pub(crate) fn direct<L: Lanes>(&self, at: usize) -> V3<L> {
        load_columns(&self.direct, at)
    }

    /// The normal of pixel k.
    #[inline(always)]
    pub(crate) fn normal(&self, k: usize) -> Vec3 {
        self.normal.map(|column| column[k]).into()
    }

    /// Direct light of pixel k.
    pub(crate) fn direct_light(&self, k: usize) -> Rgb {
        self.direct.map(|column| column[k]).into()
    }

    /// Sets direct light of pixel k.
    pub(crate) fn set_direct_light(&mut self, k: usize, light: Rgb) {
        for (column, light) in self.direct.iter_mut().zip(light.to_array()) {
            column[k] = light;
        }
    }

    /// Sets the normal of pixel k.
    pub(crate) fn set_normal(&mut self, k: usize, normal: Vec3) {
        for (column, normal) in self.normal.iter_mut().zip(normal.to_array()) {
            column[k] = normal;
        }
    }

    /// Writes lane k to the slot `slots[k]`, for the first `count` lanes.
    #[inline(always)]
    pub(crate) fn scatter<L: Lanes>(
        (normal, direct): (V3<L>, V3<L>),
        slots: &[u32],
        count: usize,
        groups: &mut [Self],
    ) {
        let first = slots[0];
        let is_next = L::eq(L::load_u(slots), L::u(first) + L::iota());
        // As most are where nothing is a mirror or glass.
        if count >= L::N && !L::any(!is_next) && (first as usize).is_multiple_of(L::N) {
            let Self { normal: n, direct: d } = &mut groups[first as usize / GROUP];
            let at = first as usize % GROUP;
            store_columns(normal, n, at);
            store_columns(direct, d, at);
            return;
        }
        let columns = [normal.x, normal.y, normal.z, direct.x, direct.y, direct.z];
        let mut lanes = [[0.0; MOST_LANES]; 6];
        for (lanes, column) in lanes.iter_mut().zip(columns) {
            L::store(column, lanes);
        }
        for (k, slot) in slots.iter().enumerate().take(L::N.min(count)) {
            let Self { normal: n, direct: d } = &mut groups[*slot as usize / GROUP];
            for (column, lanes) in n.iter_mut().chain(d).zip(&lanes) {
                column[*slot as usize % GROUP] = lanes[k];
            }
        }
    }
}

#[inline(always)]
fn load_columns<L: Lanes>([x, y, z]: &[[f32; GROUP]; 3], at: usize) -> V3<L> {
    V3::new(L::load(&x[at..]), L::load(&y[at..]), L::load(&z[at..]))
}

#[inline(always)]
fn store_columns<L: Lanes>(from: V3<L>, [x, y, z]: &mut [[f32; GROUP]; 3], at: usize) {
    L::store(from.x, &mut x[at..]);
    L::store(from.y, &mut y[at..]);
    L::store(from.z, &mut z[at..]);
}
