//! A path tracer with next-event estimation: an unbiased ground truth for the same scene and the same depth.
//!
//! It shares intersection, scattering and direct light with SPPM, but has no photons and no density estimation. Paths
//! have the same limits as in SPPM: at most `max_depth` segments up to the first diffuse surface, and at most as many
//! from there to the light.
//!
//! A lamp is asked by shadow rays. A glowing enclosure, such as the sky, is not: a shadow ray to it would be drawn by the
//! cosine, as the direction is in which the path goes on. So it counts where that meets it. What a direction brings,
//! straight from the enclosure or by way of what stands before it, then comes of one number, and varies less than both by two;
//! and one ray does for two. If there is such light, a path is put to roulette where it arrives, not where it
//! departs, as the light may be all that there is to find, and only after some segments ([`SPARED`]).

use crate::camera_pass::{CameraNumbers, camera_ray};
use crate::direct_light::estimate_irradiance;
use crate::glints::GlintRays;
use crate::intersect::intersect;
use crate::light_choice::Receiver;
use crate::sampling::cosine_hemisphere;
use crate::scatter::{dielectric, reflect};
use rayon::prelude::*;
use scene::filter::Table;
use scene::hybrid::Sampler;
use scene::rng::Family;
use scene::{
    Engine, Material, Probe, Progress, Ray, Resumable, Rgb, Rims, Scene, Settings, Stats, Still, Stop, Sums,
    max_component,
};
use std::f32::consts::FRAC_1_PI;
use std::time::Instant;

/// The path tracer; an iteration is one sample per pixel.
pub struct PathTracer<'a> {
    scene: &'a Scene,
    progress: Progress,
    /// The table of the pixels' filter; `None` for the box.
    filter: Option<&'static Table>,
    rims: Option<Rims>,
    /// Sums of radiance; in `f64`, as ground truth takes tens of thousands of samples.
    sums: Vec<[f64; 3]>,
    /// The samples of the current iteration.
    samples: Vec<Rgb>,
    /// See [`PathTracer::without_caustics`].
    has_caustics: bool,
    /// What the samples took that are not added yet.
    sampled: Stats,
}

impl<'a> PathTracer<'a> {
    /// A render that has not begun.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        let (sums, samples) = (vec![[0.0; 3]; settings.pixels()], vec![Rgb::ZERO; settings.pixels()]);
        let filter = settings.filter.table();
        let progress = Progress::new(settings);
        let rims = Rims::new(scene, settings);
        Self { scene, progress, filter, rims, sums, samples, has_caustics: true, sampled: Stats::default() }
    }

    /// The same render without the light of lamps that mirrors and glass send on to a diffuse surface: what photons carry in
    /// [`scene::Hybrid`].
    #[must_use]
    pub fn without_caustics(self) -> Self {
        Self { has_caustics: false, ..self }
    }

    /// The radiance of a pixel; black before the first iteration.
    fn mean(&self, sums: &[f64; 3]) -> Rgb {
        let scale = 1.0 / f64::from(self.progress.iterations.max(1));
        Rgb::from_array(sums.map(|sum| (sum * scale) as f32))
    }
}

impl Engine for PathTracer<'_> {
    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn has_photons(&self) -> bool {
        false
    }

    fn probe(&self, x: u32, y: u32) -> Probe {
        let width = self.progress.settings.width;
        assert!(x < width, "no such pixel");
        Probe { radiance: self.mean(&self.sums[(y * width + x) as usize]), ..Probe::default() }
    }

    fn iterate_unless(&mut self, stop: &Stop) -> bool {
        self.sample_and_add_unless(stop)
    }
}

