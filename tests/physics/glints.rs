//! Several rays by which pixels see lamps, directly and in mirrors and glass: their mean is what one path sees, with less noise.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_mean, block_mean, diffuse, empty_scene, glass, mean, mirror, pinhole,
    relative_error, render_path, render_sppm, run, settings,
};
use reference::camera_pass::{CameraNumbers, camera_ray};
use reference::intersect::intersect;
use reference::{PathTracer, Sppm, hybrid};
use scene::settings::MAX_GLINT_SAMPLES;
use scene::{Camera, Film, Filter, Material, Rgb, Rims, Scene, Settings, Vec3};
use std::f64::consts::PI;

type Render = fn(&Scene, &Settings) -> Film;

fn render_hybrid(scene: &Scene, settings: &Settings) -> Film {
    run(hybrid(PathTracer::new(scene, settings), Sppm::new(scene, settings)), settings)
}

const ENGINES: [(&str, Render); 3] =
    [("SPPM", render_sppm), ("path tracer", render_path), ("paths with photons", render_hybrid)];

/// The numbers of rays that are tried.
const SAMPLES: [u32; 4] = [2, 3, 8, MAX_GLINT_SAMPLES];

/// A pixel of side 1 at distance 1 has this vertical field of view, in degrees.
const UNIT_PIXEL: f32 = 53.130_104;

/// Relative tolerance of means over 1024 to 4096 iterations of lamps that cover an eighth of a pixel or less. Of 8192 independent
/// rays, as two in each of 4096 iterations are, the deviation is `sqrt((1 - p) / (8192 p)) = 0.03`; as own paths are stratified, the
/// largest that is met is below that.
const MEAN: f64 = 0.04;

fn many(width: u32, height: u32, depth: u32, glint_samples: u32) -> Settings {
    Settings { iterations: 4096, glint_samples, ..settings(width, height, 1, depth, 0.01) }
}

/// A lamp on the view axis, as large as a circle of this radius on the plane at distance 1.
fn lamp_of(scene: Scene, tangent: f64, color: Rgb) -> Scene {
    let sine = tangent / (1.0 + tangent * tangent).sqrt();
    scene.lamp(Vec3::NEG_Z * 10.0, (10.0 * sine) as f32, BLACK, color)
}

fn looking_down_z(fov: f32) -> Scene {
    empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, fov))
}

/// Around the eye, so that it is met first; of index 1, so that it does nothing but tint.
fn veil(scene: Scene, material: Material) -> Scene {
    scene.ball(Vec3::ZERO, 1.0, material)
}

/// Seen directly, and through glass that tints: the share of the pixel that the lamp covers, times its radiance.
#[test]
fn a_small_lamp_is_as_bright_as_the_share_of_the_pixel_that_it_covers() {
    let tangent = 0.2;
    let color = Rgb::new(3.0, 5.0, 7.0);
    let mut cases = 0;
    for (name, render) in ENGINES {
        for samples in SAMPLES {
            let iterations = 4096.min(32_768 / samples);
            let settings = Settings { iterations, ..many(1, 1, 4, samples) };
            for (tint, scene) in [
                (1.0, lamp_of(looking_down_z(UNIT_PIXEL), tangent, color)),
                (0.5, veil(lamp_of(looking_down_z(UNIT_PIXEL), tangent, color), glass(0.5, 1.0))),
            ] {
                let expected = color.to_array().map(|c| tint * PI * tangent * tangent * f64::from(c));
                assert_mean(&render(&scene, &settings), expected, MEAN, &format!("{name}, {samples} rays"));
                cases += 1;
            }
        }
    }
    tell("physics", cases, "small lamps by several rays");
}

/// A mirror ball of this radius that covers a part of a pixel. The lamp is behind the eye, and so wide that the ball shows it in most
/// directions.
fn mirror_ball(radius: f32) -> Scene {
    let ball = looking_down_z(UNIT_PIXEL).ball(Vec3::NEG_Z * 10.0, radius, mirror(0.5));
    ball.lamp(Vec3::Z * 50.0, 49.0, BLACK, Rgb::ONE)
}

/// A mirror ball that covers a part of a pixel: rays that meet nothing do not count, so what it shows is not dimmed.
#[test]
fn rays_that_meet_no_mirror_do_not_dim_what_it_shows() {
    let scene = mirror_ball(3.0);
    let mut cases = 0;
    for (name, render) in ENGINES {
        let one = mean(&render(&scene, &many(1, 1, 8, 1)))[0];
        for samples in [2, 8] {
            let several = mean(&render(&scene, &many(1, 1, 8, samples)))[0];
            assert!(one > 0.0 && (several / one - 1.0).abs() < MEAN, "{name}: {several}, not {one}");
            cases += 1;
        }
    }
    tell("physics", cases, "mirrors that fill a part of a pixel");
}

