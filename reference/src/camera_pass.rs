//! Camera pass: traces a path from the eye through every pixel to its visible point.

use crate::direct_light::estimate_irradiance;
use crate::intersect::{Hit, intersect};
use crate::light_choice::Receiver;
use crate::sampling::{uniform_disk, unit};
use crate::scatter::{dielectric, reflect};
use scene::camera::Frame;
use scene::filter::Table;
use scene::ray::{NO_SPHERE, SphereId};
use scene::rng::{Family, Stream, StreamKey, unit_float};
use scene::sobol::{DIMENSIONS, morton, moved_on, sobol};
use scene::still::Carried;
use scene::{Material, Ray, Rgb, Settings, Stats, Still, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The point where a camera path meets its first diffuse surface, and where photons are gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisiblePoint {
    /// The point.
    pub point: Vec3,
    /// Unit normal on the side that the path came from.
    pub normal: Vec3,
    /// The sphere that the point lies on.
    pub sphere: SphereId,
    /// Radiance that the pixel receives per unit of flux density arriving here: the path's throughput times the BRDF
    /// `albedo / pi`. Not zero in all channels.
    pub beta: Rgb,
}

/// The result of one camera path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraSample {
    /// Radiance of lamps seen, and of direct light on the visible point; without [`Self::glints`].
    pub direct: Rgb,
    /// The light of lamps that further rays through the pixel are to see as well, if it is to send any ([`crate::glints`]).
    pub glints: Option<Rgb>,
    /// The visible point, unless the path escaped, was absorbed, or was cut off at the maximal depth.
    pub visible: Option<VisiblePoint>,
}

/// Which dimensions of a pixel's Sobol point are used for what: two each for the position in the pixel, on the light
/// and on the lens, one for the choice of a light, and one for each of the first four segments, used if it ends at
/// glass.
mod dimension {
    pub(super) const PIXEL: [usize; 2] = [0, 1];
    pub(super) const LIGHT_POINT: [usize; 2] = [2, 3];
    pub(super) const LIGHT: usize = 4;
    pub(super) const LENS: [usize; 2] = [5, 6];
    pub(super) const LOBES: [usize; 4] = [7, 8, 9, 10];
}

/// The random numbers of one camera path.
///
/// The numbers of the first dimensions are stratified over a tile of 8x8 pixels and over the iterations. They are the
/// pixel's Sobol point, with the digital shifts of the tile and a shift that grows from iteration to iteration. The
/// rest (at glass, after the first four segments) come from the pixel's own stream.
pub struct CameraNumbers {
    iteration: u32,
    light_samples: u32,
    glint_samples: u32,
    is_rim: bool,
    index: u32,
    shifts: [u32; DIMENSIONS],
    /// The numbers that are not stratified.
    pub(crate) stream: Stream,
}

impl CameraNumbers {
    /// The numbers of pixel (x, y) in iteration `iteration`.
    pub fn new(settings: &Settings, iteration: u32, x: u32, y: u32) -> Self {
        Self::with_stream(Family::Camera, settings, iteration, x, y)
    }

    /// The same, with the pixel's stream of another family.
    pub(crate) fn with_stream(family: Family, settings: &Settings, iteration: u32, x: u32, y: u32) -> Self {
        let tile = (y / 8) * settings.width.div_ceil(8) + x / 8;
        let mut tile_stream = StreamKey::new(settings.seed, Family::Tile, 0).stream(tile);
        let key = StreamKey::new(settings.seed, family, iteration);
        Self {
            iteration,
            light_samples: settings.light_samples,
            glint_samples: settings.glint_samples,
            is_rim: false,
            index: morton(x & 7, y & 7),
            shifts: std::array::from_fn(|_| tile_stream.next_u32()),
            stream: key.stream(y * settings.width + x),
        }
    }

    pub(crate) fn stratified(&self, dimension: usize) -> f32 {
        self.stratified_at(self.iteration, dimension)
    }

    /// As in iteration `iteration`.
    fn stratified_at(&self, iteration: u32, dimension: usize) -> f32 {
        let shifted = sobol(self.index, dimension) ^ self.shifts[dimension];
        unit_float(shifted.wrapping_add(moved_on(iteration, dimension)))
    }

