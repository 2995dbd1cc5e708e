//! Ray intersection: nearest hits and occlusion, by all three search structures.

use super::inputs::{self, scattered, scene_of};
use super::rays::{RayCase, ray_case};
use super::{assert_same, assert_same_vector, check, lane_kinds, tell};
use crate::placement::{log_uniform, point};
use fast::{Intersector, LaneKind, Met, Search};
use proptest::prelude::*;
use reference::intersect::{Hit, intersect, occluded};
use scene::ray::{NO_SPHERE, SphereId};
use scene::{Material, Ray, Rgb, Sphere, Still, Vec3};

const SEARCHES: [Search; 3] = [Search::InTurn, Search::Clusters, Search::Tree];

/// Limits and lamps of shadow rays along `rays`. Limits are at the nearest hit, just above and just below it, and
/// elsewhere. Lamps are ignored in the occlusion test.
fn shadow_rays(rays: &[Ray], hits: &[Option<Hit>]) -> (Vec<f32>, Vec<SphereId>) {
    let limit = |(k, hit): (usize, &Option<Hit>)| {
        let t = hit.map_or(1.0, |hit| hit.t);
        [t, t.next_up(), t.next_down(), f32::INFINITY, 0.0, -0.0, t * 2.0, t + 1e4, -1.0][k % 9]
    };
    let lamp = |(k, hit): (usize, &Option<Hit>)| {
        let id = hit.map_or(0, |hit| hit.sphere);
        [NO_SPHERE, id, id.saturating_sub(1)][k / 9 % 3]
    };
    assert_eq!(rays.len(), hits.len());
    (hits.iter().enumerate().map(limit).collect(), hits.iter().enumerate().map(lamp).collect())
}

fn of_material(material: &Material) -> (Rgb, f32, u32) {
    match *material {
        Material::Diffuse { albedo } => (albedo, 1.0, 0),
        Material::Specular { albedo } => (albedo, 1.0, 1),
        Material::Dielectric { albedo, ior } => (albedo, ior, 2),
    }
}

/// Expects the hit and its material to be the reference's.
fn assert_met(
    still: &Still,
    actual: Option<Met>,
    expected: Option<Hit>,
    ray: &Ray,
    what: (LaneKind, Search),
) {
    let what = (what, ray, expected);
    assert_eq!(actual.map(|met| met.sphere), expected.map(|hit| hit.sphere), "{what:?}");
    if let (Some(met), Some(hit)) = (actual, expected) {
        assert_same(&[met.t], &[hit.t], &what);
        assert_same_vector(met.point, hit.point, &what);
        assert_same_vector(met.normal, hit.normal, &what);
        assert_eq!(met.inside, hit.inside, "{what:?}");
        let (albedo, ior, kind) = of_material(still.material(hit.sphere));
        assert_eq!((met.albedo, met.ior, met.kind), (albedo, ior, kind), "{what:?}");
    }
}

/// Expects all searches on all lanes to find the reference's hits, whether or not rays are said to be close; returns the number of rays that hit.
fn compare(still: &Still, rays: &[Ray], searches: &[Search]) -> usize {
    let expected: Vec<Option<Hit>> = rays.iter().map(|ray| intersect(still, ray)).collect();
    let (limits, lamps) = shadow_rays(rays, &expected);
    let blocked: Vec<bool> = rays
        .iter()
        .zip(limits.iter().zip(&lamps))
        .map(|(ray, (limit, lamp))| occluded(still, ray, *limit, *lamp))
        .collect();
    for (search, are_close) in searches.iter().flat_map(|search| [(search, false), (search, true)]) {
        for lanes in lane_kinds() {
            let intersector = Intersector::with_search(still, lanes, *search);
            let intersector = if are_close { intersector.of_close_rays() } else { intersector };
            let nearest = intersector.nearest(rays);
            let surfaces = intersector.surfaces(rays);
            let actual = intersector.occluded(rays, &limits, &lamps);
            assert_eq!((nearest.len(), surfaces.len(), actual.len()), (rays.len(), rays.len(), rays.len()));
            for (k, ray) in rays.iter().enumerate() {
                let (t, sphere) = expected[k].map_or((f32::INFINITY, NO_SPHERE), |hit| (hit.t, hit.sphere));
                assert_eq!(nearest[k].1, sphere, "{lanes:?} {search:?} {are_close} {ray:?} hits at {t}");
                assert_same(&[nearest[k].0], &[t], &(lanes, search, ray));
                assert_met(still, surfaces[k], expected[k], ray, (lanes, *search));
                assert_eq!(
                    actual[k], blocked[k],
                    "{lanes:?} {search:?} {ray:?} up to {} past {}",
                    limits[k], lamps[k]
                );
            }
        }
    }
    expected.iter().flatten().count()
}

