//! The roles of the random numbers of the path tracer: a scene for each that shows its number.
//!
//! Up to the first diffuse surface the numbers are stratified, and so is the direction in which a path leaves it. After that
//! a path draws its numbers one after the other, so which number a role gets depends on what the path met before. In all
//! scenes here it crosses two interfaces of glass and then meets a diffuse surface.

use super::Role;
use super::camera::{ASKEW, lamp_at, shells, two_lamps};
use crate::harness::{BLACK, Build, diffuse, empty_scene, glass, pinhole, settings};
use reference::PathTracer;
use scene::{Engine, Resumable, Rgb, Scene, Settings, Stats, Vec3};

/// The radiance of one path.
fn radiance(scene: &Scene, seed: u64, iteration: u32, depth: u32) -> Rgb {
    let settings = Settings { seed, ..settings(1, 1, 1, depth, 1.0) };
    let mut engine = PathTracer::new(scene, &settings);
    // Radiance is a mean over all iterations; only one is not black.
    engine.go_on_after(iteration, Stats::default());
    engine.iterate();
    engine.develop().pixels[0] * (iteration + 1) as f32
}

/// The roles of a path.
pub(super) fn roles(iteration: u32) -> Vec<Role> {
    let light = |scene: &Scene, seed, depth| radiance(scene, seed, iteration, depth);
    let two =
        |name: &str, scene: Scene, depth| Role::of_two(name, |seed| light(&scene, seed, depth) != Rgb::ZERO);
    let mut roles = vec![
        two("place in the pixel, x", half_covered(Vec3::X), 1),
        two("place in the pixel, y", half_covered(Vec3::Y), 1),
        two("place on the lens, angle", lens(ASKEW * 2.0 + Vec3::Z * 8.0, 2.0), 1),
        two("place on the lens, radius", lens(Vec3::Z * 8.0, 0.8 * LENS * 0.5_f32.sqrt()), 1),
    ];
    for segment in [0, 1] {
        let (scene, depth) = shells(segment);
        roles.push(two(&format!("lobe of segment {segment}"), scene, depth));
    }
    let lamps = behind_glass(two_lamps());
    roles.push(Role::of_two("choice of lamp", |seed| {
        let light = light(&lamps, seed, 3);
        light.x > light.y
    }));
    let overhead = behind_glass(lamp_at(Vec3::Z * 3.0, 2.0));
    roles.push(Role::of_many("place on the lamp, height", |seed| Some(light(&overhead, seed, 3).x.into())));
    roles.push(two("place on the lamp, angle", behind_glass(lamp_at(ASKEW * 3.0, 1.0)), 3));
    let lamps = four_lamps();
    roles.push(Role::of_few("direction at the first surface", |seed| {
        let [r, g, b] = light(&lamps, seed, 8).to_array();
        let is_lit = |c: f32| usize::from(c > 0.0);
        // Red, green, blue or white; or none.
        Some(if r > 0.0 && g > 0.0 { 4 } else { is_lit(r) + 2 * is_lit(g) + 3 * is_lit(b) })
    }));
    let [within, beyond] =
        [surface_in_dense_glass(Rgb::ONE, Rgb::ZERO), surface_in_dense_glass(Rgb::ZERO, Rgb::ONE)];
    roles.push(Role::of_few("lobe after the first surface", |seed| {
        let is_reached = light(&within, seed, 3) != Rgb::ZERO;
        is_reached.then(|| usize::from(light(&beyond, seed, 3) != Rgb::ZERO))
    }));
    roles.push(two("roulette at the first surface", surface_in_glowing_glass(), 8));
    roles.push(two("roulette under a sky", surface_in_many_glasses(), 8));
    roles
}

/// True for two roles of which a path has one at a time: where there is a sky, no roulette is before the next lobe.
pub(super) fn is_either(a: &str, b: &str) -> bool {
    let pair = ["lobe after the first surface", "roulette at the first surface"];
    pair.contains(&a) && pair.contains(&b)
}

/// A lamp so large that it covers one half of the pixel, towards `side`.
fn half_covered(side: Vec3) -> Scene {
    empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 0.1)).lamp(
        side * 10.0 + Vec3::NEG_Z * 9.0,
        10.0,
        BLACK,
        Rgb::ONE,
    )
}

/// Radius of the lens.
const LENS: f32 = 0.01;

