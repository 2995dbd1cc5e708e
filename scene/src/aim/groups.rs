//! Lamps as photons are aimed from them: each by itself, or where there are many in runs of neighbours.

use super::target::{Target, cone};
use crate::sphere::Sphere;
use crate::still::Still;
use glam::{DVec3, Vec3};
use std::collections::HashSet;

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
    let runs = runs(still, MAX_GROUPS);
    let mut first = 0;
    let groups = runs.iter().map(|run| {
        let begin = first;
        first += run.len() as u32;
        group(still, run, begin)
    });
    (groups.collect(), runs.concat())
}

/// The lights in runs: each by itself, if there are at most `most`. Else lamps in runs of neighbours, then the inner sides of
/// lamps of glass in the same runs, then ambient lights, each by itself: these are as large as the scene, and few.
fn runs(still: &Still, most: usize) -> Vec<Vec<u32>> {
    let lights = &still.lights;
    let ambient: HashSet<u32> = lights.tree.ambient.iter().map(|ambient| ambient.light).collect();
    let is_inner = |light: u32| lights.entries[light as usize].inside && !ambient.contains(&light);
    let count = lights.entries.len() as u32;
    if count as usize <= most {
        let mut runs = lights.tree.runs(most);
        let in_tree: HashSet<u32> = runs.iter().flatten().copied().collect();
        runs.extend((0..count).filter(|light| !in_tree.contains(light)).map(|light| vec![light]));
        return runs;
    }
    let parts = if (0..count).any(is_inner) { 2 } else { 1 };
    let mut runs = lights.tree.runs((most.saturating_sub(ambient.len()) / parts).max(2));
    // The inner side of a lamp of glass follows the outer one.
    let inner_side = |outer: &u32| Some(outer + 1).filter(|&light| light < count && is_inner(light));
    let inner = runs.iter().map(|run| run.iter().filter_map(inner_side).collect::<Vec<u32>>());
    let inner: Vec<_> = inner.filter(|run| !run.is_empty()).collect();
    runs.extend(inner);
    runs.extend(lights.tree.ambient.iter().map(|ambient| vec![ambient.light]));
    runs
}

