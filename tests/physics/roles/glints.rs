//! The roles of the random numbers of further rays, by which a pixel sees lamps: a scene for each that shows its number.
//!
//! All are seen through a veil of glass around the eye, as only rays that first meet a mirror or glass count.

use super::Role;
use super::camera::{ASKEW, half_mirror};
use crate::cases::tell;
use crate::harness::{BLACK, Build, SIGNIFICANCE, chi_square_p_of, empty_scene, glass, pinhole, settings};
use reference::glints::GlintRays;
use scene::camera::Frame;
use scene::{Rgb, Scene, Settings, Vec3};

/// The side of the image, and so how its pixels are numbered.
const SIDE: u32 = 16;

/// The last surface of glass at which a lobe is tested.
const LAST_LOBE: u32 = 3;

/// Radius of the lens, and of the veil.
const LENS: f32 = 0.01;
const VEIL: f32 = 0.5;

/// A seed, an iteration and a pixel.
type Key = (u64, u32, [u32; 2]);

/// What so many further rays of a pixel see, on the average. The pixel shows all of the camera's image, whichever it is.
fn seen(scene: &Scene, (seed, iteration, [x, y]): Key, further: u32, depth: u32) -> Rgb {
    let frame = Frame { half: [0.5 + x as f32, 0.5 + y as f32], ..scene.camera.frame(1, 1) };
    let settings = Settings { seed, glint_samples: further, ..settings(SIDE, SIDE, 1, depth, 1.0) };
    let rays = GlintRays { frame: &frame, filter: None, rims: None, settings: &settings, iteration };
    rays.mean(&scene.at(0.0), (x, y), Rgb::ZERO, &mut 0)
}

/// The roles of the further ray of a pixel; and the place of that of the next iteration.
pub(super) fn roles(iteration: u32, pixel: [u32; 2]) -> Vec<Role> {
    let two = |name: String, scene: Scene, (iteration, depth)| {
        let shows = move |seed| seen(&scene, (seed, iteration, pixel), 1, depth) != Rgb::ZERO;
        Role::of_two(format!("further ray: {name}"), shows)
    };
    let mut roles = vec![
        two("place in the pixel, x".into(), half_covered(Vec3::X), (iteration, 2)),
        two("place in the pixel, y".into(), half_covered(Vec3::Y), (iteration, 2)),
        two("place in the pixel, x, next time".into(), half_covered(Vec3::X), (iteration + 1, 2)),
        two("place on the lens, angle".into(), lens(ASKEW * 2.0 + Vec3::Z * 8.0, 2.0), (iteration, 2)),
        two(
            "place on the lens, radius".into(),
            lens(Vec3::Z * 8.0, 0.8 * LENS * 0.5_f32.sqrt()),
            (iteration, 2),
        ),
    ];
    for lobe in 0..=LAST_LOBE {
        roles.push(two(format!("lobe {lobe}"), shells(lobe), (iteration, lobe + 2)));
    }
    roles
}

/// True for two roles of which a ray has one: without a lens, choices at glass come where places on the lens would be.
pub(super) fn is_either(a: &str, b: &str) -> bool {
    let pairs = [("place on the lens, radius", "lobe 0"), ("place on the lens, angle", "lobe 1")];
    let pairs = pairs.map(|(a, b)| [a, b].map(|role| format!("further ray: {role}")));
    pairs.iter().any(|pair| pair.iter().all(|role| role == a || role == b))
}

fn veiled(scene: Scene) -> Scene {
    let eye = scene.camera.eye;
    scene.ball(eye, VEIL, glass(1.0, 1.0))
}

/// A glowing ball of glass around the eye: a lamp that shows on all sides and is no enclosure.
fn within_a_lamp(scene: Scene) -> Scene {
    scene.lamp(Vec3::ZERO, 30.0, glass(1.0, 1.0), Rgb::ONE)
}

/// A lamp so large that it covers one half of the pixel, towards `side`.
fn half_covered(side: Vec3) -> Scene {
    let center = side * 10.0 + Vec3::NEG_Z * 9.0;
    veiled(empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 0.1)).lamp(center, 10.0, BLACK, Rgb::ONE))
}

/// A lamp on all sides seen through a lens, of which a black ball covers a part.
fn lens(center: Vec3, radius: f32) -> Scene {
    let black = empty_scene(pinhole(Vec3::Z * 10.0, Vec3::ZERO, 1e-3)).ball(center, radius, BLACK);
    let mut scene = veiled(within_a_lamp(black));
    (scene.camera.aperture_radius, scene.camera.focus_distance) = (LENS, 10.0);
    scene
}

/// The eye in the middle of so many shells of glass that does nothing, and one that reflects half. At a depth of two more a path
/// sees the lamp around it only if the last shell refracts it.
fn shells(count: u32) -> Scene {
    let scene = within_a_lamp(empty_scene(pinhole(Vec3::ZERO, Vec3::X, 1e-3)));
    let scene = (0..count).fold(scene, |scene, i| scene.ball(Vec3::ZERO, 1.0 + i as f32, glass(1.0, 1.0)));
    scene.ball(Vec3::ZERO, 1.0 + count as f32, glass(1.0, half_mirror()))
}

/// Each of them sees the lamp that covers half of the pixel, or not, whatever the others see.
#[test]
fn the_rays_of_a_pixel_are_independent() {
    let scene = half_covered(ASKEW);
    for (iteration, pixel) in [(0, [0, 0]), (7, [5, 11])] {
        let mut counts = [0; 4];
        for seed in 0..4096 {
            counts[(seen(&scene, (seed, iteration, pixel), 3, 2).x * 3.0).round() as usize] += 1;
        }
        let p = chi_square_p_of(&counts, &[0.125, 0.375, 0.375, 0.125]);
        assert!(p > SIGNIFICANCE, "{counts:?}, p = {p:.1e}");
    }
    tell("physics", 2 * 4096, "pixels with three further rays");
}
