//! What is chosen, and what it follows from.

use super::account::Account;
use super::method::{GLINT_SAMPLES, PATHS, Plan, most_photons, shows_lamps_again};
use super::pilot::SEEDS;
use super::*;
use rayon::ThreadPoolBuilder;
use scene::{Camera, Material, Quality, Rgb, Sphere, Vec3};

fn cornell() -> Scene {
    let scene = files::builtin::scene("cornell").unwrap();
    Scene { settings: Settings { width: 64, height: 48, ..scene.settings }, ..scene }
}

fn chosen(scene: &Scene, automatic: Automatic, lanes: LaneKind, threads: usize) -> Settings {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| choose(scene, automatic, (MethodName::Sppm, lanes), &Stop::new())).unwrap().1
}

#[test]
fn the_choice_depends_on_neither_threads_nor_lanes() {
    let scene = cornell();
    let all = Automatic::all(Quality::Good);
    let one = chosen(&scene, all, LaneKind::best(), 1);
    for lanes in LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
        for threads in [1, 2, 3] {
            assert_eq!(chosen(&scene, all, lanes, threads), one, "{lanes:?}, {threads} threads");
        }
    }
    one.validate().unwrap();
    assert!(one != scene.settings);
}

/// The noise of the render is that of the quality, within what pilots of few paths can tell.
#[test]
fn paths_are_as_many_as_their_noise_asks_for() {
    const FACTOR: f64 = 2.0;
    let mut scene = files::builtin::scene("terrace").unwrap();
    (scene.settings.width, scene.settings.height) = (96, 72);
    let automatic = Automatic { method: false, ..Automatic::all(Quality::Draft).without_photons() };
    let of = |automatic, lanes| {
        let (method, found) = choose(&scene, automatic, (MethodName::Path, lanes), &Stop::new()).unwrap();
        assert_eq!(method, MethodName::Path);
        found
    };
    let found = of(automatic, LaneKind::best());
    assert_eq!(found, of(automatic, LaneKind::Emulated));
    let own = Settings { iterations: found.iterations, max_depth: found.max_depth, ..scene.settings };
    assert_eq!(found, own, "something else is chosen");
    let stop = Stop::new();
    let pilots = Pilots::new(&scene, &found, LaneKind::best(), &stop);
    let noise = pilots.run_paths(8, found.iterations, found.max_depth).unwrap().variance(8).pixel.sqrt();
    let goal = Goal::of(Quality::Draft).noise;
    assert!((goal / FACTOR..goal * FACTOR).contains(&noise), "{noise} for {goal}: {found:?}");
    let fixed = Automatic { iterations: false, ..automatic };
    assert_eq!(of(fixed, LaneKind::best()).iterations, scene.settings.iterations);
}

/// So many as do not take much more work than the rest: few where mirrors fill the image, none where there is nothing to see in, and
/// more where little of the image shows them.
#[test]
fn rays_that_see_lamps_are_as_many_as_their_work_allows() {
    let of = |name: &str, change: fn(&mut Scene)| {
        let mut scene = files::builtin::scene(name).unwrap();
        (scene.settings.width, scene.settings.height) = (64, 48);
        change(&mut scene);
        let only = Automatic { glint_samples: true, ..Automatic::default() };
        chosen(&scene, only, LaneKind::best(), 1).glint_samples
    };
    assert_eq!([of("dusk", |_| {}), of("terrace", |_| {}), of("mirror", |_| {})], [8, 8, 4]);
    let is_smooth = |scene: &Scene, material: u32| !scene.materials[material as usize].is_diffuse();
    let matte = |scene: &mut Scene| {
        let diffuse = (0..scene.materials.len() as u32).find(|m| !is_smooth(scene, *m)).unwrap();
        scene.spheres.iter_mut().for_each(|sphere| sphere.material = diffuse);
    };
    let mut scene = cornell();
    matte(&mut scene);
    let only = Automatic { glint_samples: true, ..Automatic::default() };
    assert_eq!(chosen(&scene, only, LaneKind::best(), 1).glint_samples, 1);
    let smooth = (0..scene.materials.len() as u32).find(|m| is_smooth(&scene, *m)).unwrap();
    let dark = scene.spheres.iter_mut().filter(|sphere| !sphere.is_emitter());
    let small = dark.min_by(|a, b| a.radius.total_cmp(&b.radius)).unwrap();
    (small.radius, small.material) = (0.2 * small.radius, smooth);
    assert_eq!(chosen(&scene, only, LaneKind::best(), 1).glint_samples, GLINT_SAMPLES[0].0);
    let mut dark = cornell();
    dark.spheres.iter_mut().for_each(|sphere| sphere.emission = Rgb::ZERO);
    assert!(!shows_lamps_again(&dark) && shows_lamps_again(&cornell()));
}

