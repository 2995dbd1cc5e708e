//! The join: adds one photon to the visible points near it.

use crate::flux::contribution;
use crate::index::Index;
use crate::pixels::Pixels;
use crate::tables::Tables;
use crate::vector::Vector;
use lanes::{Lanes, MOST_LANES};
use scene::ray::SphereId;
use scene::{Stats, Vec3};

/// A photon that has arrived at a diffuse surface.
#[derive(Clone, Copy)]
pub(crate) struct Arrival {
    pub(crate) point: Vec3,
    /// The direction that it comes from.
    pub(crate) wi: Vec3,
    pub(crate) sphere: SphereId,
    /// Its power, in units of the nominal power.
    pub(crate) power: Vec3,
}

/// Adds the photon to every visible point within whose radius it arrives, if it comes from the visible side or both lie
/// inside of the same shell (see `reference::contributes`). Tests one candidate per lane at a time.
#[inline(always)]
pub(crate) fn join<V: Vector, P: Pixels, I: Index>(
    tables: &Tables,
    pixels: &mut P,
    index: &I,
    arrival: &Arrival,
    stats: &mut Stats,
) {
    let photon = pixels.sums().photon(arrival.power, tables.still.lights.power);
    let (point, wi) = (V::splat(arrival.point), V::splat(arrival.wi));
    let in_shell = tables.is_shell(arrival.sphere);
    let mut cursor = index.open(arrival.point);
    while let Some((ids, live)) = I::next::<V::L>(&mut cursor) {
        stats.candidates += u64::from(V::L::mask_bits(live).count_ones());
        let held = pixels.fetch::<V>(ids);
        // As in the paper, a throughput of zero marks a pixel without a visible point.
        let live = live & pixels.is_set::<V>(&held);
        if V::L::N == 1 && !V::L::any(live) {
            continue;
        }
        let (visible, radius_squared) = pixels.reach::<V>(&held);
        let d = point - visible;
        let near = live & V::L::lt(d.dot(d), radius_squared);
        if !V::L::any(near) {
            continue;
        }
        let normal = pixels.normal::<V>(&held);
        let faces = V::L::lt(V::L::f(0.0), wi.dot(normal)) & pixels.is_seen::<V>(&held, normal);
        let mut counts = near & faces;
        if in_shell && V::L::any(near & !faces) {
            counts = counts | (near & pixels.is_in_shell::<V>(&held, arrival.sphere));
        }
        let bits = V::L::mask_bits(counts);
        if bits == 0 {
            continue;
        }
        stats.contributions += u64::from(bits.count_ones());
        let colour = match I::shared_sphere(&cursor) {
            Some(sphere) => V::splat(tables.albedo(sphere)),
            None => pixels.colour::<V>(tables, &held),
        };
        let contribution = contribution(&photon, colour);
        let mut numbers = [0; MOST_LANES];
        V::L::store_u(ids, &mut numbers);
        pixels.add::<V>(bits, &numbers, &photon, contribution);
    }
}
