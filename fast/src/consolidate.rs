//! `reference::consolidate`, in lanes and at the end.

use crate::camera_pass::PixelRows;
use crate::join::GROUP;
use crate::join::gather::Sums;
use crate::lanes::{Lanes, MOST_LANES, Row};
use crate::vec3::V3;
use scene::film::FLUX_ONE;
use scene::{Rgb, Settings};
use std::f32::consts::PI;

/// As in the reference.
const ALPHA: f32 = 2.0 / 3.0;

/// A pixel's words: direct light r g b, tau r g b, N, squared radius.
pub(crate) fn new_pixel(initial_radius: f32) -> Row {
    Row([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, initial_radius * initial_radius])
}

/// Takes in what a group has gathered in one iteration, and its direct light.
#[inline(always)]
pub(crate) fn consolidate_group<L: Lanes>(pixels: &mut [Row], rows: &[PixelRows], sums: &Sums, nominal: f32) {
    let unit = L::f(nominal / FLUX_ONE as f32);
    for at in (0..GROUP).step_by(L::N) {
        let visible: [Row; MOST_LANES] = std::array::from_fn(|i| rows[at + i % L::N].visible);
        let light: [Row; MOST_LANES] = std::array::from_fn(|i| rows[at + i % L::N].light);
        let [_, _, _, _, beta_r, beta_g, beta_b, _] = L::load_rows(&visible);
        let [_, _, _, direct_r, direct_g, direct_b, _, _] = L::load_rows(&light);
        let [dr, dg, db, tr, tg, tb, n, radius_squared] = L::load_rows(&pixels[at..]);
        let direct = V3::<L>::new(dr, dg, db) + V3::new(direct_r, direct_g, direct_b);
        let counted = L::load_u(&sums.m[at..]);
        let m = L::to_float(counted);
        let new_n = n + L::f(ALPHA) * m;
        let ratio = new_n / (n + m);
        let flux = |channel: usize| {
            let exact: [f32; MOST_LANES] =
                std::array::from_fn(|i| sums.flux[channel][at + i % L::N] as i64 as f64 as f32);
            L::load(&exact) * unit
        };
        let phi = V3::<L>::new(flux(0), flux(1), flux(2));
        let old = V3::<L>::new(tr, tg, tb);
        let tau = (old + V3::new(beta_r, beta_g, beta_b) * phi).scale(ratio);
        let nothing = L::eq(counted, L::u(0));
        let tau = V3::select(nothing, old, tau);
        let n = L::select(nothing, n, new_n);
        let radius_squared = L::select(nothing, radius_squared, radius_squared * ratio);
        L::transpose(
            [
                direct.x,
                direct.y,
                direct.z,
                tau.x,
                tau.y,
                tau.z,
                n,
                radius_squared,
            ],
            &mut pixels[at..],
        );
    }
}

/// Radiance of a pixel, as `reference::consolidate::Pixel::develop`.
pub(crate) fn develop(pixel: &Row, settings: &Settings, iterations: u32) -> Rgb {
    let [dr, dg, db, tr, tg, tb, _, radius_squared] = pixel.0;
    let n = iterations as f32;
    let photons = n * settings.photons_per_iteration as f32;
    let density = 1.0 / (photons * (PI * radius_squared));
    Rgb::new(dr, dg, db) * (1.0 / n) + Rgb::new(tr, tg, tb) * density
}
