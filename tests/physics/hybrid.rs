//! Path tracing with photons for caustics: each path of light between a lamp and the eye is counted by one of both, and by one
//! alone.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, diffuse, empty_scene, glass, lamp_within_glass, mean, mirror, pinhole, relative_error,
    render_by, render_path, render_path_fast, run, settings,
};
use reference::emission::emit;
use reference::intersect::intersect;
use reference::photon_numbers::PhotonNumbers;
use reference::photon_pass::{Deposit, photon_pass};
use reference::{PathTracer, Sppm};
use scene::aim::{Aim, Targets};
use scene::still::Carried;
use scene::{Film, Hybrid, Rgb, Scene, Settings, Stats, Vec3};

fn hybrid<'a>(scene: &'a Scene, settings: &Settings) -> Hybrid<PathTracer<'a>, Sppm<'a>> {
    reference::hybrid(PathTracer::new(scene, settings), Sppm::new(scene, settings))
}

/// The image of [`hybrid`], by [`render_by`].
fn render_hybrid(scene: &Scene, settings: &Settings) -> Film {
    let by_fast = || fast::hybrid(fast::PathTracer::new(scene, settings), fast::Sppm::new(scene, settings));
    render_by(by_fast, || hybrid(scene, settings), settings)
}

/// The part of the image that photons bring.
fn render_caustics(scene: &Scene, settings: &Settings) -> Film {
    let by_fast = || fast::Sppm::new(scene, settings).of_caustics();
    render_by(by_fast, || Sppm::new(scene, settings).of_caustics(), settings)
}

/// A floor with balls of glass, mirror and chalk under a sky and two lamps, one of them within glass: so large that paths meet
/// them often.
fn open_scene() -> Scene {
    let above = Vec3::new(-1.6, 2.2, 0.6);
    empty_scene(pinhole(Vec3::new(0.0, 2.0, 7.0), Vec3::new(0.0, 0.6, 0.0), 40.0))
        .lamp(Vec3::ZERO, 1e3, BLACK, Rgb::new(0.2, 0.3, 0.5))
        .ball(Vec3::new(0.0, -200.0, 0.0), 200.0, diffuse(0.6))
        .ball(Vec3::new(-0.9, 0.7, 0.3), 0.7, glass(0.9, 1.5))
        .ball(Vec3::new(1.0, 0.8, -0.3), 0.8, mirror(0.9))
        .ball(Vec3::new(0.2, 0.4, 1.2), 0.4, diffuse(0.8))
        .lamp(Vec3::new(0.6, 3.0, 0.8), 0.9, BLACK, Rgb::new(3.0, 2.0, 1.0))
        .ball(above, 0.8, glass(1.0, 1.4))
        .lamp(above, 0.6, BLACK, Rgb::new(1.0, 2.0, 3.0))
}

/// The root of the mean square difference of blocks of `side` pixels, relative to the mean.
fn difference(a: &Film, b: &Film, side: u32) -> f64 {
    let block = |film: &Film, x: u32, y: u32, channel: usize| {
        let places = (0..side * side).map(|i| ((y + i / side) * film.width + x + i % side) as usize);
        places.map(|place| f64::from(film.pixels[place][channel])).sum::<f64>() / f64::from(side * side)
    };
    let (mut squares, mut count) = (0.0, 0.0);
    for y in (0..a.height).step_by(side as usize) {
        for x in (0..a.width).step_by(side as usize) {
            for channel in 0..3 {
                let (a, b) = (block(a, x, y, channel), block(b, x, y, channel));
                squares += (a - b).powi(2);
                count += 1.0;
            }
        }
    }
    let brightness = mean(b).iter().sum::<f64>() / 3.0;
    (squares / count).sqrt() / brightness
}

