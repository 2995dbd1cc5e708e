//! Emission and scattering of photons: random choices follow their densities, energy is conserved, and transport is
//! reciprocal.
//!
//! Photons are not deposited at their first hit, as direct light is computed separately. So lamps are surrounded by
//! glass of index 1, which photons cross as if it were not there; they are then deposited at their next hit.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, SIGNIFICANCE, assert_uniform_square, chi_square_p_of, coloured, deposits, empty_scene,
    glass, mirror, pinhole, settings,
};
use glam::DVec3;
use reference::direct_light::choose_light;
use reference::photon_pass::{Deposit, Flux, quantise};
use scene::aim::Aim;
use scene::film::FLUX_ONE;
use scene::{Rgb, Scene, Settings, Vec3};
use std::f64::consts::TAU;

fn nowhere() -> Scene {
    empty_scene(pinhole(Vec3::new(0.0, 0.0, 90.0), Vec3::ZERO, 60.0))
}

/// A lamp of radius 1 at `center`, surrounded by glass of index 1, in a black shell.
fn visible_emission(center: Vec3) -> Scene {
    nowhere().ball(Vec3::ZERO, 100.0, BLACK).lamp(center, 1.0, BLACK, Rgb::ONE).ball(
        center,
        1.5,
        glass(1.0, 1.0),
    )
}

/// The point on the lamp at which the photon of deposit `d` started, relative to the lamp's centre.
fn start(d: &Deposit, center: Vec3) -> DVec3 {
    // The photon travels along -wi. Going back from the deposit, it started where this line first meets the unit
    // sphere.
    let (to_center, wi) = ((d.point - center).as_dvec3(), d.wi.as_dvec3());
    let b = to_center.dot(wi);
    let half_chord = (1.0 - (to_center.length_squared() - b * b)).max(0.0).sqrt();
    to_center + wi * (-b - half_chord)
}

/// Cells of the tests for uniformity. `f32` errors at distances of 100 are 10^-5 of the lamp's radius, a thousand times
/// less than the width of a cell.
const CELLS: [usize; 2] = [24, 24];

#[test]
fn photons_start_uniformly_on_the_lamp_with_a_cosine_distribution() {
    let center = Vec3::new(20.0, -10.0, 5.0);
    let settings = Settings { iterations: 4, ..settings(1, 1, 1 << 17, 2, 1.0) };
    let (deposits, stats) = deposits(&visible_emission(center), &settings);
    assert_eq!((deposits.len(), stats.photons), (4 << 17, 4 << 17));
    let turns = |x: f64, y: f64| (y.atan2(x) / TAU + 1.0).fract();
    let starts = || deposits.iter().map(|d| (start(d, center).normalize(), -d.wi.as_dvec3()));
    let positions = starts().map(|(n, _)| [(0.5 * n.z + 0.5).min(1.0 - f64::EPSILON), turns(n.x, n.y)]);
    assert_uniform_square(positions, CELLS, "starts on the lamp");
    // With a density of cos / pi about the normal, the squared sine and the azimuth are uniform.
    let directions = starts().map(|(n, d)| {
        let s = n.any_orthonormal_vector();
        let sine2 = 1.0 - n.dot(d).clamp(0.0, 1.0).powi(2);
        [sine2.min(1.0 - f64::EPSILON), turns(s.dot(d), n.cross(s).dot(d))]
    });
    assert_uniform_square(directions, CELLS, "directions about the normal");
    // The direction is independent of the starting point.
    let both = starts().map(|(n, d)| {
        let sine2 = 1.0 - n.dot(d).clamp(0.0, 1.0).powi(2);
        [sine2.min(1.0 - f64::EPSILON), (0.5 * n.z + 0.5).min(1.0 - f64::EPSILON)]
    });
    assert_uniform_square(both, CELLS, "directions against starts");
    tell("physics", deposits.len(), "photons on their way from a lamp");
}

#[test]
fn a_shell_emits_inward() {
    // A photon of the shell either crosses the glass and is deposited, or misses it and counts as direct light.
    let scene = nowhere().lamp(Vec3::ZERO, 100.0, BLACK, Rgb::ONE).ball(Vec3::ZERO, 50.0, glass(1.0, 1.0));
    let photons = 1 << 18;
    let (deposits, _) = deposits(&scene, &settings(1, 1, photons, 3, 1.0));
    // A quarter of cosine-weighted directions is within asin(1/2) of the normal.
    let share = deposits.len() as f64 / f64::from(photons);
    assert!((share - 0.25).abs() < STRATIFIED, "{share} of the photons meet the inner ball");
    assert!(deposits.iter().all(|d| d.wi.dot(d.point) < 0.0), "a photon comes from outside");
}

