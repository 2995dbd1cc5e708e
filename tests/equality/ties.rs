//! Comparisons of numbers that rounding makes equal.

use crate::pair::{all_lanes, assert_equal, tell};
use scene::{Engine, Scene, Settings};

/// A lamp and a ball of the same radius, whose centres differ by a few rounding errors. On one side, points of the lamp
/// are inside the ball and emit nothing; on the other side they are outside. In between, their rounded distance to the
/// ball's centre equals its radius.
#[test]
fn a_lamp_that_almost_coincides_with_a_ball() {
    let mut cases = 0;
    for radius in [0.5_f32, 1.0, 2.0, 3.0] {
        let text = format!(
            r#"
            camera = {{ eye = [0, 0, 9], target = [0, 0, 0], vertical_fov_degrees = 90 }}
            [[sphere]]
            name = "shell"
            center = [0, 0, 0]
            radius = 10
            material = {{ type = "diffuse", albedo = [0.5, 0.5, 0.5] }}
            [[sphere]]
            name = "ball"
            center = [{}, 0, 0]
            radius = {radius}
            material = {{ type = "diffuse", albedo = [0.5, 0.5, 0.5] }}
            [[sphere]]
            name = "lamp"
            center = [0, 0, 0]
            radius = {radius}
            material = {{ type = "diffuse", albedo = [0, 0, 0] }}
            emission = [1, 1, 1]
            "#,
            4.0 * f32::EPSILON * radius
        );
        let scene = files::scene_file::parse("ties.toml", &text).unwrap();
        let settings = Settings {
            width: 16,
            height: 16,
            iterations: 2,
            photons_per_iteration: 3000,
            initial_radius: 3.0,
            ..scene.settings
        };
        let segments = |spheres: &[usize]| {
            let spheres = spheres.iter().map(|&i| scene.spheres[i]).collect();
            let scene = Scene { spheres, ..scene.clone() };
            let mut engine = fast::Sppm::new(&scene, &settings);
            engine.iterate();
            engine.stats().photon_segments
        };
        let (with, without) = (segments(&[0, 1, 2]), segments(&[0, 2]));
        assert!(
            0 < with && with < without,
            "{radius}: {with} segments of {without}: rounding decides nothing"
        );
        cases += assert_equal(&scene, &settings, &all_lanes(1));
    }
    tell(cases, "lamps that all but coincide with a ball");
}
