//! Lamps as photons are aimed from them: each by itself, or where there are many in runs of neighbours.

use super::target::{Target, cone};
use crate::sphere::Sphere;
use crate::still::Still;
use glam::{DVec3, Vec3};

/// Lamps are aimed one by one up to so many, and by runs of neighbours beyond.
const MAX_GROUPS: usize = 1024;

/// Caps whose distance is less than this overlap, for all that rounding tells.
const APART: f64 = 1e-5;

/// A lamp, or lamps that stand together, as photons are aimed from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Centre of a ball around them.
    pub center: Vec3,
    /// Its radius.
    pub radius: f32,
    /// The first of its lights in [`Aim::order`](super::Aim::order).
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// The share of all power.
    pub share: f64,
}

impl Group {
    /// True if lines are drawn through a disk at the ball, which is smaller; false if at the lamp.
    pub fn is_aimed_by_disk(&self, ball: &Target) -> bool {
        self.end - self.first == 1 && ball.radius < self.radius
    }
}

/// Lights in groups: each by itself, or where there are many in runs of neighbours; and the lights in that order.
pub(super) fn groups(still: &Still) -> (Vec<Group>, Vec<u32>) {
    let lights = &still.lights;
    let count = lights.entries.len() as u32;
    let mut order = lights.tree.lights_in_order();
    let mut is_there = vec![false; count as usize];
    for &light in &order {
        is_there[light as usize] = true;
    }
    order.extend((0..count).filter(|&light| !is_there[light as usize]));
    let run = order.len().div_ceil(MAX_GROUPS);
    let group = |(index, run_of): (usize, &[u32])| {
        let spheres = || run_of.iter().map(|&l| &still.spheres[lights.entries[l as usize].sphere as usize]);
        let low = spheres().fold(DVec3::INFINITY, |low, s| low.min(s.center.as_dvec3()));
        let high = spheres().fold(DVec3::NEG_INFINITY, |high, s| high.max(s.center.as_dvec3()));
        let center = (0.5 * (low + high)).as_vec3();
        let reach =
            |s: &Sphere| s.center.as_dvec3().distance(center.as_dvec3()) * (1.0 + 1e-6) + f64::from(s.radius);
        let first = (index * run) as u32;
        Group {
            center,
            radius: spheres().map(reach).fold(0.0, f64::max) as f32,
            first,
            end: first + run_of.len() as u32,
            share: run_of.iter().map(|&l| f64::from(lights.entries[l as usize].probability)).sum(),
        }
    };
    let groups = order.chunks(run.max(1)).enumerate().map(group).collect();
    (groups, order)
}

/// The share of a group's flux that component `ball` draws lines for: of a single lamp, lines through the disk of the
/// smaller of both, over all lines of the lamp.
pub(super) fn flux(group: &Group, ball: &Target) -> f64 {
    let (axis, height) = cone(group.center, group.radius, ball.center, ball.radius);
    if are_apart((axis, height), (ball.axis, ball.height)) {
        return 0.0;
    }
    let height = height.min(ball.height);
    let ratio =
        if group.is_aimed_by_disk(ball) { f64::from(ball.radius) / f64::from(group.radius) } else { 1.0 };
    group.share * 0.5 * f64::from(height) * ratio * ratio
}

/// True if no direction lies in both caps, each an axis and `1 - cos` of the half angle.
fn are_apart((a, height_a): (Vec3, f32), (b, height_b): (Vec3, f32)) -> bool {
    let [cos_a, cos_b] = [height_a, height_b].map(|height| 1.0 - f64::from(height));
    let sine = |cos: f64| (1.0 - cos * cos).max(0.0).sqrt();
    // The half angles add up to less than a half turn, and the axes are further apart.
    cos_a > -cos_b && a.as_dvec3().dot(b.as_dvec3()) < cos_a * cos_b - sine(cos_a) * sine(cos_b) - APART
}

/// [`flux`] of each ball, of all groups together.
pub(super) fn fluxes(balls: &[Target], groups: &[Group]) -> Vec<f64> {
    balls.iter().map(|ball| groups.iter().map(|group| flux(group, ball)).sum()).collect()
}
