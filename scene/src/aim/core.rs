//! Where photons of far lamps start: on a ball around all that is near.
//!
//! A sun at distance 10^6 is known to 0.06 in `f32`, and so is a ray that starts there: a ball of radius 1 would lie in
//! a fog of that width, and one of 10^-3 would not be met. Between a far lamp and the ball around all else nothing
//! stands but the ground, so photons that cross this ball, and that the ground has not stopped before, may as well start on it.
//! The ground itself is not within: it may be 10^7 times as wide as what stands on it.
//!
//! Photons that miss the core start on their lamps, and rounding may lead them into its rim. What is near must not be there, or
//! it would receive them besides those that start at the core. So the core is many times as wide as the fog.

use super::target::Target;
use crate::ray::SphereId;
use crate::still::{Light, Role, Still};
use crate::{Sphere, Vec3};
use glam::DVec3;
use std::slice;

/// Most far lamps but the rooms: each photon asks whether one of them stands in its way.
const MOST_FAR: usize = 4;

/// The core's least radius over the fog of its farthest lamp. The farther from the core's middle, the coarser is `f32` there.
const ROOM_FOR_FOG: f64 = 16.0;

/// A lamp over a ground that is wider than it is far is far as well, where its rounding is more than such a part of what is near.
const CERTAIN: f64 = 1.0 / 1024.0;

/// What the core is widened by, so that what it is put around lies within in spite of rounding.
const WIDENED: f64 = 1.001;

/// The ball around all that is near, and what glows far from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Core {
    /// Around all spheres but rooms, grounds and far lamps, and all targets but those that are around it themselves. So a line
    /// that enters it crosses a target there or later, or not at all.
    pub ball: Target,
    /// The far lamps, rooms not among them, each as sphere and ball.
    pub far: Vec<(SphereId, Target)>,
    /// For each light, true if its photons may start at the core.
    pub is_far: Vec<bool>,
}

impl Core {
    /// The core of a scene, if some lamp is far from it.
    pub(super) fn new(still: &Still, targets: &[Target]) -> Option<Self> {
        // If too many lamps over the ground are far, they are near.
        Self::of(still, targets, CERTAIN).or_else(|| Self::of(still, targets, f64::INFINITY))
    }

    /// The core where lamps over a ground are far if their rounding is such a part of what is near.
    fn of(still: &Still, targets: &[Target], certain: f64) -> Option<Self> {
        let all = around(|| of_targets(targets).chain(of_spheres(still, |s, role| !is_lamp(s, role))));
        let is_ground = |role| matches!(role, Role::Ground(_));
        let things = around_smallest(still, targets, |s, role| !is_lamp(s, role) && !is_ground(role))?;
        let is_uncertain =
            |s: &Sphere| reach(&things, s) * f64::from(f32::EPSILON) >= certain * f64::from(things.radius);
        let is_beyond = |ball: &Target, s: &Sphere| gap(ball, s) >= f64::from(ball.radius);
        let may_be_far = |s: &Sphere, role| {
            is_lamp(s, role) && (is_beyond(&all, s) || is_beyond(&things, s) && is_uncertain(s))
        };
        let least = ROOM_FOR_FOG * fog(still, &things, may_be_far);
        // Lamps that are not far from so wide a core are near.
        let is_far = |s: &Sphere, role| may_be_far(s, role) && gap(&things, s) >= 2.0 * least;
        let near = around_smallest(still, targets, |s, role| !is_far(s, role) && !is_ground(role))?;
        let ball = around_apart(targets, Target::ball(near.center, near.radius.max(least as f32)));
        let spheres = || (0..).zip(still.spheres.iter().zip(still.roles.iter()));
        let far = spheres().filter(|(_, (s, role))| is_far(s, **role));
        let far: Vec<_> = far.map(|(id, (s, _))| (id, Target::ball(s.center, s.radius))).collect();
        let starts_at_core = |light: &Light| {
            let id = light.sphere as usize;
            let is_room = light.inside && contains(&still.spheres[id], &ball);
            light.blockers.is_empty() && (is_room || is_far(&still.spheres[id], still.roles[id]))
        };
        let is_far: Vec<bool> = still.lights.entries.iter().map(starts_at_core).collect();
        let is_clear = far
            .iter()
            .all(|(_, lamp)| distance(lamp.center, ball.center) > f64::from(lamp.radius + ball.radius));
        let is_in_rooms = still.enclosures.iter().all(|e| contains(&still.spheres[e.sphere as usize], &ball));
        (is_clear && is_in_rooms && far.len() <= MOST_FAR && is_far.contains(&true)).then_some(Self {
            ball,
            far,
            is_far,
        })
    }

