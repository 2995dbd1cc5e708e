//! Lamps that pixels see directly or in a mirror or glass: `reference::glints`, over batches of rays.
//!
//! ```text
//! before the paths of a batch of pixels run, list the pixels in which the rims of lamps may be seen
//! while they run:
//!     keep the light of lamps that the paths of listed pixels meet apart, until they meet a diffuse surface
//!     list those that first meet a mirror or glass
//! when they have ended, for each batch of further rays through the pixels listed:
//!     make the rays
//!     until no ray is left, at most max_depth times:
//!         intersect all; add the light of lamps; those that meet mirrors and glass to the front of the batch
//!     add what each brings to its pixel, in order
//! divide by the number of rays that count; if none does, what the own path brings stays
//! ```
//!
//! How it differs from the plain loop, and why:
//!
//! 1. Stages over a batch: see [`crate::paths`]. The rays of a pixel are neighbours, so packets meet the same spheres.
//! 2. Each ray adds up its light by itself, and then the pixel adds those: sums are rounded as in the reference.

use crate::eye::{Eye, EyeRays};
use crate::hierarchy::SearchBuffers;
use crate::material::{Materials, kind};
use crate::paths::{BATCH, Floats, Packet, Paths, ROOM, Vectors, Words};
use crate::sampling::{next_uniform, next_where};
use crate::scatter::{dielectric_by_roots, follow};
use crate::surface::{Hit, tag};
use crate::tables::Tables;
use crate::trace::{each_emission, hits, intersect_batch};
use lanes::{Kernel, Lanes, MOST_LANES, V3};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::{Settings, Still, Vec3};

/// What the further rays of an iteration read.
#[derive(Clone, Copy)]
pub(crate) struct GlintPass<'a> {
    pub(crate) still: &'a Still<'a>,
    pub(crate) tables: &'a Tables,
    pub(crate) eye: &'a Eye,
    pub(crate) settings: &'a Settings,
    pub(crate) iteration: u32,
}

/// What the pixels of a batch see of lamps in mirrors and glass.
pub(crate) struct Glints {
    slots: Vec<Slot>,
    /// The slots of pixels that send further rays.
    listed: Vec<u32>,
    rays: Box<GlintRays>,
}

/// What a pixel sees.
#[derive(Clone, Copy, Default)]
struct Slot {
    /// The light that its own path brings, and at last the mean.
    light: Vec3,
    /// True if it is listed.
    is_listed: bool,
    /// True if it was listed because the rim of a lamp may be seen: all its rays count.
    is_rim: bool,
}

/// What a pixel that sends further rays takes: its slot, its place in the list, and its sum.
#[cfg(test)]
pub(crate) const BYTES_PER_PIXEL: u64 =
    (size_of::<Slot>() + size_of::<u32>() + size_of::<(Vec3, u32)>()) as u64;

/// Further rays, a batch of them.
#[derive(Clone)]
struct GlintRays {
    /// Columns and rows of their pixels.
    corner: [Floats; 2],
    /// Their random streams, at the start.
    stream: Words,
    /// What each brings.
    light: Vectors,
    /// 1 for those that count, else 0.
    counts: Words,
}

impl Glints {
    pub(crate) fn new() -> Self {
        let rays = GlintRays {
            corner: [[0.0; ROOM]; 2],
            stream: [0; ROOM],
            light: Vectors::ZERO,
            counts: [0; ROOM],
        };
        Self { slots: Vec::new(), listed: Vec::new(), rays: Box::new(rays) }
    }

    /// Makes ready for so many slots.
    pub(crate) fn begin(&mut self, slots: usize) {
        self.slots.clear();
        self.slots.resize(slots, Slot::default());
        self.listed.clear();
    }

    /// Lists those of the slots from `slot` on whose bit is set: the rim of a lamp may be seen in their pixels.
    pub(crate) fn list_rims(&mut self, slot: usize, mut bits: u64) {
        while bits != 0 {
            let slot = slot + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            self.slots[slot] = Slot { is_listed: true, is_rim: true, ..Slot::default() };
            self.listed.push(slot as u32);
        }
    }

