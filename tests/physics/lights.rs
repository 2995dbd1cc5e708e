//! Direct light compared with closed forms, and lamps that touch, intersect or are enclosed by other surfaces.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_mean, coloured, diffuse, empty_scene, glass, mean, mirror, pinhole, relative_error,
    render_paths, render_photons, settings,
};
use reference::direct_light::{estimate_irradiance, sample_light};
use reference::emission::{Emitted, emit};
use reference::light_choice::Receiver;
use reference::photon_numbers::PhotonNumbers;
use reference::photon_pass::photon_pass;
use reference::sampling::uniform_sphere;
use scene::aim::Aim;
use scene::rng::{Family, StreamKey};
use scene::still::Role;
use scene::{Film, Rgb, Scene, Settings, Stats, Still, Vec3};
use std::f64::consts::PI;

/// Relative tolerance of irradiance that is smooth: a few rounding errors per sample, averaged in `f64`. Cosines near
/// the horizon have the largest error.
const EXACT: f64 = 5e-6;

/// Relative tolerance of integrals over regular grids whose integrand has an edge (a horizon or a shadow).
const QUADRATURE: f64 = 2e-3;

/// The same where a lamp intersects the wall, and the irradiance jumps from 0 to half its maximum.
const SINGULAR: f64 = 5e-3;

/// Relative tolerance of image means that show a single point; stratified noise is below this.
const PATCH: f64 = 1e-3;

/// The mean of irradiance estimates over a regular grid of `side` x `side` random numbers, for a scene with one light,
/// in the red channel.
fn irradiance(still: &Still, receiver: &Receiver, side: u32) -> f64 {
    let place = |i: u32| (i as f32 + 0.5) / side as f32;
    let mut sum = 0.0;
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        sum += f64::from(estimate_irradiance(still, receiver, 0.5, place(i), place(j)).x);
    }
    sum / f64::from(side * side)
}

/// A lamp of radiance 1 above a receiving sphere (sphere 1) at the origin.
fn lamp_over_ball(center: Vec3, radius: f32) -> Scene {
    empty_scene(pinhole(Vec3::Z * 1e3, Vec3::ZERO, 1.0)).lamp(center, radius, BLACK, Rgb::ONE).ball(
        Vec3::ZERO,
        1.0,
        diffuse(0.8),
    )
}

#[test]
fn irradiance_of_a_lamp_above_the_horizon() {
    for (distance, radius) in
        [(1.5_f32, 0.4_f32), (4.0, 2.0), (10.0, 1.0), (300.0, 1.0), (1e4, 100.0), (50.0, 0.01)]
    {
        for tilt in [0.0_f64, 0.3, 0.8] {
            let normal = Vec3::new(0.0, tilt.sin() as f32, tilt.cos() as f32);
            let center = Vec3::Z * distance;
            let scene = lamp_over_ball(center, radius);
            let receiver = Receiver { point: normal, normal, sphere: 1 };
            let to_lamp = center.as_dvec3() - normal.as_dvec3();
            let d = to_lamp.length();
            let (sine, cosine) = (f64::from(radius) / d, to_lamp.dot(normal.as_dvec3()) / d);
            if cosine < sine {
                continue; // The horizon cuts the lamp.
            }
            // pi Le sin^2 cos, by the projected solid angle.
            let expected = PI * sine * sine * cosine;
            let actual = irradiance(&scene.at(0.0), &receiver, 32);
            assert!(
                (actual / expected - 1.0).abs() < EXACT,
                "{distance}, {radius}, {tilt}: {actual} not {expected}"
            );
        }
    }
    tell("physics", 18, "lamps above the horizon, or cut by it and left out");
}

#[test]
fn irradiance_of_a_lamp_that_the_horizon_halves() {
    for sine in [0.1_f32, 0.5, 0.9] {
        let scene = lamp_over_ball(Vec3::new(10.0, 0.0, 1.0), 10.0 * sine);
        let receiver = Receiver { point: Vec3::Z, normal: Vec3::Z, sphere: 1 };
        let s = f64::from(sine);
        let expected = s.asin() - s * (1.0 - s * s).sqrt();
        let actual = irradiance(&scene.at(0.0), &receiver, 512);
        assert!((actual / expected - 1.0).abs() < QUADRATURE, "sine {sine}: {actual} instead of {expected}");
    }
    tell("physics", 3, "lamps halved by the horizon");
}

#[test]
fn lamps_below_the_horizon_or_lighting_themselves_give_nothing() {
    let scene = lamp_over_ball(Vec3::NEG_Z * 10.0, 1.0);
    let still = scene.at(0.0);
    let away = Receiver { point: Vec3::Z, normal: Vec3::Z, sphere: 1 };
    assert_eq!(irradiance(&still, &away, 16), 0.0);
    let itself = Receiver { point: Vec3::NEG_Z * 9.0, normal: Vec3::Z, sphere: 0 };
    assert_eq!(irradiance(&still, &itself, 16), 0.0);
}

#[test]
fn a_shell_gives_pi_times_its_radiance_everywhere_within() {
    let scene = empty_scene(pinhole(Vec3::X, Vec3::ZERO, 60.0)).lamp(Vec3::ZERO, 7.0, BLACK, Rgb::ONE).ball(
        Vec3::new(2.0, 1.0, 0.0),
        1.0,
        diffuse(0.5),
    );
    for normal in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
        let receiver = Receiver { point: scene.spheres[1].center + normal, normal, sphere: 1 };
        let actual = irradiance(&scene.at(0.0), &receiver, 16);
        assert!((actual / PI - 1.0).abs() < EXACT, "{actual}");
    }
}