impl Sampler for PathTracer<'_> {
    fn sample_unless(&mut self, stop: &Stop) -> bool {
        let start = Instant::now();
        let Progress { settings, next, .. } = &self.progress;
        let still = self.scene.at(self.scene.camera.shutter_time(settings.seed, *next));
        let world = World { has_caustics: self.has_caustics, ..World::new(still) };
        let frame = self.scene.camera.frame(settings.width, settings.height);
        let width = settings.width;
        let (filter, rims) = (self.filter, self.rims.as_ref());
        let glints = GlintRays { frame: &frame, filter, rims, settings, iteration: *next };
        let row_of_paths = |(y, row): (usize, &mut [Rgb])| {
            let mut segments = 0;
            stop.meter().advance(width.into());
            for (x, sample) in row.iter_mut().enumerate() {
                if stop.is_requested() {
                    return None;
                }
                let mut numbers = PathNumbers::new(settings, *next, x as u32, y as u32);
                numbers.camera = numbers.camera.at_rim(glints.is_rim(x as u32, y as u32));
                let (ray, weight) = camera_ray(&frame, self.filter, x as u32, y as u32, &numbers.camera);
                let path = trace(&world, ray, settings.max_depth, &mut numbers, &mut segments);
                *sample = path.radiance * weight;
                if let Some(own) = path.glints {
                    *sample += glints.mean(&world.still, (x as u32, y as u32), own * weight, &mut segments);
                }
            }
            Some(segments)
        };
        stop.meter().begin(self.samples.len() as u64);
        let rows = self.samples.par_chunks_mut(width as usize).enumerate();
        let Some(segments) = rows.map(row_of_paths).sum::<Option<u64>>() else {
            return false;
        };
        self.sampled = Stats {
            camera_segments: segments,
            camera_seconds: start.elapsed().as_secs_f64(),
            bytes: (size_of_val(&self.sums[..]) + size_of_val(&self.samples[..])) as u64,
            ..Stats::default()
        };
        true
    }

    fn add_samples(&mut self) {
        for (sum, sample) in self.sums.iter_mut().zip(&self.samples) {
            for (total, value) in sum.iter_mut().zip(sample.to_array()) {
                *total += f64::from(value);
            }
        }
        self.progress.stats.add(&self.sampled);
        self.progress.advance();
    }
}

impl Resumable for PathTracer<'_> {
    fn sums(&self) -> Sums {
        Sums::Paths
    }

    fn save_row(&self, y: u32, words: &mut [u32]) {
        let width = self.progress.settings.width as usize;
        assert_eq!(words.len(), 6 * width, "not a row");
        let sums = self.sums[y as usize * width..][..width].as_flattened();
        for (words, sum) in words.chunks_exact_mut(2).zip(sums) {
            let bits = sum.to_bits();
            words.copy_from_slice(&[bits as u32, (bits >> 32) as u32]);
        }
    }

    fn load_row(&mut self, y: u32, words: &[u32]) {
        let width = self.progress.settings.width as usize;
        assert_eq!(words.len(), 6 * width, "not a row");
        let sums = self.sums[y as usize * width..][..width].as_flattened_mut();
        for (words, sum) in words.chunks_exact(2).zip(sums) {
            *sum = f64::from_bits(u64::from(words[0]) | u64::from(words[1]) << 32);
        }
    }

    fn go_on_after(&mut self, iterations: u32, stats: Stats) {
        self.progress.go_on_after(iterations, stats);
    }
}

/// Which dimensions of a pixel's Sobol point the path tracer uses otherwise than the camera pass: those of the choices at
/// glass serve the first two segments and, as a pair that is spread evenly, the direction in which a path leaves its first
/// diffuse surface.
mod dimension {
    pub(super) const LOBES: [usize; 2] = [8, 10];
    pub(super) const BOUNCE: [usize; 2] = [7, 9];
}

/// The segments after the first diffuse surface that are spared roulette if there is ambient light. In the open few paths meet a
/// surface again, so little work is saved, and those below balls are where the noise is.
const SPARED: u32 = 4;

/// The random numbers of one path: stratified as those of the camera pass up to the first diffuse surface, and for the
/// direction in which the path leaves it; the rest come from the pixel's own stream.
struct PathNumbers {
    camera: CameraNumbers,
}

impl PathNumbers {
    fn new(settings: &Settings, iteration: u32, x: u32, y: u32) -> Self {
        Self { camera: CameraNumbers::with_stream(Family::Path, settings, iteration, x, y) }
    }

    /// The next number of the stream.
    fn next_f32(&mut self) -> f32 {
        self.camera.stream.next_f32()
    }

    /// The number that chooses between reflection and refraction if the segment ends at glass; `segment` counts from the
    /// eye, and is `None` after the first diffuse surface.
    fn lobe(&mut self, segment: Option<u32>) -> f32 {
        match segment.and_then(|segment| dimension::LOBES.get(segment as usize)) {
            Some(&dimension) => self.camera.stratified(dimension),
            None => self.next_f32(),
        }
    }

    /// The numbers of light sample `sample` at the first diffuse surface, or at a later one.
    fn light(&mut self, is_first: bool, sample: u32) -> [f32; 3] {
        if is_first { self.camera.light(sample) } else { std::array::from_fn(|_| self.next_f32()) }
    }

