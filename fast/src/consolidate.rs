//! Consolidation: adds an iteration's photons to what pixels have gathered, and shrinks their radii.
//! `reference::consolidate`, in lanes.

use crate::join::RadiiSums;
use crate::join::sums::GroupSums;
use crate::pixels::{GROUP, GroupColumns, Pixel, PixelLanes, PixelRow, PixelRowLanes};
use lanes::{Lanes, MOST_LANES, V3};
use scene::film::FluxUnit;
use scene::{Rgb, Settings};
use std::f32::consts::PI;

/// The share of new photons that is kept, as in the reference.
const ALPHA: f32 = 2.0 / 3.0;

/// Consolidates a group: adds its direct light and what it has gathered in one iteration. Adds the radii that follow to
/// `radii`.
#[inline(always)]
pub(crate) fn consolidate_group<L: Lanes>(
    pixels: &mut [Pixel],
    (rows, columns): (&[PixelRow], &GroupColumns),
    sums: &GroupSums,
    unit: FluxUnit,
    radii: &mut RadiiSums,
) {
    for at in (0..GROUP).step_by(L::N) {
        let new = PixelRowLanes::<L>::load(&rows[at..]);
        let old = PixelLanes::<L>::load(&pixels[at..]);
        let counted = L::load_u(&sums.m[at..]);
        let m = L::to_float(counted);
        let n = old.n + L::f(ALPHA) * m;
        let ratio = n / (old.n + m);
        let phi = phi_of::<L>(sums, at, unit);
        let tau = (old.tau + new.beta * phi).scale(ratio);
        let nothing = L::eq(counted, L::u(0));
        let pixel = PixelLanes {
            direct: old.direct + columns.direct(at),
            tau: V3::select(nothing, old.tau, tau),
            n: L::select(nothing, old.n, n),
            radius_squared: L::select(nothing, old.radius_squared, new.radius_squared * ratio),
        };
        radii.add::<L>(at, pixel.n, pixel.radius_squared);
        pixel.store(&mut pixels[at..]);
    }
}

/// With global radii: writes to the pixels what they gain in one iteration, radiance in place of direct light and the bits of
/// the count of photons in place of `n`. `density` is 1 over the area of the search disc and the photons that left the lights.
/// `reference::consolidate::estimate`, in lanes.
#[inline(always)]
pub(crate) fn estimate_group<L: Lanes>(
    pixels: &mut [Pixel],
    (rows, columns): (&[PixelRow], &GroupColumns),
    sums: &GroupSums,
    unit: FluxUnit,
    density: f32,
) {
    for at in (0..GROUP).step_by(L::N) {
        let new = PixelRowLanes::<L>::load(&rows[at..]);
        let old = PixelLanes::<L>::load(&pixels[at..]);
        let counted = L::load_u(&sums.m[at..]);
        let phi = phi_of::<L>(sums, at, unit);
        let direct = columns.direct::<L>(at);
        let radiance = direct + (new.beta * phi).scale(L::f(density));
        let pixel = PixelLanes {
            direct: V3::select(L::eq(counted, L::u(0)), direct, radiance),
            n: L::from_bits(counted),
            ..old
        };
        pixel.store(&mut pixels[at..]);
    }
}

/// The density of an iteration with global radii; see [`estimate_group`].
pub(crate) fn density(photons: u32, radius_squared: f32) -> f32 {
    1.0 / (photons as f32 * (PI * radius_squared))
}

/// The power that the pixels from `at` on have gathered, in W.
#[inline(always)]
fn phi_of<L: Lanes>(sums: &GroupSums, at: usize, unit: FluxUnit) -> V3<L> {
    V3::new(
        power_of::<L>(sums, 0, at, unit),
        power_of::<L>(sums, 1, at, unit),
        power_of::<L>(sums, 2, at, unit),
    )
}

/// The same in one channel. A function, as a closure would be called, with its vectors in memory.
#[inline(always)]
fn power_of<L: Lanes>(sums: &GroupSums, channel: usize, at: usize, unit: FluxUnit) -> L::F {
    let mut fluxes = [0.0; MOST_LANES];
    sums.rounded(channel, at, &mut fluxes[..L::N]);
    L::load(&fluxes) * L::f(unit.part) * L::f(unit.nominal)
}

/// Radiance of a pixel, as `reference::consolidate::Pixel::develop`.
#[inline(always)]
pub(crate) fn develop(pixel: &Pixel, settings: &Settings, iterations: u32) -> Rgb {
    let n = iterations as f32;
    let photons = n * settings.photons_per_iteration as f32;
    let density = 1.0 / (photons * (PI * pixel.radius_squared));
    Rgb::from_array(pixel.direct) * (1.0 / n) + Rgb::from_array(pixel.tau) * density
}
