//! Glints: lamps that a pixel sees, directly or in a mirror or glass, by several rays.
//!
//! No shadow ray finds such a lamp, and it often looks smaller than a pixel: few paths meet it, and each that does is a spark.
//! So `N` further rays go through some pixels, and see in place of the pixel's own path the lamps that it meets before a diffuse
//! surface. With `e` for the light of these that a path brings, the mean of `M` of them,
//!
//! ```text
//! L = sum e / M
//! ```
//!
//! takes the place of `e_own`.
//!
//! - In a pixel in which the rim of a lamp may be seen ([`Rims`]), all `N` count: `M = N`.
//! - In others further rays are sent if the own path first meets a mirror or glass, and those count that do so too. `e` is then
//!   the light of lamps that a path meets after that. Given that the own path first meets a mirror or glass, `e` of each of the
//!   others that do has the same expectation as `e_own`, and so has the mean over however many these are; if none does, `e_own`
//!   itself stays.
//!
//! So both are unbiased. At glass a further ray is reflected or refracted by the roots of the shares of the power
//! ([`dielectric_by_roots`]): what a lamp sends by way of a weak reflection comes more often, at less weight.
//!
//! Glowing enclosures, such as the sky, are not small: the own path alone counts them.

use crate::camera_pass::{place_in_pixel, ray_through};
use crate::intersect::intersect;
use crate::scatter::{dielectric_by_roots, reflect};
use scene::camera::Frame;
use scene::filter::Table;
use scene::rng::{Family, Stream, StreamKey};
use scene::{Material, Ray, Rgb, Rims, Settings, Still};

/// The further rays of all pixels in one iteration.
pub struct GlintRays<'a> {
    /// The view.
    pub frame: &'a Frame,
    /// The table of the pixels' filter; `None` for the box.
    pub filter: Option<&'a Table>,
    /// Pixels in which the rims of lamps may be seen.
    pub rims: Option<&'a Rims>,
    /// The settings of the render.
    pub settings: &'a Settings,
    /// The number of the iteration, from 0.
    pub iteration: u32,
}

impl GlintRays<'_> {
    /// True if the rim of a lamp may be seen in pixel (x, y).
    pub fn is_rim(&self, x: u32, y: u32) -> bool {
        self.rims.is_some_and(|rims| rims.has(x, y))
    }

    /// The mean of what the further rays of pixel (x, y) that count bring of lamps, each times its weight by the filter; if none
    /// counts, what the `own` path brings. Adds to the `segments` traced.
    pub fn mean(&self, still: &Still, (x, y): (u32, u32), own: Rgb, segments: &mut u64) -> Rgb {
        let Settings { seed, width, glint_samples, .. } = *self.settings;
        let begun = self.is_rim(x, y).then_some(Rgb::ZERO);
        let (mut sum, mut count) = (Rgb::ZERO, 0);
        for ray in 0..glint_samples {
            let number = self.iteration.wrapping_mul(glint_samples).wrapping_add(ray);
            let mut stream = StreamKey::new(seed, Family::Glint, number).stream(y * width + x);
            let start = self.ray((x, y), &mut stream);
            if let Some(light) = trace(still, start, self.settings.max_depth, begun, &mut stream, segments) {
                sum += light;
                count += 1;
            }
        }
        if count == 0 { own } else { sum / count as f32 }
    }

    /// A random ray through pixel (x, y), and what it counts.
    fn ray(&self, (x, y): (u32, u32), stream: &mut Stream) -> (Ray, f32) {
        let mut pair = || (stream.next_f32(), stream.next_f32());
        let ((dx, dy), weight) = place_in_pixel(self.filter, pair());
        let lens = (self.frame.aperture_radius > 0.0).then(pair);
        (ray_through(self.frame, (x as f32 + dx, y as f32 + dy), lens), weight)
    }
}

/// The light of lamps that a path meets up to a diffuse surface, beginning with what has `begun`; `None` if that is `None` and
/// the path first meets no mirror or glass.
fn trace(
    still: &Still,
    (mut ray, weight): (Ray, f32),
    max_depth: u32,
    begun: Option<Rgb>,
    stream: &mut Stream,
    segments: &mut u64,
) -> Option<Rgb> {
    let (mut throughput, mut light) = (Rgb::splat(weight), begun);
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
                let (direction, scale) = dielectric_by_roots(ray.direction, &hit, ior, stream.next_f32());
                throughput *= scale;
                direction
            }
        };
        light = light.or(Some(Rgb::ZERO));
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
    light
}
