//! Photons aimed at balls: their weights, their densities, and that the image stays what it is.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_same_blocks, assert_uniform_square, diffuse, empty_scene, glass, mean, pinhole,
    relative_error, render_aimed, render_path_fast, settings,
};
use glam::DVec3;
use reference::emission::{Emitted, emit};
use reference::intersect::intersect;
use reference::photon_numbers::PhotonNumbers;
use reference::photon_pass::{Flux, quantise, scatter_towards};
use reference::survey::survey;
use scene::aim::{Aim, Arrival, EXPONENT_STEP, Group, MOST_SCALE_BITS, Target, Targets, UNIFORM_SHARE, cone};
use scene::film::FLUX_ONE;
use scene::ray::SphereId;
use scene::rng::{Family, StreamKey};
use scene::{Ray, Rgb, Scene, Settings, Vec3, max_component};
use std::f64::consts::TAU;

/// Targets with equal shares, a half of all photons, the other half uniform.
fn aimed_at(balls: Vec<Target>) -> Targets {
    let share = 0.5 / balls.len() as f64;
    let shares = std::iter::once(0.5).chain(balls.iter().map(|_| share)).collect();
    Targets { balls, middle: 0, shares, expected: 0.0, guide: None }
}

/// A sky of radius `sky`, a far sun, near lamps of several sizes, in the midst of nothing.
fn open(scale: f32, offset: Vec3) -> Scene {
    let at = |v: Vec3| (v + offset) * scale;
    empty_scene(pinhole(at(Vec3::Z * 9.0), at(Vec3::ZERO), 30.0))
        .lamp(at(Vec3::new(30.0, 60.0, 20.0)), 6.0 * scale, BLACK, Rgb::new(3.0, 2.0, 1.0))
        .lamp(at(Vec3::new(-3.0, 4.0, 0.0)), 0.5 * scale, BLACK, Rgb::new(20.0, 30.0, 10.0))
        .lamp(at(Vec3::new(1.0, 3.0, 2.0)), 0.02 * scale, BLACK, Rgb::splat(1000.0))
        .lamp(at(Vec3::ZERO), 200.0 * scale, BLACK, Rgb::new(0.01, 0.02, 0.03))
}

/// Small, large, nested, overlapping; around a lamp, touching one, and around all.
fn targets(scale: f32, offset: Vec3) -> Vec<Target> {
    [
        (Vec3::ZERO, 0.1),
        (Vec3::ZERO, 1.0),
        (Vec3::X * 1.5, 1.0),
        (Vec3::new(-3.0, 4.0, 0.0), 2.0),
        (Vec3::new(1.0, 2.5, 2.0), 0.48),
        (Vec3::ZERO, 90.0),
        (Vec3::ZERO, 1.2),
        (Vec3::X * 1.5, 0.8),
    ]
    .into_iter()
    .enumerate()
    .map(|(k, (center, radius)): (usize, (Vec3, f32))| {
        // One by light from above only, and one by that of the sun.
        let (axis, height) = match k {
            6 => (Vec3::NEG_Y, 0.9),
            7 => (Vec3::new(-30.0, -60.0, -20.0).normalize(), 0.02),
            _ => (Vec3::Z, 3.0),
        };
        Target { axis, height, ..Target::ball((center + offset) * scale, radius * scale) }
    })
    .collect()
}

/// A photon's weight: the brightest channel of its power.
fn weight(e: &Emitted) -> f32 {
    max_component(e.power)
}

/// That of a photon of weight 8 in the smallest unit.
const LARGEST_FLUX: u128 = (FLUX_ONE as u128) << (3 + MOST_SCALE_BITS);

fn emitted(scene: &Scene, aim: &Aim, photons: u32, iteration: u32) -> Vec<(u32, Emitted)> {
    let still = scene.at(0.0);
    let numbers = PhotonNumbers::new(1, iteration);
    (0..photons).filter_map(|p| emit(&still, aim, &numbers, p).map(|e| (p, e))).collect()
}

/// Means of 2^20 weights and parts of them: what is left of their noise where lines are stratified.
const WEIGHTS: f64 = 1e-2;

const PHOTONS: u32 = 1 << 20;

#[test]
fn weights_are_1_on_the_average_at_every_scale() {
    for (scale, offset) in
        [(1.0, Vec3::ZERO), (1e-3, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, Vec3::new(2000.0, -1000.0, 500.0))]
    {
        let scene = open(scale, offset);
        let aim = Aim::new(&scene.at(0.0), &aimed_at(targets(scale, offset)), PHOTONS);
        let photons = emitted(&scene, &aim, PHOTONS, 0);
        let sum: f64 = photons.iter().map(|(_, e)| f64::from(weight(e))).sum();
        let mean = sum / f64::from(PHOTONS);
        assert!((mean - 1.0).abs() < WEIGHTS, "scale {scale}, offset {offset}: {mean}");
        let most = photons.iter().map(|(_, e)| weight(e)).fold(0.0, f32::max);
        assert!(most <= 2.0 * (1.0 + 1e-5), "a weight of {most} with a uniform share of a half");
        let largest = quantise(&aim, Rgb::splat(most)).values()[0];
        assert!((LARGEST_FLUX / 8..=LARGEST_FLUX).contains(&(largest << (MOST_SCALE_BITS - aim.scale_bits))));
    }
    tell("physics", 4 * PHOTONS as usize, "weights of photons");
}

