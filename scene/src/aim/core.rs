//! Where photons of far lamps start: on a ball around all that is near.
//!
//! A sun at distance 10^6 is known to 0.06 in `f32`, and so is a ray that starts there: a ball of radius 1 would lie in
//! a fog of that width, and one of 10^-3 would not be met. Between a far lamp and the ball around all else nothing
//! stands but the ground, so photons that cross this ball, and that the ground has not stopped before, may as well start on it.
//! The ground itself is not within: it may be 10^7 times as wide as what stands on it.
//!
//! Photons that miss the core start on their lamps, and rounding may lead them into its rim. What is near must not be there, or
//! it would receive them besides those that start at the core. So the core reaches beyond it by some widths of the fog, and is many
//! times as wide as the fog.

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

/// How far the core reaches beyond what is near, over the fog: the place and the direction of a ray are each rounded by about one.
const RIM_OF_FOG: f64 = 4.0;

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
        let things = around_smallest(still, targets, |_, s, role| !is_lamp(s, role))?;
        let mut far = lamps_beyond(still, targets, &things);
        // A lamp that is near widens the core, and so others may come too close to it.
        let ball = loop {
            let is_far = |id: SphereId| far.iter().any(|(lamp, _)| *lamp == id);
            let fog = fog(still, &things, is_far);
            let near = around_smallest(still, targets, |id, _, _| !is_far(id))?;
            let radius = f64::from(near.radius) + RIM_OF_FOG * fog;
            let least = ROOM_FOR_FOG * fog;
            let ball = around_apart(targets, Target::ball(near.center, radius.max(least) as f32));
            let is_clear = |lamp: &Target| {
                gap(&things, lamp) >= 2.0 * least
                    && distance(lamp.center, ball.center) > f64::from(lamp.radius + ball.radius)
            };
            let before = far.len();
            far.retain(|(_, lamp)| is_clear(lamp));
            if far.len() == before {
                break ball;
            }
        };
        let starts_at_core = |light: &Light| {
            let is_room = light.inside && contains(&still.spheres[light.sphere as usize], &ball);
            light.blockers.is_empty() && (is_room || far.iter().any(|(id, _)| *id == light.sphere))
        };
        let is_far: Vec<bool> = still.lights.entries.iter().map(starts_at_core).collect();
        let is_in_rooms = still.enclosures.iter().all(|e| contains(&still.spheres[e.sphere as usize], &ball));
        (is_in_rooms && is_far.contains(&true)).then_some(Self { ball, far, is_far })
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

/// The lamps that are beyond all else, by as much as that is wide, and those beyond all but the grounds whose fog is not small there: of
/// both together the farthest [`MOST_FAR`], by the number of their sphere. `things` is around all but lamps, grounds and rooms.
fn lamps_beyond(still: &Still, targets: &[Target], things: &Target) -> Vec<(SphereId, Target)> {
    let all = around(|| of_targets(targets).chain(of_spheres(still, |_, s, role| !is_lamp(s, role))));
    let is_beyond = |ball: &Target, lamp: &Target| gap(ball, lamp) >= f64::from(ball.radius);
    let is_uncertain =
        |lamp: &Target| reach(things, lamp) * f64::from(f32::EPSILON) >= CERTAIN * f64::from(things.radius);
    let spheres = (0..).zip(still.spheres.iter().zip(still.roles.iter()));
    let lamps = spheres.filter(|(_, (s, role))| is_lamp(s, **role));
    let mut far: Vec<(SphereId, Target)> = lamps
        .map(|(id, (s, _))| (id, Target::ball(s.center, s.radius)))
        .filter(|(_, lamp)| is_beyond(&all, lamp) || is_beyond(things, lamp) && is_uncertain(lamp))
        .collect();
    far.sort_by(|(_, a), (_, b)| reach(things, b).total_cmp(&reach(things, a)));
    far.truncate(MOST_FAR);
    far.sort_unstable_by_key(|(id, _)| *id);
    far
}

/// Centres and radii of the spheres that `counts` names, but for rooms.
fn of_spheres<'a>(
    still: &'a Still,
    counts: impl Fn(SphereId, &Sphere, Role) -> bool + 'a,
) -> impl Iterator<Item = (Vec3, f32)> + 'a {
    let spheres = (0..).zip(still.spheres.iter().zip(still.roles.iter()));
    let objects = spheres.filter(|(_, (_, role))| !matches!(role, Role::Enclosure(_)));
    objects.filter(move |(id, (s, role))| counts(*id, s, **role)).map(|(_, (s, _))| (s.center, s.radius))
}

/// Centres and radii.
fn of_targets(targets: &[Target]) -> impl Iterator<Item = (Vec3, f32)> + '_ {
    targets.iter().map(|t| (t.center, t.radius))
}

