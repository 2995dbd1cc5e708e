//! What paths share: the nearest hits of a batch of rays, and the light of lamps that they hit.

use crate::hierarchy::SearchBuffers;
use crate::intersect::nearest;
use crate::paths::{Floats, Paths, Words};
use crate::rays::{IGNORES_NONE, Rays};
use crate::tables::Tables;
use lanes::{Kernel, Lanes, MOST_LANES, V3};
use scene::{Still, Vec3};

/// Computes distance and sphere of the nearest hit of the first `count` paths.
#[inline(always)]
pub(crate) fn intersect_batch<L: Lanes>(
    tables: &Tables,
    paths: &mut Paths,
    buffers: &mut SearchBuffers,
    count: usize,
    are_close: bool,
) {
    L::call(Intersection { tables, paths, buffers, count, are_close });
}

/// [`intersect_batch`] as a function that all passes share: it is large, and takes long to build.
struct Intersection<'a> {
    tables: &'a Tables,
    paths: &'a mut Paths,
    buffers: &'a mut SearchBuffers,
    count: usize,
    are_close: bool,
}

impl Kernel for Intersection<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { tables, paths, buffers, count, are_close } = self;
        let Paths { origin, direction, leaves, t, hit, .. } = paths;
        let rays = Rays { origin, direction, leaves, ignores: &IGNORES_NONE, count, are_close };
        let chosen = tables.shapes.choose::<L>(&rays, None, &mut buffers.places);
        let are_all = chosen.are_all;
        nearest::<L::Pair>(chosen, &rays, t, hit);
        if !are_all {
            L::call(BallSearch { tables, rays: &rays, buffers, t, hit });
        }
    }
}

/// The search among many balls. It is called, so that it has all registers.
struct BallSearch<'a> {
    tables: &'a Tables,
    rays: &'a Rays<'a>,
    buffers: &'a mut SearchBuffers,
    t: &'a mut Floats,
    hit: &'a mut Words,
}

impl Kernel for BallSearch<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { tables, rays, buffers, t, hit } = self;
        tables.hierarchy.nearest::<L>(tables.rows(), rays, buffers, t, hit);
    }
}

/// The hits of `L::N` paths from `at` on: distances, spheres, and which lanes of `live` hit anything. Lanes that hit
/// nothing have sphere 0, whose table row can be fetched.
#[inline(always)]
pub(crate) fn hits<L: Lanes>(paths: &Paths, at: usize, live: L::M) -> (L::F, L::U, L::M) {
    let t = L::load(&paths.t[at..]);
    let hit = L::load_u(&paths.hit[at..]);
    let arrived = live & L::lt(t, L::f(f32::INFINITY));
    (t, L::select_u(arrived, hit, L::u(0)), arrived)
}

/// Calls `add` with the slot of each lane of `m` and the light that its path, of this weight, brings from the sphere that it has
/// hit: few lanes at a time hit lamps.
#[inline(always)]
pub(crate) fn each_emission<L: Lanes>(
    still: &Still,
    m: L::M,
    weight: V3<L>,
    (slot, ids): (L::U, &[u32]),
    mut add: impl FnMut(usize, Vec3),
) {
    if !L::any(m) {
        return;
    }
    let (mut slots, mut weights) = ([0; MOST_LANES], [[0.0; MOST_LANES]; 3]);
    L::store_u(slot, &mut slots);
    L::store(weight.x, &mut weights[0]);
    L::store(weight.y, &mut weights[1]);
    L::store(weight.z, &mut weights[2]);
    let mut rest = L::mask_bits(m);
    while rest != 0 {
        let lane = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        let emission = still.spheres[ids[lane] as usize].emission;
        let weight = Vec3::new(weights[0][lane], weights[1][lane], weights[2][lane]);
        add(slots[lane] as usize, weight * emission);
    }
}
