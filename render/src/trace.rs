//! Intersects rays with a scene at one instant.

use crate::choice::EngineChoice;
use crate::names::EngineName;
use fast::Intersector;
use rayon::prelude::*;
use reference::intersect::intersect;
use scene::ray::{NO_SPHERE, SphereId};
use scene::{Ray, Still, Vec3};

/// Rays per work item.
const RAYS_AT_ONCE: usize = 1 << 14;
/// The result for a ray that hits nothing.
const MISS: (f32, SphereId, Vec3) = (f32::INFINITY, NO_SPHERE, Vec3::ZERO);

/// Distance in scene units, sphere and unit normal of the nearest hit of each ray, computed on the current rayon pool.
/// A miss has an infinite distance. Every engine gives the same bits.
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
