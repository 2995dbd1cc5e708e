//! Which scenes are refused: those in which light or the eye is where it cannot be, and numbers that mean nothing.

use crate::cases::tell;
use crate::harness::{BLACK, Build, diffuse, empty_scene, glass, mirror, pinhole};
use scene::{Camera, Material, Rgb, Scene, Vec3};

/// A lamp of radius 1 ten units before the eye, which is at the origin.
fn lit() -> Scene {
    empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0)).lamp(Vec3::Z * -10.0, 1.0, BLACK, Rgb::ONE)
}

/// The same with a ball.
fn with(center: Vec3, radius: f32, material: Material) -> Scene {
    lit().ball(center, radius, material)
}

/// Expects scenes to be refused for the key that is told, or to be accepted.
fn check(cases: &[(&str, Scene, Option<&str>)]) {
    for (what, scene, expected) in cases {
        let found = scene.check().map_err(|flaw| flaw.key);
        assert_eq!(found.err(), *expected, "{what}");
    }
    tell("physics", cases.len(), "scenes that are accepted or refused");
}

/// Light must come into the space that the eye is in: past glass, but not through what is opaque.
#[test]
fn some_light_reaches_the_space_of_the_eye() {
    let lamp = Vec3::Z * -10.0;
    let sky = |background| {
        let scene = Scene { background, ..empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 40.0)) };
        scene.ball(lamp, 1.0, diffuse(0.5)).with_sky()
    };
    let two = |scene: Scene| scene.lamp(Vec3::Y * 9.0, 1.0, BLACK, Rgb::ONE);
    let dark = |scene: Scene| scene.check_light().map(|told| told.map(|flaw| flaw.key)).ok().flatten();
    check(&[
        ("a lamp", lit(), None),
        ("nothing", sky(Rgb::ZERO), Some("background")),
        ("a sky", sky(Rgb::X), None),
        ("a lamp in a ball", with(lamp, 1.5, diffuse(1.0)), Some("emission")),
        ("a lamp in a mirror", with(lamp, 1.5, mirror(1.0)), Some("emission")),
        ("a lamp in glass", with(lamp, 1.5, glass(1.0, 1.5)), None),
        ("a lamp that stands out of a ball", with(lamp + Vec3::X, 1.9, diffuse(1.0)), None),
        ("a lamp that does not", with(lamp + Vec3::X, 2.1, diffuse(1.0)), Some("emission")),
        ("a lamp and a ball at one place", with(lamp, 1.0, diffuse(1.0)), Some("emission")),
        ("an eye in a ball", with(Vec3::ZERO, 5.0, diffuse(1.0)), Some("emission")),
        ("an eye in glass", with(Vec3::ZERO, 5.0, glass(1.0, 1.5)), None),
        ("a room that the lamp stands into", with(Vec3::ZERO, 9.5, diffuse(1.0)), None),
        ("a room", with(Vec3::ZERO, 50.0, diffuse(1.0)), None),
        ("two lamps, one in a ball", two(with(lamp, 1.5, diffuse(1.0))), None),
    ]);
    assert_eq!(dark(two(with(lamp, 1.5, diffuse(1.0)))), Some("emission"), "one is told of");
    assert_eq!([dark(two(lit())), dark(lit())], [None, None]);
}

