//! The random numbers by which paths go on: `reference::path_tracer::PathNumbers`.

use crate::eye::{Numbers, TileTable};
use crate::material::kind;
use crate::paths::Packet;
use crate::sampling::next_where;
use lanes::Lanes;

/// Dimensions of a pixel's stratified point that the path tracer uses otherwise than the camera pass.
mod dimension {
    pub(super) const LOBES: [usize; 2] = [8, 10];
    pub(super) const BOUNCE: [usize; 2] = [7, 9];
}

/// What the random numbers of a packet's paths are needed for.
pub(super) struct Choices<L: Lanes> {
    pub(super) arrived: L::M,
    pub(super) is_diffuse: L::M,
    /// The first diffuse surface of the path.
    pub(super) is_first: L::M,
    pub(super) is_glass: L::M,
    /// The first segment from the eye, and the second if no diffuse surface came before.
    pub(super) is_early: [L::M; 2],
}

impl<L: Lanes> Choices<L> {
    /// Where paths of at most `max_depth` segments have `arrived` at materials of this `kind`: whether they have seen a diffuse
    /// surface before, and how many segments may follow this one.
    #[inline(always)]
    pub(super) fn at(arrived: L::M, kind: L::U, (seen_diffuse, rest): (L::M, L::U), max_depth: u32) -> Self {
        let is_diffuse = arrived & L::eq(kind, L::u(kind::DIFFUSE));
        let first = L::eq(rest, L::u(max_depth.wrapping_sub(1)));
        let second = L::eq(rest, L::u(max_depth.wrapping_sub(2)));
        Self {
            arrived,
            is_diffuse,
            is_first: is_diffuse & !seen_diffuse,
            is_glass: arrived & L::eq(kind, L::u(kind::DIELECTRIC)),
            is_early: [first & !seen_diffuse, second & !seen_diffuse],
        }
    }

    /// Two numbers for a direction, of which glass takes the first; anything where none is needed.
    #[inline(always)]
    pub(super) fn numbers(&self, numbers: &Numbers, tiles: &TileTable, p: &mut Packet<L>) -> [L::F; 2] {
        let is_early_glass = self.is_glass & (self.is_early[0] | self.is_early[1]);
        let is_later = self.is_diffuse & !self.is_first;
        let mut u = next_where::<L>(is_later | (self.is_glass & !is_early_glass), &mut p.stream);
        let mut v = next_where::<L>(is_later, &mut p.stream);
        if L::any(self.is_first) {
            let [a, b] = numbers.of_slots::<L, 2>(tiles, dimension::BOUNCE, (self.is_first, p.slot));
            (u, v) = (L::select(self.is_first, a, u), L::select(self.is_first, b, v));
        }
        if L::any(is_early_glass) {
            let [first, second] = numbers.of_slots::<L, 2>(tiles, dimension::LOBES, (is_early_glass, p.slot));
            u = L::select(is_early_glass, L::select(self.is_early[0], first, second), u);
        }
        [u, v]
    }
}