/// A black ball above the horizon hides the share `cos r^2 / d^2` of what a cosine weighs, wherever it is between here and the
/// shell.
#[test]
fn what_is_near_a_shell_hides_it_too() {
    /// Of a regular grid of directions, those at the outline.
    const GRID: f64 = 2e-3;
    let room = empty_scene(pinhole(Vec3::X * 5.0, Vec3::ZERO, 60.0)).lamp(Vec3::ZERO, 10.0, BLACK, Rgb::ONE);
    let room = room.ball(Vec3::ZERO, 1.0, diffuse(0.5));
    let way = Vec3::new(0.6, 0.0, 0.8);
    for (distance, radius) in [(1.5, 0.5), (4.0, 1.2), (6.5, 2.2), (8.0, 0.9)] {
        let scene = room.clone().ball(Vec3::Z + way * distance, radius, BLACK);
        let receiver = Receiver { point: Vec3::Z, normal: Vec3::Z, sphere: 1 };
        let actual = irradiance(&scene.at(0.0), &receiver, 128);
        let exact = PI * (1.0 - 0.8 * f64::from(radius / distance).powi(2));
        assert!((actual / exact - 1.0).abs() < GRID, "{actual}, not {exact}, at {distance}");
    }
}

#[test]
fn a_ball_under_a_far_lamp_is_lambertian() {
    // The eye looks at the top of the ball, with such a narrow field of view that all pixels show the same point.
    let (albedo, emission) = ([0.8, 0.4, 0.2], [1000.0, 2000.0, 500.0]);
    for tilt in [0.0_f64, 0.7, 1.3] {
        let lamp = Vec3::new(0.0, tilt.sin() as f32, tilt.cos() as f32) * 100.0;
        let scene = empty_scene(pinhole(Vec3::Z * 3.0, Vec3::Z, 0.01))
            .lamp(lamp, 1.0, BLACK, Rgb::from_array(emission))
            .ball(Vec3::ZERO, 1.0, coloured(albedo));
        let to_lamp = (lamp - Vec3::Z).as_dvec3();
        let (sine2, cosine) = (1.0 / to_lamp.length_squared(), to_lamp.z / to_lamp.length());
        let expected = [0, 1, 2].map(|c| f64::from(albedo[c]) * f64::from(emission[c]) * sine2 * cosine);
        for depth in [1, 5] {
            let settings = Settings { iterations: 4, ..settings(64, 64, 1000, depth, 0.1) };
            assert_mean(&render_photons(&scene, &settings), expected, PATCH, "SPPM");
            assert_mean(&render_paths(&scene, &settings), expected, PATCH, "path tracer");
        }
    }
    tell("physics", 12, "images of a ball under a far lamp");
}

/// Whatever its surface does with the light of others, a lamp sends its own: the irradiance of a lamp, by shadow rays and in images.
/// Glass of index 1 lets that of its inner side pass as well, to where photons and paths bring it; at depth 1 they do not.
#[test]
fn lamps_of_all_materials_light_alike() {
    let (distance, radius, albedo) = (4.0_f32, 1.0_f32, 0.5_f64);
    let share = f64::from(radius / distance).powi(2);
    for (material, sides) in [(BLACK, 1.0), (diffuse(0.7), 1.0), (mirror(0.6), 1.0), (glass(0.9, 1.0), 2.0)] {
        // The eye looks past the lamp, which is overhead.
        let scene = empty_scene(pinhole(Vec3::new(0.0, 3.0, 3.0), Vec3::Z, 0.01))
            .ball(Vec3::ZERO, 1.0, diffuse(albedo as f32))
            .lamp(Vec3::Z * (1.0 + distance), radius, material, Rgb::new(1.0, 2.0, 0.5));
        let still = scene.at(0.0);
        let receiver = Receiver { point: Vec3::Z, normal: Vec3::Z, sphere: 0 };
        let found = irradiance(&still, &receiver, 32);
        assert!((found / (PI * share) - 1.0).abs() < EXACT, "{material:?}: {found}");
        let power = sides * 2.0 * 4.0 * PI * PI * f64::from(radius * radius);
        assert!((f64::from(still.lights.power) / power - 1.0).abs() < EXACT, "{material:?}: {power}");
        let expected = [1.0, 2.0, 0.5].map(|emission| albedo * share * emission);
        let settings = Settings { iterations: 4, ..settings(16, 16, 100, 1, 0.1) };
        assert_mean(&render_photons(&scene, &settings), expected, PATCH, &format!("SPPM, {material:?}"));
        assert_mean(&render_paths(&scene, &settings), expected, PATCH, &format!("path tracer, {material:?}"));
    }
    tell("physics", 12, "irradiances of lamps of all materials");
}