    /// The numbers of the direction in which a path leaves a diffuse surface.
    fn bounce(&mut self, is_first: bool) -> (f32, f32) {
        if is_first { self.camera.pair(dimension::BOUNCE) } else { (self.next_f32(), self.next_f32()) }
    }
}

/// A still, and how paths come to its lights.
struct World<'a> {
    /// Direct light chooses among its lamps.
    still: Still<'a>,
    has_lamps: bool,
    /// True if paths meet lights that no shadow ray is sent to.
    has_ambient_lights: bool,
    /// See [`PathTracer::without_caustics`].
    has_caustics: bool,
}

impl<'a> World<'a> {
    fn new(still: Still<'a>) -> Self {
        let still = still.with_choice_of_lamps();
        let (has_lamps, has_ambient_lights) = (still.has_lamps(), still.has_ambient_lights());
        Self { still, has_lamps, has_ambient_lights, has_caustics: true }
    }
}

/// Russian roulette by the throughput, which starts at 1: true if the path survives.
fn survives(throughput: &mut Rgb, numbers: &mut PathNumbers) -> bool {
    let survival = max_component(*throughput).min(1.0);
    let survives = numbers.next_f32() < survival;
    *throughput /= survival;
    survives
}

/// What a random path brings.
struct PathLight {
    /// Its radiance, without [`Self::glints`].
    radiance: Rgb,
    /// The light of lamps that further rays through the pixel are to see as well, if it is to send any.
    glints: Option<Rgb>,
}

