//! What to aim at, and how often, by what a survey has found.

use super::groups::{Group, fluxes, groups};
use super::target::{ALL_DIRECTIONS, Target};
use super::units::LEAST_FLUX;
use crate::guide::{Arrival, Guide};
use crate::ranks::range_within;
use crate::sphere::Sphere;
use crate::still::{Role, Still};
use glam::{DVec3, Vec3};
use std::num::NonZero;
use std::slice;
use std::sync::Arc;

/// Leaves of the tree of targets: a power of two.
const LEAVES: usize = 16;

/// Balls around the middle, each so many times as large as the one before, up to one around all that reflects. Little of the light that
/// matters arrives outside of the middle, but photons that leave all lamps alike may weigh 2^30 times as much as those aimed at it: one
/// that found its way to the eye would be a spark. Between these balls weights grow step by step.
const STEP: f64 = 4.0;

/// There are no more of them than this.
const MOST_AROUND: usize = 16;

/// Fewer arrivals than this tell nothing.
const LEAST_ARRIVALS: usize = 16;

/// Nor do fewer in a leaf of the tree.
const LEAST_IN_LEAF: usize = 8;

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

/// Balls around the middle that grow by less than this would be of no use, nor would a middle that is hardly narrower.
const WIDE: f64 = 1.25;

/// The share of arrivals that lie outside of the middle at each end of each axis.
const OUTLYING: f64 = 0.1;

/// What the ball around the middle is widened by.
const MIDDLE_WIDENED: f64 = 1.5;

/// Directions whose mean is shorter than this come from everywhere.
const LEAST_MEAN: f64 = 0.1;

/// What caps are widened by: arrivals are a sample.
const CAP_WIDENED: f64 = 1.1;

/// And that of a single direction: some hundred times what rounding makes of it.
const LEAST_CAP: f64 = 1e-5;

/// What photons are aimed at in all iterations, and how many at what.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Targets {
    /// The balls: those around the middle, the tree of arrivals, whose inner nodes come before what is within, and last the middle, if it
    /// is narrower than the root of the tree.
    pub balls: Vec<Target>,
    /// The index of the middle, or else of the root: for [`Aim::region`](super::Aim::region).
    pub middle: usize,
    /// The share of each component: of uniform emission first, then of each ball. Empty if nothing is aimed.
    pub shares: Vec<f64>,
    /// The variance expected, over that of uniform emission.
    pub expected: f64,
    /// Where nothing is aimed, how photons are guided, if they are.
    pub guide: Option<Arc<Guide>>,
}

impl Targets {
    /// What to aim at, from `arrivals`, and from the lamps of `still`, those of the first iteration.
    pub fn new(still: &Still, mut arrivals: Vec<Arrival>) -> Self {
        if arrivals.len() < LEAST_ARRIVALS {
            return Self::default();
        }
        let all = ball_around(&arrivals, 0.0);
        if all.1 == 0.0 {
            // All at one place: nothing tells how large it is.
            return Self::default();
        }
        let cap = cap_around(&arrivals);
        let least = all.1 * LEAST_RADIUS;
        let ball = middle(&arrivals, cap, least);
        let is_narrower = f64::from(ball.radius) * WIDE < all.1;
        let mut balls = Vec::new();
        surround(still, if is_narrower { (ball.center, ball.radius.into()) } else { all }, cap, &mut balls);
        let root = balls.len();
        let leaves = LEAVES.min(1 << (arrivals.len() / LEAST_IN_LEAF).ilog2());
        divide(&mut arrivals, leaves, least, &mut balls);
        let middle = if is_narrower { balls.len() } else { root };
        balls.extend(is_narrower.then_some(ball));
        let groups = groups(still).0;
        for ball in &mut balls {
            widen(ball, &groups);
        }
        let fluxes = fluxes(&balls, &groups);
        let densities: Vec<f64> =
            std::iter::once(1.0).chain(fluxes.into_iter().map(|flux| 1.0 / flux)).collect();
        let lines: Vec<Line> = arrivals.iter().map(|a| Line::new(a, &balls)).collect();
        let shares = search(&lines, &densities);
        let expected = variance(&lines, &densities, &shares);
        let shares = if expected < WORTH_IT { shares } else { Vec::new() };
        Self { balls, middle, shares, expected, guide: None }
    }
}