/// A room of mirror that glows, around a ball in its middle: what leaves the ball comes back to it. So its radiance is
/// `rho e (1 + rho m + ...)`, with as many terms as there are whole turns of two segments within the depth.
#[test]
fn a_mirror_room_that_glows_lights_what_is_within() {
    /// Nothing is left to chance but which way a path takes, and all bring the same.
    const ALL_ALIKE: f64 = 1e-5;
    /// Of 2^18 photons some 1,500 come back to the part of the ball that is seen, or next to it: that is 2.6 % of less than half of
    /// the light, and this five times as much.
    const RETURNED: f64 = 0.06;
    let (albedo, reflectance) = (0.8, 0.9);
    let room = empty_scene(pinhole(Vec3::Z * 1.5, Vec3::ZERO, 40.0));
    let scene =
        room.lamp(Vec3::ZERO, 2.0, mirror(reflectance), Rgb::ONE).ball(Vec3::ZERO, 1.0, diffuse(albedo));
    let [rho, m] = [albedo, reflectance].map(f64::from);
    for (depth, terms) in [(1, 1), (2, 1), (3, 2)] {
        let expected = [(0..terms).map(|k| rho * (rho * m).powi(k)).sum::<f64>(); 3];
        let path = render_paths(&scene, &Settings { iterations: 4, ..settings(16, 16, 1, depth, 0.2) });
        assert_mean(&path, expected, ALL_ALIKE, &format!("path tracer, depth {depth}"));
        let (photons, tolerance) = if terms > 1 { (1 << 18, RETURNED) } else { (1000, ALL_ALIKE) };
        let sppm = render_photons(&scene, &settings(16, 16, photons, depth, 0.2));
        assert_mean(&sppm, expected, tolerance, &format!("SPPM, depth {depth}"));
    }
    tell("physics", 6, "mirror rooms that glow");
}

/// Two large lamps of different colours. The choice of a lamp must be independent of the choice of a point on it.
#[test]
fn a_ball_under_two_near_lamps_gets_the_light_of_each() {
    let lamps = [(Vec3::new(0.0, 3.0, 5.0), 3.0_f32, Rgb::X), (Vec3::new(-4.0, 0.0, 3.0), 1.5, Rgb::Y * 3.0)];
    let scene = lamps.into_iter().fold(
        empty_scene(pinhole(Vec3::Z * 3.0, Vec3::Z, 0.01)).ball(Vec3::ZERO, 1.0, diffuse(0.5)),
        |scene, (center, radius, emission)| scene.lamp(center, radius, BLACK, emission),
    );
    let share = |(center, radius, _): (Vec3, f32, Rgb)| {
        let to_lamp = (center - Vec3::Z).as_dvec3();
        (f64::from(radius) / to_lamp.length()).powi(2) * to_lamp.z / to_lamp.length()
    };
    let expected = [0.5 * share(lamps[0]), 0.5 * 3.0 * share(lamps[1]), 0.0];
    let settings = Settings { iterations: 128, ..settings(64, 64, 100, 1, 0.1) };
    assert_mean(&render_photons(&scene, &settings), expected, CHOSEN, "SPPM");
    assert_mean(&render_paths(&scene, &settings), expected, CHOSEN, "path tracer");
    tell("physics", 2, "images of a ball under two lamps");
}

/// The direction of the lamp, which is not an axis of any grid of directions.
const AXIS: Vec3 = Vec3::new(0.48, 0.6, 0.64);

/// A diffuse shell of radius 3, with a lamp of radius 1 at a distance of `offset` from its centre.
fn lamp_in_shell(offset: f32) -> Scene {
    empty_scene(pinhole(Vec3::Z * -1.5, Vec3::ZERO, 60.0)).ball(Vec3::ZERO, 3.0, diffuse(0.5)).lamp(
        AXIS * offset,
        1.0,
        diffuse(0.5),
        Rgb::ONE,
    )
}

/// Area of the part of the lamp inside the shell: by Archimedes, `2 pi a` times its height.
fn area_within(offset: f32) -> f64 {
    let d = f64::from(offset);
    if d <= 2.0 {
        return 4.0 * PI;
    }
    // Outward distance from the lamp's centre to the plane in which both spheres intersect.
    let plane = (d * d + 9.0 - 1.0) / (2.0 * d) - d;
    2.0 * PI * (1.0 + plane.clamp(-1.0, 1.0))
}

/// In the middle, close to the wall, touching it, and sunk into the wall very slightly, partly, by half and by more.
const OFFSETS: [f32; 7] = [0.0, 1.9, 2.0, 2.02, 2.5, 3.0, 3.5];

#[test]
fn a_sunk_lamp_lights_the_shell_with_the_power_of_what_is_not_sunk() {
    for offset in OFFSETS {
        let scene = lamp_in_shell(offset);
        let still = scene.at(0.0);
        let side = 200;
        let place = |i: u32| (i as f32 + 0.5) / side as f32;
        let mut sum = 0.0;
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let outward = uniform_sphere(place(i), place(j));
            let receiver = Receiver { point: outward * 3.0, normal: -outward, sphere: 0 };
            sum += irradiance(&still, &receiver, 8);
        }
        let power = sum / f64::from(side * side) * 36.0 * PI;
        let expected = PI * area_within(offset);
        let error = (power / expected - 1.0).abs();
        assert!(error < SINGULAR, "offset {offset}: {power} instead of {expected}, off by {error:.1e}");
    }
    tell("physics", OFFSETS.len(), "powers of sunk lamps by shadow rays");
}

