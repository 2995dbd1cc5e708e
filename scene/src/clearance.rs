//! Clearance: how far what a pixel sees is from other surfaces, by which its first search radius is limited.
//!
//! Photon mapping takes light to be even over the disc of the search radius. It changes fastest where another surface is
//! near: where a ball touches the ground, in corners, and at the caustic below a ball of glass, which is about as far from it
//! as it is wide. There the disc should be narrow; elsewhere a wide one has less noise. What is near is known without any
//! photon:
//!
//! ```text
//! d(S) = | |x - c| - r |                             of each sphere S but that of the visible point x
//! L(S) = R_0 / 3 if x lies within S, else R_0 / 8    R_0 the initial radius
//! R = min(R, min over all S of max(radius_clearance d(S), L(S)))     while the pixel has gathered no photon
//! ```
//!
//! A sphere that `x` lies within is mostly a wall. In the corner of a room light changes less than below a ball: limited to
//! an eighth there too, the edges of rooms were lines of noise (docs/quality.md).
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

/// Spheres that the visible point lies within limit the radius to no less than the initial radius over this.
const WALLS: f32 = 3.0;

/// The limit of search radii by clearance, for the spheres of one instant.
pub struct Clearance {
    /// [`Settings::radius_clearance`].
    factor: f64,
    /// The least radii to which others are limited: by spheres that the visible point lies within, and by the rest.
    least: [f64; 2],
    /// All spheres; made for the first pixel that asks.
    neighbours: OnceLock<Neighbours>,
}

impl Clearance {
    /// The limit of a render with these settings, if it has one.
    pub fn new(settings: &Settings) -> Option<Self> {
        (settings.radius_clearance > 0.0).then(|| Self {
            factor: settings.radius_clearance.into(),
            least: [WALLS, RADIUS_RATIO].map(|ratio| f64::from(settings.initial_radius) / f64::from(ratio)),
            neighbours: OnceLock::new(),
        })
    }

