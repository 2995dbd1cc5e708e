//! Helpers of the physics tests: build scenes in code, render them, and test statistics.

use reference::photon_pass::{Deposit, photon_pass};
use reference::{PathTracer, Sppm};
use scene::aim::{Aim, Targets};
use scene::{
    Camera, Engine, Film, Filter, Material, RadiusSchedule, Rgb, Scene, Settings, Sphere, Stats, Vec3,
};
use statrs::distribution::{ChiSquared, ContinuousCDF};

pub(crate) const BLACK: Material = diffuse(0.0);

/// A grey diffuse material.
pub(crate) const fn diffuse(albedo: f32) -> Material {
    Material::Diffuse { albedo: Rgb::splat(albedo) }
}

/// A diffuse material with an albedo per channel.
pub(crate) const fn coloured(albedo: [f32; 3]) -> Material {
    Material::Diffuse { albedo: Rgb::from_array(albedo) }
}

pub(crate) const fn mirror(albedo: f32) -> Material {
    Material::Specular { albedo: Rgb::splat(albedo) }
}

pub(crate) const fn glass(tint: f32, ior: f32) -> Material {
    Material::Dielectric { albedo: Rgb::splat(tint), ior }
}

/// A pinhole camera at `eye` that looks at `target`, with a vertical field of view in degrees.
pub(crate) fn pinhole(eye: Vec3, target: Vec3, fov: f32) -> Camera {
    let direction = target - eye;
    let up = if direction.y.abs() > 0.9 * direction.length() { Vec3::X } else { Vec3::Y };
    Camera {
        eye,
        direction,
        up,
        vertical_fov_degrees: fov,
        aperture_radius: 0.0,
        focus_distance: 1.0,
        shutter: [0.0, 0.0],
    }
}

/// A scene without spheres.
pub(crate) fn empty_scene(camera: Camera) -> Scene {
    Scene {
        name: "built in code".into(),
        camera,
        materials: Vec::new(),
        spheres: Vec::new().into(),
        background: Rgb::ZERO,
        transparent_background: false,
        imports: Vec::new(),
        settings: Settings::default(),
    }
}

/// Adds spheres to a scene, each with its own material.
pub(crate) trait Build: Sized {
    /// Adds a sphere that does not glow.
    fn ball(self, center: Vec3, radius: f32, material: Material) -> Self {
        self.lamp(center, radius, material, Rgb::ZERO)
    }

    /// Adds a sphere that glows.
    fn lamp(self, center: Vec3, radius: f32, material: Material, emission: Rgb) -> Self;
}

impl Build for Scene {
    fn lamp(mut self, center: Vec3, radius: f32, material: Material, emission: Rgb) -> Self {
        let index = self.materials.len() as u32;
        self.materials.push(material);
        self.spheres.push(Sphere { center, velocity: Vec3::ZERO, radius, material: index, emission });
        self
    }
}

/// Settings with one iteration and seed 1.
pub(crate) fn settings(width: u32, height: u32, photons: u32, depth: u32, radius: f32) -> Settings {
    Settings {
        width,
        height,
        iterations: 1,
        photons_per_iteration: photons,
        max_depth: depth,
        initial_radius: radius,
        seed: 1,
        filter: Filter::Box,
        radius_schedule: RadiusSchedule::PerPixel,
        radius_pilots: 0,
        radius_clearance: 0.0,
        light_samples: 1,
        glint_samples: 1,
    }
}

/// A little lamp in the middle of a ball of glass over a floor, which all its light reaches through the glass; and the radiance
/// of the floor below it, where irradiance is that of a point, `Phi / (4 pi h^2)`, less what the glass reflects back into
/// the lamp.
pub(crate) fn lamp_within_glass() -> (Scene, f64) {
    let (height, lamp, radiance, albedo) = (0.7_f64, 0.02_f64, 1e4_f64, 0.5_f64);
    // At normal incidence on an index of 1.5.
    let transmitted = 1.0 - 0.2_f64.powi(2);
    // `Phi = 4 pi^2 r^2 L`, and the floor reflects `albedo / pi`.
    let expected = transmitted * albedo * lamp * lamp * radiance / (height * height);
    let above = Vec3::new(0.0, height as f32, 0.0);
    let scene = empty_scene(pinhole(Vec3::new(5.0, 0.4, 0.0), Vec3::ZERO, 0.1))
        .ball(Vec3::new(0.0, -1000.0, 0.0), 1000.0, diffuse(albedo as f32))
        .ball(above, 0.5, glass(1.0, 1.5))
        .lamp(above, lamp as f32, BLACK, Rgb::splat(radiance as f32));
    (scene, expected)
}

