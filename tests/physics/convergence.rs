//! Convergence of progressive photon mapping: radii shrink by their law, and errors fall at the expected rates.

use crate::cases::tell;
use crate::harness::{Build, diffuse, empty_scene, pinhole, relative_error, settings};
use reference::consolidate::{ALPHA, Gathered, Pixel};
use reference::{PathTracer, Sppm};
use scene::film::{FLUX_ONE, FluxUnit};
use scene::{Engine, Film, Rgb, Scene, Settings, Vec3};
use statrs::function::gamma::ln_gamma;

const ITERATIONS: u32 = 64;

/// Relative tolerance. The law holds for mean counts. A pixel counts about 50 photons per iteration, whose noise has a
/// second-order effect of less than 1 %.
const RADIUS_LAW: f64 = 0.01;

/// A glowing shell, in which the radiance is 2 everywhere.
fn even_light() -> Scene {
    empty_scene(pinhole(Vec3::Z * 2.9, Vec3::ZERO, 90.0)).lamp(Vec3::ZERO, 3.0, diffuse(0.5), Rgb::ONE)
}

fn even_settings() -> Settings {
    settings(16, 16, 40_000, 32, 0.3)
}

fn mean_square(engine: &impl Engine) -> f64 {
    let radii = engine.radius().unwrap().values;
    radii.iter().map(|&r| f64::from(r).powi(2)).sum::<f64>() / radii.len() as f64
}

#[test]
fn radii_never_grow_and_follow_the_law() {
    let (scene, settings) = (even_light(), even_settings());
    let mut engine = Sppm::new(&scene, &settings);
    let mut before = engine.radius().unwrap();
    let mut radii = Vec::new();
    for n in 1..=ITERATIONS {
        engine.iterate();
        let after = engine.radius().unwrap();
        assert!(after.values.iter().zip(&before.values).all(|(a, b)| a <= b && *a > 0.0));
        before = after;
        // Under uniform light, R^2 shrinks by (i + alpha) / (i + 1) in iteration i, counted from 0. The product of
        // these factors is Gamma(n + alpha) / (Gamma(alpha) n!), which is of order n^(alpha - 1).
        let (n, alpha) = (f64::from(n), f64::from(ALPHA));
        let law = (ln_gamma(n + alpha) - ln_gamma(alpha) - ln_gamma(n + 1.0)).exp();
        let ratio = mean_square(&engine) / f64::from(settings.initial_radius).powi(2);
        assert!((ratio / law - 1.0).abs() < RADIUS_LAW, "after {n}: {ratio} instead of {law}");
        radii.push(mean_square(&engine).sqrt());
    }
    // For the paper's alpha of 2/3 that is a radius of order n^(-1/6).
    let order = (radii[63] / radii[3]).ln() / 16.0_f64.ln();
    assert!((order + 1.0 / 6.0).abs() < RADIUS_ORDER, "the radius is of order n^{order:.3}");
}

/// Tolerance of the exponent. The law deviates from a pure power by a factor of 1 - 1 / (9 n), which is less than 3 %
/// from 4 iterations on, or 0.005 in the exponent. The noise of the counts adds as much again.
const RADIUS_ORDER: f64 = 0.01;

#[test]
fn the_error_of_direct_light_falls_with_the_iterations() {
    // The horizon cuts the lamp in half, so half of the shadow rays contribute nothing. All pixels see the same point.
    let sine = 0.5_f64;
    let scene = empty_scene(pinhole(Vec3::Z * 3.0, Vec3::Z, 0.01))
        .lamp(Vec3::new(10.0, 0.0, 1.0), 5.0, diffuse(0.0), Rgb::ONE)
        .ball(Vec3::ZERO, 1.0, diffuse(0.5));
    let expected = 0.5 * (sine.asin() - sine * (1.0 - sine * sine).sqrt()) / std::f64::consts::PI;
    let settings = settings(64, 64, 1, 1, 1.0);
    let (mut sppm, mut path) = (Sppm::new(&scene, &settings), PathTracer::new(&scene, &settings));
    for engine in [&mut sppm as &mut dyn Engine, &mut path] {
        let mut errors = Vec::new();
        for n in 1..=256_u32 {
            engine.iterate();
            if n.is_power_of_two() && n.trailing_zeros() % 2 == 0 {
                let film = engine.develop();
                let square: f64 = film.pixels.iter().map(|p| (f64::from(p.x) - expected).powi(2)).sum();
                errors.push((square / film.pixels.len() as f64).sqrt());
            }
        }
        let order = (errors[4] / errors[0]).ln() / 256.0_f64.ln();
        assert!((-1.0..STRATIFIED_ORDER).contains(&order), "errors {errors:?} are of order n^{order:.3}");
    }
    tell("physics", 2, "orders of convergence of direct light");
}