    pub(crate) fn pair(&self, [a, b]: [usize; 2]) -> (f32, f32) {
        (self.stratified(a), self.stratified(b))
    }

    /// How many shadow rays the first diffuse surface sends.
    pub(crate) fn light_samples(&self) -> u32 {
        self.light_samples
    }

    /// The same of a pixel in which the rim of a lamp may be seen, if `is_rim`.
    #[must_use]
    pub fn at_rim(self, is_rim: bool) -> Self {
        Self { is_rim, ..self }
    }

    /// True if the rim of a lamp may be seen in the pixel.
    pub(crate) fn is_rim(&self) -> bool {
        self.is_rim
    }

    /// True if further rays are to see lamps as well.
    pub(crate) fn has_glints(&self, still: &Still) -> bool {
        self.glint_samples > 1 && still.has_lamps()
    }

    /// The numbers of one of these shadow rays: one to choose the light, two for the point on it. Those of all iterations
    /// are one sequence.
    pub(crate) fn light(&self, sample: u32) -> [f32; 3] {
        let place = self.iteration.wrapping_mul(self.light_samples).wrapping_add(sample);
        let [u, v] = dimension::LIGHT_POINT;
        [dimension::LIGHT, u, v].map(|d| self.stratified_at(place, d))
    }

    /// The number that chooses between reflection and refraction if segment `segment` ends at glass.
    fn lobe(&mut self, segment: u32) -> f32 {
        match dimension::LOBES.get(segment as usize) {
            Some(&dimension) => self.stratified(dimension),
            None => self.stream.next_f32(),
        }
    }
}

/// Traces one camera path of the given weight: follows mirrors and glass, adds the light of lamps that it hits, and at the first diffuse
/// surface estimates direct light and returns the visible point. If photons carry caustics alone, there is no direct light.
pub fn trace(
    still: &Still,
    (ray, weight): (Ray, f32),
    max_depth: u32,
    numbers: &mut CameraNumbers,
    stats: &mut Stats,
) -> CameraSample {
    let (mut ray, mut throughput, mut direct) = (ray, Rgb::splat(weight), Rgb::ZERO);
    let has_direct = still.carried == Carried::All;
    let has_glints = has_direct && numbers.has_glints(still);
    let mut glints = (has_glints && numbers.is_rim).then_some(Rgb::ZERO);
    for segment in 0..max_depth {
        stats.camera_segments += 1;
        let Some(hit) = intersect(still, &ray) else { break };
        if has_direct {
            let light = throughput * still.spheres[hit.sphere as usize].emission;
            match &mut glints {
                Some(glints) if !still.is_enclosure(hit.sphere) => *glints += light,
                _ => direct += light,
            }
        }
        let lobe = numbers.lobe(segment);
        let material = still.material(hit.sphere);
        if has_glints && segment == 0 && !material.is_diffuse() {
            glints = glints.or(Some(Rgb::ZERO));
        }
        throughput *= material.albedo();
        let direction = match *material {
            Material::Diffuse { .. } => {
                let beta = throughput * FRAC_1_PI;
                if beta == Rgb::ZERO {
                    break;
                }
                stats.visible_points += 1;
                if has_direct {
                    stats.shadow_rays += u64::from(numbers.light_samples);
                    direct += beta * irradiance(still, &hit, numbers);
                }
                let visible = VisiblePoint { point: hit.point, normal: hit.normal, sphere: hit.sphere, beta };
                return CameraSample { direct, glints, visible: Some(visible) };
            }
            Material::Specular { .. } => reflect(ray.direction, hit.normal),
            Material::Dielectric { ior, .. } => {
                let (direction, scale) = dielectric(ray.direction, &hit, ior, lobe);
                throughput *= scale;
                direction
            }
        };
        ray = Ray { origin: hit.point, direction, leaves: hit.sphere };
    }
    CameraSample { direct, glints, visible: None }
}

