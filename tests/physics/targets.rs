//! What photons are aimed at, learnt from arrivals that are made up for it: which balls, how many photons for each, and what
//! is gained.

use crate::cases::tell;
use crate::harness::{BLACK, Build, diffuse, empty_scene, pinhole};
use glam::DVec3;
use scene::aim::{Aim, Arrival, Target, Targets};
use scene::rng::{Family, Stream, StreamKey};
use scene::{Rgb, Scene, Vec3};

/// A lamp above the origin, one far from it, and a wide ground.
fn lit(sun: Vec3, sun_radius: f32) -> Scene {
    empty_scene(pinhole(Vec3::Z * 9.0, Vec3::ZERO, 30.0))
        .ball(Vec3::NEG_Y * 5001.0, 5000.0, diffuse(0.5))
        .lamp(Vec3::Y * 40.0, 0.5, BLACK, Rgb::ONE)
        .lamp(sun, sun_radius, BLACK, Rgb::ONE)
}

const SUN: (Vec3, f32) = (Vec3::new(0.0, 3e4, 0.0), 300.0);

fn under_a_sun() -> Scene {
    lit(SUN.0, SUN.1)
}

/// A place in a cube of side 2 around the origin.
fn place(stream: &mut Stream) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| 2.0 * stream.next_f32() - 1.0))
}

/// Light from the lamp above the origin.
fn arrival(point: Vec3, flux: f32) -> Arrival {
    Arrival { point, source: Vec3::Y * 39.5, flux }
}

/// `count` arrivals within `radius` of each of these places, along every axis.
fn heaps(places: &[Vec3], count: u32, radius: f32) -> Vec<Arrival> {
    let mut stream = StreamKey::new(17, Family::Survey, 0).stream(0);
    let all = places.iter().flat_map(|&center| (0..count).map(move |_| center));
    all.map(|center| arrival(center + place(&mut stream) * radius, 1.0)).collect()
}

fn learnt(scene: &Scene, arrivals: &[Arrival]) -> Targets {
    let targets = Targets::new(&scene.at(0.0), arrivals.to_vec());
    assert_eq!(targets.shares.len(), targets.balls.len() + 1, "nothing is aimed: {}", targets.expected);
    targets
}

/// Roundings of a radius.
const RADIUS: f64 = 1e-6;

fn holds(ball: &Target, point: Vec3) -> bool {
    ball.center.as_dvec3().distance(point.as_dvec3()) <= f64::from(ball.radius) * (1.0 + RADIUS)
}

/// Sixteen heaps of arrivals that are far from each other, four along each of two axes: whichever these are, each heap has a
/// ball of its own, of its size.
#[test]
fn each_of_sixteen_heaps_of_arrivals_has_a_ball_of_its_own() {
    /// From the middle to the corner of a cube of side 2.
    const CORNER: f32 = 1.733;
    let scene = under_a_sun();
    let mut found = 0;
    for [along, across] in [[Vec3::X, Vec3::Y], [Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::X]] {
        let center = |k: u32| along * (k / 4 * 4) as f32 + across * (k % 4 * 3) as f32;
        let arrivals = heaps(&(0..16).map(center).collect::<Vec<_>>(), 64, 0.2);
        let targets = learnt(&scene, &arrivals);
        for arrival in &arrivals {
            let around = targets.balls.iter().filter(|ball| holds(ball, arrival.point));
            let narrowest = around.map(|ball| ball.radius).fold(f32::INFINITY, f32::min);
            assert!(narrowest < 0.2 * CORNER, "{arrival:?} is in no ball narrower than {narrowest}");
            found += 1;
        }
    }
    tell("physics", found, "arrivals in balls of their heap");
}

/// Arrivals that all lie in one place have a ball as well, which their lines cross.
#[test]
fn arrivals_in_one_place_have_a_ball_that_light_crosses() {
    let scene = under_a_sun();
    for count in [64, 16] {
        let mut arrivals = heaps(&[Vec3::new(3.0, 0.5, 1.0)], count, 0.0);
        arrivals.extend(heaps(&[Vec3::NEG_X * 3.0], 64, 0.5));
        let targets = learnt(&scene, &arrivals);
        let one = arrivals[0];
        let direction = (one.point - one.source).normalize();
        // All balls of the tree that hold the place but no other arrival.
        let around: Vec<_> =
            targets.balls.iter().filter(|ball| holds(ball, one.point) && ball.center.x > 2.0).collect();
        assert!(!around.is_empty(), "no ball around {count} arrivals in one place");
        for ball in around {
            assert!(ball.radius > 0.0 && ball.is_crossed(one.source, direction), "no light crosses {ball:?}");
        }
    }
}