/// The image after `settings.iterations` iterations.
pub(crate) fn run(mut engine: impl Engine, settings: &Settings) -> Film {
    for _ in 0..settings.iterations {
        engine.iterate();
    }
    engine.develop()
}

pub(crate) fn render_sppm(scene: &Scene, settings: &Settings) -> Film {
    settings.validate().unwrap();
    run(Sppm::new(scene, settings), settings)
}

pub(crate) fn render_path(scene: &Scene, settings: &Settings) -> Film {
    settings.validate().unwrap();
    run(PathTracer::new(scene, settings), settings)
}

/// [`render_sppm`] by the fast engine.
pub(crate) fn render_sppm_fast(scene: &Scene, settings: &Settings) -> Film {
    settings.validate().unwrap();
    run(fast::Sppm::new(scene, settings), settings)
}

/// [`render_path`] by the fast engine.
pub(crate) fn render_path_fast(scene: &Scene, settings: &Settings) -> Film {
    settings.validate().unwrap();
    run(fast::PathTracer::new(scene, settings), settings)
}

/// Whether the reference renders larger images too (`SPPM_PHYSICS_ENGINE=reference`). By default the fast engine does, whose
/// bits are the same. `scripts/faults` asks for the reference, as it puts some faults into the reference alone.
pub(crate) fn is_by_reference() -> bool {
    match std::env::var("SPPM_PHYSICS_ENGINE") {
        Ok(engine) if engine == "reference" => true,
        Ok(engine) if engine != "fast" => panic!("SPPM_PHYSICS_ENGINE: {engine:?} is not fast or reference"),
        _ => false,
    }
}

/// The image by one of two engines: see [`is_by_reference`].
pub(crate) fn render_by<F: Engine, R: Engine>(
    fast: impl FnOnce() -> F,
    reference: impl FnOnce() -> R,
    settings: &Settings,
) -> Film {
    settings.validate().unwrap();
    if is_by_reference() { run(reference(), settings) } else { run(fast(), settings) }
}

/// [`render_sppm`], by [`render_by`].
pub(crate) fn render_photons(scene: &Scene, settings: &Settings) -> Film {
    render_by(|| fast::Sppm::new(scene, settings), || Sppm::new(scene, settings), settings)
}

/// [`render_path`], by [`render_by`].
pub(crate) fn render_paths(scene: &Scene, settings: &Settings) -> Film {
    let by_fast = || fast::PathTracer::new(scene, settings);
    render_by(by_fast, || PathTracer::new(scene, settings), settings)
}

/// [`render_photons`] with photons aimed at `targets`.
pub(crate) fn render_aimed(scene: &Scene, settings: &Settings, targets: &Targets) -> Film {
    render_by(
        || fast::Sppm::new(scene, settings).aimed_at(targets.clone()),
        || Sppm::new(scene, settings).aimed_at(targets.clone()),
        settings,
    )
}

/// The photons that several iterations deposit at shutter time 0, and the work that was counted.
pub(crate) fn deposits(scene: &Scene, settings: &Settings) -> (Vec<Deposit>, Stats) {
    let (mut all, mut stats) = (Vec::new(), Stats::default());
    for iteration in 0..settings.iterations {
        let photons = 0..settings.photons_per_iteration;
        let still = scene.at(0.0);
        photon_pass(&still, &Aim::default(), settings, iteration, photons, &mut stats, |deposit, _| {
            all.push(*deposit);
        });
    }
    (all, stats)
}

/// The mean over all pixels, summed in `f64`.
pub(crate) fn mean(film: &Film) -> [f64; 3] {
    block_mean(film, 0..film.width, 0..film.height)
}

