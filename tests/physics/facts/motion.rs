//! A picture is the mean over the exposure: of what is seen, of what is lit, and of what lights it.

use super::closed_form::{SMOOTH, assert_close, average, lit, straight_ahead};
use crate::cases::tell;
use crate::distributed::{assert_converges, two_balls};
use crate::harness::{
    BLACK, Build, diffuse, empty_scene, mean, pinhole, render_paths, render_photons, settings,
};
use scene::{Rgb, Settings, Vec3};

/// Tolerance: within half a pixel of the middle, the round edge of the lamp shortens the time.
const TRAIL: f64 = 5e-3;

#[test]
fn eye_sees_the_trail_of_a_lamp_as_bright_as_the_time_it_stays() {
    // The lamp moves by 2 units through the middle of the image during the exposure.
    let mut scene = empty_scene(pinhole(Vec3::ZERO, Vec3::NEG_Z, 45.0));
    scene = scene.lamp(Vec3::new(-1.0, 0.0, -4.0), 0.2, BLACK, Rgb::ONE);
    scene.spheres[0].velocity = Vec3::X * 2.0;
    scene.camera.shutter = [0.0, 1.0];
    let settings = Settings { iterations: 1024, ..settings(65, 65, 1, 1, 1.0) };
    for film in [render_paths(&scene, &settings), render_photons(&scene, &settings)] {
        // It covers a point in the middle of its path while it moves by 0.4 of the 2 units.
        let middle = f64::from(film.pixels[32 * 65 + 32].x);
        assert!((middle - 0.2).abs() < TRAIL, "{middle}");
        // Pixels that it never covers are black.
        assert!(film.pixels[..65 * 20].iter().all(|&p| p == Rgb::ZERO));
    }
    // The shutter times of 2^k iterations are stratified, one in each interval.
    let mut times: Vec<f32> = (0..1024).map(|i| scene.camera.shutter_time(1, i) * 1024.0).collect();
    times.sort_by(f32::total_cmp);
    assert!(times.iter().enumerate().all(|(i, t)| t.floor() == i as f32));
    tell("physics", 2, "trails of a lamp");
}

#[test]
fn photons_leave_a_moving_lamp_where_it_is() {
    let still = two_balls();
    let mut scene = still.clone();
    scene.camera.shutter = [0.0, 1.0];
    scene.spheres[1].velocity = Vec3::new(4.0, -2.0, 0.0);
    assert_converges(&scene, &still);
}

#[test]
fn photons_light_a_moving_ball_where_it_is() {
    let still = two_balls();
    let mut scene = still.clone();
    scene.camera.shutter = [0.0, 1.0];
    scene.spheres[2].velocity = Vec3::new(3.0, 1.0, 0.0);
    assert_converges(&scene, &still);
}

#[test]
fn direct_light_of_a_moving_lamp_is_its_mean_over_the_exposure() {
    let (from, velocity, shutter) = (Vec3::new(-6.0, 0.0, 4.0), Vec3::new(4.0, 1.0, 1.0), [1.0_f32, 3.0]);
    let mut scene = straight_ahead(Vec3::Z * 3.0, Vec3::NEG_Z).ball(Vec3::NEG_Z, 1.0, diffuse(0.5)).lamp(
        from,
        0.1,
        BLACK,
        Rgb::ONE,
    );
    scene.spheres[1].velocity = velocity;
    scene.camera.shutter = shutter;
    let at = |time: f64| lit(Vec3::Z, from + velocity * time as f32, 0.1);
    let [open, close] = shutter.map(f64::from);
    let expected = 0.5 * average(close - open, |time| at(open + time));
    let settings = Settings { iterations: 1024, ..settings(4, 4, 1, 1, 1.0) };
    for film in [render_photons(&scene, &settings), render_paths(&scene, &settings)] {
        assert_close(mean(&film), [expected; 3], SMOOTH, "a ball under a moving lamp");
    }
    tell("physics", 2, "balls under a moving lamp");
}
