//! A deposit: a photon at a diffuse surface, before and after it is sorted.

use bytemuck::{Pod, Zeroable};
use scene::ray::SphereId;

/// The bit of a deposit's surface that says that the photon is safe: it arrives on the visible side for every visible
/// point on the same sphere within the largest radius, so the join need not test the side.
pub(crate) const SAFE: u32 = 1 << 31;

/// What a visible point on `sphere` shares with the surface of photons that are safe for it.
#[inline(always)]
pub(crate) fn safe_surface(sphere: SphereId) -> u32 {
    sphere | SAFE
}

/// A deposit as the photon pass writes it.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Record {
    pub(crate) point: [f32; 3],
    /// The sphere, and perhaps [`SAFE`].
    pub(crate) surface: u32,
    /// Integer fluxes, as the bits of floats: so they can be broadcast from memory, where integers would pass through a
    /// scalar register.
    pub(crate) flux: [f32; 3],
    /// The bucket of the join's cells that the point falls into.
    pub(crate) bucket: u32,
}

/// The direction that a photon comes from; the last word is unused.
pub(crate) type Direction = [f32; 4];

/// What a sorted deposit brings to a visible point that it is near. Points are apart, see
/// [`Sorted`](super::sorted::Sorted).
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Arrival {
    /// As [`Record::surface`].
    pub(crate) surface: u32,
    /// As [`Record::flux`].
    pub(crate) flux: [f32; 3],
    /// The direction that the photon comes from.
    pub(crate) wi: [f32; 3],
    /// As [`Record::bucket`].
    pub(crate) bucket: u32,
}

impl Record {
    /// What the deposit brings, once its direction is known.
    ///
    /// By words, which the compiler moves as vectors; field by field it took ten instructions more.
    #[inline]
    pub(crate) fn arrival(self, [wx, wy, wz, _]: Direction) -> Arrival {
        let [_, _, _, surface, r, g, b, bucket]: [f32; 8] = bytemuck::cast(self);
        bytemuck::cast([surface, r, g, b, wx, wy, wz, bucket])
    }
}
