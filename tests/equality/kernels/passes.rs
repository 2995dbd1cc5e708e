//! Camera pass, photon pass and direct light on their own, before their results are summed up.

use super::inputs::{self, numbers, scene_of};
use super::{assert_same_vector, check, lane_kinds, tell};
use crate::draft::{Case, case};
use crate::placement::log_uniform;
use fast::LaneKind;
use fast::kernels::{
    CameraSample, Cells, Occupancy, Photon, PhotonRun, Query, Receiver, camera_pass, direct_light,
    photon_pass, pixel_slot,
};
use proptest::prelude::*;
use reference::camera_pass::{CameraNumbers, VisiblePoint, camera_ray, trace};
use reference::contributes;
use reference::direct_light::estimate_irradiance;
use reference::glints::GlintRays;
use reference::intersect::{Hit, intersect};
use reference::photon_pass::{Deposit, Flux};
use scene::aim::{Aim, Target, Targets};
use scene::guide::{Departures, Guide, SURFACES, Shares};
use scene::ray::NO_SPHERE;
use scene::rng::{Family, StreamKey};
use scene::{Ray, Rgb, Rims, Scene, Settings, Sphere, Stats, Still, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The results of the reference's camera pass for all pixels.
fn samples(scene: &Scene, still: &Still, settings: &Settings, iteration: u32) -> (Vec<CameraSample>, Stats) {
    let frame = scene.camera.frame(settings.width, settings.height);
    let mut stats = Stats::default();
    let (filter, rims) = (settings.filter.table(), Rims::new(scene, settings));
    let rims = rims.as_ref();
    let glints = GlintRays { frame: &frame, filter, rims, settings, iteration };
    let pixels = (0..settings.height).flat_map(|y| (0..settings.width).map(move |x| (x, y)));
    let sample = |(x, y)| {
        let mut numbers = CameraNumbers::new(settings, iteration, x, y).at_rim(glints.is_rim(x, y));
        let ray = camera_ray(&frame, filter, x, y, &numbers);
        let sample = trace(still, ray, settings.max_depth, &mut numbers, &mut stats);
        let visible = sample.visible.map(|v| (v.point, v.normal, v.sphere, v.beta));
        let lamps = sample.glints.map(|own| glints.mean(still, (x, y), own, &mut stats.camera_segments));
        CameraSample { direct: lamps.map_or(sample.direct, |lamps| sample.direct + lamps), visible }
    };
    (pixels.map(sample).collect(), stats)
}

#[test]
fn camera_passes() {
    check(150, "the camera pass", &(case(1..=20), 0..5_u32), |(Case { scene, settings, .. }, iteration)| {
        let still = scene.at(scene.camera.shutter_time(settings.seed, iteration));
        let (expected, stats) = samples(&scene, &still, &settings, iteration);
        for lanes in lane_kinds() {
            let (actual, segments, visible_points) = camera_pass(&scene, &still, &settings, iteration, lanes);
            prop_assert_eq!(actual.len(), expected.len());
            for (pixel, (a, e)) in actual.iter().zip(&expected).enumerate() {
                let what = (lanes, pixel, e);
                assert_same_vector(a.direct, e.direct, &what);
                prop_assert_eq!(a.visible.map(|v| v.2), e.visible.map(|v| v.2), "{:?}", what);
                if let (Some(a), Some(e)) = (a.visible, e.visible) {
                    assert_same_vector(a.0, e.0, &what);
                    assert_same_vector(a.1, e.1, &what);
                    assert_same_vector(a.3, e.3, &what);
                }
            }
            prop_assert_eq!(segments, stats.camera_segments);
            prop_assert_eq!(visible_points, stats.visible_points);
        }
        Ok(())
    });
}

#[test]
fn pixels_have_slots_of_their_own() {
    for (width, height) in [(1, 1), (8, 8), (9, 7), (17, 33)] {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let mut slots: Vec<usize> = pixels.map(|(x, y)| pixel_slot(width, x, y)).collect();
        slots.sort_unstable();
        slots.dedup();
        assert_eq!(slots.len(), (width * height) as usize);
        assert!(slots[slots.len() - 1] < (width.div_ceil(8) * height.div_ceil(8) * 64) as usize);
    }
}

/// The bits of a deposit, which identify it.
fn bits(deposit: &Deposit) -> [u32; 11] {
    let (p, wi) = (deposit.point.to_array(), deposit.wi.to_array());
    let [px, py, pz] = p.map(f32::to_bits);
    let [wx, wy, wz] = wi.map(f32::to_bits);
    let Flux { units: [r, g, b], shift } = deposit.flux;
    [px, py, pz, wx, wy, wz, deposit.sphere, r, g, b, shift]
}

fn as_deposit(photon: &Photon) -> Deposit {
    let Photon { point, wi, sphere, flux, shift, .. } = *photon;
    Deposit { point, wi, sphere, flux: Flux { units: flux, shift } }
}

/// Expects every photon that the engine keeps to be one of the reference's; returns the reference's photons that it
/// drops.
fn dropped(run: &PhotonRun, deposits: &[Deposit]) -> Result<Vec<Deposit>, TestCaseError> {
    let mut left: HashMap<[u32; 11], Vec<Deposit>> = HashMap::new();
    for deposit in deposits {
        left.entry(bits(deposit)).or_default().push(*deposit);
    }
    for (photon, _) in &run.photons {
        let one = left.get_mut(&bits(&as_deposit(photon))).and_then(Vec::pop);
        prop_assert!(one.is_some(), "{:?} is none of the reference's deposits", photon);
    }
    Ok(left.into_values().flatten().collect())
}

/// An occupancy map that contains all deposits.
fn all_of(deposits: &[Deposit], size: f32) -> Occupancy {
    let mut wanted = Occupancy::new(size);
    for deposit in deposits {
        wanted.mark(LaneKind::best(), Query { low: deposit.point, high: deposit.point, reach: size * 1e-3 });
    }
    wanted
}

/// An occupancy map of everything within reach of the visible points.
fn what_is_seen(visible: &[VisiblePoint], radius: f32) -> Occupancy {
    let mut wanted = Occupancy::new(radius * 2.0);
    for v in visible {
        let reach = radius * (1.0 + 1.0 / 1_048_576.0);
        assert!(wanted.mark(LaneKind::best(), Query { low: v.point, high: v.point, reach }));
    }
    wanted
}

/// Balls at some visible points, and around all; with equal shares. None if `count` is 0.
fn aim_at(
    still: &Still,
    visible: &[VisiblePoint],
    settings: &Settings,
    (count, size, height): (usize, f32, f32),
) -> Aim {
    let near = visible.iter().cycle().step_by(7).take(if visible.is_empty() { 0 } else { count });
    let ball = |(k, v): (usize, &VisiblePoint)| Target {
        axis: -v.normal,
        height,
        ..Target::ball(v.point, size * (k + 1) as f32)
    };
    let balls: Vec<Target> = near.enumerate().map(ball).collect();
    let shares =
        if balls.is_empty() { Vec::new() } else { vec![1.0 / (balls.len() + 1) as f64; balls.len() + 1] };
    let middle = balls.len() / 2;
    Aim::new(
        still,
        &Targets { balls, middle, shares, expected: 0.0, guide: None },
        settings.photons_per_iteration,
    )
}

/// A guide that knows nothing of the scene: parts of this size around the visible points, and tables that all differ.
fn guide_anywhere(visible: &[VisiblePoint], size: f32, seed: u32, photons: u32) -> Aim {
    let shares = |number: u32| {
        let mut stream = StreamKey::new(seed.into(), Family::Path, number).stream(0);
        let values: Shares =
            std::array::from_fn(|_| std::array::from_fn(|_| f64::from(stream.next_f32()).powi(4)));
        let sum: f64 = values.iter().flatten().sum();
        values.map(|row| row.map(|value| value / sum))
    };
    let low = visible.first().map_or(Vec3::ZERO, |v| v.point - Vec3::splat(1.5 * size));
    let guide = Guide::of_shares(low, 1.0 / size, (0..SURFACES).map(shares), &shares(SURFACES));
    let departures = Departures::new(&guide.departures, photons);
    Aim { guide: Some(Arc::new(guide)), departures, ..Aim::default() }
}

/// The photon pass whose photons are guided anywhere: with few of them, and with as many as are guided as they leave.
#[test]
fn guided_photon_passes() {
    let inputs = (
        case(1..=20),
        log_uniform(0.1, 100.0),
        prop_oneof![3 => 1..3000_u32, 1 => 8192..9000_u32],
        any::<u32>(),
    );
    check(100, "the guided photon pass", &inputs, |(Case { scene, settings, .. }, size, photons, seed)| {
        let still = scene.at(scene.camera.shutter_time(settings.seed, 0));
        let (samples, _) = samples(&scene, &still, &settings, 0);
        let point = |(point, normal, sphere, beta)| VisiblePoint { point, normal, sphere, beta };
        let visible: Vec<VisiblePoint> = samples.iter().filter_map(|s| s.visible).map(point).collect();
        let aim = guide_anywhere(&visible, size, seed, photons);
        let (mut stats, mut deposits) = (Stats::default(), Vec::new());
        let deposit = |deposit: &Deposit, _: &mut Stats| deposits.push(*deposit);
        reference::photon_pass::photon_pass(&still, &aim, &settings, 0, 0..photons, &mut stats, deposit);
        let radius = settings.initial_radius;
        let (cells, all) = (Cells::new(radius * 1.5, photons as usize), all_of(&deposits, radius.max(1e-3)));
        for lanes in lane_kinds() {
            let run = photon_pass((&still, &aim), &settings, 0, 0..photons, (&all, cells, radius), lanes);
            prop_assert_eq!((run.segments, run.deposits), (stats.photon_segments, stats.deposits));
            let dropped = dropped(&run, &deposits)?;
            prop_assert!(dropped.is_empty(), "{:?} is dropped", dropped);
        }
        Ok(())
    });
}

#[test]
fn photon_passes() {
    let aims = (0..4_usize, log_uniform(0.1, 100.0), prop_oneof![Just(3.0_f32), 0.01..2.0_f32]);
    let inputs = (case(1..=20), 0..5_u32, aims);
    check(200, "the photon pass", &inputs, |(Case { scene, settings, .. }, iteration, aims)| {
        let still = scene.at(scene.camera.shutter_time(settings.seed, iteration));
        let (samples, _) = samples(&scene, &still, &settings, iteration);
        let point = |(point, normal, sphere, beta)| VisiblePoint { point, normal, sphere, beta };
        let visible: Vec<VisiblePoint> = samples.iter().filter_map(|s| s.visible).map(point).collect();
        let (mut stats, mut deposits) = (Stats::default(), Vec::new());
        let all = 0..settings.photons_per_iteration;
        let aim = aim_at(&still, &visible, &settings, aims);
        let deposit = |deposit: &Deposit, _: &mut Stats| deposits.push(*deposit);
        reference::photon_pass::photon_pass(&still, &aim, &settings, iteration, all, &mut stats, deposit);
        let (radius, photons) = (settings.initial_radius, 0..settings.photons_per_iteration);
        let radius_squared = radius * radius;
        let cells = Cells::new(radius * 1.5, settings.photons_per_iteration as usize);
        let (all, seen) = (all_of(&deposits, radius.max(1e-3)), what_is_seen(&visible, radius));
        for lanes in lane_kinds() {
            for (wanted, drops) in [(&all, false), (&seen, true)] {
                let by = (wanted, cells, radius);
                let run = photon_pass((&still, &aim), &settings, iteration, photons.clone(), by, lanes);
                prop_assert_eq!((run.segments, run.deposits), (stats.photon_segments, stats.deposits));
                let dropped = dropped(&run, &deposits)?;
                prop_assert!(drops || dropped.is_empty(), "{:?} is dropped", dropped);
                for v in &visible {
                    let lost = dropped.iter().find(|d| contributes(&still, d, v, radius_squared));
                    prop_assert!(lost.is_none(), "{:?} is dropped, and counts at {:?}", lost, v);
                    for (photon, _) in run.photons.iter().filter(|(photon, _)| photon.is_safe) {
                        let d = photon.point - v.point;
                        let is_near = photon.sphere == v.sphere && d.dot(d) < radius_squared;
                        let counts = contributes(&still, &as_deposit(photon), v, radius_squared);
                        prop_assert!(counts || !is_near, "{:?} is not safe at {:?}", photon, v);
                    }
                }
            }
        }
        Ok(())
    });
}

#[test]
fn direct_light_on_any_point() {
    let number = || prop_oneof![1 => Just(0.0_f32), 1 => Just(1.0 - f32::EPSILON / 2.0), 6 => 0.0..1.0_f32];
    let numbers = prop::collection::vec((number(), number(), number()), 0..=40);
    check(300, "direct light", &(case(1..=20), numbers), |(Case { scene, settings, .. }, numbers)| {
        let still = scene.at(scene.camera.shutter_time(settings.seed, 0));
        if still.lights.entries.is_empty() {
            return Ok(());
        }
        let (samples, _) = samples(&scene, &still, &settings, 0);
        let seen: Vec<Receiver> = samples
            .iter()
            .filter_map(|sample| sample.visible)
            .map(|(point, normal, sphere, _)| Receiver { point, normal, sphere })
            .collect();
        let receivers: Vec<Receiver> = seen.iter().copied().cycle().take(numbers.len()).collect();
        let column = |k: usize| receivers.iter().zip(&numbers).map(|(_, n)| [n.0, n.1, n.2][k]).collect();
        let columns: [Vec<f32>; 3] = std::array::from_fn(column);
        let expected: Vec<Rgb> = receivers
            .iter()
            .zip(&numbers)
            .map(|(r, (choice, u, v))| {
                let Receiver { point, normal, sphere } = *r;
                let receiver = reference::light_choice::Receiver { point, normal, sphere };
                estimate_irradiance(&still, &receiver, *choice, *u, *v)
            })
            .collect();
        for lanes in lane_kinds() {
            let actual = direct_light(&still, &receivers, columns.each_ref().map(|c| &c[..]), lanes);
            prop_assert_eq!(actual.len(), expected.len());
            for (k, (a, e)) in actual.iter().zip(&expected).enumerate() {
                assert_same_vector(*a, *e, &(lanes, receivers[k], numbers[k]));
            }
        }
        Ok(())
    });
}

/// A ball of radius 1 in a glowing shell, moved from the origin by `offset` along each axis, with the eye at this distance from its
/// centre.
fn ball_in_shell(offset: f32, away: f32) -> Scene {
    let sphere = |radius, emission| Sphere {
        center: Vec3::splat(offset),
        velocity: Vec3::ZERO,
        radius,
        material: 0,
        emission: Rgb::splat(emission),
    };
    scene_of(vec![sphere(1.0, 0.0), sphere(4.0, 1.0)], Vec3::splat(offset) + Vec3::X * away)
}

/// The engine's tolerance for the rounding of a point, relative to its largest coordinate: about 8 roundings.
const ROUNDED: f64 = 1e-6;
/// Uncertainty of this test about that, because it computes in `f64` from points rounded to `f32`: about one rounding.
const ROUNDED_BY: f64 = 0.1 * ROUNDED;
/// Twice the engine's tolerance for the rounding of cosines.
const COSINES: f64 = 3e-5;

/// A photon that is marked safe must count at every visible point of its sphere within reach, even far from the origin,
/// where rounded points and their normals do not match exactly. Conversely, every photon that can be marked safe should
/// be: one whose cosine exceeds the change of normals over the reach, plus the tolerance for rounding.
#[test]
fn safe_photons_count_at_all_points_within_reach() {
    let mut cases = 0;
    // As a ball, and as a ground.
    for (away, offset) in [(3.0, 0.0_f32), (3.0, 3e3), (3.0, 1e5), (1.03, 0.0), (1.03, 3e3), (1.03, 1e5)] {
        let scene = ball_in_shell(offset, away);
        let still = scene.at(0.0);
        assert_eq!(still.grounds.len(), usize::from(away < 2.0));
        let photons = 1 << 16;
        let settings = Settings { photons_per_iteration: photons, max_depth: 4, ..scene.settings };
        // Points on the ball, found by rays.
        let mut stream = numbers(71);
        let points: Vec<Hit> = (0..4000)
            .filter_map(|_| {
                let start = inputs::direction(&mut stream);
                let aim = inputs::direction(&mut stream);
                let (origin, target) = (scene.spheres[0].center + start * 3.0, scene.spheres[0].center + aim);
                let direction = reference::sampling::unit(target - origin);
                intersect(&still, &Ray { origin, direction, leaves: NO_SPHERE }).filter(|hit| hit.sphere == 0)
            })
            .collect();
        // From the spacing of the coordinates to a large reach.
        for reach in [1e-3_f32, 0.02, 0.1, 0.4].map(|reach| reach.max(offset * f32::EPSILON)) {
            let mut wanted = Occupancy::new(20.0);
            let (low, high) = (scene.spheres[0].center - 1.0, scene.spheres[0].center + 1.0);
            assert!(wanted.mark(LaneKind::best(), Query { low, high, reach }));
            let by = (&wanted, Cells::new(reach * 1.5, 4096), reach);
            for lanes in lane_kinds() {
                let run = photon_pass((&still, &Aim::default()), &settings, 0, 0..photons, by, lanes);
                let on_ball: Vec<&Photon> = run.photons.iter().map(|(photon, _)| photon).collect();
                for photon in &on_ball {
                    let normal = (photon.point - scene.spheres[0].center).as_dvec3().normalize();
                    let spare = photon.wi.as_dvec3().dot(normal) - f64::from(reach);
                    let largest = f64::from(offset + 1.0);
                    let (least, most) =
                        ((ROUNDED - ROUNDED_BY) * largest, (ROUNDED + ROUNDED_BY) * largest + COSINES);
                    let is_decided = !(least..most).contains(&spare);
                    let expected = photon.sphere == 1 || spare >= most;
                    assert!(
                        !is_decided || photon.is_safe == expected,
                        "{lanes:?}, reach {reach}: {photon:?}"
                    );
                }
                let safe = on_ball.iter().filter(|photon| photon.is_safe && photon.sphere == 0);
                // Test an eighth of the safe photons at all points.
                let some = safe.step_by(8);
                for (photon, hit) in some.flat_map(|photon| points.iter().map(move |hit| (photon, hit))) {
                    let d = photon.point - hit.point;
                    let counts = photon.wi.dot(hit.normal) > 0.0;
                    assert!(
                        counts || d.dot(d) >= reach * reach,
                        "{lanes:?}, reach {reach}: {photon:?} at {hit:?}"
                    );
                }
                cases += points.len();
            }
        }
    }
    tell(cases, "points among safe photons");
}

/// At the point where a ball touches the lamp, the distance to the lamp's centre equals its radius, and the reference
/// computes no light.
#[test]
fn a_lamp_gives_no_light_where_it_is_touched() {
    let sphere = |x: f32, radius, emission| Sphere {
        center: Vec3::X * x,
        velocity: Vec3::ZERO,
        radius,
        material: 0,
        emission: Rgb::splat(emission),
    };
    let mut cases = 0;
    for (radius, other) in [(1.0_f32, 1.0_f32), (2.0, 0.5), (0.5, 4.0)] {
        let scene =
            scene_of(vec![sphere(0.0, radius, 1.0), sphere(radius + other, other, 0.0)], Vec3::Z * 99.0);
        let still = scene.at(0.0);
        let steps = [radius.next_down(), radius, radius.next_up(), radius * 1.01, radius * 0.99];
        let normals = [Vec3::NEG_X, Vec3::Y, Vec3::new(-0.6, 0.8, 0.0), Vec3::X];
        let receivers: Vec<Receiver> = steps
            .into_iter()
            .flat_map(|x| normals.map(|normal| Receiver { point: Vec3::X * x, normal, sphere: 1 }))
            .collect();
        for (u, v) in [(0.0, 0.0), (0.3, 0.6), (0.9, 0.2), (1.0 - f32::EPSILON, 0.5)] {
            let column = |x: f32| vec![x; receivers.len()];
            let columns = [column(0.0), column(u), column(v)];
            for lanes in lane_kinds() {
                let actual = direct_light(&still, &receivers, columns.each_ref().map(|c| &c[..]), lanes);
                for (receiver, actual) in receivers.iter().zip(actual) {
                    let Receiver { point, normal, sphere } = *receiver;
                    let as_reference = reference::light_choice::Receiver { point, normal, sphere };
                    let expected = estimate_irradiance(&still, &as_reference, 0.0, u, v);
                    assert_same_vector(actual, expected, &(lanes, receiver, u, v));
                    assert!(point.x != radius || expected == Rgb::ZERO, "{receiver:?} is lit");
                    cases += 1;
                }
            }
        }
    }
    tell(cases, "direct light where a lamp is touched");
}

/// Tracing photons in parts of the range gives the same photons as tracing them all at once.
#[test]
fn photons_in_parts_of_the_range() {
    let scene = files::builtin::scene("cornell").unwrap();
    let settings = Settings { photons_per_iteration: 1000, ..scene.settings };
    let still = scene.at(0.0);
    let run = |lanes, photons| {
        let mut wanted = Occupancy::new(100.0);
        for corner in 0..64 {
            let place = Vec3::new((corner % 4) as f32, (corner / 4 % 4) as f32, (corner / 16) as f32);
            wanted.mark(
                LaneKind::best(),
                Query { low: place * 50.0 - 100.0, high: place * 50.0 - 50.0, reach: 60.0 },
            );
        }
        let by = (&wanted, Cells::new(3.0, 1000), 2.0);
        photon_pass((&still, &Aim::default()), &settings, 3, photons, by, lanes)
    };
    for lanes in lane_kinds() {
        let whole = run(lanes, 0..1000);
        let parts = [run(lanes, 0..16), run(lanes, 16..512), run(lanes, 512..1000)];
        assert_eq!(whole.segments, parts.iter().map(|part| part.segments).sum::<u64>());
        let mut all: Vec<[u32; 11]> = parts
            .iter()
            .flat_map(|part| &part.photons)
            .map(|(photon, _)| bits(&as_deposit(photon)))
            .collect();
        let mut expected: Vec<[u32; 11]> =
            whole.photons.iter().map(|(photon, _)| bits(&as_deposit(photon))).collect();
        all.sort_unstable();
        expected.sort_unstable();
        assert!(expected.len() > 100);
        assert_eq!(all, expected, "{lanes:?}");
    }
}