/// By blocks it is the path tracer's image; and neither part is all of it.
#[test]
fn both_parts_together_are_the_image_of_the_path_tracer() {
    /// Four times what two images of the path tracer with other seeds differ by: 0.0031.
    const TOLERANCE: f64 = 0.0125;
    /// What paths lack, 0.046 and 0.050; photons lack far more.
    const LACKING: f64 = 0.04;
    let scene = open_scene();
    for max_depth in [3, 12] {
        let settings = Settings {
            iterations: 400,
            photons_per_iteration: 2000,
            ..settings(32, 24, 2000, max_depth, 0.25)
        };
        let truth = render_path_fast(&scene, &settings);
        let both = render_hybrid(&scene, &Settings { seed: 7, ..settings });
        let found = difference(&both, &truth, 4);
        assert!(found < TOLERANCE, "{found} at depth {max_depth}");
        let means = relative_error(mean(&both), mean(&truth));
        // Of the whole image these two differ by 0.0007.
        assert!(means < TOLERANCE / 4.0, "{means} at depth {max_depth}");
        let paths = render_by(
            || fast::PathTracer::new(&scene, &settings).without_caustics(),
            || PathTracer::new(&scene, &settings).without_caustics(),
            &settings,
        );
        let caustics = render_caustics(&scene, &settings);
        assert!(difference(&paths, &truth, 4) > LACKING && difference(&caustics, &truth, 4) > LACKING);
    }
    tell("physics", 2, "images by paths and photons for caustics");
}

/// Whatever it is that makes a caustic, photons carry it: a mirror where there is no glass, and the glass of a lamp itself, which
/// glows within as well.
#[test]
fn mirrors_alone_and_glass_that_glows_make_caustics() {
    /// Noise of means of the image, of 150 samples of each of 768 pixels.
    const TOLERANCE: f64 = 0.01;
    /// What photons bring is at least this share of the image.
    const LEAST: f64 = 0.005;
    let floor = || {
        empty_scene(pinhole(Vec3::new(0.0, 2.0, 7.0), Vec3::new(0.0, 0.6, 0.0), 40.0)).ball(
            Vec3::new(0.0, -200.0, 0.0),
            200.0,
            diffuse(0.6),
        )
    };
    let color = Rgb::new(3.0, 2.0, 1.0);
    let of_mirror = floor().ball(Vec3::new(0.6, 0.9, -0.3), 0.9, mirror(0.9)).lamp(
        Vec3::new(-1.0, 1.5, 0.5),
        0.9,
        BLACK,
        color,
    );
    let of_glass = floor().lamp(Vec3::new(0.0, 1.2, 0.0), 1.0, glass(1.0, 1.5), color);
    for scene in [of_mirror, of_glass] {
        let settings =
            Settings { iterations: 150, photons_per_iteration: 2000, ..settings(32, 24, 2000, 8, 0.25) };
        let truth = render_path_fast(&scene, &Settings { seed: 9, ..settings });
        let both = render_hybrid(&scene, &settings);
        let error = relative_error(mean(&both), mean(&truth));
        assert!(error < TOLERANCE, "{error}: {:?}, not {:?}", mean(&both), mean(&truth));
        let caustics = render_caustics(&scene, &settings);
        let share = mean(&caustics)[0] / mean(&truth)[0];
        assert!(share > LEAST, "{share} of the image is of caustics");
    }
}

/// Where there is no mirror and no glass, or no lamp but the sky, paths do it all, as if there were no photons.
#[test]
fn without_caustics_the_image_is_the_path_tracers_bit_by_bit() {
    let camera = || pinhole(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO, 40.0);
    let floor = |scene: Scene| scene.ball(Vec3::new(0.0, -100.0, 0.0), 100.0, diffuse(0.6));
    let dull = floor(empty_scene(camera())).lamp(Vec3::new(1.0, 3.0, 0.0), 0.3, BLACK, Rgb::splat(9.0)).ball(
        Vec3::new(0.0, 0.5, 0.0),
        0.5,
        diffuse(0.7),
    );
    let sky = floor(empty_scene(camera()).lamp(Vec3::ZERO, 1e3, BLACK, Rgb::ONE))
        .ball(Vec3::new(-0.5, 0.5, 0.0), 0.5, glass(1.0, 1.5))
        .ball(Vec3::new(0.6, 0.5, 0.0), 0.5, mirror(0.9));
    for scene in [dull, sky] {
        let settings = settings(24, 18, 3000, 6, 0.3);
        let settings = Settings { iterations: 3, ..settings };
        assert_eq!(run(hybrid(&scene, &settings), &settings), render_path(&scene, &settings));
    }
}