/// What surfaces scatter photons towards holds all places where light arrives, and is no wider than the box around them,
/// where none lies apart from the others.
#[test]
fn photons_are_scattered_towards_all_places_of_arrival_and_no_more() {
    let scene = under_a_sun();
    for centers in [vec![Vec3::ZERO, Vec3::X * 3.0], vec![Vec3::Z, Vec3::new(5.0, 2.0, -4.0), Vec3::NEG_X]] {
        let arrivals = heaps(&centers, 100, 0.5);
        let aim = Aim::new(&scene.at(0.0), &learnt(&scene, &arrivals), 1 << 16);
        let region = aim.region.unwrap();
        assert!(arrivals.iter().all(|arrival| holds(&region, arrival.point)), "{region:?}");
        let points = || arrivals.iter().map(|arrival| arrival.point.as_dvec3());
        let (low, high) = (points().reduce(DVec3::min).unwrap(), points().reduce(DVec3::max).unwrap());
        let most = 0.5 * (high - low).length() * (1.0 + RADIUS);
        assert!(f64::from(region.radius) <= most, "{region:?} from {low} to {high}");
    }
}

/// A few places far across a plain do not widen it, or photons between them and what is seen would weigh too much. It is a target as
/// well, for light from every direction of arrival.
#[test]
fn a_few_places_far_away_do_not_widen_what_photons_are_scattered_towards() {
    let scene = under_a_sun();
    let near = heaps(&[Vec3::ZERO, Vec3::X * 3.0], 100, 0.5);
    let far = heaps(&[Vec3::new(80.0, 0.0, 5.0), Vec3::new(-30.0, 0.0, 60.0)], 5, 0.5);
    let targets = learnt(&scene, &[&near[..], &far[..]].concat());
    let region = Aim::new(&scene.at(0.0), &targets, 1 << 16).region.unwrap();
    assert!(near.iter().all(|arrival| holds(&region, arrival.point)), "{region:?}");
    assert!(!far.iter().any(|arrival| holds(&region, arrival.point)), "{region:?}");
    let middle = &targets.balls[targets.middle];
    assert_eq!((middle.center, middle.radius), (region.center, region.radius));
    for Arrival { point, source, .. } in near.iter().chain(&far) {
        // Along the same direction, through its center.
        let direction = (*point - *source).normalize();
        assert!(
            middle.is_crossed(middle.center - direction * 10.0, direction),
            "{direction} is not in {middle:?}"
        );
    }
}

/// Around the middle are balls that grow by the same factor, up to one that reaches all that reflects. How far lamps are does not
/// matter, nor do a few places far away.
#[test]
fn balls_grow_from_the_middle_to_all_that_reflects_whatever_glows_beyond() {
    /// Roundings of `f32`.
    const ROUNDING: f64 = 1e-5;
    const STEP: f64 = 4.0;
    /// The last of them grows by more where it would be hardly wider.
    const MORE: f64 = 1.25;
    let near = heaps(&[Vec3::ZERO, Vec3::X * 2.0], 100, 0.5);
    let far = heaps(&[Vec3::new(80.0, 0.0, 5.0), Vec3::new(-30.0, 0.0, 60.0)], 5, 0.5);
    for arrivals in [near.clone(), [&near[..], &far[..]].concat()] {
        let targets = learnt(&under_a_sun(), &arrivals);
        let middle = targets.balls[targets.middle];
        let around: Vec<_> = targets.balls.iter().take_while(|ball| ball.center == middle.center).collect();
        let mut radii: Vec<f64> = around.iter().rev().map(|ball| ball.radius.into()).collect();
        // Where no place is far away the middle is the ball around all of them, and comes next.
        radii.retain(|radius| *radius > f64::from(middle.radius));
        let reach = middle.center.as_dvec3().distance(DVec3::NEG_Y * 5001.0) + 5000.0;
        let last = radii.pop().unwrap();
        assert!((last / reach - 1.0).abs() < ROUNDING, "{last}, not {reach}");
        assert!(
            radii.len() > 3 && last / radii[radii.len() - 1] < STEP * MORE * (1.0 + ROUNDING),
            "{radii:?}"
        );
        let mut exact = f64::from(middle.radius);
        for radius in &radii {
            exact *= STEP;
            assert!((radius / exact - 1.0).abs() < ROUNDING, "{radii:?} around {middle:?}");
        }
        // The same angle from afar, and from farther.
        for factor in [8.0, 0.5] {
            let sun = lit(SUN.0 * factor, SUN.1 * factor);
            assert_eq!(learnt(&sun, &arrivals).balls, targets.balls, "a sun {factor} times as far");
        }
    }
}

/// The ball that mirrors another.
fn mirror_image(targets: &Targets, ball: &Target, mirror: Vec3) -> Option<usize> {
    /// Roundings of `f32`: balls of a heap differ by far more.
    const SAME: f32 = 1e-4;
    let near = |a: Vec3, b: Vec3| (a - b).length() < SAME * (1.0 + b.length());
    targets.balls.iter().position(|other| {
        near(other.center, ball.center * mirror)
            && (other.radius / ball.radius - 1.0).abs() < SAME
            && near(other.axis, ball.axis * mirror)
    })
}