/// A mirror ball that reflects nothing beside one that does: its rays count, and bring nothing.
#[test]
fn black_mirrors_count_among_the_rays() {
    let ball = |scene: Scene, x: f32, albedo: f32| scene.ball(Vec3::new(x, 0.0, -10.0), 2.0, mirror(albedo));
    let lamp = looking_down_z(UNIT_PIXEL).lamp(Vec3::Z * 50.0, 49.0, BLACK, Rgb::ONE);
    let scene = ball(ball(lamp, -2.2, 0.0), 2.2, 0.5);
    let mut cases = 0;
    for (name, render) in ENGINES {
        let one = mean(&render(&scene, &many(1, 1, 8, 1)))[0];
        let several = mean(&render(&scene, &many(1, 1, 8, 4)))[0];
        assert!(one > 0.0 && (several / one - 1.0).abs() < MEAN, "{name}: {several}, not {one}");
        cases += 1;
    }
    tell("physics", cases, "black mirrors beside bright ones");
}

/// A ball of glass so large that it is a plane, which shows a lamp by its reflection alone: the share of the pixel that the lamp's
/// image covers, times the reflectance.
#[test]
fn glass_reflects_lamps_by_its_reflectance() {
    let (tangent, mut cases) = (0.2_f64, 0);
    // Straight ahead, where the reflectance is ((n - 1) / (n + 1))^2; the lamp and its image are at distances 10 and 12.
    for ior in [1.2_f32, 1.5, 2.5] {
        let share = ((f64::from(ior) - 1.0) / (f64::from(ior) + 1.0)).powi(2);
        let sine = tangent / (1.0 + tangent * tangent).sqrt();
        let scene = looking_down_z(UNIT_PIXEL).ball(Vec3::NEG_Z * 100_001.0, 1e5, glass(0.5, ior)).lamp(
            Vec3::Z * 10.0,
            (12.0 * sine) as f32,
            BLACK,
            Rgb::ONE,
        );
        let expected = 0.5 * share * PI * tangent * tangent;
        for (name, render) in ENGINES {
            let film = render(&scene, &many(1, 1, 2, 16));
            assert_mean(&film, [expected; 3], MEAN, &format!("{name}, index {ior}"));
            cases += 1;
        }
    }
    tell("physics", cases, "lamps that glass reflects");
}

/// What is met first is seen by the own path alone, also if it glows: the further rays bring what is seen in it.
#[test]
fn mirrors_and_glass_that_glow_are_counted_once() {
    let mut cases = 0;
    for material in [mirror(0.5), glass(0.9, 1.5)] {
        // The ball fills the pixel. Glass shows its own inner side again, so that is compared with one ray.
        let scene = looking_down_z(10.0).lamp(Vec3::NEG_Z * 10.0, 3.0, material, Rgb::new(1.0, 2.0, 4.0));
        for (name, render) in ENGINES {
            let of = |glint_samples| mean(&render(&scene, &many(1, 1, 16, glint_samples)));
            let (one, several) = (of(1), of(4));
            let error = relative_error(several, one);
            assert!(one[0] > 0.9 && error < MEAN, "{name}, {material:?}: {several:?}, not {one:?}");
            cases += 1;
        }
    }
    tell("physics", cases, "mirrors and glass that glow");
}

/// By however many reflections within a ball of glass a lamp is seen: all of them together are as bright as by one ray.
#[test]
fn lamps_by_many_reflections_are_as_with_one_ray() {
    // Wide, behind the ball and to a side, so that light comes by all orders. The ball fills the pixel.
    let scene = looking_down_z(10.0)
        .ball(Vec3::new(0.0, 1.2, -10.0), 3.0, glass(0.9, 1.6))
        .lamp(Vec3::new(30.0, 0.0, -30.0), 20.0, BLACK, Rgb::ONE)
        .lamp(Vec3::new(-20.0, 0.0, 40.0), 30.0, BLACK, Rgb::new(0.5, 1.0, 2.0));
    let mut cases = 0;
    for (name, render) in ENGINES {
        // By one ray a thirtieth of the paths sees a lamp: 2^17 of them deviate by `sqrt(30 / 2^17) = 0.015`.
        let of = |glint_samples, iterations| {
            mean(&render(&scene, &Settings { iterations, ..many(1, 1, 24, glint_samples) }))
        };
        let (one, several) = (of(1, 1 << 17), of(8, 1 << 14));
        let error = relative_error(several, one);
        assert!(one[0] > 0.0 && error < MEAN, "{name}: {several:?}, not {one:?}");
        cases += 1;
    }
    tell("physics", cases, "lamps by many reflections");
}

