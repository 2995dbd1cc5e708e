//! Fuzzes scene files: each text gives a one-line error or a scene that satisfies what the engines rely on.

#![no_main]

use libfuzzer_sys::fuzz_target;
use scene::{Rgb, Scene};

fuzz_target!(|text: &str| {
    match files::scene_file::parse("fuzz.toml", text) {
        Ok(scene) => check(&scene),
        Err(error) => {
            let line = error.to_string();
            assert!(!line.is_empty() && !line.chars().any(char::is_control), "{line:?}");
        }
    }
});

fn check(scene: &Scene) {
    scene.settings.validate().unwrap();
    for sphere in &scene.spheres {
        assert!(sphere.center.is_finite() && sphere.velocity.is_finite());
        assert!(sphere.radius.is_finite() && sphere.radius > 0.0);
        assert!(sphere.emission.is_finite() && sphere.emission.min_element() >= 0.0);
        let albedo = scene.materials[sphere.material as usize].albedo();
        assert!(albedo.cmpge(Rgb::ZERO).all() && albedo.cmple(Rgb::ONE).all());
    }
    let frame = scene.camera.frame(scene.settings.width, scene.settings.height);
    assert!(frame.forward.is_finite() && frame.right.is_finite() && frame.up.is_finite());
    for time in scene.camera.shutter {
        let still = scene.at(time);
        assert!(still.lights.power.is_finite() && still.lights.power > 0.0);
        assert_eq!(still.roles.len(), scene.spheres.len());
    }
}