/// The eye, and all of the lens, is clearly on one side of what is opaque, as long as the shutter is open.
#[test]
fn the_lens_is_on_one_side_of_every_surface() {
    let lens = |aperture_radius, scene: Scene| {
        let camera = Camera { aperture_radius, focus_distance: 5.0, ..scene.camera };
        Scene { camera, ..scene }
    };
    let moving = |shutter, center: Vec3, velocity| {
        let mut scene = with(center, 1.0, diffuse(0.5));
        scene.camera.shutter = shutter;
        scene.spheres[1].velocity = velocity;
        scene
    };
    let (aside, towards) = (Vec3::new(8.0, 0.0, 0.0), Vec3::NEG_X * 4.0);
    check(&[
        ("an eye on a ball", with(Vec3::X * 2.0, 2.0, diffuse(0.5)), Some("eye")),
        ("an eye on glass", with(Vec3::X * 2.0, 2.0, glass(1.0, 1.5)), None),
        ("an eye beside a ball", with(Vec3::X * 2.0, 1.999, diffuse(0.5)), None),
        ("a lens beside a ball", lens(0.9, with(Vec3::X * 3.0, 2.0, diffuse(0.5))), None),
        ("a lens in a ball", lens(1.1, with(Vec3::X * 3.0, 2.0, diffuse(0.5))), Some("aperture_radius")),
        ("a lens in glass", lens(1.1, with(Vec3::X * 3.0, 2.0, glass(1.0, 1.5))), None),
        ("a lens within a room", lens(1.1, with(Vec3::ZERO, 50.0, diffuse(0.5))), None),
        (
            "a lens through a wall",
            lens(1.1, with(Vec3::X * -30.0, 31.0, diffuse(0.5))),
            Some("aperture_radius"),
        ),
        ("a ball over the eye", moving([0.0, 4.0], aside, towards), Some("velocity")),
        ("a ball that has not come", moving([0.0, 1.5], aside, towards), None),
        ("a ball that has gone", moving([2.5, 4.0], aside, towards), None),
        ("a ball that passes", moving([0.0, 4.0], aside + Vec3::Y * 1.2, towards), None),
        ("a ball that stays", moving([0.0, 4.0], aside, Vec3::ZERO), None),
    ]);
}

/// Albedos are shares, indices at least that of the vacuum, and all else is finite and of its sign.
#[test]
fn numbers_mean_something() {
    let made_of = |material| with(Vec3::X * 4.0, 1.0, material);
    let seen_by = |change: fn(&mut Camera)| {
        let mut scene = lit();
        change(&mut scene.camera);
        scene
    };
    let sphere = |change: fn(&mut scene::Sphere)| {
        let mut scene = with(Vec3::X * 4.0, 1.0, diffuse(0.5));
        change(&mut scene.spheres[1]);
        scene
    };
    let above_1 = 1.0 + f32::EPSILON;
    check(&[
        ("all is reflected", made_of(diffuse(1.0)), None),
        ("more than all", made_of(diffuse(above_1)), Some("albedo")),
        ("less than nothing", made_of(mirror(-0.1)), Some("albedo")),
        ("no number", made_of(glass(f32::NAN, 1.5)), Some("albedo")),
        ("an index of 1", made_of(glass(1.0, 1.0)), None),
        ("an index below", made_of(glass(1.0, 0.999)), Some("ior")),
        ("an index of 100", made_of(glass(1.0, 100.0)), None),
        ("an index above", made_of(glass(1.0, 100.1)), Some("ior")),
        ("no radius", sphere(|s| s.radius = 0.0), Some("radius")),
        ("a negative radius", sphere(|s| s.radius = -1.0), Some("radius")),
        ("a negative emission", sphere(|s| s.emission.y = -1.0), Some("emission")),
        ("an infinite emission", sphere(|s| s.emission.x = f32::INFINITY), Some("emission")),
        ("an infinite velocity", sphere(|s| s.velocity.x = f32::INFINITY), Some("velocity")),
        ("a material that there is not", sphere(|s| s.material = 2), Some("material")),
        ("a place that is none", sphere(|s| s.center.z = f32::NAN), Some("center")),
        ("a view of nothing", seen_by(|c| c.vertical_fov_degrees = 0.0), Some("vertical_fov_degrees")),
        ("a view of half of all", seen_by(|c| c.vertical_fov_degrees = 180.0), Some("vertical_fov_degrees")),
        ("nearly that", seen_by(|c| c.vertical_fov_degrees = 179.0), None),
        ("no direction", seen_by(|c| c.direction = Vec3::ZERO), Some("direction")),
        ("up along the direction", seen_by(|c| c.up = Vec3::Z * 3.0), Some("up")),
        ("up aside", seen_by(|c| c.up = Vec3::new(0.01, 0.0, 3.0)), None),
        ("a negative lens", seen_by(|c| c.aperture_radius = -0.1), Some("aperture_radius")),
        ("a focus at the eye", seen_by(|c| c.focus_distance = 0.0), Some("focus_distance")),
        ("a shutter that closes first", seen_by(|c| c.shutter = [1.0, 0.5]), Some("shutter")),
        ("a shutter that opens for no time", seen_by(|c| c.shutter = [-1.0, -1.0]), None),
    ]);
}