    /// Lists the slots of lanes whose own path first meets a mirror or glass.
    #[inline(always)]
    pub(crate) fn list<L: Lanes>(&mut self, m: L::M, slot: L::U) {
        let mut slots = [0; MOST_LANES];
        L::compress_u(m, slot, &mut slots);
        for slot in &slots[..L::mask_bits(m).count_ones() as usize] {
            let is_listed = &mut self.slots[*slot as usize].is_listed;
            if !std::mem::replace(is_listed, true) {
                self.listed.push(*slot);
            }
        }
    }

    /// What the own path of a slot brings so far, if that is kept apart.
    #[inline(always)]
    pub(crate) fn of(&mut self, slot: usize) -> Option<&mut Vec3> {
        self.slots.get_mut(slot).filter(|slot| slot.is_listed).map(|slot| &mut slot.light)
    }

    /// Multiplies what the own paths of all slots bring by these weights.
    pub(crate) fn weigh(&mut self, weights: &[f32]) {
        self.slots.iter_mut().zip(weights).for_each(|(slot, weight)| slot.light *= *weight);
    }

    /// The slots listed, and the means of what they see.
    pub(crate) fn means(&self) -> impl Iterator<Item = (usize, Vec3)> {
        self.listed.iter().map(|slot| (*slot as usize, self.slots[*slot as usize].light))
    }

    /// The means of the slots of a packet.
    #[inline(always)]
    pub(crate) fn gather<L: Lanes>(&self, slots: &[u32]) -> V3<L> {
        let mut light = [[0.0; MOST_LANES]; 3];
        for (lane, slot) in slots.iter().enumerate().take(L::N) {
            let Vec3 { x, y, z } = self.slots[*slot as usize].light;
            [light[0][lane], light[1][lane], light[2][lane]] = [x, y, z];
        }
        V3::new(L::load(&light[0]), L::load(&light[1]), L::load(&light[2]))
    }
}

impl GlintPass<'_> {
    /// True if pixels see lamps by further rays.
    #[inline(always)]
    pub(crate) fn is_needed(&self) -> bool {
        self.settings.glint_samples > 1 && self.still.has_lamps()
    }

    /// Sends the further rays through the pixels listed, the first of whose slots is `first`; returns the number of segments
    /// traced.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(
        &self,
        glints: &mut Glints,
        paths: &mut Paths,
        search: &mut SearchBuffers,
        first: usize,
    ) -> u64 {
        if glints.listed.is_empty() {
            return 0;
        }
        L::call(FurtherRays { pass: *self, glints, paths, search, first })
    }

    /// The keys of the streams of the further rays of one pixel.
    fn keys(&self) -> Vec<StreamKey> {
        let rays = self.settings.glint_samples;
        let number = |ray| self.iteration.wrapping_mul(rays).wrapping_add(ray);
        (0..rays).map(|ray| StreamKey::new(self.settings.seed, Family::Glint, number(ray))).collect()
    }

    /// Makes the rays of the batch; returns their number.
    #[inline(always)]
    fn make_rays<L: Lanes>(&self, rays: &GlintRays, paths: &mut Paths, count: usize) -> usize {
        let mut live = 0;
        for at in (0..count).step_by(L::N) {
            let mut stream = L::load_u(&rays.stream[at..]);
            let in_pixel = next_pair::<L>(&mut stream);
            let lens = if self.eye.has_lens() { next_pair::<L>(&mut stream) } else { [L::f(0.0); 2] };
            let corner = [L::load(&rays.corner[0][at..]), L::load(&rays.corner[1][at..])];
            let EyeRays { origin, direction, weight } = self.eye.rays::<L>(corner, in_pixel, lens);
            let packet = Packet {
                origin,
                direction,
                weight: V3::new(weight, weight, weight),
                leaves: L::u(NO_SPHERE),
                stream,
                slot: L::u(at as u32) + L::iota(),
            };
            live = paths.append(live, L::first(count - at), &packet);
        }
        live
    }

    /// Adds the light of lamps where the first `live` rays have hit, if the rays count; returns the number of rays that go on.
    #[inline(always)]
    fn shade<L: Lanes>(&self, rays: &mut GlintRays, paths: &mut Paths, live: usize) -> usize {
        let surfaces = self.tables.surfaces(&paths.hit[..live]);
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let mut p = paths.load::<L>(at);
            let (t, hit, arrived) = hits::<L>(paths, at, L::first(live - at));
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Hit::<L>::at(surfaces, p.origin, p.direction, t, &ids);
            let is_lamp =
                tag::has::<L>(surface.tag, tag::EMITTER) & !tag::has::<L>(surface.tag, tag::ENCLOSURE);
            let add = |ray: usize, light| {
                if rays.counts[ray] == 1 {
                    rays.light.add(ray, light);
                }
            };
            each_emission::<L>(self.still, arrived & is_lamp, p.weight, (p.slot, &ids), add);
            let material = Materials::<L>::gather(&self.tables.materials, surface.tag);
            let is_smooth = arrived & !L::eq(material.kind, L::u(kind::DIFFUSE));
            if L::any(is_smooth) {
                let is_glass = is_smooth & L::eq(material.kind, L::u(kind::DIELECTRIC));
                let lobe = next_where::<L>(is_glass, &mut p.stream);
                p.weight = p.weight * material.albedo;
                let (d, ior) = (p.direction, material.ior);
                let through = dielectric_by_roots(d, surface.normal, surface.inside, ior, lobe);
                follow(&mut p, (&surface, hit), is_glass, through);
                go_on = paths.append(go_on, is_smooth, &p);
            }
        }
        go_on
    }
}