    /// Where a half line from far lamp `lamp` enters the core; `None` if it does not, or if another far lamp stands there.
    /// `point` is any point of it, the nearer the better. Whether a ground stands in the way, the engines ask.
    pub fn entry(&self, lamp: SphereId, origin: Vec3, point: Vec3, direction: Vec3) -> Option<Vec3> {
        let is_ahead = (origin - self.ball.center).dot(direction) < 0.0;
        let stands_between =
            |(other, ball): &(SphereId, Target)| *other != lamp && ball.is_crossed(origin, direction);
        if !is_ahead || self.far.iter().any(stands_between) {
            return None;
        }
        let f = point - self.ball.center;
        let nearest = f - direction * f.dot(direction);
        let half_chord2 = self.ball.radius_squared - nearest.dot(nearest);
        (half_chord2 > 0.0).then(|| self.ball.center + (nearest - direction * half_chord2.sqrt()))
    }
}

fn distance(a: Vec3, b: Vec3) -> f64 {
    a.as_dvec3().distance(b.as_dvec3())
}

/// True for lamps, which may be far. What glows and is a room, or of glass, is none.
fn is_lamp(s: &Sphere, role: Role) -> bool {
    role == Role::Solid && s.is_emitter()
}

/// Centres and radii of the spheres that `counts` names, but for rooms.
fn of_spheres<'a>(
    still: &'a Still,
    counts: impl Fn(&Sphere, Role) -> bool + 'a,
) -> impl Iterator<Item = (Vec3, f32)> + 'a {
    let spheres = still.spheres.iter().zip(still.roles.iter());
    let objects = spheres.filter(|(_, role)| !matches!(role, Role::Enclosure(_)));
    objects.filter(move |(s, role)| counts(s, **role)).map(|(s, _)| (s.center, s.radius))
}

/// Centres and radii.
fn of_targets(targets: &[Target]) -> impl Iterator<Item = (Vec3, f32)> + '_ {
    targets.iter().map(|t| (t.center, t.radius))
}

/// By how much rays from far lamps and rooms are uncertain where they pass a ball.
fn fog(still: &Still, ball: &Target, is_far: impl Fn(&Sphere, Role) -> bool) -> f64 {
    let spheres = still.lights.entries.iter().map(|light| light.sphere as usize);
    let roles = spheres.map(|id| (&still.spheres[id], still.roles[id]));
    let sends = roles.filter(|(s, role)| matches!(role, Role::Enclosure(_)) || is_far(s, *role));
    sends.map(|(s, _)| reach(ball, s)).fold(0.0, f64::max) * f64::from(f32::EPSILON)
}

/// The ball around the spheres that `counts` names, but for rooms, and around the smallest target, so that there is a ball even if nothing
/// stands on the ground. `None` without targets.
fn around_smallest(
    still: &Still,
    targets: &[Target],
    counts: impl Fn(&Sphere, Role) -> bool + Copy,
) -> Option<Target> {
    let smallest = targets.iter().min_by(|a, b| a.radius.total_cmp(&b.radius))?;
    Some(around(|| of_targets(slice::from_ref(smallest)).chain(of_spheres(still, counts))))
}

/// The ball around a ball, and around all targets that neither lie within it nor are around it.
fn around_apart(targets: &[Target], mut ball: Target) -> Target {
    let is_within = |inner: &Target, outer: &Target, widened: f64| {
        let reach = distance(inner.center, outer.center) + f64::from(inner.radius);
        reach * widened <= f64::from(outer.radius)
    };
    let apart = |ball: Target| {
        let is_apart = |t: &&Target| !is_within(t, &ball, 1.0) && !is_within(&ball, t, WIDENED);
        targets.iter().find(is_apart)
    };
    // What has been added stays within, so there is no more to add than all.
    for _ in targets {
        let Some(target) = apart(ball) else { break };
        ball = around(|| [ball, *target].into_iter().map(|t| (t.center, t.radius)));
    }
    ball
}

