//! The camera: pinhole or thin lens, with a shutter.

use crate::rng;
use glam::Vec3;
use serde::Serialize;

/// A perspective camera as the scene file states it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// Centre of projection (of the lens), in scene units.
    pub eye: Vec3,
    /// Viewing direction, of any length but zero.
    pub direction: Vec3,
    /// The direction that points up in the image; not parallel to `direction`.
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub vertical_fov_degrees: f32,
    /// Radius of the lens; 0 for a pinhole, which has everything in focus.
    pub aperture_radius: f32,
    /// Distance of the plane in focus, along `direction`; ignored for a pinhole.
    pub focus_distance: f32,
    /// Shutter times at which the exposure begins and ends. Every iteration renders one instant between them.
    pub shutter: [f32; 2],
}

/// The camera of one render: an orthonormal frame and the size of a pixel at distance 1.
///
/// Computed in `f64`, stored in `f32`. Its setup uses only exactly rounded operations, so it is the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Centre of the lens.
    pub eye: Vec3,
    /// Unit vector that the camera looks along.
    pub forward: Vec3,
    /// Unit vector to the right of the image.
    pub right: Vec3,
    /// Unit vector to the top of the image.
    pub up: Vec3,
    /// Side of a pixel on the plane at distance 1.
    pub pixel: f32,
    /// Half the width and half the height of the image, in pixels.
    pub half: [f32; 2],
    /// Radius of the lens.
    pub aperture_radius: f32,
    /// Distance of the plane in focus.
    pub focus_distance: f32,
}

impl Default for Camera {
    /// A pinhole at the origin that looks along -z, 40 degrees high.
    fn default() -> Self {
        Self {
            eye: Vec3::ZERO,
            direction: -Vec3::Z,
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
            aperture_radius: 0.0,
            focus_distance: 1.0,
            shutter: [0.0, 0.0],
        }
    }
}

impl Camera {
    /// The frame for an image of `width` x `height` pixels.
    pub fn frame(&self, width: u32, height: u32) -> Frame {
        let unit = |v: glam::DVec3| v / v.dot(v).sqrt();
        let forward = unit(self.direction.as_dvec3());
        let right = unit(forward.cross(unit(self.up.as_dvec3())));
        let up = right.cross(forward);
        let half_angle = f64::from(self.vertical_fov_degrees) * (core::f64::consts::PI / 360.0);
        let pixel = 2.0 * tangent(half_angle) / f64::from(height);
        Frame {
            eye: self.eye,
            forward: forward.as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            pixel: pixel as f32,
            half: [0.5 * width as f32, 0.5 * height as f32],
            aperture_radius: self.aperture_radius,
            focus_distance: self.focus_distance,
        }
    }

    /// The shutter time of iteration `iteration`, which camera rays and photons share.
    ///
    /// Times follow the van der Corput sequence under a random shift, so they fill the interval evenly. If camera and
    /// photons had different times, photons would light objects where the camera does not see them.
    pub fn shutter_time(&self, seed: u64, iteration: u32) -> f32 {
        let shift = rng::StreamKey::new(seed, rng::Family::Shutter, 0).stream(0).next_u32();
        let u = rng::unit_float(iteration.reverse_bits() ^ shift);
        self.shutter[0] + u * (self.shutter[1] - self.shutter[0])
    }
}

/// The tangent of `x` in [0, pi/2), from Taylor series of sine and cosine at x/8 and three angle doublings.
///
/// `f64::tan` may differ in the last bit between C libraries, and an image must not depend on one.
fn tangent(x: f64) -> f64 {
    let (mut sine, mut versine) = (0.0, 0.0); // sin x and 1 - cos x; doubling cos x itself would lose digits
    let y = x / 8.0;
    let mut term = 1.0;
    for k in 1..=20 {
        term *= y / f64::from(k);
        match k % 4 {
            1 => sine += term,
            2 => versine += term,
            3 => sine -= term,
            _ => versine -= term,
        }
    }
    for _ in 0..3 {
        (sine, versine) = (2.0 * sine * (1.0 - versine), 2.0 * sine * sine);
    }
    sine / (1.0 - versine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangent_agrees_with_the_library_to_a_few_ulps() {
        for i in 0..9000 {
            let x = f64::from(i) * 0.01_f64.to_radians();
            let (ours, theirs) = (tangent(x), x.tan());
            // At 89.99 degrees the tangent has a condition number of 6e3: one rounding of x changes it by 1.3e-12.
            approx::assert_relative_eq!(ours, theirs, max_relative = 4e-12);
        }
    }

    #[test]
    fn a_frame_is_right_handed_and_of_unit_length() {
        let camera = Camera {
            direction: Vec3::new(1.0, -2.0, -3.0),
            up: Vec3::new(0.5, 9.0, 0.0),
            vertical_fov_degrees: 53.130_104,
            aperture_radius: 0.25,
            focus_distance: 7.0,
            ..Camera::default()
        };
        let frame = camera.frame(40, 30);
        for axis in [frame.forward, frame.right, frame.up] {
            assert!((axis.length() - 1.0).abs() < 1e-6, "{axis}");
        }
        assert!((frame.right.cross(frame.forward) - frame.up).length() < 1e-6);
        assert!(frame.forward.dot(frame.up).abs() < 1e-6 && frame.up.dot(camera.up) > 0.0);
        assert!((frame.forward - camera.direction / 14.0_f32.sqrt()).length() < 1e-6);
        // The tangent of half the angle is a half, and the image is as high as it is far away.
        assert!((frame.pixel * 30.0 - 1.0).abs() < 1e-6, "{}", frame.pixel);
        assert_eq!((frame.half, frame.aperture_radius, frame.focus_distance), ([20.0, 15.0], 0.25, 7.0));
    }

    /// Every eighth of the time that the shutter is open has one of eight iterations.
    #[test]
    fn instants_fill_the_exposure_evenly() {
        let camera = Camera { shutter: [2.0, 6.0], ..Camera::default() };
        for seed in [1, 2] {
            for first in [0, 8, 800] {
                let mut cells: Vec<u32> =
                    (first..first + 8).map(|n| ((camera.shutter_time(seed, n) - 2.0) * 2.0) as u32).collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..8).collect::<Vec<u32>>());
            }
        }
        assert_ne!(camera.shutter_time(1, 0), camera.shutter_time(2, 0));
        let still = Camera { shutter: [3.0, 3.0], ..camera };
        assert!((0..8).all(|n| still.shutter_time(1, n) == 3.0));
    }

    /// It looks along -z, and up is y.
    #[test]
    fn a_camera_that_states_nothing_is_a_pinhole_at_the_origin() {
        let expected = Camera {
            eye: Vec3::ZERO,
            direction: Vec3::NEG_Z,
            up: Vec3::Y,
            vertical_fov_degrees: 40.0,
            aperture_radius: 0.0,
            focus_distance: 1.0,
            shutter: [0.0, 0.0],
        };
        assert_eq!(Camera::default(), expected);
        // Lengths of the vectors do not matter, and what is ahead is in the middle of the image.
        let longer = Camera { direction: Vec3::NEG_Z * 9.0, up: Vec3::new(0.0, 0.5, -3.0), ..expected };
        assert_eq!(longer.frame(8, 6), expected.frame(8, 6));
    }
}
