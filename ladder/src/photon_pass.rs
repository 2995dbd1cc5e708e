//! Photon pass: traces photons from the lamps, one per lane, and joins each with the visible points near it where it
//! hits a diffuse surface.

use crate::direct_light::choose_light;
use crate::index::Index;
use crate::intersect::{Rays, Surface, nearest, surface_at};
use crate::join::{Arrival, join};
use crate::numbers::{Numbers, photon_dimension as dimension};
use crate::pixels::Pixels;
use crate::sampling::{cosine_hemisphere, uniform_sphere};
use crate::scatter::{dielectric, reflect};
use crate::tables::{Tables, fetch_pairs};
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::{Settings, Stats, Vec3};

/// The inputs of the pass.
pub(crate) struct PhotonPass<'a> {
    pub(crate) tables: &'a Tables<'a>,
    pub(crate) settings: &'a Settings,
    pub(crate) iteration: u32,
    /// Whether the properties of hit spheres are read from columns.
    pub(crate) from_columns: bool,
}

/// The photons being traced, one per lane.
struct Photons<V: Vector> {
    live: M<V>,
    rays: Rays<V>,
    power: V,
}

impl PhotonPass<'_> {
    /// Traces all photons of the iteration.
    #[inline(always)]
    pub(crate) fn run<V: Vector, P: Pixels, I: Index>(
        &self,
        pixels: &mut P,
        index: &I,
        numbers: &mut Numbers,
        stats: &mut Stats,
    ) {
        let count = self.settings.photons_per_iteration;
        stats.photons += u64::from(count);
        if self.tables.lights.is_empty() {
            return;
        }
        for at in (0..count).step_by(V::L::N) {
            numbers.begin_photon_paths::<V::L>(self.iteration, at);
            let mut photons = self.emit::<V>(V::L::first((count - at) as usize), numbers);
            for bounce in 0..self.settings.max_depth {
                if !V::L::any(photons.live) {
                    break;
                }
                stats.photon_segments += u64::from(V::L::mask_bits(photons.live).count_ones());
                self.bounce(&mut photons, bounce, pixels, index, numbers, stats);
            }
        }
    }

    /// Emits photons from the lamps, as `reference::photon_pass::emit`.
    #[inline(always)]
    fn emit<V: Vector>(&self, wanted: M<V>, numbers: &mut Numbers) -> Photons<V> {
        let choice = numbers.stratified::<V::L>(dimension::LIGHT);
        let number = choose_light::<V::L>(&self.tables.still.lights.cumulative, choice);
        let [[cx, cy, cz, .., lamp], [pr, pg, pb, radius, inwards, ..]] =
            fetch_pairs::<V::L>(&self.tables.lights, &number);
        let [u, v] = numbers.pair::<V::L>(dimension::POSITION);
        let outward = uniform_sphere::<V>(u, v);
        let origin = V::new(cx, cy, cz) + outward.scale(radius);
        let inwards = V::L::eq(V::L::bits(inwards), V::L::u(1));
        let normal = V::select(inwards, -outward, outward);
        let [u, v] = numbers.pair::<V::L>(dimension::DIRECTION);
        let direction = cosine_hemisphere::<V>(normal, u, v);
        let live = wanted & self.is_free(origin, &number);
        Photons {
            live,
            rays: Rays { origin, direction, leaves: V::L::bits(lamp) },
            power: V::new(pr, pg, pb),
        }
    }

    /// The lanes whose photon does not start inside another sphere.
    #[inline(always)]
    fn is_free<V: Vector>(&self, origin: V, lights: &[u32; MOST_LANES]) -> M<V> {
        if self.tables.still.lights.blockers.is_empty() {
            return V::L::first(V::L::N);
        }
        let points = lanes_of(origin);
        let mut bits = 0;
        for lane in 0..V::L::N {
            let still = self.tables.still;
            let is_free = !still.is_hidden(&still.lights.entries[lights[lane] as usize], points[lane]);
            bits |= u32::from(is_free) << lane;
        }
        V::L::mask_from_bits(bits)
    }

    /// Traces one bounce.
    #[inline(always)]
    fn bounce<V: Vector, P: Pixels, I: Index>(
        &self,
        photons: &mut Photons<V>,
        bounce: u32,
        pixels: &mut P,
        index: &I,
        numbers: &mut Numbers,
        stats: &mut Stats,
    ) {
        let (t, hit) = nearest::<V>(&self.tables.shapes, &photons.rays);
        let arrived = photons.live & V::L::lt(t, V::L::f(f32::INFINITY));
        photons.live = arrived;
        if !V::L::any(arrived) {
            return;
        }
        // Lanes that have hit nothing read sphere 0 instead.
        let hit: U<V> = V::L::select_u(arrived, hit, V::L::u(0));
        let surface = surface_at::<V>(self.tables, &photons.rays, t, hit, self.from_columns);
        if bounce > 0 {
            let lands = arrived & surface.is_diffuse;
            if V::L::any(lands) {
                self.deposit(lands, &surface, hit, photons, pixels, index, stats);
            }
        }
        let [u, v, roulette] = bounce_numbers::<V::L>(bounce, numbers);
        let scattered = photons.power * surface.albedo;
        let (before, after): (F<V>, F<V>) = (photons.power.max_component(), scattered.max_component());
        photons.live = arrived & V::L::lt(roulette * before, after);
        if !V::L::any(photons.live) {
            return;
        }
        photons.power = scattered.scale(before / after);
        photons.rays = Rays {
            origin: surface.point,
            direction: scatter(photons.live, photons.rays.direction, &surface, u, v),
            leaves: hit,
        };
    }

    /// Joins the photons of the lanes `lands` one by one.
    #[allow(clippy::too_many_arguments)] // a part of `bounce`, separate for readability
    #[inline(always)]
    fn deposit<V: Vector, P: Pixels, I: Index>(
        &self,
        lands: M<V>,
        surface: &Surface<V>,
        hit: U<V>,
        photons: &Photons<V>,
        pixels: &mut P,
        index: &I,
        stats: &mut Stats,
    ) {
        let mut rest = V::L::mask_bits(lands);
        stats.deposits += u64::from(rest.count_ones());
        let (points, wi, powers) =
            (lanes_of(surface.point), lanes_of(-photons.rays.direction), lanes_of(photons.power));
        let mut spheres = [0; MOST_LANES];
        V::L::store_u(hit, &mut spheres);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let arrival =
                Arrival { point: points[lane], wi: wi[lane], sphere: spheres[lane], power: powers[lane] };
            join::<V, P, I>(self.tables, pixels, index, &arrival, stats);
        }
    }
}