fn irradiance(still: &Still, hit: &Hit, numbers: &CameraNumbers) -> Rgb {
    let receiver = Receiver { point: hit.point, normal: hit.normal, sphere: hit.sphere };
    let mut sum = Rgb::ZERO;
    for sample in 0..numbers.light_samples {
        let [choice, u, v] = numbers.light(sample);
        sum += estimate_irradiance(still, &receiver, choice, u, v);
    }
    sum * (1.0 / numbers.light_samples as f32)
}

/// The camera ray of pixel (x, y), with a random position that the pixel's filter chooses, and on the lens if there is
/// one; and what the path counts.
pub fn camera_ray(
    frame: &Frame,
    filter: Option<&Table>,
    x: u32,
    y: u32,
    numbers: &CameraNumbers,
) -> (Ray, f32) {
    let (place, weight) = place_in_pixel(filter, numbers.pair(dimension::PIXEL));
    let lens = if frame.aperture_radius > 0.0 { Some(numbers.pair(dimension::LENS)) } else { None };
    (ray_through(frame, (x as f32 + place.0, y as f32 + place.1), lens), weight)
}

/// The position from the top left of a pixel that two uniform numbers give under `filter`, the box if there is none; and
/// what a sample there counts.
pub(crate) fn place_in_pixel(filter: Option<&Table>, (u, v): (f32, f32)) -> ((f32, f32), f32) {
    let Some(table) = filter else { return ((u, v), 1.0) };
    let ((x, weight_x), (y, weight_y)) = (table.place(u), table.place(v));
    ((x, y), weight_x * weight_y)
}

