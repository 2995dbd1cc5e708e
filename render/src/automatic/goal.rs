//! How far each quality goes.

use scene::Quality;

/// The noise to reach, and the work that may be spent on it.
pub(super) struct Goal {
    /// Root of the relative mean square error of pixels.
    pub(super) noise: f64,
    /// In units of a ray segment among few spheres.
    pub(super) work: f64,
    /// The share of light that may be lost by a finite depth.
    pub(super) loss: f64,
    /// The first radius, in footprints of a pixel. With a 64th of the work, the best radius is twice as large: bias grows
    /// as its fourth power, noise falls as its square.
    pub(super) radius: f32,
}

impl Goal {
    pub(super) fn of(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Self { noise: 0.08, work: 2e7, loss: 0.02, radius: 6.5 },
            Quality::Good | Quality::Paper => Self { noise: 0.02, work: 2e8, loss: 0.005, radius: 4.8 },
            Quality::Final => Self { noise: 0.007, work: 5e9, loss: 0.002, radius: 3.6 },
        }
    }
}
