//! Survey: what photons are to be aimed at. `reference::survey`, over batches of walks.
//!
//! ```text
//! until enough arrivals are found, for each round of 512 walks, a batch of 256 at a time:
//!     make the rays
//!     until none is left, at most max_depth times after the first diffuse surface:
//!         intersect all; scatter all: those that reflect after the first diffuse surface ask for a lamp
//!         follow the shadow rays; each that finds its lamp is an arrival
//!     put the arrivals of the batch in order of their walks
//! ```

use crate::direct_light::Receivers;
use crate::eye::ray_through;
use crate::hierarchy::SearchBuffers;
use crate::lit_points::LitPoints;
use crate::material::{Materials, kind};
use crate::paths::{BATCH, Packet, Paths, ROOM, Words};
use crate::pool::Pool;
use crate::prepared::Prepared;
use crate::sampling::{cosine_hemisphere, next_uniform, stream_state, unit_float};
use crate::scatter::{dielectric, reflect};
use crate::surface::{Hit, tag};
use crate::trace::{hits, intersect_batch};
use lanes::{Kernel, LaneKind, Lanes, MOST_LANES, V3, dispatch};
use rayon::prelude::*;
use scene::aim::survey::MOST_OF_WALK;
use scene::aim::{Arrival, Targets, survey};
use scene::camera::Frame;
use scene::guide::{Edge, Found, Lit};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::sobol::{low_digits, sobol};
use scene::still::Carried;
use scene::{Scene, Settings, Vec3};
use std::mem::take;

// A round is a number of whole batches.
const _: () = assert!((survey::ROUND as usize).is_multiple_of(BATCH));

/// What photons are to be aimed at, from the still of the first iteration.
pub(crate) fn survey(scene: &Scene, settings: &Settings, first: &Prepared, lanes: LaneKind) -> Targets {
    let pass = Survey {
        prepared: first,
        frame: scene.camera.frame(settings.width, settings.height),
        settings,
        key: StreamKey::new(settings.seed, Family::Survey, 0),
        low_digits: [0, 1].map(low_digits),
    };
    let pool = Pool::new();
    survey::targets(&first.still, settings, |walks, max_depth| {
        let batches: Vec<u32> = walks.step_by(BATCH).collect();
        let run = |first| {
            let mut walks = pool.take(Walks::new);
            let found = dispatch(lanes, Batch { pass: &pass, walks: &mut walks, first, max_depth });
            pool.put(walks);
            found
        };
        batches.into_par_iter().map(run).collect()
    })
}

/// What all walks read.
struct Survey<'a> {
    prepared: &'a Prepared<'a>,
    frame: Frame,
    settings: &'a Settings,
    /// The key of the walks' random streams.
    key: StreamKey,
    /// Along either axis of the image, what the low bits of a walk's number contribute to its Sobol point.
    low_digits: [[u32; BATCH]; 2],
}

/// [`BATCH`] walks from `first` on.
struct Batch<'a> {
    pass: &'a Survey<'a>,
    walks: &'a mut Walks,
    first: u32,
    /// Segments of a walk after its first diffuse surface, at most.
    max_depth: u32,
}

impl Kernel for Batch<'_> {
    type Output = Found;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Found {
        let Batch { pass, walks, first, max_depth } = self;
        let mut live = pass.begin::<L>(walks, first);
        while live > 0 {
            intersect_batch::<L>(&pass.prepared.tables, &mut walks.paths, &mut walks.search, live, false);
            live = pass.scatter::<L>(walks, live, max_depth);
            pass.ask::<L>(walks);
        }
        // Stable: those of a walk stay in order.
        let mut found = take(&mut walks.found);
        found.edges.sort_by_key(|edge| edge.walk);
        found.lit.sort_by_key(|lit| lit.walk);
        found
    }
}

/// The bit of a walk's state that is set once it has met a diffuse surface; those above it count its segments.
const SEEN_DIFFUSE: u32 = 1;
const LENGTH_SHIFT: i32 = 1;

/// The bit of the slot of a point that asks for a lamp which is set if the eye sees it itself.
const IS_SEEN: u32 = 1 << 31;

/// The walks of a batch.
struct Walks {
    /// Their `slot` is their number in the batch.
    paths: Box<Paths>,
    state: Box<Words>,
    search: SearchBuffers,
    asking: Box<LitPoints>,
    /// The number of the first.
    first: u32,
    found: Found,
}

impl Walks {
    fn new() -> Self {
        Self {
            paths: Paths::new(),
            state: Box::new([0; ROOM]),
            search: SearchBuffers::new(),
            asking: LitPoints::new(),
            first: 0,
            found: Found::default(),
        }
    }

    /// Keeps the lines of these lanes, along which walks have come to a surface.
    #[inline(always)]
    fn keep_edges<L: Lanes>(&mut self, lanes: L::M, surface: &Hit<L>, p: &Packet<L>) {
        let mut rest = L::mask_bits(lanes);
        if rest == 0 {
            return;
        }
        let mut slots = [0; MOST_LANES];
        L::store_u(p.slot, &mut slots);
        let [points, normals, directions] = [surface.point, surface.normal, -p.direction].map(columns);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let [point, normal, direction] = [&points, &normals, &directions]
                .map(|columns| Vec3::from(columns.map(|column| column[lane])));
            self.found.edges.push(Edge { walk: self.first + slots[lane], point, normal, direction });
        }
    }
}

/// The components of a vector by lanes.
#[inline(always)]
fn columns<L: Lanes>(v: V3<L>) -> [[f32; MOST_LANES]; 3] {
    [v.x, v.y, v.z].map(|component| {
        let mut column = [0.0; MOST_LANES];
        L::store(component, &mut column);
        column
    })
}