/// Upper limit of the order for stratified numbers. For a smooth integrand they would give -1. The horizon is an edge,
/// for which two stratified dimensions give -0.75. Independent random numbers would give -0.5.
const STRATIFIED_ORDER: f64 = -0.7;

#[test]
fn errors_fall_with_the_iterations() {
    let (scene, settings) = (even_light(), even_settings());
    let mut engine = Sppm::new(&scene, &settings);
    let rmse = |film: &Film| {
        let square: f64 = film.pixels.iter().map(|p| (f64::from(p.x) - 2.0).powi(2)).sum();
        (square / film.pixels.len() as f64).sqrt()
    };
    let mut errors = Vec::new();
    for n in 1..=ITERATIONS {
        engine.iterate();
        if [1, 4, 16, 64].contains(&n) {
            errors.push(rmse(&engine.develop()));
        }
    }
    // The variance falls as n^-alpha, with the number of photons in the shrinking discs. For four times as many
    // iterations, the error falls by a factor of 4^(-1/3) = 0.63. The bound allows for the noise of an error estimated
    // over 256 pixels.
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.75 * pair[0], "{errors:?}");
    }
    assert!(errors[3] < 0.3 * errors[0], "{errors:?}");
}

/// Relative tolerance: about six rounding errors of 2^-24 in each of seven iterations.
const CONSOLIDATION: f64 = 2e-6;

#[test]
fn consolidation_is_that_of_the_paper() {
    let power = 3.0;
    let unit = FluxUnit::new(power, 1.0);
    let (beta, radius) = (Rgb::new(0.5, 0.25, 0.125), 2.0);
    let mut pixel = Pixel::new(radius);
    let (mut n, mut r2, mut tau) = (0.0_f64, 4.0_f64, [0.0_f64; 3]);
    for m in [10_u32, 0, 1, 250, 3, 0, 17] {
        let flux = [u64::from(m * FLUX_ONE), u64::from(m * (FLUX_ONE / 2)), u64::from(m)];
        pixel.consolidate((beta, pixel.radius_squared), &Gathered { m, flux: flux.map(u128::from) }, unit);
        if m > 0 {
            let kept = n + f64::from(m) * 2.0 / 3.0;
            let ratio = kept / (n + f64::from(m));
            for ((tau, beta), flux) in tau.iter_mut().zip(beta.to_array()).zip(flux) {
                let phi = flux as f64 / f64::from(FLUX_ONE) * f64::from(power);
                *tau = (*tau + f64::from(beta) * phi) * ratio;
            }
            (n, r2) = (kept, r2 * ratio);
        }
        assert!((f64::from(pixel.n) - n).abs() <= CONSOLIDATION * n);
        assert!((f64::from(pixel.radius_squared) / r2 - 1.0).abs() < CONSOLIDATION);
        assert!(relative_error(pixel.tau.as_dvec3().to_array(), tau) < CONSOLIDATION);
    }
    let settings = settings(1, 1, 1000, 5, radius);
    let expected = tau.map(|t| t / (7.0 * 1000.0 * std::f64::consts::PI * r2));
    let actual = pixel.develop(&settings, 7);
    assert!(relative_error(actual.as_dvec3().to_array(), expected) < CONSOLIDATION);
}

/// Radiance by the paper's equation, however many photons there were in all: more than 32 bits count.
#[test]
fn radiance_is_that_of_the_equation_however_many_photons_there_were() {
    /// Roundings of `f32`.
    const ROUNDING: f64 = 1e-6;
    let pixel =
        Pixel { direct: Rgb::new(3.0, 0.0, 1.0), tau: Rgb::new(0.0, 7e3, 2e3), n: 40.0, radius_squared: 0.3 };
    for (photons, iterations) in [(1000, 3), (65_536, 65_536), (200_000, 50_000), (1 << 28, 1 << 30)] {
        let settings = settings(8, 8, photons, 5, 1.0);
        let found = pixel.develop(&settings, iterations).as_dvec3();
        let n = f64::from(iterations);
        let disc = std::f64::consts::PI * f64::from(pixel.radius_squared);
        let expected = pixel.direct.as_dvec3() / n + pixel.tau.as_dvec3() / (n * f64::from(photons) * disc);
        let error = (found - expected).abs().max_element();
        assert!(
            error <= ROUNDING * expected.max_element(),
            "{photons} photons, {iterations} times: {found}, not {expected}"
        );
    }
}
