//! Rays in, hits out: what rays of a still scene meet.

use crate::choice::EngineChoice;
use crate::names::EngineName;
use fast::Intersector;
use rayon::prelude::*;
use reference::intersect::intersect;
use scene::ray::{NO_SPHERE, SphereId};
use scene::{Ray, Still, Vec3};

/// Rays that a thread traces before it asks for more.
const RAYS_AT_ONCE: usize = 1 << 14;
/// A ray that meets nothing.
const MISS: (f32, SphereId, Vec3) = (f32::INFINITY, NO_SPHERE, Vec3::ZERO);

/// Distance in scene units, sphere and unit normal of the nearest hit of each ray, by the threads of the current rayon
/// pool; a miss is infinitely far. Every engine gives the same bits.
pub fn trace(engine: EngineChoice, still: &Still, rays: &[Ray]) -> Vec<(f32, SphereId, Vec3)> {
    let intersector = Intersector::new(still, engine.lane_kind());
    let one_by_one = |ray: &Ray| intersect(still, ray).map_or(MISS, |hit| (hit.t, hit.sphere, hit.normal));
    let some = |rays: &[Ray]| -> Vec<_> {
        match engine.name() {
            EngineName::Fast => {
                let met = intersector.surfaces(rays).into_iter();
                met.map(|met| met.map_or(MISS, |met| (met.t, met.sphere, met.normal))).collect()
            }
            EngineName::Reference | EngineName::Path => rays.iter().map(one_by_one).collect(),
        }
    };
    rays.par_chunks(RAYS_AT_ONCE).flat_map_iter(some).collect()
}