#[test]
fn photons_leave_a_sunk_lamp_only_from_its_exposed_part() {
    for offset in OFFSETS {
        let scene = lamp_in_shell(offset);
        let settings = settings(1, 1, 1 << 18, 1, 1.0);
        let mut stats = Stats::default();
        photon_pass(
            &scene.at(0.0),
            &Aim::default(),
            &settings,
            0,
            0..settings.photons_per_iteration,
            &mut stats,
            |_, _| panic!("a photon is deposited at bounce 0"),
        );
        let share = stats.photon_segments as f64 / f64::from(1 << 18);
        let expected = area_within(offset) / (4.0 * PI);
        assert!(
            (share - expected).abs() < QUADRATURE * expected,
            "offset {offset}: {share} instead of {expected}"
        );
    }
    tell("physics", OFFSETS.len(), "powers of sunk lamps by photons");
}

/// A lamp of radius 1 at the origin, and a black ball of the given radius at the given distance.
fn lamp_by_ball(radius: f32, distance: f32) -> Scene {
    empty_scene(pinhole(Vec3::Z * -500.0, Vec3::ZERO, 60.0)).lamp(Vec3::ZERO, 1.0, BLACK, Rgb::ONE).ball(
        AXIS * distance,
        radius,
        BLACK,
    )
}

/// The share of that lamp's surface outside the ball, by Archimedes.
fn share_outside(radius: f32, distance: f32) -> f64 {
    let (r, d) = (f64::from(radius), f64::from(distance));
    // Distance from the lamp's centre towards the ball to the plane in which both spheres intersect.
    let plane = (d * d + 1.0 - r * r) / (2.0 * d);
    0.5 * (1.0 + plane.clamp(-1.0, 1.0))
}

/// Balls on both sides of a lamp: each hides its own part of it.
#[test]
fn all_balls_that_a_lamp_is_sunk_into_hide_it() {
    let photons = 1 << 17;
    for (radius, distance) in [(2.0, 2.5), (0.5, 1.2)] {
        let scene = lamp_by_ball(radius, distance).ball(AXIS * -distance, radius, BLACK);
        let settings = settings(1, 1, photons, 1, 1.0);
        let mut stats = Stats::default();
        photon_pass(&scene.at(0.0), &Aim::default(), &settings, 0, 0..photons, &mut stats, |_, _| {});
        let share = stats.photon_segments as f64 / f64::from(photons);
        let expected = 2.0 * share_outside(radius, distance) - 1.0;
        assert!((share - expected).abs() < STRATIFIED, "balls of {radius}: {share} instead of {expected}");
    }
}

/// A surface that is black in one channel reflects in the others as if it were not.
#[test]
fn each_channel_reflects_by_itself() {
    let pixel = |material| {
        let scene = empty_scene(pinhole(Vec3::Z * 5.0, Vec3::ZERO, 5.0))
            .ball(Vec3::ZERO, 1.0, material)
            .lamp(Vec3::new(2.0, 0.0, 6.0), 0.5, BLACK, Rgb::ONE);
        let settings = settings(8, 8, 1, 2, 1.0);
        [render_photons(&scene, &settings), render_paths(&scene, &settings)].map(|film| film.pixels[27])
    };
    for (grey, colour) in pixel(diffuse(0.5)).into_iter().zip(pixel(coloured([0.5, 0.0, 0.25]))) {
        assert!(grey.x > 0.0);
        assert_eq!(colour, Rgb::new(grey.x, 0.0, grey.x / 2.0));
    }
}

/// A small step in position; the conditions for a blocked lamp are tested this close to their limits.
const STEP: f32 = 1e-3;

#[test]
fn a_lamp_shines_where_no_ball_covers_it_however_little_that_is() {
    let photons = 1 << 17;
    let mut cases = 0;
    for radius in [0.5_f32, 2.0, 40.0] {
        // The distances at which the lamp touches the ball from outside, and at which it would be completely inside.
        let (touching, swallowed) = (radius + 1.0, radius - 1.0);
        let by_a_part = [0.3, 0.05, 0.01, STEP].map(|part| part * radius.min(1.0));
        let sunk = by_a_part.map(|depth| touching - depth);
        let peeking = by_a_part.map(|depth| swallowed + depth).into_iter().filter(|_| radius > 1.0);
        for distance in sunk.into_iter().chain(peeking).chain([touching + STEP]) {
            let (scene, what) = (lamp_by_ball(radius, distance), format!("ball {radius} at {distance}"));
            let still = scene.at(0.0);
            let expected = share_outside(radius, distance);
            assert_eq!(still.lights.blockers.contains(&1), expected < 1.0, "{what}: is it sunk?");
            let settings = settings(1, 1, photons, 1, 1.0);
            let mut stats = Stats::default();
            photon_pass(&still, &Aim::default(), &settings, 0, 0..photons, &mut stats, |_, _| {});
            let share = stats.photon_segments as f64 / f64::from(photons);
            assert!((share - expected).abs() < STRATIFIED, "{what}: {share} instead of {expected}");
            cases += 1;
        }
        if radius > 1.0 {
            let within = lamp_by_ball(radius, swallowed * (1.0 - STEP));
            assert!(within.at(0.0).lights.entries.is_empty(), "a lamp within a ball of {radius} shines");
            cases += 1;
        }
    }
    // The same for a shell: the lamp is just inside, slightly sunk into the wall, almost outside, and outside.
    for (offset, entries, blockers) in [
        (2.0 - 3.0 * STEP, 1, 0),
        (2.0 + 3.0 * STEP, 1, 1),
        (4.0 - 3.0 * STEP, 1, 1),
        (4.0 + 3.0 * STEP, 0, 0),
    ] {
        let lights = lamp_in_shell(offset).at(0.0).lights;
        assert_eq!((lights.entries.len(), lights.blockers.len()), (entries, blockers), "offset {offset}");
        cases += 1;
    }
    tell("physics", cases, "lamps sunk into balls and walls, by a touch and almost wholly");
}

