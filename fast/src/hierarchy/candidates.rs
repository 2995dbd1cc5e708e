//! Candidates: pairs of a ray and a ball that it may hit, collected and then tested by the exact formula in full packets.
//!
//! A pair names its ball by its sphere, whose surface row is in the cache where balls are few ([`SurfaceRows`]). Where they are
//! many, the ball is copied from its leaf, which is in the cache ([`Copies`]): a row would have to come from memory.

use super::cull::may_meet;
use super::keys::key;
use super::leaves::{GLASS, LeafPart, WIDTH};
use crate::intersect::meet;
use crate::paths::{ROOM, Vectors};
use crate::rays::Rays;
use crate::search::Work;
use crate::surface::ball_lanes;
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::ray::SphereId;

/// More than there are pairs of either kind, with those that are added at once.
const MOST_CANDIDATES: usize = (SurfaceRows::ENOUGH + RAYS_AT_ONCE * WIDTH).next_power_of_two();

/// Room for the pairs, and for what vectors write past the end.
const CANDIDATE_ROOM: usize = MOST_CANDIDATES + MOST_LANES;

/// So many rays may be added before one asks whether the candidates are enough.
pub(crate) const RAYS_AT_ONCE: usize = 8;

// There is room for either kind.
const _: () = assert!(Copies::ENOUGH <= SurfaceRows::ENOUGH);
// The pairs in use take no more than a third of a first-level cache of 32 KiB: a ray and a sphere, or a ray and the five words
// of a ball.
const _: () =
    assert!(SurfaceRows::ENOUGH * 2 * 4 <= (32 << 10) / 3 && Copies::ENOUGH * 6 * 4 <= (32 << 10) / 3);

/// Pairs of a ray and a ball, as a structure of arrays.
pub(crate) struct Pairs {
    /// The number of the ray in the batch.
    rays: [u32; CANDIDATE_ROOM],
    /// The sphere; with [`Copies`] perhaps with [`GLASS`].
    balls: [u32; CANDIDATE_ROOM],
    /// With [`Copies`] only.
    centers: Vectors<CANDIDATE_ROOM>,
    /// With [`Copies`] only.
    radii_squared: [f32; CANDIDATE_ROOM],
}

/// Balls in lanes.
pub(crate) struct BallLanes<L: Lanes> {
    center: V3<L>,
    radius_squared: L::F,
    sphere: L::U,
    is_glass: L::M,
}

/// Where the balls of pairs are.
pub(crate) trait Balls {
    /// The list is evaluated once it has this many candidates.
    const ENOUGH: usize;

    /// Writes the balls of the lanes `may` to the pairs from `at` on.
    fn append<L: Lanes>(pairs: &mut Pairs, at: usize, may: L::M, balls: &LeafPart<L>);

    /// The balls of the pairs from `at` on.
    fn load<L: Lanes>(&self, pairs: &Pairs, at: usize) -> BallLanes<L>;
}

/// The rows of the surfaces of all spheres, enclosures included.
pub(crate) struct SurfaceRows<'a>(pub(crate) &'a [Row]);

impl Balls for SurfaceRows<'_> {
    const ENOUGH: usize = 1024;

    #[inline(always)]
    fn append<L: Lanes>(pairs: &mut Pairs, at: usize, may: L::M, balls: &LeafPart<L>) {
        L::compress_u(may, balls.spheres & L::u(!GLASS), &mut pairs.balls[at..]);
    }

    #[inline(always)]
    fn load<L: Lanes>(&self, pairs: &Pairs, at: usize) -> BallLanes<L> {
        let spheres = &pairs.balls[at..at + L::N];
        let (center, radius, is_glass) = ball_lanes::<L>(self.0, spheres);
        BallLanes { center, radius_squared: radius * radius, sphere: L::load_u(spheres), is_glass }
    }
}

/// The balls are in the pairs.
pub(crate) struct Copies;

impl Balls for Copies {
    const ENOUGH: usize = 256;

    #[inline(always)]
    fn append<L: Lanes>(pairs: &mut Pairs, at: usize, may: L::M, balls: &LeafPart<L>) {
        pairs.centers.compress(may, balls.center, at);
        L::compress(may, balls.radius_squared, &mut pairs.radii_squared[at..]);
        L::compress_u(may, balls.spheres, &mut pairs.balls[at..]);
    }

    #[inline(always)]
    fn load<L: Lanes>(&self, pairs: &Pairs, at: usize) -> BallLanes<L> {
        let (center, radius_squared) = (pairs.centers.load::<L>(at), L::load(&pairs.radii_squared[at..]));
        let (id, glass) = (L::load_u(&pairs.balls[at..]), L::u(GLASS));
        BallLanes { center, radius_squared, sphere: id & L::u(!GLASS), is_glass: L::eq(id & glass, glass) }
    }
}

/// The rays of a batch as rows, and the balls that they may hit.
pub(crate) struct Candidates {
    /// A row per ray of the batch, see [`RayLanes`].
    rows: Box<[Row; ROOM]>,
    pairs: Box<Pairs>,
    /// The number of pairs.
    pub(crate) count: usize,
    /// Counted work so far.
    pub(crate) work: Work,
}