/// Traces one random path.
fn trace(
    world: &World,
    ray: Ray,
    max_depth: u32,
    numbers: &mut PathNumbers,
    segments: &mut u64,
) -> PathLight {
    let (mut ray, mut throughput, mut radiance) = (ray, Rgb::ONE, Rgb::ZERO);
    let has_glints = numbers.camera.has_glints(&world.still);
    let mut glints = (has_glints && numbers.camera.is_rim()).then_some(Rgb::ZERO);
    // The product of the factors from refraction. It is kept out of the throughput that decides roulette, as it does
    // not change the chance of a path to find light.
    let mut radiance_scale = 1.0;
    let mut length = 0;
    let mut seen_diffuse = false;
    // Lamps hit directly from a diffuse surface were already counted there, as direct light.
    let mut counts_lamps = true;
    let still = &world.still;
    while length < max_depth {
        length += 1;
        *segments += 1;
        let Some(hit) = intersect(still, &ray) else { break };
        let is_caustic = seen_diffuse && !world.has_caustics;
        if (counts_lamps && !is_caustic) || still.is_enclosure(hit.sphere) {
            let light = throughput * radiance_scale * still.spheres[hit.sphere as usize].emission;
            match &mut glints {
                Some(glints) if !seen_diffuse && !still.is_enclosure(hit.sphere) => *glints += light,
                _ => radiance += light,
            }
        }
        let is_late = seen_diffuse && length > SPARED;
        if is_late && world.has_ambient_lights && !survives(&mut throughput, numbers) {
            break;
        }
        let material = still.material(hit.sphere);
        let segment = (!seen_diffuse).then_some(length - 1);
        if has_glints && segment == Some(0) && !material.is_diffuse() {
            glints = glints.or(Some(Rgb::ZERO));
        }
        throughput *= material.albedo();
        if throughput == Rgb::ZERO {
            break;
        }
        let direction = match *material {
            Material::Diffuse { .. } => {
                let is_first = !seen_diffuse;
                if is_first {
                    (seen_diffuse, length) = (true, 0);
                }
                if length < max_depth && world.has_lamps {
                    let receiver = Receiver { point: hit.point, normal: hit.normal, sphere: hit.sphere };
                    let samples = if is_first { numbers.camera.light_samples() } else { 1 };
                    let share = 1.0 / samples as f32;
                    for sample in 0..samples {
                        let [choice, u, v] = numbers.light(is_first, sample);
                        let irradiance = estimate_irradiance(still, &receiver, choice, u, v);
                        radiance += throughput * (radiance_scale * FRAC_1_PI * share) * irradiance;
                    }
                }
                let (u, v) = numbers.bounce(is_first);
                cosine_hemisphere(hit.normal, u, v)
            }
            Material::Specular { .. } => reflect(ray.direction, hit.normal),
            Material::Dielectric { ior, .. } => {
                let (direction, scale) = dielectric(ray.direction, &hit, ior, numbers.lobe(segment));
                radiance_scale *= scale;
                direction
            }
        };
        counts_lamps = !matches!(material, Material::Diffuse { .. });
        if seen_diffuse && !world.has_ambient_lights && !survives(&mut throughput, numbers) {
            break;
        }
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
    PathLight { radiance, glints }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(name: &str) -> Scene {
        let scene = files::builtin::scene(name).unwrap();
        Scene { settings: Settings { width: 12, height: 9, ..scene.settings }, ..scene }
    }

    /// Paths survive by their brightest channel, and what they carry stays the same on the average.
    #[test]
    fn survivors_of_roulette_carry_what_others_lose() {
        let settings = Settings::default();
        let (mut survivors, count) = (0, 4000);
        for x in 0..count {
            let mut throughput = Rgb::new(0.25, 0.125, 0.0);
            survivors += u32::from(survives(&mut throughput, &mut PathNumbers::new(&settings, 0, x, 0)));
            assert_eq!(throughput, Rgb::new(1.0, 0.5, 0.0));
        }
        let share = f64::from(survivors) / f64::from(count);
        assert!((share - 0.25).abs() < 0.03, "{share}");
        // Brighter ones always do, and are not made brighter.
        let mut bright = Rgb::splat(3.0);
        assert!(
            survives(&mut bright, &mut PathNumbers::new(&settings, 0, 0, 0)) && bright == Rgb::splat(3.0)
        );
    }

    #[test]
    fn a_render_goes_on_from_its_rows() {
        let scene = scene("cornell");
        let mut whole = PathTracer::new(&scene, &scene.settings);
        assert_eq!(whole.probe(11, 8).radiance, Rgb::ZERO);
        whole.iterate();
        whole.iterate();
        let mut resumed = PathTracer::new(&scene, &scene.settings);
        for y in 0..9 {
            let mut words = vec![0; 12 * 6];
            whole.save_row(y, &mut words);
            resumed.load_row(y, &words);
        }
        resumed.go_on_after(2, *whole.stats());
        for _ in 0..2 {
            let done = |engine: &PathTracer| (engine.iterations(), engine.progress.next, *engine.stats());
            assert_eq!((&resumed.sums, done(&resumed)), (&whole.sums, done(&whole)));
            assert_eq!(resumed.probe(5, 7), whole.probe(5, 7));
            whole.iterate();
            resumed.iterate();
            whole.progress.stats = resumed.progress.stats; // of different times
        }
    }

    /// The image is the mean of all samples, and an iteration that is abandoned is none.
    #[test]
    fn samples_are_averaged_and_counted() {
        let (scene, stopped) = (scene("cornell"), Stop::new());
        stopped.request();
        let mut engine = PathTracer::new(&scene, &scene.settings);
        let mut sums = [0.0; 3];
        for n in 1..=3_u32 {
            assert!(!engine.iterate_unless(&stopped));
            assert_eq!(engine.iterations(), n - 1);
            engine.iterate();
            for (sum, value) in sums.iter_mut().zip(engine.samples[5 * 12 + 7].to_array()) {
                *sum += f64::from(value) / 3.0;
            }
        }
        let radiance = engine.probe(7, 5).radiance;
        assert_ne!(radiance, Rgb::ZERO);
        for (found, exact) in radiance.to_array().into_iter().zip(sums) {
            assert!((f64::from(found) - exact).abs() < 1e-6, "{radiance}, {sums:?}");
        }
        let stats = engine.stats();
        let paths = 3 * 12 * 9;
        assert!(
            stats.camera_segments >= 2 * paths
                && stats.camera_segments <= paths * 2 * u64::from(scene.settings.max_depth)
        );
        assert_eq!(stats.bytes, 12 * 9 * (24 + size_of::<Rgb>() as u64));
        assert!(stats.camera_seconds > 0.0 && !engine.has_photons());
    }

    /// Roulette needs no light to end: every path has at most as many segments as are allowed, twice.
    #[test]
    fn paths_have_at_most_their_depth() {
        let scene = scene("cornell");
        for max_depth in [1, 2, 5] {
            let world = World::new(scene.at(0.0));
            let frame = scene.camera.frame(12, 9);
            let mut most = 0;
            for (x, y) in (0..12).flat_map(|x| (0..9).map(move |y| (x, y))) {
                let mut numbers = PathNumbers::new(&scene.settings, 0, x, y);
                let (ray, _) = camera_ray(&frame, None, x, y, &numbers.camera);
                let mut segments = 0;
                trace(&world, ray, max_depth, &mut numbers, &mut segments);
                most = most.max(segments);
            }
            assert!(most > u64::from(max_depth) && most <= 2 * u64::from(max_depth), "{most} of {max_depth}");
        }
    }
}