/// Tolerance of a share of 2^17 stratified photons, whose error is below the 10^-3 of as many independent ones.
const STRATIFIED: f64 = 5e-4;

#[test]
fn both_engines_agree_about_sunk_lamps() {
    for offset in [2.0, 2.5, 3.0] {
        let mut scene = lamp_in_shell(offset);
        scene.camera = pinhole(AXIS * -2.8, AXIS, 70.0);
        let sppm = render_photons(&scene, &Settings { iterations: 8, ..settings(64, 64, 100_000, 8, 0.15) });
        let path = render_paths(&scene, &Settings { iterations: 64, ..settings(64, 64, 1, 8, 0.15) });
        let error = relative_error(mean(&sppm), mean(&path));
        assert!(error < SAME_MEAN, "offset {offset}: {:?} and {:?}", mean(&sppm), mean(&path));
    }
    tell("physics", 3, "images of sunk lamps");
}

/// A glowing ball of glass of index 1, which does not refract or reflect, lights what is inside it from its inner side.
#[test]
fn a_glowing_glass_ball_lights_what_is_within_from_its_inner_side() {
    let albedo = [0.8, 0.4, 0.2];
    let scene = |eye: Vec3| {
        empty_scene(pinhole(eye, Vec3::ZERO, 2.0)).lamp(Vec3::ZERO, 7.0, glass(1.0, 1.0), Rgb::ONE).ball(
            Vec3::ZERO,
            1.0,
            coloured(albedo),
        )
    };
    let receiver = Receiver { point: Vec3::X, normal: Vec3::X, sphere: 1 };
    // The inner side alone can light what is within, and whatever the number, it is chosen.
    for choice in [0.25, 0.75] {
        let actual =
            f64::from(estimate_irradiance(&scene(Vec3::X * 5.0).at(0.0), &receiver, choice, 0.3, 0.6).x);
        assert!((actual / PI - 1.0).abs() < EXACT, "{actual} instead of pi");
    }
    // Seen from inside the glass, the ball shows its albedo. Seen from outside, the emission of the near side is added.
    for (eye, seen) in [(5.0, 0.0), (12.0, 1.0)] {
        let scene = scene(Vec3::Z * eye);
        let settings = Settings { iterations: 64, ..settings(64, 64, 100, 5, 0.1) };
        let expected = albedo.map(|albedo| seen + f64::from(albedo));
        assert_mean(&render_photons(&scene, &settings), expected, CHOSEN, "SPPM");
        assert_mean(&render_paths(&scene, &settings), expected, CHOSEN, "path tracer");
    }
    tell("physics", 6, "irradiances and images of a ball in glowing glass");
}

/// Relative tolerance: means of at least 2^18 shadow rays to one of two random lights have noise of 0.2 %.
const CHOSEN: f64 = 1e-2;

/// From the centre of a glowing glass ball of index n, all rays hit its surface at right angles. The share
/// r = ((n - 1) / (n + 1))^2 is reflected to the other side, so the radiance is Le (1 + r + r^2 + ...).
#[test]
fn glowing_glass_shines_inwards_and_reflects_its_own_light() {
    for ior in [1.0_f32, 1.5, 2.4] {
        let scene =
            empty_scene(pinhole(Vec3::ZERO, Vec3::X, 60.0)).lamp(Vec3::ZERO, 3.0, glass(1.0, ior), Rgb::ONE);
        let n = f64::from(ior);
        let expected = [1.0 / (1.0 - ((n - 1.0) / (n + 1.0)).powi(2)); 3];
        let settings = Settings { iterations: 32, ..settings(64, 64, 1, 64, 1.0) };
        assert_mean(&render_photons(&scene, &settings), expected, QUADRATURE, "SPPM");
        assert_mean(&render_paths(&scene, &settings), expected, QUADRATURE, "path tracer");
    }
    tell("physics", 6, "images from within glowing glass");
}

/// A glowing ball of glass of index 1 at the centre of a diffuse shell. Light from its inner side comes out on the
/// other side, so it lights the shell with twice its radiance. It blocks no light, so the shell is a furnace.
#[test]
fn both_sides_of_a_glowing_glass_ball_light_the_shell_around_it() {
    let (albedo, depth) = (0.5_f64, 64);
    let scene = empty_scene(pinhole(Vec3::Z * 2.0, Vec3::Z * 3.0, 120.0))
        .ball(Vec3::ZERO, 3.0, diffuse(0.5))
        .lamp(Vec3::ZERO, 1.0, glass(1.0, 1.0), Rgb::ONE);
    // Pi times the area, for each of the two sides.
    let power = f64::from(scene.at(0.0).lights.power);
    assert!((power / (8.0 * PI * PI) - 1.0).abs() < EXACT, "power {power} is not that of two sides");
    let expected = [albedo * 2.0 / 9.0 / (1.0 - albedo); 3];
    let sppm = Settings { iterations: 2, ..settings(32, 32, 750_000, depth, 0.2) };
    assert_mean(&render_photons(&scene, &sppm), expected, SAME_MEAN, "SPPM");
    tell("physics", 1, "furnaces with glowing glass");
}

