//! Says when moving spheres show as separate images: each iteration renders one instant of the exposure.

use scene::settings::MAX_ITERATIONS;
use scene::text::counted;
use scene::{Scene, Vec3};

/// From so many pixels between two instants on, they are seen apart.
const APART: f64 = 2.0;

/// What to do about spheres that move too far between the instants of `iterations` iterations.
pub(super) fn hint(scene: &Scene, iterations: u32) -> String {
    let step = travel(scene) / f64::from(iterations.max(1));
    if step <= APART {
        return String::new();
    }
    let enough = (travel(scene) / APART).ceil();
    let seen = format!("; moving spheres show at {}", counted(iterations, "instant"));
    if enough > f64::from(MAX_ITERATIONS) {
        return format!("{seen}, far apart: open the shutter for a shorter time");
    }
    format!("{seen}, {step:.0} pixels apart: `-n {enough:.0}`, of fewer photons each, blurs them smoothly")
}

/// The way of the fastest sphere over the image while the shutter is open, in pixels; 0 if nothing moves.
fn travel(scene: &Scene) -> f64 {
    let camera = &scene.camera;
    let pixel = f64::from(camera.frame(scene.settings.width, scene.settings.height).pixel);
    let moving = scene.spheres.iter().filter(|sphere| sphere.velocity != Vec3::ZERO);
    let pixels = moving.map(|sphere| {
        let [open, close] =
            camera.shutter.map(|time| sphere.at(time).center.as_dvec3() - camera.eye.as_dvec3());
        let distance = open.length().min(close.length()).max(f64::from(sphere.radius));
        open.distance(close) / (distance * pixel)
    });
    pixels.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_that_are_seen_apart_are_told() {
        let mut scene = files::builtin::scene("motion").unwrap();
        let travel = travel(&scene);
        assert!(travel > 4.0, "{travel}");
        let enough = (travel / APART).ceil() as u32;
        assert_eq!(hint(&scene, enough), "");
        let told = hint(&scene, enough / 2);
        assert!(told.contains(&format!("`-n {enough}`")), "{told}");
        // Twice the pixels, twice the way.
        (scene.settings.width, scene.settings.height) = (2 * scene.settings.width, 2 * scene.settings.height);
        let ratio = super::travel(&scene) / travel;
        assert!((ratio - 2.0).abs() < 1e-5, "{ratio}");
        // More iterations than there can be.
        let shutter = std::mem::replace(&mut scene.camera.shutter, [0.0, 1e10]);
        assert_eq!(
            hint(&scene, 2),
            "; moving spheres show at 2 instants, far apart: open the shutter for a shorter time"
        );
        scene.camera.shutter = shutter;
        for sphere in &mut scene.spheres {
            sphere.velocity = Vec3::ZERO;
        }
        assert_eq!(hint(&scene, 1), "");
    }

    /// From so many pixels on, and no fewer.
    #[test]
    fn instants_that_are_close_enough_are_not_told() {
        let mut scene = files::builtin::scene("motion").unwrap();
        let travel = travel(&scene);
        let ratio = 4.0 * APART / travel;
        for sphere in &mut scene.spheres {
            sphere.velocity *= ratio as f32;
        }
        // Some 8 pixels in all.
        assert!((super::travel(&scene) / (4.0 * APART) - 1.0).abs() < 0.3, "{}", super::travel(&scene));
        assert_eq!((hint(&scene, 8), hint(&scene, 1).is_empty()), (String::new(), false));
        assert_eq!(hint(&scene, 0), hint(&scene, 1).replace("at 1 instant,", "at 0 instants,"));
    }

    /// By its distance where it is nearest: as far whether it comes or goes.
    #[test]
    fn a_ball_that_comes_near_travels_as_far_as_one_that_leaves() {
        let mut scene = files::builtin::scene("motion").unwrap();
        scene.camera.shutter = [0.0, 1.0];
        scene.spheres.retain(|sphere| sphere.velocity != Vec3::ZERO);
        scene.spheres.truncate(1);
        let (eye, ahead) = (scene.camera.eye, scene.camera.direction.normalize());
        let [far, near] = [50.0, 5.0].map(|distance| eye + ahead * distance + Vec3::X * 4.0);
        let mut between = |from: Vec3, to: Vec3| {
            (scene.spheres[0].center, scene.spheres[0].velocity) = (from, to - from);
            travel(&scene)
        };
        let [comes, leaves, rests] = [between(far, near), between(near, far), between(far, far + Vec3::X)];
        assert!((comes / leaves - 1.0).abs() < 1e-5 && comes > 100.0 * rests, "{comes}, {leaves}, {rests}");
    }

    /// It is seen from within, at the distance of its surface: its way over the image has an end.
    #[test]
    fn a_ball_around_the_eye_is_as_near_as_its_surface() {
        let mut scene = files::builtin::scene("motion").unwrap();
        scene.camera.shutter = [0.0, 1.0];
        scene.spheres.retain(|sphere| sphere.velocity != Vec3::ZERO);
        scene.spheres.truncate(1);
        let ball = &mut scene.spheres[0];
        (ball.center, ball.velocity) = (scene.camera.eye, Vec3::X * ball.radius);
        let pixel = f64::from(scene.camera.frame(scene.settings.width, scene.settings.height).pixel);
        assert!((travel(&scene) * pixel - 1.0).abs() < 1e-3, "{} pixels", travel(&scene));
    }
}