/// Lamps of 13 powers over a square of 60 x 50, in the midst of nothing.
fn lamps_over_a_square(count: u32) -> Scene {
    (0..count).fold(empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0)), |scene, k| {
        let place = Vec3::new((k % 60) as f32 - 30.0, 5.0 + (k % 7) as f32, (k / 60) as f32 - 25.0);
        let radius = 0.02 + 0.001 * (k % 11) as f32;
        scene.lamp(place, radius, BLACK, Rgb::splat(1.0 + (k % 13) as f32))
    })
}

#[test]
fn weights_are_1_on_the_average_with_more_lamps_than_are_aimed_one_by_one() {
    let scene = lamps_over_a_square(3000);
    let still = scene.at(0.0);
    let aim = Aim::new(&still, &aimed_at(targets(1.0, Vec3::ZERO)), PHOTONS);
    assert!(aim.groups.iter().any(|group| group.end - group.first > 1), "each lamp is by itself");
    let photons = emitted(&scene, &aim, PHOTONS, 0);
    let sum: f64 = photons.iter().map(|(_, e)| f64::from(weight(e))).sum();
    let mean = sum / f64::from(PHOTONS);
    assert!((mean - 1.0).abs() < WEIGHTS, "{mean}");
    // Each lamp sends its share, whatever its run of neighbours.
    let mut power = [0.0; 13];
    for (_, e) in &photons {
        let brightness = f64::from(scene.spheres[e.ray.leaves as usize].emission.x);
        power[brightness as usize - 1] += f64::from(weight(e)) / f64::from(PHOTONS);
    }
    let of_all: f64 = still.lights.entries.iter().map(|light| f64::from(light.probability)).sum();
    for (class, power) in power.iter().enumerate() {
        let is_of = |light: &&scene::still::Light| {
            scene.spheres[light.sphere as usize].emission.x as usize == class + 1
        };
        let lights = still.lights.entries.iter().filter(is_of);
        let expected = lights.map(|light| f64::from(light.probability)).sum::<f64>() / of_all;
        assert!((power / expected - 1.0).abs() < SHARE_OF_LAMPS, "{class}: {power}, not {expected}");
    }
    tell("physics", PHOTONS as usize, "weights of photons of 3000 lamps");
}

/// The expected variance of photons that are aimed, over that of uniform emission, where the sky has nearly all power.
const AIMED_AMONG_THOUSANDS: f64 = 1e-3;

/// Balls on a wide ground under a sky and two thousand lamps.
#[test]
fn photons_are_aimed_under_a_sky_and_thousands_of_lamps() {
    let mut scene = lamps_over_a_square(2000);
    scene.background = Rgb::splat(0.02);
    scene.camera = pinhole(Vec3::new(0.0, 3.0, 12.0), Vec3::ZERO, 34.0);
    let scene = scene
        .ball(Vec3::new(0.0, -10_001.0, 0.0), 10_000.0, diffuse(0.5))
        .ball(Vec3::ZERO, 1.0, diffuse(0.8))
        .ball(Vec3::new(2.2, 0.0, 0.0), 1.0, glass(1.0, 1.5))
        .with_sky();
    let targets = survey(&scene, &settings(64, 48, 1000, 8, 0.25));
    assert!(targets.expected < AIMED_AMONG_THOUSANDS, "{:?}", targets.expected);
    let aim = Aim::new(&scene.at(0.0), &targets, PHOTONS);
    let photons = emitted(&scene, &aim, PHOTONS, 0);
    let mean = photons.iter().map(|(_, e)| f64::from(weight(e))).sum::<f64>() / f64::from(PHOTONS);
    assert!((mean - 1.0).abs() < WEIGHTS, "a mean weight of {mean}");
}

/// So few photons that their shares cannot be what is asked for: components get whole runs of them, or none.
#[test]
fn weights_are_1_on_the_average_with_few_photons() {
    const ITERATIONS: u32 = 4096;
    let scene = open(1.0, Vec3::ZERO);
    for photons in [40, 72, 100] {
        let aim = Aim::new(&scene.at(0.0), &aimed_at(targets(1.0, Vec3::ZERO)), photons);
        let of = |iteration| emitted(&scene, &aim, photons, iteration).into_iter().map(|(_, e)| weight(&e));
        let sum: f64 = (0..ITERATIONS).flat_map(of).map(f64::from).sum();
        let mean = sum / f64::from(ITERATIONS * photons);
        assert!((mean - 1.0).abs() < FEW, "{photons} photons: {mean}");
    }
}

/// However light the photons are that are aimed at something small, their fluxes are rounded by as little as others'.
#[test]
fn light_photons_are_counted_as_finely_as_heavy_ones() {
    /// As `quantise` states it, of the brightest channel.
    const MOST: f64 = 1.0 / 16_384.0;
    let near = open(1.0, Vec3::ZERO);
    let sun = (Vec3::new(4e5, 7e5, 3e5), 6e3);
    let far =
        empty_scene(pinhole(Vec3::Z, Vec3::ZERO, 30.0)).lamp(sun.0, sun.1, BLACK, Rgb::new(3.0, 2.0, 1.0));
    let mut cases = 0;
    for (scene, radius) in [(&near, 1.0), (&near, 0.05), (&near, 1e-3), (&far, 1.0), (&far, 1e-3)] {
        let aim = Aim::new(&scene.at(0.0), &aimed_at(vec![Target::ball(Vec3::ZERO, radius)]), PHOTONS);
        let photons = emitted(scene, &aim, PHOTONS, 0);
        let lightest = photons.iter().map(|(_, e)| weight(e)).fold(f32::INFINITY, f32::min);
        assert!(lightest < 0.1 * radius * radius, "a weight of {lightest} at radius {radius}");
        for (photon, e) in &photons {
            let scale = f64::from(FLUX_ONE) * f64::from(aim.scale());
            for (value, power) in quantise(&aim, e.power).values().into_iter().zip(e.power.to_array()) {
                let error = (value as f64 / scale - f64::from(power)).abs();
                let most = MOST * f64::from(weight(e));
                assert!(
                    error <= most,
                    "photon {photon} at radius {radius}: {value} for {power} of {}",
                    weight(e)
                );
                cases += 1;
            }
        }
    }
    tell("physics", cases, "fluxes of light and heavy photons");
}