impl Survey<'_> {
    /// Begins the walks from number `first` on; returns how many.
    #[inline(always)]
    fn begin<L: Lanes>(&self, walks: &mut Walks, first: u32) -> usize {
        walks.first = first;
        let (width, height) = (L::f(self.settings.width as f32), L::f(self.settings.height as f32));
        let high_digits = [0, 1].map(|d| sobol(first, d));
        for at in (0..BATCH).step_by(L::N) {
            let start = first + at as u32;
            let mut stream = stream_state::<L>(self.key, L::u(start) + L::iota());
            let [u, v] = std::array::from_fn(|_| next_uniform::<L>(&mut stream));
            let [x, y] =
                [0, 1].map(|d| unit_float::<L>(L::load_u(&self.low_digits[d][at..]) ^ L::u(high_digits[d])));
            let (origin, direction) = ray_through::<L>(&self.frame, x * width, y * height, [u, v]);
            let packet = Packet {
                origin,
                direction,
                weight: V3::splat(Vec3::ONE),
                leaves: L::u(NO_SPHERE),
                stream,
                slot: L::u(at as u32) + L::iota(),
            };
            walks.paths.append(at, L::first(L::N), &packet);
            L::store_u(L::u(0), &mut walks.state[at..]);
        }
        BATCH
    }

    /// Takes the first `live` walks on from where they have hit, keeps the lines between diffuse surfaces, and lists the points
    /// that ask for a lamp. Returns the number of walks that go on.
    #[inline(always)]
    fn scatter<L: Lanes>(&self, walks: &mut Walks, live: usize, max_depth: u32) -> usize {
        let tables = &self.prepared.tables;
        let surfaces = tables.surfaces(&walks.paths.hit[..live]);
        let is_of_all = self.prepared.still.carried == Carried::All;
        walks.asking.count = 0;
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let mut p = walks.paths.load::<L>(at);
            let state = L::load_u(&walks.state[at..]);
            let (t, hit, arrived) = hits::<L>(&walks.paths, at, L::first(live - at));
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Hit::<L>::at(surfaces, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::gather(&tables.materials, surface.tag);
            let [u, v, roulette] = std::array::from_fn(|_| next_uniform::<L>(&mut p.stream));
            let [choice, x, y] = std::array::from_fn(|_| next_uniform::<L>(&mut p.stream));
            let is_diffuse = L::eq(material.kind, L::u(kind::DIFFUSE));
            let seen = tag::has::<L>(state, SEEN_DIFFUSE);
            let one = L::u(1);
            let length = L::shr::<LENGTH_SHIFT>(state) + one;
            let is_of_use = L::lt(L::to_float(length), L::f((MOST_OF_WALK + 1) as f32));
            walks.keep_edges::<L>(arrived & is_diffuse & seen & is_of_use, &surface, &p);
            let is_glass = L::eq(material.kind, L::u(kind::DIELECTRIC));
            let (through, _) = dielectric(p.direction, surface.normal, surface.inside, material.ior, u);
            let smooth = V3::select(is_glass, through, reflect(p.direction, surface.normal));
            let diffuse = cosine_hemisphere(surface.normal, u, v);
            (p.origin, p.direction, p.leaves) = (surface.point, V3::select(is_diffuse, diffuse, smooth), hit);
            // What would be absorbed where it arrives does not matter.
            let survives = arrived & L::lt(roulette, material.albedo.max_component());
            let is_first = is_diffuse & !seen;
            let counts = if is_of_all { L::first(L::N) } else { !is_diffuse };
            let faces = L::lt(L::f(0.0), surface.normal.dot(p.direction));
            let receivers = Receivers {
                live: survives & (seen | is_first) & counts,
                point: surface.point,
                normal: V3::select(faces, surface.normal, -surface.normal),
                sphere: hit,
            };
            let slot = p.slot | L::select_u(is_first, L::u(IS_SEEN), L::u(0));
            walks.asking.append(&receivers, slot, V3::new(choice, x, y));
            // The first diffuse surface begins a new count, of one segment.
            let length = L::select_u(is_first, one, length);
            let seen = L::select_u(is_diffuse | seen, L::u(SEEN_DIFFUSE), L::u(0));
            let may_follow = L::lt(L::to_float(length), L::f(max_depth as f32));
            let goes_on = survives & may_follow;
            L::compress_u(goes_on, L::shl::<LENGTH_SHIFT>(length) | seen, &mut walks.state[go_on..]);
            go_on = walks.paths.append(go_on, goes_on, &p);
        }
        go_on
    }

    /// Follows a shadow ray from each point of the list. Those that find their lamp are arrivals.
    #[inline(always)]
    fn ask<L: Lanes>(&self, walks: &mut Walks) {
        let Walks { asking, search, first, found, .. } = walks;
        if self.prepared.lights.is_empty() {
            return;
        }
        asking.ask::<L>(self.prepared, search);
        for at in (0..asking.count).step_by(L::N) {
            let point = asking.point.load::<L>(at);
            let [points, sources] = [point, point + asking.shadows.to_lamp::<L>(at)].map(columns);
            let flux = asking.shadows.irradiance::<L>(at).max_component();
            let mut rest = L::mask_bits(L::lt(L::f(0.0), flux) & L::first(asking.count - at));
            let mut fluxes = [0.0; MOST_LANES];
            L::store(flux, &mut fluxes);
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let slot = asking.slot[at + lane];
                let [point, source] = [&points, &sources].map(|columns| Vec3::from(columns.map(|c| c[lane])));
                found.lit.push(Lit {
                    walk: *first + (slot & !IS_SEEN),
                    is_seen: slot & IS_SEEN != 0,
                    arrival: Arrival { point, source, flux: fluxes[lane] },
                });
            }
        }
    }
}
