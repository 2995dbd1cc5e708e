//! Several shadow rays from the first diffuse surface of a path: direct light is their mean, by numbers of their own.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_mean, diffuse, empty_scene, mean, pinhole, render_path, render_sppm, settings,
};
use scene::settings::MAX_LIGHT_SAMPLES;
use scene::{Film, Rgb, Scene, Settings, Vec3};

/// Relative tolerance of the mean over 64 iterations of 16 x 16 pixels that show one point: the stratified noise of the
/// choice between two lamps is below this.
const MEAN: f64 = 2e-3;

/// The albedo of the ball, the distance of the lamps from its top, and their radius.
const ALBEDO: f32 = 0.8;
const DISTANCE: f32 = 5.0;
const LAMP: f32 = 0.5;

/// A ball under a red lamp on one side and a green one on the other, as the eye sees its top.
fn red_and_green() -> Scene {
    let side = |x: f32| Vec3::Z + Vec3::new(0.6 * x, 0.0, 0.8) * DISTANCE;
    empty_scene(pinhole(Vec3::Z * 100.0, Vec3::Z, 1e-4))
        .ball(Vec3::ZERO, 1.0, diffuse(ALBEDO))
        .lamp(side(1.0), LAMP, BLACK, Rgb::X)
        .lamp(side(-1.0), LAMP, BLACK, Rgb::Y)
}

fn many(light_samples: u32, iterations: u32) -> Settings {
    Settings { light_samples, iterations, ..settings(16, 16, 1, 2, 0.01) }
}

type Render = fn(&Scene, &Settings) -> Film;

const ENGINES: [(&str, Render); 2] = [("SPPM", render_sppm), ("path tracer", render_path)];

#[test]
fn their_mean_is_direct_light() {
    let scene = red_and_green();
    // A lamp wholly above the horizon gives the irradiance pi L sin^2(a) cos(t), and the ball reflects albedo / pi of it.
    let radiance = f64::from(ALBEDO) * f64::from(LAMP / DISTANCE).powi(2) * 0.8;
    for (name, render) in ENGINES {
        for samples in [1, 2, 3, 5, MAX_LIGHT_SAMPLES] {
            let film = render(&scene, &many(samples, 64));
            assert_mean(&film, [radiance, radiance, 0.0], MEAN, &format!("{name}, {samples} light samples"));
        }
    }
    tell("physics", 10, "means of several light samples");
}

/// Each counts whatever the others find: in a penumbra, where some reach the lamp and some do not, as anywhere.
#[test]
fn their_mean_is_direct_light_in_a_penumbra() {
    /// Half of at least 2^14 shadow rays bring light, in proportion to a cosine: unrelated ones would deviate by 1 %, and these are
    /// spread evenly.
    const PENUMBRA: f64 = 1e-2;
    // The horizon cuts the lamp in half.
    let scene = empty_scene(pinhole(Vec3::Z * 3.0, Vec3::Z, 0.01))
        .ball(Vec3::ZERO, 1.0, diffuse(ALBEDO))
        .lamp(Vec3::new(10.0, 0.0, 1.0), 5.0, BLACK, Rgb::ONE);
    let sine = 0.5_f64;
    let share = (sine.asin() - sine * (1.0 - sine * sine).sqrt()) / std::f64::consts::PI;
    let radiance = f64::from(ALBEDO) * share;
    for (name, render) in ENGINES {
        for samples in [1, 2, 3, 5, MAX_LIGHT_SAMPLES] {
            let film = render(&scene, &many(samples, 64));
            assert_mean(&film, [radiance; 3], PENUMBRA, &format!("{name}, {samples} light samples"));
        }
    }
    tell("physics", 10, "means of several light samples in a penumbra");
}

/// Shadow rays that share a number would all go to the same lamp.
#[test]
fn each_chooses_its_lamp() {
    let scene = red_and_green();
    for (name, render) in ENGINES {
        let two_colours = |samples| {
            let film = render(&scene, &many(samples, 1));
            film.pixels.iter().filter(|pixel| pixel.x > 0.0 && pixel.y > 0.0).count()
        };
        assert_eq!(two_colours(1), 0, "{name}");
        // Two numbers that are spread evenly are mostly on two sides.
        assert!(two_colours(2) > 16 * 16 / 2, "{name}: {}", two_colours(2));
        assert_eq!(two_colours(MAX_LIGHT_SAMPLES), 16 * 16, "{name}");
    }
    tell("physics", 6, "choices by several light samples");
}

/// Sixteen numbers that were unrelated would divide the variance by sixteen; as they are spread evenly, it falls further.
#[test]
fn noise_falls_as_if_they_were_so_many_paths() {
    let scene = red_and_green();
    for (name, render) in ENGINES {
        let variance = |samples| {
            let film = render(&scene, &many(samples, 1));
            let reds: Vec<f64> = film.pixels.iter().map(|pixel| f64::from(pixel.x)).collect();
            let mean = reds.iter().sum::<f64>() / reds.len() as f64;
            reds.iter().map(|red| (red - mean).powi(2)).sum::<f64>() / reds.len() as f64
        };
        let (one, sixteen) = (variance(1), variance(16));
        assert!(sixteen * 16.0 < one, "{name}: {one:.2e}, {sixteen:.2e}");
    }
    tell("physics", 2, "variances of several light samples");
}

/// Those of all iterations are one sequence: with as many in one iteration as others take iterations for, a pixel has the same
/// shadow rays. (Here all pixels show one point at all times.)
#[test]
fn samples_of_one_iteration_go_on_where_those_of_the_last_ended() {
    /// Roundings of `f32`, and of the point that is seen.
    const ROUNDING: f32 = 1e-5;
    let scene = red_and_green();
    for (name, render) in ENGINES {
        for (samples, iterations) in [(2, 6), (4, 3), (12, 1)] {
            let (one, several) = (render(&scene, &many(1, 12)), render(&scene, &many(samples, iterations)));
            for (a, b) in one.pixels.iter().zip(&several.pixels) {
                let error = (*a - *b).abs().max_element();
                assert!(error <= ROUNDING * a.max_element(), "{name}, {samples} samples: {b}, not {a}");
            }
        }
    }
    tell("physics", 6 * 256, "pixels with the shadow rays of another order");
}

/// However many there are, light that comes by way of other surfaces is the same.
#[test]
fn they_leave_light_that_comes_by_way_of_others_as_it_is() {
    /// Noise of the mean of an image.
    const NOISE: f64 = 0.03;
    let scene = empty_scene(pinhole(Vec3::Z * 3.0, Vec3::ZERO, 60.0))
        .ball(Vec3::ZERO, 4.0, diffuse(0.8))
        .lamp(Vec3::new(0.0, 2.0, 0.0), 0.5, BLACK, Rgb::ONE);
    for (engine, render) in ENGINES {
        let light = |light_samples: u32| {
            let settings = settings(16, 12, 2000, 12, 0.5);
            mean(&render(&scene, &Settings { light_samples, iterations: 200, ..settings }))[0]
        };
        let (one, five) = (light(1), light(5));
        assert!((five / one - 1.0).abs() < NOISE, "{engine}: {five} with five, {one} with one");
    }
}
