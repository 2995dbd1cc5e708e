//! Finds what is seen at a place of the image.

use crate::message::Answer;
use render::EngineChoice;
use scene::ray::NO_SPHERE;
use scene::{Ray, Scene};

/// What is seen at `place`: from the left and the top edge of the image, 0, to the right and the bottom one, 1.
pub(crate) fn pick(scene: &Scene, id: u32, place: [f32; 2]) -> Answer {
    let nothing = Answer::Picked { id, sphere: None, point: None, depth: None };
    let [x, y] = place;
    if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
        return nothing;
    }
    let (width, height) = (scene.settings.width, scene.settings.height);
    let frame = scene.camera.frame(width, height);
    let across = (x - 0.5) * width as f32 * frame.pixel;
    let up = (0.5 - y) * height as f32 * frame.pixel;
    let direction = (frame.forward + frame.right * across + frame.up * up).normalize();
    let still = scene.at(scene.camera.shutter[0]);
    let ray = Ray { origin: frame.eye, direction, leaves: NO_SPHERE };
    // One ray needs no more than one thread, and none of those that render.
    let Ok(pool) = render::pool(Some(1)) else { return nothing };
    let hits = pool.install(|| render::trace(EngineChoice::default(), &still, &[ray]));
    let spheres = scene.without_sky().len() as u32;
    match hits.first() {
        Some(&(t, sphere, _)) if t.is_finite() => {
            let point = frame.eye + direction * t;
            let depth = (t * direction.dot(frame.forward)).max(f32::MIN_POSITIVE);
            let sphere = Some(sphere).filter(|sphere| *sphere < spheres);
            Answer::Picked { id, sphere, point: Some(point.to_array()), depth: Some(depth) }
        }
        _ => nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_found_where_they_are_seen() {
        let scene = files::builtin::scene("cornell").unwrap();
        let at = |x, y| match pick(&scene, 1, [x, y]) {
            Answer::Picked { sphere, depth, .. } => (sphere, depth),
            _ => (None, None),
        };
        // The mirror ball on the left, the glass ball on the right, lamps above.
        assert_eq!(at(0.34, 0.72).0, Some(5));
        assert_eq!(at(0.68, 0.75).0, Some(6));
        let (back, depth) = at(0.5, 0.45);
        assert_eq!(back, Some(2));
        // The back wall stands at z = 0, the eye at 295.6.
        assert!((depth.unwrap() - 295.6).abs() < 1.0, "{depth:?}");
        assert_eq!(at(1.5, 0.5), (None, None));
        assert_eq!(at(f32::NAN, 0.5), (None, None));
    }

    /// What the camera turns about and focuses on: a plane, not a ball about the eye.
    #[test]
    fn depths_are_along_the_view_and_points_on_the_line_of_sight() {
        let scene = files::builtin::scene("cornell").unwrap();
        let (width, height) = (scene.settings.width as f32, scene.settings.height as f32);
        let frame = scene.camera.frame(scene.settings.width, scene.settings.height);
        for [x, y] in [[0.02, 0.03], [0.97, 0.04], [0.05, 0.95], [0.9, 0.9], [0.5, 0.02]] {
            let Answer::Picked { point: Some(point), depth: Some(depth), .. } = pick(&scene, 1, [x, y])
            else {
                panic!("nothing at {x}, {y}");
            };
            let way = scene::Vec3::from(point) - scene.camera.eye;
            let along = way.dot(frame.forward);
            assert!((depth / along - 1.0).abs() < 1e-5, "{depth} for {along}");
            let [right, up] =
                [way.dot(frame.right), way.dot(frame.up)].map(|side| side / along / frame.pixel);
            assert!((right - (x - 0.5) * width).abs() < 0.01, "{right} at {x}");
            assert!((up - (0.5 - y) * height).abs() < 0.01, "{up} at {y}");
        }
    }

    /// The picture shows a moving ball all along its way; it is picked where its way begins.
    #[test]
    fn what_moves_is_picked_where_it_is_when_the_shutter_opens() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        let at = |scene: &Scene| match pick(scene, 1, [0.68, 0.75]) {
            Answer::Picked { sphere, .. } => sphere,
            _ => None,
        };
        let velocity = scene::Vec3::new(0.0, 40.0, 0.0);
        scene.camera.shutter = [1.0, 2.0];
        // When the shutter opens the ball is where it stood, and later it is away.
        scene.spheres[6].velocity = velocity;
        scene.spheres[6].center -= velocity;
        assert_eq!(at(&scene), Some(6));
        scene.camera.shutter = [0.0, 1.0];
        assert_ne!(at(&scene), Some(6));
    }

    #[test]
    fn the_sky_is_no_sphere_of_the_scene() {
        let scene = files::builtin::scene("terrace").unwrap();
        let Answer::Picked { sphere, .. } = pick(&scene, 1, [0.5, 0.01]) else { panic!("no answer") };
        assert_eq!(sphere, None);
    }
}