/// Each in a unit that keeps its brightest channel within 2^21 and no coarser than that needs, in steps of 2^8.
#[test]
fn heavy_photons_are_counted_in_coarser_units() {
    /// Half a step of the least units that the brightest channel may have, and the rounding of a sum of 24 bits.
    const ROUNDING: f64 = 0.75;
    let scene = open(1.0, Vec3::ZERO);
    let aim = Aim::new(&scene.at(0.0), &aimed_at(targets(1.0, Vec3::ZERO)), PHOTONS);
    let mut seen = Vec::new();
    for (octave, part) in (-20..38).flat_map(|octave| [1.0, 1.2, 1.999].map(|part| (octave, part))) {
        let scaled = part * 2.0_f32.powi(octave);
        let Flux { units, shift } = quantise(&aim, Rgb::new(0.25, 1.0, 0.5) * (scaled / aim.scale()));
        let step = f64::from(shift).exp2();
        for (units, share) in units.into_iter().zip([0.25, 1.0, 0.5]) {
            let exact = share * f64::from(scaled) * f64::from(FLUX_ONE) / step;
            assert!((f64::from(units) - exact).abs() <= ROUNDING, "{scaled}: {units} of 2^{shift}");
        }
        assert!(units[1] <= FLUX_ONE && shift % EXPONENT_STEP == 0, "{scaled}: {units:?} of 2^{shift}");
        let would_fit = f64::from(scaled) < f64::from(shift.saturating_sub(EXPONENT_STEP)).exp2();
        assert!(shift == 0 || !would_fit, "{scaled}: {units:?} of 2^{shift}");
        seen.push(shift);
    }
    seen.dedup();
    assert_eq!(seen, [0, 8, 16, 24, 32, 40]);
}

/// Of a few hundred thousand weights, which are not stratified from one iteration to the next.
const FEW: f64 = 2e-2;

/// Of photons that are aimed from afar: those whose lines pass the rim of the sun are dropped, and some at the rim of the ball.
const KEPT: f64 = 0.98;

/// A line of a sun that is known to some units at its lamp crosses small balls, or it does not, where it enters what is near.
#[test]
fn photons_of_a_far_sun_belong_to_the_target_that_they_are_drawn_for() {
    let sun = Vec3::new(0.48, 0.6, 0.64) * 1e6;
    let scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0))
        .ball(Vec3::ZERO, 1.0, diffuse(0.5))
        .lamp(sun, 4500.0, BLACK, Rgb::splat(3e4));
    let balls = [(Vec3::Z, 0.02), (Vec3::X, 0.1), (Vec3::Y * 0.5, 0.6)];
    let balls = balls.map(|(center, radius)| Target::ball(center, radius)).to_vec();
    let aim = Aim::new(&scene.at(0.0), &aimed_at(balls), 1 << 16);
    assert!(aim.core.is_some());
    let photons = emitted(&scene, &aim, 1 << 16, 0);
    let aimed = photons.iter().filter(|(p, _)| aim.component(*p) > 0);
    assert!(aimed.clone().count() > 1 << 14);
    // Of those that are drawn for a ball nearly all cross it, however small: the disk that they are drawn through is known far
    // better than the place on the sun.
    for k in 1..aim.ends.len() {
        let asked = f64::from(aim.ends[k] - aim.ends[k - 1]);
        let kept = aimed.clone().filter(|(photon, _)| aim.component(*photon) == k).count() as f64;
        assert!(kept > KEPT * asked, "ball {k}: {kept} of {asked}");
    }
    for (photon, e) in aimed {
        let most = 1.0 / aim.densities[aim.component(*photon)];
        assert!(weight(e) <= most * (1.0 + 1e-5), "photon {photon} weighs {}, not {most}", weight(e));
    }
}

/// A thirteenth of the photons, of which some are heavy.
const SHARE_OF_LAMPS: f64 = 4e-2;

/// Power per channel that crosses `detector`, by photons.
fn power_through(photons: &[(u32, Emitted)], all: u32, detector: &Target) -> DVec3 {
    let crossing = photons.iter().filter(|(_, e)| detector.is_crossed(e.ray.origin, e.ray.direction));
    let power = crossing.map(|(_, e)| e.power.as_dvec3()).sum::<DVec3>();
    power / f64::from(all)
}

/// The share of a lamp's lines, uniform over its surface and by the cosine, that cross a ball: by quadrature over the
/// angle to the axis and the overlap of two disks.
fn share_of_lines(r: f64, ball: f64, distance: f64) -> f64 {
    if distance + r <= ball {
        return 1.0;
    }
    let limit = ((r + ball) / distance).min(1.0).asin();
    let steps = 4000;
    let mut sum = 0.0;
    for i in 0..steps {
        let angle = (f64::from(i) + 0.5) / f64::from(steps) * limit;
        sum += overlap(r, ball, distance * angle.sin()) * TAU * angle.sin() * limit / f64::from(steps);
    }
    sum / (2.0 * TAU * std::f64::consts::PI * r * r)
}