/// Balls of chalk, and a mirror if there is one, on a ground under a sky and a lamp.
fn open(has_mirror: bool) -> Scene {
    let mut scene =
        Scene { settings: Settings { width: 128, height: 96, ..Settings::default() }, ..cornell() };
    scene.background = Rgb::new(0.5, 0.6, 0.8);
    scene.camera = Camera {
        eye: Vec3::new(0.0, 4.0, 12.0),
        direction: Vec3::new(0.0, -3.0, -12.0),
        vertical_fov_degrees: 36.0,
        ..scene.camera
    };
    scene.materials =
        vec![Material::Diffuse { albedo: Rgb::splat(0.7) }, Material::Specular { albedo: Rgb::splat(0.9) }];
    let sphere = |x: f32, y: f32, radius: f32, material: u32, light: f32| Sphere {
        center: Vec3::new(x, y, 0.0),
        velocity: Vec3::ZERO,
        radius,
        material,
        emission: Rgb::splat(light),
    };
    scene.spheres = [sphere(0.0, -1e4, 1e4, 0, 0.0), sphere(5.0, 8.0, 0.5, 0, 200.0)].into_iter().collect();
    for (x, material) in [(-2.5, 0), (0.0, u32::from(has_mirror)), (2.5, 0)] {
        scene.spheres.push(sphere(x, 1.0, 1.0, material, 0.0));
    }
    scene.with_sky()
}

/// In the open by paths, with photons where there may be caustics; in a closed room by photons. It is the same on all lanes,
/// with any number of threads, and the other settings are those of a render by that method.
#[test]
fn the_method_is_the_one_that_suits_the_scene() {
    for (scene, method) in
        [(open(true), MethodName::Hybrid), (open(false), MethodName::Path), (cornell(), MethodName::Sppm)]
    {
        for quality in [Quality::Draft, Quality::Good, Quality::Final] {
            let all = Automatic::all(quality);
            let found = choose(&scene, all, (MethodName::Sppm, LaneKind::best()), &Stop::new()).unwrap();
            assert_eq!(found.0, method, "{}, {quality}", scene.name);
            let stated = Automatic { method: false, ..all };
            let stated = if method.has_photons() { stated } else { stated.without_photons() };
            let same = choose(&scene, stated, (method, LaneKind::Emulated), &Stop::new()).unwrap();
            assert_eq!(same, found, "{quality}");
        }
    }
}

/// By a little less noise paths do not win, as pilots are not that sure: among `surgery`'s lamps they promise less.
#[test]
fn paths_must_promise_far_less_noise() {
    let mut scene = files::builtin::scene("surgery").unwrap();
    (scene.settings.width, scene.settings.height) = (256, 192);
    let (goal, all, stop) = (Goal::of(Quality::Good), Automatic::all(Quality::Good), Stop::new());
    let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
    let noise = |method| {
        Plan::new(&pilots.by(method), &scene.settings, all).unwrap().least_noise(&scene.settings, &goal)
    };
    let share = noise(MethodName::Hybrid) / noise(MethodName::Sppm);
    assert!((method::LEAST_ADVANTAGE..1.0).contains(&share), "{share}");
    assert_eq!(
        plan(&pilots, &scene.settings, (all, MethodName::Sppm), &goal).unwrap().method,
        MethodName::Sppm
    );
}

