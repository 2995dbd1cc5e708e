//! `reference::consolidate`, in lanes and at the end.

use crate::camera_pass::PixelRows;
use crate::join::GROUP;
use crate::join::gather::{Sums, load_pixel_rows};
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
        let (visible, light) = load_pixel_rows::<L>(&rows[at..]);
        let beta = V3::<L>::new(visible[4], visible[5], visible[6]);
        let [dr, dg, db, tr, tg, tb, n, radius_squared] = L::load_rows(&pixels[at..]);
        let direct = V3::<L>::new(dr, dg, db) + V3::new(light[3], light[4], light[5]);
        let counted = L::load_u(&sums.m[at..]);
        let m = L::to_float(counted);
        let new_n = n + L::f(ALPHA) * m;
        let ratio = new_n / (n + m);
        let phi = V3::new(
            exact_float::<L>(&sums.flux[0][at..]) * unit,
            exact_float::<L>(&sums.flux[1][at..]) * unit,
            exact_float::<L>(&sums.flux[2][at..]) * unit,
        );
        let old = V3::<L>::new(tr, tg, tb);
        let tau = (old + beta * phi).scale(ratio);
        let nothing = L::eq(counted, L::u(0));
        let tau = V3::select(nothing, old, tau);
        let n = L::select(nothing, n, new_n);
        let radius_squared = L::select(nothing, radius_squared, radius_squared * ratio);
        L::transpose(
            [direct.x, direct.y, direct.z, tau.x, tau.y, tau.z, n, radius_squared],
            &mut pixels[at..],
        );
    }
}

/// Sums as floats, rounded once (below 2^53 an `f64` holds them exactly).
#[inline(always)]
fn exact_float<L: Lanes>(sums: &[u64]) -> L::F {
    let mut floats = [0.0; MOST_LANES];
    for k in 0..L::N {
        floats[k] = sums[k] as i64 as f64 as f32;
    }
    L::load(&floats)
}

/// Radiance of a pixel, as `reference::consolidate::Pixel::develop`.
pub(crate) fn develop(pixel: &Row, settings: &Settings, iterations: u32) -> Rgb {
    let [dr, dg, db, tr, tg, tb, _, radius_squared] = pixel.0;
    let n = iterations as f32;
    let photons = n * settings.photons_per_iteration as f32;
    let density = 1.0 / (photons * (PI * radius_squared));
    Rgb::new(dr, dg, db) * (1.0 / n) + Rgb::new(tr, tg, tb) * density
}