/// Widens a ball that so little of the lamps' flux crosses that it would not be counted finely enough.
fn widen(ball: &mut Target, groups: &[Group]) {
    // A ball that no light crosses stays as it is.
    while (f64::MIN_POSITIVE..LEAST_FLUX).contains(&fluxes(slice::from_ref(ball), groups)[0]) {
        let radius = 2.0 * ball.radius;
        (ball.radius, ball.radius_squared) = (radius, radius * radius);
    }
}

/// The ball around the places that are not among the outlying ones along any axis, widened, with the cap of all arrivals.
///
/// A few arrivals far across a plain make the ball around all many times as wide as what is seen. A photon whose line crosses no
/// narrower ball weighs in proportion to the square of that radius: where it is seen, it is a spark.
fn middle(arrivals: &[Arrival], (axis, height): (Vec3, f32), least: f64) -> Target {
    let outlying = (OUTLYING * arrivals.len() as f64) as usize;
    let edges =
        [0, 1, 2].map(|axis| range_within(arrivals.iter().map(|a| a.point[axis]).collect(), outlying));
    let [low, high] = [0, 1].map(|end| Vec3::from_array(edges.map(|edge| edge[end])));
    let is_within = |a: &&Arrival| a.point.cmpge(low).all() && a.point.cmple(high).all();
    let within: Vec<Arrival> = arrivals.iter().filter(is_within).copied().collect();
    let (center, radius) = ball_around(&within, 0.0);
    Target { axis, height, ..Target::ball(center, (radius * MIDDLE_WIDENED).max(least) as f32) }
}

/// The line of an arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    flux: f64,
    /// A bit for each component that it belongs to.
    components: u64,
}

/// The most components of an aim: uniform emission, the balls around the middle, the tree and the middle.
const MOST_COMPONENTS: usize = 1 + MOST_AROUND + (2 * LEAVES - 1) + 1;
const _: () = assert!(MOST_COMPONENTS <= u64::BITS as usize, "a line has a bit for each component");

impl Line {
    fn new(arrival: &Arrival, balls: &[Target]) -> Self {
        let way = arrival.point - arrival.source;
        let length = way.dot(way).sqrt();
        let direction = way * (1.0 / length);
        // From far lamps the line is told apart from its neighbours only near the targets. All lie within three times the widest, as
        // the centre of each lies in the ball around all arrivals.
        let widest = balls.iter().map(|ball| ball.radius).fold(0.0, f32::max);
        let back = if balls.is_empty() { length } else { (3.0 * widest).min(length) };
        let origin = arrival.point - direction * back;
        let crossed = (1..).zip(balls).filter(|(_, ball)| ball.is_crossed(origin, direction));
        let components = crossed.fold(1, |bits, (k, _): (u32, _)| bits | 1 << k);
        Self { flux: f64::from(arrival.flux), components }
    }

    /// The numbers of its components, in order.
    fn components(&self) -> impl Iterator<Item = usize> + use<> {
        let without_least = |bits: &NonZero<u64>| NonZero::new(bits.get() & (bits.get() - 1));
        std::iter::successors(NonZero::new(self.components), without_least)
            .map(|bits| bits.trailing_zeros() as usize)
    }

    /// The density of lines here, of photons by these shares.
    fn density(&self, densities: &[f64], shares: &[f64]) -> f64 {
        self.components().map(|k| densities[k] * shares[k]).sum()
    }
}

/// The variance that photons leave, over that which uniform emission leaves: the mean weight of what arrives.
fn variance(lines: &[Line], densities: &[f64], shares: &[f64]) -> f64 {
    let (with, without) = lines.iter().fold((0.0, 0.0), |(with, without), line| {
        (with + line.flux * (1.0 / line.density(densities, shares)), without + line.flux)
    });
    with / without
}