/// Rays in lanes. Their rows hold the words origin x y z, direction x y z, the sphere that the ray leaves, and the
/// sphere that it ignores.
struct RayLanes<L: Lanes> {
    origin: V3<L>,
    direction: V3<L>,
    leaves: L::U,
    ignores: L::U,
}

impl<L: Lanes> RayLanes<L> {
    #[inline(always)]
    fn gather(rows: &[Row], index: &[u32]) -> Self {
        let [ox, oy, oz, dx, dy, dz, leaves, ignores] = L::gather_rows(rows, index);
        let (origin, direction) = (V3::new(ox, oy, oz), V3::new(dx, dy, dz));
        Self { origin, direction, leaves: L::bits(leaves), ignores: L::bits(ignores) }
    }

    #[inline(always)]
    fn store(self, to: &mut [Row]) {
        let Self { origin: o, direction: d, leaves, ignores } = self;
        L::transpose([o.x, o.y, o.z, d.x, d.y, d.z, L::from_bits(leaves), L::from_bits(ignores)], to);
    }
}

impl Candidates {
    pub(crate) fn new() -> Self {
        let pairs = Pairs {
            rays: [0; CANDIDATE_ROOM],
            balls: [0; CANDIDATE_ROOM],
            centers: Vectors::ZERO,
            radii_squared: [0.0; CANDIDATE_ROOM],
        };
        let rows = Box::new([Row::default(); ROOM]);
        Self { rows, pairs: Box::new(pairs), count: 0, work: Work::default() }
    }

    /// Stores a packet of rays, those from `at` on.
    #[inline(always)]
    pub(crate) fn take_rays<L: Lanes>(&mut self, rays: &Rays, at: usize, origin: V3<L>, direction: V3<L>) {
        let (leaves, ignores) = (L::load_u(&rays.leaves[at..]), L::load_u(&rays.ignores[at..]));
        RayLanes { origin, direction, leaves, ignores }.store(&mut self.rows[at..]);
    }

    /// Adds the balls of a leaf that some rays may hit, at most [`RAYS_AT_ONCE`]. The [`trust`](super::cull::trust) of none is less
    /// than `trust`.
    #[inline(always)]
    pub(crate) fn add<L: Lanes, B: Balls>(&mut self, parts: &[LeafPart<L>; 2], rays: &[u32], trust: f32) {
        // By themselves, as they would be read again for every ray: what is written might be part of them.
        let (rows, pairs, mut end) = (&*self.rows, &mut *self.pairs, self.count);
        let trust = L::f(trust);
        for ray in rays {
            let Row([ox, oy, oz, dx, dy, dz, ..]) = rows[*ray as usize];
            let origin = V3::new(L::f(ox), L::f(oy), L::f(oz));
            let direction = V3::new(L::f(dx), L::f(dy), L::f(dz));
            for part in parts.iter().take(LeafPart::<L>::COUNT) {
                let may = may_meet(origin, direction, trust, part.center, part.radius_squared);
                // It is less already; this spares the checks of the place.
                let at = end % MOST_CANDIDATES;
                B::append(pairs, at, may, part);
                L::store_u(L::u(*ray), &mut pairs.rays[at..]);
                end += L::mask_bits(may).count_ones() as usize;
            }
        }
        self.count = end;
    }

    /// Adds a ball for the rays `may` of those from `at` on.
    #[inline(always)]
    pub(crate) fn add_ball<L: Lanes>(&mut self, may: L::M, at: usize, sphere: SphereId) {
        let end = self.count % MOST_CANDIDATES;
        L::compress_u(may, L::u(at as u32) + L::iota(), &mut self.pairs.rays[end..]);
        L::store_u(L::u(sphere), &mut self.pairs.balls[end..]);
        self.count += L::mask_bits(may).count_ones() as usize;
    }

    /// True if the candidates must be evaluated before more are added.
    #[inline(always)]
    pub(crate) fn are_enough<B: Balls>(&self, _: &B) -> bool {
        self.count >= B::ENOUGH
    }

    /// Tests all candidates by the exact formula, lowers the keys of the rays to those of the hits, and empties the list.
    #[inline(always)]
    pub(crate) fn evaluate<L: Lanes>(&mut self, balls: &impl Balls, keys: &mut [u64; ROOM]) {
        self.work.balls += self.count as u64;
        for at in (0..self.count).step_by(L::N) {
            let rays = &self.pairs.rays[at..at + L::N];
            let RayLanes { origin, direction, leaves, ignores } = RayLanes::<L>::gather(&self.rows[..], rays);
            let BallLanes { center, radius_squared, sphere, is_glass } = balls.load::<L>(&self.pairs, at);
            let leaves = L::eq(sphere, leaves);
            let (t, valid) = meet(origin, direction, leaves, center, radius_squared, is_glass);
            let valid = valid & L::first(self.count - at) & !L::eq(sphere, ignores);
            let (mut distances, mut spheres) = ([0; MOST_LANES], [0; MOST_LANES]);
            L::store_u(L::select_u(valid, L::bits(t), L::u(u32::MAX)), &mut distances);
            L::store_u(sphere, &mut spheres);
            for k in 0..L::N {
                let nearest = &mut keys[rays[k] as usize];
                *nearest = (*nearest).min(key(distances[k], spheres[k]));
            }
        }
        self.count = 0;
    }
}