/// Where no further ray meets the mirror that the own path meets, what that path sees stays.
#[test]
fn what_the_own_path_alone_meets_is_not_lost() {
    // The ball fills a twentieth of the pixel, so of two rays most often none meets it.
    let scene = mirror_ball(1.25);
    let mut cases = 0;
    for (name, render) in ENGINES {
        let settings = |glint_samples| Settings { iterations: 1 << 14, ..many(1, 1, 8, glint_samples) };
        let of = |glint_samples| mean(&render(&scene, &settings(glint_samples)))[0];
        let (one, several) = (of(1), of(2));
        assert!(one > 0.0 && (several / one - 1.0).abs() < MEAN, "{name}: {several}, not {one}");
        cases += 1;
    }
    tell("physics", cases, "mirrors that the own path alone meets");
}

/// Where a lamp covers a part of the pixel, the variance of one iteration is `p (1 - p) L^2 / N`, by the binomial distribution.
#[test]
fn the_variance_is_that_of_so_many_paths() {
    /// A variance of 4096 values that are nearly normal deviates by `sqrt(2 / 4096) = 0.022`, of rare ones by more.
    const VARIANCE: f64 = 0.15;
    let tangent: f64 = 0.2;
    let p = PI * tangent * tangent;
    for is_veiled in [false, true] {
        let mut scene = lamp_of(looking_down_z(UNIT_PIXEL), tangent, Rgb::ONE);
        if is_veiled {
            scene = veil(scene, glass(1.0, 1.0));
        }
        for samples in [4, 16] {
            let values: Vec<f64> = (0..4096)
                .map(|seed| {
                    let settings = Settings { seed, iterations: 1, ..many(1, 1, 3, samples) };
                    mean(&render_path(&scene, &settings))[0]
                })
                .collect();
            let mean = values.iter().sum::<f64>() / 4096.0;
            let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 4095.0;
            let expected = p * (1.0 - p) / f64::from(samples);
            assert!((variance / expected - 1.0).abs() < VARIANCE, "{samples}: {variance}, not {expected}");
        }
    }
    tell("physics", 4, "variances of several rays");
}

/// So it is of the mean over some iterations: their rays are all different, and unrelated.
#[test]
fn the_variance_falls_with_the_iterations_as_with_the_rays() {
    const SEEDS: u32 = 2048;
    /// A variance of 2048 values that are nearly normal deviates by `sqrt(2 / 2048) = 0.031`, of rare ones by a little more. If
    /// iterations shared rays with the next, it would be twice as large and more.
    const VARIANCE: f64 = 0.2;
    let tangent: f64 = 0.2;
    let p = PI * tangent * tangent;
    let scene = lamp_of(looking_down_z(UNIT_PIXEL), tangent, Rgb::ONE);
    for (samples, iterations) in [(4, 4), (16, 2)] {
        let of = |seed: u32| {
            let settings = Settings { seed: seed.into(), iterations, ..many(1, 1, 3, samples) };
            mean(&render_path(&scene, &settings))[0]
        };
        let values: Vec<f64> = (0..SEEDS).map(of).collect();
        let mean = values.iter().sum::<f64>() / f64::from(SEEDS);
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::from(SEEDS - 1);
        let expected = p * (1.0 - p) / f64::from(samples * iterations);
        assert!((variance / expected - 1.0).abs() < VARIANCE, "{samples}: {variance}, not {expected}");
    }
    tell("physics", 2, "variances of several rays of some iterations");
}

