//! Which scenes are refused, and by which sentences.

use super::*;
use crate::settings::Settings;

fn sphere(center: Vec3, radius: f32, emission: Rgb) -> Sphere {
    Sphere { center, velocity: Vec3::ZERO, radius, material: 0, emission }
}

type Change = fn(&mut Scene);

/// A lamp and a ball before the eye.
fn valid() -> Scene {
    Scene {
        name: "built".into(),
        camera: Camera { shutter: [0.0, 1.0], ..Camera::default() },
        materials: vec![Material::Diffuse { albedo: Rgb::splat(0.5) }],
        spheres: vec![
            sphere(Vec3::NEG_Z * 10.0, 1.0, Rgb::ONE),
            sphere(Vec3::new(0.0, 4.0, -10.0), 1.0, Rgb::ZERO),
        ]
        .into(),
        background: Rgb::ZERO,
        transparent_background: false,
        imports: Vec::new(),
        settings: Settings::default(),
    }
}

/// Two lamps, of which the second is sealed off in each way; and scenes in which it is not.
#[test]
fn a_lamp_that_lights_nothing_is_told() {
    let with = |others: &[(Vec3, f32, Rgb)]| {
        let mut scene = valid();
        let others = others.iter().map(|(center, radius, emission)| sphere(*center, *radius, *emission));
        scene.spheres.extend(others);
        scene.check_light().unwrap().map(|flaw| flaw.to_string())
    };
    let (aside, dark) = (Vec3::X * 20.0, Rgb::ZERO);
    let lamp = (aside, 1.0, Rgb::ONE);
    assert_eq!(with(&[lamp]), None);
    assert_eq!(with(&[lamp, (aside + Vec3::X, 1.5, dark)]), None, "a part of it is outside");
    assert_eq!(with(&[lamp, (aside, 0.5, dark)]), None, "it holds the ball");
    assert_eq!(
        with(&[lamp, (aside, 2.0, dark)]).as_deref(),
        Some("sphere 3 lights nothing: sphere 4 is opaque and encloses it")
    );
    assert_eq!(
        with(&[(aside, 2.0, dark), lamp, lamp]).as_deref(),
        Some("sphere 4 lights nothing, as does another lamp: sphere 3 is opaque and encloses it")
    );
    assert_eq!(
        with(&[lamp, lamp, lamp]).as_deref(),
        Some(
            "sphere 3 lights nothing, as do 2 other lamps: sphere 4 is opaque and lies exactly where it does; remove one"
        )
    );
    assert_eq!(
        with(&[lamp, (Vec3::ZERO, 18.0, dark)]).as_deref(),
        Some("sphere 3 lights nothing: sphere 4 encloses the eye and not it")
    );
    assert_eq!(
        with(&[(Vec3::ZERO, 100.0, Rgb::ONE), (Vec3::ZERO, 18.0, dark)]).as_deref(),
        Some("sphere 3 lights nothing: sphere 4 encloses the eye and not it"),
        "a lamp around the sphere that the eye is in"
    );
    // Spheres that hide a part of it are not to blame.
    assert_eq!(
        with(&[(aside + Vec3::X * 1.5, 2.0, dark), lamp, (aside, 2.0, dark)]).as_deref(),
        Some("sphere 4 lights nothing: sphere 5 is opaque and encloses it")
    );
    assert_eq!(
        with(&[(Vec3::ZERO, 19.5, dark), lamp, (aside, 2.0, dark)]).as_deref(),
        Some("sphere 4 lights nothing: sphere 5 is opaque and encloses it")
    );
}

/// A lamp that comes into the open while the shutter is open does light something.
#[test]
fn a_lamp_that_lights_for_a_moment_is_not_told() {
    let mut scene = valid();
    let (aside, dark) = (Vec3::X * 20.0, Rgb::ZERO);
    scene.spheres.extend([sphere(aside, 1.0, Rgb::ONE), sphere(aside, 2.0, dark)]);
    assert!(scene.check_light().unwrap().is_some());
    scene.spheres[2].velocity = Vec3::Y * 10.0;
    assert_eq!(scene.check_light(), Ok(None));
    // It crosses the open from one sphere to another.
    scene.spheres.extend([sphere(aside + Vec3::Y * 10.0, 2.0, dark)]);
    assert_eq!(scene.check_light(), Ok(None));
    // What moves along with it hides it all the time.
    scene.spheres[3].velocity = scene.spheres[2].velocity;
    let told = scene.check_light().unwrap().unwrap().to_string();
    assert_eq!(told, "sphere 3 lights nothing: sphere 4 is opaque and encloses it");
}