#[test]
fn only_what_is_automatic_is_chosen() {
    let scene = cornell();
    let none = Automatic::default();
    for one in [
        Automatic { iterations: true, ..none },
        Automatic { photons_per_iteration: true, ..none },
        Automatic { max_depth: true, ..none },
        Automatic { initial_radius: true, ..none },
        Automatic { radius_pilots: true, ..none },
        Automatic { radius_clearance: true, ..none },
        Automatic { glint_samples: true, ..none },
    ] {
        let (found, own) = (chosen(&scene, one, LaneKind::best(), 1), scene.settings);
        assert_eq!(found.iterations == own.iterations, !one.iterations, "{found:?}");
        assert_eq!(
            found.photons_per_iteration == own.photons_per_iteration,
            !one.photons_per_iteration,
            "{found:?}"
        );
        assert_eq!(found.max_depth == own.max_depth, !one.max_depth, "{found:?}");
        assert_eq!(found.initial_radius == own.initial_radius, !one.initial_radius, "{found:?}");
        assert_eq!(found.radius_pilots == own.radius_pilots, !one.radius_pilots, "{found:?}");
        assert_eq!(found.radius_clearance == own.radius_clearance, !one.radius_clearance, "{found:?}");
        assert_eq!(found.glint_samples == own.glint_samples, !one.glint_samples, "{found:?}");
    }
}

#[test]
fn a_pilot_has_an_iteration_for_so_many_of_the_render() {
    let one = Automatic { radius_pilots: true, ..Automatic::default() };
    for (iterations, pilots) in [(1, 1), (64, 1), (128, 2), (250, 3), (256, 4), (100_000, 4)] {
        let mut scene = cornell();
        scene.settings.iterations = iterations;
        assert_eq!(chosen(&scene, one, LaneKind::best(), 1).radius_pilots, pilots, "{iterations} iterations");
    }
}

/// By clearance in renders that are too short for a pilot, and by one of both alone, unless both are given.
#[test]
fn first_radii_are_by_clearance_or_by_pilots() {
    let none = Automatic::default();
    let [pilots, clearance] =
        [Automatic { radius_pilots: true, ..none }, Automatic { radius_clearance: true, ..none }];
    let both = Automatic { radius_pilots: true, radius_clearance: true, ..none };
    let own =
        |radius_pilots, radius_clearance| Settings { radius_pilots, radius_clearance, ..Settings::default() };
    for (automatic, iterations, given, expected) in [
        (both, 63, (0, 0.0), (0, CLEARANCE)),
        (both, 64, (9, 9.0), (1, 0.0)),
        (both, 1 << 30, (0, 0.0), (4, 0.0)),
        (pilots, 63, (9, 0.0), (1, 0.0)),
        (pilots, 500, (9, 2.0), (0, 2.0)),
        (clearance, 500, (0, 0.0), (0, CLEARANCE)),
        (clearance, 6, (2, 5.0), (2, 0.0)),
        (none, 6, (2, 5.0), (2, 5.0)),
    ] {
        let mut settings = Settings { iterations, ..own(given.0, given.1) };
        choose_first_radii(&mut settings, automatic);
        let found = (settings.radius_pilots, settings.radius_clearance);
        assert_eq!(found, expected, "{iterations} iterations, {automatic:?}, given {given:?}");
    }
}

/// A block shows the same part of the picture, whatever its size.
#[test]
fn blocks_are_to_the_image_as_those_of_the_pilot_are_to_it() {
    let (scene, stop) = (cornell(), Stop::new());
    let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
    let Settings { width, height, .. } = pilots.settings;
    assert_eq!(pilots.block(&pilots.settings), BLOCK as usize);
    for (times, block) in [(2, 4), (3, 3), (8, 1), (100, 1)] {
        let larger = Settings { width: width * times, height: height * times, ..scene.settings };
        assert_eq!(pilots.block(&larger), block, "{times} times");
    }
}

/// What is chosen follows from the scene, and not from what the scene has in its place.
#[test]
fn what_is_chosen_does_not_depend_on_what_stands_there() {
    let scene = cornell();
    let all = Automatic::all(Quality::Draft);
    let expected = chosen(&scene, all, LaneKind::best(), 1);
    let own = Settings {
        iterations: 77,
        photons_per_iteration: 1_000_000,
        max_depth: 2,
        initial_radius: 0.01,
        radius_pilots: 3,
        ..scene.settings
    };
    let found = chosen(&Scene { settings: own, ..scene }, all, LaneKind::best(), 1);
    assert_eq!(found, expected);
}

