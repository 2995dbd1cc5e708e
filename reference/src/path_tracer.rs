//! A path tracer with next-event estimation: the unbiased truth for the same scene and the same depth.
//!
//! It shares intersection, scattering and direct light with SPPM, and none of what makes SPPM: no photons, no
//! density estimation. Paths are limited as SPPM's are: at most `max_depth` segments up to the first diffuse
//! surface, and at most as many from there to the light.

use crate::camera_pass::ray_through;
use crate::direct_light::{Receiver, estimate_irradiance};
use crate::intersect::intersect;
use crate::sampling::cosine_hemisphere;
use crate::scatter::{dielectric, reflect};
use rayon::prelude::*;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Engine, Film, Material, Plane, Ray, Rgb, Scene, Settings, Stats, Still, max_component};
use std::f32::consts::FRAC_1_PI;
use std::time::Instant;

/// The path tracer; an iteration is one sample per pixel.
pub struct PathTracer<'a> {
    scene: &'a Scene,
    settings: Settings,
    iterations: u32,
    /// Sums of radiance. In `f64`, as truth is asked for by the ten thousand samples.
    sums: Vec<[f64; 3]>,
    stats: Stats,
}

impl<'a> PathTracer<'a> {
    /// A render that has not begun.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        let sums = vec![[0.0; 3]; settings.pixels()];
        Self { scene, settings: *settings, iterations: 0, sums, stats: Stats::default() }
    }
}

impl Engine for PathTracer<'_> {
    fn iterate(&mut self) {
        let start = Instant::now();
        let still = self.scene.at(self.scene.camera.shutter_time(self.settings.seed, self.iterations));
        let frame = self.scene.camera.frame(self.settings.width, self.settings.height);
        let key = StreamKey::new(self.settings.seed, Family::Path, self.iterations);
        let (width, depth) = (self.settings.width, self.settings.max_depth);
        let row_of_paths = |(y, row): (usize, &mut [[f64; 3]])| {
            let mut segments = 0;
            for (x, sum) in row.iter_mut().enumerate() {
                let mut stream = key.stream(y as u32 * width + x as u32);
                let place = (x as f32 + stream.next_f32(), y as f32 + stream.next_f32());
                let lens = (stream.next_f32(), stream.next_f32());
                let ray = ray_through(&frame, place, (frame.aperture_radius > 0.0).then_some(lens));
                let radiance = trace(&still, ray, depth, &mut stream, &mut segments);
                for (total, value) in sum.iter_mut().zip(radiance.to_array()) {
                    *total += f64::from(value);
                }
            }
            segments
        };
        let rows = self.sums.par_chunks_mut(width as usize).enumerate();
        self.stats.camera_segments += rows.map(row_of_paths).sum::<u64>();
        self.stats.bytes = size_of_val(&self.sums[..]) as u64;
        self.iterations += 1;
        self.stats.camera_seconds += start.elapsed().as_secs_f64();
    }

    fn iterations(&self) -> u32 {
        self.iterations
    }

    fn develop(&self) -> Film {
        let Settings { width, height, .. } = self.settings;
        let scale = 1.0 / f64::from(self.iterations.max(1));
        let pixels = self.sums.iter().map(|s| Rgb::from_array(s.map(|v| (v * scale) as f32))).collect();
        Film { width, height, pixels }
    }

    fn direct(&self) -> Option<Film> {
        None
    }

    fn radius(&self) -> Option<Plane> {
        None
    }

    fn count(&self) -> Option<Plane> {
        None
    }

    fn stats(&self) -> &Stats {
        &self.stats
    }
}

/// The radiance that one random path brings.
fn trace(still: &Still, ray: Ray, max_depth: u32, stream: &mut Stream, segments: &mut u64) -> Rgb {
    let (mut ray, mut throughput, mut radiance) = (ray, Rgb::ONE, Rgb::ZERO);
    // The squared relative index of where the path is. Kept apart, as roulette is about the chance to find light.
    let mut radiance_scale = 1.0;
    let mut length = 0;
    let mut seen_diffuse = false;
    // Lamps met straight from a diffuse surface have been counted there, as direct light.
    let mut counts_lamps = true;
    while length < max_depth {
        length += 1;
        *segments += 1;
        let Some(hit) = intersect(still, &ray) else { break };
        if counts_lamps {
            radiance += throughput * radiance_scale * still.spheres[hit.sphere as usize].emission;
        }
        let material = still.material(hit.sphere);
        throughput *= material.albedo();
        let direction = match *material {
            Material::Diffuse { .. } => {
                if !seen_diffuse {
                    (seen_diffuse, length) = (true, 0);
                }
                if length < max_depth {
                    let receiver = Receiver { point: hit.point, normal: hit.normal, sphere: hit.sphere };
                    let [choice, u, v] = std::array::from_fn(|_| stream.next_f32());
                    let irradiance = estimate_irradiance(still, &receiver, choice, u, v);
                    radiance += throughput * (radiance_scale * FRAC_1_PI) * irradiance;
                }
                cosine_hemisphere(hit.normal, stream.next_f32(), stream.next_f32())
            }
            Material::Specular { .. } => reflect(ray.direction, hit.normal),
            Material::Dielectric { ior, .. } => {
                let (direction, scale) = dielectric(ray.direction, &hit, ior, stream.next_f32());
                radiance_scale *= scale;
                direction
            }
        };
        counts_lamps = !matches!(material, Material::Diffuse { .. });
        // Roulette by the throughput, which starts at 1, once direct light has been had.
        let survival = max_component(throughput).min(1.0);
        if seen_diffuse {
            if stream.next_f32() >= survival {
                break;
            }
            throughput /= survival;
        }
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
    radiance
}