/// Two numbers for the direction (at glass, the first chooses between reflection and refraction), one for roulette.
#[inline(always)]
fn bounce_numbers<L: Lanes>(bounce: u32, numbers: &mut Numbers) -> [L::F; 3] {
    if bounce == 0 {
        let [u, v, roulette] = dimension::FIRST_BOUNCE;
        let [u, v] = numbers.pair::<L>([u, v]);
        [u, v, numbers.stratified::<L>(roulette)]
    } else {
        let u = numbers.next::<L>();
        let v = numbers.next::<L>();
        [u, v, numbers.next::<L>()]
    }
}

/// The directions in which surfaces scatter photons.
#[inline(always)]
fn scatter<V: Vector>(live: M<V>, d: V, surface: &Surface<V>, u: F<V>, v: F<V>) -> V {
    let mut direction = d;
    let is_diffuse = live & surface.is_diffuse;
    if V::L::any(is_diffuse) {
        direction = cosine_hemisphere::<V>(surface.normal, u, v);
    }
    let is_smooth = live & !surface.is_diffuse;
    if V::L::any(is_smooth) {
        let mut smooth = reflect::<V>(d, surface.normal);
        let is_glass = is_smooth & surface.is_glass;
        if V::L::any(is_glass) {
            let (through, _) = dielectric::<V>(d, surface.normal, surface.inside, surface.ior, u);
            smooth = V::select(is_glass, through, smooth);
        }
        direction = V::select(is_smooth, smooth, direction);
    }
    direction
}

/// The vector of each lane.
#[inline(always)]
fn lanes_of<V: Vector>(v: V) -> [Vec3; MOST_LANES] {
    let ([x, y, z], mut words) = (v.xyz(), [[0.0; MOST_LANES]; 3]);
    V::L::store(x, &mut words[0]);
    V::L::store(y, &mut words[1]);
    V::L::store(z, &mut words[2]);
    let mut vectors = [Vec3::ZERO; MOST_LANES];
    for lane in 0..V::L::N {
        vectors[lane] = Vec3::new(words[0][lane], words[1][lane], words[2][lane]);
    }
    vectors
}