    /// The squared search radius at the visible point `x` on sphere `own`, where without a limit it is `radius_squared`. The
    /// `spheres` are the same in all calls.
    pub fn limited(&self, spheres: &[Sphere], (x, own): (Vec3, SphereId), radius_squared: f32) -> f32 {
        let all = || Neighbours::new(spheres, (0..spheres.len() as SphereId).collect());
        let neighbours = self.neighbours.get_or_init(all);
        let [by_walls, by_others] = self.least;
        let mut radius = f64::from(radius_squared).sqrt();
        // Spheres that are farther do not limit the radius.
        let reach = radius / self.factor;
        let x = x.as_dvec3();
        let _ = neighbours.visit_near(x, reach, |id| {
            let sphere = &spheres[id as usize];
            let beyond = x.distance(sphere.center.as_dvec3()) - f64::from(sphere.radius);
            let least = if beyond < 0.0 { by_walls } else { by_others };
            let limit = (self.factor * beyond.abs()).max(least);
            if id != own && limit < radius {
                radius = limit;
            }
            if radius > by_others { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        // The square of the root of an `f32` is that `f32`.
        radius_squared.min((radius * radius) as f32)
    }
}

/// The most bytes that a render with these settings takes to find what is near among so many spheres.
pub fn bytes_at_most(settings: &Settings, spheres: usize) -> u64 {
    if settings.radius_clearance > 0.0 { Neighbours::bytes_at_most(spheres) } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb;
    use crate::rng::{Family, Stream, StreamKey};

    /// Rounding of two ways to compute a squared radius, as `f32`.
    const ROUNDING: f64 = 1e-6;

    fn sphere(center: Vec3, radius: f32) -> Sphere {
        Sphere { center, velocity: Vec3::ZERO, radius, material: 0, emission: Rgb::ZERO }
    }

    fn settings(radius_clearance: f32) -> Settings {
        Settings { initial_radius: 2.0, radius_clearance, ..Settings::default() }
    }

    fn limited(spheres: &[Sphere], settings: &Settings, place: (Vec3, SphereId), radius: f32) -> f32 {
        Clearance::new(settings).unwrap().limited(spheres, place, radius * radius).sqrt()
    }

    fn within(stream: &mut Stream, reach: f32) -> Vec3 {
        Vec3::from([(); 3].map(|()| reach * (2.0 * stream.next_f32() - 1.0)))
    }

    #[test]
    fn without_clearance_there_is_no_limit() {
        assert!(Clearance::new(&settings(0.0)).is_none() && Clearance::new(&settings(0.5)).is_some());
    }

    /// A ball of radius 3 on a floor that is a wide sphere: at a place of the floor, and on the ball.
    #[test]
    fn the_radius_is_so_many_times_the_distance_to_the_nearest_surface() {
        let spheres = [sphere(Vec3::new(0.0, -1e5, 0.0), 1e5), sphere(Vec3::new(0.0, 3.0, 0.0), 3.0)];
        let at = |x: f32, factor: f32| limited(&spheres, &settings(factor), (Vec3::new(x, 0.0, 0.0), 0), 2.0);
        for (x, factor) in [(2.0_f32, 1.0_f32), (3.0, 1.0), (2.0, 0.5), (2.5, 2.0)] {
            let distance = x.hypot(3.0) - 3.0;
            let found = at(x, factor);
            assert!((found / (factor * distance) - 1.0).abs() < 1e-5, "{found} at {x}, {factor}");
        }
        // Far away it is untouched, to the bit, and at the contact an eighth of the initial radius.
        assert_eq!((at(20.0, 1.0), at(0.0, 1.0), at(0.1, 1.0)), (2.0, 0.25, 0.25));
        // On the ball, at half of its height, the floor is 3 away.
        let side = (Vec3::new(3.0, 3.0, 0.0), 1);
        let found = limited(&spheres, &settings(0.1), side, 2.0);
        assert!((found - 0.3).abs() < 1e-5, "{found}");
        // A radius that is narrower than the limit stays.
        assert_eq!(limited(&spheres, &settings(1.0), (Vec3::ZERO, 0), 0.1), 0.1);
    }

    /// Where the point is within a sphere, it is as far from its surface as from outside.
    #[test]
    fn surfaces_are_near_from_both_sides() {
        let spheres = [sphere(Vec3::ZERO, 5.0), sphere(Vec3::new(0.0, 3.0, 0.0), 1.0)];
        let top = (Vec3::new(0.0, 4.0, 0.0), 1);
        assert_eq!(limited(&spheres, &settings(0.75), top, 2.0), 0.75);
        // What surrounds it limits the radius to a third at least, and what does not, to an eighth.
        let third = limited(&spheres, &settings(0.1), top, 2.0);
        assert!((third - 2.0 / 3.0).abs() < 1e-6, "{third}");
        let nearer = [spheres[0], spheres[1], sphere(Vec3::new(0.0, 4.4, 0.0), 0.1)];
        let by_both = limited(&nearer, &settings(1.0), top, 2.0);
        assert!((by_both - 0.3).abs() < 1e-6, "{by_both}");
        assert_eq!(limited(&nearer, &settings(0.1), top, 2.0), 0.25);
        assert_eq!(limited(&nearer, &settings(0.1), top, 0.5), 0.25);
        assert_eq!(limited(&spheres, &settings(0.1), top, 0.5), 0.5);
        // Of the sphere that it lies on, no other point is near: another sphere in its place is.
        let alone = [sphere(Vec3::ZERO, 5.0)];
        let wall = (Vec3::new(0.0, 5.0, 0.0), 0);
        assert_eq!(limited(&alone, &settings(1.0), wall, 2.0), 2.0);
        assert_eq!(limited(&[alone[0]; 2], &settings(1.0), wall, 2.0), 0.25);
    }

    /// Among many balls, some within others, of all sizes: as all of them one by one.
    #[test]
    fn among_many_spheres_the_nearest_counts() {
        let mut stream = StreamKey::new(3, Family::Camera, 0).stream(0);
        let mut spheres: Vec<Sphere> = (0..3000)
            .map(|_| sphere(within(&mut stream, 40.0), 10.0_f32.powf(2.0 * stream.next_f32() - 1.5)))
            .collect();
        spheres.push(sphere(Vec3::new(0.0, -1e4, 0.0), 1e4));
        let (mut touched, mut least, mut walls) = (0, 0, 0);
        for factor in [0.3, 1.0, 4.0] {
            let settings = settings(factor);
            let clearance = Clearance::new(&settings).unwrap();
            for id in 0..spheres.len() {
                let own = &spheres[id];
                let x = own.center + within(&mut stream, 1.0).normalize() * own.radius;
                let of = |other: &Sphere| {
                    let away = x.as_dvec3().distance(other.center.as_dvec3());
                    let beyond = away - f64::from(other.radius);
                    (f64::from(factor) * beyond.abs()).max(2.0 / if beyond < 0.0 { 3.0 } else { 8.0 })
                };
                let others = spheres.iter().enumerate().filter(|(other, _)| *other != id);
                let expected = others.map(|(_, other)| of(other)).fold(2.0, f64::min).powi(2);
                let found = f64::from(clearance.limited(&spheres, (x, id as SphereId), 4.0));
                assert!((found / expected - 1.0).abs() < ROUNDING, "{found}, not {expected}, on {own:?}");
                touched += u32::from(found < 4.0);
                least += u32::from(found == 0.0625);
                walls += u32::from((found * 9.0 / 4.0 - 1.0).abs() < ROUNDING);
            }
        }
        assert!(touched > 3000 && (300..touched / 2).contains(&least), "{touched}, {least}");
        assert!(walls > 100, "{walls} by what surrounds them");
    }

    /// What is told for the hierarchy is what it takes, and little more.
    #[test]
    fn bytes_are_those_of_the_hierarchy() {
        assert_eq!(bytes_at_most(&settings(0.0), 1000), 0);
        let told = bytes_at_most(&settings(1.0), 1000);
        assert!(told > 0 && bytes_at_most(&settings(1.0), 2000) > told);
    }
}