/// Area that two disks share whose centres are `d` apart.
fn overlap(a: f64, b: f64, d: f64) -> f64 {
    let small = a.min(b);
    if d <= (a - b).abs() {
        return std::f64::consts::PI * small * small;
    }
    if d >= a + b {
        return 0.0;
    }
    let part = |a: f64, b: f64| a * a * ((d * d + a * a - b * b) / (2.0 * d * a)).clamp(-1.0, 1.0).acos();
    let kite = (-d + a + b) * (d + a - b) * (d - a + b) * (d + a + b);
    part(a, b) + part(b, a) - 0.5 * kite.max(0.0).sqrt()
}

#[test]
fn every_ball_receives_what_the_lamps_send_it() {
    for scale in [1.0, 1e-3, 1e6_f32] {
        let scene = open(scale, Vec3::ZERO);
        let still = scene.at(0.0);
        let aim = Aim::new(&still, &aimed_at(targets(scale, Vec3::ZERO)), PHOTONS);
        let photons = emitted(&scene, &aim, PHOTONS, 0);
        // Within targets, across a rim, and one of them: elsewhere few photons of great weight tell little.
        for (center, radius) in [
            (Vec3::new(0.02, 0.03, 0.0), 0.05),
            (Vec3::new(0.5, 0.0, 0.0), 0.3),
            (Vec3::new(1.5, 0.3, 0.2), 0.6),
            (Vec3::ZERO, 1.0),
            (Vec3::new(0.0, -12.0, 5.0), 40.0),
        ] {
            let detector = Target::ball(center * scale, radius * scale);
            let mut expected = DVec3::ZERO;
            for light in &still.lights.entries {
                let lamp = &still.spheres[light.sphere as usize];
                let (r, b) = (f64::from(lamp.radius), f64::from(detector.radius));
                let distance = lamp.center.as_dvec3().distance(detector.center.as_dvec3());
                let share = if light.inside { b * b / (r * r) } else { share_of_lines(r, b, distance) };
                expected += share * f64::from(light.probability) * light.photon_power.as_dvec3();
            }
            let actual = power_through(&photons, PHOTONS, &detector);
            let error = relative_error(actual.to_array(), expected.to_array());
            assert!(error < POWER, "{center} {radius} at {scale}: {actual}, not {expected}: {error:.3}");
        }
    }
    tell("physics", 15, "balls that receive what the lamps send");
}

/// Photons of the sky that fly down start among what stands on the ground. Where they started around the ground, which is 10^7 times
/// as wide, roundings would take most of them past a ball.
#[test]
fn a_tiny_ball_on_a_huge_ground_receives_what_the_sky_sends_from_above() {
    const TINY: f32 = 1e-3;
    const GROUND: f32 = 1e4;
    let scene = empty_scene(pinhole(Vec3::new(0.0, 2.0, 9.0) * TINY, Vec3::ZERO, 30.0))
        .ball(Vec3::NEG_Y * GROUND, GROUND, diffuse(0.5))
        .ball(Vec3::Y * TINY, TINY, diffuse(0.5));
    let scene = Scene { background: Rgb::new(0.5, 1.0, 0.7), ..scene }.with_sky();
    let still = scene.at(0.0);
    let ball = Target::ball(Vec3::Y * TINY, 0.5 * TINY);
    let around = [1.0, 1e2, 1e4, 3e7].map(|times| Target::ball(ball.center, ball.radius * times)).to_vec();
    let aim = Aim::new(&still, &aimed_at(around), PHOTONS);
    let photons: Vec<_> = emitted(&scene, &aim, PHOTONS, 0);
    // Away from the horizon, where the ground may stand in the way.
    let least_cos = 0.1;
    let from_above: Vec<_> = photons.into_iter().filter(|(_, p)| p.ray.direction.y < -least_cos).collect();
    let sky = still.spheres[still.lights.entries[0].sphere as usize].radius;
    let share = (f64::from(ball.radius) / f64::from(sky)).powi(2) * 0.5 * (1.0 - f64::from(least_cos));
    let expected = share * still.lights.entries[0].photon_power.as_dvec3();
    let actual = power_through(&from_above, PHOTONS, &ball);
    let error = relative_error(actual.to_array(), expected.to_array());
    assert!(error < POWER, "{actual}, not {expected}: {error:.3}");
    tell("physics", from_above.len(), "photons from above a tiny ball");
}

/// The power of the photons that meet some spheres first, and the number of those.
fn power_met(scene: &Scene, aim: &Aim, spheres: &[SphereId]) -> (DVec3, usize) {
    let still = scene.at(0.0);
    let meets = |ray: &Ray| intersect(&still, ray).is_some_and(|hit| spheres.contains(&hit.sphere));
    let met = emitted(scene, aim, PHOTONS, 0).into_iter().filter(|(_, e)| meets(&e.ray));
    let powers: Vec<DVec3> = met.map(|(_, e)| e.power.as_dvec3()).collect();
    (powers.iter().sum::<DVec3>() / f64::from(PHOTONS), powers.len())
}

