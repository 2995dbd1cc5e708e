//! Photons aimed at what is seen: at which balls, with which shares, and what a photon then weighs.
//!
//! See docs/aiming.md for the derivation. Photons of a Lambertian lamp carry their flux alike over the lines that cross
//! it, and so do those of a glowing shell over the lines through it. A photon aimed at a target ball is drawn alike over
//! the lines that cross both lamp and ball, of all lamps together. So the density of component k, relative to emission
//! from all lamps alike, is one number, `1 / flux_k`, on all lines that cross ball k, and 0 on others; and a photon of
//! the mixture weighs `1 / (share_0 + sum over the balls that its line crosses of share_k / flux_k)`, exactly.
//!
//! What is computed here is set-up, shared by engines as the [`crate::still::Lights`] are: `f64`, of `+ - * /` and square
//! roots. How lines are drawn and tested is theirs.

mod core;
pub mod survey;

use crate::still::{Role, Still};
use crate::{Sphere, Vec3};
use glam::DVec3;

pub use self::core::Core;

/// Leaves of the tree of targets: a power of two.
const LEAVES: usize = 16;

/// Balls of all sizes: the nodes of the tree.
pub const MAX_TARGETS: usize = OUTER + 2 * LEAVES - 1;

/// Balls around the tree's root, ever larger, up to one around all that reflects. Light that arrives outside of the root
/// matters little, but photons that leave all lamps alike may weigh 2^30 times as much as those aimed at it: one that
/// found its way to the eye would be a spark. Between these balls weights grow step by step.
const OUTER: usize = 4;

/// Fewer arrivals than this tell nothing.
const LEAST_ARRIVALS: usize = 64;

/// The share of photons that leave all lamps alike, whatever else is learnt: no photon weighs more than its inverse.
pub const UNIFORM_SHARE: f64 = 1.0 / 8.0;

/// The share that is spread evenly over all components, whatever is learnt: what keeps the weights of lines apart
/// that cross neighbouring balls within small factors.
const EVEN_SHARE: f64 = 0.3;

/// Steps of the search for shares. Only the first is worth its while: further ones trust few arrivals, from afar, with
/// most of the photons (docs/aiming.md).
const STEPS: usize = 1;

/// Photons are aimed only if that is expected to leave at most so much of the variance. In closed rooms it gains
/// nothing, and then the image is that of uniform emission, bit for bit.
const WORTH_IT: f64 = 0.6;

/// Least radius of a target over the radius of all: below, rounding decides which lines cross it.
const LEAST_RADIUS: f64 = 1.0 / 65536.0;

/// Balls around the root that grow by less than this would be of no use.
const WIDE: f64 = 1.25;

/// [`Target::height`] of all directions, whatever rounding.
const ALL: f32 = 3.0;

/// Directions whose mean is shorter than this come from everywhere.
const LEAST_MEAN: f64 = 0.1;

/// What caps are widened by: arrivals are a sample.
const CAP_WIDENED: f64 = 1.1;

/// And that of a single direction: some hundred times what rounding makes of it.
const LEAST_CAP: f64 = 1e-5;

/// Caps whose distance is less than this overlap, for all that rounding tells.
const APART: f64 = 1e-5;

/// Lamps are aimed one by one up to so many, and by runs of neighbours beyond.
const MAX_GROUPS: usize = 1024;

/// Bits by which the unit of flux is lowered for light photons, at most. No flux exceeds 2^(3 + 21 + 38), and as fewer than
/// 2^31 photons are deposited no sum exceeds 2^93.
pub const MOST_SCALE_BITS: u32 = 38;

/// Photons are given to components in multiples of this, but for the last: no vector of photons has two components.
pub const RUN: u32 = 16;

/// Exponents of heavy photons' fluxes are multiples of this; weights of up to `2^EXPONENT_STEP` times the least need none
/// ([`Aim::scale_bits`]).
pub const EXPONENT_STEP: u32 = 8;