/// Where pixels have radii of their own, most of which are narrower than the largest.
#[test]
fn photons_are_chosen_for_the_radius_that_most_pixels_take() {
    let scene = cornell();
    let of = |initial_radius: f32, are_own: bool| {
        let settings = Settings { initial_radius, radius_pilots: 0, ..scene.settings };
        let automatic = Automatic {
            initial_radius: false,
            radius_pilots: are_own,
            radius_clearance: are_own,
            ..Automatic::all(Quality::Good)
        };
        chosen(&Scene { settings, ..scene.clone() }, automatic, LaneKind::best(), 1)
    };
    let (own, even) = (of(8.0, true), of(8.0 * TYPICAL_SHARE, false));
    assert!(own.radius_pilots > 0 && even.radius_pilots == 0);
    assert_eq!((own.iterations, own.photons_per_iteration), (even.iterations, even.photons_per_iteration));
    assert_ne!(own.iterations, of(8.0, false).iterations, "the radius is of no account here");
}

/// The scene, the engines of the largest pilot, all images that are held at once, and the terms of a variance of one image.
#[test]
fn bytes_are_those_of_the_largest_pilot_and_of_its_images() {
    /// In memory an image may be padded to so many bytes per pixel.
    const PADDED: u64 = 16;
    for (width, height, threads) in [(64, 48, 1), (1024, 768, 3)] {
        let mut scene = cornell();
        (scene.settings.width, scene.settings.height) = (width, height);
        let pilot = large_pilot_settings(&scene.settings);
        let largest =
            Settings { photons_per_iteration: pilot.photons_per_iteration * 8, max_depth: 64, ..pilot };
        let (spheres, parameters) = (scene.spheres.len(), Parameters::default());
        let engine = |settings: &Settings| {
            Sppm::bytes_at_most(settings, spheres, threads, DEPOSITS_OF_PILOTS, &parameters)
                + PathTracer::bytes_at_most(settings, spheres, threads)
        };
        let of_scene = bytes_of_scene(&scene) + lamps(&scene) * KEPT_PER_LAMP;
        let images = bytes_at_most(&scene, threads) - engine(&largest) - of_scene;
        let pixels = pilot.pixels() as u64;
        let terms = size_of::<[f64; 3]>() as u64;
        assert!(PADDED >= size_of::<Rgb>() as u64);
        assert_eq!(images, (PADDED * bias::FILMS + terms) * pixels, "{pixels} pixels");
        // What makes it the largest.
        assert!(engine(&largest) > engine(&Settings { max_depth: 16, ..largest }));
        let fewer = Settings { photons_per_iteration: pilot.photons_per_iteration * 4, ..largest };
        assert!(engine(&largest) > engine(&fewer));
    }
}

/// Scenes of many lamps are small in pixels, and large in what is found out about their light.
#[test]
fn bytes_grow_with_spheres_and_lamps() {
    let base = cornell();
    let more = |is_lamp: bool| {
        let mut scene = base.clone();
        let sphere = *scene.spheres.iter().find(|sphere| sphere.is_emitter() == is_lamp).unwrap();
        scene.spheres.push(sphere);
        let of_engine = |scene: &Scene| {
            let pilot = large_pilot_settings(&scene.settings);
            let spheres = scene.spheres.len();
            Sppm::bytes_at_most(&pilot, spheres, 1, DEPOSITS_OF_PILOTS, &Parameters::default())
                + PathTracer::bytes_at_most(&pilot, spheres, 1)
        };
        let more = bytes_at_most(&scene, 1) - bytes_at_most(&base, 1);
        more - (of_engine(&scene) - of_engine(&base))
    };
    let sphere = bytes_of_scene(&base) - {
        let mut fewer = base.clone();
        let dark = fewer.spheres.iter().position(|sphere| !sphere.is_emitter()).unwrap();
        fewer.spheres.remove(dark);
        bytes_of_scene(&fewer)
    };
    assert_eq!(more(false), sphere);
    assert!(more(true) >= sphere + size_of::<scene::still::Light>() as u64 + KEPT_PER_LAMP);
}

#[test]
fn photons_are_as_many_as_their_depth_allows() {
    for depth in [1, 8, 16, 64, 1000] {
        let most = most_photons(depth);
        let is_valid = |photons: u32| {
            let settings =
                Settings { photons_per_iteration: photons, max_depth: depth, ..Settings::default() };
            settings.validate().is_ok()
        };
        assert!(is_valid(most) && !is_valid(most + 1), "{most} at depth {depth}");
    }
}