/// Photons that start on the sun are uncertain by some hundred times the ball's radius where it stands. They miss what is near by far
/// more, or else it would receive them besides those that start beside it.
#[test]
fn a_tiny_ball_receives_what_a_far_sun_sends_and_no_more() {
    const TINY: f32 = 1e-3;
    let (sun, sun_radius) = (Vec3::new(4e5, 7e5, 3e5), 6e3);
    let center = Vec3::Y * TINY;
    let scene = empty_scene(pinhole(Vec3::new(0.0, 2.0, 9.0) * TINY, Vec3::ZERO, 30.0))
        .ball(Vec3::NEG_Y * 1e4, 1e4, diffuse(0.5))
        .ball(center, TINY, diffuse(0.5))
        .lamp(sun, sun_radius, BLACK, Rgb::new(3.0, 2.0, 1.0));
    let still = scene.at(0.0);
    let away = sun - center;
    assert!(f64::from(away.length() * f32::EPSILON) > 50.0 * f64::from(TINY), "all is certain");
    let around = (0..12).map(|power| Target::ball(center, 2.0 * TINY * 4.0_f32.powi(power)));
    let aim = Aim::new(&still, &aimed_at(around.collect()), PHOTONS);
    assert!(aim.core.is_some());
    let (actual, count) = power_met(&scene, &aim, &[1]);
    let share = share_of_lines(sun_radius.into(), TINY.into(), away.as_dvec3().length());
    let expected = share * still.lights.entries[0].photon_power.as_dvec3();
    let error = relative_error(actual.to_array(), expected.to_array());
    assert!(error < POWER, "{actual}, not {expected}: {error:.3}");
    tell("physics", count, "photons that meet a tiny ball");
}

/// Balls of a millimetre over a ground as wide as the Earth, under a sun of red and green: where rays of that sun are uncertain by more than a
/// ball, and by far less than the balls are apart, or where blue lamps stand at the rim of the core that would be around the balls alone.
#[test]
fn tiny_balls_far_apart_or_among_lamps_receive_what_a_far_sun_sends() {
    const TINY: f32 = 1e-3;
    let (sun, sun_radius) = (Vec3::new(5.7e5, 0.0, 5.7e5), 6e3);
    let [side, far_side] = [2.0 * TINY, 2.0].map(|y| [y, -y].map(|y| Vec3::new(0.0, y, 2.0 * TINY)));
    let lamps = [[3.0, 0.0], [0.0, 3.0], [2.3, 2.3]].map(|[x, y]| Vec3::new(x, y, 0.02));
    for (balls, lamps) in [(far_side, &lamps[..0]), (side, &lamps), (far_side, &lamps)] {
        let empty = empty_scene(pinhole(Vec3::new(9.0, 0.0, 2.0) * TINY, Vec3::ZERO, 30.0));
        let lit = empty.ball(Vec3::NEG_Z * 8e6, 8e6, diffuse(0.5)).lamp(
            sun,
            sun_radius,
            BLACK,
            Rgb::new(3.0, 2.0, 0.0),
        );
        let scene = balls.into_iter().fold(lit, |scene, place| scene.ball(place, TINY, diffuse(0.5)));
        let lamp = |scene: Scene, place: &Vec3| scene.lamp(*place, 0.01, BLACK, Rgb::new(0.0, 0.0, 1.0));
        let scene = lamps.iter().fold(scene, lamp);
        let still = scene.at(0.0);
        let each = balls.map(|place| Target::ball(place, 2.0 * TINY));
        let both = (0..8).map(|power| Target::ball(Vec3::ZERO, 2.0 * balls[0].y * 4.0_f32.powi(power)));
        let aim = Aim::new(&still, &aimed_at(each.into_iter().chain(both).collect()), PHOTONS);
        let is_of_sun = |light: usize| still.lights.entries[light].sphere == 1;
        let core = aim.core.as_ref().expect("the sun is far");
        assert!(
            (0..still.lights.entries.len()).all(|light| core.is_far[light] == is_of_sun(light)),
            "{core:?}"
        );
        let (actual, _) = power_met(&scene, &aim, &[2, 3]);
        let of_sun = still.lights.entries.iter().find(|light| light.sphere == 1).expect("it glows");
        let share = share_of_lines(sun_radius.into(), TINY.into(), sun.as_dvec3().length());
        let expected = 2.0 * share * f64::from(of_sun.probability) * of_sun.photon_power.as_dvec3();
        let error = (actual / expected - 1.0).truncate().abs().max_element();
        assert!(error < POWER, "{balls:?}, {}: {actual}, not {expected}: {error:.3}", lamps.len());
    }
    tell("physics", 3 * PHOTONS as usize, "photons above tiny balls");
}

/// A ball that is smaller than the lamps, which are aimed by runs of neighbours.
#[test]
fn a_small_ball_receives_what_many_large_lamps_send_it() {
    /// Of some ten thousand photons, each drawn for one to four lamps.
    const NOISE: f64 = 4e-2;
    let mut scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0));
    for k in 0..1800_u32 {
        let place = Vec3::new((k % 45) as f32 - 22.0, 6.0, (k / 45) as f32 - 20.0);
        scene = scene.lamp(place, 0.3, BLACK, Rgb::splat(1.0 + (k % 5) as f32));
    }
    let still = scene.at(0.0);
    let detector = Target::ball(Vec3::ZERO, 0.15);
    let aim = Aim::new(&still, &aimed_at(vec![detector]), PHOTONS);
    let in_runs = |group: &Group| Some(group.end - group.first).filter(|&lamps| lamps > 1);
    let lamps = still.lights.entries.len() as u32;
    assert!(aim.groups.iter().filter_map(in_runs).sum::<u32>() > lamps / 2, "most lamps are in runs");
    let share = |light: &scene::still::Light| {
        let lamp = &still.spheres[light.sphere as usize];
        let distance = f64::from(lamp.center.length());
        share_of_lines(lamp.radius.into(), detector.radius.into(), distance) * f64::from(light.probability)
    };
    let expected: f64 = still.lights.entries.iter().map(share).sum();
    let actual = power_through(&emitted(&scene, &aim, PHOTONS, 0), PHOTONS, &detector);
    let error = relative_error(actual.to_array(), [expected; 3]);
    assert!(error < NOISE, "{actual}, not {expected}: {error:.3}");
    tell("physics", 1, "balls that receive what many lamps send");
}

