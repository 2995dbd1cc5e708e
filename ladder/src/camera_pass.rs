//! Camera pass: traces a path from the eye through every pixel to its visible point, one pixel per lane.

use crate::direct_light::{Receivers, irradiance};
use crate::intersect::{Rays, nearest, surface_at};
use crate::numbers::{Numbers, camera_dimension as dimension};
use crate::pixels::{Pixels, Seen};
use crate::sampling::{uniform_disk, unit};
use crate::scatter::{dielectric, reflect};
use crate::tables::Tables;
use crate::vector::{F, M, U, Vector};
use lanes::{Lanes, MOST_LANES};
use scene::camera::Frame;
use scene::ray::NO_SPHERE;
use scene::{Settings, Stats};
use std::f32::consts::FRAC_1_PI;

/// The inputs of the pass.
pub(crate) struct CameraPass<'a> {
    pub(crate) tables: &'a Tables<'a>,
    pub(crate) frame: &'a Frame,
    pub(crate) settings: &'a Settings,
    pub(crate) iteration: u32,
    /// Whether the properties of hit spheres are read from columns.
    pub(crate) from_columns: bool,
}

/// The paths being traced, one per lane.
struct Paths<V: Vector> {
    live: M<V>,
    rays: Rays<V>,
    throughput: V,
}