/// Light that arrives where it matters: what a walk from the eye over a diffuse surface found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Where.
    pub point: Vec3,
    /// Where it comes from: a point of a lamp.
    pub source: Vec3,
    /// How much, in the brightest channel; in any unit.
    pub flux: f32,
}

/// What photons are aimed at: a ball, and the directions in which it is to be crossed, a cap of the unit sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Centre of the ball.
    pub center: Vec3,
    /// Its radius.
    pub radius: f32,
    /// The square of that.
    pub radius_squared: f32,
    /// The middle of the cap.
    pub axis: Vec3,
    /// `1 - cos` of its half angle; above 2 for all directions.
    pub height: f32,
}

/// What photons are aimed at in all iterations, and how many at what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Targets {
    /// The balls, inner nodes before what is within.
    pub balls: Vec<Target>,
    /// The share of each component: of uniform emission first, then of each ball. Empty if nothing is aimed.
    pub shares: Vec<f64>,
    /// The variance expected, over that of uniform emission.
    pub expected: f64,
}

/// A lamp, or lamps that stand together, as photons are aimed from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Centre of a ball around them.
    pub center: Vec3,
    /// Its radius.
    pub radius: f32,
    /// The first of its lights in [`Aim::order`].
    pub first: u32,
    /// One past the last.
    pub end: u32,
    /// The share of all power.
    pub share: f64,
}

/// All that aimed emission from the lamps of one instant needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Aim {
    /// The targets of the components from 1 on.
    pub balls: Vec<Target>,
    /// The first photon after those of each component. Empty if nothing is aimed.
    pub ends: Vec<u32>,
    /// What the weight's denominator has of each component, where a line belongs to it.
    pub densities: Vec<f32>,
    /// For each ball, for each group the probability of it or one before, but the last.
    pub cumulative: Vec<Vec<f32>>,
    /// Lamps as they are aimed.
    pub groups: Vec<Group>,
    /// The lights of the groups, in a row.
    pub order: Vec<u32>,
    /// For each place in the order, the share that lights up to it have of their group's power.
    pub within: Vec<f32>,
    /// Where photons of far lamps start.
    pub core: Option<Core>,
    /// Fluxes count in units of `2^-scale_bits` of what they are without aiming.
    pub scale_bits: u32,
}

/// The cone of directions of all lines that cross both of two balls: its axis, and `1 - cos` of its half angle. All
/// directions if the balls touch.
pub fn cone(from: Vec3, from_radius: f32, to: Vec3, to_radius: f32) -> (Vec3, f32) {
    let axis = to - from;
    let d2 = axis.dot(axis);
    let reach = from_radius + to_radius;
    let sin2 = reach * reach / d2;
    if sin2 < 1.0 { (axis * (1.0 / d2.sqrt()), sin2 / (1.0 + (1.0 - sin2).sqrt())) } else { (Vec3::Z, 2.0) }
}

impl Target {
    /// A ball, to be crossed in any direction.
    pub fn ball(center: Vec3, radius: f32) -> Self {
        Self { center, radius, radius_squared: radius * radius, axis: Vec3::Z, height: ALL }
    }

    /// The directions to draw from for lines that come from another ball: the smaller of the cone that holds all lines
    /// which cross both balls, and the cap.
    pub fn directions(&self, from: Vec3, from_radius: f32) -> (Vec3, f32) {
        let (axis, height) = cone(from, from_radius, self.center, self.radius);
        if self.height < height { (self.axis, self.height) } else { (axis, height) }
    }

    /// True if the half line from `origin` crosses the ball. Whatever asks for the weight of a line asks this, so that a
    /// line belongs to a component or does not, whichever component drew it.
    #[inline]
    pub fn is_crossed(&self, origin: Vec3, direction: Vec3) -> bool {
        let f = origin - self.center;
        let b = f.dot(direction);
        let nearest = f - direction * b;
        nearest.dot(nearest) < self.radius_squared
            && (b < 0.0 || f.dot(f) < self.radius_squared)
            && 1.0 - direction.dot(self.axis) < self.height
    }
}

