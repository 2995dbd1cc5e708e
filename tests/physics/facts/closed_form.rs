//! Closed forms that several facts share, in `f64`, and the pictures and photons to hold against them.

use crate::harness::{BLACK, Build, deposits, empty_scene, mean, pinhole, relative_error, settings};
use reference::Sppm;
use scene::film::FLUX_ONE;
use scene::{Engine, Material, Rgb, Scene, Settings, Vec3};

/// Relative tolerance of pictures whose paths are chosen at random at glass: 2^18 stratified samples, of which at least
/// a tenth reach a light. Independent ones would have a standard error of 0.6 %.
pub(super) const SAMPLED: f64 = 1e-2;

/// Relative tolerance of flux that arrives: at least 2 % of 2^20 photons. Independent ones would have a standard error
/// of 0.7 %, and stratified ones have less.
pub(super) const ARRIVED: f64 = 1e-2;

/// Relative tolerance of pictures without random choices: shadow rays to all of a lamp of a hundredth of its distance.
pub(super) const SMOOTH: f64 = 1e-3;

/// Reflectance for unpolarised light of a boundary to an index `ior` times as large; `sine` is that of the angle on the
/// side of the lower index.
pub(super) fn reflectance(sine: f64, ior: f64) -> f64 {
    let (low, high) = ((1.0 - sine * sine).sqrt(), (1.0 - (sine / ior).powi(2)).sqrt());
    let s = (low - ior * high) / (low + ior * high);
    let p = (ior * low - high) / (ior * low + high);
    f64::midpoint(s * s, p * p)
}

/// The mean of `f` over `0..most`, by the rule of midpoints.
pub(super) fn average(most: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 1 << 16;
    (0..STEPS).map(|i| f((f64::from(i) + 0.5) / f64::from(STEPS) * most)).sum::<f64>() / f64::from(STEPS)
}

/// Asserts that the channels agree within a relative `tolerance`.
#[track_caller]
pub(crate) fn assert_close(actual: [f64; 3], expected: [f64; 3], tolerance: f64, what: &str) {
    let error = relative_error(actual, expected);
    assert!(error < tolerance, "{what}: {actual:?} instead of {expected:?}, off by {error:.1e}");
}

/// The mean of the direct light in a picture that SPPM takes with 2^18 samples.
pub(crate) fn direct_light(scene: &Scene, depth: u32) -> [f64; 3] {
    let settings = Settings { iterations: 64, ..settings(64, 64, 1, depth, 1.0) };
    settings.validate().unwrap();
    let mut engine = Sppm::new(scene, &settings);
    for _ in 0..settings.iterations {
        engine.iterate();
    }
    mean(&engine.direct().unwrap()).map(|sum| sum / f64::from(settings.iterations))
}

/// The radiance of a diffuse surface of albedo 1 in the direct light of a lamp of radiance 1 and radius `radius` above
/// its horizon, where `to_lamp` leads from the surface to the lamp's centre.
pub(crate) fn lit(normal: Vec3, to_lamp: Vec3, radius: f32) -> f64 {
    let to_lamp = to_lamp.as_dvec3();
    (f64::from(radius) / to_lamp.length()).powi(2) * to_lamp.normalize().dot(normal.as_dvec3())
}

/// A scene whose pixels all show what is straight ahead of the eye at `eye`, along `direction`.
pub(super) fn straight_ahead(eye: Vec3, direction: Vec3) -> Scene {
    empty_scene(pinhole(eye, eye + direction, 1e-3))
}

/// The distance from the small lamp of [`a_lamp_beside`] to the centre of the ball, in radii of the ball.
const DISTANCE: f32 = 1.5;

/// A ball of radius 1 and of `material` beside a small lamp of radiance 1, in a black shell. Photons that meet the ball
/// first and leave it later are deposited on the shell, and no others are.
pub(super) fn a_lamp_beside(material: Material) -> Scene {
    empty_scene(pinhole(Vec3::Z * 90.0, Vec3::ZERO, 60.0))
        .ball(Vec3::ZERO, 100.0, BLACK)
        .lamp(Vec3::X * DISTANCE, 0.004, BLACK, Rgb::ONE)
        .ball(Vec3::ZERO, 1.0, material)
}

/// What arrives on sphere `sphere` of the power of all lights, per channel, in units of the power of the brightest.
pub(super) fn arriving(scene: &Scene, sphere: u32, depth: u32) -> [f64; 3] {
    let photons = 1 << 20;
    let (deposits, _) = deposits(scene, &settings(1, 1, photons, depth, 1.0));
    let mut sum = [0_u64; 3];
    for deposit in deposits.iter().filter(|deposit| deposit.sphere == sphere) {
        sum = [0, 1, 2].map(|c| sum[c] + u64::from(deposit.flux.units[c]));
    }
    sum.map(|flux| flux as f64 / (f64::from(photons) * f64::from(FLUX_ONE)))
}

/// The part of the light of [`a_lamp_beside`] that meets the ball, times the mean of `f` of the sine of its angle of
/// incidence.
pub(super) fn met(f: impl Fn(f64) -> f64) -> f64 {
    let distance = f64::from(DISTANCE);
    let most = 1.0 - (1.0 - 1.0 / (distance * distance)).sqrt();
    // Directions are uniform in 1 minus the cosine of their angle to the line of centres.
    let sine = |height: f64| distance * (height * (2.0 - height)).sqrt();
    0.5 * most * average(most, |height| f(sine(height).min(1.0)))
}