/// Within the digits that radii are rounded to.
#[test]
fn global_radii_begin_smaller() {
    let scene = cornell();
    let one = Automatic { initial_radius: true, ..Automatic::default() };
    let of = |radius_schedule| {
        let settings = Settings { radius_schedule, ..scene.settings };
        let scene = Scene { settings, ..scene.clone() };
        chosen(&scene, one, LaneKind::best(), 1).initial_radius
    };
    let [per_pixel, global] = RadiusSchedule::ALL.map(of);
    let share = global / per_pixel;
    assert!((share.powi(2) - 2.0 / 3.0).abs() < 0.02, "{share}");
}

/// However small or large the scene: what is chosen is a radius that a render takes, also if pilots or clearance narrow it.
#[test]
fn radii_that_are_chosen_are_within_their_bounds() {
    for schedule in RadiusSchedule::ALL {
        for size in [f32::MIN_POSITIVE, 1e-30, 1e-15, 1.0, 1e15, 1e30, f32::MAX, f32::INFINITY] {
            let initial_radius = first_radius(size, schedule);
            let settings = Settings { initial_radius, radius_schedule: schedule, ..Settings::default() };
            settings.validate().unwrap();
            if schedule == RadiusSchedule::PerPixel {
                Settings { radius_pilots: 1, ..settings }.validate().unwrap();
                Settings { radius_clearance: CLEARANCE, ..settings }.validate().unwrap();
            }
        }
    }
}

/// Where nothing is smooth there are no caustics, so photons tell path tracing with photons for caustics nothing, however many
/// there are; photon mapping has all light from them.
#[test]
fn photons_are_chosen_by_the_method_that_takes_them() {
    let mut scene = cornell();
    let diffuse = scene.materials.len() as u32;
    scene.materials.push(Material::Diffuse { albedo: Rgb::splat(0.5) });
    scene.spheres.iter_mut().for_each(|sphere| sphere.material = diffuse);
    (scene.settings.width, scene.settings.height) = (256, 192);
    let automatic =
        Automatic { quality: Quality::Final, photons_per_iteration: true, ..Automatic::default() };
    let [photons, hybrid] = [MethodName::Sppm, MethodName::Hybrid].map(|method| {
        let chosen = choose(&scene, automatic, (method, LaneKind::best()), &Stop::new());
        chosen.unwrap().1.photons_per_iteration
    });
    // The fewest that are chosen at all.
    assert!(hybrid == 4096 && photons > hybrid, "{photons} and {hybrid} photons");
}

/// As docs/quality.md has it.
#[test]
fn a_quality_is_a_noise_a_loss_of_light_and_a_radius() {
    let goals = [Quality::Draft, Quality::Good, Quality::Paper, Quality::Final].map(Goal::of);
    assert_eq!(goals.each_ref().map(|goal| goal.noise), [0.08, 0.02, 0.02, 0.007]);
    assert_eq!(goals.each_ref().map(|goal| goal.loss), [0.02, 0.005, 0.005, 0.002]);
    assert_eq!(goals.each_ref().map(|goal| goal.radius), [6.5, 4.8, 4.8, 3.6]);
    // About 0.3, 4 and 100 s of CPU time.
    assert_eq!(goals.each_ref().map(|goal| goal.work), [2e7, 2e8, 2e8, 5e9]);
}

/// In footprints of a pixel: what the iterations of each quality take, if one radius is for all; another if they end by
/// time or by their error; and the largest of radii of their own.
#[test]
fn a_first_radius_is_so_many_footprints() {
    let mut scene = cornell();
    (scene.settings.width, scene.settings.height) = (16, 12);
    let side = footprint(LaneKind::best(), &scene, &scene.settings).unwrap();
    let of = |quality, iterations, radius_pilots| {
        let radius = Automatic { quality, initial_radius: true, ..Automatic::default() };
        let automatic = Automatic { iterations, radius_pilots, ..radius };
        chosen(&scene, automatic, LaneKind::best(), 1).initial_radius
    };
    for (found, footprints) in [
        (of(Quality::Draft, true, false), 6.5),
        (of(Quality::Good, true, false), 4.8),
        (of(Quality::Draft, false, false), 4.0),
        (of(Quality::Good, false, false), 4.0),
        (of(Quality::Draft, false, true), 12.0),
        (of(Quality::Good, false, true), 12.0),
    ] {
        assert_eq!(found, rounded(footprints * side), "{footprints}");
    }
}