/// What glass reflects weakly is followed as often as by the root of its share: of a pixel that shows nothing but a reflected lamp,
/// the variance is `(R^2 / p - R^2) L^2 / N`, with the probability `p` of a reflection.
#[test]
fn the_variance_of_weak_reflections_is_that_by_roots() {
    const SEEDS: u32 = 2048;
    /// As above; were reflections followed by their share, the variance would be five times as large.
    const VARIANCE: f64 = 0.2;
    const SAMPLES: u32 = 8;
    // A plane of glass before the eye, head on, and a lamp behind that is as good as a half space.
    let scene = looking_down_z(10.0).ball(Vec3::NEG_Z * 100_001.0, 1e5, glass(1.0, 1.5)).lamp(
        Vec3::Z * 50.0,
        49.0,
        BLACK,
        Rgb::ONE,
    );
    let of = |seed: u32| {
        let settings = Settings { seed: seed.into(), iterations: 1, ..many(1, 1, 2, SAMPLES) };
        mean(&render_path(&scene, &settings))[0]
    };
    let values: Vec<f64> = (0..SEEDS).map(of).collect();
    let mean = values.iter().sum::<f64>() / f64::from(SEEDS);
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / f64::from(SEEDS - 1);
    let reflected: f64 = 0.04;
    let probability = reflected.sqrt() / (reflected.sqrt() + (1.0 - reflected).sqrt());
    let expected = reflected * reflected * (1.0 / probability - 1.0) / f64::from(SAMPLES);
    assert!((variance / expected - 1.0).abs() < VARIANCE, "{variance}, not {expected}");
    assert!((mean - reflected).abs() < 5.0 * (expected / f64::from(SEEDS)).sqrt(), "{mean}");
    tell("physics", SEEDS as usize, "pixels that show a weak reflection");
}

/// What glows as much as it does not reflect or let through is invisible where there is as much light from everywhere: to every ray,
/// wherever it meets that first or later, and whether it is a rim.
#[test]
fn mirrors_and_glass_that_glow_by_what_they_take_are_invisible() {
    /// Roundings, whose root is what glass of index 1 reflects at grazing angles.
    const ROUNDING: f32 = 1e-3;
    let taken = |albedo: f32| Rgb::splat(1.0 - albedo);
    // A lamp on all sides, which is no enclosure.
    let scene = looking_down_z(40.0)
        .lamp(Vec3::ZERO, 90.0, glass(1.0, 1.0), Rgb::ONE)
        .lamp(Vec3::new(-1.2, 0.0, -6.0), 1.0, mirror(0.5), taken(0.5))
        .lamp(Vec3::new(1.2, 0.3, -6.0), 1.0, glass(0.75, 1.0), taken(0.75));
    for (name, render) in ENGINES {
        for (scene, is_veiled) in [(scene.clone(), false), (veil(scene.clone(), glass(1.0, 1.0)), true)] {
            for samples in [1, 2, 5] {
                let film = render(&scene, &Settings { iterations: 4, ..many(12, 9, 16, samples) });
                let shows = |pixel: &&Rgb| (**pixel - Rgb::ONE).abs().max_element() > ROUNDING;
                let found = film.pixels.iter().find(shows);
                assert_eq!(found, None, "{name}, {samples} rays, behind a veil: {is_veiled}");
            }
        }
    }
    tell("physics", 18, "images of what is invisible");
}

/// Light that is no lamp's, and what paths meet beyond a diffuse surface, is the own path's alone: bit by bit as with one ray.
#[test]
fn the_sky_and_diffuse_surfaces_are_seen_by_the_own_path_alone() {
    // The lamp is behind the eye, and a ball hides it from all that is before it.
    let scene = Scene { background: Rgb::new(0.5, 0.75, 1.0), ..looking_down_z(40.0) }
        .ball(Vec3::new(0.0, -101.0, -5.0), 100.0, diffuse(0.5))
        .ball(Vec3::new(-0.7, -0.3, -5.0), 0.7, mirror(0.75))
        .ball(Vec3::new(0.7, -0.3, -5.0), 0.7, glass(1.0, 1.5))
        .lamp(Vec3::Z * 100.0, 1.0, BLACK, Rgb::ONE)
        .ball(Vec3::Z * 60.0, 30.0, diffuse(0.25))
        .with_sky();
    for (name, render) in ENGINES {
        let of = |glint_samples| {
            let settings = Settings { iterations: 2, glint_samples, ..settings(20, 15, 2000, 8, 0.3) };
            render(&scene, &settings).pixels
        };
        assert_eq!(of(1), of(8), "{name}");
    }
    tell("physics", 3, "images of what is no lamp");
}