/// Tolerance of a share of 2^18 stratified photons. Their error is below that of as many independent ones, 10^-3.
const STRATIFIED: f64 = 1e-3;

#[test]
fn lights_are_chosen_by_their_power() {
    let scene = nowhere()
        .lamp(Vec3::X * 5.0, 1.0, BLACK, Rgb::new(1.0, 4.0, 2.0))
        .lamp(Vec3::X * -5.0, 2.0, BLACK, Rgb::new(3.0, 1.0, 0.5))
        .lamp(Vec3::Y * 9.0, 0.1, BLACK, Rgb::new(0.0, 0.0, 100.0))
        .lamp(Vec3::ZERO, 200.0, BLACK, Rgb::splat(0.001));
    // The brightest channel times the squared radius.
    let weights = [4.0, 12.0, 1.0, 40.0];
    let lights = scene.at(0.0).lights;
    let mut stream = scene::rng::StreamKey::new(8, scene::rng::Family::Path, 0).stream(0);
    let mut counts = vec![0; weights.len()];
    for _ in 0..1 << 20 {
        let light = choose_light(&lights, stream.next_f32()).unwrap();
        counts[lights.entries[light as usize].sphere as usize] += 1;
    }
    let p = chi_square_p_of(&counts, &weights.map(|w| w / 57.0));
    assert!(p > SIGNIFICANCE, "{counts:?}: p = {p:.1e}");
    // The same for photons: each lamp has its share of the deposits.
    let scene = nowhere()
        .ball(Vec3::ZERO, 200.0, BLACK)
        .lamp(Vec3::X * 50.0, 1.0, BLACK, Rgb::ONE)
        .lamp(Vec3::X * -50.0, 3.0, BLACK, Rgb::ONE)
        .ball(Vec3::X * 50.0, 2.0, glass(1.0, 1.0))
        .ball(Vec3::X * -50.0, 4.0, glass(1.0, 1.0));
    let photons = 1 << 18;
    let (deposits, _) = deposits(&scene, &settings(1, 1, photons, 2, 1.0));
    let missed = |d: &&Deposit| {
        let from = (d.point - Vec3::X * 50.0).as_dvec3();
        (from - d.wi.as_dvec3() * from.dot(d.wi.as_dvec3())).length() > 1.001
    };
    // A photon of the large lamp may be on a line through the small one, which covers (1/100)^2 / 4 of the sphere of
    // directions: a share below 10^-4.
    let share = deposits.iter().filter(missed).count() as f64 / f64::from(photons);
    assert!((share - 0.9).abs() < STRATIFIED, "{share} of the photons are of the lamp of 0.9 of the power");
}

/// A closed room, in which photons end only by Russian roulette or at the maximum depth.
fn closed(albedo: Rgb, emission: Rgb) -> Scene {
    nowhere().ball(Vec3::ZERO, 100.0, coloured(albedo.to_array())).lamp(
        Vec3::new(10.0, 20.0, 0.0),
        5.0,
        coloured(albedo.to_array()),
        emission,
    )
}

#[test]
fn roulette_survivors_are_as_many_as_the_brightest_channel_reflects() {
    let (albedo, photons, depth) = (Rgb::new(0.3, 0.7, 0.5), 1 << 18, 8);
    let scene = closed(albedo, Rgb::new(2.0, 1.0, 1.0));
    // At depth d there are photons that have survived d - 1 times. The brightest channel of the lamp is the first;
    // after a reflection it is the second. The photons that survive are 0.35, 0.245, 0.171, ... of those emitted.
    let segments = |depth| {
        let (_, stats) = deposits(&scene, &settings(1, 1, photons, depth, 1.0));
        stats.photon_segments as f64
    };
    let mut power = Rgb::new(2.0, 1.0, 1.0).as_dvec3();
    let (mut alive, mut before) = (f64::from(photons), 0.0);
    for depth in 1..=depth {
        let actual = segments(depth) - before;
        let sigma = (alive * (1.0 - alive / f64::from(photons))).sqrt();
        assert!((actual - alive).abs() <= DEVIATIONS * sigma, "depth {depth}: {actual} instead of {alive}");
        let after = power * albedo.as_dvec3();
        alive *= after.max_element() / power.max_element();
        (power, before) = (after, before + actual);
    }
    tell("physics", depth as usize, "steps of roulette");
}