fn check_cases(cases: u32, what: &str, strategy: &impl Strategy<Value = RayCase>) {
    check(cases, what, strategy, |case| {
        compare(&case.scene.at(0.0), &case.rays, &SEARCHES);
        Ok(())
    });
}

#[test]
fn few_spheres_and_every_tail_of_rays() {
    check_cases(1500, "rays against few spheres", &ray_case(1..=6, 0..=31));
}

#[test]
fn some_spheres() {
    check_cases(400, "rays against some spheres", &ray_case(7..=40, 0..=70));
}

#[test]
fn many_spheres_and_more_than_a_batch_of_rays() {
    check_cases(60, "rays against many spheres", &ray_case(41..=150, 200..=300));
}

/// Eight balls in one place, far from the origin in any octant and smaller than the rounding of a ray's distance from it;
/// one ball near the origin. Rays start near it and pass the place so closely that only rounding decides.
fn far_and_small() -> impl Strategy<Value = RayCase> {
    let ray = (point(1.0), point(1.0), 0.0..8.0_f32);
    let place = (prop::array::uniform3(prop_oneof![-1000.0..-500.0_f32, 500.0..1000.0_f32]), 0..3_u32);
    (place, prop::collection::vec(ray, 100..200)).prop_map(|((far, kind), rays)| {
        const RADIUS: f32 = 1e-5;
        let far = Vec3::from_array(far);
        let ball = |center, radius| Sphere {
            center,
            velocity: Vec3::ZERO,
            radius,
            material: kind,
            emission: Rgb::ZERO,
        };
        let spheres = [vec![ball(far, RADIUS); 8], vec![ball(Vec3::splat(0.5), 0.1)]].concat();
        let aim = |(origin, twist, radii): (Vec3, Vec3, f32)| {
            let sideways = (far - origin).cross(twist).normalize_or(Vec3::Y);
            let direction = (far + sideways * (radii * RADIUS) - origin).normalize();
            Ray { origin, direction, leaves: NO_SPHERE }
        };
        RayCase { scene: scene_of(spheres, Vec3::ZERO), rays: rays.into_iter().map(aim).collect() }
    })
}

#[test]
fn small_balls_far_away_on_every_side() {
    check_cases(100, "rays past small balls far away", &far_and_small());
}

