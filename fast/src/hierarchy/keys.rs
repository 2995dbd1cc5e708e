//! Keys of hits: integers whose minimum is the nearest hit.
//!
//! A key is the distance in the high half and the sphere in the low half. Distances are not negative, so their bits order
//! as they do, and keys order as the contract demands: by distance, and of equal distances the lower sphere first.

use scene::ray::SphereId;

/// The key of a hit on `sphere` at the distance with these bits.
#[inline(always)]
pub(crate) fn key(distance: u32, sphere: SphereId) -> u64 {
    u64::from(distance) << 32 | u64::from(sphere)
}

/// The key of a hit; a distance of minus zero counts as zero.
#[inline(always)]
pub(crate) fn hit_key(t: f32, sphere: SphereId) -> u64 {
    key((t + 0.0).to_bits(), sphere)
}

/// The key that is greater than those of all hits nearer than `t`, and than no others.
#[inline(always)]
pub(crate) fn limit_key(t: f32) -> u64 {
    key(if t > 0.0 { t.to_bits() } else { 0 }, 0)
}

/// The distance of a key.
#[inline(always)]
pub(crate) fn key_distance(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}