/// The same, by paths of two segments: the outer side is asked by shadow rays, from where a path arrives and once more from the shell;
/// the inner side is met by chance, where the path goes on through the near side that was asked before.
#[test]
fn paths_find_both_sides_of_a_glowing_glass_ball() {
    /// Half of 2^16 paths go on, and a ninth of these meet the ball, at twice the weight: unrelated ones would deviate by 0.7 % of
    /// all light, and this is five times as much.
    const MET: f64 = 3.5e-2;
    let (albedo, share) = (0.5_f64, 1.0 / 9.0);
    let scene = empty_scene(pinhole(Vec3::Z * 2.0, Vec3::Z * 3.0, 120.0))
        .ball(Vec3::ZERO, 3.0, diffuse(0.5))
        .lamp(Vec3::ZERO, 1.0, glass(1.0, 1.0), Rgb::ONE);
    let (outer, inner, again) = (albedo * share, albedo * share, albedo * albedo * (1.0 - share) * share);
    for (depth, expected) in [(1, outer), (2, outer + inner + again)] {
        let settings = Settings { iterations: 16, ..settings(64, 64, 1, depth, 0.2) };
        assert_mean(&render_paths(&scene, &settings), [expected; 3], MET, &format!("depth {depth}"));
    }
    tell("physics", 2, "images by paths of glowing glass");
}

/// Relative tolerance of image means: noise of 0.1 % in each engine, and the bias of SPPM where lamp and wall meet at a
/// sharp angle.
const SAME_MEAN: f64 = 5e-3;

/// Few lamps or many, what is sunk into a ball or stands out of the room sends no light from there: photons begin in the room and
/// out of all balls.
#[test]
fn photons_of_few_and_of_many_lamps_begin_in_free_space() {
    /// Roundings of places, as a share of the room's radius.
    const ROUNDING: f32 = 1e-6;
    for count in [3_u16, 16, 17, 40] {
        let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::X, 40.0)).ball(Vec3::Y, 10.0, diffuse(0.5));
        for k in 0..count {
            let (sin, cos) = (f32::from(k) * std::f32::consts::TAU / f32::from(count)).sin_cos();
            let direction = Vec3::new(cos, 0.0, sin);
            // Some are cut by the room and by a ball, some by one of both.
            let center = Vec3::Y + direction * [9.9, 8.0, 9.9][usize::from(k % 3)];
            scene = scene.lamp(center, 0.3, BLACK, Rgb::splat(f32::from(k % 4) + 1.0));
            if k % 3 < 2 {
                scene = scene.ball(center + Vec3::Y * 0.3, 0.25, diffuse(0.5));
            }
        }
        let (still, numbers) = (scene.at(0.0), PhotonNumbers::new(1, 0));
        let balls: Vec<_> = still.spheres[1..].iter().filter(|sphere| !sphere.is_emitter()).collect();
        let mut begun = 0;
        for photon in 0..20_000 {
            let Some(Emitted { ray, .. }) = emit(&still, &Aim::default(), &numbers, photon) else { continue };
            let away = ray.origin.distance(Vec3::Y);
            assert!(away < 10.0 * (1.0 + ROUNDING), "of {count}: {ray:?} begins outside of the room");
            let within = balls.iter().find(|ball| ray.origin.distance(ball.center) < ball.radius - 1e-5);
            assert_eq!(within, None, "of {count}: {ray:?}");
            begun += 1;
        }
        // About half of the lamps that the room cuts is outside, and a tenth of others in balls.
        assert!((9000..16_000).contains(&begun), "of {count}: {begun} photons begin");
    }
    tell("physics", 80_000, "beginnings of photons in free space");
}

/// A lamp that stands into two rooms around the eye, as far as it is in both: what direct light comes from is in both.
#[test]
fn direct_light_comes_from_what_all_rooms_leave_of_a_lamp() {
    /// Roundings of distances.
    const ROUNDING: f32 = 1e-4;
    let rooms = [(Vec3::new(-3.0, 0.0, 0.0), 6.0), (Vec3::new(3.0, 0.0, 0.0), 6.0)];
    let lamp = Vec3::new(0.0, 5.2, 0.0);
    let scene =
        rooms.into_iter().fold(empty_scene(pinhole(Vec3::ZERO, Vec3::Y, 60.0)), |scene, (center, radius)| {
            scene.ball(center, radius, diffuse(0.5))
        });
    let scene = scene.lamp(lamp, 1.5, BLACK, Rgb::ONE).ball(Vec3::NEG_Y * 2.0, 0.5, diffuse(0.5));
    let still = scene.at(0.0);
    // At the top of the ball, and at a place of each room.
    let receivers = [
        (Vec3::NEG_Y * 1.5, Vec3::Y, 3),
        (Vec3::new(2.0, 11.0_f32.sqrt() - 0.01, 0.0), Vec3::NEG_Y, 0),
        (Vec3::new(-2.9, 0.2, 0.0), Vec3::X, 1),
    ];
    let (mut seen, mut hidden) = (0, 0);
    for (point, normal, sphere) in receivers {
        let receiver = Receiver { point, normal, sphere };
        for (u, v) in
            (0..64).flat_map(|i| (0..64).map(move |j| ((i as f32 + 0.5) / 64.0, (j as f32 + 0.5) / 64.0)))
        {
            let Some((from, _)) = sample_light(&still, &receiver, 0.5, u, v) else {
                hidden += 1;
                continue;
            };
            let is_within = rooms.iter().all(|(center, radius)| from.distance(*center) < radius + ROUNDING);
            assert!(is_within, "{point} is lit from {from}");
            seen += 1;
        }
    }
    assert!(seen > 1000 && hidden > 1000, "{seen}, {hidden}");
    tell("physics", seen, "points of a lamp in two rooms");
}

