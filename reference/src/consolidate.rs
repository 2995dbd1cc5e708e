//! The statistics of progressive photon mapping per pixel: `consolidate` adds the photons of an iteration, `develop`
//! computes radiance.

use scene::film::FluxUnit;
use scene::{Rgb, Settings};
use std::f32::consts::PI;

/// The share of new photons that is kept (Hachisuka and Jensen 2009): the smaller, the faster the radius shrinks.
pub const ALPHA: f32 = 2.0 / 3.0;

/// The state of a pixel, accumulated over all iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// The radiance of direct light, summed over all iterations.
    pub direct: Rgb,
    /// Flux within the current radius times the BRDF, in W sr^-1 times photons.
    pub tau: Rgb,
    /// `N`: photons counted so far, weighted by alpha.
    pub n: f32,
    /// Square of the search radius, in square scene units.
    pub radius_squared: f32,
}

/// The photons that one iteration adds to a visible point. The sums are integers, so they do not depend on the order
/// of addition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gathered {
    /// `M`: the number of photons.
    pub m: u32,
    /// The sums of their fluxes, in the unit of [`Flux::values`](crate::photon_pass::Flux::values).
    pub flux: [u128; 3],
}

impl Gathered {
    /// The sum of fluxes in W.
    fn power(&self, unit: FluxUnit) -> Rgb {
        Rgb::from_array(self.flux.map(|sum| (sum as f64) as f32 * unit.part * unit.nominal))
    }
}

impl Pixel {
    /// A pixel before the first iteration.
    pub fn new(initial_radius: f32) -> Self {
        let radius_squared = initial_radius * initial_radius;
        Self { direct: Rgb::ZERO, tau: Rgb::ZERO, n: 0.0, radius_squared }
    }

    /// Adds the photons of one iteration (equations 9 to 11 of the paper of 2009):
    /// `N' = N + alpha M`, `R'^2 = R^2 (N + alpha M) / (N + M)`, `tau' = (tau + beta phi) R'^2 / R^2`. The squared
    /// radius of the iteration, `R^2`, is the pixel's own unless that has gathered nothing before.
    pub fn consolidate(&mut self, (beta, radius_squared): (Rgb, f32), gathered: &Gathered, unit: FluxUnit) {
        if gathered.m == 0 {
            return;
        }
        let m = gathered.m as f32;
        let n = self.n + ALPHA * m;
        let ratio = n / (self.n + m);
        self.tau = (self.tau + beta * gathered.power(unit)) * ratio;
        self.radius_squared = radius_squared * ratio;
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

/// With global radii, an iteration's own estimate of a pixel's radiance: `direct + beta phi / (l pi R^2)`, for `photons` that
/// left the lights. As [`Pixel::consolidate`], and the same radius for all pixels.
pub fn estimate(
    direct: Rgb,
    (beta, gathered): (Rgb, &Gathered),
    unit: FluxUnit,
    photons: u32,
    radius_squared: f32,
) -> Rgb {
    if gathered.m == 0 {
        return direct;
    }
    let density = 1.0 / (photons as f32 * (PI * radius_squared));
    direct + beta * gathered.power(unit) * density
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::film::FLUX_ONE;

    fn unit(nominal: f32) -> FluxUnit {
        FluxUnit::new(nominal, 1.0)
    }

    /// Of lamps of a power for which a flux of 1 is less than the least `f32`, where what they send is not.
    #[test]
    fn faint_lamps_keep_their_power() {
        let scale = 2.0_f32.powi(69);
        let gathered = Gathered { m: 1, flux: [u128::from(3 * FLUX_ONE) << 69; 3] };
        for nominal in [1e-36, 1e-30, 1.0, 1e30] {
            assert_eq!(gathered.power(FluxUnit::new(nominal, scale)), Rgb::splat(3.0 * nominal));
        }
    }

    fn gathered(m: u32) -> Gathered {
        Gathered { m, flux: [u128::from(m) * u128::from(FLUX_ONE); 3] }
    }

    /// `N' = N + alpha M`, and the density of photons stays as it was measured.
    #[test]
    fn radius_and_flux_shrink_alike() {
        let mut pixel = Pixel::new(3.0);
        assert_eq!((pixel.radius_squared, pixel.n), (9.0, 0.0));
        pixel.consolidate((Rgb::ONE, 4.0), &gathered(0), unit(1.0));
        assert_eq!(pixel, Pixel::new(3.0));
        for m in [3, 6] {
            let before = pixel;
            pixel.consolidate((Rgb::ONE, pixel.radius_squared), &gathered(m), unit(2.0));
            let ratio = (before.n + ALPHA * m as f32) / (before.n + m as f32);
            assert_eq!(pixel.n, before.n + ALPHA * m as f32);
            assert_eq!(pixel.radius_squared, before.radius_squared * ratio);
            assert_eq!(pixel.tau, (before.tau + Rgb::splat(2.0 * m as f32)) * ratio);
        }
    }

    /// Both ways to estimate agree on one iteration, but for the shrunk radius, whose density is the same.
    #[test]
    fn an_estimate_is_direct_light_and_flux_over_the_disk() {
        let settings = Settings { photons_per_iteration: 10, ..Settings::default() };
        let (direct, beta) = (Rgb::splat(0.5), Rgb::new(1.0, 0.5, 0.0));
        let found = estimate(direct, (beta, &gathered(4)), unit(3.0), 10, 2.0);
        let density = 12.0 / (10.0 * PI * 2.0);
        assert!((found - (direct + beta * density)).abs().max_element() < 1e-6, "{found}");
        assert_eq!(estimate(direct, (beta, &gathered(0)), unit(3.0), 10, 2.0), direct);
        let mut pixel = Pixel { direct, ..Pixel::new(2.0_f32.sqrt()) };
        pixel.consolidate((beta, 2.0), &gathered(4), unit(3.0));
        assert!((pixel.develop(&settings, 1) - found).abs().max_element() < 1e-6);
        // Of two iterations, of which the second brought nothing, it is half.
        assert!((pixel.develop(&settings, 2) - found * 0.5).abs().max_element() < 1e-6);
    }
}