/// Allowed deviation of a count in standard errors, about as unlikely as [`SIGNIFICANCE`].
const DEVIATIONS: f64 = 5.0;

#[test]
fn survivors_keep_the_nominal_power_and_take_the_colour_of_surfaces() {
    let albedo = Rgb::new(0.25, 0.5, 1.0);
    let scene = nowhere().ball(Vec3::ZERO, 100.0, coloured(albedo.to_array())).lamp(
        Vec3::ZERO,
        5.0,
        BLACK,
        Rgb::new(4.0, 4.0, 2.0),
    );
    let (deposits, _) = deposits(&scene, &settings(1, 1, 10_000, 4, 1.0));
    // The lamp reflects nothing. After k reflections the colour is the lamp's times the kth power of the albedo.
    let colours: Vec<Flux> = (1..4)
        .map(|k| {
            let colour = Rgb::new(4.0, 4.0, 2.0).as_dvec3() * albedo.as_dvec3().powf(f64::from(k));
            let scaled = colour / colour.max_element() * f64::from(FLUX_ONE);
            Flux { units: scaled.round().to_array().map(|v| v as u32), shift: 0 }
        })
        .collect();
    let near = |a: &Flux, b: &Flux| a.units.iter().zip(b.units).all(|(a, b)| a.abs_diff(b) <= FLUX_ROUNDING);
    for d in &deposits {
        assert!(colours.iter().any(|colour| near(colour, &d.flux)), "{:?} is none of {colours:?}", d.flux);
    }
    for colour in &colours {
        assert!(deposits.iter().any(|d| near(colour, &d.flux)), "no photon has {colour:?}");
    }
}

/// A photon of the nominal power in all channels.
const NOMINAL: Flux = Flux { units: [FLUX_ONE; 3], shift: 0 };

/// Tolerance of a quantised flux of up to 2^21: a few rounding errors of 2^-24.
const FLUX_ROUNDING: u32 = 1;

#[test]
fn quantisation_rounds_to_the_nearest_and_never_overflows() {
    for i in 0..=100_000_u32 {
        let power = i as f32 / 100_000.0;
        let Flux { units: [r, g, b], shift } = quantise(&Aim::default(), Rgb::new(power, 0.5 * power, 0.0));
        assert_eq!(shift, 0);
        let exact = f64::from(power) * f64::from(FLUX_ONE);
        // Half a step, plus the rounding of the sum before it is truncated.
        for (flux, exact) in [(r, exact), (g, 0.5 * exact)] {
            assert!((f64::from(flux) - exact).abs() <= 0.75, "{power}: {flux} instead of {exact}");
        }
        assert_eq!(b, 0);
    }
    for power in [1.0, 1.0 + f32::EPSILON, 2.0, f32::INFINITY] {
        assert_eq!(quantise(&Aim::default(), Rgb::splat(power)), NOMINAL);
    }
    tell("physics", 100_001, "quantised powers");
}

/// Lossless mirrors and glass, separate, nested and overlapping, around a lamp in glass of index 1.
fn lossless() -> Scene {
    visible_emission(Vec3::ZERO)
        .ball(Vec3::new(5.0, 0.0, 0.0), 3.0, glass(1.0, 1.5))
        .ball(Vec3::new(5.0, 0.0, 0.0), 2.0, glass(1.0, 2.4))
        .ball(Vec3::new(-5.0, 1.0, 0.0), 3.0, mirror(1.0))
        .ball(Vec3::new(0.0, -6.0, 0.0), 4.0, glass(1.0, 1.3))
        .ball(Vec3::new(1.0, 6.0, 2.0), 4.0, mirror(1.0))
}

#[test]
fn what_takes_no_light_loses_none() {
    let photons = 20_000;
    let (deposits, stats) = deposits(&lossless(), &settings(1, 1, photons, 4096, 1.0));
    // Each photon ends on a black surface, the lamp or the shell, and is deposited once with its full power.
    assert_eq!(deposits.len(), photons as usize);
    assert!(deposits.iter().all(|d| d.flux == NOMINAL));
    assert!(stats.photon_segments > 3 * u64::from(photons), "the balls are not met");
    tell("physics", deposits.len(), "photons through mirrors and glass, none lost");
}