/// What all photons of one number deposit.
fn deposits(scene: &Scene, settings: &Settings, carried: Carried, photon: u32) -> Vec<Deposit> {
    let (still, mut all) = (scene.at_for(0.0, carried), Vec::new());
    let photons = photon..photon + 1;
    photon_pass(&still, &Aim::default(), settings, 0, photons, &mut Stats::default(), |deposit, _| {
        all.push(*deposit);
    });
    all
}

/// A photon whose first surface is a mirror or glass does all that it does in photon mapping; any other, nothing.
#[test]
fn photons_carry_what_comes_from_a_mirror_or_glass_first() {
    let mut scene = open_scene();
    // The sky's photons are left out, so the others have other numbers: here it is dark.
    scene.spheres[0].emission = Rgb::ZERO;
    let settings = settings(8, 6, 4000, 6, 0.25);
    let (still, numbers) = (scene.at(0.0), PhotonNumbers::new(settings.seed, 0));
    let (mut first, mut others) = (0, 0);
    for photon in 0..4000 {
        let hit = emit(&still, &Aim::default(), &numbers, photon)
            .and_then(|emitted| intersect(&still, &emitted.ray));
        let is_first = hit.is_some_and(|hit| !still.material(hit.sphere).is_diffuse());
        let all = deposits(&scene, &settings, Carried::All, photon);
        let found = deposits(&scene, &settings, Carried::Caustics, photon);
        if is_first {
            assert_eq!(found, all, "photon {photon}");
            first += found.len();
        } else {
            assert!(found.is_empty(), "photon {photon}");
            others += all.len();
        }
    }
    assert!(first > 500 && others > 500, "{first} deposits, {others} left out");
}

/// The sky is no lamp of photons that carry caustics, and a lamp's share of their power is that among lamps.
#[test]
fn photons_for_caustics_leave_lamps_alone() {
    let scene = open_scene();
    let (all, still) = (scene.at(0.0), scene.at_for(0.0, Carried::Caustics));
    let spheres: Vec<u32> = still.lights.entries.iter().map(|light| light.sphere).collect();
    assert_eq!(spheres, [5, 7]);
    assert!(all.lights.entries.len() == 3 && all.lights.power > still.lights.power);
    let power = |sphere: usize| {
        let sphere = &scene.spheres[sphere];
        let area = 4.0 * std::f64::consts::PI * f64::from(sphere.radius).powi(2);
        std::f64::consts::PI * area * f64::from(sphere.emission.max_element())
    };
    let sum = power(5) + power(7);
    assert!((f64::from(still.lights.power) / sum - 1.0).abs() < 1e-6);
    for (light, sphere) in still.lights.entries.iter().zip([5, 7]) {
        assert!((f64::from(light.probability) / (power(sphere) / sum) - 1.0).abs() < 1e-6);
    }
    assert!(
        still.has_photons()
            && !Scene { materials: vec![diffuse(0.5); 9], ..scene.clone() }
                .at_for(0.0, Carried::Caustics)
                .has_photons()
    );
}

/// All light of a lamp in the middle of a ball of glass leaves it by the glass: below, irradiance is that of a point,
/// `Phi / (4 pi h^2)`, less what the glass reflects back into the lamp, all of it by photons.
#[test]
fn light_of_a_lamp_within_glass_comes_by_photons_alone() {
    /// Of the disc of radius 0.1, 0.7 below the lamp, 1.5 %; three standard errors of some 4,000 photons, 5 %.
    const NEAR: f64 = 0.065;
    let (scene, expected) = lamp_within_glass();
    let settings = Settings { iterations: 4, radius_clearance: 0.5, ..settings(4, 3, 200_000, 8, 0.8) };
    let paths = PathTracer::new(&scene, &settings).without_caustics();
    let caustics = || Sppm::new(&scene, &settings).of_caustics().aimed_at(Targets::default());
    let both = run(Hybrid::new(paths, caustics()), &settings);
    assert!(relative_error(mean(&both), [expected; 3]) < NEAR, "{:?} for {expected}", mean(&both));
    assert_eq!(both, run(caustics(), &settings));
}
