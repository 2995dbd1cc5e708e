//! Paths from the eye end after `max_depth` segments, and so do those of photons.

use super::closed_form::{SMOOTH, assert_close, direct_light, lit, straight_ahead};
use crate::cases::tell;
use crate::harness::{
    BLACK, Build, assert_mean, coloured, diffuse, empty_scene, glass, pinhole, render_paths, render_photons,
    settings,
};
use scene::{Material, Rgb, Settings, Vec3};

/// Relative tolerance of furnaces without noise: about a hundred rounding errors of 2^-24.
const ROUNDING: f64 = 1e-5;

/// Relative tolerance of furnaces with 400,000 photons of which most survive: up to 2 standard errors.
const FURNACE: f64 = 1e-3;

/// The sum of the first `terms` powers of `q`.
fn geometric(q: f64, terms: u32) -> f64 {
    (0..terms as i32).map(|k| q.powi(k)).sum()
}

#[test]
fn eye_sees_as_many_reflections_as_there_are_segments() {
    let (albedo, emission) = (Rgb::new(0.9, 0.5, 1.0), Rgb::new(1.0, 2.0, 0.5));
    let scene = empty_scene(pinhole(Vec3::Z * 2.9, Vec3::ZERO, 90.0)).lamp(
        Vec3::ZERO,
        3.0,
        Material::Specular { albedo },
        emission,
    );
    for depth in [1, 2, 3, 5, 64] {
        let settings = settings(16, 16, 1, depth, 1.0);
        let expected = [0, 1, 2].map(|c| f64::from(emission[c]) * geometric(f64::from(albedo[c]), depth));
        for film in [render_photons(&scene, &settings), render_paths(&scene, &settings)] {
            assert_mean(&film, expected, ROUNDING, &format!("depth {depth}"));
        }
    }
    tell("physics", 10, "furnaces of a mirror");
}

/// Photons on the whole shell contribute to each pixel, whatever the angle between their normal and that of the visible
/// point. A test of this angle would lose half of the light beyond the first two terms.
#[test]
fn photons_bring_as_many_reflections_as_there_are_segments() {
    // The brightest channel has an albedo of 1, so roulette ends no path, and the other channels are weighted.
    let (albedo, emission) = ([1.0, 0.5, 0.2], [3.0, 1.0, 0.5]);
    let scene = empty_scene(pinhole(Vec3::Z * 2.9, Vec3::ZERO, 90.0)).lamp(
        Vec3::ZERO,
        3.0,
        coloured(albedo),
        Rgb::from_array(emission),
    );
    for depth in [1, 2, 3, 5] {
        let expected = [0, 1, 2].map(|c| f64::from(emission[c]) * geometric(f64::from(albedo[c]), depth + 1));
        let settings = Settings { iterations: 1, ..settings(4, 4, 400_000, depth, 6.0) };
        assert_mean(&render_photons(&scene, &settings), expected, FURNACE, &format!("depth {depth}"));
    }
    tell("physics", 4, "furnaces within one radius");
}

#[test]
fn direct_light_is_seen_where_the_last_segment_ends() {
    // Three panes of glass of index 1, two interfaces each, and a lit ball behind them.
    let scene = (0..3).fold(straight_ahead(Vec3::Z * 5.0, Vec3::NEG_Z), |scene, i| {
        scene.ball(Vec3::Z * (4.5 - 0.5 * i as f32), 0.1, glass(1.0, 1.0))
    });
    let scene =
        scene.ball(Vec3::NEG_Z, 1.0, diffuse(0.5)).lamp(Vec3::new(9.0, 0.0, 9.0), 0.1, BLACK, Rgb::ONE);
    let expected = 0.5 * lit(Vec3::Z, Vec3::new(9.0, 0.0, 9.0), 0.1);
    for depth in [1, 6] {
        assert_eq!(direct_light(&scene, depth), [0.0; 3], "depth {depth}");
    }
    for depth in [7, 8] {
        assert_close(direct_light(&scene, depth), [expected; 3], SMOOTH, &format!("depth {depth}"));
    }
    tell("physics", 4, "depths at which a lit ball is seen");
}
