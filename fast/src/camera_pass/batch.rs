//! The camera paths of a batch of pixels.

use crate::direct_light::{LightTable, Receivers, ShadowRays};
use crate::eye::{Eye, EyeRays, Numbers, dimension};
use crate::glints::{GlintPass, Glints};
use crate::hierarchy::SearchBuffers;
use crate::material::{Materials, kind};
use crate::paths::{Floats, Packet, Paths, ROOM, Vectors, Words};
use crate::pixels::{GroupColumns, Pixel, PixelRow, PixelRowLanes};
use crate::sampling::{next_uniform, stream_state};
use crate::scatter::{dielectric, follow};
use crate::surface::{Hit, tag};
use crate::tables::Tables;
use crate::trace::{each_emission, hits, intersect_batch};
use lanes::{Lanes, MOST_LANES, V3};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::still::Carried;
use scene::{Clearance, Settings, Still, Vec3};
use std::f32::consts::FRAC_1_PI;

/// What the camera pass of one iteration reads.
pub(crate) struct CameraPass<'a> {
    pub(crate) still: &'a Still<'a>,
    pub(crate) tables: &'a Tables,
    pub(crate) lights: &'a LightTable,
    pub(crate) eye: &'a Eye,
    pub(crate) settings: &'a Settings,
    pub(crate) iteration: u32,
    /// The limit of radii by what is near, if there is one.
    pub(crate) clearance: Option<&'a Clearance>,
}

/// Counted work.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CameraCounts {
    pub(crate) segments: u64,
    pub(crate) visible_points: u64,
}

impl CameraCounts {
    #[inline(always)]
    pub(super) fn add(&mut self, more: Self) {
        self.segments += more.segments;
        self.visible_points += more.visible_points;
    }
}

/// Buffers of one batch.
pub(crate) struct CameraBatch {
    paths: Box<Paths>,
    search: SearchBuffers,
    shadows: Box<ShadowRays>,
    ended: Box<Ended>,
    /// Direct light of each pixel: of lamps that its path meets.
    direct: Box<Vectors>,
    /// The sum over the shadow rays of each of the paths that have ended.
    irradiance: Box<Vectors>,
    glints: Glints,
    numbers: Numbers,
}

/// The paths that have ended, in any order. Those without a visible point have [`NO_SPHERE`].
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
            search: SearchBuffers::new(),
            shadows: Box::new(ShadowRays::new()),
            ended: Box::new(Ended { point, normal, beta, sphere: words, slot: words, count: 0 }),
            direct: Box::new(vectors.clone()),
            irradiance: Box::new(vectors),
            glints: Glints::new(),
            numbers: Numbers::new(),
        }
    }
}