/// The next two numbers of the streams. (Not a closure: these do not inherit what lanes the processor has.)
#[inline(always)]
fn next_pair<L: Lanes>(stream: &mut L::U) -> [L::F; 2] {
    [next_uniform::<L>(stream), next_uniform::<L>(stream)]
}

/// [`GlintPass::run`] as a function that the passes share.
struct FurtherRays<'a> {
    pass: GlintPass<'a>,
    glints: &'a mut Glints,
    paths: &'a mut Paths,
    search: &'a mut SearchBuffers,
    first: usize,
}

impl Kernel for FurtherRays<'_> {
    /// Segments traced.
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u64 {
        let Self { pass, glints: Glints { slots, listed, rays }, paths, search, first } = self;
        let keys = pass.keys();
        let mut sums = vec![(Vec3::ZERO, 0); listed.len()];
        let of_pixel = |ray| (ray / keys.len(), ray % keys.len());
        let (all, mut segments) = (listed.len() * keys.len(), 0);
        for begun in (0..all).step_by(BATCH) {
            let count = BATCH.min(all - begun);
            for ray in 0..count {
                let (pixel, number) = of_pixel(begun + ray);
                let place = pass.eye.pixel(first + listed[pixel] as usize);
                [rays.corner[0][ray], rays.corner[1][ray]] = [place.0 as f32, place.1 as f32];
                rays.stream[ray] = keys[number].state(pass.eye.index(place));
                rays.counts[ray] = slots[listed[pixel] as usize].is_rim.into();
            }
            rays.light = Vectors::ZERO;
            let mut live = pass.make_rays::<L::Pair>(rays, paths, count);
            for segment in 0..pass.settings.max_depth {
                if live == 0 {
                    break;
                }
                segments += live as u64;
                intersect_batch::<L>(pass.tables, paths, search, live, segment == 0);
                live = pass.shade::<L::Pair>(rays, paths, live);
                if segment == 0 {
                    paths.slot[..live].iter().for_each(|ray| rays.counts[*ray as usize] = 1);
                }
            }
            for ray in 0..count {
                let (sum, counted) = &mut sums[of_pixel(begun + ray).0];
                *sum += Vec3::new(rays.light.x[ray], rays.light.y[ray], rays.light.z[ray]);
                *counted += rays.counts[ray];
            }
        }
        for (slot, (sum, counted)) in listed.iter().zip(sums) {
            if counted > 0 {
                slots[*slot as usize].light = sum / counted as f32;
            }
        }
        segments
    }
}