/// Where all is alike on both sides of a plane, both sides get as many photons.
#[test]
fn what_mirrors_each_other_gets_as_many_photons() {
    /// Sums in another order, and balls by roundings of `f32`.
    const ROUNDING: f64 = 1e-3;
    let scene = under_a_sun();
    let mut pairs = 0;
    for mirror in [Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, 1.0, -1.0)] {
        // Longest across the plane, so that this is what divides them first.
        let across = (Vec3::ONE - mirror) * 0.5;
        let mut arrivals = heaps(&[across * 4.0, across * 6.0 + Vec3::Y], 64, 0.7);
        arrivals.iter_mut().enumerate().for_each(|(k, arrival)| arrival.flux = 1.0 + (k % 7) as f32);
        let others: Vec<Arrival> = arrivals.iter().map(|a| arrival(a.point * mirror, a.flux)).collect();
        arrivals.extend(others);
        let targets = learnt(&scene, &arrivals);
        for (k, ball) in targets.balls.iter().enumerate() {
            let other = mirror_image(&targets, ball, mirror);
            let other = other.unwrap_or_else(|| panic!("nothing mirrors {ball:?}"));
            let (share, others) = (targets.shares[k + 1], targets.shares[other + 1]);
            assert!(
                (share / others - 1.0).abs() < ROUNDING,
                "{share} for {ball:?}, {others} for its mirror image"
            );
            pairs += usize::from(other != k);
        }
    }
    assert!(pairs >= 60, "{pairs} balls with another mirror image");
    tell("physics", pairs, "balls that mirror each other");
}

/// Of two heaps that mirror each other but for the light that arrives, the brighter gets more photons: where neither can have
/// the other's, the least variance is that of shares by the root of the light. A part is spread evenly over all balls alike.
#[test]
fn photons_are_sent_by_the_root_of_the_light_that_arrives() {
    /// Sums in another order.
    const ROUNDING: f64 = 1e-3;
    let mirror = Vec3::new(-1.0, 1.0, 1.0);
    let scene = under_a_sun();
    for light in [4.0_f32, 100.0] {
        let mut arrivals = heaps(&[Vec3::X * 4.0], 128, 0.5);
        let others = arrivals.clone();
        for arrival in &mut arrivals {
            arrival.flux = light;
        }
        arrivals.extend(others.iter().map(|a| arrival(a.point * mirror, a.flux)));
        let targets = learnt(&scene, &arrivals);
        let is_bright = |ball: &Target| ball.center.x > ball.radius;
        let bright = (0..targets.balls.len()).filter(|k| is_bright(&targets.balls[*k]));
        let mut shares: Vec<[f64; 2]> = bright
            .map(|k| {
                let dim = mirror_image(&targets, &targets.balls[k], mirror).expect("a mirror image");
                [targets.shares[dim + 1], targets.shares[k + 1]]
            })
            .collect();
        shares.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let ([low, of_low], [high, of_high]) = (shares[0], shares[shares.len() - 1]);
        assert!(shares.len() > 8 && high > 1.1 * low, "{shares:?}");
        let (found, expected) = ((of_high - of_low) / (high - low), f64::from(light).sqrt());
        assert!((found / expected - 1.0).abs() < ROUNDING, "{found} times as many photons, not {expected}");
    }
}

/// What is expected to be left of the variance is the mean weight of photons that come along the lines of the arrivals, as
/// they are weighed when they fly.
#[test]
fn the_expected_variance_is_the_weight_of_what_arrives() {
    /// Runs of photons in place of shares, and roundings of `f32`.
    const RUNS: f64 = 2e-3;
    let scene = under_a_sun();
    for centers in [vec![Vec3::ZERO], vec![Vec3::X * 4.0, Vec3::ZERO, Vec3::Z * 5.0]] {
        let mut arrivals = heaps(&centers, 100, 0.4);
        arrivals.iter_mut().enumerate().for_each(|(k, arrival)| arrival.flux = 1.0 + (k % 13) as f32);
        let targets = learnt(&scene, &arrivals);
        let aim = Aim::new(&scene.at(0.0), &targets, 1 << 26);
        let weight = |arrival: &Arrival| {
            let direction = (arrival.point - arrival.source).normalize();
            f64::from(arrival.flux * aim.weight(arrival.source, direction))
        };
        let flux: f64 = arrivals.iter().map(|arrival| f64::from(arrival.flux)).sum();
        let found = arrivals.iter().map(weight).sum::<f64>() / flux;
        assert!((found / targets.expected - 1.0).abs() < RUNS, "{found}, not {}", targets.expected);
    }
}