/// A batch of rays from about the same place past a ball, on every side and so closely that rounding decides, among others of every
/// size.
fn bundles() -> impl Strategy<Value = RayCase> {
    let balls = prop::collection::vec((point(1.0), log_uniform(0.01, 0.25), 0..3_u32), 2..60);
    let ray = (point(1.0), point(1.0), prop_oneof![Just(1.0_f32), 0.0..2.0_f32]);
    // A ray by itself has the narrowest shaft.
    let rays = prop_oneof![
        3 => prop::collection::vec(ray.clone(), 1..4),
        1 => prop::collection::vec(ray, 256),
    ];
    let bundle = (point(2.0), log_uniform(1e-6, 0.25), rays);
    (balls, bundle, log_uniform(1e-3, 1e3)).prop_map(|(balls, (place, spread, rays), scale)| {
        let sphere = |(center, radius, material): (Vec3, f32, u32)| Sphere {
            center: center * scale,
            velocity: Vec3::ZERO,
            radius: radius * scale,
            material,
            emission: Rgb::ZERO,
        };
        let spheres: Vec<Sphere> = balls.into_iter().map(sphere).collect();
        let Sphere { center, radius, .. } = spheres[0];
        let aim = |(off, twist, radii): (Vec3, Vec3, f32)| {
            let origin = (place + off * spread) * scale;
            let sideways = (center - origin).cross(twist).normalize_or(Vec3::Y);
            // How far to the side of the centre a tangent passes.
            let slope = (radius / center.distance(origin)).min(0.9);
            let tangent = radius / (1.0 - slope * slope).sqrt();
            let direction = (center + sideways * (radii * tangent) - origin).normalize_or(Vec3::X);
            Ray { origin, direction, leaves: NO_SPHERE }
        };
        let eye = Vec3::splat(1e3 * scale);
        RayCase { rays: rays.into_iter().map(aim).collect(), scene: scene_of(spheres, eye) }
    })
}

#[test]
fn rays_that_run_close_together() {
    check_cases(2000, "rays close together", &bundles());
}

/// A batch of rays from about the same place to about the same place, within walls of every size, among some balls. Some leave a
/// wall, or the place that they go to is on one or on an edge of the room.
fn bundles_within_walls() -> impl Strategy<Value = RayCase> {
    // Where a wall is nearest to the eye, how far off, and how large it is, over that.
    let wall = (
        point(1.0),
        log_uniform(0.05, 2.0),
        prop_oneof![3 => log_uniform(1.1, 1e5), 1 => log_uniform(1e5, 1e8)],
    );
    let balls = prop::collection::vec((point(0.6), log_uniform(0.01, 0.25), 0..3_u32), 1..6);
    let rays = prop_oneof![1 => prop::collection::vec((point(1.0), point(1.0)), 1..4),
        1 => prop::collection::vec((point(1.0), point(1.0)), 256)];
    let spreads = (log_uniform(1e-6, 0.5), log_uniform(1e-6, 0.5));
    let bundle = (point(0.5), point(3.0), spreads, rays, 0..6_u32);
    (prop::collection::vec(wall, 1..20), balls, bundle, log_uniform(1e-3, 1e3)).prop_map(
        |(walls, balls, (from, to, (spread, apart), rays, kind), scale)| {
            let sphere = |center: Vec3, radius: f32, material| Sphere {
                center: center * scale,
                velocity: Vec3::ZERO,
                radius: radius * scale,
                material,
                emission: Rgb::ZERO,
            };
            let outwards: Vec<Vec3> = walls.iter().map(|(way, ..)| way.normalize_or(Vec3::X)).collect();
            let wall = |(out, (_, off, size)): (&Vec3, &(Vec3, f32, f32))| {
                sphere(*out * (off - off * size), off * size, 0)
            };
            let mut spheres: Vec<Sphere> = outwards.iter().zip(&walls).map(wall).collect();
            spheres.extend(balls.into_iter().map(|(center, radius, kind)| sphere(center, radius, kind)));
            let first = spheres[0];
            let on_wall = outwards[0] * walls[0].1;
            let last = walls.len() - 1;
            let (from, to, leaves) = match kind {
                0 => (on_wall, to, 0),
                1 => (from, on_wall, NO_SPHERE),
                // About where two walls meet, if both are flat.
                2 => (from, on_wall + outwards[last] * walls[last].1, NO_SPHERE),
                _ => (from, to, NO_SPHERE),
            };
            let aim = |(a, b): (Vec3, Vec3)| {
                let near = (from + a * spread) * scale;
                let outward = (near - first.center).normalize_or(Vec3::X);
                let origin = if leaves == 0 { first.center + outward * first.radius } else { near };
                let direction = ((to + b * apart) * scale - origin).normalize_or(Vec3::X);
                Ray { origin, direction, leaves }
            };
            RayCase { rays: rays.into_iter().map(aim).collect(), scene: scene_of(spheres, Vec3::ZERO) }
        },
    )
}