impl CameraPass<'_> {
    /// Renders the pixels of the slots from `first` on, one per element of `rows`, at most
    /// [`BATCH`](crate::paths::BATCH).
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(
        &self,
        batch: &mut CameraBatch,
        first: usize,
        (rows, columns): (&mut [PixelRow], &mut [GroupColumns]),
    ) -> CameraCounts {
        let mut counts = CameraCounts::default();
        batch.ended.count = 0;
        batch.glints.begin(if self.has_glints() { ROOM } else { 0 });
        batch.numbers.begin(self.settings, self.iteration, first, rows.len());
        let mut live = self.make_rays::<L>(batch, first, rows.len());
        for segment in 0..self.settings.max_depth {
            if live == 0 {
                break;
            }
            counts.segments += live as u64;
            intersect_batch::<L>(self.tables, &mut batch.paths, &mut batch.search, live, segment == 0);
            live = self.shade::<L::Pair>(batch, live, segment);
        }
        end_the_rest::<L>(batch, live);
        if self.asks_lights() {
            self.light::<L>(batch);
        }
        let CameraBatch { paths, search, glints, .. } = batch;
        counts.segments += self.glint_pass().run::<L>(glints, paths, search, first);
        counts.visible_points = self.write::<L>(batch, rows, columns);
        counts
    }

    /// False if photons carry caustics alone: the rest is a path tracer's.
    #[inline(always)]
    pub(super) fn has_direct(&self) -> bool {
        self.still.carried == Carried::All
    }

    #[inline(always)]
    fn glint_pass(&self) -> GlintPass<'_> {
        let &Self { still, tables, eye, settings, iteration, .. } = self;
        GlintPass { still, tables, eye, settings, iteration }
    }

    #[inline(always)]
    fn has_glints(&self) -> bool {
        self.has_direct() && self.glint_pass().is_needed()
    }

    #[inline(always)]
    fn asks_lights(&self) -> bool {
        self.has_direct() && !self.lights.is_empty()
    }

    /// The squared search radius of a pixel whose camera path has found `row`.
    #[inline(always)]
    pub(crate) fn radius_squared(&self, row: &PixelRow, pixel: &Pixel) -> f32 {
        match (self.clearance, row.visible()) {
            (Some(clearance), Some(point)) if pixel.n == 0.0 => {
                clearance.limited(&self.still.spheres, (point, row.sphere), pixel.radius_squared)
            }
            _ => pixel.radius_squared,
        }
    }

    /// The number by which a path chooses between reflection and refraction, as
    /// `reference::camera_pass::CameraNumbers::lobe`; anything if no lane is `needed`.
    #[inline(always)]
    fn lobe<L: Lanes>(&self, numbers: &Numbers, p: &mut Packet<L>, segment: u32, needed: L::M) -> L::F {
        let Some(&d) = dimension::LOBES.get(segment as usize) else {
            return next_uniform::<L>(&mut p.stream);
        };
        if !L::any(needed) {
            return L::f(0.0);
        }
        let [number] = numbers.of_slots::<L, 1>(&self.eye.tiles, [d], (needed, p.slot));
        number
    }

    /// Makes the camera rays of the batch, except for slots outside of the image; returns their number.
    #[inline(always)]
    fn make_rays<L: Lanes>(&self, batch: &mut CameraBatch, first: usize, count: usize) -> usize {
        let key = StreamKey::new(self.settings.seed, Family::Camera, self.iteration);
        let has_glints = self.has_glints();
        let mut live = 0;
        for at in (0..count).step_by(L::N) {
            let pixels = self.eye.pixels::<L>(first + at);
            let in_pixel = batch.numbers.of_packet::<L>(&self.eye.tiles, dimension::PIXEL, at);
            let lens = batch.numbers.of_packet::<L>(&self.eye.tiles, dimension::LENS, at);
            let EyeRays { origin, direction, weight } = self.eye.rays::<L>(pixels.corner, in_pixel, lens);
            let packet = Packet {
                origin,
                direction,
                weight: V3::new(weight, weight, weight),
                leaves: L::u(NO_SPHERE),
                stream: stream_state::<L>(key, pixels.index),
                slot: L::u(at as u32) + L::iota(),
            };
            live = batch.paths.append(live, pixels.in_image, &packet);
            batch.direct.store(at, V3::<L>::splat(Vec3::ZERO));
            if has_glints {
                batch.glints.list_rims(at, self.eye.rims(first + at, L::N));
            }
        }
        live
    }

    /// Shades the first `live` paths where they have hit; returns the number of those that go on.
    #[inline(always)]
    fn shade<L: Lanes>(&self, batch: &mut CameraBatch, live: usize, segment: u32) -> usize {
        let surfaces = self.tables.surfaces(&batch.paths.hit[..live]);
        let has_glints = self.has_glints();
        let mut go_on = 0;
        for at in (0..live).step_by(L::N) {
            let here = L::first(live - at);
            let mut p = batch.paths.load::<L>(at);
            let (t, hit, arrived) = hits::<L>(&batch.paths, at, here);
            let mut ids = [0; MOST_LANES];
            L::store_u(hit, &mut ids);
            let surface = Hit::<L>::at(surfaces, p.origin, p.direction, t, &ids);
            let material = Materials::<L>::gather(&self.tables.materials, surface.tag);
            let glows = arrived & tag::has::<L>(surface.tag, tag::EMITTER);
            if self.has_direct() {
                let is_lamp = !tag::has::<L>(surface.tag, tag::ENCLOSURE);
                let (still, from) = (self.still, (p.slot, &ids[..]));
                let add = |slot, light| match batch.glints.of(slot) {
                    Some(glints) => *glints += light,
                    None => batch.direct.add(slot, light),
                };
                each_emission::<L>(still, glows & is_lamp, p.weight, from, add);
                let add = |slot, light| batch.direct.add(slot, light);
                each_emission::<L>(still, glows & !is_lamp, p.weight, from, add);
            }
            let is_glass = arrived & L::eq(material.kind, L::u(kind::DIELECTRIC));
            let lobe = self.lobe::<L>(&batch.numbers, &mut p, segment, is_glass);
            p.weight = p.weight * material.albedo;
            let is_diffuse = arrived & L::eq(material.kind, L::u(kind::DIFFUSE));
            let ends = here & (!arrived | is_diffuse);
            batch.ended.append(ends, is_diffuse, &surface, hit, &p);
            let is_smooth = arrived & !is_diffuse;
            if L::any(is_smooth) {
                if has_glints && segment == 0 {
                    batch.glints.list::<L>(is_smooth, p.slot);
                }
                let through = dielectric(p.direction, surface.normal, surface.inside, material.ior, lobe);
                follow(&mut p, (&surface, hit), is_glass, through);
                go_on = batch.paths.append(go_on, is_smooth, &p);
            }
        }
        go_on
    }

    /// Direct light on all visible points: the mean over all shadow rays from each.
    #[inline(always)]
    fn light<L: Lanes>(&self, batch: &mut CameraBatch) {
        let CameraBatch { ended, shadows, search, numbers, irradiance, .. } = batch;
        let samples = self.settings.light_samples;
        for sample in 0..samples {
            self.aim_shadows::<L::Pair>(ended, numbers, sample, shadows);
            shadows.follow::<L>(self.tables, &ended.point, &ended.sphere, search, ended.count, true);
            for at in (0..ended.count).step_by(L::N) {
                let so_far = if sample == 0 { V3::splat(Vec3::ZERO) } else { irradiance.load::<L>(at) };
                irradiance.store(at, so_far + shadows.irradiance(at));
            }
        }
    }

    /// Aims a shadow ray from each visible point.
    #[inline(always)]
    fn aim_shadows<L: Lanes>(&self, ended: &Ended, numbers: &Numbers, sample: u32, shadows: &mut ShadowRays) {
        for at in (0..ended.count).step_by(L::N) {
            let sphere = L::load_u(&ended.sphere[at..]);
            let live = L::first(ended.count - at) & !L::eq(sphere, L::u(NO_SPHERE));
            let digits = numbers.light_digits(&self.eye.tiles, live, L::load_u(&ended.slot[at..]));
            let (point, normal) = (ended.point.load::<L>(at), ended.normal.load::<L>(at));
            let receivers = Receivers { live, point, normal, sphere };
            shadows.aim(at, self.lights, &receivers, &numbers.light(&digits, sample));
        }
    }

    /// Writes the results of all pixels; returns the number of visible points.
    #[inline(always)]
    fn write<L: Lanes>(
        &self,
        batch: &CameraBatch,
        rows: &mut [PixelRow],
        columns: &mut [GroupColumns],
    ) -> u64 {
        let ended = &batch.ended;
        let share = 1.0 / self.settings.light_samples as f32;
        let has_glints = self.has_glints();
        let mut visible_points = 0;
        for at in (0..ended.count).step_by(L::N) {
            let beta: V3<L> = ended.beta.load(at);
            let (point, normal) = (ended.point.load::<L>(at), ended.normal.load::<L>(at));
            let sphere = L::load_u(&ended.sphere[at..]);
            let slots = &ended.slot[at..at + L::N];
            let is_visible = L::first(ended.count - at) & !L::eq(sphere, L::u(NO_SPHERE));
            visible_points += u64::from(L::mask_bits(is_visible).count_ones());
            let mut direct = batch.direct.gather::<L>(slots);
            if self.asks_lights() {
                let mean = batch.irradiance.load::<L>(at).scale(L::f(share));
                direct = V3::select(is_visible, direct + beta * mean, direct);
            }
            if has_glints {
                direct = direct + batch.glints.gather::<L>(slots);
            }
            // The radius follows once all pixels have their points.
            let radius_squared = L::f(0.0);
            let found = PixelRowLanes::<L> { point, sphere, beta, radius_squared };
            found.scatter(slots, ended.count - at, rows);
            GroupColumns::scatter::<L>((normal, direct), slots, ended.count - at, columns);
        }
        visible_points
    }
}

