//! Consolidate and develop: the statistics of progressive photon mapping, per pixel.

use scene::film::FLUX_ONE;
use scene::{Rgb, Settings};
use std::f32::consts::PI;

/// The share of new photons that is kept (Hachisuka and Jensen 2009): the smaller, the faster the radius shrinks.
pub const ALPHA: f32 = 2.0 / 3.0;

/// What a pixel has gathered over all iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Sum of the direct light of all iterations, radiance.
    pub direct: Rgb,
    /// Flux within the current radius times the BRDF, in W sr^-1 times photons.
    pub tau: Rgb,
    /// `N`: photons counted so far.
    pub n: f32,
    /// Square of the search radius, in square scene units.
    pub radius_squared: f32,
}

/// What one iteration's photons bring to a visible point. Integers, so it does not matter who adds them first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// `M`: photons that counted.
    pub m: u32,
    /// Sums of their fluxes, in multiples of the nominal power over `FLUX_ONE`.
    pub flux: [u64; 3],
}

impl Pixel {
    /// A pixel before the first iteration.
    pub fn new(initial_radius: f32) -> Self {
        let radius_squared = initial_radius * initial_radius;
        Self { direct: Rgb::ZERO, tau: Rgb::ZERO, n: 0.0, radius_squared }
    }

    /// Takes in the photons of one iteration (equations 9 to 11 of the paper of 2009):
    /// `N' = N + alpha M`, `R'^2 = R^2 (N + alpha M) / (N + M)`, `tau' = (tau + beta phi) R'^2 / R^2`.
    pub fn consolidate(&mut self, beta: Rgb, gathered: &Gathered, nominal_power: f32) {
        if gathered.m == 0 {
            return;
        }
        let m = gathered.m as f32;
        let n = self.n + ALPHA * m;
        let ratio = n / (self.n + m);
        let unit = nominal_power / FLUX_ONE as f32;
        let [r, g, b] = gathered.flux.map(|sum| (sum as f64) as f32 * unit);
        self.tau = (self.tau + beta * Rgb::new(r, g, b)) * ratio;
        self.radius_squared *= ratio;
        self.n = n;
    }

    /// Radiance after `iterations` iterations: `direct / n + tau / (n l pi R^2)`.
    pub fn develop(&self, settings: &Settings, iterations: u32) -> Rgb {
        let n = iterations as f32;
        let photons = n * settings.photons_per_iteration as f32;
        let density = 1.0 / (photons * (PI * self.radius_squared));
        self.direct * (1.0 / n) + self.tau * density
    }
}
