//! Camera pass: `reference::camera_pass` over batches of pixels.
//!
//! ```text
//! for each batch of 256 pixels (four tiles of 8x8):
//!     make the rays
//!     until none is left, at most max_depth times:
//!         intersect all; shade all: paths that end go to a list, others to the front of the batch
//!     direct light for all on the list, in full packets
//!     write two rows per pixel
//! ```
//!
//! Pixels are kept in tile order, along the Z curve within a tile: neighbours in memory are neighbours in the
//! picture, so they see the same things, and gather photons together ([`crate::join`]).

use crate::direct_light::{LightTable, Receivers, ShadowNumbers, ShadowRays};
use crate::hierarchy::Scratch;
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::paths::{BATCH, Floats, Packet, Paths, ROOM, Vectors, Words};
use crate::sampling::{next_uniform, stream_state, uniform_disk, unit, unit_float};
use crate::scatter::{dielectric, reflect};
use crate::tables::{Materials, Surface, Tables, kind, tag};
use crate::trace::{hits, intersect_batch};
use crate::vec3::V3;
use bytemuck::{Pod, Zeroable};
use scene::camera::Frame;
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::sobol::{DIMENSIONS, morton, moved_on, sobol};
use scene::{Settings, Still, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Pixels of a tile.
pub(crate) const TILE: usize = 64;

/// How the dimensions of a pixel's stratified point are used; as in `reference::camera_pass`.
mod dimension {
    pub(super) const PIXEL: [usize; 2] = [0, 1];
    pub(super) const LIGHT_POINT: [usize; 2] = [2, 3];
    pub(super) const LIGHT: usize = 4;
    pub(super) const LENS: [usize; 2] = [5, 6];
    /// Those before are drawn for all pixels, these where a path meets glass.
    pub(super) const LOBES: [usize; 4] = [7, 8, 9, 10];
}

/// A pixel's visible point and direct light of this iteration.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PixelRows {
    /// Words: point x y z, sphere ([`NO_SPHERE`] if there is no visible point), beta r g b, unused.
    pub(crate) visible: Row,
    /// Words: normal x y z, direct light r g b, unused.
    pub(crate) light: Row,
}

impl PixelRows {
    /// A pixel that sees nothing.
    pub(crate) const NOTHING: Self = Self {
        visible: Row([0.0, 0.0, 0.0, f32::from_bits(NO_SPHERE), 0.0, 0.0, 0.0, 0.0]),
        light: Row([0.0; 8]),
    };
}

/// The Sobol digits of the pixels of a tile, and where these lie in it; the same for all tiles and iterations.
pub(crate) struct TileTable {
    digits: [[u32; TILE]; DIMENSIONS],
    x: [u32; TILE],
    y: [u32; TILE],
}

impl TileTable {
    pub(crate) fn new() -> Self {
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

/// How many slots there are for the pixels of an image: whole tiles.
pub(crate) fn slots(settings: &Settings) -> usize {
    settings.width.div_ceil(8) as usize * settings.height.div_ceil(8) as usize * TILE
}

/// The slot of pixel (x, y).
pub(crate) fn slot_of(width: u32, x: u32, y: u32) -> usize {
    let tile = (y / 8) as usize * width.div_ceil(8) as usize + (x / 8) as usize;
    tile * TILE + morton(x & 7, y & 7) as usize
}

/// What the camera pass of one iteration reads.
pub(crate) struct CameraPass<'a> {
    pub(crate) still: &'a Still<'a>,
    pub(crate) tables: &'a Tables,
    pub(crate) lights: &'a LightTable,
    pub(crate) tiles: &'a TileTable,
    pub(crate) frame: Frame,
    pub(crate) settings: &'a Settings,
    pub(crate) iteration: u32,
}

/// Counted work of a batch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CameraCounts {
    pub(crate) segments: u64,
    pub(crate) visible_points: u64,
}

/// Buffers of one batch.
pub(crate) struct CameraBatch {
    paths: Box<Paths>,
    scratch: Scratch,
    shadows: Box<ShadowRays>,
    ended: Box<Ended>,
    direct: Box<Vectors>,
    /// The digital shifts of the batch's tiles.
    shifts: [[u32; DIMENSIONS]; BATCH / TILE],
    numbers: Box<Numbers>,
}

/// The stratified numbers of all pixels of a batch, but for those at glass.
type Numbers = [Floats; dimension::LOBES[0]];

/// The paths that have ended, in any order.
#[derive(Clone)]
struct Ended {
    point: Vectors,
    normal: Vectors,
    beta: Vectors,
    sphere: Words,
    slot: Words,
    count: usize,
}