/// Some ten thousand photons of alike weights that cross a ball, were they not stratified.
const POWER: f64 = 2e-2;

#[test]
fn lines_of_the_sky_through_a_target_are_uniform() {
    lines_of_the_sky(Vec3::Z, 3.0);
    lines_of_the_sky(Vec3::Z, 0.7);
    lines_of_the_sky(Vec3::Z, 0.001);
}

/// Expects directions to be uniform in the cap of this height around the z axis, and places across the target.
fn lines_of_the_sky(axis: Vec3, height: f32) {
    let scene = empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0)).lamp(
        Vec3::new(3.0, -4.0, 5.0),
        50.0,
        BLACK,
        Rgb::ONE,
    );
    let target = Target { axis, height, ..Target::ball(Vec3::new(1.0, 2.0, 3.0), 0.7) };
    let aim = Aim::new(&scene.at(0.0), &aimed_at(vec![target]), PHOTONS);
    let photons: Vec<Emitted> = emitted(&scene, &aim, PHOTONS, 0)
        .into_iter()
        .filter(|(p, _)| aim.component(*p) == 1)
        .map(|(_, e)| e)
        .collect();
    let turns = |x: f64, y: f64| (y.atan2(x) / TAU + 1.0).fract();
    let below_one = 1.0 - f64::EPSILON;
    let directions = photons.iter().map(|e| e.ray.direction.as_dvec3());
    assert_uniform_square(
        directions
            .map(|d| [((1.0 - d.z) / f64::from(height.min(2.0))).clamp(0.0, below_one), turns(d.x, d.y)]),
        [24, 24],
        "directions",
    );
    let offsets = photons.iter().map(|e| {
        let (f, d) = ((e.ray.origin - target.center).as_dvec3(), e.ray.direction.as_dvec3());
        let offset = (f - d * f.dot(d)) / f64::from(target.radius);
        let (s, t) = d.any_orthonormal_pair();
        [offset.length_squared().min(below_one), turns(offset.dot(s), offset.dot(t))]
    });
    assert_uniform_square(offsets, [24, 24], "places across the target");
    tell("physics", photons.len(), "lines of the sky through a target");
}

#[test]
fn lines_of_a_lamp_to_a_target_are_uniform_where_they_cross_both() {
    // In line space lines of a lamp that cross a ball: uniform in direction times disk. Binned by direction about the
    // axis against the overlap of both disks.
    for (r, b) in [(0.5_f32, 2.0_f32), (2.0, 0.5), (1.0, 1.0)] {
        let distance = 6.0_f32;
        let scene =
            empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0)).lamp(Vec3::ZERO, r, BLACK, Rgb::ONE);
        let target = Target::ball(Vec3::X * distance, b);
        let aim = Aim::new(&scene.at(0.0), &aimed_at(vec![target]), PHOTONS);
        let (_, height) = cone(Vec3::ZERO, r, target.center, b);
        let slices = 12;
        let mut counts = vec![0_u32; slices];
        for (photon, e) in emitted(&scene, &aim, PHOTONS, 0) {
            if aim.component(photon) == 1 {
                let h = f64::from(1.0 - e.ray.direction.x) / f64::from(height);
                counts[((h * slices as f64) as usize).min(slices - 1)] += 1;
            }
        }
        let area = |i: usize| {
            let steps = 200;
            let one = |k: usize| {
                let h = (i as f64 + (k as f64 + 0.5) / f64::from(steps)) / slices as f64 * f64::from(height);
                let sine = (h * (2.0 - h)).sqrt();
                overlap(f64::from(r), f64::from(b), f64::from(distance) * sine)
            };
            (0..steps as usize).map(one).sum::<f64>()
        };
        let (areas, drawn): (Vec<f64>, u32) = ((0..slices).map(area).collect(), counts.iter().sum());
        let whole: f64 = areas.iter().sum();
        for (count, area) in counts.iter().zip(areas) {
            let expected = area / whole * f64::from(drawn);
            let deviation = (f64::from(*count) - expected).abs();
            assert!(deviation < 5.0 * expected.sqrt() + 5.0, "radii {r}, {b}: {counts:?}, not {expected}");
        }
    }
    tell("physics", 3, "densities of lines from lamp to ball");
}

#[test]
fn cones_hold_all_lines_that_cross_both_balls() {
    let mut stream = StreamKey::new(5, Family::Path, 0).stream(0);
    for _ in 0..20_000 {
        let mut place =
            |scale: f32| Vec3::from_array(std::array::from_fn(|_| (stream.next_f32() - 0.5) * scale));
        let (a, b) = (place(4.0), place(4.0) + Vec3::X * 6.0);
        let (ra, rb) = (0.1 + stream.next_f32(), 0.1 + 2.0 * stream.next_f32());
        let mut within = |c: Vec3, r: f32| {
            let v = Vec3::from_array(std::array::from_fn(|_| stream.next_f32() - 0.5));
            c + v.normalize() * (r * stream.next_f32())
        };
        let direction = (within(b, rb) - within(a, ra)).normalize();
        let (axis, height) = cone(a, ra, b, rb);
        assert!(1.0 - axis.dot(direction) <= height * 1.0001 + 1e-6, "a line leaves the cone");
    }
    tell("physics", 20_000, "lines within cones");
}