impl Targets {
    /// What to aim at, from `arrivals`, and from the lamps of `still`, those of the first iteration.
    pub fn new(still: &Still, mut arrivals: Vec<Arrival>) -> Self {
        if arrivals.len() < LEAST_ARRIVALS {
            return Self::default();
        }
        let mut balls = Vec::new();
        let all = ball_around(&arrivals, 0.0);
        surround(still, all, cap_around(&arrivals), &mut balls);
        divide(&mut arrivals, LEAVES, all.1 * LEAST_RADIUS, &mut balls);
        let fluxes = fluxes(&balls, &groups(still).0);
        let densities: Vec<f64> =
            std::iter::once(1.0).chain(fluxes.into_iter().map(|flux| 1.0 / flux)).collect();
        let lines: Vec<(f64, Vec<usize>)> = arrivals.iter().map(|a| line(a, &balls)).collect();
        let shares = search(&lines, &densities);
        let expected = variance(&lines, &densities, &shares);
        let shares = if expected < WORTH_IT { shares } else { Vec::new() };
        Self { balls, shares, expected }
    }
}

/// The flux of an arrival, and the components that its line belongs to.
fn line(arrival: &Arrival, balls: &[Target]) -> (f64, Vec<usize>) {
    let way = arrival.point - arrival.source;
    let length = way.dot(way).sqrt();
    let direction = way * (1.0 / length);
    // From far lamps the line is told apart from its neighbours only near the targets: all lie in the first.
    let back = balls.first().map_or(length, |all| (3.0 * all.radius).min(length));
    let origin = arrival.point - direction * back;
    let crossed = (1..).zip(balls).filter(|(_, ball)| ball.is_crossed(origin, direction));
    (f64::from(arrival.flux), std::iter::once(0).chain(crossed.map(|(k, _)| k)).collect())
}

/// The variance that photons leave, over that which uniform emission leaves: the mean weight of what arrives.
fn variance(lines: &[(f64, Vec<usize>)], densities: &[f64], shares: &[f64]) -> f64 {
    let weight =
        |components: &[usize]| 1.0 / components.iter().map(|&k| densities[k] * shares[k]).sum::<f64>();
    let (with, without) = lines
        .iter()
        .fold((0.0, 0.0), |(with, without), (flux, of)| (with + flux * weight(of), without + flux));
    with / without
}

/// The shares that leave the least variance, by the multiplicative steps of optimal design (Silvey, Titterington and
/// Torsney 1978), each of which lessens it; then mixed with those that are always granted.
fn search(lines: &[(f64, Vec<usize>)], densities: &[f64]) -> Vec<f64> {
    let count = densities.len() as f64;
    let mut shares = vec![1.0 / count; densities.len()];
    for _ in 0..STEPS {
        let mut gains = vec![0.0; shares.len()];
        for (flux, of) in lines {
            let density: f64 = of.iter().map(|&k| densities[k] * shares[k]).sum();
            let gain = flux / (density * density);
            for &k in of {
                gains[k] += gain * densities[k];
            }
        }
        for (share, gain) in shares.iter_mut().zip(&gains) {
            *share *= gain.sqrt();
        }
        let sum: f64 = shares.iter().sum();
        for share in &mut shares {
            *share /= sum;
        }
    }
    let learnt = 1.0 - UNIFORM_SHARE - EVEN_SHARE;
    for share in &mut shares {
        *share = learnt * *share + EVEN_SHARE / count;
    }
    shares[0] += UNIFORM_SHARE;
    shares
}

/// Centre and radius of a ball around arrivals.
fn ball_around(arrivals: &[Arrival], least: f64) -> (Vec3, f64) {
    let points = || arrivals.iter().map(|a| a.point.as_dvec3());
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    let center = (0.5 * (low + high)).as_vec3();
    let radius = points().map(|p| p.distance(center.as_dvec3())).fold(least, f64::max);
    (center, radius)
}