/// The group of the lights `run`, which begin at place `first`.
fn group(still: &Still, run: &[u32], first: u32) -> Group {
    let light = |l: &u32| &still.lights.entries[*l as usize];
    let spheres = || run.iter().map(|l| &still.spheres[light(l).sphere as usize]);
    let low = spheres().fold(DVec3::INFINITY, |low, s| low.min(s.center.as_dvec3()));
    let high = spheres().fold(DVec3::NEG_INFINITY, |high, s| high.max(s.center.as_dvec3()));
    let center = (0.5 * (low + high)).as_vec3();
    let reach =
        |s: &Sphere| s.center.as_dvec3().distance(center.as_dvec3()) * (1.0 + 1e-6) + f64::from(s.radius);
    Group {
        center,
        radius: spheres().map(reach).fold(0.0, f64::max) as f32,
        first,
        end: first + run.len() as u32,
        share: run.iter().map(|l| f64::from(light(l).probability)).sum(),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::material::Material;
    use crate::test_scenes::balls;
    use crate::world::Scene;

    /// `count` lamps over a square, every third of glass; a sun far away; a sky.
    fn open(count: u32) -> Scene {
        let place = |k: u32| Vec3::new((k % 40) as f32, 3.0 + (k % 3) as f32, (k / 40) as f32);
        let lamps = (0..count).map(|k| (place(k), 0.1, 1.0 + (k % 5) as f32));
        let sun = (Vec3::new(6e5, 6e5, -5e5), 4e4, 700.0);
        let mut scene = balls(&lamps.chain([sun]).collect::<Vec<_>>());
        scene.materials.push(Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 });
        let mut spheres = scene.spheres.to_vec();
        spheres[..count as usize].iter_mut().step_by(3).for_each(|lamp| lamp.material = 1);
        (scene.spheres, scene.background) = (spheres.into(), Rgb::splat(0.5));
        scene.with_sky()
    }

    /// Whatever else there is, lights that are as large as the scene are aimed by themselves: with a sky or a sun in its run of
    /// lamps, no direction would be better than another.
    #[test]
    fn skies_and_suns_are_aimed_by_themselves() {
        for count in [100, 2000, 5000] {
            let scene = open(count);
            let still = scene.at(0.0);
            let (groups, order) = groups(&still);
            let entries = &still.lights.entries;
            let mut all = order.clone();
            all.sort_unstable();
            assert_eq!(all, (0..entries.len() as u32).collect::<Vec<_>>(), "{count}: each light once");
            let places = groups.iter().flat_map(|group| [group.first, group.end]);
            let ends: Vec<u32> = places.collect();
            assert!(ends.windows(2).skip(1).step_by(2).all(|pair| pair[0] == pair[1]), "{count}: no gaps");
            assert_eq!((ends.first(), ends.last()), (Some(&0), Some(&(order.len() as u32))));
            let (sky, sides) = (1, count.div_ceil(3));
            assert_eq!(order.len() as u32, count + sides + 1 + sky, "{count}: with sun and sky");
            assert!(groups.len() <= MAX_GROUPS, "{count}: {} groups", groups.len());
            for group in &groups {
                let lights = &order[group.first as usize..group.end as usize];
                let large = lights
                    .iter()
                    .filter(|&&l| still.spheres[entries[l as usize].sphere as usize].radius > 1.0);
                assert!(large.count() == 0 || lights.len() == 1, "{count}: a sky or a sun among {lights:?}");
                let is_inner = |l: &u32| entries[*l as usize].inside;
                assert!(lights.iter().all(is_inner) || !lights.iter().any(is_inner), "{count}: sides apart");
            }
            let share: f64 = groups.iter().map(|group| group.share).sum();
            assert!((share - 1.0).abs() < 1e-4, "{count}: shares of {share}");
        }
    }

    /// Of a single lamp, the lines through the smaller of both over all of its lines: the share of directions, and of the disk.
    #[test]
    fn fluxes_are_shares_of_lines() {
        let group = |radius, end| Group { center: Vec3::ZERO, radius, first: 0, end, share: 0.5 };
        let ball = Target::ball(Vec3::X * 10.0, 2.0);
        let height = |radius| f64::from(cone(Vec3::ZERO, radius, ball.center, ball.radius).1);
        let near = |found: f64, exact: f64| (found / exact - 1.0).abs() < 1e-12;
        let small = group(1.0, 1);
        assert!(!small.is_aimed_by_disk(&ball) && near(flux(&small, &ball), 0.5 * 0.5 * height(1.0)));
        let large = group(4.0, 1);
        assert!(large.is_aimed_by_disk(&ball) && near(flux(&large, &ball), 0.5 * 0.5 * height(4.0) / 4.0));
        // Of several lamps, lines are drawn through each.
        let several = group(4.0, 2);
        assert!(!several.is_aimed_by_disk(&ball) && near(flux(&several, &ball), 0.5 * 0.5 * height(4.0)));
        // A narrow cap is drawn from instead, and one that looks elsewhere gets nothing.
        let cap = Target { axis: Vec3::X, height: 0.001, ..ball };
        assert!(near(flux(&small, &cap), 0.5 * 0.5 * f64::from(0.001_f32)));
        assert_eq!(flux(&small, &Target { axis: Vec3::Y, ..cap }), 0.0);
        let all = [small, large];
        let sum = flux(&small, &ball) + flux(&large, &ball);
        assert_eq!(fluxes(&[ball, cap], &all), [sum, flux(&small, &cap) + flux(&large, &cap)]);
    }

    /// By the angles between their axes: half angles of 60 and 20 degrees.
    #[test]
    fn caps_are_apart_if_their_axes_are_further_than_their_half_angles() {
        let height = |degrees: f64| (1.0 - degrees.to_radians().cos()) as f32;
        let axis = |degrees: f64| {
            Vec3::new(degrees.to_radians().cos() as f32, degrees.to_radians().sin() as f32, 0.0)
        };
        let apart = |between, a, b| are_apart((Vec3::X, height(a)), (axis(between), height(b)));
        assert!(apart(81.0, 60.0, 20.0) && !apart(79.0, 60.0, 20.0) && apart(81.0, 20.0, 60.0));
        assert!(apart(179.0, 90.0, 80.0) && !apart(169.0, 90.0, 80.0));
        // Half angles of more than a half turn together hold some direction in common.
        assert!(!apart(180.0, 100.0, 90.0) && !apart(180.0, 180.0, 1.0));
        assert!(!are_apart((Vec3::X, 3.0), (Vec3::NEG_X, 0.1)));
    }

    /// The ball of a group is around all of its lamps, and its share is theirs.
    #[test]
    fn a_group_is_around_its_lamps() {
        let scene = balls(&[(Vec3::X * 2.0, 0.5, 1.0), (Vec3::X * 8.0, 1.5, 2.0), (Vec3::Y * 9.0, 0.5, 1.0)]);
        let still = scene.at(0.0);
        let found = group(&still, &[0, 1], 4);
        assert_eq!((found.center, found.first, found.end), (Vec3::X * 5.0, 4, 6));
        assert!((found.radius - 4.5).abs() < 1e-4, "{}", found.radius);
        let share = |light: usize| f64::from(still.lights.entries[light].probability);
        assert!((found.share - share(0) - share(1)).abs() < 1e-12);
    }
}