/// The ray through a position in the image, in pixels from the top left. Two uniform numbers give the point where it
/// leaves the lens; without them it is a pinhole.
pub fn ray_through(frame: &Frame, (x, y): (f32, f32), lens: Option<(f32, f32)>) -> Ray {
    let sx = (x - frame.half[0]) * frame.pixel;
    let sy = (frame.half[1] - y) * frame.pixel;
    let to_image = frame.forward + frame.right * sx + frame.up * sy;
    let Some((u, v)) = lens else {
        return Ray { origin: frame.eye, direction: unit(to_image), leaves: NO_SPHERE };
    };
    let (dx, dy) = uniform_disk(u, v);
    let offset = frame.right * (dx * frame.aperture_radius) + frame.up * (dy * frame.aperture_radius);
    let direction = unit(to_image * frame.focus_distance - offset);
    Ray { origin: frame.eye + offset, direction, leaves: NO_SPHERE }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays through the middle and the corners of an image.
    #[test]
    fn rays_go_through_their_places_in_the_image() {
        let scene = files::builtin::scene("cornell").unwrap();
        let frame = scene.camera.frame(40, 30);
        let middle = ray_through(&frame, (20.0, 15.0), None);
        assert!((middle.direction - unit(frame.forward)).length() < 1e-6 && middle.origin == frame.eye);
        let (left, right) = (ray_through(&frame, (0.0, 15.0), None), ray_through(&frame, (40.0, 15.0), None));
        assert!(left.direction.dot(frame.right) < 0.0 && right.direction.dot(frame.right) > 0.0);
        assert!((left.direction.dot(frame.right) + right.direction.dot(frame.right)).abs() < 1e-6);
        // Rows are counted from the top, and pixels are square.
        let up = |y: f32| ray_through(&frame, (20.0, y), None).direction.dot(frame.up);
        assert!(up(0.0) > 0.0 && up(30.0) < 0.0);
        let tan = |ray: Ray, axis: Vec3| ray.direction.dot(axis) / ray.direction.dot(frame.forward);
        let (x, y) = (
            tan(ray_through(&frame, (25.0, 15.0), None), frame.right),
            up(10.0) / (1.0 - up(10.0).powi(2)).sqrt(),
        );
        assert!((x / y - 1.0).abs() < 1e-5, "{x}, {y}");
    }

    /// All rays of a place meet in the plane of focus, and leave the lens everywhere within its rim.
    #[test]
    fn rays_from_a_lens_meet_in_focus() {
        let scene = files::builtin::scene("cornell").unwrap();
        let frame = Frame { aperture_radius: 2.0, focus_distance: 30.0, ..scene.camera.frame(40, 30) };
        let focus = |u, v| {
            let ray = ray_through(&frame, (33.0, 4.0), Some((u, v)));
            let from_eye = ray.origin - frame.eye;
            assert!((from_eye.length() - 2.0 * f32::sqrt(u)).abs() < 1e-3, "{from_eye}");
            let depth = 30.0 - from_eye.dot(frame.forward);
            ray.origin + ray.direction * (depth / ray.direction.dot(frame.forward))
        };
        let pinhole = ray_through(&frame, (33.0, 4.0), None).direction;
        let expected = frame.eye + pinhole * (30.0 / pinhole.dot(frame.forward));
        for (u, v) in [(0.0, 0.0), (0.5, 0.1), (0.9, 0.6)] {
            assert!((focus(u, v) - expected).length() < 1e-2, "{} not {expected}", focus(u, v));
        }
    }

    #[test]
    fn without_a_filter_a_sample_is_uniform_in_its_pixel() {
        assert_eq!(place_in_pixel(None, (0.25, 0.75)), ((0.25, 0.75), 1.0));
        let table = scene::Filter::Mitchell.table().unwrap();
        let ((x, y), weight) = place_in_pixel(Some(table), (0.25, 0.875));
        let ((of_x, weight_x), (of_y, weight_y)) = (table.place(0.25), table.place(0.875));
        assert_eq!(((x, y), weight), ((of_x, of_y), weight_x * weight_y));
    }

    /// Every pixel of a tile has numbers of its own, and so has every tile, iteration and shadow ray.
    #[test]
    fn numbers_are_stratified_over_tiles_and_iterations() {
        let settings = Settings { width: 20, height: 20, light_samples: 3, ..Settings::default() };
        let first = |iteration, x, y| CameraNumbers::new(&settings, iteration, x, y).stratified(0);
        let mut cells: Vec<u32> = (0..64).map(|i| (first(0, 8 + i % 8, 8 + i / 8) * 64.0) as u32).collect();
        cells.sort_unstable();
        assert_eq!(cells, (0..64).collect::<Vec<u32>>());
        let others =
            [first(0, 0, 0), first(0, 8, 0), first(0, 0, 8), first(0, 16, 0), first(1, 0, 0), first(0, 1, 0)];
        for (i, number) in others.iter().enumerate() {
            assert!(!others[..i].contains(number), "{others:?}");
        }
        // Shadow rays of all iterations are one sequence.
        let light = |iteration, sample| CameraNumbers::new(&settings, iteration, 3, 3).light(sample);
        assert_eq!(light(0, 4), light(1, 1));
        assert_eq!(light(2, 0), light(0, 6));
        assert_ne!(light(0, 0), light(0, 1));
    }

    /// The mean of so many shadow rays, each with its own numbers.
    #[test]
    fn light_samples_are_averaged() {
        let scene = files::builtin::scene("cornell").unwrap();
        let (still, frame) = (scene.at(0.0), scene.camera.frame(40, 30));
        for light_samples in [1, 2, 5] {
            let settings = Settings { width: 40, height: 30, light_samples, ..scene.settings };
            let numbers = CameraNumbers::new(&settings, 0, 20, 5);
            let (ray, _) = camera_ray(&frame, None, 20, 5, &numbers);
            let hit = intersect(&still, &ray).unwrap();
            let receiver = Receiver { point: hit.point, normal: hit.normal, sphere: hit.sphere };
            let one = |sample| {
                let [choice, u, v] = numbers.light(sample);
                estimate_irradiance(&still, &receiver, choice, u, v)
            };
            let mean = (0..light_samples).map(one).sum::<Rgb>() / light_samples as f32;
            let found = irradiance(&still, &hit, &numbers);
            assert!(
                mean.max_element() > 0.0 && (found - mean).abs().max_element() <= 1e-5 * mean.max_element(),
                "{found}, {mean}"
            );
            assert_eq!(numbers.light_samples(), light_samples);
        }
    }
}