#[test]
fn rays_that_run_close_together_within_walls() {
    check_cases(2000, "rays close together within walls", &bundles_within_walls());
}

const RAYS: usize = 400;

/// Numbers of spheres around those at which a leaf, a node, a level or the top of the tree is full, and at which several
/// threads build.
#[test]
fn hierarchies_of_every_shape() {
    let sizes = [
        1, 2, 7, 8, 9, 15, 16, 17, 63, 64, 65, 72, 100, 255, 256, 257, 511, 512, 513, 520, 1500, 2047, 2048,
        2049, 4095, 4096, 4097, 16_384, 16_385, 20_000,
    ];
    let mut cases = 0;
    for (index, count) in sizes.into_iter().enumerate() {
        let (spheres, rays) = scattered(count, 1, RAYS, 300 + 2 * index as u32);
        let scene = scene_of(spheres, Vec3::splat(1e3));
        let searches = if count > 2000 { &SEARCHES[2..] } else { &SEARCHES[..] };
        let hits = compare(&scene.at(0.0), &rays, searches);
        assert!(count < 100 || hits > 100, "{hits} hits on {count} spheres put nothing to the test");
        cases += rays.len() * searches.len();
    }
    tell(cases, "rays against 1 to 20 000 spheres");
}

/// Beyond 131 072 balls a tree has three levels of nodes. Balls stand at whole places, and rays leave the middle between two of
/// them towards either.
#[test]
fn a_tree_of_three_levels() {
    const SIDE: u32 = 52;
    let ball = |k: u32| Sphere {
        center: Vec3::from([k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE].map(|c| c as f32)),
        velocity: Vec3::ZERO,
        radius: 0.25,
        material: 0,
        emission: Rgb::ZERO,
    };
    let scene = scene_of((0..SIDE * SIDE * SIDE).map(ball).collect(), Vec3::splat(1e3));
    let (mut rays, mut expected) = (Vec::new(), Vec::new());
    for k in 0..SIDE - 1 {
        for (axis, step) in Vec3::AXES.into_iter().enumerate() {
            let mut before = [k * 7 % SIDE, k * 11 % SIDE, k * 13 % SIDE];
            before[axis] = k;
            let mut after = before;
            after[axis] += 1;
            let origin = Vec3::from(before.map(|c| c as f32)) + 0.5 * step;
            for (direction, [x, y, z]) in [(step, after), (-step, before)] {
                rays.push(Ray { origin, direction, leaves: NO_SPHERE });
                expected.push((0.25, x + SIDE * (y + SIDE * z)));
            }
        }
    }
    let tree = Intersector::with_search(&scene.at(0.0), LaneKind::best(), Search::Tree);
    assert_eq!(tree.nearest(&rays), expected);
    tell(rays.len(), "rays between 140 608 spheres");
}

/// Balls in a row, and rays along it, which enter many boxes and hit none of the first balls; some begin within a box. So
/// stacks are high, and rays come to what is at their bottom.
#[test]
fn along_rows_of_balls() {
    let mut cases = 0;
    for (index, count) in [40, 256, 1000, 2048, 9000].into_iter().enumerate() {
        let mut stream = inputs::numbers(900 + index as u32);
        let mut symmetric = |size: f32| (stream.next_f32() * 2.0 - 1.0) * size;
        let ball = |k: usize, [y, z]: [f32; 2]| Sphere {
            center: Vec3::new(k as f32, y, z),
            velocity: Vec3::ZERO,
            radius: 0.02,
            material: 0,
            emission: Rgb::ZERO,
        };
        let spheres: Vec<Sphere> = (0..count).map(|k| ball(k, [symmetric(0.5), symmetric(0.5)])).collect();
        let mut along = |k: usize| {
            let (from, to) = (symmetric(0.5).abs() * count as f32, spheres[(k * 7919) % count].center);
            let aside = Vec3::new(0.0, symmetric(0.02), symmetric(0.02));
            let begin = [-5.0, count as f32 + 5.0, from][k % 3];
            let origin = Vec3::new(begin, symmetric(0.5), symmetric(0.5));
            Ray { origin, direction: (to + aside - origin).normalize(), leaves: NO_SPHERE }
        };
        let rays: Vec<Ray> = (0..RAYS).map(&mut along).collect();
        let scene = scene_of(spheres, Vec3::splat(1e5));
        assert!(compare(&scene.at(0.0), &rays, &SEARCHES[1..]) > RAYS / 2);
        cases += rays.len() * 2;
    }
    tell(cases, "rays along rows of balls");
}

