//! Pixels in which the rim of a lamp may be seen.
//!
//! A lamp that is seen directly covers a part of the pixels along its rim, and of small lamps that is all there are. In these
//! pixels the few samples that meet the lamp are the noise, so more rays are sent through them ([`Settings::glint_samples`]).
//! Which pixels they are need not be exact: a pixel too few is as noisy as it was, and one too many takes some time. A lamp is
//! taken for a disc around where its centre is when the shutter opens,
//!
//! ```text
//! tan(a) D / z < r < tan(a) (D / z)^2         sin(a) = R / D
//! ```
//!
//! as large across the line to the middle of the image and along it, at distance D from the eye and depth z; its rim is as wide
//! as the filter, and as the disc in which a lens blurs that depth.

use crate::camera::Frame;
use crate::settings::Settings;
use crate::world::Scene;
use std::f64::consts::SQRT_2;

/// The pixels of an image in which the rim of a lamp may be seen, at a bit each.
#[derive(Clone, Debug)]
pub struct Rims {
    width: u32,
    bits: Vec<u64>,
}

impl Rims {
    /// Those of a render; `None` if its pixels send one ray each.
    pub fn new(scene: &Scene, settings: &Settings) -> Option<Self> {
        if settings.glint_samples == 1 {
            return None;
        }
        let mut rims = Self { width: settings.width, bits: vec![0; settings.pixels().div_ceil(64)] };
        let frame = scene.camera.frame(settings.width, settings.height);
        let margin = SQRT_2 * settings.filter.radius();
        let opening = scene.camera.shutter[0];
        for lamp in scene.spheres.iter().filter(|sphere| sphere.is_emitter()) {
            let center = (lamp.center + lamp.velocity * opening).as_dvec3();
            if let Some(ring) = Ring::of(&frame, center, lamp.radius.into(), margin) {
                rims.mark(&ring, settings.height);
            }
        }
        Some(rims)
    }

    /// True if the rim of a lamp may be seen in pixel (x, y).
    pub fn has(&self, x: u32, y: u32) -> bool {
        let at = self.at(x, y);
        self.bits[at / 64] >> (at % 64) & 1 == 1
    }

