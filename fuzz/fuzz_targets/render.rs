//! Fuzzes rendering: any valid scene file must give the same bits in both engines.

#![no_main]

use libfuzzer_sys::fuzz_target;
use scene::{Engine, Rgb, Scene, Settings};

/// Scenes with more spheres are skipped, as they would only be slower.
const MOST_SPHERES: usize = 48;

fuzz_target!(|text: &str| {
    if let Ok(scene) = files::scene_file::parse("fuzz.toml", text)
        && scene.spheres.len() <= MOST_SPHERES
    {
        compare(&scene);
    }
});

fn compare(scene: &Scene) {
    let settings = Settings {
        width: 5,
        height: 3,
        iterations: 2,
        photons_per_iteration: 40,
        max_depth: scene.settings.max_depth.min(12),
        ..scene.settings
    };
    let expected = shown(reference::Sppm::new(scene, &settings));
    for lanes in fast::LaneKind::ALL.into_iter().filter(|lanes| lanes.is_available()) {
        let actual = shown(fast::Sppm::with_lanes(scene, &settings, lanes));
        assert!(expected == actual, "{lanes:?} differs");
    }
}

/// The bits of image, radii and counts after two iterations.
fn shown(mut engine: impl Engine) -> [Vec<u32>; 3] {
    engine.iterate();
    engine.iterate();
    let image = engine.develop().pixels.iter().flat_map(Rgb::to_array).map(f32::to_bits).collect();
    let plane = |values: Vec<f32>| values.into_iter().map(f32::to_bits).collect();
    [image, plane(engine.radius().unwrap().values), plane(engine.count().unwrap().values)]
}
