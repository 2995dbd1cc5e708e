//! The paths of a work item, from the eye until they end, a batch of them at a time.

use crate::camera_pass::{Eye, EyeRays};
use crate::direct_light::Receivers;
use crate::hierarchy::SearchBuffers;
use crate::lit_points::LitPoints;
use crate::material::{Materials, kind};
use crate::paths::{Floats, Packet, Paths, ROOM, Vectors, Words};
use crate::prepared::Prepared;
use crate::sampling::{cosine_hemisphere, next_uniform, stream_state};
use crate::scatter::{dielectric, reflect};
use crate::surface::{Hit, tag};
use crate::trace::{hits, intersect_batch};
use lanes::{Lanes, MOST_LANES, V3};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::{Rgb, Vec3};
use std::f32::consts::FRAC_1_PI;

/// What an iteration reads.
pub(super) struct PathPass<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) eye: &'a Eye,
    pub(super) max_depth: u32,
    /// The key of the paths' random streams.
    pub(super) key: StreamKey,
}

impl<'a> PathPass<'a> {
    /// That of iteration `iteration`.
    pub(super) fn new(
        prepared: &'a Prepared<'a>,
        eye: &'a Eye,
        max_depth: u32,
        (seed, iteration): (u64, u32),
    ) -> Self {
        Self { prepared, eye, max_depth, key: StreamKey::new(seed, Family::Path, iteration) }
    }
}

/// Buffers of one batch.
pub(super) struct PathBatch {
    paths: Box<Paths>,
    progress: Box<PathProgress>,
    search: SearchBuffers,
    lit: Box<LitPoints>,
    /// What irradiance counts at each of them.
    lit_weights: Box<Vectors>,
    /// What the sample of each pixel of a work item counts, by the filter.
    weights: Vec<f32>,
}

impl PathBatch {
    pub(super) fn new() -> Self {
        Self {
            paths: Paths::new(),
            progress: Box::new(PathProgress { scale: [0.0; ROOM], state: [0; ROOM] }),
            search: SearchBuffers::new(),
            lit: LitPoints::new(),
            lit_weights: Box::new(Vectors::ZERO),
            weights: Vec::new(),
        }
    }
}

/// What the path tracer knows of each path of a batch, beside [`Paths`].
struct PathProgress {
    /// The product of the factors from refraction.
    scale: Floats,
    /// [`SEEN_DIFFUSE`] and [`COUNTS_LAMPS`], and above them how many segments may follow.
    state: Words,
}

/// The path has met a diffuse surface.
const SEEN_DIFFUSE: u32 = 1;
/// Lamps that the path hits next were not counted as direct light.
const COUNTS_LAMPS: u32 = 2;
/// The bits of a path's state above these count segments.
const REST_SHIFT: i32 = 2;

/// One packet of [`PathProgress`].
struct ProgressLanes<L: Lanes> {
    scale: L::F,
    seen_diffuse: L::M,
    counts_lamps: L::M,
    /// How many segments may follow.
    rest: L::U,
}

impl PathProgress {
    /// The packet from `at` on, whose paths now go one segment further.
    #[inline(always)]
    fn go_on<L: Lanes>(&self, at: usize) -> ProgressLanes<L> {
        let state = L::load_u(&self.state[at..]);
        ProgressLanes {
            scale: L::load(&self.scale[at..]),
            seen_diffuse: tag::has::<L>(state, SEEN_DIFFUSE),
            counts_lamps: tag::has::<L>(state, COUNTS_LAMPS),
            rest: L::shr::<REST_SHIFT>(state) + L::u(u32::MAX),
        }
    }

    /// Writes the lanes where `m` is true from `at` on.
    #[inline(always)]
    fn append<L: Lanes>(&mut self, at: usize, m: L::M, p: &ProgressLanes<L>) {
        let zero = L::u(0);
        let seen_diffuse = L::select_u(p.seen_diffuse, L::u(SEEN_DIFFUSE), zero);
        let counts_lamps = L::select_u(p.counts_lamps, L::u(COUNTS_LAMPS), zero);
        let state = L::shl::<REST_SHIFT>(p.rest) | seen_diffuse | counts_lamps;
        L::compress(m, p.scale, &mut self.scale[at..]);
        L::compress_u(m, state, &mut self.state[at..]);
    }
}