/// There must be light when the shutter closes as when it opens: the only lamp may not vanish in a ball.
#[test]
fn the_only_lamp_is_in_the_open_at_both_ends_of_the_exposure() {
    let mut scene = valid();
    let (aside, dark) = (Vec3::new(0.0, 20.0, -10.0), Rgb::ZERO);
    scene.spheres.extend([sphere(aside, 2.0, dark)]);
    assert_eq!(scene.check_light(), Ok(None));
    scene.spheres[0].velocity = Vec3::Y * 20.0;
    let told = scene.check_light().unwrap_err().to_string();
    assert!(told.contains("sphere 3"), "{told}");
    // The other way round, and half of the way.
    (scene.spheres[0].center, scene.spheres[0].velocity) = (aside, Vec3::Y * -20.0);
    assert_eq!(scene.check_light().unwrap_err().to_string(), told);
    (scene.spheres[0].center, scene.spheres[0].velocity) = (Vec3::NEG_Z * 10.0, Vec3::Y * 10.0);
    assert_eq!(scene.check_light(), Ok(None));
}

#[test]
fn a_scene_built_in_code_is_told_what_is_wrong_with_it() {
    assert_eq!(valid().check(), Ok(()));
    let sky = Scene { background: Rgb::ONE, ..valid() };
    assert_eq!(sky.clone().with_sky().check(), Ok(()));
    assert!(sky.check().unwrap_err().to_string().starts_with("background of the scene is no light yet"));
    let changes: [(Change, &str); 15] = [
        (|s| s.camera.eye.x = f32::NAN, "eye of the camera must be finite"),
        (|s| s.camera.direction = Vec3::ZERO, "direction of the camera must be finite numbers, not all zero"),
        (|s| s.camera.up = s.camera.direction, "up of the camera is parallel"),
        (|s| s.camera.vertical_fov_degrees = 180.0, "is outside (0, 180)"),
        (|s| s.camera.shutter = [1.0, 0.0], "shutter of the camera"),
        (|s| s.spheres[1].radius = -1.0, "radius of sphere 2 must be above 0"),
        (|s| s.spheres[0].material = 1, "material of sphere 1 is index 1 of 1 materials"),
        (|s| s.spheres[0].emission.y = -1.0, "emission of sphere 1 is outside"),
        (|s| s.spheres[0].emission = Rgb::ZERO, "there is no light"),
        (|s| s.spheres[1].velocity = Vec3::X * 2e15, "velocity of sphere 2 must be finite numbers"),
        (|s| s.spheres[1].center = Vec3::X, "eye of the camera lies on the surface of sphere 2"),
        // Where it lies from the beginning, whichever way the sphere goes then.
        (
            |s| (s.spheres[1].center, s.spheres[1].velocity) = (Vec3::X, Vec3::X),
            "eye of the camera lies on the surface of sphere 2",
        ),
        (
            |s| (s.spheres[1].center, s.spheres[1].velocity) = (Vec3::X * 3.0, Vec3::NEG_X * 3.0),
            "sphere 2 passes over the eye",
        ),
        (
            |s| (s.spheres[1].velocity, s.camera.shutter[1]) = (Vec3::X * 9e14, 2.0),
            "velocity of sphere 2 takes it beyond 1e15",
        ),
        (|s| s.spheres[1].center = Vec3::NEG_Z * 10.5, ""),
    ];
    for (change, expected) in changes {
        let mut scene = valid();
        change(&mut scene);
        match scene.check() {
            Err(flaw) => assert!(!expected.is_empty() && flaw.to_string().contains(expected), "{flaw}"),
            Ok(()) => assert_eq!(expected, ""),
        }
    }
}

