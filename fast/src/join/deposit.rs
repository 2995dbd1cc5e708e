//! A deposit: a photon at a diffuse surface, before and after it is sorted.

use bytemuck::{Pod, Zeroable};
use scene::ray::SphereId;

/// The bit of a deposit's surface that says that the photon is safe: it arrives on the visible side for every visible
/// point on the same sphere within the largest radius, so the join need not test the side.
pub(crate) const SAFE: u32 = 1 << 31;

/// The bit of a deposit's surface that says that the photon is heavy: its flux has an exponent above 0. Only aimed photons
/// are. A surface with this bit is none that visible points share ([`safe_surface`]), so such photons come to where the
/// side is tested, and all others are spared the question.
pub(crate) const HEAVY: u32 = 1 << 30;

/// The bits of a surface that name the sphere.
pub(crate) const SPHERE: u32 = HEAVY - 1;

/// The bits above those of the first channel's units that hold the exponent of a heavy flux.
pub(crate) const EXPONENT_SHIFT: i32 = 24;

/// The flux of a deposit: `reference::photon_pass::Flux`.
#[derive(Clone, Copy)]
pub(crate) struct Flux {
    pub(crate) units: [u32; 3],
    pub(crate) shift: u32,
}

impl Flux {
    /// As [`Record::flux`] has it.
    pub(crate) fn pack(self) -> [f32; 3] {
        let [r, g, b] = self.units;
        [r | self.shift << EXPONENT_SHIFT, g, b].map(f32::from_bits)
    }

    pub(crate) fn unpack(packed: [f32; 3]) -> Self {
        let [r, g, b] = packed.map(f32::to_bits);
        Self { units: [r & ((1 << EXPONENT_SHIFT) - 1), g, b], shift: r >> EXPONENT_SHIFT }
    }
}

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
    /// The sphere, and perhaps [`SAFE`] and [`HEAVY`].
    pub(crate) surface: u32,
    /// Integer fluxes ([`Flux`]), as the bits of floats: so they can be broadcast from memory, where integers would pass
    /// through a scalar register.
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
