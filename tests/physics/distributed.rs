//! Depth of field and motion blur: comparisons with closed forms, and of SPPM with the path tracer.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, block_mean, coloured, diffuse, empty_scene, mean, pinhole, relative_error, render_path,
    render_sppm, settings,
};
use scene::{Film, Rgb, Scene, Settings, Vec3};

const BLOCKS: [u32; 2] = [4, 3];

/// Relative tolerance of image means: noise of 0.1 % in each engine, and the bias of SPPM.
const SAME_MEAN: f64 = 5e-3;

/// Relative tolerance of blocks of 12 x 12 pixels. Each gets about a hundredth of the photons and samples, which gives
/// up to 1 % of noise in each engine; blocks with an edge also have some bias.
const SAME_BLOCK: f64 = 3e-2;

/// A dark shell with a lamp above, a near ball and a far ball.
fn two_balls() -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO, 45.0))
        .ball(Vec3::ZERO, 10.0, diffuse(0.6))
        .lamp(Vec3::new(0.0, 8.0, 2.0), 1.5, BLACK, Rgb::new(20.0, 18.0, 15.0))
        .ball(Vec3::new(-1.5, -1.0, 3.0), 1.2, coloured([0.8, 0.3, 0.3]))
        .ball(Vec3::new(1.5, -0.5, -3.0), 2.0, coloured([0.3, 0.4, 0.8]));
    scene.camera.focus_distance = 6.0;
    scene
}

fn sppm_settings(iterations: u32) -> Settings {
    Settings { iterations, ..settings(48, 36, 60_000, 8, 0.3) }
}

fn block_means(film: &Film) -> Vec<[f64; 3]> {
    let [columns, rows] = BLOCKS;
    let (w, h) = (film.width / columns, film.height / rows);
    let blocks = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    blocks.map(|(x, y)| block_mean(film, x * w..(x + 1) * w, y * h..(y + 1) * h)).collect()
}

/// The largest relative difference of two images over all blocks.
fn worst_block(a: &Film, b: &Film) -> f64 {
    let pairs = block_means(a).into_iter().zip(block_means(b));
    pairs.map(|(a, b)| relative_error(a, b)).fold(0.0, f64::max)
}

/// Asserts that both engines agree on `scene`, and that the effect is visible: at least 2 % of the pixels differ by a
/// quarter from the scene `without` it.
fn assert_converges(scene: &Scene, without: &Scene) {
    let settings = sppm_settings(64);
    let sppm = render_sppm(scene, &settings);
    let path = render_path(scene, &Settings { iterations: 1024, ..settings });
    let error = relative_error(mean(&sppm), mean(&path));
    assert!(error < SAME_MEAN, "means {:?} and {:?}", mean(&sppm), mean(&path));
    let error = worst_block(&sppm, &path);
    assert!(error < SAME_BLOCK, "a block differs by {error:.3}");
    let without = render_path(without, &Settings { iterations: 256, ..settings });
    let differs = |(a, b): (&Rgb, &Rgb)| (a.x / b.x - 1.0).abs() > 0.25;
    let effect = without.pixels.iter().zip(&path.pixels).filter(|&pair| differs(pair)).count();
    assert!(effect > path.pixels.len() / 50, "the effect is seen in {effect} pixels only");
}

#[test]
fn depth_of_field_converges_to_the_path_tracers() {
    let sharp = two_balls();
    let mut scene = sharp.clone();
    scene.camera.aperture_radius = 0.6;
    assert_converges(&scene, &sharp);
}

#[test]
fn motion_blur_converges_to_the_path_tracers() {
    let still = two_balls();
    let mut scene = still.clone();
    scene.camera.shutter = [0.0, 1.0];
    scene.spheres[2].velocity = Vec3::new(3.0, 1.0, 0.0);
    assert_converges(&scene, &still);
}

#[test]
fn a_moving_lamp_converges_to_the_path_tracers() {
    let still = two_balls();
    let mut scene = still.clone();
    scene.camera.shutter = [0.0, 1.0];
    scene.spheres[1].velocity = Vec3::new(4.0, -2.0, 0.0);
    assert_converges(&scene, &still);
}