/// However large the sphere, unless it moves: its centre is then rounded.
#[test]
fn the_eye_may_be_as_close_to_a_surface_as_its_coordinates_tell() {
    let over = |eye: Vec3, velocity: Vec3| {
        let mut scene = valid();
        let lamp = sphere(eye + Vec3::Y * 9.0, 1.0, Rgb::ONE);
        let ground = sphere(Vec3::new(eye.x, -1e4, 0.0), 1e4, Rgb::ZERO);
        scene.camera.eye = eye;
        scene.spheres = vec![lamp, Sphere { velocity, ..ground }].into();
        scene.check().map_err(|flaw| flaw.problem)
    };
    let refused = Err(Problem::EyeOn(1));
    assert_eq!(over(Vec3::Y * 1e-3, Vec3::ZERO), Ok(()));
    assert_eq!(over(Vec3::Y * 1e-3, Vec3::X), refused);
    assert_eq!(over(Vec3::Y * 1e-9, Vec3::ZERO), refused);
    // At a thousand, heights are told to a thousandth.
    assert_eq!(over(Vec3::new(1e3, 2e-3, 0.0), Vec3::ZERO), Ok(()));
    assert_eq!(over(Vec3::new(1e3, 5e-4, 0.0), Vec3::ZERO), refused);
}

#[test]
fn the_sphere_that_hides_the_only_lamp_is_named() {
    let at_lamp = sphere(Vec3::NEG_Z * 10.0, 1.0, Rgb::ZERO);
    let around = |center, radius| sphere(center, radius, Rgb::ZERO);
    for (hides, seal) in [
        (at_lamp, Seal::Coincides),
        (around(Vec3::NEG_Z * 10.0, 3.0), Seal::HoldsLamp),
        (around(Vec3::ZERO, 3.0), Seal::HoldsEye),
    ] {
        let mut scene = valid();
        scene.spheres.insert(0, hides);
        let flaw = scene.check().unwrap_err();
        assert_eq!((flaw.part, flaw.problem), (Part::Sphere(1), Problem::Sealed(Some((seal, 0)))));
    }
}