#[test]
fn of_equal_distances_the_lower_sphere() {
    let mut cases = 0;
    for (index, (count, copies)) in
        [(4, 2), (12, 3), (40, 4), (300, 3), (1200, 2), (64, 16)].into_iter().enumerate()
    {
        let (spheres, rays) = scattered(count, copies, RAYS, 400 + 2 * index as u32);
        let scene = scene_of(spheres, Vec3::splat(1e3));
        assert!(compare(&scene.at(0.0), &rays, &SEARCHES) > 0);
        cases += rays.len() * SEARCHES.len();
    }
    tell(cases, "rays against copies of spheres");
}

/// Seen from a distance of 1000, a ball of radius 0.001 is smaller than the reference's rounding error. The reference
/// then hits it with rays that pass by, and misses it with some that do not. Bounding boxes must not cull any of these
/// hits.
#[test]
fn small_spheres_seen_from_far() {
    let mut cases = 0;
    for (index, (radius, distance)) in
        [(1e-3_f32, 1e3_f32), (1e-3, 100.0), (0.02, 1e4), (0.3, 300.0)].into_iter().enumerate()
    {
        let mut stream = inputs::numbers(700 + index as u32);
        let ball = |center| Sphere { center, velocity: Vec3::ZERO, radius, material: 0, emission: Rgb::ZERO };
        let spheres: Vec<Sphere> =
            (0..300).map(|_| ball(inputs::place(&mut stream, 300.0 * radius.max(0.1)))).collect();
        let past = |sphere: &Sphere| {
            let direction = inputs::direction(&mut stream);
            let (s, t) = reference::sampling::frame(direction);
            let (x, y) = reference::sampling::uniform_disk(stream.next_f32(), stream.next_f32());
            let aside = (s * x + t * y) * (radius * 2.0);
            Ray { origin: sphere.center + aside - direction * distance, direction, leaves: NO_SPHERE }
        };
        let rays: Vec<Ray> = spheres.iter().cycle().take(1500).map(past).collect();
        let scene = scene_of(spheres, Vec3::splat(1e5));
        assert!(compare(&scene.at(0.0), &rays, &SEARCHES) > 200);
        cases += rays.len() * SEARCHES.len();
    }
    tell(cases, "rays from far to small spheres");
}

/// Directions given by a caller may have larger rounding errors than the engine's own; bounds allow for that.
#[test]
fn directions_that_are_not_quite_of_unit_length() {
    let mut cases = 0;
    for (index, factor) in [1.0 - 1e-4, 1.0 + 1e-4, 1.0 - 1e-5, 1.0 + 1e-5_f32].into_iter().enumerate() {
        let mut stream = inputs::numbers(800 + index as u32);
        let spheres: Vec<Sphere> = (0..200)
            .map(|_| {
                let center = inputs::place(&mut stream, 30.0);
                Sphere { center, velocity: Vec3::ZERO, radius: 0.05, material: 0, emission: Rgb::ZERO }
            })
            .collect();
        let towards = |sphere: &Sphere| {
            let origin = inputs::place(&mut stream, 60.0);
            let aside = inputs::direction(&mut stream) * 0.06;
            let direction = reference::sampling::unit(sphere.center + aside - origin) * factor;
            Ray { origin, direction, leaves: NO_SPHERE }
        };
        let rays: Vec<Ray> = spheres.iter().cycle().take(1500).map(towards).collect();
        let scene = scene_of(spheres, Vec3::splat(1e5));
        assert!(compare(&scene.at(0.0), &rays, &SEARCHES) > 200);
        cases += rays.len() * SEARCHES.len();
    }
    tell(cases, "rays of directions that are too short or too long");
}