impl CameraBatch {
    pub(crate) fn new() -> Self {
        let (vectors, words) = (Vectors::ZERO, [0; ROOM]);
        let (point, normal, beta) = (vectors.clone(), vectors.clone(), vectors.clone());
        Self {
            paths: Paths::new(),
            scratch: Scratch::new(),
            shadows: Box::new(ShadowRays::new()),
            ended: Box::new(Ended { point, normal, beta, sphere: words, slot: words, count: 0 }),
            direct: Box::new(vectors),
            shifts: [[0; DIMENSIONS]; BATCH / TILE],
            numbers: Box::new([[0.0; ROOM]; dimension::LOBES[0]]),
        }
    }
}

impl CameraPass<'_> {
    /// Renders the pixels of the slots from `first` on; `rows` holds one entry per slot, at most [`BATCH`].
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(
        &self,
        batch: &mut CameraBatch,
        first: usize,
        rows: &mut [PixelRows],
    ) -> CameraCounts {
        let mut counts = CameraCounts::default();
        batch.ended.count = 0;
        self.draw_numbers::<L>(batch, first, rows.len());
        let mut live = self.make_rays::<L>(batch, first, rows.len());
        for segment in 0..self.settings.max_depth {
            if live == 0 {
                break;
            }
            counts.segments += live as u64;
            intersect_batch::<L>(self.tables, &mut batch.paths, &mut batch.scratch, live);
            live = self.shade::<L>(batch, live, segment);
        }
        end_the_rest::<L>(batch, live);
        if !self.lights.is_empty() {
            self.light::<L>(batch);
        }
        counts.visible_points = self.write::<L>(batch, rows);
        counts
    }

    /// The stratified numbers of all pixels: Sobol points under the digital shifts of their tiles, moved on.
    #[inline(always)]
    fn draw_numbers<L: Lanes>(&self, batch: &mut CameraBatch, first: usize, count: usize) {
        let key = StreamKey::new(self.settings.seed, Family::Tile, 0);
        for start in (0..count).step_by(TILE) {
            let mut stream = key.stream(((first + start) / TILE) as u32);
            let shifts = std::array::from_fn(|_| stream.next_u32());
            batch.shifts[start / TILE] = shifts;
            for (d, numbers) in batch.numbers.iter_mut().enumerate() {
                let (shift, moved) = (L::u(shifts[d]), L::u(moved_on(self.iteration, d)));
                for at in (0..TILE).step_by(L::N) {
                    let word = (L::load_u(&self.tiles.digits[d][at..]) ^ shift) + moved;
                    L::store(unit_float::<L>(word), &mut numbers[start + at..]);
                }
            }
        }
    }

    /// As `reference::camera_pass::CameraNumbers::lobe`; where none of `needed` is set, anything.
    #[inline(always)]
    fn lobe<L: Lanes>(
        &self,
        shifts: &[[u32; DIMENSIONS]; BATCH / TILE],
        p: &mut Packet<L>,
        segment: u32,
        needed: L::M,
    ) -> L::F {
        let Some(&d) = dimension::LOBES.get(segment as usize) else {
            return next_uniform::<L>(&mut p.stream);
        };
        if !L::any(needed) {
            return L::f(0.0);
        }
        let (mut slots, mut words) = ([0; MOST_LANES], [0; MOST_LANES]);
        L::store_u(p.slot, &mut slots);
        for (word, slot) in words.iter_mut().zip(slots).take(L::N) {
            let (tile, place) = (slot as usize / TILE % shifts.len(), slot as usize % TILE);
            *word = self.tiles.digits[d][place] ^ shifts[tile][d];
        }
        unit_float::<L>(L::load_u(&words) + L::u(moved_on(self.iteration, d)))
    }

    /// The camera rays of the batch, without those of slots that lie outside of the image; gives their number.
    #[inline(always)]
    fn make_rays<L: Lanes>(&self, batch: &mut CameraBatch, first: usize, count: usize) -> usize {
        let Settings { width, height, seed, .. } = *self.settings;
        let key = StreamKey::new(seed, Family::Camera, self.iteration);
        let tiles_across = width.div_ceil(8) as usize;
        let mut live = 0;
        for at in (0..count).step_by(L::N) {
            let tile = (first + at) / TILE;
            let corner = ((tile % tiles_across) as u32 * 8, (tile / tiles_across) as u32 * 8);
            let x = L::load_u(&self.tiles.x[at % TILE..]) + L::u(corner.0);
            let y = L::load_u(&self.tiles.y[at % TILE..]) + L::u(corner.1);
            let (xf, yf) = (L::to_float(x), L::to_float(y));
            let in_image = L::lt(xf, L::f(width as f32)) & L::lt(yf, L::f(height as f32));
            let numbers = &batch.numbers;
            let place = pair::<L>(numbers, dimension::PIXEL, at);
            let lens = pair::<L>(numbers, dimension::LENS, at);
            let (origin, direction) = ray_through::<L>(&self.frame, xf + place[0], yf + place[1], lens);
            let packet = Packet {
                origin,
                direction,
                weight: V3::splat(Vec3::ONE),
                leaves: L::u(NO_SPHERE),
                stream: stream_state::<L>(key, y * L::u(width) + x),
                slot: L::u(at as u32) + L::iota(),
            };
            live = batch.paths.append(live, in_image, &packet);
            batch.direct.store(at, V3::<L>::splat(Vec3::ZERO));
        }
        live
    }

    /// One bounce of the first `live` paths; gives the number of those that go on.
    #[inline(always)]
    fn shade<L: Lanes>(&self, batch: &mut CameraBatch, live: usize, segment: u32) -> usize {
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let here = L::first(live - at);
            let mut p = batch.paths.load::<L>(at);
            let (t, hit, arrived) = hits::<L>(&batch.paths, at, here);
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Surface::<L>::at(self.tables, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::of(self.tables, surface.tag);
            let glows = arrived & L::eq(surface.tag & L::u(tag::EMITTER), L::u(tag::EMITTER));
            if L::any(glows) {
                self.add_emission::<L>(batch, glows, &p, &ids);
            }
            let is_glass = arrived & L::eq(material.kind, L::u(kind::DIELECTRIC));
            let lobe = self.lobe::<L>(&batch.shifts, &mut p, segment, is_glass);
            p.weight = p.weight * material.albedo;
            let is_diffuse = arrived & L::eq(material.kind, L::u(kind::DIFFUSE));
            let ends = here & (!arrived | is_diffuse);
            batch.ended.append(ends, is_diffuse, &surface, hit, &p);
            let is_smooth = arrived & !is_diffuse;
            if L::any(is_smooth) {
                let mirrored = reflect(p.direction, surface.normal);
                let (through, scale) =
                    dielectric(p.direction, surface.normal, surface.inside, material.ior, lobe);
                p.weight = p.weight.scale(L::select(is_glass, scale, L::f(1.0)));
                p.direction = V3::select(is_glass, through, mirrored);
                p.origin = surface.point;
                p.leaves = hit;
                go_on = batch.paths.append(go_on, is_smooth, &p);
            }
        }
        go_on
    }

    /// Lamps seen are rare: lane by lane.
    #[inline(always)]
    fn add_emission<L: Lanes>(&self, batch: &mut CameraBatch, glows: L::M, p: &Packet<L>, ids: &[u32]) {
        let (mut slots, mut weights) = ([0; MOST_LANES], [[0.0; MOST_LANES]; 3]);
        L::store_u(p.slot, &mut slots);
        L::store(p.weight.x, &mut weights[0]);
        L::store(p.weight.y, &mut weights[1]);
        L::store(p.weight.z, &mut weights[2]);
        let mut rest = L::mask_bits(glows);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let emission = self.still.spheres[ids[lane] as usize].emission;
            let weight = Vec3::new(weights[0][lane], weights[1][lane], weights[2][lane]);
            batch.direct.add(slots[lane] as usize, weight * emission);
        }
    }

    /// Direct light on all visible points.
    #[inline(always)]
    fn light<L: Lanes>(&self, batch: &mut CameraBatch) {
        let CameraBatch { ended, shadows, scratch, numbers, .. } = batch;
        for at in (0..ended.count).step_by(L::N) {
            let slots = &ended.slot[at..at + L::N];
            let [u, v] = dimension::LIGHT_POINT;
            let numbers = ShadowNumbers {
                choice: gather::<L>(&numbers[dimension::LIGHT], slots),
                u: gather::<L>(&numbers[u], slots),
                v: gather::<L>(&numbers[v], slots),
            };
            let sphere = L::load_u(&ended.sphere[at..]);
            let receivers = Receivers {
                live: L::first(ended.count - at) & !L::eq(sphere, L::u(NO_SPHERE)),
                point: ended.point.load::<L>(at),
                normal: ended.normal.load::<L>(at),
                sphere,
            };
            shadows.aim(at, self.tables, self.lights, &receivers, &numbers);
        }
        shadows.follow::<L>(self.tables, &ended.point, &ended.sphere, scratch, ended.count);
    }

    /// The rows of all pixels; gives the number of visible points.
    #[inline(always)]
    fn write<L: Lanes>(&self, batch: &CameraBatch, rows: &mut [PixelRows]) -> u64 {
        let ended = &batch.ended;
        let mut visible_points = 0;
        for at in (0..ended.count).step_by(L::N) {
            let beta: V3<L> = ended.beta.load(at);
            let (point, normal) = (ended.point.load::<L>(at), ended.normal.load::<L>(at));
            let sphere = L::load_u(&ended.sphere[at..]);
            let slots = &ended.slot[at..at + L::N];
            let is_visible = L::first(ended.count - at) & !L::eq(sphere, L::u(NO_SPHERE));
            visible_points += u64::from(L::mask_bits(is_visible).count_ones());
            let mut direct = batch.direct.gather::<L>(slots);
            if !self.lights.is_empty() {
                let e = batch.shadows.irradiance(at);
                direct = V3::select(is_visible, direct + beta * e, direct);
            }
            let zero = L::f(0.0);
            let visible = [point.x, point.y, point.z, L::from_bits(sphere), beta.x, beta.y, beta.z, zero];
            let light = [normal.x, normal.y, normal.z, direct.x, direct.y, direct.z, zero, zero];
            let mut transposed = [[Row::default(); MOST_LANES]; 2];
            L::transpose(visible, &mut transposed[0]);
            L::transpose(light, &mut transposed[1]);
            for (lane, slot) in slots.iter().enumerate().take(ended.count - at) {
                rows[*slot as usize] = PixelRows { visible: transposed[0][lane], light: transposed[1][lane] };
            }
        }
        visible_points
    }
}

