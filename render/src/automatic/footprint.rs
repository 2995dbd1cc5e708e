//! How large a pixel is on the surfaces that it sees.

use fast::{Intersector, LaneKind};
use reference::camera_pass::ray_through;
use scene::{Ray, Scene, Settings, Vec3};

/// Rays along each side of the image, at most.
const MOST_ALONG_SIDE: u32 = 64;

/// The median, over the image, of a pixel's side on the first surface that it sees, if that scatters light; in scene units.
/// `None` if no pixel sees one.
///
/// Mirrors and glass count as they are: following rays to what is seen in them was tried, and gave worse radii.
pub(super) fn footprint(lanes: LaneKind, scene: &Scene, settings: &Settings) -> Option<f32> {
    let still = scene.at(scene.camera.shutter_time(settings.seed, 0));
    let hits = Intersector::new(&still, lanes).surfaces(&camera_rays(scene, settings));
    let lengths = hits.into_iter().flatten().filter(|hit| hit.albedo != Vec3::ZERO).map(|hit| hit.t);
    let pixel = scene.camera.frame(settings.width, settings.height).pixel;
    median(lengths.collect()).map(|length| length * pixel)
}

/// Rays from the centre of the lens, spread over the image.
fn camera_rays(scene: &Scene, settings: &Settings) -> Vec<Ray> {
    let frame = scene.camera.frame(settings.width, settings.height);
    let [columns, rows] = [settings.width, settings.height].map(|side| side.min(MOST_ALONG_SIDE));
    let place = |i: u32, of: u32, side: u32| (i as f32 + 0.5) * side as f32 / of as f32;
    let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    places
        .map(|(x, y)| (place(x, columns, settings.width), place(y, rows, settings.height)))
        .map(|place| ray_through(&frame, place, None))
        .collect()
}

fn median(mut lengths: Vec<f32>) -> Option<f32> {
    let middle = lengths.len() / 2;
    (middle < lengths.len()).then(|| *lengths.select_nth_unstable_by(middle, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{Camera, Material, Sphere};

    /// The inside of a ball of radius 10 from its centre, so that all is as far; the ball is of `material`.
    fn from_the_centre(material: Material) -> Scene {
        Scene {
            name: String::new(),
            camera: Camera { vertical_fov_degrees: 60.0, ..Camera::default() },
            materials: vec![material],
            spheres: vec![Sphere {
                center: Vec3::ZERO,
                velocity: Vec3::ZERO,
                radius: 10.0,
                material: 0,
                emission: Vec3::ZERO,
            }]
            .into(),
            background: Vec3::ZERO,
            transparent_background: false,
            settings: Settings { width: 100, height: 80, ..Settings::default() },
            imports: Vec::new(),
        }
    }

    /// At a distance of 10, 80 rows span twice the tangent of 30 degrees.
    #[test]
    fn a_footprint_is_a_pixel_at_the_distance_of_what_it_sees() {
        const ROUNDING: f32 = 1e-4;
        let exact = 10.0 * 2.0 / 3f32.sqrt() / 80.0;
        for material in [
            Material::Diffuse { albedo: Vec3::splat(0.5) },
            Material::Specular { albedo: Vec3::ONE },
            Material::Dielectric { albedo: Vec3::ONE, ior: 1.5 },
        ] {
            let scene = from_the_centre(material);
            let found = footprint(LaneKind::best(), &scene, &scene.settings).unwrap();
            assert!((found / exact - 1.0).abs() < ROUNDING, "{found} for {exact}");
        }
        // A ball just before the camera is seen by a few pixels of the middle.
        let mut scene = from_the_centre(Material::Diffuse { albedo: Vec3::splat(0.5) });
        let center = scene.camera.direction * 1.0;
        let near = Sphere { center, radius: 0.1, ..scene.spheres[0] };
        scene.spheres.push(near);
        let found = footprint(LaneKind::best(), &scene, &scene.settings).unwrap();
        assert!((found / exact - 1.0).abs() < ROUNDING, "{found} for {exact}");
        let black = from_the_centre(Material::Diffuse { albedo: Vec3::ZERO });
        assert_eq!(footprint(LaneKind::best(), &black, &black.settings), None);
    }

    /// The ball is around the camera while the shutter is open, and nowhere near it at time 0.
    #[test]
    fn a_footprint_is_on_what_is_there_when_the_shutter_is_open() {
        let mut scene = from_the_centre(Material::Diffuse { albedo: Vec3::splat(0.5) });
        let exact = footprint(LaneKind::best(), &scene, &scene.settings);
        assert!(exact.is_some());
        scene.camera.shutter = [5.0; 2];
        scene.spheres[0].velocity = Vec3::Y * 100.0;
        scene.spheres[0].center = Vec3::Y * -500.0;
        assert_eq!(footprint(LaneKind::best(), &scene, &scene.settings), exact);
    }

    /// Evenly over the image, from the middle of their parts, and at most so many along a side.
    #[test]
    fn rays_are_spread_over_the_image() {
        let scene = from_the_centre(Material::Diffuse { albedo: Vec3::splat(0.5) });
        for (width, height, count) in [(3, 2, 6), (64, 65, 64 * 64), (640, 2, 128)] {
            let settings = Settings { width, height, ..scene.settings };
            let rays = camera_rays(&scene, &settings);
            assert_eq!(rays.len(), count);
            let frame = scene.camera.frame(width, height);
            let (columns, rows) = (width.min(64) as f32, height.min(64) as f32);
            let through = |x: f32, y: f32| {
                ray_through(&frame, (x / columns * width as f32, y / rows * height as f32), None).direction
            };
            let corners = [through(0.5, 0.5), through(columns - 0.5, rows - 0.5)];
            for (ray, corner) in [rays[0], rays[count - 1]].iter().zip(corners) {
                assert!((ray.direction - corner).length() < 1e-6, "{width} x {height}");
            }
            assert!((rays[1].direction - through(1.5, 0.5)).length() < 1e-6, "{width} x {height}");
        }
    }

    #[test]
    fn a_median_is_the_upper_of_the_middle() {
        assert_eq!(median(Vec::new()), None);
        assert_eq!(
            [median(vec![3.0]), median(vec![5.0, 1.0, 3.0]), median(vec![4.0, 1.0, 3.0, 2.0])],
            [Some(3.0); 3]
        );
    }
}
