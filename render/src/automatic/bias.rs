//! Estimates the bias of photon mapping: how much the image is wrong as light is blurred over the search radius.
//!
//! To leading order the bias of a pixel grows with the mean square of its radii (Knaus and Zwicker 2011, section 4). So two
//! radii tell it: pilots with the first radius and with half of it, and the same random numbers, differ by three quarters
//! of the bias of the larger, and by noise that many of them average out. What they differ by on the average is squared, and
//! the variance of that average subtracted, so that noise is not taken for bias.
//!
//! ```text
//! d      = mean over pilots of I(R) - I(R/2), for each block
//! bias^2 = (4/3)^2 mean over blocks of (d^2 - variance(d) / pilots) / (I^2 + epsilon)
//! ```

use super::pilot::{Pilot, blocks};
use super::pilots::Pilots;
use crate::names::MethodName;
use fast::{LaneKind, first_radii_for};
use scene::film::RELATIVE_MSE_EPSILON;
use scene::still::Carried;
use scene::{FirstRadii, Rgb, Scene, Settings, Stop};

/// Pilots with each radius.
const SEEDS: u64 = 8;
/// Images in memory at the same time, more than of any other pilots.
pub(super) const FILMS: u64 = 2 * SEEDS;
/// Photons per pixel of a pilot, and the least: enough that blocks of few pixels are not lost in noise.
const PHOTONS: (u32, u32) = (4, 1 << 14);
/// The side of a block in pixels of a pilot. The bias varies from pixel to pixel at the rims of caustics; smaller blocks are
/// too noisy to tell.
const SIDE: usize = 2;

/// The bias of a render at its first radii.
pub(crate) struct Bias {
    /// The root of its mean square over blocks, each relative as in [`crate::Estimate`].
    pub(crate) relative: f64,
    pub(crate) radii: FirstRadii,
}

/// The bias at the first radii of the scene's settings; `None` if stopped.
pub(crate) fn first_bias(
    scene: &Scene,
    (method, lanes): (MethodName, LaneKind),
    stop: &Stop,
) -> Option<Bias> {
    let pilots = Pilots::large(scene, &scene.settings, lanes, stop).by(method);
    let carried = if method == MethodName::Hybrid { Carried::Caustics } else { Carried::All };
    let photons = photons(&pilots.settings);
    let radii = match scene.settings.radius_pilots {
        0 => FirstRadii::even(scene.settings.initial_radius),
        _ => first_radii_for((scene, carried), &scene.settings, lanes, stop)?,
    };
    let of = |scale| pilots.run_with(SEEDS, photons, (&radii, &scene.settings), scale);
    let (wide, narrow) = (of(1.0)?, of(0.5)?);
    Some(Bias { relative: bias(&wide, &narrow), radii })
}

/// The photons of a pilot with these settings.
fn photons(pilot: &Settings) -> u32 {
    let (per_pixel, least) = PHOTONS;
    (per_pixel * pilot.pixels() as u32).max(least)
}