/// Two rooms that glow and are cut by each other: what is in the middle of both sees the red one on one side and the green one on the
/// other. A quarter of each is within the other, and photons leave from there.
#[test]
fn rooms_that_glow_hide_each_other() {
    /// A quarter of 2^14 samples bring twice or four times the mean: unrelated ones would deviate by 1.4 %.
    const SIDES: f64 = 5e-2;
    /// Five deviations of a quarter of 2^16 photons, were they unrelated.
    const QUARTER: f64 = 9e-3;
    /// Roundings of places.
    const EDGE: f32 = 1e-5;
    let albedo = 0.5_f64;
    let scene = empty_scene(pinhole(Vec3::new(1.5, 1.0, 0.0), Vec3::NEG_Y * 1.5, 0.01))
        .lamp(Vec3::NEG_X * 3.0, 6.0, BLACK, Rgb::X)
        .lamp(Vec3::X * 3.0, 6.0, BLACK, Rgb::Y)
        .ball(Vec3::NEG_Y * 2.0, 0.5, diffuse(albedo as f32));
    let still = scene.at(0.0);
    let receiver = Receiver { point: Vec3::NEG_Y * 1.5, normal: Vec3::Y, sphere: 2 };
    let place = |i: u32| (i as f32 + 0.5) / 128.0;
    let mut sum = Rgb::ZERO.as_dvec3();
    for (i, j) in (0..128).flat_map(|i| (0..128).map(move |j| (i, j))) {
        for choice in [0.25, 0.75] {
            sum += estimate_irradiance(&still, &receiver, choice, place(i), place(j)).as_dvec3();
        }
    }
    let found = (sum / (2.0 * 128.0 * 128.0)).to_array();
    let error = relative_error(found, [PI / 2.0, PI / 2.0, 0.0]);
    assert!(error < QUADRATURE, "{found:?}");
    let settings = Settings { iterations: 4, ..settings(64, 64, 1, 1, 0.1) };
    let expected = [0.5 * albedo, 0.5 * albedo, 0.0];
    assert_mean(&render_photons(&scene, &settings), expected, SIDES, "SPPM");
    assert_mean(&render_paths(&scene, &settings), expected, SIDES, "path tracer");
    let (numbers, photons) = (PhotonNumbers::new(1, 0), 1 << 16);
    let left: Vec<Emitted> =
        (0..photons).filter_map(|photon| emit(&still, &Aim::default(), &numbers, photon)).collect();
    for Emitted { ray, power } in &left {
        // Of the red room the part at the side of the green one, and the other way round.
        assert!(power.x > 0.0 && ray.origin.x > -EDGE || power.y > 0.0 && ray.origin.x < EDGE, "{ray:?}");
    }
    let share = left.len() as f64 / f64::from(photons);
    assert!((share - 0.25).abs() < QUARTER, "{share}");
    tell("physics", left.len(), "photons of rooms that hide each other");
}

/// A ball whose middle is on the wall of a room that glows hides a cap of the wall, of `r^2 / (4 R^2)` of its area.
#[test]
fn a_room_that_glows_sends_nothing_from_within_a_ball_at_its_wall() {
    /// Five deviations of a share of 0.06 of 2^16 photons, were they unrelated.
    const SHARE: f64 = 5e-3;
    let (wall, radius) = (AXIS * 6.0, 3.0);
    let scene = empty_scene(pinhole(Vec3::ZERO, Vec3::X, 60.0))
        .lamp(Vec3::ZERO, 6.0, diffuse(0.5), Rgb::ONE)
        .ball(wall, radius, diffuse(0.5));
    let still = scene.at(0.0);
    let (numbers, photons) = (PhotonNumbers::new(1, 0), 1 << 16);
    let mut left = 0;
    for photon in 0..photons {
        let Some(Emitted { ray, .. }) = emit(&still, &Aim::default(), &numbers, photon) else { continue };
        assert!(ray.origin.distance(wall) > radius - 1e-5, "{ray:?} begins within the ball");
        left += 1;
    }
    let (share, expected) = (f64::from(left) / f64::from(photons), 1.0 - 9.0 / 144.0);
    assert!((share - expected).abs() < SHARE, "{share}, not {expected}");
    tell("physics", photons as usize, "photons of a room with a ball at its wall");
}

