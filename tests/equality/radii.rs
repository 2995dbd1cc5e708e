//! Search radii from one that finds no photons to one that finds all, and radii after many iterations.

use crate::pair::{all_lanes, assert_equal, tell};
use scene::{Settings, Vec3};

/// Radii, with the width and height of the image. For large radii every photon is a candidate at every pixel, so the
/// images are small.
const RADII: [(f32, u32, u32); 14] = [
    (1e-15, 16, 16),
    (1e-8, 16, 16),
    (1e-5, 24, 24),
    (1e-4, 32, 24),
    (3e-4, 32, 24),
    (6e-4, 32, 24),
    (1e-3, 32, 24),
    (0.01, 32, 24),
    (0.3, 32, 24),
    (5.0, 24, 24),
    (60.0, 16, 16),
    (500.0, 9, 9),
    (1e5, 5, 3),
    (1e15, 5, 3),
];

#[test]
fn first_radii() {
    let mut cases = 0;
    for name in ["cornell", "random", "motion"] {
        let scene = files::builtin::scene(name).unwrap();
        for (initial_radius, width, height) in RADII {
            let settings = Settings {
                width,
                height,
                iterations: 3,
                photons_per_iteration: 2000,
                initial_radius,
                ..scene.settings
            };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
        }
    }
    tell(cases, "14 radii");
}

/// Limits of first radii by what is near: among few spheres, among many, while these move, and with radii that find all photons
/// or hardly any, so that pixels keep asking.
#[test]
fn first_radii_by_clearance() {
    let mut cases = 0;
    for (name, radii) in [("mirror", [0.05, 8.0]), ("motion", [0.1, 2.0]), ("heap", [0.02, 0.8])] {
        let scene = files::builtin::scene(name).unwrap();
        for (initial_radius, radius_clearance) in
            radii.into_iter().flat_map(|radius| [0.2, 0.7, 3.0, 1000.0].map(|factor| (radius, factor)))
        {
            let settings = Settings {
                width: 32,
                height: 24,
                iterations: 3,
                photons_per_iteration: 2000,
                initial_radius,
                radius_clearance,
                radius_pilots: 0,
                ..scene.settings
            };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
        }
    }
    // Balls that move, each its own way and far, so that others are near at each instant.
    let mut scene = files::builtin::scene("heap").unwrap();
    scene.camera.shutter = [0.0, 1.0];
    let mut balls = 0..150_u8;
    scene.spheres.retain_mut(|sphere| {
        // The ground and the lights stay.
        if sphere.radius > 2.0 || sphere.is_emitter() {
            return true;
        }
        let Some(k) = balls.next() else { return false };
        let [x, y, z] = [k % 7, k % 5, k % 11].map(f32::from);
        sphere.velocity = Vec3::new(x - 3.0, y - 2.0, z - 5.0);
        true
    });
    for initial_radius in [0.05, 0.8] {
        let settings = Settings {
            width: 48,
            height: 36,
            iterations: 6,
            photons_per_iteration: 300,
            initial_radius,
            radius_clearance: 1.0,
            radius_pilots: 0,
            ..scene.settings
        };
        cases += assert_equal(&scene, &settings, &all_lanes(1));
    }
    tell(cases, "limits by clearance");
}

#[test]
fn radii_that_spread() {
    let mut cases = 0;
    for (name, initial_radius) in [("cornell", 40.0), ("mirror", 15.0), ("focus", 6.0)] {
        let scene = files::builtin::scene(name).unwrap();
        let settings = Settings {
            width: 24,
            height: 24,
            iterations: 48,
            photons_per_iteration: 200,
            initial_radius,
            ..scene.settings
        };
        cases += assert_equal(&scene, &settings, &all_lanes(2));
    }
    tell(cases, "48 iterations");
}

/// If the radius is about as small as the rounding error of coordinates, search spheres become boxes of a few cells.
/// The scene is far from the origin, so that this happens for radii at which photons are still found.
#[test]
fn radii_of_the_size_of_rounding() {
    let mut cases = 0;
    for offset in [0.0_f32, 3000.0, 100_000.0, 1e6] {
        let text = format!(
            "[camera]\neye = [{offset:?}, 1, 4]\ndirection = [0, -0.2, -1]\nvertical_fov_degrees = 60\n\
             [[sphere]]\ncenter = [{offset:?}, 0, 0]\nradius = 1\n\
             material = {{ type = \"diffuse\", albedo = [0.9, 0.8, 0.7] }}\n\
             [[sphere]]\ncenter = [{offset:?}, 0, 0]\nradius = 9\nemission = [1, 1, 1]\n\
             material = {{ type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }}\n"
        );
        let scene = files::scene_file::parse("far.toml", &text).unwrap();
        for step in 0..48 {
            // From far below the rounding error of coordinates to well above it.
            let ulp = offset.max(1.0) * f32::EPSILON;
            let initial_radius = ulp * 0.05 * 1.2_f32.powi(step);
            let settings = Settings {
                width: 16,
                height: 16,
                iterations: 2,
                photons_per_iteration: 1000,
                initial_radius,
                ..scene.settings
            };
            cases += assert_equal(&scene, &settings, &all_lanes(1));
        }
    }
    tell(cases, "radii of the size of rounding");
}
