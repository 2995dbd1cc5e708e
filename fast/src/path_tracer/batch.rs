//! The paths of a work item, from the eye until they end, a batch of them at a time.

use super::numbers::Choices;
use crate::direct_light::{Receivers, ShadowNumbers};
use crate::eye::{Eye, EyeRays, Numbers, dimension};
use crate::glints::{GlintPass, Glints};
use crate::hierarchy::SearchBuffers;
use crate::lit_points::LitPoints;
use crate::material::{Materials, kind};
use crate::paths::{BATCH, Floats, Packet, Paths, ROOM, Vectors, Words};
use crate::prepared::Prepared;
use crate::sampling::{cosine_hemisphere, next_where, stream_state};
use crate::scatter::{dielectric, reflect};
use crate::surface::{Hit, tag};
use crate::trace::{each_emission, hits, intersect_batch};
use lanes::{Lanes, MOST_LANES, V3};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::{Rgb, Settings, Vec3};
use std::f32::consts::FRAC_1_PI;

/// What an iteration reads.
pub(super) struct PathPass<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) eye: &'a Eye,
    pub(super) settings: &'a Settings,
    pub(super) iteration: u32,
    /// True if there are lights for shadow rays.
    has_lamps: bool,
    /// True if paths meet lights that no shadow ray is sent to.
    has_ambient_lights: bool,
    /// False if the light of lamps that mirrors and glass send on to diffuse surfaces is left out.
    has_caustics: bool,
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
    glints: Glints,
    numbers: Numbers,
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
            glints: Glints::new(),
            numbers: Numbers::new(),
        }
    }
}

/// As in `reference::path_tracer`.
const SPARED: f32 = 4.0;

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

impl<'a> PathPass<'a> {
    pub(super) fn new(
        prepared: &'a Prepared<'a>,
        eye: &'a Eye,
        settings: &'a Settings,
        iteration: u32,
    ) -> Self {
        let Prepared { still, .. } = prepared;
        let (has_lamps, has_ambient_lights) = (still.has_lamps(), still.has_ambient_lights());
        Self { prepared, eye, settings, iteration, has_lamps, has_ambient_lights, has_caustics: true }
    }