#[test]
fn better_pictures_take_more_iterations() {
    let scene = cornell();
    let of = |quality| chosen(&scene, Automatic::all(quality), LaneKind::best(), 1);
    let [draft, good, last] = [Quality::Draft, Quality::Good, Quality::Final].map(of);
    assert!(draft.iterations < good.iterations && good.iterations < last.iterations);
    assert!(draft.max_depth <= good.max_depth && good.max_depth <= last.max_depth);
    assert!(draft.radius_pilots == 0 && draft.radius_clearance > 0.0);
    assert!(last.radius_pilots > 0 && last.radius_clearance == 0.0);
    assert_eq!(draft.initial_radius, last.initial_radius);
}

/// With the same radius for all pixels it is narrower than the largest of their own, and the narrower, the better the
/// picture.
#[test]
fn one_radius_for_all_follows_the_quality() {
    let scene = cornell();
    let own = chosen(&scene, Automatic::all(Quality::Good), LaneKind::best(), 1);
    let settings = Settings { radius_schedule: RadiusSchedule::Global, ..scene.settings };
    let scene = Scene { settings, ..scene };
    let of = |quality| chosen(&scene, Automatic::all(quality), LaneKind::best(), 1);
    let [draft, good, last] = [Quality::Draft, Quality::Good, Quality::Final].map(of);
    assert!([draft, good, last].iter().all(|s| (s.radius_pilots, s.radius_clearance) == (0, 0.0)));
    assert!(draft.initial_radius > good.initial_radius && good.initial_radius > last.initial_radius);
    assert!(own.initial_radius > draft.initial_radius);
}

#[test]
fn a_stopped_choice_gives_nothing() {
    let stop = Stop::new();
    stop.request();
    for method in MethodName::ALL {
        assert_eq!(
            choose(&cornell(), Automatic::all(Quality::Good), (method, LaneKind::best()), &stop),
            None
        );
    }
}

#[test]
fn radii_have_two_digits() {
    assert_eq!(rounded(1.2345), 1.2);
    assert_eq!(rounded(0.009_87), 0.0099);
    assert_eq!(rounded(98_765.0), 99_000.0);
}

/// No picture is too small, and nothing that is seen may be missing.
#[test]
fn tiny_pictures_and_empty_views_have_settings_too() {
    let mut scene = cornell();
    for (width, height) in [(1, 1), (1, 300), (7, 3)] {
        (scene.settings.width, scene.settings.height) = (width, height);
        chosen(&scene, Automatic::all(Quality::Draft), LaneKind::best(), 1).validate().unwrap();
    }
}

/// Of half as many rows and columns, pixels are twice as large.
#[test]
fn radii_follow_the_size_of_pixels() {
    let one = Automatic { initial_radius: true, ..Automatic::default() };
    let of = |width, height, radius_pilots, radius_clearance| {
        let scene = cornell();
        let settings = Settings { width, height, radius_pilots, radius_clearance, ..scene.settings };
        chosen(&Scene { settings, ..scene }, one, LaneKind::best(), 1).initial_radius
    };
    let (coarse, fine) = (of(64, 48, 0, 0.0), of(128, 96, 0, 0.0));
    // Radii have two digits.
    assert!((coarse / fine - 2.0).abs() < 0.15, "{coarse}, {fine}");
    // With radii of their own, pixels have wider ones to choose from, whoever asks for them.
    let own = of(64, 48, 2, 0.0);
    assert_eq!(own, of(64, 48, 0, 0.5));
    assert!((own / coarse - LARGEST_RADIUS / RADIUS).abs() < 0.15, "{own}, {coarse}");
}

/// The least depth that loses no more than is allowed, or else the deepest.
#[test]
fn depths_are_the_least_that_are_good_enough() {
    let (scene, stop) = (cornell(), Stop::new());
    let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
    let of = |loss| pilots.depth(&Goal { loss, ..Goal::of(Quality::Good) }).unwrap();
    assert_eq!([of(f64::INFINITY), of(-1.0)], [DEPTHS[0], DEPTHS[3]]);
    let film = |depth| pilots.run(1, |settings| settings.max_depth = depth).unwrap().films.remove(0);
    let all = film(DEPTHS[3]);
    let lost = |depth| loss(&film(depth), &all, pilots.block(&pilots.settings));
    let (first, second) = (lost(DEPTHS[0]), lost(DEPTHS[1]));
    assert!(first > second && second > 0.0, "{first}, {second}");
    assert_eq!(
        [of(first), of(second), of(second * 1.01), of(second * 0.99)],
        [DEPTHS[0], DEPTHS[1], DEPTHS[1], DEPTHS[2]]
    );
}