#[test]
fn a_point_out_of_focus_is_a_disc_of_the_lens_seen_from_it() {
    // A lens of radius A that is focused at f blurs a point at distance d to a disc of radius A |1/f - 1/d| at distance
    // 1.
    let (aperture, focus) = (0.5_f32, 4.0_f32);
    for distance in [2.5_f32, 4.0, 8.0] {
        let lamp_radius = 0.01 * distance;
        let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 30.0));
        scene = scene.lamp(Vec3::NEG_Z * distance, lamp_radius, BLACK, Rgb::ONE);
        (scene.camera.aperture_radius, scene.camera.focus_distance) = (aperture, focus);
        let film = render_path(&scene, &Settings { iterations: 400, ..settings(101, 101, 1, 1, 1.0) });
        let pixel = 2.0 * 15.0_f64.to_radians().tan() / 101.0;
        let (mut light, mut second_moment) = (0.0, 0.0);
        for (index, value) in film.pixels.iter().enumerate() {
            let place = |i: usize| (i as f64 - 50.0) * pixel;
            let r2 = place(index % 101).powi(2) + place(index / 101).powi(2);
            light += f64::from(value.x) * pixel * pixel;
            second_moment += f64::from(value.x) * pixel * pixel * r2;
        }
        // Blurring preserves the total light. The image is the convolution of the discs of lens and lamp, so their mean
        // squared radii add up. That of a disc is half its squared radius, that of a pixel a sixth of its squared side.
        let disc = f64::from(aperture) * (1.0 / f64::from(focus) - 1.0 / f64::from(distance)).abs();
        let expected_light = std::f64::consts::PI * 0.01_f64.powi(2);
        let expected = 0.5 * disc * disc + 0.5 * 0.01_f64.powi(2) - pixel * pixel / 6.0;
        assert!(
            (light / expected_light - 1.0).abs() < SMALL_LAMP,
            "distance {distance}: {light} {expected_light}"
        );
        let mean_square = second_moment / light - pixel * pixel / 3.0;
        assert!(
            (mean_square / expected - 1.0).abs() < SMALL_LAMP,
            "distance {distance}: {mean_square} {expected}"
        );
    }
    tell("physics", 3, "discs of a point out of focus");
}

/// Relative tolerance: the noise of about a thousand samples that hit the lamp, and second-order terms in the sizes of
/// lamp and lens.
const SMALL_LAMP: f64 = 5e-2;

#[test]
fn the_trail_of_a_moving_lamp_is_as_bright_as_the_time_it_stays() {
    // The lamp moves by 2 units through the middle of the image during the exposure.
    let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 45.0));
    scene = scene.lamp(Vec3::new(-1.0, 0.0, -4.0), 0.2, BLACK, Rgb::ONE);
    scene.spheres[0].velocity = Vec3::X * 2.0;
    scene.camera.shutter = [0.0, 1.0];
    let film = render_path(&scene, &Settings { iterations: 1024, ..settings(65, 65, 1, 1, 1.0) });
    // It covers a point in the middle of its path while it moves by 0.4 of the 2 units.
    let middle = f64::from(film.pixels[32 * 65 + 32].x);
    assert!((middle - 0.2).abs() < TRAIL, "{middle}");
    // Pixels that it never covers are black.
    assert!(film.pixels[..65 * 20].iter().all(|&p| p == Rgb::ZERO));
    // The shutter times of 2^k iterations are stratified, one in each interval.
    let mut times: Vec<f32> = (0..1024).map(|i| scene.camera.shutter_time(1, i) * 1024.0).collect();
    times.sort_by(f32::total_cmp);
    assert!(times.iter().enumerate().all(|(i, t)| t.floor() == i as f32));
}

/// Tolerance: within half a pixel of the middle, the round edge of the lamp shortens the time.
const TRAIL: f64 = 5e-3;