/// The mean over a rectangle of pixels, summed in `f64`.
pub(crate) fn block_mean(film: &Film, xs: std::ops::Range<u32>, ys: std::ops::Range<u32>) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let count = f64::from(xs.len() as u32 * ys.len() as u32);
    for (y, x) in ys.flat_map(|y| xs.clone().map(move |x| (y, x))) {
        let pixel = film.pixels[(y * film.width + x) as usize];
        for (total, value) in sum.iter_mut().zip(pixel.to_array()) {
            *total += f64::from(value);
        }
    }
    sum.map(|total| total / count)
}

/// The largest relative difference of any channel; infinite if a channel is zero in `expected` and not in `actual`.
pub(crate) fn relative_error(actual: [f64; 3], expected: [f64; 3]) -> f64 {
    let error = |(a, e): (f64, f64)| if a == e { 0.0 } else { ((a - e) / e).abs() };
    actual.into_iter().zip(expected).map(error).fold(0.0, f64::max)
}

/// Asserts that the image mean is `expected` within a relative `tolerance` in every channel.
#[track_caller]
pub(crate) fn assert_mean(film: &Film, expected: [f64; 3], tolerance: f64, what: &str) {
    let actual = mean(film);
    let error = relative_error(actual, expected);
    assert!(
        error <= tolerance,
        "{what}: mean {actual:?}, expected {expected:?}, off by {error:.2e} > {tolerance:.0e}"
    );
}

/// The p-value below which a statistical test fails. There are about a hundred of these, so with correct code only one
/// in 10^4 choices of the fixed seeds would fail a test; a real fault typically gives 10^-20 or less.
pub(crate) const SIGNIFICANCE: f64 = 1e-6;

/// The p-value of Pearson's chi-square test that all cells of `counts` are equally likely.
pub(crate) fn chi_square_p(counts: &[u32]) -> f64 {
    chi_square_p_of(counts, &vec![1.0 / counts.len() as f64; counts.len()])
}

/// The p-value of Pearson's chi-square test that the cells have the given probabilities.
pub(crate) fn chi_square_p_of(counts: &[u32], probabilities: &[f64]) -> f64 {
    assert_eq!(counts.len(), probabilities.len());
    let total: u64 = counts.iter().map(|&c| u64::from(c)).sum();
    let misfit = |(&count, probability): (&u32, &f64)| {
        let expected = total as f64 * probability;
        assert!(expected >= 20.0, "too few samples per cell for the chi-square approximation");
        (f64::from(count) - expected).powi(2) / expected
    };
    let statistic: f64 = counts.iter().zip(probabilities).map(misfit).sum();
    ChiSquared::new((counts.len() - 1) as f64).unwrap().sf(statistic)
}

/// Counts points of the unit square in `columns` x `rows` cells, and tests that they are uniformly distributed.
///
/// # Panics
/// If a point lies outside of the square.
#[track_caller]
pub(crate) fn assert_uniform_square(
    points: impl Iterator<Item = [f64; 2]>,
    [columns, rows]: [usize; 2],
    what: &str,
) {
    let mut counts = vec![0; columns * rows];
    for [x, y] in points {
        assert!(
            (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y),
            "{what}: ({x}, {y}) is out of the square"
        );
        counts[(y * rows as f64) as usize * columns + (x * columns as f64) as usize] += 1;
    }
    let p = chi_square_p(&counts);
    assert!(p > SIGNIFICANCE, "{what}: not uniform, p = {p:.1e}");
}

/// Expects all blocks of 8x8 pixels of two images of 64x48 to agree within `tolerance`.
pub(crate) fn assert_same_blocks(a: &Film, b: &Film, tolerance: f64) {
    for (x, y) in (0..6).flat_map(|y| (0..8).map(move |x| (x, y))) {
        let block = |film| block_mean(film, x * 8..x * 8 + 8, y * 8..y * 8 + 8);
        let error = relative_error(block(a), block(b));
        assert!(error < tolerance, "block {x}, {y}: {:?} and {:?}", block(a), block(b));
    }
}