/// By how much rays from far lamps and rooms are uncertain where they pass a ball.
fn fog(still: &Still, ball: &Target, is_far: impl Fn(SphereId) -> bool) -> f64 {
    let lights = still.lights.entries.iter().map(|light| light.sphere);
    let sends = lights.filter(|id| matches!(still.roles[*id as usize], Role::Enclosure(_)) || is_far(*id));
    let lamps = sends.map(|id| &still.spheres[id as usize]).map(|s| Target::ball(s.center, s.radius));
    lamps.map(|lamp| reach(ball, &lamp)).fold(0.0, f64::max) * f64::from(f32::EPSILON)
}

/// The ball around the spheres that `counts` names, but for rooms and grounds, and around the smallest target, so that there is a ball even
/// if nothing stands on the ground. `None` without targets.
fn around_smallest(
    still: &Still,
    targets: &[Target],
    counts: impl Fn(SphereId, &Sphere, Role) -> bool + Copy,
) -> Option<Target> {
    let smallest = targets.iter().min_by(|a, b| a.radius.total_cmp(&b.radius))?;
    let stands = move |id, s: &Sphere, role| !matches!(role, Role::Ground(_)) && counts(id, s, role);
    Some(around(|| of_targets(slice::from_ref(smallest)).chain(of_spheres(still, stands))))
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

/// How far the far side of a lamp is from the middle of a ball.
fn reach(ball: &Target, lamp: &Target) -> f64 {
    distance(lamp.center, ball.center) + f64::from(lamp.radius)
}

/// How far a lamp is from a ball.
fn gap(ball: &Target, lamp: &Target) -> f64 {
    distance(ball.center, lamp.center) - f64::from(lamp.radius) - f64::from(ball.radius)
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

    /// Lamps over the ground that are uncertain: photons of a few start at the core, and with more of them those of the sky still do, and those
    /// of a sun.
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
        // Of five the nearest is near, and widens the core up to two more.
        assert_eq!([of(1), of(4), of(5)].map(|core| (core.far.len(), far(&core))), [(1, 2), (4, 5), (2, 3)]);
        assert!(of(4).ball.radius < 10.0 && of(5).ball.radius > 50.0);
        let sun = (Vec3::new(2e5, 0.0, 2e5), 2e3, 5.0);
        let lamps = (0..9_u8).map(|k| (100.0 * Vec3::Z + Vec3::X * f32::from(10 * k), 0.5, 3.0));
        let scene = balls(&[ground, thing].into_iter().chain(lamps).chain([sun]).collect::<Vec<_>>());
        let scene = Scene { camera: Camera { eye: Vec3::Z * 3e-3, ..scene.camera }, ..scene };
        let core = Core::new(&scene.at(0.0), &[Target::ball(Vec3::ZERO, 1e-3)]).unwrap();
        assert!(core.far.iter().any(|(id, _)| *id == 11), "{core:?}");
    }

    /// Whatever its size, no less than four times the fog is left around what is near: photons from the sun itself may lead there.
    #[test]
    fn what_is_near_is_not_at_the_rim_of_the_core() {
        let sun = (8e5 * Vec3::Z, 6e3, 5.0);
        let fog = 8.06e5 * 2.0_f64.powi(-23);
        for apart in [0.0, 1.0, 1.5, 2.0, 20.0] {
            let [a, b] = [apart, -apart].map(|x| (Vec3::X * x, 1e-3, 0.0));
            let core = Core::new(&balls(&[a, b, sun]).at(0.0), &[Target::ball(Vec3::ZERO, 1e-3)]).unwrap();
            let rim = f64::from(core.ball.radius) - f64::from(apart) - 1e-3;
            assert!(rim > 4.0 * fog, "{rim} for {apart}");
        }
    }

    /// Where lamps that are near widen it up to one that was not.
    #[test]
    fn lamps_that_the_core_would_reach_are_near() {
        let sun = (Vec3::new(5.7e5, 0.0, 5.7e5), 6e3, 5.0);
        let thing = (Vec3::ZERO, 1e-3, 0.0);
        let lamps = [[3.0, 0.0], [0.0, 3.0], [2.3, 2.3], [4.6, 0.0], [0.0, 6.0], [9.0, 0.0]];
        for count in 0..=lamps.len() {
            let lamp = |[x, y]: [f32; 2]| (Vec3::new(x, y, 0.0), 0.01, 1.0);
            let near = lamps[..count].iter().map(|place| lamp(*place));
            let scene = balls(&[thing, sun].into_iter().chain(near).collect::<Vec<_>>());
            let core = Core::new(&scene.at(0.0), &[Target::ball(Vec3::ZERO, 1e-3)]).unwrap();
            let (id, far) = core.far[0];
            assert_eq!((id, far.center), (1, sun.0), "{count}");
            for (place, radius) in near_spheres(&scene, &core) {
                let reach = distance(place, core.ball.center) + f64::from(radius);
                assert!(reach <= f64::from(core.ball.radius), "{count}: {core:?}");
            }
        }
    }

    /// Spheres but the far lamps.
    fn near_spheres(scene: &Scene, core: &Core) -> Vec<(Vec3, f32)> {
        let ids = (0..).zip(scene.spheres.iter());
        let near = ids.filter(|(id, _)| core.far.iter().all(|(far, _)| far != id));
        near.map(|(_, s)| (s.center, s.radius)).collect()
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
