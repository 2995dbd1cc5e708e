//! The stage that all paths share: what do the rays of a batch hit?

use crate::hierarchy::{PASSES_NONE, Rays, Scratch};
use crate::intersect::{RayLanes, nearest};
use crate::lanes::Lanes;
use crate::paths::Paths;
use crate::tables::Tables;

/// Fills in distance and sphere of the nearest hit for the first `count` paths.
#[inline(always)]
pub(crate) fn intersect_batch<L: Lanes>(
    tables: &Tables,
    paths: &mut Paths,
    scratch: &mut Scratch,
    count: usize,
) {
    for at in (0..count).step_by(L::N) {
        let ray = RayLanes::<L> {
            origin: paths.origin.load(at),
            direction: paths.direction.load(at),
            leaves: L::load_u(&paths.leaves[at..]),
        };
        let (t, hit) = nearest(&tables.shapes, &ray);
        L::store(t, &mut paths.t[at..]);
        L::store_u(hit, &mut paths.hit[at..]);
    }
    let Paths { origin, direction, leaves, t, hit, .. } = paths;
    let rays = Rays { origin, direction, leaves, passes: &PASSES_NONE, count };
    tables.hierarchy.nearest::<L>(&tables.surfaces, &rays, scratch, t, hit);
}

/// The spheres hit by `L::N` paths from `at` on, those that escape replaced by sphere 0, which is there to be
/// fetched; and the lanes of `live` that did hit.
#[inline(always)]
pub(crate) fn hits<L: Lanes>(paths: &Paths, at: usize, live: L::M) -> (L::F, L::U, L::M) {
    let t = L::load(&paths.t[at..]);
    let hit = L::load_u(&paths.hit[at..]);
    let arrived = live & L::lt(t, L::f(f32::INFINITY));
    (t, L::select_u(arrived, hit, L::u(0)), arrived)
}