impl PathPass<'_> {
    /// Samples the pixels of the slots from `first` on, one per element of `samples`, by at most `at_once` paths at a time,
    /// themselves at most [`BATCH`](crate::paths::BATCH). Returns the number of segments traced.
    #[inline(always)]
    pub(super) fn run<L: Lanes>(
        &self,
        batch: &mut PathBatch,
        first: usize,
        at_once: usize,
        samples: &mut [[f32; 3]],
    ) -> u64 {
        samples.fill([0.0; 3]);
        batch.weights.resize(samples.len(), 0.0);
        let (mut live, mut begun, mut segments) = (0, 0, 0);
        loop {
            while live + L::N <= at_once && begun < samples.len() {
                live = self.make_rays::<L>(batch, live, first, begun);
                begun += L::N;
            }
            if live == 0 {
                break;
            }
            segments += live as u64;
            intersect_batch::<L>(&self.prepared.tables, &mut batch.paths, &mut batch.search, live);
            batch.lit.count = 0;
            live = self.shade::<L>(batch, live, samples);
            self.light::<L>(batch, samples);
        }
        if self.eye.weighs() {
            for (sample, weight) in samples.iter_mut().zip(&batch.weights) {
                *sample = (Rgb::from_array(*sample) * *weight).to_array();
            }
        }
        segments
    }

    /// Appends the camera rays of a packet of slots, the one at `begun` after `first`, to the `live` paths, except for slots
    /// outside of the image; returns the number of paths.
    #[inline(always)]
    fn make_rays<L: Lanes>(&self, batch: &mut PathBatch, live: usize, first: usize, begun: usize) -> usize {
        let pixels = self.eye.pixels::<L>(first + begun);
        let mut stream = stream_state::<L>(self.key, pixels.index);
        let [a, b, c, d] = std::array::from_fn(|_| next_uniform::<L>(&mut stream));
        let EyeRays { origin, direction, weight } = self.eye.rays(&pixels, [a, b], [c, d]);
        L::store(weight, &mut batch.weights[begun..]);
        let packet = Packet {
            origin,
            direction,
            weight: V3::splat(Vec3::ONE),
            leaves: L::u(NO_SPHERE),
            stream,
            slot: L::u(begun as u32) + L::iota(),
        };
        let progress = ProgressLanes::<L> {
            scale: L::f(1.0),
            seen_diffuse: L::first(0),
            counts_lamps: L::first(L::N),
            rest: L::u(self.max_depth),
        };
        batch.progress.append(live, pixels.in_image, &progress);
        batch.paths.append(live, pixels.in_image, &packet)
    }

    /// Shades the first `live` paths where they have hit: adds emission to `samples`, and lists the points that receive
    /// direct light. Returns the number of paths that go on.
    #[inline(always)]
    fn shade<L: Lanes>(&self, batch: &mut PathBatch, live: usize, samples: &mut [[f32; 3]]) -> usize {
        let Prepared { still, tables, lights } = self.prepared;
        let (surfaces, is_dark) = (tables.surfaces(still), lights.is_empty());
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let mut p = batch.paths.load::<L>(at);
            let mut progress = batch.progress.go_on::<L>(at);
            let (t, hit, arrived) = hits::<L>(&batch.paths, at, L::first(live - at));
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Hit::<L>::at(surfaces, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::gather(&tables.materials, surface.tag);
            let glows = arrived & progress.counts_lamps & tag::has::<L>(surface.tag, tag::EMITTER);
            if L::any(glows) {
                self.add_emission::<L>(glows, p.weight.scale(progress.scale), (p.slot, &ids), samples);
            }
            p.weight = p.weight * material.albedo;
            let is_diffuse = arrived & L::eq(material.kind, L::u(kind::DIFFUSE));
            let is_first = is_diffuse & !progress.seen_diffuse;
            progress.rest = L::select_u(is_first, L::u(self.max_depth), progress.rest);
            progress.seen_diffuse = progress.seen_diffuse | is_diffuse;
            progress.counts_lamps = !is_diffuse;
            let may_follow = !L::eq(progress.rest, L::u(0));
            // A black surface, such as the sky, ends the path: what it receives is not seen, nor are the random numbers of the
            // path that are left.
            let is_lit = is_diffuse & may_follow & L::lt(L::f(0.0), p.weight.max_component());
            if L::any(is_lit) {
                let [choice, u, v] = std::array::from_fn(|_| next_where::<L>(is_lit, &mut p.stream));
                if !is_dark {
                    let weight = p.weight.scale(progress.scale * L::f(FRAC_1_PI));
                    batch.lit_weights.compress(is_lit, weight, batch.lit.count);
                    let (point, normal) = (surface.point, surface.normal);
                    let receivers = Receivers { live: is_lit, point, normal, sphere: hit };
                    batch.lit.append(&receivers, p.slot, V3::new(choice, u, v));
                }
            }
            p.direction = scatter::<L>(arrived, &surface, &material, &mut p, &mut progress.scale);
            p.origin = surface.point;
            p.leaves = hit;
            let survives = arrived & survive::<L>(arrived & progress.seen_diffuse, &mut p) & may_follow;
            batch.progress.append(go_on, survives, &progress);
            go_on = batch.paths.append(go_on, survives, &p);
        }
        go_on
    }

    /// Adds the emission of lamps that paths of this weight meet: seldom, so lane by lane.
    #[inline(always)]
    fn add_emission<L: Lanes>(
        &self,
        glows: L::M,
        weight: V3<L>,
        (slot, ids): (L::U, &[u32]),
        samples: &mut [[f32; 3]],
    ) {
        let (mut slots, weights) = ([0; MOST_LANES], lanes_of::<L>(weight));
        L::store_u(slot, &mut slots);
        let mut rest = L::mask_bits(glows);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let emission = self.prepared.still.spheres[ids[lane] as usize].emission;
            let weight = Vec3::new(weights[0][lane], weights[1][lane], weights[2][lane]);
            add(&mut samples[slots[lane] as usize], (weight * emission).to_array());
        }
    }

    /// Adds direct light on all points of the list.
    #[inline(always)]
    fn light<L: Lanes>(&self, batch: &mut PathBatch, samples: &mut [[f32; 3]]) {
        let PathBatch { lit, lit_weights, search, .. } = batch;
        lit.ask::<L>(self.prepared, search);
        for at in (0..lit.count).step_by(L::N) {
            let light = lanes_of::<L>(lit_weights.load::<L>(at) * lit.shadows.irradiance(at));
            for lane in 0..L::N.min(lit.count - at) {
                add(
                    &mut samples[lit.slot[at + lane] as usize],
                    [0, 1, 2].map(|channel| light[channel][lane]),
                );
            }
        }
    }
}