impl Ended {
    /// Appends the lanes `ends`. Those on diffuse surfaces have a visible point, unless their path carries no light.
    #[inline(always)]
    fn append<L: Lanes>(&mut self, ends: L::M, is_diffuse: L::M, surface: &Hit<L>, hit: L::U, p: &Packet<L>) {
        let zero = V3::splat(Vec3::ZERO);
        let beta = p.weight.scale(L::f(FRAC_1_PI));
        // A filter may have negative weights.
        let brightest = V3::<L>::new(L::abs(beta.x), L::abs(beta.y), L::abs(beta.z)).max_component();
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

/// Ends the paths that have reached the maximal depth: they have no visible point.
#[inline(always)]
fn end_the_rest<L: Lanes>(batch: &mut CameraBatch, live: usize) {
    let nowhere = V3::splat(Vec3::ZERO);
    let surface =
        Hit::<L> { point: nowhere, normal: nowhere, inside: L::first(0), scale: L::f(0.0), tag: L::u(0) };
    for at in (0..live).step_by(L::N) {
        let p = batch.paths.load::<L>(at);
        batch.ended.append(L::first(live - at), L::first(0), &surface, L::u(NO_SPHERE), &p);
    }
}

impl Vectors {
    /// The vectors at these indices.
    #[inline(always)]
    fn gather<L: Lanes>(&self, index: &[u32]) -> V3<L> {
        // As most are where nothing is a mirror or glass.
        let is_next = L::eq(L::load_u(index), L::u(index[0]) + L::iota());
        if !L::any(!is_next) {
            return self.load(index[0] as usize);
        }
        V3::new(gather::<L>(&self.x, index), gather::<L>(&self.y, index), gather::<L>(&self.z, index))
    }
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