    fn at(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// Marks the pixels whose middle is within the ring.
    fn mark(&mut self, ring: &Ring, height: u32) {
        let Ring { center: [x, y], radii: [inner, outer] } = *ring;
        for row in within([y - outer, y + outer], height) {
            let up = f64::from(row) + 0.5 - y;
            let reach = |radius: f64| (radius * radius - up * up).max(0.0).sqrt();
            let (near, far) = (if inner > 0.0 { reach(inner) } else { 0.0 }, reach(outer));
            for columns in [[x - far, x - near], [x + near, x + far]] {
                for column in within(columns, self.width) {
                    let at = self.at(column, row);
                    self.bits[at / 64] |= 1 << (at % 64);
                }
            }
        }
    }
}

/// The pixels of a line of so many whose middle is within these bounds.
fn within([low, high]: [f64; 2], count: u32) -> std::ops::Range<u32> {
    // Casts saturate, and make 0 of what is no number.
    (low - 0.5).ceil().max(0.0) as u32..((high + 0.5).floor().max(0.0) as u32).min(count)
}

/// A rim in the image, in pixels from the top left.
struct Ring {
    center: [f64; 2],
    /// The inner one is negative if the ring is a disc.
    radii: [f64; 2],
}

impl Ring {
    /// That of a ball, so much wider on either side; `None` if it holds the eye, or reaches beside it or behind.
    fn of(frame: &Frame, center: glam::DVec3, radius: f64, margin: f64) -> Option<Self> {
        let to_center = center - frame.eye.as_dvec3();
        let along = |axis: crate::Vec3| to_center.dot(axis.as_dvec3());
        let (depth, squared) = (along(frame.forward), to_center.dot(to_center));
        if depth <= radius {
            return None;
        }
        let pixel = f64::from(frame.pixel);
        let [right, up] = [frame.right, frame.up].map(|axis| along(axis) / (depth * pixel));
        let [half_width, half_height] = frame.half.map(f64::from);
        let slant = squared.sqrt() / depth;
        let across = radius / (squared - radius * radius).sqrt() * slant / pixel;
        let blur =
            f64::from(frame.aperture_radius) * (1.0 / f64::from(frame.focus_distance) - 1.0 / depth).abs();
        let wider = margin + blur / pixel;
        let radii = [across - wider, across * slant + wider];
        Some(Self { center: [half_width + right, half_height - up], radii })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::filter::Filter;
    use crate::test_scenes::balls;
    use crate::{Rgb, Vec3};

    /// 60 x 40 pixels of a side of 0.01 at distance 1, seen from the origin along z.
    fn marked(lamps: &[(Vec3, f32)], change: impl Fn(&mut Scene)) -> Vec<(u32, u32)> {
        let of: Vec<_> = lamps.iter().map(|(center, radius)| (*center, *radius, 1.0)).collect();
        let mut scene = balls(&of);
        scene.camera = Camera {
            eye: Vec3::ZERO,
            direction: Vec3::Z,
            up: Vec3::Y,
            vertical_fov_degrees: 2.0 * 0.2_f32.atan().to_degrees(),
            ..Camera::default()
        };
        scene.settings = Settings { width: 60, height: 40, glint_samples: 2, ..scene.settings };
        change(&mut scene);
        let rims = Rims::new(&scene, &scene.settings).unwrap();
        (0..40).flat_map(|y| (0..60).map(move |x| (x, y))).filter(|(x, y)| rims.has(*x, *y)).collect()
    }

    #[test]
    fn one_ray_needs_none() {
        assert!(Rims::new(&balls(&[]), &Settings::default()).is_none());
    }

    /// A lamp of 10 pixels: those on its rim, of which some part is within and some without, are marked, and none far from it.
    #[test]
    fn rims_are_marked_and_neither_what_is_within_nor_what_is_without() {
        let (center, radius) = (Vec3::new(-0.5, 0.3, 10.0), 1.0);
        let found = marked(&[(center, radius)], |_| {});
        // x grows to the left: right is forward times up.
        let middle = (30.0 + 5.0, 20.0 - 3.0);
        let distance = |x: f64, y: f64| ((x - middle.0).powi(2) + (y - middle.1).powi(2)).sqrt();
        for (x, y) in (0..40).flat_map(|y| (0..60).map(move |x| (x, y))) {
            let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
            let corners = corners.map(|(u, v)| distance(f64::from(x) + u, f64::from(y) + v));
            let (near, far) = (
                corners.iter().copied().fold(f64::MAX, f64::min),
                corners.iter().copied().fold(0.0, f64::max),
            );
            let is_marked = found.contains(&(x, y));
            if near < 10.0 && far > 10.1 {
                assert!(is_marked, "({x}, {y}) at {near} to {far} is on the rim");
            }
            if far < 8.5 || near > 11.5 {
                assert!(!is_marked, "({x}, {y}) at {near} to {far} is not on the rim");
            }
        }
    }

    #[test]
    fn a_lamp_smaller_than_a_pixel_marks_those_around_it() {
        let found = marked(&[(Vec3::new(-0.045, -0.055, 10.0), 1e-4)], |_| {});
        assert_eq!(found, [(30, 20)]);
        let wide = marked(&[(Vec3::new(-0.045, -0.055, 10.0), 1e-4)], |scene| {
            scene.settings.filter = Filter::Mitchell;
        });
        assert!(wide.len() > 9 && wide.contains(&(30, 20)) && wide.contains(&(28, 20)), "{wide:?}");
    }

    #[test]
    fn a_lens_blurs_what_is_not_in_focus() {
        let of = |focus_distance| {
            marked(&[(Vec3::new(-0.045, -0.055, 10.0), 1e-4)], |scene| {
                (scene.camera.aperture_radius, scene.camera.focus_distance) = (1.0, focus_distance);
            })
        };
        assert_eq!(of(10.0).len(), 1);
        // Half as far: a disc of radius 0.1 / 0.01.
        let area = of(5.0).len() as f64 / std::f64::consts::PI;
        assert!((10.0_f64.powi(2)..12.0_f64.powi(2)).contains(&area), "{area}");
    }

    #[test]
    fn lamps_are_where_they_are_when_the_shutter_opens() {
        let lamp = [(Vec3::new(-0.045, -0.055, 10.0), 1e-4)];
        let found = marked(&lamp, |scene| {
            scene.camera.shutter = [0.5, 3.0];
            scene.spheres.iter_mut().for_each(|sphere| sphere.velocity = Vec3::new(-1.0, 0.0, 0.0));
        });
        assert_eq!(found, [(35, 20)]);
    }

    #[test]
    fn what_is_dark_or_behind_or_around_the_eye_has_no_rim() {
        let beside = [(Vec3::new(0.0, 0.0, -10.0), 1.0), (Vec3::new(1.0, 0.0, 0.0), 5.0), (Vec3::X, 0.5)];
        assert_eq!(marked(&beside, |_| {}), []);
        let dark =
            |scene: &mut Scene| scene.spheres.iter_mut().for_each(|sphere| sphere.emission = Rgb::ZERO);
        assert_eq!(marked(&[(Vec3::Z * 10.0, 1.0)], dark), []);
        // Far away, in no direction of the image, and as large as can be.
        let odd = [(Vec3::new(1e30, 0.0, 1.0), 1e-3), (Vec3::Z * 1e30, 1e-30), (Vec3::Z * 1e15, 9e14)];
        marked(&odd, |_| {});
    }

    /// From wherever that is. Lamps behind it have none, whichever come after.
    #[test]
    fn rims_are_seen_from_the_eye() {
        let (eye, away) = (Vec3::new(3.0, -2.0, 5.0), Vec3::new(-0.045, -0.055, 10.0));
        let found = marked(&[(eye - Vec3::Z * 10.0, 1.0), (eye + away, 1e-4)], |scene| {
            scene.camera.eye = eye;
        });
        assert_eq!(found, [(30, 20)]);
    }
}
