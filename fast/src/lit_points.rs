//! Points of a stage that ask for a lamp, and the shadow rays from them.

use crate::direct_light::{LightTable, Receivers, ShadowNumbers, ShadowRays};
use crate::hierarchy::SearchBuffers;
use crate::paths::{ROOM, Vectors, Words};
use crate::prepared::Prepared;
use lanes::{Lanes, V3};

/// The points, in any order.
pub(crate) struct LitPoints {
    pub(crate) point: Vectors,
    normal: Vectors,
    sphere: Words,
    /// The number of the path that asks.
    pub(crate) slot: Words,
    /// The uniform numbers of the shadow ray: for the choice of a light, and for the point on it.
    numbers: Vectors,
    pub(crate) shadows: ShadowRays,
    pub(crate) count: usize,
}

impl LitPoints {
    pub(crate) fn new() -> Box<Self> {
        Box::new(Self {
            point: Vectors::ZERO,
            normal: Vectors::ZERO,
            sphere: [0; ROOM],
            slot: [0; ROOM],
            numbers: Vectors::ZERO,
            shadows: ShadowRays::new(),
            count: 0,
        })
    }

    /// Appends the lanes of `to` that hold a point.
    #[inline(always)]
    pub(crate) fn append<L: Lanes>(&mut self, to: &Receivers<L>, slot: L::U, numbers: V3<L>) {
        let (m, at) = (to.live, self.count);
        self.point.compress(m, to.point, at);
        self.normal.compress(m, to.normal, at);
        L::compress_u(m, to.sphere, &mut self.sphere[at..]);
        L::compress_u(m, slot, &mut self.slot[at..]);
        self.numbers.compress(m, numbers, at);
        self.count += L::mask_bits(m).count_ones() as usize;
    }

    /// Sends a shadow ray from each point.
    #[inline(always)]
    pub(crate) fn ask<L: Lanes>(&mut self, prepared: &Prepared, search: &mut SearchBuffers) {
        let Prepared { tables, lights, .. } = prepared;
        self.aim::<L::Pair>(lights);
        self.shadows.follow::<L>(tables, &self.point, &self.sphere, search, self.count, false);
    }

    /// Aims the rays.
    #[inline(always)]
    fn aim<L: Lanes>(&mut self, lights: &LightTable) {
        for at in (0..self.count).step_by(L::N) {
            let V3 { x: choice, y: u, z: v } = self.numbers.load::<L>(at);
            let receivers = Receivers {
                live: L::first(self.count - at),
                point: self.point.load::<L>(at),
                normal: self.normal.load::<L>(at),
                sphere: L::load_u(&self.sphere[at..]),
            };
            self.shadows.aim(at, lights, &receivers, &ShadowNumbers { choice, u, v });
        }
    }
}