/// One with few photons and one with four times as many tell noise and work, of which an image with four times the pixels has
/// four times as much.
#[test]
fn photons_are_those_of_two_pilots_scaled_to_the_image() {
    let mut scene = cornell();
    (scene.settings.width, scene.settings.height) = (256, 192);
    let automatic = Automatic {
        quality: Quality::Final,
        iterations: true,
        photons_per_iteration: true,
        ..Automatic::default()
    };
    let found = chosen(&scene, automatic, LaneKind::best(), 2);
    let stop = Stop::new();
    let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
    assert_eq!(scene.settings.pixels(), 4 * pilots.settings.pixels());
    let few = pilots.settings.photons_per_iteration;
    let [first, second] = [few, 4 * few]
        .map(|photons| pilots.run(SEEDS, |settings| settings.photons_per_iteration = photons).unwrap());
    let variances = [&first, &second].map(|pilot| pilot.variance(BLOCK as usize / 2));
    let account = Account::new([few, 4 * few], variances, &second.stats, 4.0);
    let account = account.of(scene.settings.pixels(), scene.spheres.len());
    let goal = Goal::of(Quality::Final);
    let photons = account.photons(most_photons(scene.settings.max_depth), goal.work);
    let iterations = account.iterations(photons, goal.noise, goal.work);
    assert_eq!((found.photons_per_iteration, found.iterations), (photons, iterations));
    // Not the least, so that they tell something.
    assert!(photons > few && iterations > 8, "{photons}, {iterations}");
}

/// Paths gather no photons, so no radius has been stated, and the usual one may be wider than the scene.
#[test]
fn the_depth_of_paths_does_not_depend_on_a_search_radius() {
    let depth = Automatic { max_depth: true, quality: Quality::Final, ..Automatic::default() };
    let of = |initial_radius| {
        let scene = cornell();
        let settings = Settings { initial_radius, ..scene.settings };
        let method = (MethodName::Path, LaneKind::best());
        choose(&Scene { settings, ..scene }, depth, method, &Stop::new()).unwrap().1
    };
    // By the first and the last no pilot would see that light is lost: none gathers a photon, or all gather the same.
    let radii = [0.01, 2.0, 1000.0];
    let found = radii.map(of);
    assert!(found.iter().all(|chosen| chosen.max_depth == 16), "{found:?}");
    assert_eq!(found.map(|chosen| chosen.initial_radius), radii);
}

/// Of an image that has four times the pixels of its pilot, by the noise and the work of each of them.
#[test]
fn iterations_of_paths_are_those_of_the_pilot_scaled_to_the_image() {
    let mut scene = files::builtin::scene("terrace").unwrap();
    (scene.settings.width, scene.settings.height) = (256, 192);
    let automatic = Automatic { quality: Quality::Draft, iterations: true, ..Automatic::default() };
    let (method, stop) = ((MethodName::Path, LaneKind::best()), Stop::new());
    let found = choose(&scene, automatic, method, &stop).unwrap().1.iterations;
    let pilots = Pilots::new(&scene, &scene.settings, LaneKind::best(), &stop);
    assert_eq!(scene.settings.pixels(), 4 * pilots.settings.pixels());
    let pilot = pilots.run_paths(SEEDS, PATHS, scene.settings.max_depth).unwrap();
    let variance = pilot.variance(BLOCK as usize / 2);
    let account = Account::of_paths(PATHS, variance, &pilot.stats, 4.0);
    let account = account.of(scene.settings.pixels(), scene.spheres.len());
    let goal = Goal::of(Quality::Draft);
    assert_eq!(found, account.iterations(1, goal.noise, goal.work));
    // Neither the least nor what the work alone would allow.
    assert!(found > 8 && found < account.iterations(1, 0.0, goal.work), "{found}");
}