/// The cap that holds the directions in which light arrives: its axis, and `1 - cos` of its half angle.
fn cap_around(arrivals: &[Arrival]) -> (Vec3, f32) {
    let direction = |a: &Arrival| (a.point.as_dvec3() - a.source.as_dvec3()).normalize_or_zero();
    let mean = arrivals.iter().map(direction).sum::<DVec3>();
    if mean.length() < LEAST_MEAN * arrivals.len() as f64 {
        return (Vec3::Z, ALL);
    }
    let axis = mean.normalize().as_vec3();
    let height = arrivals.iter().map(|a| 1.0 - direction(a).dot(axis.as_dvec3())).fold(0.0, f64::max);
    (axis, (height * CAP_WIDENED + LEAST_CAP) as f32)
}

/// Adds the balls around the ball (`center`, `radius`), the largest first, each as many times as large as the next.
fn surround(
    still: &Still,
    (center, radius): (Vec3, f64),
    (axis, height): (Vec3, f32),
    balls: &mut Vec<Target>,
) {
    let is_object = |role: &Role| !matches!(role, Role::Enclosure(_));
    let objects =
        still.spheres.iter().zip(&still.roles).filter(|(s, role)| is_object(role) && !s.is_emitter());
    let reach =
        |(s, _): (&Sphere, &Role)| s.center.as_dvec3().distance(center.as_dvec3()) + f64::from(s.radius);
    let step = (objects.map(reach).fold(radius, f64::max) / radius).sqrt().sqrt();
    if step < WIDE {
        return;
    }
    for power in (1..=OUTER as i32).rev() {
        let radius = (radius * (0..power).fold(1.0, |product, _| product * step)) as f32;
        balls.push(Target { axis, height, ..Target::ball(center, radius) });
    }
}

/// Adds the ball around arrivals, and those around each half of them, down to `leaves` parts.
fn divide(arrivals: &mut [Arrival], leaves: usize, least: f64, balls: &mut Vec<Target>) {
    let (center, radius) = ball_around(arrivals, least);
    let (axis, height) = cap_around(arrivals);
    balls.push(Target { axis, height, ..Target::ball(center, radius as f32) });
    if leaves < 2 {
        return;
    }
    let points = || arrivals.iter().map(|a| a.point.as_dvec3());
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    let axis = (high - low).max_position();
    let middle = arrivals.len() / 2;
    arrivals.select_nth_unstable_by(middle, |a, b| a.point[axis].total_cmp(&b.point[axis]));
    let (first, second) = arrivals.split_at_mut(middle);
    divide(first, leaves / 2, least, balls);
    divide(second, leaves / 2, least, balls);
}