impl Ended {
    /// Takes the lanes `ends`, of which `is_diffuse` may have a visible point.
    #[inline(always)]
    fn append<L: Lanes>(
        &mut self,
        ends: L::M,
        is_diffuse: L::M,
        surface: &Surface<L>,
        hit: L::U,
        p: &Packet<L>,
    ) {
        let zero = V3::splat(Vec3::ZERO);
        let beta = p.weight.scale(L::f(FRAC_1_PI));
        let brightest = beta.max_component();
        let is_visible = is_diffuse & L::lt(L::f(0.0), brightest);
        let at = self.count;
        self.point.compress(ends, surface.point, at);
        self.normal.compress(ends, surface.normal, at);
        self.beta.compress(ends, V3::select(is_visible, beta, zero), at);
        L::compress_u(ends, L::select_u(is_visible, hit, L::u(NO_SPHERE)), &mut self.sphere[at..]);
        L::compress_u(ends, p.slot, &mut self.slot[at..]);
        self.count += L::mask_bits(ends).count_ones() as usize;
    }
}

/// Paths cut off at the maximal depth have no visible point.
#[inline(always)]
fn end_the_rest<L: Lanes>(batch: &mut CameraBatch, live: usize) {
    let nowhere = V3::splat(Vec3::ZERO);
    let surface =
        Surface::<L> { point: nowhere, normal: nowhere, inside: L::first(0), scale: L::f(0.0), tag: L::u(0) };
    for at in (0..live).step_by(L::N) {
        let p = batch.paths.load::<L>(at);
        batch.ended.append(L::first(live - at), L::first(0), &surface, L::u(NO_SPHERE), &p);
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

/// Two of the stratified numbers of the pixels from `at` on.
#[inline(always)]
fn pair<L: Lanes>(numbers: &Numbers, [a, b]: [usize; 2], at: usize) -> [L::F; 2] {
    [L::load(&numbers[a][at..]), L::load(&numbers[b][at..])]
}

/// Lane k of the result is `from[index[k]]`.
#[inline(always)]
fn gather<L: Lanes>(from: &Floats, index: &[u32]) -> L::F {
    let mut values = [0.0; MOST_LANES];
    for (value, i) in values.iter_mut().zip(index).take(L::N) {
        *value = from[*i as usize];
    }
    L::load(&values)
}

impl Vectors {
    #[inline(always)]
    fn gather<L: Lanes>(&self, index: &[u32]) -> V3<L> {
        V3::new(gather::<L>(&self.x, index), gather::<L>(&self.y, index), gather::<L>(&self.z, index))
    }

    #[inline(always)]
    fn add(&mut self, at: usize, v: Vec3) {
        self.x[at] += v.x;
        self.y[at] += v.y;
        self.z[at] += v.z;
    }
}

const _: () = assert!(BATCH.is_multiple_of(TILE));