/// The shares that leave the least variance, by the multiplicative steps of optimal design (Silvey, Titterington and
/// Torsney 1978), each of which lessens it; then mixed with those that are always granted.
fn search(lines: &[Line], densities: &[f64]) -> Vec<f64> {
    let count = densities.len() as f64;
    let mut shares = vec![1.0 / count; densities.len()];
    for _ in 0..STEPS {
        let mut gains = vec![0.0; shares.len()];
        for line in lines {
            let density = line.density(densities, &shares);
            let gain = line.flux / (density * density);
            for k in line.components() {
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
        return (Vec3::Z, ALL_DIRECTIONS);
    }
    let axis = mean.normalize().as_vec3();
    let height = arrivals.iter().map(|a| 1.0 - direction(a).dot(axis.as_dvec3())).fold(0.0, f64::max);
    (axis, (height * CAP_WIDENED + LEAST_CAP) as f32)
}

/// Adds the balls around the ball (`center`, `radius`), the largest first.
fn surround(
    still: &Still,
    (center, radius): (Vec3, f64),
    (axis, height): (Vec3, f32),
    balls: &mut Vec<Target>,
) {
    let is_object = |role: &Role| !matches!(role, Role::Enclosure(_));
    let objects =
        still.spheres.iter().zip(still.roles.iter()).filter(|(s, role)| is_object(role) && !s.is_emitter());
    let reach =
        |(s, _): (&Sphere, &Role)| s.center.as_dvec3().distance(center.as_dvec3()) + f64::from(s.radius);
    let all = objects.map(reach).fold(radius, f64::max);
    let grown = std::iter::successors(Some(radius * STEP), |radius| Some(radius * STEP));
    let mut radii: Vec<f64> = grown.take(MOST_AROUND - 1).take_while(|radius| radius * WIDE < all).collect();
    radii.extend((radius * WIDE < all).then_some(all));
    balls.extend(radii.iter().rev().map(|&r| Target { axis, height, ..Target::ball(center, r as f32) }));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aim::Aim;
    use crate::aim::groups::flux;
    use crate::test_scenes::balls;

    /// Lines that each cross one of two targets, whose components are 1 and 2.
    fn lines() -> Vec<Line> {
        [(9.0, 0b11), (1.0, 0b101), (3.0, 0b101)].map(|(flux, components)| Line { flux, components }).into()
    }

    /// Of targets that share no lines, each is due a share that goes as the root of its flux over its density: then no other
    /// shares leave less variance (by Lagrange's multiplier).
    #[test]
    fn targets_of_their_own_lines_get_the_best_shares() {
        let densities = [1e-12, 2.0, 8.0];
        let shares = search(&lines(), &densities);
        let learnt = 1.0 - UNIFORM_SHARE - EVEN_SHARE;
        let roots = [(9.0_f64 / 2.0).sqrt(), (4.0_f64 / 8.0).sqrt()];
        for (share, root) in shares[1..].iter().zip(roots) {
            let exact = learnt * root / (roots[0] + roots[1]) + EVEN_SHARE / 3.0;
            assert!((share / exact - 1.0).abs() < 1e-5, "{share}, not {exact}");
        }
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // It is less than that of shares without learning.
        assert!(variance(&lines(), &densities, &shares) < variance(&lines(), &densities, &[1.0 / 3.0; 3]));
    }

    /// It is relative to that of uniform emission, whatever the unit of flux.
    #[test]
    fn variances_are_relative() {
        let (densities, shares) = ([1.0, 2.0, 8.0], [0.5, 0.3, 0.2]);
        assert_eq!(variance(&lines(), &densities, &[1.0, 0.0, 0.0]), 1.0);
        let found = variance(&lines(), &densities, &shares);
        let exact = (9.0 / (0.5 + 0.6) + 4.0 / (0.5 + 1.6)) / 13.0;
        assert!((found - exact).abs() < 1e-12, "{found}, not {exact}");
        let brighter: Vec<_> = lines().into_iter().map(|l| Line { flux: 1e6 * l.flux, ..l }).collect();
        assert!((variance(&brighter, &densities, &shares) - found).abs() < 1e-12);
    }

    /// Up to one that holds all that reflects, lamps and rooms left out.
    #[test]
    fn balls_around_the_middle_grow_step_by_step_to_all_that_reflects() {
        let far = Vec3::new(0.0, 30.0, 40.0);
        let scene =
            balls(&[(Vec3::ZERO, 900.0, 0.0), (far, 7.0, 0.0), (Vec3::X, 0.5, 0.0), (10.0 * far, 2.0, 1.0)]);
        let radii = |radius: f64| -> Vec<f32> {
            let mut found = Vec::new();
            surround(&scene.at(0.0), (Vec3::ZERO, radius), (Vec3::Y, 0.5), &mut found);
            let is_around = |ball: &Target| {
                let exact = Target::ball(Vec3::ZERO, ball.radius);
                *ball == Target { axis: Vec3::Y, height: 0.5, ..exact }
            };
            assert!(found.iter().all(is_around), "{found:?}");
            found.iter().map(|ball| ball.radius).collect()
        };
        assert_eq!(radii(2.0), [57.0, 32.0, 8.0]);
        // One of 52 would hardly be narrower.
        assert_eq!([radii(13.0), radii(40.0), radii(50.0)], [vec![57.0], vec![57.0], Vec::new()]);
        // However small the middle is, they are not too many.
        let most = radii(1e-12);
        assert_eq!((most.len(), most[0]), (MOST_AROUND, 57.0));
        assert!((f64::from(most[MOST_AROUND - 1]) / 4e-12 - 1.0).abs() < 1e-6, "{most:?}");
    }

    /// Not those around it, and not its parts: outside of it photons are scattered towards it, as long as no arrival lies apart.
    #[test]
    fn photons_are_scattered_towards_the_ball_around_all_arrivals() {
        let far = (Vec3::new(0.0, 300.0, 400.0), 7.0, 0.0);
        let scene = balls(&[(Vec3::ZERO, 1.0, 0.0), far, (40.0 * Vec3::Y, 2.0, 1.0)]);
        let still = scene.at(0.0);
        let place = |k: u16| Vec3::new(f32::from(k % 8), f32::from(k / 8), 0.0);
        let arrival = |k| Arrival { point: place(k), source: 38.0 * Vec3::Y, flux: 1.0 };
        let targets = Targets::new(&still, (0..64).map(arrival).collect());
        // After 4, 16, 64 times and all.
        assert_eq!(targets.middle, 4);
        let region = Aim::new(&still, &targets, 1000).region.unwrap();
        assert_eq!(region, Target::ball(Vec3::new(3.5, 3.5, 0.0), 3.5 * 2.0_f32.sqrt()));
        // Nothing is aimed, so nothing is scattered anywhere.
        assert_eq!(Aim::new(&still, &Targets::default(), 1000).region, None);
    }

    fn arrival(point: Vec3, source: Vec3) -> Arrival {
        Arrival { point, source, flux: 2.0 }
    }

    /// It leaves out a tenth at each end of each axis, and is half as wide again as what is left.
    #[test]
    fn outlying_arrivals_widen_the_root_and_not_the_middle() {
        // Along an axis 0, ..., 99, of which 10, ..., 89 are within; across it all are.
        let along = |axis: Vec3| -> Vec<Arrival> {
            (0..100_u8).map(|k| arrival(axis * f32::from(k) + Vec3::ONE, Vec3::splat(900.0))).collect()
        };
        for axis in Vec3::AXES {
            let ball = middle(&along(axis), (Vec3::X, 0.25), 1e-3);
            let exact =
                Target { axis: Vec3::X, height: 0.25, ..Target::ball(axis * 49.5 + Vec3::ONE, 39.5 * 1.5) };
            assert_eq!(ball, exact);
        }
        // The order does not matter.
        let mut turned = along(Vec3::Y);
        turned.rotate_left(37);
        assert_eq!(middle(&turned, (Vec3::X, 0.25), 1e-3), middle(&along(Vec3::Y), (Vec3::X, 0.25), 1e-3));
        // Arrivals at one place have the least ball.
        let ball = middle(&vec![arrival(Vec3::Z, Vec3::X); 16], (Vec3::X, 0.25), 0.5);
        assert_eq!([ball.center, Vec3::splat(ball.radius)], [Vec3::Z, Vec3::splat(0.5)]);

        // One in 65 lies far away: photons are scattered towards the others, and aimed at them by all of the cap.
        let scene = balls(&[(Vec3::ZERO, 1.0, 0.0), (40.0 * Vec3::Y, 2.0, 1.0)]);
        let still = scene.at(0.0);
        let place = |k: u16| Vec3::new(f32::from(k % 8), f32::from(k / 8), 0.0);
        let mut arrivals: Vec<Arrival> = (0..64).map(|k| arrival(place(k), 38.0 * Vec3::Y)).collect();
        arrivals.push(arrival(Vec3::X * 1000.0, 38.0 * Vec3::Y));
        let targets = Targets::new(&still, arrivals);
        // There is none around them all, as nothing that reflects is far.
        let (root, last) = (targets.balls[0], targets.balls.len() - 1);
        assert!(root.radius > 490.0 && targets.middle == last, "{root:?}");
        let region = Aim::new(&still, &targets, 1000).region.unwrap();
        assert!(region.radius < 8.0 && region.radius == targets.balls[last].radius, "{region:?}");
        assert_eq!((targets.balls[last].axis, targets.balls[last].height), (root.axis, root.height));
    }

    /// A line belongs to uniform emission, and to every ball that it crosses; from far lamps only what is near the targets counts.
    #[test]
    fn lines_belong_to_the_balls_that_they_cross() {
        let found = arrival(Vec3::ZERO, Vec3::Y * 100.0);
        let ball = |y: f32, radius| Target::ball(Vec3::Y * y, radius);
        let balls = [
            ball(0.0, 4.0),
            ball(0.0, 1.0),
            ball(90.0, 1.0),
            ball(11.0, 1.5),
            Target::ball(Vec3::X * 3.0, 2.0),
        ];
        // Three radii of the first ball are 12.
        let line = |arrival, balls: &[Target]| {
            let line = Line::new(arrival, balls);
            (line.flux, line.components().collect::<Vec<_>>())
        };
        assert_eq!(line(&found, &balls), (2.0, vec![0, 1, 2, 4]));
        assert_eq!(line(&found, &[]), (2.0, vec![0]));
        let near = arrival(Vec3::ZERO, Vec3::Y * 10.0);
        assert_eq!(line(&near, &balls), (2.0, vec![0, 1, 2, 4]));
        let nearer = arrival(Vec3::ZERO, Vec3::Y * 9.0);
        assert_eq!(line(&nearer, &balls), (2.0, vec![0, 1, 2]));
    }

    #[test]
    fn a_ball_is_around_all_arrivals() {
        let arrivals =
            [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0), Vec3::new(2.0, 6.0, 0.0)].map(|p| arrival(p, Vec3::Z));
        let (center, radius) = ball_around(&arrivals, 0.5);
        assert_eq!(center, Vec3::new(2.0, 3.0, 0.0));
        assert!((radius - 13.0_f64.sqrt()).abs() < 1e-12, "{radius}");
        assert_eq!(ball_around(&arrivals[..1], 0.5), (Vec3::ZERO, 0.5));
    }

    /// Each node before what is within, its two halves one after the other.
    #[test]
    fn arrivals_are_divided_along_the_longer_side() {
        let mut arrivals: Vec<Arrival> = (0..8_u8)
            .map(|k| arrival(Vec3::new(f32::from(k * 3 % 8), 0.25 * f32::from(k % 2), 0.0), Vec3::Z * 9.0))
            .collect();
        let mut balls = Vec::new();
        divide(&mut arrivals, 4, 0.25, &mut balls);
        let places: Vec<(f32, f32)> = balls.iter().map(|ball| (ball.center.x, ball.radius)).collect();
        assert_eq!(places.len(), 7);
        let middles = [3.5, 1.5, 0.5, 2.5, 5.5, 4.5, 6.5];
        for ((x, radius), middle) in places.iter().zip(middles) {
            assert!((x - middle).abs() < 1e-6 && *radius >= 0.5, "{places:?}");
        }
        balls.clear();
        divide(&mut arrivals, 1, 0.25, &mut balls);
        assert_eq!(balls.len(), 1);
        assert_eq!(balls[0].radius_squared, balls[0].radius * balls[0].radius);
    }

    /// Of a sun as ours, in metres: a ball of a centimetre is widened until photons aimed at it are counted by ten bits.
    #[test]
    fn balls_that_hardly_any_light_crosses_are_widened() {
        let scene = balls(&[(Vec3::ZERO, 1.0, 0.0), (1.5e11 * Vec3::Z, 7e8, 1.0)]);
        let groups = groups(&scene.at(0.0)).0;
        let lit = |radius| Target { axis: Vec3::NEG_Z, height: 0.5, ..Target::ball(Vec3::X, radius) };
        for radius in [1e-16, 1e-9, 1e-2, 0.1, 0.3, 1.0, 1e3] {
            let mut ball = lit(radius);
            let before = flux(&groups[0], &ball);
            widen(&mut ball, &groups);
            let after = flux(&groups[0], &ball);
            if before < LEAST_FLUX {
                assert!((LEAST_FLUX..4.01 * LEAST_FLUX).contains(&after), "{radius}: {after}");
            }
            let widened = if before < LEAST_FLUX { ball.radius } else { radius };
            assert_eq!(ball, lit(widened));
        }
        // No light at all comes from below.
        let mut ball = Target { axis: Vec3::Z, ..lit(1e-3) };
        widen(&mut ball, &groups);
        assert_eq!(ball.radius, 1e-3);
    }

    #[test]
    fn arrivals_at_one_place_tell_nothing() {
        let scene = balls(&[(Vec3::ZERO, 1.0, 0.0), (40.0 * Vec3::Y, 2.0, 1.0)]);
        let targets = Targets::new(&scene.at(0.0), vec![arrival(Vec3::Y, Vec3::Y * 38.0); 64]);
        assert_eq!(targets, Targets::default());
    }

    /// Too few of them tell nothing, and each leaf has enough.
    #[test]
    fn a_tree_has_as_many_leaves_as_there_are_arrivals_for() {
        let scene = balls(&[(Vec3::ZERO, 1.0, 0.0), (40.0 * Vec3::Y, 2.0, 1.0)]);
        let still = scene.at(0.0);
        let nodes = |count: u16| {
            let place = |k: u16| Vec3::new(f32::from(k % 16), f32::from(k / 16), 0.0);
            let targets =
                Targets::new(&still, (0..count).map(|k| arrival(place(k), 38.0 * Vec3::Y)).collect());
            targets.balls.len() - targets.middle
        };
        assert_eq!(
            [nodes(16), nodes(31), nodes(32), nodes(64), nodes(128), nodes(300)],
            [3, 3, 7, 15, 31, 31]
        );
        assert_eq!(Targets::new(&still, vec![arrival(Vec3::X, Vec3::Y); 15]), Targets::default());
    }

    /// Around the mean direction, as far as the farthest and a tenth more; all directions where there is no mean.
    #[test]
    fn a_cap_holds_all_directions_of_arrival() {
        let from = |degrees: f64| {
            let angle = degrees.to_radians();
            arrival(Vec3::ZERO, Vec3::new(-angle.cos() as f32, -angle.sin() as f32, 0.0) * 7.0)
        };
        let (axis, height) = cap_around(&[from(30.0), from(-30.0), from(0.0)]);
        assert!((axis - Vec3::X).length() < 1e-6, "{axis}");
        let exact = (1.0 - 30.0_f64.to_radians().cos()) * CAP_WIDENED + LEAST_CAP;
        assert!((f64::from(height) / exact - 1.0).abs() < 1e-5, "{height}, not {exact}");
        assert_eq!(cap_around(&[from(0.0), from(180.0)]), (Vec3::Z, ALL_DIRECTIONS));
        let one = cap_around(&[from(0.0)]);
        assert!((f64::from(one.1) / LEAST_CAP - 1.0).abs() < 1e-3, "{one:?}");
        // A mean that is just long enough: 1 of 9, and too short, 1 of 11.
        let many = |ahead: usize, behind: usize| {
            let all: Vec<Arrival> =
                (0..ahead).map(|_| from(0.0)).chain((0..behind).map(|_| from(180.0))).collect();
            cap_around(&all).0
        };
        assert!((many(5, 4) - Vec3::X).length() < 1e-6 && many(6, 5) == Vec3::Z);
    }
}