/// Lights in groups: each by itself, or where there are many in runs of neighbours; and the lights in that order.
fn groups(still: &Still) -> (Vec<Group>, Vec<u32>) {
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
fn flux(group: &Group, ball: &Target) -> f64 {
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

impl Group {
    /// True if lines are drawn through a disk at the ball, which is smaller; false if at the lamp.
    pub fn is_aimed_by_disk(&self, ball: &Target) -> bool {
        self.end - self.first == 1 && ball.radius < self.radius
    }
}

fn fluxes(balls: &[Target], groups: &[Group]) -> Vec<f64> {
    balls.iter().map(|ball| groups.iter().map(|group| flux(group, ball)).sum()).collect()
}

impl Aim {
    /// How `photons` of an iteration are aimed from the lamps of `still`.
    pub fn new(still: &Still, targets: &Targets, photons: u32) -> Self {
        if targets.shares.is_empty() || still.lights.entries.is_empty() {
            return Self::default();
        }
        let (groups, order) = groups(still);
        let mut aim = Self { balls: targets.balls.clone(), groups, order, ..Self::default() };
        aim.allot(targets, photons);
        let fluxes = fluxes(&aim.balls, &aim.groups);
        let count = |k: usize| f64::from(aim.ends[k] - if k > 0 { aim.ends[k - 1] } else { 0 });
        let density = |k: usize| count(k) / f64::from(photons) / if k > 0 { fluxes[k - 1] } else { 1.0 };
        aim.densities = (0..aim.ends.len()).map(|k| density(k) as f32).collect();
        aim.cumulative = aim.balls.iter().zip(&fluxes).map(|(ball, sum)| aim.cumulate(ball, *sum)).collect();
        aim.within = aim.cumulate_groups(still);
        aim.core = Core::new(still, &aim.balls);
        let most: f64 = aim.densities.iter().map(|&d| f64::from(d)).sum();
        while aim.scale_bits < MOST_SCALE_BITS && most >= (1_u64 << (aim.scale_bits + EXPONENT_STEP)) as f64 {
            aim.scale_bits += 1;
        }
        aim
    }

    /// Gives each component a run of the photons, so that each has its own run of Sobol points.
    fn allot(&mut self, targets: &Targets, photons: u32) {
        // However few there are, some leave all lamps alike.
        let least = ((f64::from(photons) * UNIFORM_SHARE) as u32 + 1).next_multiple_of(RUN);
        let mut sum = 0.0;
        for share in &targets.shares {
            sum += share;
            let end = (sum * f64::from(photons)) as u32;
            self.ends.push((end - end % RUN).max(least).min(photons));
        }
        if let Some(last) = self.ends.last_mut() {
            *last = photons;
        }
    }

    fn cumulate(&self, ball: &Target, all: f64) -> Vec<f32> {
        let mut sum = 0.0;
        let step = |group: &Group| {
            sum += flux(group, ball) / all;
            sum as f32
        };
        self.groups[..self.groups.len() - 1].iter().map(step).collect()
    }

    fn cumulate_groups(&self, still: &Still) -> Vec<f32> {
        let mut within = Vec::with_capacity(self.order.len());
        for group in &self.groups {
            let mut sum = 0.0;
            for &light in &self.order[group.first as usize..group.end as usize] {
                sum += f64::from(still.lights.entries[light as usize].probability) / group.share;
                within.push(sum as f32);
            }
        }
        within
    }

    /// The component that photon `photon` is drawn from: 0 for uniform emission, else one more than its ball.
    pub fn component(&self, photon: u32) -> usize {
        self.ends.partition_point(|&end| end <= photon)
    }

    /// The light that `u` chooses for a photon aimed at `ball`, where it has chosen `group`.
    pub fn light_of(&self, ball: usize, group: usize, u: f32) -> u32 {
        let (cumulative, Group { first, end, .. }) = (&self.cumulative[ball], self.groups[group]);
        let (first, end) = (first as usize, end as usize);
        if end - first == 1 {
            return self.order[first];
        }
        let before = if group > 0 { cumulative[group - 1] } else { 0.0 };
        let after = cumulative.get(group).copied().unwrap_or(1.0);
        let rest = (u - before) / (after - before);
        self.order[first + self.within[first..end - 1].partition_point(|&c| c <= rest)]
    }

    /// What multiplies a photon's power, where [`FLUX_ONE`] stands for the nominal one.
    pub fn scale(&self) -> f32 {
        (1_u64 << self.scale_bits) as f32
    }

    /// True if photons are aimed at nothing: they leave all lamps alike.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The weight of a photon that leaves its lamp along this half line; 1 if nothing is aimed.
    pub fn weight(&self, origin: Vec3, direction: Vec3) -> f32 {
        let Some((&uniform, aimed)) = self.densities.split_first() else { return 1.0 };
        let mut sum = uniform;
        for (ball, density) in self.balls.iter().zip(aimed) {
            if ball.is_crossed(origin, direction) {
                sum += density;
            }
        }
        1.0 / sum
    }
}
