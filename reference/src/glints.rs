//! Glints: lamps that a pixel sees in the mirror or glass that its path meets first.
//!
//! No shadow ray finds such a lamp, and it often looks smaller than a pixel there: few paths meet it, and each that does is a
//! spark. So where a pixel's own path first meets a mirror or glass, `N - 1` further rays go through the pixel, and those whose
//! first surface is a mirror or glass as well follow it until they meet a diffuse surface, or nothing. With `e` for what a path
//! brings of lamps after its first surface and before a diffuse one, and `M` paths that first meet a mirror or glass,
//!
//! ```text
//! L = (e_own + sum e) / M
//! ```
//!
//! takes the place of `e_own`. It is unbiased: given that the own path first meets a mirror or glass, each of the others
//! that do has the same distribution as it, and so has the mean over however many these are. Glowing enclosures, such as the
//! sky, are not small; the own path alone counts them, and what it meets first.

use crate::camera_pass::{place_in_pixel, ray_through};
use crate::intersect::intersect;
use crate::scatter::{dielectric, reflect};
use scene::camera::Frame;
use scene::filter::Table;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Material, Ray, Rgb, Settings, Still};

/// The further rays of all pixels in one iteration.
pub struct GlintRays<'a> {
    /// The view.
    pub frame: &'a Frame,
    /// The table of the pixels' filter; `None` for the box.
    pub filter: Option<&'a Table>,
    /// The settings of the render.
    pub settings: &'a Settings,
    /// The number of the iteration, from 0.
    pub iteration: u32,
}

impl GlintRays<'_> {
    /// The mean of what the own path of pixel (x, y) and those of the further rays that count bring of lamps, each times its
    /// weight by the filter. Adds to the `segments` traced.
    pub fn mean(&self, still: &Still, (x, y): (u32, u32), own: Rgb, segments: &mut u64) -> Rgb {
        let Settings { seed, width, glint_samples, .. } = *self.settings;
        let further = glint_samples - 1;
        let (mut sum, mut count) = (own, 1);
        for ray in 0..further {
            let number = self.iteration.wrapping_mul(further).wrapping_add(ray);
            let mut stream = StreamKey::new(seed, Family::Glint, number).stream(y * width + x);
            let start = self.ray((x, y), &mut stream);
            if let Some(light) = trace(still, start, self.settings.max_depth, &mut stream, segments) {
                sum += light;
                count += 1;
            }
        }
        sum / count as f32
    }

    /// A random ray through pixel (x, y), and what it counts.
    fn ray(&self, (x, y): (u32, u32), stream: &mut Stream) -> (Ray, f32) {
        let mut pair = || (stream.next_f32(), stream.next_f32());
        let ((dx, dy), weight) = place_in_pixel(self.filter, pair());
        let lens = (self.frame.aperture_radius > 0.0).then(pair);
        (ray_through(self.frame, (x as f32 + dx, y as f32 + dy), lens), weight)
    }
}

/// The light of lamps that a path meets after its first surface and up to a diffuse one; `None` if it first meets no mirror or
/// glass.
fn trace(
    still: &Still,
    (mut ray, weight): (Ray, f32),
    max_depth: u32,
    stream: &mut Stream,
    segments: &mut u64,
) -> Option<Rgb> {
    let (mut throughput, mut light) = (Rgb::splat(weight), None);
    for _ in 0..max_depth {
        *segments += 1;
        let Some(hit) = intersect(still, &ray) else { break };
        if let Some(light) = &mut light
            && !still.is_enclosure(hit.sphere)
        {
            *light += throughput * still.spheres[hit.sphere as usize].emission;
        }
        let material = still.material(hit.sphere);
        throughput *= material.albedo();
        let direction = match *material {
            Material::Diffuse { .. } => break,
            Material::Specular { .. } => reflect(ray.direction, hit.normal),
            Material::Dielectric { ior, .. } => {
                let (direction, scale) = dielectric(ray.direction, &hit, ior, stream.next_f32());
                throughput *= scale;
                direction
            }
        };
        light = light.or(Some(Rgb::ZERO));
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
    light
}