/// Through each filter a lamp gives as much light to all pixels together as by one ray.
#[test]
fn filters_spread_lamps_as_with_one_ray() {
    let tangent = 0.2;
    // Pixels of side 1/2: the lamp is in the middle of four.
    let fov = 2.0 * (2.0_f32).atan().to_degrees();
    let mut cases = 0;
    for (name, render) in ENGINES {
        for filter in [Filter::Gaussian, Filter::Mitchell] {
            for is_veiled in [false, true] {
                let mut scene = lamp_of(looking_down_z(fov), tangent, Rgb::ONE);
                if is_veiled {
                    scene = veil(scene, glass(1.0, 1.0));
                }
                let settings = Settings { filter, iterations: 1024, ..many(8, 8, 3, 4) };
                let one = render(&scene, &Settings { glint_samples: 1, ..settings });
                let several = render(&scene, &settings);
                // The four pixels about the lamp as well, as others may weigh it negatively.
                for pixels in [0..8, 3..5] {
                    let of = |film| block_mean(film, pixels.clone(), pixels.clone())[0];
                    let (one, several) = (of(&one), of(&several));
                    assert!((several / one - 1.0).abs() < MEAN, "{name}, {filter}: {several}, not {one}");
                    cases += 1;
                }
            }
        }
    }
    tell("physics", cases, "lamps through filters");
}

/// A lamp out of focus is a disc of the lens: with several rays as with one.
#[test]
fn lamps_out_of_focus_are_as_with_one_ray() {
    let mut scene = looking_down_z(20.0).lamp(Vec3::NEG_Z * 10.0, 0.5, BLACK, Rgb::ONE);
    scene.camera = Camera { aperture_radius: 0.4, focus_distance: 5.0, ..scene.camera };
    for is_veiled in [false, true] {
        let scene = if is_veiled { veil(scene.clone(), glass(1.0, 1.0)) } else { scene.clone() };
        let of = |glint_samples| {
            let settings = many(8, 8, 3, glint_samples);
            render_path(&scene, &settings)
        };
        let (one, several) = (of(1), of(8));
        for (x, y) in [(0, 0), (4, 0), (0, 4), (4, 4)] {
            let quarter = |film| block_mean(film, x..x + 4, y..y + 4);
            let error = relative_error(quarter(&several), quarter(&one));
            assert!(quarter(&one)[0] > 0.0 && error < MEAN, "{x}, {y}: off by {error}");
        }
    }
    tell("physics", 8, "quarters of a lamp out of focus");
}

/// A pixel that shows a part of a lamp sees it by several rays, in focus, out of it and through any filter: else the rays that meet
/// the lamp by chance are noise. Which pixels these are, the rays from the lens tell.
#[test]
fn pixels_that_show_parts_of_lamps_are_rims() {
    /// Rays through each pixel.
    const RAYS: u32 = 256;
    for (what, aperture_radius, focus_distance, filter, least) in [
        ("in focus", 0.0, 1.0, Filter::Box, 20),
        ("before what is in focus", 0.4, 30.0, Filter::Box, 50),
        ("beyond what is in focus", 0.4, 5.0, Filter::Box, 50),
        ("filtered", 0.0, 1.0, Filter::Mitchell, 40),
        ("filtered, out of focus", 0.4, 30.0, Filter::Gaussian, 60),
    ] {
        let camera = Camera { aperture_radius, focus_distance, ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 12.0) };
        let scene = empty_scene(camera).lamp(Vec3::new(-0.3, 0.2, -10.0), 0.05, BLACK, Rgb::ONE).lamp(
            Vec3::new(0.6, -0.3, -12.0),
            0.3,
            BLACK,
            Rgb::ONE,
        );
        let settings = Settings { filter, ..many(48, 36, 4, 8) };
        let (still, frame) = (scene.at(0.0), scene.camera.frame(48, 36));
        let (table, rims) = (filter.table(), Rims::new(&scene, &settings).unwrap());
        let mut parts = 0;
        for (x, y) in (0..36).flat_map(|y| (0..48).map(move |x| (x, y))) {
            let meets_lamp = |iteration: &u32| {
                let numbers = CameraNumbers::new(&settings, *iteration, x, y);
                let (ray, _) = camera_ray(&frame, table, x, y, &numbers);
                intersect(&still, &ray).is_some()
            };
            let met = (0..RAYS).filter(meets_lamp).count() as u32;
            if met > 0 && met < RAYS {
                parts += 1;
                assert!(rims.has(x, y), "{what}: {met} of {RAYS} rays through ({x}, {y}) meet a lamp");
            }
        }
        assert!(parts > least, "{what}: {parts} pixels");
    }
}

