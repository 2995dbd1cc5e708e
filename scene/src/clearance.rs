//! Clearance: how far what a pixel sees is from other surfaces, by which its first search radius is limited.
//!
//! Photon mapping takes light to be even over the disc of the search radius. It changes fastest where another surface is
//! near: where a ball touches the ground, in corners, and at the caustic below a ball of glass, which is about as far from it
//! as it is wide. There the disc should be narrow; elsewhere a wide one has less noise. What is near is known without any
//! photon:
//!
//! ```text
//! d = min over all spheres but that of the visible point x of | |x - c| - r |
//! R = min(R, max(radius_clearance d, R_0 / 8))     while the pixel has gathered no photon; R_0 the initial radius
//! ```
//!
//! `R` is the radius of that iteration alone, and becomes the pixel's with the first photon that is gathered. It depends on
//! the visible point and on no photon of its iteration, so nothing is biased by it.
//!
//! Distances are computed in `f64`, as a wall may be a sphere whose radius is thousands of times the distance from it. All
//! operations are exactly rounded, so every engine has the same radii.

use crate::neighbours::Neighbours;
use crate::ray::SphereId;
use crate::settings::{RADIUS_RATIO, Settings};
use crate::sphere::Sphere;
use glam::Vec3;
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// The limit of search radii by clearance, for the spheres of one instant.
pub struct Clearance {
    /// [`Settings::radius_clearance`].
    factor: f64,
    /// The least radius to which others are limited.
    least: f64,
    /// All spheres; made for the first pixel that asks.
    neighbours: OnceLock<Neighbours>,
}

impl Clearance {
    /// The limit of a render with these settings, if it has one.
    pub fn new(settings: &Settings) -> Option<Self> {
        (settings.radius_clearance > 0.0).then(|| Self {
            factor: settings.radius_clearance.into(),
            least: f64::from(settings.initial_radius) / f64::from(RADIUS_RATIO),
            neighbours: OnceLock::new(),
        })
    }

    /// The squared search radius at the visible point `x` on sphere `own`, where without a limit it is `radius_squared`. The
    /// `spheres` are the same in all calls.
    pub fn limited(&self, spheres: &[Sphere], (x, own): (Vec3, SphereId), radius_squared: f32) -> f32 {
        let all = || Neighbours::new(spheres, (0..spheres.len() as SphereId).collect());
        let neighbours = self.neighbours.get_or_init(all);
        // Spheres that are farther do not limit the radius, and nearer than `enough` they limit it alike.
        let mut nearest = f64::from(radius_squared).sqrt() / self.factor;
        let (reach, enough) = (nearest, self.least / self.factor);
        let x = x.as_dvec3();
        let _ = neighbours.visit_near(x, reach, |id| {
            let sphere = &spheres[id as usize];
            let distance = (x.distance(sphere.center.as_dvec3()) - f64::from(sphere.radius)).abs();
            if id != own && distance < nearest {
                nearest = distance;
            }
            if nearest > enough { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        if nearest < reach {
            let radius = (self.factor * nearest).max(self.least);
            radius_squared.min((radius * radius) as f32)
        } else {
            radius_squared
        }
    }
}