/// A plain, a ball of chalk and one of glass under a sky and a wide far sun.
fn meadow() -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::new(0.0, 3.0, 9.0), Vec3::Y * 0.7, 30.0))
        .ball(Vec3::Y * -1e4, 1e4, diffuse(0.6))
        .ball(Vec3::new(-1.2, 1.0, 0.0), 1.0, diffuse(0.8))
        .ball(Vec3::new(1.3, 1.0, 0.0), 1.0, glass(1.0, 1.5))
        .lamp(Vec3::new(5e4, 6e4, -2e4), 8e3, BLACK, Rgb::new(60.0, 50.0, 40.0));
    scene.background = Rgb::new(0.3, 0.4, 0.6);
    scene.with_sky()
}

/// Noise of both methods in blocks of 8x8, and the radius' blur of the caustic.
const SAME_BLOCK: f64 = 0.12;

/// And over the image.
const SAME_MEAN: f64 = 1e-2;

#[test]
fn an_open_scene_is_the_path_tracers_block_by_block() {
    let scene = meadow();
    let settings = Settings { iterations: 96, ..settings(64, 48, 50_000, 8, 0.3) };
    let targets = survey(&scene, &settings);
    assert!(!targets.shares.is_empty(), "nothing is aimed: {}", targets.expected);
    let aimed = render_aimed(&scene, &settings, &targets);
    let path = render_path_fast(&scene, &Settings { iterations: 2048, ..settings });
    let error = relative_error(mean(&aimed), mean(&path));
    assert!(error < SAME_MEAN, "{:?} and {:?}", mean(&aimed), mean(&path));
    assert_same_blocks(&aimed, &path, SAME_BLOCK);
    // Without aiming the plain below the balls gets no light from them.
    let uniform = render_aimed(&scene, &settings, &Targets::default());
    assert!(relative_error(mean(&uniform), mean(&path)) > SAME_MEAN, "nothing was to be gained");
    tell("physics", 48, "blocks of an open scene");
}

#[test]
fn whatever_photons_are_aimed_at_a_closed_room_looks_the_same() {
    let scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 2.9), Vec3::ZERO, 90.0))
        .ball(Vec3::ZERO, 3.0, diffuse(0.6))
        .lamp(Vec3::new(0.5, 1.0, 0.0), 0.3, BLACK, Rgb::splat(10.0))
        .lamp(Vec3::new(-1.0, 0.0, -1.0), 0.05, BLACK, Rgb::splat(100.0));
    let settings = Settings { iterations: 8, ..settings(32, 32, 100_000, 5, 0.2) };
    // The same camera paths, so that all that differs is what photons bring.
    let expected = mean(&render_aimed(&scene, &settings, &Targets::default()));
    for balls in [
        vec![Target::ball(Vec3::NEG_Z * 2.0, 1.0)],
        vec![
            Target::ball(Vec3::ZERO, 2.0),
            Target::ball(Vec3::ZERO, 0.5),
            Target::ball(Vec3::new(-1.0, 0.5, -1.0), 0.3),
        ],
        vec![Target::ball(Vec3::X * 3.0, 2.0), Target::ball(Vec3::new(2.0, 2.0, -2.0), 3.0)],
    ] {
        let targets = aimed_at(balls);
        let actual = mean(&render_aimed(&scene, &settings, &targets));
        let error = relative_error(actual, expected);
        assert!(error < SAME_MEAN, "{:?}: {actual:?} and {expected:?}", targets.balls);
    }
    tell("physics", 3, "closed rooms with photons aimed anywhere");
}

/// A lamp that flies through the room in the exposure, past a ball that is aimed at: photons leave it where it is at each instant, as
/// paths meet it.
#[test]
fn photons_are_aimed_from_lamps_where_they_are() {
    let mut scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 2.9), Vec3::ZERO, 90.0))
        .ball(Vec3::ZERO, 3.0, diffuse(0.6))
        .ball(Vec3::new(0.3, -1.2, 0.0), 0.8, diffuse(0.9))
        .lamp(Vec3::new(-2.2, 0.4, 0.0), 0.3, BLACK, Rgb::splat(10.0));
    scene.spheres[2].velocity = Vec3::X * 4.4;
    scene.camera.shutter = [0.0, 1.0];
    // The first iteration is at the beginning, so that photons which are aimed as in the first one miss the lamp.
    let seed = (1..1000).find(|seed| scene.camera.shutter_time(*seed, 0) < 0.1).unwrap();
    let settings = Settings { seed, iterations: 64, ..settings(64, 48, 40_000, 5, 0.2) };
    let expected = render_path_fast(&scene, &Settings { iterations: 1024, ..settings });
    let targets = aimed_at(vec![Target::ball(Vec3::new(0.3, -1.2, 0.0), 0.8), Target::ball(Vec3::ZERO, 1.5)]);
    let aimed = render_aimed(&scene, &settings, &targets);
    let error = relative_error(mean(&aimed), mean(&expected));
    assert!(error < SAME_MEAN, "{:?} and {:?}", mean(&aimed), mean(&expected));
    assert_same_blocks(&aimed, &expected, SAME_BLOCK);
    tell("physics", 1, "rooms with a moving lamp and photons aimed at a ball");
}

#[test]
fn closed_rooms_are_left_alone() {
    for name in ["cornell", "mirror", "random", "surgery"] {
        let scene = files::builtin::scene(name).unwrap();
        assert!(survey(&scene, &scene.settings).shares.is_empty(), "{name} is aimed");
    }
}

/// Sums of shares: some roundings of `f64`.
const SHARES: f64 = 1e-12;