/// The directions in which paths go on from where they have hit. Multiplies `scale` by the factor from refraction.
#[inline(always)]
fn scatter<L: Lanes>(
    arrived: L::M,
    surface: &Hit<L>,
    material: &Materials<L>,
    p: &mut Packet<L>,
    scale: &mut L::F,
) -> V3<L> {
    let is_diffuse = arrived & L::eq(material.kind, L::u(kind::DIFFUSE));
    let is_glass = arrived & L::eq(material.kind, L::u(kind::DIELECTRIC));
    let u = next_where::<L>(is_diffuse | is_glass, &mut p.stream);
    let v = next_where::<L>(is_diffuse, &mut p.stream);
    let direction = cosine_hemisphere(surface.normal, u, v);
    if !L::any(arrived & !is_diffuse) {
        return direction;
    }
    let mirrored = reflect(p.direction, surface.normal);
    let (through, factor) = dielectric(p.direction, surface.normal, surface.inside, material.ior, u);
    *scale = *scale * L::select(is_glass, factor, L::f(1.0));
    V3::select(is_diffuse, direction, V3::select(is_glass, through, mirrored))
}

/// Russian roulette by the throughput, where `m` is true: which lanes survive it, with what throughput. Elsewhere all do.
#[inline(always)]
fn survive<L: Lanes>(m: L::M, p: &mut Packet<L>) -> L::M {
    let survival = L::min(p.weight.max_component(), L::f(1.0));
    let survives = L::lt(next_where::<L>(m, &mut p.stream), survival);
    let V3 { x, y, z } = p.weight;
    p.weight = V3::select(m, V3::new(x / survival, y / survival, z / survival), p.weight);
    survives | !m
}

/// Steps the streams where `m` is true, and returns their next uniform numbers; elsewhere anything.
#[inline(always)]
fn next_where<L: Lanes>(m: L::M, stream: &mut L::U) -> L::F {
    let mut next = *stream;
    let number = next_uniform::<L>(&mut next);
    *stream = L::select_u(m, next, *stream);
    number
}

/// The components of each lane.
#[inline(always)]
fn lanes_of<L: Lanes>(v: V3<L>) -> [[f32; MOST_LANES]; 3] {
    let mut lanes = [[0.0; MOST_LANES]; 3];
    L::store(v.x, &mut lanes[0]);
    L::store(v.y, &mut lanes[1]);
    L::store(v.z, &mut lanes[2]);
    lanes
}

#[inline(always)]
fn add(to: &mut [f32; 3], light: [f32; 3]) {
    for channel in 0..3 {
        to[channel] += light[channel];
    }
}