/// A glowing shell seen through a lens, of which a black ball covers a part.
fn lens(center: Vec3, radius: f32) -> Scene {
    let mut scene = empty_scene(pinhole(Vec3::Z * 10.0, Vec3::ZERO, 1e-3))
        .lamp(Vec3::ZERO, 30.0, BLACK, Rgb::ONE)
        .ball(center, radius, BLACK);
    (scene.camera.aperture_radius, scene.camera.focus_distance) = (LENS, 10.0);
    scene
}

/// Two shells of glass of index 1 around the eye, too small to be met again.
fn behind_glass(scene: Scene) -> Scene {
    let eye = scene.camera.eye;
    scene.ball(eye, 0.01, glass(1.0, 1.0)).ball(eye, 0.02, glass(1.0, 1.0))
}

/// A diffuse ball whose top the eye sees, in a ball of glass of index 1; beyond it a shell that glows. Light reaches the
/// eye only from where the path goes on to: glass casts shadows, and what a path meets behind it counts.
fn surface_in_glass(albedo: f32, emission: Rgb) -> Scene {
    let eye = Vec3::new(0.0, 0.0, 30.0);
    let shell = empty_scene(pinhole(eye, Vec3::ZERO, 1e-3)).lamp(Vec3::ZERO, 100.0, BLACK, emission);
    shell.ball(Vec3::NEG_Z, 1.0, diffuse(albedo)).ball(Vec3::ZERO, 3.0, glass(1.0, 1.0)).ball(
        eye,
        0.01,
        glass(1.0, 1.0),
    )
}

/// As [`surface_in_glass`], with glowing glass around: a lamp that shows on all sides and is no enclosure.
fn surface_in_glowing_glass() -> Scene {
    surface_in_glass(0.5, Rgb::ZERO).lamp(Vec3::ZERO, 90.0, glass(1.0, 1.0), Rgb::ONE)
}

/// As [`surface_in_glass`], in so much glass that the path is put to roulette on its way to the shell, once.
fn surface_in_many_glasses() -> Scene {
    let scene = surface_in_glass(0.5, Rgb::ONE);
    [4.0, 5.0, 6.0, 7.0].iter().fold(scene, |scene, radius| scene.ball(Vec3::ZERO, *radius, glass(1.0, 1.0)))
}

/// A diffuse ball, which glows or not, whose top is the centre of a ball of glass that reflects nearly a half; beyond it a shell that
/// glows or not. What leaves the top meets the glass head on: it passes, or comes back.
fn surface_in_dense_glass(within: Rgb, beyond: Rgb) -> Scene {
    let eye = Vec3::new(0.0, 0.0, 30.0);
    empty_scene(pinhole(eye, Vec3::ZERO, 1e-3))
        .lamp(Vec3::ZERO, 100.0, BLACK, beyond)
        .lamp(Vec3::NEG_Z, 1.0, diffuse(1.0), within)
        .ball(Vec3::ZERO, 3.0, glass(1.0, 5.0))
        .ball(eye, 0.01, glass(1.0, 1.0))
}

/// As [`surface_in_glass`], with lamps of four colours on four sides of a black shell.
fn four_lamps() -> Scene {
    let sides = [(Vec3::X, Rgb::X), (Vec3::Y, Rgb::Y), (Vec3::NEG_X, Rgb::Z), (Vec3::NEG_Y, Rgb::ONE)];
    sides.into_iter().fold(surface_in_glass(1.0, Rgb::ZERO), |scene, (side, color)| {
        scene.lamp((side + Vec3::Z) * 20.0, 16.0, BLACK, color)
    })
}

/// Two numbers of a direction that are one would light some sides more than others.
#[test]
fn paths_go_to_all_sides_alike() {
    let lamps = four_lamps();
    let mut counts = [0_u32; 4];
    for seed in 0..16_384 {
        let [r, g, b] = radiance(&lamps, seed, 0, 8).to_array();
        if r + g + b > 0.0 {
            let side = if r > 0.0 && g > 0.0 { 3 } else { usize::from(g > 0.0) + 2 * usize::from(b > 0.0) };
            counts[side] += 1;
        }
    }
    let p = crate::harness::chi_square_p(&counts);
    assert!(p > crate::harness::SIGNIFICANCE, "{counts:?}: p = {p:.1e}");
}