/// Of a line: beside one of its ends, or across it.
#[test]
fn the_nearest_point_of_a_way_may_be_within_it() {
    let of = |from: [f64; 3], to: [f64; 3]| nearest(from.into(), to.into());
    assert_eq!(of([-3.0, 4.0, 0.0], [5.0, 4.0, 0.0]), 4.0);
    assert_eq!(of([3.0, 4.0, 0.0], [9.0, 4.0, 0.0]), 5.0);
    assert_eq!(of([-9.0, 0.0, 4.0], [-3.0, 0.0, 4.0]), 5.0);
    assert_eq!(of([0.0, 3.0, 4.0], [0.0, 3.0, 4.0]), 5.0);
    let found = of([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert!((found - 0.5_f64.sqrt()).abs() < 1e-15, "{found}");
}

/// Away from the origin.
const EYE: Vec3 = Vec3::new(3.0, -2.0, 1.0);

/// The whole lens stays on one side: outside of a ball beside it, and inside of a room around it.
#[test]
fn a_lens_keeps_clear_of_surfaces() {
    let said = |aperture_radius: f32, center: Vec3, radius: f32| {
        let mut scene = valid();
        (scene.camera.eye, scene.camera.aperture_radius) = (EYE, aperture_radius);
        let mut spheres = scene.spheres.to_vec();
        spheres[1] = sphere(EYE + center, radius, Rgb::ZERO);
        scene.spheres = spheres.into();
        scene.check_places().err().map(|flaw| flaw.key)
    };
    // A ball that is 1 away.
    assert_eq!(
        [said(0.99, Vec3::X * 5.0, 4.0), said(1.01, Vec3::X * 5.0, 4.0)],
        [None, Some("aperture_radius")]
    );
    // A room whose wall is 1 away.
    assert_eq!(
        [said(0.99, Vec3::X * 5.0, 6.0), said(1.01, Vec3::X * 5.0, 6.0)],
        [None, Some("aperture_radius")]
    );
    assert_eq!(said(0.0, Vec3::X * 5.0, 5.0), Some("eye"));
}

/// On its way past the eye, and around it.
#[test]
fn spheres_that_move_keep_clear_of_the_lens() {
    let said = |from: Vec3, velocity: Vec3, lens: f32| {
        let mut scene = valid();
        (scene.camera.eye, scene.camera.aperture_radius) = (EYE, lens);
        let mut spheres = scene.spheres.to_vec();
        spheres[1] = Sphere { velocity, ..sphere(EYE + from, 2.0, Rgb::ZERO) };
        scene.spheres = spheres.into();
        scene.check_places().err().map(|flaw| flaw.key)
    };
    let across = |y: f32| said(Vec3::new(-10.0, y, 0.0), Vec3::X * 20.0, 0.0);
    assert_eq!([across(3.0), across(2.1), across(1.9)], [None, None, Some("velocity")]);
    // It ends before it comes near.
    assert_eq!(said(Vec3::X * -10.0, Vec3::X * 7.9, 0.0), None);
    assert_eq!(said(Vec3::X * -10.0, Vec3::X * 8.1, 0.0), Some("velocity"));
    assert_eq!(said(Vec3::new(-10.0, 3.0, 0.0), Vec3::X * 20.0, 1.1), Some("aperture_radius"));
    assert_eq!(said(Vec3::new(-10.0, 3.0, 0.0), Vec3::X * 20.0, 0.9), None);
    // A room around the eye, that comes and goes.
    let room = |from: f32, to: f32, lens| said(Vec3::X * from, Vec3::X * (to - from), lens);
    assert_eq!([room(-1.9, 1.9, 0.0), room(0.0, 1.9, 0.0), room(1.9, 0.0, 0.0)], [None; 3]);
    assert_eq!([room(0.0, 2.1, 0.0), room(-1.0, 2.1, 0.0)], [Some("velocity"); 2]);
    assert_eq!(room(2.1, 0.0, 0.0), Some("velocity"));
    assert_eq!([room(0.0, 1.0, 0.9), room(1.0, 0.0, 0.9)], [None; 2]);
    assert_eq!([room(0.0, 1.0, 1.1), room(1.0, 0.0, 1.1)], [Some("aperture_radius"); 2]);
}

const MOST: f32 = 1e15;
const BEYOND: f32 = 1.1e15;

fn of_ranges(change: Change) -> Option<(Part, &'static str)> {
    let mut scene = valid();
    change(&mut scene);
    scene.check_ranges().err().map(|flaw| (flaw.part, flaw.key))
}

#[test]
fn numbers_may_lie_at_the_ends_of_their_ranges() {
    let changes: [Change; 17] = [
        |s| s.camera.eye = Vec3::new(0.0, -MOST, MOST),
        |s| s.camera.direction = Vec3::new(0.0, 0.0, -1e-30),
        |s| s.camera.up = Vec3::new(0.0, 1e-5, 1.0),
        |s| s.camera.vertical_fov_degrees = 179.99,
        |s| s.camera.aperture_radius = MOST,
        |s| s.camera.focus_distance = f32::MAX,
        |s| s.camera.shutter = [-MOST, MOST],
        |s| s.camera.shutter = [2.0, 2.0],
        |s| s.materials[0] = Material::Specular { albedo: Rgb::new(0.0, 1.0, 0.0) },
        |s| s.materials[0] = Material::Dielectric { albedo: Rgb::ONE, ior: 1.0 },
        |s| s.materials[0] = Material::Dielectric { albedo: Rgb::ONE, ior: MAX_IOR },
        |s| s.spheres[1].center = Vec3::splat(-MOST),
        |s| s.spheres[1].velocity = Vec3::splat(-MOST),
        |s| s.spheres[1].radius = RADIUS_RANGE[0],
        |s| s.spheres[1].radius = RADIUS_RANGE[1],
        |s| s.spheres[1].emission = Rgb::new(0.0, MOST, 0.0),
        |s| s.materials.push(s.materials[0]),
    ];
    for (number, change) in changes.into_iter().enumerate() {
        assert_eq!(of_ranges(change), None, "change {number}");
    }
}

/// Each channel and each coordinate, on both sides, and what is no number.
#[test]
fn numbers_beyond_their_ranges_are_refused() {
    let of_camera: [(Change, &str); 17] = [
        (|s| s.camera.eye.z = BEYOND, "eye"),
        (|s| s.camera.eye.y = -BEYOND, "eye"),
        (|s| s.camera.direction.x = f32::INFINITY, "direction"),
        (|s| s.camera.up = Vec3::ZERO, "up"),
        (|s| s.camera.up = s.camera.direction * -3.0, "up"),
        (|s| s.camera.up = Vec3::new(0.0, 1e-7, 1.0), "up"),
        (|s| s.camera.vertical_fov_degrees = 0.0, "vertical_fov_degrees"),
        (|s| s.camera.vertical_fov_degrees = f32::NAN, "vertical_fov_degrees"),
        (|s| s.camera.aperture_radius = -1.0, "aperture_radius"),
        (|s| s.camera.aperture_radius = BEYOND, "aperture_radius"),
        (|s| s.camera.aperture_radius = f32::NAN, "aperture_radius"),
        (|s| s.camera.focus_distance = 0.0, "focus_distance"),
        (|s| s.camera.focus_distance = f32::INFINITY, "focus_distance"),
        (|s| s.camera.focus_distance = f32::NAN, "focus_distance"),
        (|s| s.camera.shutter = [0.0, BEYOND], "shutter"),
        (|s| s.camera.shutter = [-BEYOND, 0.0], "shutter"),
        (|s| s.camera.shutter = [0.0, f32::NAN], "shutter"),
    ];
    for (number, (change, key)) in of_camera.into_iter().enumerate() {
        assert_eq!(of_ranges(change), Some((Part::Camera, key)), "change {number} of the camera");
    }
    let glass = |ior| Material::Dielectric { albedo: Rgb::ONE, ior };
    let diffuse = |red, green, blue| Material::Diffuse { albedo: Rgb::new(red, green, blue) };
    for (material, key) in [
        (diffuse(-0.01, 0.5, 0.5), "albedo"),
        (diffuse(0.5, f32::NAN, 0.5), "albedo"),
        (diffuse(0.5, 0.5, 1.01), "albedo"),
        (glass(0.99), "ior"),
        (glass(100.01), "ior"),
        (glass(f32::NAN), "ior"),
    ] {
        let flaw = check_material(Part::Material(3), &material).unwrap_err();
        assert_eq!((flaw.part, flaw.key), (Part::Material(3), key), "{material:?}");
    }
    let of_others: [(Change, Part, &str); 9] = [
        (|s| s.background.z = -1.0, Part::Scene, "background"),
        (|s| s.background.y = BEYOND, Part::Scene, "background"),
        (|s| s.spheres[1].center.y = -BEYOND, Part::Sphere(1), "center"),
        (|s| s.spheres[1].velocity.z = f32::NAN, Part::Sphere(1), "velocity"),
        (|s| s.spheres[1].radius = 0.0, Part::Sphere(1), "radius"),
        (|s| s.spheres[1].radius = f32::INFINITY, Part::Sphere(1), "radius"),
        (|s| s.spheres[1].emission.z = BEYOND, Part::Sphere(1), "emission"),
        (|s| s.spheres[0].emission.x = f32::NAN, Part::Sphere(0), "emission"),
        (|s| s.spheres[0].material = 7, Part::Sphere(0), "material"),
    ];
    for (number, (change, part, key)) in of_others.into_iter().enumerate() {
        assert_eq!(of_ranges(change), Some((part, key)), "change {number}");
    }
}

/// Parts by the names that the caller has for them, and of two spheres each in its place.
#[test]
fn sentences_tell_the_numbers_and_name_the_parts() {
    const CLEAR: &str = "it must lie clearly inside or outside of an opaque sphere";
    const PUT: &str = "put a light into the space that the eye is in";
    let name = |part: Part| match part {
        Part::Sphere(i) => format!("ball {i}"),
        other => other.to_string(),
    };
    let hidden = |by, others| Problem::Hidden { by, others };
    for (part, problem, sentence) in [
        (
            Part::Camera,
            Problem::LensCuts(0.25, 3),
            format!("the lens, 0.25 around eye, cuts through ball 3; {CLEAR}"),
        ),
        (
            Part::Camera,
            Problem::EyeOn(3),
            format!("eye of the camera lies on the surface of ball 3; {CLEAR}"),
        ),
        (
            Part::Sphere(2),
            Problem::PassesEye,
            "ball 2 passes over the eye while the shutter is open; keep it clear of the eye".into(),
        ),
        (
            Part::Sphere(2),
            Problem::Escapes,
            "velocity of ball 2 takes it beyond 1e15 while the shutter is open".into(),
        ),
        (
            Part::Sphere(2),
            Problem::Sealed(None),
            format!("no light reaches the eye: opaque spheres seal every light off; {PUT}"),
        ),
        (
            Part::Sphere(2),
            Problem::Sealed(Some((Seal::HoldsLamp, 5))),
            format!("no light reaches the eye: ball 5 encloses ball 2; {PUT}"),
        ),
        (
            Part::Sphere(2),
            Problem::Sealed(Some((Seal::HoldsEye, 5))),
            format!("no light reaches the eye: ball 5 encloses the eye and no light; {PUT}"),
        ),
        (
            Part::Sphere(2),
            Problem::Sealed(Some((Seal::Coincides, 5))),
            "no light reaches the eye: ball 5 is opaque and lies exactly where ball 2 does; remove one"
                .into(),
        ),
        (Part::Sphere(2), hidden(None, 0), "ball 2 lights nothing: opaque spheres seal it off".into()),
        (
            Part::Sphere(2),
            hidden(None, 7),
            "ball 2 lights nothing, as do 7 other lamps: opaque spheres seal it off".into(),
        ),
    ] {
        let key = if part == Part::Camera { "eye" } else { "emission" };
        assert_eq!(Flaw::new(part, key, problem).say(name), sentence);
    }
    // Without names of the caller's, parts are counted from 1.
    let told = |part| Flaw::range(part, "albedo", "is odd").to_string();
    assert_eq!(told(Part::Material(1)), "albedo of material 2 is odd");
    assert_eq!(told(Part::Sphere(0)), "albedo of sphere 1 is odd");
    assert_eq!(told(Part::Scene), "albedo of the scene is odd");
}

/// Where spheres are while the shutter is open counts, and not where they are at time 0.
#[test]
fn scenes_are_checked_as_they_are_while_the_shutter_is_open() {
    let mut scene = valid();
    (scene.spheres[1].center, scene.spheres[1].velocity) = (Vec3::X, Vec3::X * 10.0);
    assert_eq!(scene.check_places().map_err(|flaw| flaw.key), Err("eye"));
    scene.camera.shutter = [1.0, 2.0];
    assert_eq!(scene.check_places(), Ok(()));
    // Beyond the limit when it opens, on the other side of the origin.
    scene.camera.shutter = [-2.0, 0.0];
    scene.spheres[1] = Sphere { velocity: Vec3::X * 9e14, ..sphere(Vec3::X * 5e14, 1.0, Rgb::ZERO) };
    let flaw = scene.check_places().unwrap_err();
    assert_eq!((flaw.part, flaw.problem), (Part::Sphere(1), Problem::Escapes));
    // A lamp that has flown into a ball, of an exposure that takes no time. Another rests there.
    let (mut scene, aside) = (valid(), Vec3::X * 20.0);
    let flies = Sphere { velocity: Vec3::NEG_Y * 10.0, ..sphere(aside + Vec3::Y * 10.0, 1.0, Rgb::ONE) };
    scene.spheres.extend([flies, sphere(aside, 2.0, Rgb::ZERO), sphere(aside, 0.5, Rgb::ONE)]);
    let told = |scene: &Scene| scene.check_light().unwrap().unwrap().to_string();
    scene.camera.shutter = [0.0, 0.0];
    assert_eq!(told(&scene), "sphere 5 lights nothing: sphere 4 is opaque and encloses it");
    scene.camera.shutter = [1.0, 1.0];
    let both = "sphere 3 lights nothing, as does another lamp: sphere 4 is opaque and encloses it";
    assert_eq!(told(&scene), both);
}

#[test]
fn glass_around_a_lamp_is_not_to_blame() {
    let (mut scene, aside) = (valid(), Vec3::X * 20.0);
    scene.materials.push(Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 });
    let glass = Sphere { material: 1, ..sphere(aside, 3.0, Rgb::ZERO) };
    scene.spheres.extend([glass, sphere(aside, 1.0, Rgb::ONE)]);
    assert_eq!(scene.check_light(), Ok(None));
    scene.spheres.extend([sphere(aside, 2.0, Rgb::ZERO)]);
    let told = scene.check_light().unwrap().unwrap().to_string();
    assert_eq!(told, "sphere 4 lights nothing: sphere 5 is opaque and encloses it");
}

/// Neither infinite nor so small that digits are lost.
#[test]
fn the_power_of_all_lights_is_a_normal_number() {
    let of = |radius: f32, emission: f32| {
        let lamp = sphere(Vec3::NEG_Z * 10.0, radius, Rgb::splat(emission));
        Scene { spheres: vec![lamp].into(), ..valid() }.check_light()
    };
    assert_eq!([of(1e-3, 1e-30), of(1e3, 1e30)], [Ok(None), Ok(None)]);
    let refused = Flaw::new(Part::Sphere(0), "emission", Problem::Power);
    assert_eq!(of(1e-3, 1e-35), Err(refused.clone()));
    assert_eq!(of(1e15, 1e15), Err(refused));
}

/// A background is the last sphere once it is a sky, and before there may be no sphere at all.
#[test]
fn a_scene_without_spheres_has_none_besides_its_sky() {
    let empty = Scene { spheres: Vec::<Sphere>::new().into(), background: Rgb::ONE, ..valid() };
    assert!(empty.without_sky().is_empty());
    assert_eq!(empty.check().map_err(|flaw| flaw.key), Err("background"));
    let sky = empty.with_sky();
    assert_eq!((sky.spheres.len(), sky.without_sky().len(), sky.check()), (1, 0, Ok(())));
}

/// Two that fly together keep the lamp dark, as one does that holds it; one that does not move with it does not.
#[test]
fn a_lamp_that_flies_with_its_double_is_told() {
    let (mut scene, aside) = (valid(), Vec3::X * 20.0);
    let flies = |emission| Sphere { velocity: Vec3::Y * 5.0, ..sphere(aside, 1.0, emission) };
    scene.spheres.extend([flies(Rgb::ONE), flies(Rgb::ZERO)]);
    let told = scene.check_light().unwrap().map(|flaw| flaw.problem);
    assert_eq!(told, Some(Problem::Hidden { by: Some((Seal::Coincides, 3)), others: 0 }));
    scene.spheres[3].velocity = Vec3::ZERO;
    assert_eq!(scene.check_light(), Ok(None));
}

/// The eye may be anywhere in glass, and on it.
#[test]
fn only_opaque_spheres_must_keep_clear_of_the_lens() {
    let mut scene = valid();
    scene.camera.aperture_radius = 0.5;
    scene.spheres[1].center = Vec3::X;
    assert_eq!(scene.check_places().map_err(|flaw| flaw.key), Err("eye"));
    scene.materials.push(Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 });
    scene.spheres[1].material = 1;
    assert_eq!(scene.check(), Ok(()));
}

/// Where there is no lamp, the background is the light that does not reach the eye.
#[test]
fn a_sky_is_sealed_off_by_what_is_around_the_eye() {
    let around = |center: Vec3| {
        let spheres = vec![sphere(Vec3::Y * 9.0, 1.0, Rgb::ZERO), sphere(center, 3.0, Rgb::ZERO)];
        Scene { spheres: spheres.into(), background: Rgb::ONE, ..valid() }.with_sky().check()
    };
    let sealed = Problem::Sealed(Some((Seal::HoldsEye, 1)));
    assert_eq!(around(Vec3::X), Err(Flaw::new(Part::Scene, "background", sealed)));
    assert_eq!(around(Vec3::X * 4.0), Ok(()));
}