    /// The same; without caustics if they are not wanted.
    pub(super) fn with_caustics(self, has_caustics: bool) -> Self {
        Self { has_caustics, ..self }
    }

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
        batch.glints.begin(if self.glint_pass().is_needed() { samples.len() } else { 0 });
        batch.numbers.begin(self.settings, self.iteration, first, samples.len());
        let key = StreamKey::new(self.settings.seed, Family::Path, self.iteration);
        let (mut live, mut begun, mut segments) = (0, 0, 0);
        loop {
            while live + L::N <= at_once && begun < samples.len() {
                live = self.make_rays::<L>(batch, live, key, (first, begun));
                begun += L::N;
            }
            if live == 0 {
                break;
            }
            segments += live as u64;
            intersect_batch::<L>(&self.prepared.tables, &mut batch.paths, &mut batch.search, live, false);
            live = self.shade::<L>(batch, live, samples);
        }
        if self.eye.weighs() {
            for (sample, weight) in samples.iter_mut().zip(&batch.weights) {
                *sample = (Rgb::from_array(*sample) * *weight).to_array();
            }
            batch.glints.weigh(&batch.weights);
        }
        let PathBatch { paths, search, glints, .. } = batch;
        segments += self.glint_pass().run::<L>(glints, paths, search, first);
        for (slot, mean) in glints.means() {
            add(&mut samples[slot], mean.to_array());
        }
        segments
    }

    #[inline(always)]
    fn glint_pass(&self) -> GlintPass<'_> {
        let &Self { prepared: Prepared { still, tables, .. }, eye, settings, iteration, .. } = self;
        GlintPass { still, tables, eye, settings, iteration }
    }

    /// Appends the camera rays of a packet of slots, the one at `begun` after `first`, to the `live` paths, except for slots
    /// outside of the image; returns the number of paths.
    #[inline(always)]
    fn make_rays<L: Lanes>(
        &self,
        batch: &mut PathBatch,
        live: usize,
        key: StreamKey,
        (first, begun): (usize, usize),
    ) -> usize {
        let pixels = self.eye.pixels::<L>(first + begun);
        let in_pixel = batch.numbers.of_packet::<L>(&self.eye.tiles, dimension::PIXEL, begun);
        let lens = batch.numbers.of_packet::<L>(&self.eye.tiles, dimension::LENS, begun);
        let EyeRays { origin, direction, weight } = self.eye.rays::<L>(pixels.corner, in_pixel, lens);
        L::store(weight, &mut batch.weights[begun..]);
        if self.glint_pass().is_needed() {
            batch.glints.list_rims(begun, self.eye.rims(first + begun, L::N));
        }
        let packet = Packet {
            origin,
            direction,
            weight: V3::splat(Vec3::ONE),
            leaves: L::u(NO_SPHERE),
            stream: stream_state::<L>(key, pixels.index),
            slot: L::u(begun as u32) + L::iota(),
        };
        let progress = ProgressLanes::<L> {
            scale: L::f(1.0),
            seen_diffuse: L::first(0),
            counts_lamps: L::first(L::N),
            rest: L::u(self.settings.max_depth),
        };
        batch.progress.append(live, pixels.in_image, &progress);
        batch.paths.append(live, pixels.in_image, &packet)
    }

    /// Shades the first `live` paths where they have hit: adds emission and direct light to `samples`. Returns the number of
    /// paths that go on.
    #[inline(always)]
    fn shade<L: Lanes>(&self, batch: &mut PathBatch, live: usize, samples: &mut [[f32; 3]]) -> usize {
        let tables = &self.prepared.tables;
        let surfaces = tables.surfaces(&batch.paths.hit[..live]);
        // A packet lists so many points at most.
        let room = BATCH - self.settings.light_samples as usize * L::N;
        let has_glints = self.glint_pass().is_needed();
        let leaves_caustics = L::first(if self.has_caustics { 0 } else { L::N });
        let (mut at, mut go_on) = (0, 0);
        batch.lit.count = 0;
        loop {
            if at >= live || batch.lit.count > room {
                self.light::<L>(batch, samples);
                batch.lit.count = 0;
            }
            if at >= live {
                return go_on;
            }
            let mut p = batch.paths.load::<L>(at);
            let mut progress = batch.progress.go_on::<L>(at);
            let (t, hit, mut arrived) = hits::<L>(&batch.paths, at, L::first(live - at));
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Hit::<L>::at(surfaces, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::gather(&tables.materials, surface.tag);
            let counts = (progress.counts_lamps & !(leaves_caustics & progress.seen_diffuse))
                | tag::has::<L>(surface.tag, tag::ENCLOSURE);
            let glows = arrived & counts & tag::has::<L>(surface.tag, tag::EMITTER);
            if L::any(glows) {
                let weight = p.weight.scale(progress.scale);
                let is_apart = !(progress.seen_diffuse | tag::has::<L>(surface.tag, tag::ENCLOSURE));
                let (still, from) = (&self.prepared.still, (p.slot, &ids[..]));
                let apart = |slot: usize, light: Vec3| match batch.glints.of(slot) {
                    Some(glints) => *glints += light,
                    None => add(&mut samples[slot], light.to_array()),
                };
                each_emission::<L>(still, glows & is_apart, weight, from, apart);
                let own = |slot: usize, light: Vec3| add(&mut samples[slot], light.to_array());
                each_emission::<L>(still, glows & !is_apart, weight, from, own);
            }
            if has_glints {
                let is_first =
                    L::eq(progress.rest, L::u(self.settings.max_depth - 1)) & !progress.seen_diffuse;
                let is_smooth = !L::eq(material.kind, L::u(kind::DIFFUSE));
                batch.glints.list::<L>(arrived & is_first & is_smooth, p.slot);
            }
            if self.has_ambient_lights {
                let is_late =
                    L::lt(L::to_float(progress.rest), L::f(self.settings.max_depth as f32 - SPARED));
                arrived = arrived & survive::<L>(arrived & progress.seen_diffuse & is_late, &mut p);
            }
            p.weight = p.weight * material.albedo;
            // A black surface, such as the sky, ends the path.
            arrived = arrived & L::lt(L::f(0.0), p.weight.max_component());
            let before = (progress.seen_diffuse, progress.rest);
            let choices = Choices::at(arrived, material.kind, before, self.settings.max_depth);
            let Choices { is_diffuse, is_first, .. } = choices;
            progress.rest = L::select_u(is_first, L::u(self.settings.max_depth), progress.rest);
            progress.seen_diffuse = progress.seen_diffuse | is_diffuse;
            progress.counts_lamps = !is_diffuse;
            let may_follow = !L::eq(progress.rest, L::u(0));
            let is_lit = is_diffuse & may_follow;
            if self.has_lamps && L::any(is_lit) {
                self.list_lit::<L>(batch, (is_lit, is_first), (&surface, hit), &mut p, progress.scale);
            }
            let [u, v] = choices.numbers(&batch.numbers, &self.eye.tiles, &mut p);
            p.direction = scatter::<L>(&choices, &surface, &material, (&p, [u, v]), &mut progress.scale);
            p.origin = surface.point;
            p.leaves = hit;
            let mut survives = arrived & may_follow;
            if !self.has_ambient_lights {
                survives = survives & survive::<L>(arrived & progress.seen_diffuse, &mut p);
            }
            batch.progress.append(go_on, survives, &progress);
            go_on = batch.paths.append(go_on, survives, &p);
            at += L::N;
        }
    }

    /// Lists what the points of a packet ask lamps: as many times as there are light samples where `is_first`, else once.
    #[inline(always)]
    fn list_lit<L: Lanes>(
        &self,
        batch: &mut PathBatch,
        (is_lit, is_first): (L::M, L::M),
        (surface, sphere): (&Hit<L>, L::U),
        p: &mut Packet<L>,
        scale: L::F,
    ) {
        let is_first = is_lit & is_first;
        let is_later = is_lit & !is_first;
        let choice = next_where::<L>(is_later, &mut p.stream);
        let u = next_where::<L>(is_later, &mut p.stream);
        let drawn = V3::new(choice, u, next_where::<L>(is_later, &mut p.stream));
        let samples = if L::any(is_first) { self.settings.light_samples } else { 1 };
        let share = 1.0 / self.settings.light_samples as f32;
        let share = L::select(is_first, L::f(share), L::f(1.0));
        let weight = p.weight.scale(scale * L::f(FRAC_1_PI) * share);
        let digits = batch.numbers.light_digits::<L>(&self.eye.tiles, is_first, p.slot);
        for sample in 0..samples {
            let live = if sample == 0 { is_lit } else { is_first };
            let ShadowNumbers { choice, u, v } = batch.numbers.light(&digits, sample);
            let numbers = V3::select(is_first, V3::new(choice, u, v), drawn);
            batch.lit_weights.compress(live, weight, batch.lit.count);
            let receivers = Receivers { live, point: surface.point, normal: surface.normal, sphere };
            batch.lit.append(&receivers, p.slot, numbers);
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
    to: &Choices<L>,
    surface: &Hit<L>,
    material: &Materials<L>,
    (p, [u, v]): (&Packet<L>, [L::F; 2]),
    scale: &mut L::F,
) -> V3<L> {
    let direction = cosine_hemisphere(surface.normal, u, v);
    if !L::any(to.arrived & !to.is_diffuse) {
        return direction;
    }
    let mirrored = reflect(p.direction, surface.normal);
    let (through, factor) = dielectric(p.direction, surface.normal, surface.inside, material.ior, u);
    *scale = *scale * L::select(to.is_glass, factor, L::f(1.0));
    V3::select(to.is_diffuse, direction, V3::select(to.is_glass, through, mirrored))
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
