//! The update of pixels at the end of an iteration.

use crate::vector::{F, Vector};
use lanes::{Lanes, MOST_LANES};

/// The share of new photons that is kept, as in the reference.
const ALPHA: f32 = 2.0 / 3.0;

/// The values of pixels that change at the end of an iteration.
pub(crate) struct Gathered<V: Vector> {
    pub(crate) tau: V,
    pub(crate) n: F<V>,
    pub(crate) radius_squared: F<V>,
}

impl<V: Vector> Gathered<V> {
    /// `N' = N + alpha M`, `R'^2 = R^2 (N + alpha M) / (N + M)`, `tau' = (tau + attenuation phi) R'^2 / R^2`, as
    /// `reference::consolidate`, for one pixel per lane.
    #[inline(always)]
    pub(crate) fn consolidated(self, attenuation: V, sums: &[[f32; 4]; MOST_LANES]) -> Self {
        let (mut m, mut flux) = ([0.0; MOST_LANES], [[0.0; MOST_LANES]; 3]);
        for lane in 0..V::L::N {
            [flux[0][lane], flux[1][lane], flux[2][lane], m[lane]] = sums[lane];
        }
        let m = V::L::load(&m);
        let phi = V::new(V::L::load(&flux[0]), V::L::load(&flux[1]), V::L::load(&flux[2]));
        let n = self.n + V::L::f(ALPHA) * m;
        let ratio = n / (self.n + m);
        let tau = (self.tau + attenuation * phi).scale(ratio);
        let counts = V::L::lt(V::L::f(0.0), m);
        Self {
            tau: V::select(counts, tau, self.tau),
            n: V::L::select(counts, n, self.n),
            radius_squared: V::L::select(counts, self.radius_squared * ratio, self.radius_squared),
        }
    }
}