/// The relative bias of the images of `wide`, if those of `narrow` have half the radius and the same random numbers.
fn bias(wide: &Pilot, narrow: &Pilot) -> f64 {
    let all =
        |pilot: &Pilot| -> Vec<Vec<Rgb>> { pilot.films.iter().map(|film| blocks(film, SIDE)).collect() };
    let (wide, narrow) = (all(wide), all(narrow));
    let count = wide.len() as f64;
    let (mut sum, places) = (0.0, wide[0].len());
    for place in 0..places {
        for channel in 0..3 {
            let value = |image: &Vec<Rgb>| f64::from(image[place][channel]);
            let mean = wide.iter().map(value).sum::<f64>() / count;
            let differences = || wide.iter().zip(&narrow).map(|(a, b)| value(a) - value(b));
            let difference = differences().sum::<f64>() / count;
            let squares: f64 = differences().map(|d| d - difference).map(|d| d * d).sum();
            let noise = squares / (count - 1.0) / count;
            let term = (difference * difference - noise) / (mean * mean + RELATIVE_MSE_EPSILON);
            if term.is_finite() {
                sum += term;
            }
        }
    }
    // Noise may leave less than nothing.
    4.0 / 3.0 * (sum / (3 * places) as f64).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Film, Stats};

    fn pilot(values: &[f32]) -> Pilot {
        let film = |&value: &f32| Film { width: 4, height: 4, pixels: vec![Rgb::splat(value); 16] };
        Pilot { films: values.iter().map(film).collect(), stats: Stats::default() }
    }

    /// Images of 1.2 and 1.05 for a truth of 1: biases of 0.2 and 0.05, four times less at half the radius.
    #[test]
    fn two_radii_tell_the_bias() {
        let found = bias(&pilot(&[1.2; 8]), &pilot(&[1.05; 8]));
        let exact = 0.2 / (1.2_f64 * 1.2 + RELATIVE_MSE_EPSILON).sqrt();
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} for {exact}");
    }

    /// Differences of noise alone, which are zero on the average, are not taken for bias.
    #[test]
    fn noise_is_no_bias() {
        let wide = pilot(&[1.1, 0.9, 1.2, 0.8, 1.1, 0.9, 1.0, 1.0]);
        assert_eq!(bias(&wide, &pilot(&[1.0; 8])), 0.0);
    }

    /// Blocks have two pixels along a side: what makes up for each other within them is no bias, and what does not, is.
    #[test]
    fn the_bias_is_that_of_small_blocks() {
        let of = |is_bright: fn(usize, usize) -> bool| {
            let at = |i: usize| Rgb::splat(if is_bright(i % 4, i / 4) { 1.5 } else { 0.5 });
            let film = Film { width: 4, height: 4, pixels: (0..16).map(at).collect() };
            let wide = Pilot { films: vec![film; 8], stats: Stats::default() };
            bias(&wide, &pilot(&[1.0; 8]))
        };
        let stripes = [of(|x, _| x.is_multiple_of(2)), of(|_, y| y.is_multiple_of(2))];
        assert_eq!(stripes, [0.0; 2]);
        assert!(of(|x, _| x < 2) > 0.1 && of(|_, y| y < 2) > 0.1);
    }

    /// To leading order it grows as the square of the radius, 16 times from 4 to 16. Far less is asked for, as blocks of few
    /// pixels are noisy, and a radius of 16 is wider than the caustic.
    #[test]
    fn a_wider_radius_has_more_bias() {
        let scene = files::builtin::scene("cornell").unwrap();
        let of = |radius: f32| {
            let settings =
                Settings { width: 64, height: 48, initial_radius: radius, max_depth: 16, ..scene.settings };
            first_bias(
                &Scene { settings, ..scene.clone() },
                (MethodName::Sppm, LaneKind::best()),
                &Stop::new(),
            )
            .unwrap()
            .relative
        };
        let (wide, narrow) = (of(16.0), of(4.0));
        assert!(wide > 2.0 * narrow, "{wide} and {narrow}");
    }

    /// By clearance radii are narrow where light changes fast, and so is the bias; and half of them are half as wide there too.
    /// In smaller images noise is as large as the bias that is left.
    #[test]
    fn clearance_makes_the_bias_less() {
        let scene = files::builtin::scene("mirror").unwrap();
        let of = |radius_clearance: f32| {
            let settings = Settings {
                width: 128,
                height: 96,
                initial_radius: 10.0,
                max_depth: 16,
                radius_clearance,
                ..scene.settings
            };
            first_bias(
                &Scene { settings, ..scene.clone() },
                (MethodName::Sppm, LaneKind::best()),
                &Stop::new(),
            )
            .unwrap()
            .relative
        };
        let (without, wide, narrow) = (of(0.0), of(1000.0), of(0.5));
        // A thousandth of the radius away from another surface is where hardly a pixel looks.
        assert!((wide / without - 1.0).abs() < 1e-3 && narrow < 0.5 * without, "{without}, {wide}, {narrow}");
    }

    /// Path tracing with photons for caustics has the bias of these alone: none at all where nothing is smooth.
    #[test]
    fn the_bias_is_of_the_light_that_photons_carry() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        let diffuse = scene.materials.len() as u32;
        scene.materials.push(scene::Material::Diffuse { albedo: Rgb::splat(0.5) });
        scene.spheres.iter_mut().for_each(|sphere| sphere.material = diffuse);
        (scene.settings.width, scene.settings.height, scene.settings.initial_radius) = (32, 24, 16.0);
        let of = |method| first_bias(&scene, (method, LaneKind::best()), &Stop::new()).unwrap().relative;
        let (photons, hybrid) = (of(MethodName::Sppm), of(MethodName::Hybrid));
        assert!(hybrid == 0.0 && photons > 0.0, "{photons} and {hybrid}");
    }

    #[test]
    fn photons_are_as_many_as_pixels_ask_for_but_not_too_few() {
        let of = |width, height| photons(&Settings { width, height, ..Settings::default() });
        assert_eq!([of(1, 1), of(64, 64), of(65, 64), of(256, 192)], [16_384, 16_384, 16_640, 196_608]);
    }

    /// With both radii, which begin as those of the settings.
    #[test]
    fn the_bias_is_found_with_enough_photons() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        (scene.settings.width, scene.settings.height) = (8, 6);
        let (lanes, stop) = (LaneKind::best(), Stop::new());
        let found = first_bias(&scene, (MethodName::Sppm, lanes), &stop).unwrap();
        assert_eq!(found.radii, FirstRadii::even(scene.settings.initial_radius));
        let pilots = Pilots::large(&scene, &scene.settings, lanes, &stop);
        let of = |scale| pilots.run_with(SEEDS, PHOTONS.1, (&found.radii, &scene.settings), scale).unwrap();
        assert_eq!(found.relative, bias(&of(1.0), &of(0.5)));
        let stopped = Stop::new();
        stopped.request();
        assert!(first_bias(&scene, (MethodName::Sppm, lanes), &stopped).is_none());
    }

    /// Differences of 0.2, 0.3 and 0.7: 0.4 on the average, whose variance is a third of 0.07.
    #[test]
    fn the_variance_of_the_mean_is_taken_away() {
        let found = bias(&pilot(&[1.2, 1.3, 1.7]), &pilot(&[1.0; 3]));
        let squared = (0.16 - 0.07 / 3.0) / (1.4_f64 * 1.4 + RELATIVE_MSE_EPSILON);
        assert!((found / (4.0 / 3.0 * squared.sqrt()) - 1.0).abs() < 1e-6, "{found}");
    }
}