#[test]
fn an_enclosed_lamp_changes_no_pixel() {
    let scene = lamp_in_shell(1.0).ball(Vec3::Y * -1.5, 0.7, diffuse(0.4));
    let settings = Settings { iterations: 2, ..settings(16, 12, 2000, 5, 1.0) };
    let images =
        |scene: &Scene| -> [Film; 2] { [render_photons(scene, &settings), render_paths(scene, &settings)] };
    let expected = images(&scene);
    // Inside a ball, and outside the shell.
    for (center, radius) in [(Vec3::Y * -1.5, 0.5), (AXIS * 10.0, 2.0), (Vec3::ZERO, 4.0)] {
        let sealed = scene.clone().lamp(center, radius, BLACK, Rgb::splat(1e6));
        assert_eq!(sealed.at(0.0).lights.entries.len(), 1);
        assert!(images(&sealed) == expected, "a sealed lamp at {center} shows");
    }
}

#[test]
fn lights_are_weighted_by_their_power() {
    let scene = empty_scene(pinhole(Vec3::ZERO, Vec3::X, 60.0))
        .lamp(Vec3::X * 5.0, 1.0, BLACK, Rgb::new(1.0, 4.0, 2.0))
        .lamp(Vec3::X * -5.0, 2.0, BLACK, Rgb::new(3.0, 1.0, 0.5))
        .lamp(Vec3::ZERO, 20.0, BLACK, Rgb::splat(0.01));
    let still = scene.at(0.0);
    // pi times the area times the brightest channel.
    let weights = [4.0 * 1.0, 3.0 * 4.0, 0.01 * 400.0].map(|w: f64| w * 4.0 * PI * PI);
    let total: f64 = weights.iter().sum();
    assert!((f64::from(still.lights.power) / total - 1.0).abs() < EXACT);
    assert_eq!(still.lights.entries.len(), 3);
    for (light, weight) in still.lights.entries.iter().zip(weights) {
        assert!((f64::from(light.probability) * total / weight - 1.0).abs() < EXACT);
        // The brightest channel of a photon is the same for all lights.
        assert_eq!(light.photon_power.max_element(), 1.0);
    }
}

/// What hides a part of a lamp is found by the definition, be lamps few or many: the balls within which a part of its surface
/// lies, other lamps among them, and the rooms beyond which a part lies. Of glass nothing is hidden. Who is hidden entirely sends
/// no light.
#[test]
fn what_hides_a_part_of_a_lamp_is_found_whatever_the_number_of_lamps() {
    /// Surfaces that touch but for roundings count as either.
    const TOUCHING: f64 = 1e-4;
    let (mut parts, mut hidden) = (0, 0);
    for seed in 0..300 {
        let mut stream = StreamKey::new(41, Family::Survey, 0).stream(seed);
        let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::X, 30.0))
            .ball(Vec3::new(0.5, 0.0, 0.0), 9.0, diffuse(0.5))
            .ball(Vec3::new(-0.5, 0.3, 0.0), 9.5, diffuse(0.5));
        for k in 0..40 {
            let mut next = || stream.next_f32();
            let way = Vec3::from_array(std::array::from_fn(|_| next() - 0.5));
            let center = way * 20.0;
            let radius = (0.2 + 2.0 * next()).min(0.9 * center.length());
            // Few lamps of odd seeds, many of even ones.
            let glows = if seed % 2 == 1 { k % 10 == 0 } else { k % 3 > 0 };
            let material = if next() < 0.25 { glass(1.0, 1.5) } else { diffuse(0.5) };
            scene = scene.lamp(center, radius, material, if glows { Rgb::ONE } else { Rgb::ZERO });
        }
        let still = scene.at(0.0);
        for (id, lamp) in scene.spheres.iter().enumerate().filter(|(_, sphere)| sphere.is_emitter()) {
            let (mut some, mut unsure, mut all) = (Vec::new(), Vec::new(), false);
            for (other, sphere) in (0..).zip(scene.spheres.iter()).filter(|(other, _)| *other != id as u32) {
                let distance = lamp.center.as_dvec3().distance(sphere.center.as_dvec3());
                let [own, radius] = [lamp.radius, sphere.radius].map(f64::from);
                let [nearest, farthest] = [(distance - own).abs(), distance + own];
                let (edge, part, whole) = match still.roles[other as usize] {
                    Role::Glass => continue,
                    Role::Solid | Role::Ground(_) => (nearest, nearest < radius, farthest < radius),
                    Role::Enclosure(_) => (farthest, farthest > radius, nearest > radius),
                };
                all |= whole;
                if (edge / radius - 1.0).abs() < TOUCHING {
                    unsure.push(other);
                } else if part {
                    some.push(other);
                }
            }
            let lights = still.lights.entries.iter().filter(|light| light.sphere == id as u32);
            let mut sides = 0;
            for light in lights {
                let range = light.blockers.start as usize..light.blockers.end as usize;
                let found: Vec<u32> = still.lights.blockers[range]
                    .iter()
                    .copied()
                    .filter(|other| !unsure.contains(other))
                    .collect();
                assert_eq!(found, some, "{seed}: lamp {id}");
                sides += 1;
                parts += found.len();
            }
            assert_eq!(sides == 0, all, "{seed}: lamp {id}, of which {some:?} hide a part");
            hidden += usize::from(all);
        }
    }
    assert!(parts > 3000 && hidden > 300, "{parts} parts, {hidden} hidden");
    tell("physics", parts, "parts of lamps that are hidden");
}
