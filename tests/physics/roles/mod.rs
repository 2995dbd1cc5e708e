//! Every two random numbers of a path are unrelated.
//!
//! A path's random numbers have roles: the place in the pixel, the choice of lamp, the direction of a bounce. If two
//! roles share a number, each still has its distribution, and means over large areas do not change; but where an image
//! depends on both, as behind glass or out of focus, it is wrong. So each role has a scene of its own in which a path
//! shows its number, and the numbers that the same path (same key, many seeds) shows in two scenes must be independent,
//! for any two roles.
//!
//! [`source`] holds the list of roles to what the engines' sources read: a new random number fails there until its role
//! is tested here. [`pictures`] shows some pairs as they appear in images, against closed forms.

mod camera;
mod evenness;
mod glints;
mod paths;
mod photons;
mod pictures;
mod source;

use crate::cases::tell;
use crate::harness::SIGNIFICANCE;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The number of seeds, and so of independent paths.
const SEEDS: u32 = 4096;

/// Classes into which numbers that vary continuously are divided, equally filled.
const CLASSES: usize = 8;

/// The least share of paths in a class, so that a test of it means something.
const LEAST_SHARE: f64 = 0.04;

/// What a random number is for.
struct Role {
    name: String,
    /// Per seed the number's class; `None` if the path does not show it.
    classes: Vec<Option<usize>>,
}

impl Role {
    /// A role whose number shows as one of a few values.
    fn of_few(name: impl Into<String>, show: impl Fn(u64) -> Option<usize>) -> Self {
        let name = name.into();
        let classes: Vec<_> = (0..SEEDS).map(|seed| show(seed.into())).collect();
        let count = classes.iter().flatten().max().map_or(0, |most| most + 1);
        assert!(count > 1, "{name} shows nothing");
        for class in 0..count {
            let share = classes.iter().filter(|c| **c == Some(class)).count() as f64 / f64::from(SEEDS);
            assert!(share > LEAST_SHARE, "{name}: {share:.3} of the paths are of class {class}");
        }
        Self { name, classes }
    }

    /// A role whose number shows as yes or no.
    fn of_two(name: impl Into<String>, show: impl Fn(u64) -> bool) -> Self {
        Self::of_few(name, |seed| Some(usize::from(show(seed))))
    }

    /// A role whose number shows as a value that grows or falls with it.
    fn of_many(name: impl Into<String>, show: impl Fn(u64) -> Option<f64>) -> Self {
        let values: Vec<_> = (0..SEEDS).map(|seed| show(seed.into())).collect();
        let mut sorted: Vec<f64> = values.iter().flatten().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let rank = |value: f64| sorted.partition_point(|other| *other < value) * CLASSES / sorted.len();
        Self::of_few(name, |seed| values[seed as usize].map(rank))
    }

    fn count(&self) -> usize {
        self.classes.iter().flatten().max().map_or(0, |most| most + 1)
    }
}

/// The p-value of Pearson's test that two roles are independent.
fn independence(a: &Role, b: &Role) -> f64 {
    let (rows, columns) = (a.count(), b.count());
    let mut counts = vec![0.0; rows * columns];
    for (a, b) in a.classes.iter().zip(&b.classes) {
        if let (Some(a), Some(b)) = (a, b) {
            counts[a * columns + b] += 1.0;
        }
    }
    let all: f64 = counts.iter().sum();
    let row = |r: usize| counts[r * columns..][..columns].iter().sum::<f64>();
    let column = |c: usize| counts.iter().skip(c).step_by(columns).sum::<f64>();
    let misfit = |i: usize| {
        let expected = row(i / columns) * column(i % columns) / all;
        (counts[i] - expected).powi(2) / expected
    };
    let statistic: f64 = (0..counts.len()).map(misfit).sum();
    ChiSquared::new(((rows - 1) * (columns - 1)) as f64).unwrap().sf(statistic)
}

/// Asserts that every two of `roles` are independent, but for pairs of which a path uses only one.
fn assert_unrelated(roles: &[Role], is_either: impl Fn(&str, &str) -> bool, what: &str) {
    let mut pairs = 0;
    for (i, a) in roles.iter().enumerate() {
        for b in &roles[..i] {
            let p = independence(a, b);
            let is_related = p < SIGNIFICANCE;
            // Such a pair is one number on purpose; that it shows as one proves that the test can see it.
            assert_eq!(
                is_related,
                is_either(&a.name, &b.name),
                "{what}: {} and {}, p = {p:.1e}",
                b.name,
                a.name
            );
            pairs += 1;
        }
    }
    tell("physics", pairs, &format!("pairs of random numbers of {what}"));
}

/// The two numbers of the unit square from which `reference::sampling::cosine_hemisphere` makes a direction about a
/// normal.
fn hemisphere_numbers(normal: glam::DVec3, direction: glam::DVec3) -> [f64; 2] {
    let on_sphere = direction * (2.0 * direction.dot(normal)) - normal;
    sphere_numbers(on_sphere)
}

/// The two numbers of the unit square from which `reference::sampling::uniform_sphere` makes a point.
fn sphere_numbers(point: glam::DVec3) -> [f64; 2] {
    [0.5 - 0.5 * point.z, (point.y.atan2(point.x) / std::f64::consts::TAU + 1.0).fract()]
}

/// The roles of SPPM's camera paths and photons, and the time. Those of one path must be unrelated; those of camera
/// paths, photons and time as well, as all meet in a pixel.
#[test]
fn no_two_roles_of_sppm_share_a_number() {
    for (iteration, pixel, photon) in [(0, [0, 0], 0), (3, [13, 6], 77)] {
        let mut roles = camera::roles(iteration, pixel);
        roles.extend(photons::roles(iteration, photon));
        roles.extend(glints::roles(iteration, pixel));
        roles.push(camera::time(iteration));
        let is_either = |a: &str, b: &str| {
            photons::is_either(a, b) || photons::is_either(b, a) || glints::is_either(a, b)
        };
        assert_unrelated(&roles, is_either, "SPPM");
    }
}

#[test]
fn no_two_roles_of_the_path_tracer_share_a_number() {
    for iteration in [0, 5] {
        let mut roles = paths::roles(iteration);
        roles.extend(glints::roles(iteration, [0, 0]));
        roles.push(camera::time(iteration));
        let is_either = |a: &str, b: &str| paths::is_either(a, b) || glints::is_either(a, b);
        assert_unrelated(&roles, is_either, "the path tracer");
    }
}