/// The engine's default search, which depends on the number of spheres, around the limits between the three.
#[test]
fn the_default_search() {
    let mut cases = 0;
    for (index, count) in [1, 11, 12, 13, 14, 1023, 1024, 1025, 1026].into_iter().enumerate() {
        let (spheres, rays) = scattered(count, 1, RAYS, 500 + 2 * index as u32);
        let scene = scene_of(spheres, Vec3::splat(1e3));
        let still = scene.at(0.0);
        let chosen = Intersector::new(&still, LaneKind::best());
        let bytes = |search| Intersector::with_search(&still, LaneKind::best(), search).bytes();
        let expected = match count {
            0..=12 => Search::InTurn,
            13..=1024 => Search::Clusters,
            _ => Search::Tree,
        };
        assert_eq!(chosen.bytes(), bytes(expected), "{count} spheres");
        let found: Vec<SphereId> = chosen.nearest(&rays).into_iter().map(|(_, sphere)| sphere).collect();
        let reference = rays.iter().map(|ray| intersect(&still, ray).map_or(NO_SPHERE, |hit| hit.sphere));
        assert!(reference.eq(found), "{count} spheres");
        cases += rays.len();
    }
    tell(cases, "rays by the search of choice");
}

/// Search structures take little memory per sphere in addition to the scene, a tree 24 bytes and a table of 32. Clusters, which the
/// renderer makes of a thousand balls at most, take more, as their balls are also tested in turn. `bytes` reports at least what they
/// must hold.
#[test]
fn memory_per_sphere() {
    // What ten million spheres take for as long as they are rendered: in the scene, a byte for the role, in the tree, a row.
    assert!(size_of::<Sphere>() + 1 + 24 + 32 <= 104);
    for count in [1000, 20_000] {
        let (spheres, _) = scattered(count, 1, RAYS, 600);
        let scene = scene_of(spheres, Vec3::splat(1e3));
        let still = scene.at(0.0);
        let tree = Intersector::with_search(&still, LaneKind::best(), Search::Tree).bytes();
        // 20 bytes in a leaf, a box for sixteen of them, and a row of 32.
        assert!((52 * count..56 * count).contains(&tree), "{tree} bytes for {count} spheres");
        let in_turn = Intersector::with_search(&still, LaneKind::best(), Search::InTurn).bytes();
        let clusters = Intersector::with_search(&still, LaneKind::best(), Search::Clusters).bytes();
        // Each sphere has a row of 32 bytes, and at least 20 bytes in a leaf.
        for bytes in [in_turn, clusters] {
            assert!(bytes >= 52 * count, "{bytes} bytes for {count} spheres");
        }
        // One of a bounding sphere with a leaf's, and what is tested in turn: a shape, and its centre and radii for shafts.
        let shape = 52 + 20;
        assert!(
            ((53 + shape) * count..(54 + shape + 1) * count).contains(&clusters),
            "{clusters} bytes for {count} spheres"
        );
        assert!((32 + shape) * count < in_turn, "{in_turn} bytes for {count} spheres");
    }
}

/// Rays that leave or hit a sphere of any size.
#[test]
fn one_sphere_of_any_size() {
    let strategy = (log_uniform(1e-3, 1e5), ray_case(1..=1, 16..=16)).prop_map(|(scale, mut case)| {
        for sphere in &mut case.scene.spheres {
            sphere.radius *= scale;
            sphere.center *= scale;
        }
        for ray in &mut case.rays {
            ray.origin *= scale;
        }
        case
    });
    check_cases(600, "rays against one sphere of any size", &strategy);
}
