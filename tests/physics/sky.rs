//! A uniform sky, under which a single convex object has a radiance in closed form.

use crate::cases::tell;
use crate::harness::{
    Build, coloured, diffuse, empty_scene, glass, mirror, pinhole, render_path, render_sppm, settings,
};
use scene::{Camera, Film, Rgb, Scene, Settings, Vec3};

const SKY: Rgb = Rgb::new(0.5, 1.0, 2.0);

/// Tolerance: a dozen rounding errors of 2^-24.
const ROUNDING: f32 = 1e-6;

/// Relative tolerance: the rounding errors of about a hundred reflections in glass at grazing angles and between
/// mirrors.
const THROUGH_GLASS: f32 = 1e-5;

fn under_the_sky(scene: Scene) -> Scene {
    Scene { background: SKY, ..scene }.with_sky()
}

fn images(scene: &Scene, depth: u32) -> [Film; 2] {
    let settings = Settings { iterations: 2, ..settings(33, 25, 500, depth, 0.1) };
    [render_sppm(scene, &settings), render_path(scene, &settings)]
}

#[test]
fn a_ball_under_the_sky_reflects_its_albedo_of_it() {
    let albedo = [0.9, 0.5, 0.1];
    let scene = empty_scene(pinhole(Vec3::new(1.0, 2.0, 5.0), Vec3::ZERO, 40.0));
    let scene = under_the_sky(scene.ball(Vec3::ZERO, 1.0, coloured(albedo)));
    for depth in [1, 2, 7] {
        for film in images(&scene, depth) {
            // In each of the two iterations, a pixel shows either the ball or the sky.
            let ball = Rgb::from_array(albedo) * SKY;
            let near = |p: &Rgb, to: Rgb| (*p - to).abs().max_element() < ROUNDING;
            let [balls, skies] = [ball, SKY].map(|to| film.pixels.iter().filter(|p| near(p, to)).count());
            let edges = film.pixels.iter().filter(|p| near(p, 0.5 * (ball + SKY))).count();
            assert!(balls > 100 && skies > 300, "depth {depth}: {balls} of the ball, {skies} of the sky");
            assert_eq!(balls + skies + edges, film.pixels.len(), "depth {depth}: pixels of another radiance");
            // The corner shows exactly the sky.
            assert_eq!(film.pixels[0], SKY);
        }
    }
    tell("physics", 6, "images of a ball under the sky");
}

/// Where all that is not sky reflects all light, each path of the path tracer ends in the sky and brings just that: of a shadow ray
/// and a path of their own, one or both might. Balls touch, so that paths are long and roulette decides, which spares all.
#[test]
fn white_objects_are_invisible_to_every_path() {
    const WHITE: [f32; 3] = [1.0; 3];
    let scene = empty_scene(pinhole(Vec3::new(0.5, 1.5, 5.0), Vec3::ZERO, 50.0))
        .ball(Vec3::new(0.0, -101.0, 0.0), 100.0, coloured(WHITE))
        .ball(Vec3::new(-1.0, 0.0, 0.0), 1.0, coloured(WHITE))
        .ball(Vec3::new(1.0, 0.0, 0.0), 1.0, coloured(WHITE))
        .ball(Vec3::new(0.0, -0.6, 1.2), 0.4, glass(1.0, 1.5));
    let settings = Settings { iterations: 1, ..settings(33, 25, 1, 1024, 1.0) };
    let film = render_path(&under_the_sky(scene), &settings);
    let shows = |p: &&Rgb| ((**p - SKY) / SKY).abs().max_element() > THROUGH_GLASS;
    assert_eq!(film.pixels.iter().find(shows), None, "something shows");
    tell("physics", 1, "images of white things under the sky");
}

#[test]
fn lossless_objects_are_invisible_under_the_sky() {
    let scene = empty_scene(pinhole(Vec3::Z * 5.0, Vec3::ZERO, 50.0))
        .ball(Vec3::new(-1.0, 0.0, 0.0), 1.0, glass(1.0, 1.5))
        .ball(Vec3::new(1.0, 0.0, 0.0), 1.0, mirror(1.0))
        .ball(Vec3::new(-1.0, 0.0, 0.0), 0.4, mirror(1.0));
    for film in images(&under_the_sky(scene), 1024) {
        // Radiance is scaled by the squared index when entering glass and by its inverse when leaving.
        let shows = |p: &&Rgb| ((**p - SKY) / SKY).abs().max_element() > THROUGH_GLASS;
        assert_eq!(film.pixels.iter().find(shows), None, "something shows");
    }
}

/// Relative tolerance: rounding may decide whether a few of the 1650 rays hit the ball at its edge or miss it.
const EDGE: f64 = 2e-3;

#[test]
fn the_sky_does_not_depend_on_place_and_size_of_the_scene() {
    // The sky is uniform, so moving or scaling the whole scene changes only rounding.
    let scene = |offset: Vec3, size: f32| {
        let scene = empty_scene(pinhole((Vec3::Z * 5.0 + offset) * size, offset * size, 40.0));
        under_the_sky(scene.ball(offset * size, size, coloured([0.5; 3])))
    };
    let mean = |scene: &Scene| images(scene, 3).map(|film| crate::harness::mean(&film)[0]);
    let expected = mean(&scene(Vec3::ZERO, 1.0));
    for (offset, size) in [(Vec3::new(3.0, 0.0, -7.0), 1.0), (Vec3::ZERO, 8.0)] {
        for (actual, expected) in mean(&scene(offset, size)).into_iter().zip(expected) {
            assert!((actual / expected - 1.0).abs() < EDGE, "{actual} instead of {expected}");
        }
    }
}

/// There is nothing else: no ball, no lens, and so nothing that gives the sky a size.
#[test]
fn an_eye_that_is_alone_sees_the_sky() {
    let scene = under_the_sky(empty_scene(pinhole(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 30.0)));
    scene.check().unwrap();
    for film in images(&scene, 4) {
        assert!(film.pixels.iter().all(|pixel| *pixel == SKY), "{:?}", film.pixels);
    }
}

/// However wide the lens is, the sky is around all of it: a lens that is wider than all else sees nothing but the sky.
#[test]
fn the_sky_is_seen_from_all_of_a_wide_lens() {
    let camera = pinhole(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 30.0);
    let camera = Camera { aperture_radius: 50.0, focus_distance: 100.0, ..camera };
    let background = Rgb::new(0.25, 0.5, 2.0);
    // Behind the lens.
    let scene = Scene { background, ..empty_scene(camera) }.ball(Vec3::new(2.0, 4.0, 6.0), 0.5, diffuse(0.5));
    for film in images(&scene.with_sky(), 4) {
        assert!(film.pixels.iter().all(|pixel| *pixel == background), "{:?}", film.pixels);
    }
}
