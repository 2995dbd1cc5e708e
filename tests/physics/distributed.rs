//! Depth of field and motion blur: comparison of SPPM with the path tracer.

use crate::harness::{
    BLACK, Build, block_mean, coloured, diffuse, empty_scene, mean, pinhole, relative_error,
    render_path_fast, render_sppm, settings,
};
use scene::{Film, Rgb, Scene, Settings, Vec3};

const BLOCKS: [u32; 2] = [4, 3];

/// Relative tolerance of image means: noise of 0.1 % in each engine, and the bias of SPPM.
const SAME_MEAN: f64 = 5e-3;

/// Relative tolerance of blocks of 12 x 12 pixels. Each gets about a hundredth of the photons and samples, which gives
/// up to 1 % of noise in each engine; blocks with an edge also have some bias.
const SAME_BLOCK: f64 = 3e-2;

/// A dark shell with a lamp above, a near ball and a far ball.
pub(crate) fn two_balls() -> Scene {
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
pub(crate) fn assert_converges(scene: &Scene, without: &Scene) {
    let settings = sppm_settings(64);
    let sppm = render_sppm(scene, &settings);
    let path = render_path_fast(scene, &Settings { iterations: 1024, ..settings });
    let error = relative_error(mean(&sppm), mean(&path));
    assert!(error < SAME_MEAN, "means {:?} and {:?}", mean(&sppm), mean(&path));
    let error = worst_block(&sppm, &path);
    assert!(error < SAME_BLOCK, "a block differs by {error:.3}");
    let without = render_path_fast(without, &Settings { iterations: 256, ..settings });
    let differs = |(a, b): (&Rgb, &Rgb)| (a.x / b.x - 1.0).abs() > 0.25;
    let effect = without.pixels.iter().zip(&path.pixels).filter(|&pair| differs(pair)).count();
    assert!(effect > path.pixels.len() / 50, "the effect is seen in {effect} pixels only");
}