/// How far the far side of a sphere is from the middle of a ball.
fn reach(ball: &Target, s: &Sphere) -> f64 {
    distance(s.center, ball.center) + f64::from(s.radius)
}

/// How far a sphere is from a ball.
fn gap(ball: &Target, s: &Sphere) -> f64 {
    distance(ball.center, s.center) - f64::from(s.radius) - f64::from(ball.radius)
}

/// True if a ball lies within a sphere.
fn contains(s: &Sphere, ball: &Target) -> bool {
    (distance(ball.center, s.center) + f64::from(ball.radius)) * WIDENED < f64::from(s.radius)
}

/// A ball around balls. They may be millions, so they are gone through twice and never held.
fn around<I: Iterator<Item = (Vec3, f32)>>(balls: impl Fn() -> I) -> Target {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (center, radius) in balls() {
        let (c, r) = (center.as_dvec3(), f64::from(radius));
        (low, high) = (low.min(c - r), high.max(c + r));
    }
    let center = (0.5 * (low + high)).as_vec3();
    let reach = |(c, r): (Vec3, f32)| distance(c, center) + f64::from(r);
    Target::ball(center, (balls().map(reach).fold(0.0, f64::max) * WIDENED) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::test_scenes::balls;
    use crate::world::Scene;

    /// What weighs a line asks which targets it crosses, from where it enters the core.
    #[test]
    fn all_that_is_near_and_all_targets_lie_in_the_core() {
        let near = [(Vec3::X, 0.5, 0.0), (3.0 * Vec3::Y, 1.0, 0.0), (4.0 * Vec3::Y, 0.25, 1.0)];
        let sun = (1000.0 * Vec3::Z, 20.0, 5.0);
        let scene = balls(&[&near[..], &[sun]].concat());
        let still = scene.at(0.0);
        for target in [Target::ball(Vec3::ZERO, 0.1), Target::ball(-30.0 * Vec3::X, 2.0)] {
            let core = Core::new(&still, &[target]).unwrap();
            let holds = |center: Vec3, radius: f32| {
                distance(center, core.ball.center) + f64::from(radius) <= f64::from(core.ball.radius)
            };
            assert!(holds(target.center, target.radius), "{:?}", core.ball);
            assert!(near.iter().all(|(center, radius, _)| holds(*center, *radius)), "{:?}", core.ball);
            assert_eq!(core.far.iter().map(|(id, _)| *id).collect::<Vec<_>>(), [3]);
            assert_eq!(core.is_far, [false, true]);
        }
    }

    /// Else roundings at the far side of the ground would be as large as what stands on it.
    #[test]
    fn the_core_does_not_reach_around_the_ground() {
        let scene =
            balls(&[(-1000.0 * Vec3::Z, 999.0, 0.0), (0.2 * Vec3::Y, 0.5, 0.0), (9e4 * Vec3::Z, 90.0, 5.0)]);
        let around_it = |eye: Vec3| {
            let scene = Scene { camera: Camera { eye, ..scene.camera }, ..scene.clone() };
            let core = Core::new(&scene.at(0.0), &[Target::ball(Vec3::ZERO, 1.0)]).unwrap();
            assert_eq!(core.is_far, [true]);
            core.ball.radius
        };
        // It is a ball among others for an eye that is far from it.
        assert!(around_it(Vec3::Z * 200.0) > 999.0);
        assert!(around_it(Vec3::Z * 9.0) < 1.1);
    }

    /// Of the sun, if there is no sky, and of the sky, which is around it; and no larger if all is near.
    #[test]
    fn the_core_is_many_times_as_wide_as_the_fog_of_far_lamps() {
        let sun = (8e5 * Vec3::Z, 6e3, 5.0);
        let of = |lamps: &[(Vec3, f32, f32)]| {
            let scene = balls(&[&[(Vec3::X * 1e-3, 5e-4, 0.0)], lamps].concat());
            f64::from(Core::new(&scene.at(0.0), &[Target::ball(Vec3::ZERO, 1e-3)]).unwrap().ball.radius)
        };
        let fog = |distance: f64| distance * 2.0_f64.powi(-23);
        let (alone, with_sky) = (of(&[sun]), of(&[sun, (Vec3::ZERO, 3e6, 1.0)]));
        assert!((alone / (16.0 * fog(8.06e5)) - 1.0).abs() < 1e-6, "{alone}");
        assert!((with_sky / (16.0 * fog(3e6)) - 1.0).abs() < 1e-6, "{with_sky}");
        // So it is over a ground that is ten times as wide as the sun is far, and than which it is no farther.
        let ground = (-8e6 * Vec3::Z, 8e6 - 1e-3, 0.0);
        assert_eq!(of(&[sun, ground]), alone);
        // A lamp that would be in it, or at its rim, is near: it lies within.
        for y in [1.0, 2.5] {
            let with_lamp = of(&[sun, (y * Vec3::Y, 1e-3, 2.0)]);
            assert!((alone..1.01 * alone.max(y.into())).contains(&with_lamp), "{with_lamp} for {y}");
        }
        // All is certain where no lamp is as far.
        let near = of(&[(0.1 * Vec3::Z, 1e-2, 5.0)]);
        assert!((1e-3..3e-3).contains(&near), "{near}");
    }

    /// Lamps over the ground that are uncertain: a few start at the core, and with more of them those of the sky still do.
    #[test]
    fn many_lamps_over_a_ground_leave_the_core_to_the_sky() {
        let ground = (-1e4 * Vec3::Z, 1e4 - 1e-3, 0.0);
        let (thing, sky) = ((Vec3::X * 1e-3, 5e-4, 0.0), (Vec3::ZERO, 3e6, 1.0));
        let of = |lamps: u8| {
            let lamp = |k: u8| (100.0 * Vec3::Z + Vec3::X * f32::from(10 * k), 0.5, 3.0);
            let scene =
                balls(&[&[ground, thing, sky][..], &(0..lamps).map(lamp).collect::<Vec<_>>()].concat());
            let scene = Scene { camera: Camera { eye: Vec3::Z * 3e-3, ..scene.camera }, ..scene };
            Core::new(&scene.at(0.0), &[Target::ball(Vec3::ZERO, 1e-3)]).unwrap()
        };
        let far = |core: &Core| core.is_far.iter().filter(|far| **far).count();
        assert_eq!([of(1), of(4), of(5)].map(|core| (core.far.len(), far(&core))), [(1, 2), (4, 5), (0, 1)]);
        assert!(of(4).ball.radius < 10.0 && of(5).ball.radius > 50.0);
    }

    /// In numbers that are exact: a line that only touches it does not enter.
    #[test]
    fn a_line_enters_the_core_where_it_crosses_it() {
        let core = Core { ball: Target::ball(Vec3::ZERO, 5.0), far: Vec::new(), is_far: Vec::new() };
        let entry = |y: f32| core.entry(0, Vec3::new(-100.0, y, 0.0), Vec3::new(8.0, y, 0.0), Vec3::X);
        assert_eq!(entry(0.0), Some(Vec3::new(-5.0, 0.0, 0.0)));
        assert_eq!(entry(3.0), Some(Vec3::new(-4.0, 3.0, 0.0)));
        assert_eq!((entry(5.0), entry(6.0)), (None, None));
    }

    /// Where its photons end, and begin nowhere else.
    #[test]
    fn a_far_lamp_stands_in_the_way_of_another() {
        let scene =
            balls(&[(Vec3::ZERO, 1.0, 0.0), (100.0 * Vec3::Z, 5.0, 1.0), (200.0 * Vec3::Z, 5.0, 1.0)]);
        let core = Core::new(&scene.at(0.0), &[Target::ball(Vec3::ZERO, 1.0)]).unwrap();
        let entry = |lamp: SphereId, from: Vec3| core.entry(lamp, from, Vec3::ZERO, Vec3::NEG_Z);
        let entered = entry(1, 95.0 * Vec3::Z).unwrap();
        assert!((entered.z - core.ball.radius).abs() < 1e-5, "{entered}");
        assert_eq!(entry(2, 195.0 * Vec3::Z), None);
        // Away from the core nothing enters it.
        assert_eq!(core.entry(1, 105.0 * Vec3::Z, 105.0 * Vec3::Z, Vec3::Z), None);
    }
}