#[test]
fn the_flux_in_a_closed_room_is_the_series_of_its_albedo() {
    let (albedo, photons) = (Rgb::new(0.8, 0.4, 0.2), 1 << 17);
    let (deposits, _) =
        deposits(&closed(albedo, Rgb::new(1.0, 2.0, 4.0)), &settings(1, 1, photons, 200, 1.0));
    let mut sum = [0_u64; 3];
    for d in &deposits {
        sum = [0, 1, 2].map(|c| sum[c] + u64::from(d.flux.units[c]));
    }
    for (c, (albedo, emission)) in albedo.to_array().into_iter().zip([1.0, 2.0, 4.0]).enumerate() {
        // A photon starts with e / 4 of the nominal power, arrives a second time with that times rho, and so on.
        let rho = f64::from(albedo);
        let expected = emission / 4.0 * rho / (1.0 - rho) * f64::from(photons) * f64::from(FLUX_ONE);
        let actual = sum[c] as f64;
        // Photons start mostly blue, and a fifth of them survive the first reflection. Red light is carried by few
        // bright survivors.
        assert!((actual / expected - 1.0).abs() < SERIES, "channel {c}: {actual} instead of {expected}");
    }
}

/// Relative tolerance: sums over at least 26 000 survivors, with weights that vary with the number of bounces, have
/// noise below 0.7 %.
const SERIES: f64 = 0.02;

/// The share of photons from ball `from` that arrive at the other one, in a black shell with `optics`. The balls have
/// the given places and radii.
fn exchange(from: usize, places: [Vec3; 2], radii: [f32; 2], optics: impl Fn(Scene) -> Scene) -> f64 {
    let photons = 1 << 20;
    let mut scene = nowhere().ball(Vec3::ZERO, 100.0, BLACK);
    for (index, (place, radius)) in places.into_iter().zip(radii).enumerate() {
        let emission = if index == from { Rgb::ONE } else { Rgb::ZERO };
        scene = scene.lamp(place, radius, BLACK, emission);
    }
    let scene = optics(scene.ball(places[from], 1.25 * radii[from], glass(1.0, 1.0)));
    let target = 2 - from as u32;
    let (deposits, _) = deposits(&scene, &settings(1, 1, photons, 64, 1.0));
    deposits.iter().filter(|d| d.sphere == target).count() as f64 / f64::from(photons)
}

/// Relative tolerance: shares of at least 2 % of 2^20 photons would have noise of at most 0.7 % even without
/// stratification.
const RECIPROCITY: f64 = 0.02;

#[test]
fn light_transport_is_reciprocal() {
    let (places, radii) = ([Vec3::new(-5.0, 0.0, 0.0), Vec3::new(6.0, 1.0, 0.0)], [3.0, 4.0]);
    let empty = |scene: Scene| scene;
    let lens = |scene: Scene| scene.ball(Vec3::new(-0.2, 0.3, 0.0), 1.2, glass(1.0, 1.5));
    let mirrors = |scene: Scene| {
        scene.ball(Vec3::new(0.0, 8.0, 0.0), 5.0, mirror(1.0)).ball(
            Vec3::new(0.0, -9.0, 1.0),
            5.0,
            mirror(0.5),
        )
    };
    let cases: [(&str, &dyn Fn(Scene) -> Scene); 3] =
        [("empty", &empty), ("a lens", &lens), ("mirrors", &mirrors)];
    for (what, optics) in cases {
        let [there, back] = [0, 1].map(|from| exchange(from, places, radii, optics));
        // Reciprocity of form factors: A1 F12 = A2 F21, with any smooth surfaces in between.
        let ratio = there * f64::from(radii[0] * radii[0]) / (back * f64::from(radii[1] * radii[1]));
        assert!((ratio - 1.0).abs() < RECIPROCITY, "{what}: {there} and {back}, off by {:.1e}", ratio - 1.0);
    }
    tell("physics", 3, "exchanges of light in both directions");
}

#[test]
fn the_power_that_a_ball_receives_is_the_solid_angle_of_a_small_lamp() {
    // The lamp is almost a point. The share of its photons that hit the ball is (1 - cos) / 2, by the angle of its
    // cone.
    let (distance, radius) = (10.0_f32, 4.0_f32);
    let share = exchange(0, [Vec3::ZERO, Vec3::X * distance], [0.01, radius], |scene| scene);
    let cosine = (1.0 - f64::from(radius / distance).powi(2)).sqrt();
    let expected = 0.5 * (1.0 - cosine);
    assert!((share / expected - 1.0).abs() < RECIPROCITY, "{share} instead of {expected}");
}