/// Of a lamp that moves, the rim is where it is when the shutter opens.
#[test]
fn rims_of_moving_lamps_are_where_they_are_when_the_shutter_opens() {
    const RAYS: u32 = 64;
    let opening = 2.0;
    let camera = Camera { shutter: [opening; 2], ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 12.0) };
    let mut scene = empty_scene(camera).lamp(Vec3::new(0.5, -0.6, -10.0), 0.3, BLACK, Rgb::ONE);
    scene.spheres[0].velocity = Vec3::new(-0.4, 0.5, 0.0);
    let settings = many(48, 36, 4, 8);
    let (still, frame) = (scene.at(opening), scene.camera.frame(48, 36));
    let rims = Rims::new(&scene, &settings).unwrap();
    let mut parts = 0;
    for (x, y) in (0..36).flat_map(|y| (0..48).map(move |x| (x, y))) {
        let meets_lamp = |iteration: &u32| {
            let numbers = CameraNumbers::new(&settings, *iteration, x, y);
            intersect(&still, &camera_ray(&frame, None, x, y, &numbers).0).is_some()
        };
        let met = (0..RAYS).filter(meets_lamp).count() as u32;
        if met > 0 && met < RAYS {
            parts += 1;
            assert!(rims.has(x, y), "{met} of {RAYS} rays through ({x}, {y}) meet the lamp");
        }
    }
    assert!(parts > 20, "{parts} pixels");
}

/// Rays go as far as paths do: through so many shells of glass.
#[test]
fn further_rays_are_as_deep_as_paths() {
    let shells = |count: u32| {
        let scene = lamp_of(looking_down_z(UNIT_PIXEL), 0.2, Rgb::ONE);
        (0..count).fold(scene, |scene, i| scene.ball(Vec3::ZERO, 1.0 + i as f32, glass(1.0, 1.0)))
    };
    for (name, render) in ENGINES {
        for count in 0..4 {
            let of = |depth| {
                let settings = Settings { iterations: 64, ..many(1, 1, depth, 16) };
                mean(&render(&shells(count), &settings))[0]
            };
            assert!(of(count + 1) > 0.0, "{name}: nothing is seen through {count} shells");
            assert!(count == 0 || of(count) == 0.0, "{name}: {} segments for {count} shells", count + 1);
        }
    }
    tell("physics", 12, "depths of further rays");
}

/// A lamp in the middle of a ball of glass looks `n` times as large, and its radiance is `1 / n^2` of what it is within, less what the
/// glass reflects.
#[test]
fn a_lamp_within_glass_gives_what_it_gives_without_but_for_what_is_reflected() {
    // At normal incidence on an index of 1.5.
    let transmitted = 1.0 - 0.2_f64.powi(2);
    let (lamp, distance) = (0.8, 10.0);
    let scene = looking_down_z(UNIT_PIXEL).ball(Vec3::NEG_Z * distance as f32, 4.0, glass(1.0, 1.5)).lamp(
        Vec3::NEG_Z * distance as f32,
        lamp as f32,
        BLACK,
        Rgb::ONE,
    );
    // As wide as rays that would pass the middle at `n` times its radius.
    let sine: f64 = 1.5 * lamp / distance;
    let expected = transmitted * PI * sine * sine / (1.0 - sine * sine) / 1.5_f64.powi(2);
    for (name, render) in ENGINES {
        for samples in [1, 8] {
            let film = render(&scene, &many(1, 1, 2, samples));
            assert_mean(&film, [expected; 3], MEAN, &format!("{name}, {samples} rays"));
        }
    }
    tell("physics", 6, "lamps within glass by several rays");
}

/// What a path finds beyond a diffuse surface is no lamp that it sees, though it comes by way of glass: it is not divided by the rays.
#[test]
fn lamps_behind_glass_that_light_a_surface_are_not_lamps_that_are_seen() {
    let albedo = 0.5;
    // Within a glowing ball of glass, which is no enclosure; the surface is in glass, which keeps shadow rays from it.
    let scene = empty_scene(pinhole(Vec3::Z * 30.0, Vec3::ZERO, 1e-3))
        .lamp(Vec3::ZERO, 90.0, glass(1.0, 1.0), Rgb::ONE)
        .ball(Vec3::NEG_Z, 1.0, diffuse(albedo))
        .ball(Vec3::ZERO, 3.0, glass(1.0, 1.0));
    for samples in [1, 8] {
        let film = render_path(&scene, &many(1, 1, 8, samples));
        assert_mean(&film, [f64::from(albedo); 3], MEAN, &format!("{samples} rays"));
    }
    tell("physics", 2, "surfaces behind glass lit by way of it");
}