#[test]
fn shares_sum_to_one_and_none_is_starved() {
    let scene = meadow();
    let targets = survey(&scene, &settings(64, 48, 1000, 8, 0.25));
    let sum: f64 = targets.shares.iter().sum();
    assert!((sum - 1.0).abs() < SHARES && targets.shares.iter().all(|&s| s > 1e-3), "{:?}", targets.shares);
    assert!(targets.shares[0] >= UNIFORM_SHARE);
    for photons in [1, 2, 7, 100, 1 << 20] {
        let aim = Aim::new(&scene.at(0.0), &targets, photons);
        assert_eq!(aim.ends.last(), Some(&photons));
        assert!(aim.ends.windows(2).all(|pair| pair[0] <= pair[1]), "{:?}", aim.ends);
        let uniform = f64::from(aim.ends[0]);
        assert!(
            f64::from(photons) / uniform <= 1.0 / UNIFORM_SHARE,
            "{photons} photons: {uniform} of them uniform"
        );
    }
    // Too few arrivals teach nothing.
    let few = vec![Arrival { point: Vec3::ZERO, source: Vec3::Y, flux: 1.0 }; 10];
    assert_eq!(Targets::new(&scene.at(0.0), few), Targets::default());
}

/// A surface at the origin that faces up, and a ball above the horizon at this distance and angle to the normal.
fn ball_over_surface(radius: f32, distance: f32, angle: f32) -> Target {
    Target::ball(Vec3::new(angle.sin(), 0.0, angle.cos()) * distance, radius)
}

/// Directions and weights of photons scattered at a surface at the origin that faces up, at 512 x 512 even numbers.
fn scattered(ball: &Target) -> impl Iterator<Item = (DVec3, f64)> {
    const SIDE: u32 = 512;
    let at = |k: u32| (k as f32 + 0.5) / SIDE as f32;
    (0..SIDE * SIDE).map(move |k| {
        let (direction, weight) = scatter_towards(ball, Vec3::ZERO, Vec3::Z, at(k / SIDE), at(k % SIDE));
        (direction.as_dvec3(), f64::from(weight) / f64::from(SIDE * SIDE))
    })
}

/// Means over a grid of 2^18 numbers: the rims of the ball and of the surface cut through its cells.
const SCATTERED: f64 = 5e-3;

#[test]
fn photons_scattered_towards_a_ball_carry_what_the_cosine_sends_in_each_direction() {
    for (radius, distance, angle) in [
        (1.0, 1.01, 0.1),
        (1.0, 1.5, 0.5),
        (1.0, 4.0, 0.8),
        (1e-3, 10.0, 1.0),
        (1.0, 1e4, 0.3),
        (0.02, 1.0, 1.5),
    ] {
        let ball = ball_over_surface(radius, distance, angle);
        let (mut power, mut mean, mut through) = (0.0, DVec3::ZERO, 0.0);
        for (direction, weight) in scattered(&ball) {
            power += weight;
            mean += direction * weight;
            through += if ball.is_crossed(Vec3::ZERO, direction.as_vec3()) { weight } else { 0.0 };
        }
        let case = format!("radius {radius}, distance {distance}, angle {angle}");
        assert!((power - 1.0).abs() < SCATTERED, "{case}: {power} of the power");
        // The mean direction by the cosine is two thirds of the normal.
        assert!((mean - DVec3::Z * 2.0 / 3.0).length() < SCATTERED, "{case}: {mean}");
        // A ball wholly above the horizon is met by the cosine times the square of the sine of its half angle.
        if (radius / distance).asin() + angle < std::f32::consts::FRAC_PI_2 {
            let form_factor = f64::from(angle).cos() * f64::from(radius / distance).powi(2);
            assert!((through / form_factor - 1.0).abs() < SCATTERED, "{case}: {through}, not {form_factor}");
        }
    }
    tell("physics", 6 << 18, "photons scattered towards balls");
}

/// Of the 2^17 photons drawn for the ball, most that rounding keeps from it: those near its rim.
const KEPT_AWAY: u32 = 1 << 14;

/// Weights and heights of cones: some roundings of `f32`.
const ROUNDING: f64 = 1e-5;

/// What crosses the ball is many light photons, not few heavy ones; and no photon is more than doubled.
#[test]
fn photons_scattered_towards_a_far_ball_are_light() {
    for (radius, distance, angle) in [(1.0, 4.0, 0.8), (1e-3, 10.0, 1.0), (1.0, 1e4, 0.3)] {
        let ball = ball_over_surface(radius, distance, angle);
        let (mut crossing, mut most) = (0_u32, 0.0_f64);
        for (direction, weight) in scattered(&ball) {
            let weight = weight * f64::from(1 << 18);
            assert!((0.0..=2.0).contains(&weight), "a weight of {weight}");
            if weight > 0.0 && ball.is_crossed(Vec3::ZERO, direction.as_vec3()) {
                crossing += 1;
                most = most.max(weight);
            }
        }
        let height = 1.0 - (1.0 - f64::from(radius / distance).powi(2)).sqrt();
        assert!(crossing > (1 << 17) - KEPT_AWAY, "{crossing} photons cross the ball");
        assert!(most <= 4.0 * height * (1.0 + ROUNDING), "a weight of {most} in a cap of height {height}");
    }
}

#[test]
fn photons_within_the_ball_are_scattered_by_the_cosine_alone() {
    for ball in
        [Target::ball(Vec3::X * 0.5, 0.6), Target::ball(Vec3::ZERO, 1e-3), Target::ball(Vec3::ZERO, 0.0)]
    {
        for (u, v) in [(0.1, 0.2), (0.7, 0.9), (0.0, 0.5)] {
            let expected = (reference::sampling::cosine_hemisphere(Vec3::Z, u, v), 1.0);
            assert_eq!(scatter_towards(&ball, Vec3::ZERO, Vec3::Z, u, v), expected, "{ball:?}");
        }
    }
}
