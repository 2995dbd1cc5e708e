//! Aimed photons: where they leave their lamps, where surfaces scatter them, and what they weigh. `reference::emission`,
//! `reference::photon_pass::scatter_towards` and [`scene::aim`], in lanes.

use crate::intersect::{RayLanes, from_above, power};
use crate::light_choice::LightChoice;
use crate::sampling::{cosine_hemisphere, frame, uniform_cone, uniform_disk};
use bytemuck::{Pod, Zeroable};
use lanes::{Lanes, MOST_LANES, Row, V3};
use scene::aim::{Aim, Group, RUN, Target};
use scene::ray::NO_SPHERE;
use scene::still::Ground;

// All photons of a packet are of one component.
const _: () = assert!((RUN as usize).is_multiple_of(MOST_LANES));

/// How lines from a group of lamps to a ball are drawn.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LineRow {
    /// The directions: axis and height of a cap.
    axis: [f32; 3],
    height: f32,
    /// The disk across the line, at the ball.
    center: [f32; 3],
    /// Its radius; negative if the disk is at the lamp.
    radius: f32,
}

/// The tables of aimed emission: the same for all iterations of a still.
pub(crate) struct AimTables {
    pub(super) aim: Aim,
    /// See [`Aim::region`].
    region: Target,
    /// For each ball, the choice among groups of lamps.
    groups: Vec<LightChoice>,
    /// [`LineRow`]s: for each ball, those of all groups.
    lines: Vec<Row>,
}

/// Photons as they leave their lamps.
#[derive(Clone, Copy)]
pub(super) struct Departures<L: Lanes> {
    pub(super) origin: V3<L>,
    pub(super) direction: V3<L>,
    /// The sphere that the ray leaves.
    pub(super) leaves: L::U,
}

/// The lamps of a packet of photons.
pub(super) struct LampLanes<L: Lanes> {
    pub(super) center: V3<L>,
    pub(super) radius: L::F,
    pub(super) sphere: L::U,
    pub(super) shines_inwards: L::M,
    /// Photons may start at the core ([`scene::aim::Core`]).
    pub(super) is_far: L::M,
}

impl AimTables {
    /// `None` if nothing is aimed.
    pub(crate) fn new(aim: Aim) -> Option<Self> {
        let region = aim.region?;
        let groups = aim.cumulative.iter().map(|cumulative| LightChoice::new(cumulative)).collect();
        let lines = aim.balls.iter().flat_map(|ball| aim.groups.iter().map(|group| line_row(group, ball)));
        let lines = lines.collect();
        Some(Self { aim, region, groups, lines })
    }

    /// The component of a packet of photons, of which `photon` is the first.
    pub(super) fn component(&self, photon: u32) -> usize {
        self.aim.component(photon)
    }

    /// The lights that `u` chooses for photons aimed at `ball`, and the rows of their lines.
    #[inline(always)]
    pub(super) fn choose<L: Lanes>(&self, ball: usize, u: L::F) -> ([u32; MOST_LANES], [u32; MOST_LANES]) {
        let (mut numbers, mut groups, mut lights) = ([0.0; MOST_LANES], [0; MOST_LANES], [0; MOST_LANES]);
        L::store(u, &mut numbers);
        L::store_u(self.groups[ball].choose::<L>(u), &mut groups);
        for lane in 0..L::N {
            lights[lane] = self.aim.light_of(ball, groups[lane] as usize, numbers[lane]);
            groups[lane] += (ball * self.aim.groups.len()) as u32;
        }
        (lights, groups)
    }

    /// Lines from lamps, along these rows: where they leave the lamp, their directions, and which of them cross the lamp.
    /// Also the point of each that is known best.
    #[inline(always)]
    pub(super) fn lines<L: Lanes>(
        &self,
        rows: &[u32],
        lamp: &LampLanes<L>,
        on_disk: [L::F; 2],
        direction: [L::F; 2],
    ) -> (V3<L>, V3<L>, V3<L>, L::M) {
        let [ax, ay, az, height, cx, cy, cz, radius] = L::gather_rows(&self.lines, rows);
        let [u, v] = direction;
        let (direction, _) = uniform_cone::<L>(V3::new(ax, ay, az), height, u, v);
        let at_lamp = L::lt(radius, L::f(0.0));
        let center = V3::select(at_lamp, lamp.center, V3::new(cx, cy, cz));
        let radius = L::select(at_lamp, lamp.radius, radius);
        let (x, y) = uniform_disk::<L>(on_disk[0], on_disk[1]);
        let (s, t) = frame(direction);
        let point = center + (s.scale(x * radius) + t.scale(y * radius));
        let (origin, crosses) = end_of_chord(lamp, point, direction);
        (origin, direction, point, crosses)
    }

