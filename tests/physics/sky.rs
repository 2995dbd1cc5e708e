//! A uniform sky: what is convex and alone under it has a radiance in closed form.

use crate::cases::tell;
use crate::harness::{
    Build, coloured, empty_scene, glass, mirror, pinhole, render_path, render_sppm, settings,
};
use scene::{Film, Rgb, Scene, Settings, Vec3};

const SKY: Rgb = Rgb::new(0.5, 1.0, 2.0);

/// A dozen roundings of 2^-24.
const ROUNDING: f32 = 1e-6;

/// The roundings of some hundred reflections in grazing glass and between mirrors.
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
            // A pixel shows the ball, the sky, or in two iterations once each.
            let ball = Rgb::from_array(albedo) * SKY;
            let near = |p: &Rgb, to: Rgb| (*p - to).abs().max_element() < ROUNDING;
            let [balls, skies] = [ball, SKY].map(|to| film.pixels.iter().filter(|p| near(p, to)).count());
            let edges = film.pixels.iter().filter(|p| near(p, 0.5 * (ball + SKY))).count();
            assert!(balls > 100 && skies > 300, "depth {depth}: {balls} of the ball, {skies} of the sky");
            assert_eq!(balls + skies + edges, film.pixels.len(), "depth {depth}: pixels of another radiance");
            // In the corner there is nothing but sky, exactly.
            assert_eq!(film.pixels[0], SKY);
        }
    }
    tell("physics", 6, "images of a ball under the sky");
}

#[test]
fn what_takes_no_light_is_invisible_under_the_sky() {
    let scene = empty_scene(pinhole(Vec3::Z * 5.0, Vec3::ZERO, 50.0))
        .ball(Vec3::new(-1.0, 0.0, 0.0), 1.0, glass(1.0, 1.5))
        .ball(Vec3::new(1.0, 0.0, 0.0), 1.0, mirror(1.0))
        .ball(Vec3::new(-1.0, 0.0, 0.0), 0.4, mirror(1.0));
    for film in images(&under_the_sky(scene), 1024) {
        // Radiance is scaled by the squared index on the way in, and by its inverse on the way out.
        let shows = |p: &&Rgb| ((**p - SKY) / SKY).abs().max_element() > THROUGH_GLASS;
        assert_eq!(film.pixels.iter().find(shows), None, "something shows");
    }
}

/// Relative: rounding may decide whether one ray or another of 1650 hits the edge of the ball, or misses it.
const EDGE: f64 = 2e-3;

#[test]
fn the_sky_does_not_move_with_what_stands_under_it() {
    // The sky is uniform, so a shift of everything, or its size, changes nothing but rounding.
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
