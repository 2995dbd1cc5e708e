//! Where paths from the eye begin: the rays through the pixels, and the stratified numbers that choose them.

mod filter;
mod numbers;

use crate::pixels::{TILE, slots};
use crate::sampling::{uniform_disk, unit};
use filter::PixelFilter;
use lanes::{Lanes, V3};
pub(crate) use numbers::{Numbers, TileTable, dimension};
use scene::camera::Frame;
use scene::{Rims, Scene, Settings};

/// What the rays through the pixels depend on: the same for all iterations.
pub(crate) struct Eye {
    pub(crate) tiles: TileTable,
    /// `None` for the box.
    filter: Option<PixelFilter>,
    frame: Frame,
    /// Per tile a bit for each of its slots: set where the rim of a lamp may be seen. Empty if it does not matter.
    rims: Vec<u64>,
    width: u32,
    height: u32,
}

/// The pixels of `L::N` slots.
pub(crate) struct PixelLanes<L: Lanes> {
    /// The slots that are not outside of the image.
    pub(crate) in_image: L::M,
    /// `y * width + x`.
    pub(crate) index: L::U,
    /// Their columns and rows.
    pub(crate) corner: [L::F; 2],
}

/// Rays from the eye.
pub(crate) struct EyeRays<L: Lanes> {
    pub(crate) origin: V3<L>,
    pub(crate) direction: V3<L>,
    /// What each path counts, by the filter.
    pub(crate) weight: L::F,
}

/// What an [`Eye`] takes by its pixels while it is made: two bits for each, if the rims of lamps matter.
pub(crate) fn bytes_at_most(settings: &Settings) -> u64 {
    let words = settings.pixels().div_ceil(64) + slots(settings) / TILE;
    if settings.glint_samples > 1 { 8 * words as u64 } else { 0 }
}

impl Eye {
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let &Settings { width, height, filter, .. } = settings;
        let frame = scene.camera.frame(width, height);
        let (tiles, filter) = (TileTable::new(), PixelFilter::new(filter));
        let mut eye = Self { tiles, filter, frame, rims: Vec::new(), width, height };
        if let Some(rims) = Rims::new(scene, settings) {
            let is_rim = |(x, y): (u32, u32)| x < width && y < height && rims.has(x, y);
            let of_tile = |tile: usize| {
                let bit = |place: usize| u64::from(is_rim(eye.pixel(tile * TILE + place))) << place;
                (0..TILE).map(bit).sum()
            };
            eye.rims = (0..slots(settings) / TILE).map(of_tile).collect();
        }
        eye
    }

    /// True if the filter is not the box, so that paths count more or less than 1.
    pub(crate) fn weighs(&self) -> bool {
        self.filter.is_some()
    }

    /// The pixels from `slot` on, all in one tile.
    #[inline(always)]
    pub(crate) fn pixels<L: Lanes>(&self, slot: usize) -> PixelLanes<L> {
        let corner = self.corner(slot);
        let x = L::load_u(&self.tiles.x[slot % TILE..]) + L::u(corner.0);
        let y = L::load_u(&self.tiles.y[slot % TILE..]) + L::u(corner.1);
        let index = y * L::u(self.width) + x;
        let (x, y) = (L::to_float(x), L::to_float(y));
        let in_image = L::lt(x, L::f(self.width as f32)) & L::lt(y, L::f(self.height as f32));
        PixelLanes { in_image, index, corner: [x, y] }
    }

    /// Column and row of the first pixel of a slot's tile.
    #[inline(always)]
    fn corner(&self, slot: usize) -> (u32, u32) {
        let (tile, tiles_across) = (slot / TILE, self.width.div_ceil(8) as usize);
        ((tile % tiles_across) as u32 * 8, (tile / tiles_across) as u32 * 8)
    }

    /// Column and row of the pixel of a slot.
    pub(crate) fn pixel(&self, slot: usize) -> (u32, u32) {
        let ((x, y), place) = (self.corner(slot), slot % TILE);
        (x + self.tiles.x[place], y + self.tiles.y[place])
    }

    /// Of so many slots from `slot` on, all in one tile: a bit for each, set where the rim of a lamp may be seen.
    pub(crate) fn rims(&self, slot: usize, count: usize) -> u64 {
        self.rims.get(slot / TILE).map_or(0, |tile| tile >> (slot % TILE) & ((1 << count) - 1))
    }

    /// The number of pixel (x, y): the index of its streams.
    pub(crate) fn index(&self, (x, y): (u32, u32)) -> u32 {
        y * self.width + x
    }

    /// True if rays begin on a lens, so that each has a place on it.
    pub(crate) fn has_lens(&self) -> bool {
        self.frame.aperture_radius > 0.0
    }

    /// The rays through the pixels with these columns and rows that two uniform numbers each choose: the place in the pixel, and
    /// on the lens.
    #[inline(always)]
    pub(crate) fn rays<L: Lanes>(
        &self,
        pixels: [L::F; 2],
        in_pixel: [L::F; 2],
        lens: [L::F; 2],
    ) -> EyeRays<L> {
        let (place, weight) = match &self.filter {
            Some(filter) => filter.place::<L>(in_pixel),
            None => (in_pixel, L::f(1.0)),
        };
        let (x, y) = (pixels[0] + place[0], pixels[1] + place[1]);
        let (origin, direction) = ray_through::<L>(&self.frame, x, y, lens);
        EyeRays { origin, direction, weight }
    }
}

/// As `reference::camera_pass::ray_through`.
#[inline(always)]
pub(crate) fn ray_through<L: Lanes>(frame: &Frame, x: L::F, y: L::F, lens: [L::F; 2]) -> (V3<L>, V3<L>) {
    let sx = (x - L::f(frame.half[0])) * L::f(frame.pixel);
    let sy = (L::f(frame.half[1]) - y) * L::f(frame.pixel);
    let (right, up) = (V3::<L>::splat(frame.right), V3::<L>::splat(frame.up));
    let to_image = V3::splat(frame.forward) + right.scale(sx) + up.scale(sy);
    let eye = V3::splat(frame.eye);
    if frame.aperture_radius > 0.0 {
        let aperture = L::f(frame.aperture_radius);
        let (dx, dy) = uniform_disk::<L>(lens[0], lens[1]);
        let offset = right.scale(dx * aperture) + up.scale(dy * aperture);
        return (eye + offset, unit(to_image.scale(L::f(frame.focus_distance)) - offset));
    }
    (eye, unit(to_image))
}