    /// The rays of photons: from their lamps, or if these are far from where all else begins. `point` is any point of the
    /// ray, the nearer the better.
    #[inline(always)]
    pub(super) fn depart<L: Lanes>(
        &self,
        grounds: &[Ground],
        lamp: &LampLanes<L>,
        (origin, direction, point): (V3<L>, V3<L>, V3<L>),
    ) -> Departures<L> {
        let at_lamp = Departures { origin, direction, leaves: lamp.sphere };
        let Some(core) = &self.aim.core else { return at_lamp };
        let (zero, ball) = (L::f(0.0), &core.ball);
        let center = V3::splat(ball.center);
        let mut enters = lamp.is_far & L::lt((origin - center).dot(direction), zero);
        for (other, ball) in &core.far {
            let is_other = !L::eq(lamp.sphere, L::u(*other));
            enters = enters & !(is_other & is_crossed(ball, origin, direction));
        }
        let f = point - center;
        let nearest = f - direction.scale(f.dot(direction));
        let half_chord2 = L::f(ball.radius_squared) - nearest.dot(nearest);
        enters = enters & L::lt(zero, half_chord2);
        let entry = center + (nearest - direction.scale(L::sqrt(half_chord2)));
        for ground in grounds {
            enters = enters & !has_met(ground, entry, direction);
        }
        Departures {
            origin: V3::select(enters, entry, origin),
            direction,
            leaves: L::select_u(enters, L::u(NO_SPHERE), lamp.sphere),
        }
    }

    /// What photons weigh, and which of them are of `component`, as all are that leave all lamps alike.
    #[inline(always)]
    pub(super) fn weigh<L: Lanes>(&self, component: usize, ray: &Departures<L>) -> (L::F, L::M) {
        let Aim { balls, densities, .. } = &self.aim;
        let (mut sum, mut is_of_component) = (L::f(densities[0]), L::first(L::N));
        for (k, ball) in (1..).zip(balls) {
            let crosses = is_crossed::<L>(ball, ray.origin, ray.direction);
            sum = L::select(crosses, sum + L::f(densities[k]), sum);
            if k == component {
                is_of_component = crosses;
            }
        }
        (L::f(1.0) / sum, is_of_component)
    }

    /// As `reference::photon_pass::scatter_towards`, with the ball around the middle of what photons are aimed at.
    #[inline(always)]
    pub(super) fn scatter<L: Lanes>(&self, point: V3<L>, normal: V3<L>, u: L::F, v: L::F) -> (V3<L>, L::F) {
        let (ball, one) = (&self.region, L::f(1.0));
        let way = V3::splat(ball.center) - point;
        let d2 = way.dot(way);
        let sin2 = L::f(ball.radius_squared) / d2;
        let is_outside = L::lt(sin2, one);
        let axis = way.scale(one / L::sqrt(d2));
        let height = sin2 / (one + L::sqrt(one - sin2));
        let twice = u * L::f(2.0);
        let is_aimed = is_outside & L::lt(twice, one);
        let (aimed, _) = uniform_cone(axis, height, twice, v);
        let spread = L::select(is_outside, twice - one, u);
        let direction = V3::select(is_aimed, aimed, cosine_hemisphere(normal, spread, v));
        let ratio = L::f(2.0) * (height * L::max(direction.dot(normal), L::f(0.0)));
        let crosses = is_crossed(ball, point, direction);
        let missed = L::select(is_aimed, L::f(0.0), L::f(2.0));
        let weight = L::select(crosses, L::f(2.0) * (ratio / (one + ratio)), missed);
        (direction, L::select(is_outside, weight, one))
    }
}

fn line_row(group: &Group, ball: &Target) -> Row {
    let (axis, height) = ball.directions(group.center, group.radius);
    let radius = if group.is_aimed_by_disk(ball) { ball.radius } else { -1.0 };
    bytemuck::cast(LineRow { axis: axis.into(), height, center: ball.center.into(), radius })
}

/// As [`Target::is_crossed`].
#[inline(always)]
fn is_crossed<L: Lanes>(ball: &Target, origin: V3<L>, direction: V3<L>) -> L::M {
    let r2 = L::f(ball.radius_squared);
    let f = origin - V3::splat(ball.center);
    let b = f.dot(direction);
    let nearest = f - direction.scale(b);
    L::lt(nearest.dot(nearest), r2)
        & (L::lt(b, L::f(0.0)) | L::lt(f.dot(f), r2))
        & L::lt(L::f(1.0) - direction.dot(V3::splat(ball.axis)), L::f(ball.height))
}

/// As `reference::emission::has_met`.
#[inline(always)]
fn has_met<L: Lanes>(ground: &Ground, point: V3<L>, direction: V3<L>) -> L::M {
    let back = RayLanes { origin: point, direction: -direction, leaves: L::u(NO_SPHERE) };
    let (t, meets) = from_above(ground, &back);
    (meets & L::lt(t, L::f(f32::INFINITY))) | !L::lt(L::f(0.0), power(ground, point))
}

/// Where lines through points leave their lamp, or where they enter a shell; and which of them cross it.
#[inline(always)]
fn end_of_chord<L: Lanes>(lamp: &LampLanes<L>, point: V3<L>, direction: V3<L>) -> (V3<L>, L::M) {
    let f = point - lamp.center;
    let nearest = f - direction.scale(f.dot(direction));
    let half_chord2 = lamp.radius * lamp.radius - nearest.dot(nearest);
    let half_chord = L::sqrt(half_chord2);
    let along = L::select(lamp.shines_inwards, -half_chord, half_chord);
    let from_center = nearest + direction.scale(along);
    let outward = from_center.scale(L::f(1.0) / L::sqrt(from_center.dot(from_center)));
    (lamp.center + outward.scale(lamp.radius), L::le(L::f(0.0), half_chord2))
}