impl CameraPass<'_> {
    /// Traces the paths of all pixels.
    #[inline(always)]
    pub(crate) fn run<V: Vector, P: Pixels>(&self, pixels: &mut P, numbers: &mut Numbers, stats: &mut Stats) {
        let count = self.settings.pixels();
        for at in (0..count).step_by(V::L::N) {
            numbers.begin_camera_paths::<V::L>(self.iteration, at);
            let rays = self.rays::<V>(at, numbers);
            let paths = Paths { live: V::L::first(count - at), rays, throughput: V::splat(scene::Rgb::ONE) };
            let seen = self.trace(paths, numbers, stats);
            pixels.see(at, &seen);
        }
    }

    /// As `reference::camera_pass::trace`.
    #[inline(always)]
    fn trace<V: Vector>(&self, mut paths: Paths<V>, numbers: &mut Numbers, stats: &mut Stats) -> Seen<V> {
        let zero = V::zero();
        let mut seen = Seen {
            direct: zero,
            attenuation: zero,
            point: zero,
            normal: zero,
            incident: zero,
            sphere: V::L::u(NO_SPHERE),
            colour: zero,
            in_shell: V::L::first(0),
        };
        for segment in 0..self.settings.max_depth {
            if !V::L::any(paths.live) {
                break;
            }
            stats.camera_segments += u64::from(V::L::mask_bits(paths.live).count_ones());
            let (t, hit) = nearest::<V>(&self.tables.shapes, &paths.rays);
            let arrived = paths.live & V::L::lt(t, V::L::f(f32::INFINITY));
            paths.live = arrived;
            if !V::L::any(arrived) {
                break;
            }
            // Lanes that have hit nothing read sphere 0 instead.
            let hit = V::L::select_u(arrived, hit, V::L::u(0));
            let surface = surface_at::<V>(self.tables, &paths.rays, t, hit, self.from_columns);
            let lit = seen.direct + paths.throughput * surface.emission;
            seen.direct = V::select(arrived, lit, seen.direct);
            let lobe = numbers.lobe::<V::L>(segment);
            let attenuation = paths.throughput;
            paths.throughput = attenuation * surface.albedo;
            let ends = arrived & surface.is_diffuse;
            if V::L::any(ends) {
                let beta = paths.throughput.scale(V::L::f(FRAC_1_PI));
                let is_visible = ends & V::L::lt(V::L::f(0.0), beta.max_component());
                if V::L::any(is_visible) {
                    self.light(
                        &mut seen,
                        is_visible,
                        &surface.point,
                        &surface.normal,
                        hit,
                        beta,
                        numbers,
                        stats,
                    );
                    seen.attenuation = V::select(is_visible, attenuation, seen.attenuation);
                    seen.point = V::select(is_visible, surface.point, seen.point);
                    seen.normal = V::select(is_visible, surface.normal, seen.normal);
                    seen.incident = V::select(is_visible, paths.rays.direction, seen.incident);
                    seen.sphere = V::L::select_u(is_visible, hit, seen.sphere);
                    seen.colour = V::select(is_visible, surface.albedo, seen.colour);
                    seen.in_shell = seen.in_shell | (is_visible & surface.inside);
                }
                paths.live = arrived & !surface.is_diffuse;
            }
            if V::L::any(paths.live) {
                let (d, n) = (paths.rays.direction, surface.normal);
                let mut direction = reflect::<V>(d, n);
                let is_glass = paths.live & surface.is_glass;
                if V::L::any(is_glass) {
                    let (through, scale) = dielectric::<V>(d, n, surface.inside, surface.ior, lobe);
                    direction = V::select(is_glass, through, direction);
                    let scale = V::L::select(is_glass, scale, V::L::f(1.0));
                    paths.throughput = paths.throughput.scale(scale);
                }
                paths.rays = Rays { origin: surface.point, direction, leaves: hit };
            }
        }
        seen
    }

    /// Adds direct light on the visible points.
    #[allow(clippy::too_many_arguments)] // a part of `trace`, separate for readability
    #[inline(always)]
    fn light<V: Vector>(
        &self,
        seen: &mut Seen<V>,
        live: M<V>,
        point: &V,
        normal: &V,
        sphere: U<V>,
        beta: V,
        numbers: &mut Numbers,
        stats: &mut Stats,
    ) {
        let count = u64::from(V::L::mask_bits(live).count_ones());
        stats.shadow_rays += count;
        stats.visible_points += count;
        let [u, v] = numbers.pair::<V::L>(dimension::LIGHT_POINT);
        let choice = numbers.stratified::<V::L>(dimension::LIGHT);
        if self.tables.lights.is_empty() {
            return;
        }
        let receivers = Receivers { live, point: *point, normal: *normal, sphere };
        let light = irradiance::<V>(self.tables, &receivers, choice, u, v);
        seen.direct = V::select(live, seen.direct + beta * light, seen.direct);
    }

    /// The camera rays of the pixels from `at` on, as `reference::camera_pass::camera_ray`.
    #[inline(always)]
    fn rays<V: Vector>(&self, at: usize, numbers: &mut Numbers) -> Rays<V> {
        let (mut column, mut row) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
        let width = self.settings.width as usize;
        for lane in 0..V::L::N {
            column[lane] = ((at + lane) % width) as f32;
            row[lane] = ((at + lane) / width) as f32;
        }
        let frame = self.frame;
        let [u, v] = numbers.pair::<V::L>(dimension::PIXEL);
        let (x, y) = (V::L::load(&column) + u, V::L::load(&row) + v);
        let sx: F<V> = (x - V::L::f(frame.half[0])) * V::L::f(frame.pixel);
        let sy: F<V> = (V::L::f(frame.half[1]) - y) * V::L::f(frame.pixel);
        let (right, up) = (V::splat(frame.right), V::splat(frame.up));
        let to_image = V::splat(frame.forward) + right.scale(sx) + up.scale(sy);
        let (eye, leaves) = (V::splat(frame.eye), V::L::u(NO_SPHERE));
        if frame.aperture_radius > 0.0 {
            let aperture = V::L::f(frame.aperture_radius);
            let [u, v] = numbers.pair::<V::L>(dimension::LENS);
            let (dx, dy) = uniform_disk::<V>(u, v);
            let offset = right.scale(dx * aperture) + up.scale(dy * aperture);
            let direction = unit::<V>(to_image.scale(V::L::f(frame.focus_distance)) - offset);
            return Rays { origin: eye + offset, direction, leaves };
        }
        Rays { origin: eye, direction: unit::<V>(to_image), leaves }
    }
}
