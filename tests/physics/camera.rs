//! The camera: projection, and the distribution of its rays over pixel, lens and exposure.

use crate::cases::tell;
use crate::harness::{
    BLACK, Build, SIGNIFICANCE, assert_uniform_square, chi_square_p, empty_scene, mean, pinhole, render_path,
    render_sppm, settings,
};
use glam::DVec3;
use reference::camera_pass::{CameraNumbers, camera_ray, ray_through};
use scene::{Camera, Film, Ray, Rgb, Settings, Vec3};

/// A camera without symmetry, so that swapped axes are noticed.
fn tilted() -> Camera {
    Camera {
        eye: Vec3::new(1.0, -2.0, 3.0),
        direction: Vec3::new(2.0, 1.0, -4.0),
        up: Vec3::new(0.3, 1.0, 0.2),
        ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 50.0)
    }
}

/// Forward, right and up of a camera by the textbook: right-handed, with up in the plane of the viewing direction and
/// the camera's `up`.
fn axes(camera: &Camera) -> [DVec3; 3] {
    let forward = camera.direction.as_dvec3().normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    [forward, right, right.cross(forward)]
}

/// The pinhole projection of a point, in pixels from the top left of the image.
fn project(camera: &Camera, point: DVec3, [width, height]: [u32; 2]) -> [f64; 2] {
    let [forward, right, up] = axes(camera);
    let v = point - camera.eye.as_dvec3();
    let half_height = f64::from(camera.vertical_fov_degrees / 2.0).to_radians().tan();
    let scale = 0.5 * f64::from(height) / half_height / v.dot(forward);
    [0.5 * f64::from(width) + v.dot(right) * scale, 0.5 * f64::from(height) - v.dot(up) * scale]
}

/// The centroid of light in an image of one lamp, in pixels from the top left.
fn centre_of_light(film: &Film) -> [f64; 2] {
    let (mut sum, mut at) = (0.0, [0.0; 2]);
    for (index, pixel) in film.pixels.iter().enumerate() {
        let place = [index as u32 % film.width, index as u32 / film.width].map(|i| f64::from(i) + 0.5);
        sum += f64::from(pixel.x);
        at = [0, 1].map(|i| at[i] + place[i] * f64::from(pixel.x));
    }
    at.map(|a| a / sum)
}

/// Tolerance in pixels. The centroid of a lamp with a radius of 1.6 pixels has noise of a few hundredths from its edge.
/// Its image is an ellipse, whose centre is up to 0.03 pixels from the image of its centre.
const CENTRE: f64 = 0.1;

#[test]
fn lamps_appear_where_the_pinhole_projects_them() {
    let (camera, size) = (tilted(), [60, 40]);
    let [forward, right, up] = axes(&camera);
    for (x, y) in [(0.0, 0.0), (2.0, 0.0), (-2.0, 0.0), (0.0, 1.4), (0.0, -1.4), (2.2, 1.2), (-1.0, -0.7)] {
        let point = camera.eye.as_dvec3() + forward * 4.0 + right * x + up * y;
        let scene = empty_scene(camera).lamp(point.as_vec3(), 0.15, BLACK, Rgb::ONE);
        let settings = Settings { iterations: 128, ..settings(size[0], size[1], 1, 1, 1.0) };
        let expected = project(&camera, point, size);
        for film in [render_sppm(&scene, &settings), render_path(&scene, &settings)] {
            let actual = centre_of_light(&film);
            let error = (actual[0] - expected[0]).hypot(actual[1] - expected[1]);
            assert!(error < CENTRE, "a lamp at {x}, {y} appears at {actual:?} instead of {expected:?}");
        }
    }
    tell("physics", 14, "lamps appear where they should");
}

#[test]
fn right_is_right_and_up_is_up() {
    // A check without formulas: the eye is at the origin and looks along -z, with y up.
    let camera = pinhole(Vec3::ZERO, Vec3::NEG_Z, 60.0);
    let scene = empty_scene(camera).lamp(Vec3::new(1.0, 0.5, -4.0), 0.2, BLACK, Rgb::X).lamp(
        Vec3::new(-1.0, -0.5, -4.0),
        0.2,
        BLACK,
        Rgb::Y,
    );
    let settings = Settings { iterations: 4, ..settings(32, 24, 1, 1, 1.0) };
    for film in [render_sppm(&scene, &settings), render_path(&scene, &settings)] {
        let quarter =
            |x: u32, y: u32| crate::harness::block_mean(&film, x * 16..(x + 1) * 16, y * 12..(y + 1) * 12);
        assert!(quarter(1, 0)[0] > 0.0 && quarter(0, 1)[1] > 0.0);
        assert_eq!((quarter(0, 0), quarter(1, 1)), ([0.0; 3], [0.0; 3]));
        assert_eq!((quarter(1, 0)[1], quarter(0, 1)[0]), (0.0, 0.0));
    }
}

/// Relative tolerance of image means for a lamp that covers a quarter of the pixels. The noise comes from its edge.
const AREA: f64 = 2e-3;

#[test]
fn the_field_of_view_is_vertical_and_in_degrees() {
    // A lamp in the middle appears as a disc of radius tan(asin(r / d)) at distance 1.
    for (fov, size) in [(20.0_f32, [90, 60]), (60.0, [60, 90]), (90.0, [120, 30])] {
        let half_height = f64::from(fov / 2.0).to_radians().tan();
        let shortest = half_height * f64::from(size[0].min(size[1])) / f64::from(size[1]);
        let tangent = 0.7 * shortest;
        let radius = tangent.atan().sin();
        let scene =
            empty_scene(pinhole(Vec3::ZERO, Vec3::X, fov)).lamp(Vec3::X, radius as f32, BLACK, Rgb::ONE);
        let settings = Settings { iterations: 64, ..settings(size[0], size[1], 1, 1, 1.0) };
        let [width, height] = size.map(|side| f64::from(side) * 2.0 * half_height / f64::from(size[1]));
        let expected = std::f64::consts::PI * tangent * tangent / (width * height);
        for film in [render_sppm(&scene, &settings), render_path(&scene, &settings)] {
            let actual = mean(&film)[0];
            assert!((actual / expected - 1.0).abs() < AREA, "{fov} degrees: {actual} instead of {expected}");
        }
    }
}

const SIDE: u32 = 64;

/// The camera rays of all pixels over several iterations, with their pixels.
fn rays(camera: &Camera, iterations: u32) -> impl Iterator<Item = ([u32; 2], Ray)> {
    rays_of(camera, iterations, (0..SIDE * SIDE).map(|index| [index % SIDE, index / SIDE]).collect())
}

fn rays_of(camera: &Camera, iterations: u32, pixels: Vec<[u32; 2]>) -> impl Iterator<Item = ([u32; 2], Ray)> {
    let frame = camera.frame(SIDE, SIDE);
    let settings = settings(SIDE, SIDE, 1, 1, 1.0);
    (0..iterations).flat_map(move |iteration| {
        let of_pixel = move |[x, y]: [u32; 2]| {
            let numbers = CameraNumbers::new(&settings, iteration, x, y);
            ([x, y], camera_ray(&frame, None, x, y, &numbers).0)
        };
        pixels.clone().into_iter().map(of_pixel)
    })
}

/// Tolerance in pixels: coordinates of up to 64, from directions with a dozen rounding errors.
const PLACE: f64 = 1e-4;

#[test]
fn rays_are_spread_evenly_over_their_pixel() {
    let camera = tilted();
    let eye = camera.eye.as_dvec3();
    let points = rays(&camera, 64).map(|(pixel, ray)| {
        let place = project(&camera, eye + ray.direction.as_dvec3(), [SIDE; 2]);
        [0, 1].map(|i| {
            let within = place[i] - f64::from(pixel[i]);
            assert!((-PLACE..1.0 + PLACE).contains(&within), "pixel {pixel:?} is seen at {place:?}");
            within.clamp(0.0, 1.0 - f64::EPSILON)
        })
    });
    // Stratified points are more even than random ones, so this only tests that they are not less even.
    assert_uniform_square(points, [16, 16], "places in the pixel");
    tell("physics", 64 * 64 * 64, "camera rays in their pixels");
}

#[test]
fn rays_of_one_pixel_are_spread_evenly_over_the_iterations() {
    const ITERATIONS: u32 = 1024;
    // With random points, the count of a cell would have a standard deviation of 4.
    const FROM_SIXTEEN: i32 = 6;
    let camera = tilted();
    let eye = camera.eye.as_dvec3();
    for pixel in [[0, 0], [13, 50], [63, 31]] {
        let mut cells = [0; 64];
        for (_, ray) in rays_of(&camera, ITERATIONS, vec![pixel]) {
            let place = project(&camera, eye + ray.direction.as_dvec3(), [SIDE; 2]);
            let [column, row] =
                [0, 1].map(|i| ((place[i] - f64::from(pixel[i])) * 8.0).clamp(0.0, 7.0) as usize);
            cells[8 * row + column] += 1;
        }
        let furthest = cells.iter().map(|count| (count - 16_i32).abs()).max().unwrap();
        assert!(furthest <= FROM_SIXTEEN, "pixel {pixel:?}: {cells:?}");
    }
    tell("physics", 3 * 64, "cells of a pixel");
}

/// Of the four pixels of a block, one has its place in each quarter of the pixel along either axis, and of sixteen one in each
/// sixteenth. So an image that is made smaller is smoother.
#[test]
fn places_of_a_block_of_pixels_are_spread_evenly() {
    /// Rows and columns of blocks with a place that is rounded over a border.
    const ROUNDED: usize = 20;
    let camera = tilted();
    let eye = camera.eye.as_dvec3();
    let mut places = vec![[0.0; 2]; (SIDE * SIDE) as usize];
    for (pixel, ray) in rays(&camera, 1) {
        let place = project(&camera, eye + ray.direction.as_dvec3(), [SIDE; 2]);
        places[(pixel[1] * SIDE + pixel[0]) as usize] = [0, 1].map(|i| place[i] - f64::from(pixel[i]));
    }
    for side in [2, 4] {
        let count = side * side;
        let corners = (0..SIDE * SIDE).map(|index| (index % SIDE, index / SIDE));
        let corners = corners.filter(|(x, y)| x % side == 0 && y % side == 0);
        let is_uneven = |(x, y): (u32, u32), axis: usize| {
            let mut seen = vec![false; count as usize];
            for pixel in 0..count {
                let at = (y + pixel / side) * SIDE + x + pixel % side;
                let class = (places[at as usize][axis] * f64::from(count)).max(0.0) as usize;
                let last = seen.len() - 1;
                seen[class.min(last)] = true;
            }
            seen.contains(&false)
        };
        let uneven = corners.flat_map(|corner| [0, 1].map(|axis| is_uneven(corner, axis)));
        let uneven = uneven.filter(|is_uneven| *is_uneven).count();
        assert!(uneven <= ROUNDED, "{uneven} rows and columns of blocks of side {side}");
    }
    tell("physics", 5 * 512, "rows and columns of blocks of pixels");
}

#[test]
fn each_tile_and_iteration_has_places_of_its_own() {
    // Image sides that are not multiples of a tile's side; a wide and a tall image.
    let camera = tilted();
    let mut cases = 0;
    for size in [[20, 44], [44, 20]] {
        let [width, height] = size;
        let (frame, settings) = (camera.frame(width, height), settings(width, height, 1, 1, 1.0));
        let tiles = (0..height).step_by(8).flat_map(|y| (0..width).step_by(8).map(move |x| [x, y]));
        let mut places: Vec<[i32; 2]> = tiles
            .flat_map(|tile| (0..3).map(move |iteration| (tile, iteration)))
            .map(|([x, y], iteration)| {
                let numbers = CameraNumbers::new(&settings, iteration, x, y);
                let direction = camera_ray(&frame, None, x, y, &numbers).0.direction.as_dvec3();
                let place = project(&camera, camera.eye.as_dvec3() + direction, size);
                [place[0] - f64::from(x), place[1] - f64::from(y)].map(|v| (v * 1024.0) as i32)
            })
            .collect();
        let count = places.len();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), count, "tiles of {width} x {height} share a place");
        cases += count;
    }
    tell("physics", cases, "places of tiles");
}

/// Rays must start at uniformly distributed points of the lens. In the focal plane they must be within their pixel.
#[test]
fn rays_are_spread_evenly_over_the_lens_and_meet_in_focus() {
    let (aperture, focus) = (0.25_f32, 7.0_f32);
    let camera = Camera { aperture_radius: aperture, focus_distance: focus, ..tilted() };
    let [forward, right, up] = axes(&camera);
    let eye = camera.eye.as_dvec3();
    let lens = rays(&camera, 64).map(|(pixel, ray)| {
        let (from_eye, direction) = (ray.origin.as_dvec3() - eye, ray.direction.as_dvec3());
        assert!(from_eye.dot(forward).abs() < 1e-6, "a ray leaves off the lens");
        // A pinhole would see the point at which the ray meets the focal plane in the same pixel.
        let in_focus = ray.origin.as_dvec3()
            + direction * (f64::from(focus) - from_eye.dot(forward)) / direction.dot(forward);
        let place = project(&camera, in_focus, [SIDE; 2]);
        for (at, pixel) in place.into_iter().zip(pixel) {
            let within = at - f64::from(pixel);
            assert!((-PLACE..1.0 + PLACE).contains(&within), "pixel {pixel:?} is focused at {place:?}");
        }
        let [x, y] = [right, up].map(|axis| from_eye.dot(axis) / f64::from(aperture));
        let angle = y.atan2(x) / std::f64::consts::TAU;
        [(x * x + y * y).clamp(0.0, 1.0 - f64::EPSILON), (angle + 1.0).fract()]
    });
    assert_uniform_square(lens, [16, 16], "points of the lens");
}

/// As the places in the pixel are.
#[test]
fn places_of_one_pixel_on_the_lens_are_spread_evenly_over_the_iterations() {
    const ITERATIONS: u32 = 1024;
    // With random points, the count of a cell would have a standard deviation of 4, so the furthest of 64 would be off by 10.
    const FROM_SIXTEEN: i32 = 6;
    let camera = Camera { aperture_radius: 1.0, focus_distance: 5.0, ..tilted() };
    let [_, right, up] = axes(&camera);
    for pixel in [[0, 0], [13, 50], [63, 31]] {
        let mut cells = [0; 64];
        for (_, ray) in rays_of(&camera, ITERATIONS, vec![pixel]) {
            let from_eye = (ray.origin - camera.eye).as_dvec3();
            let [x, y] = [right, up].map(|axis| from_eye.dot(axis));
            let turn = (y.atan2(x) / std::f64::consts::TAU + 1.0).fract();
            let [ring, sector] = [x * x + y * y, turn].map(|v| (v * 8.0).clamp(0.0, 7.0) as usize);
            cells[8 * ring + sector] += 1;
        }
        let furthest = cells.iter().map(|count| (count - 16_i32).abs()).max().unwrap();
        assert!(furthest <= FROM_SIXTEEN, "pixel {pixel:?}: {cells:?}");
    }
    tell("physics", 3 * 64, "cells of a lens");
}

#[test]
fn the_places_in_the_pixel_and_on_the_lens_are_independent() {
    let camera =
        Camera { aperture_radius: 1.0, focus_distance: 1.0, ..pinhole(Vec3::ZERO, Vec3::NEG_Z, 90.0) };
    // The pixels of a tile share their random shifts, so use one pixel of each tile, which are independent.
    let pixels: Vec<_> = (0..64).map(|tile| [tile % 8 * 8 + 3, tile / 8 * 8 + 6]).collect();
    for axis in [0, 1] {
        let points = rays_of(&camera, 1024, pixels.clone()).map(|(pixel, ray)| {
            let in_focus = ray.origin + ray.direction / -ray.direction.z;
            let place = [in_focus.x, -in_focus.y].map(|v| f64::from(v) * 32.0 + 32.0);
            let within = (place[axis] - f64::from(pixel[axis])).clamp(0.0, 1.0 - f64::EPSILON);
            let angle = f64::from(ray.origin.y).atan2(f64::from(ray.origin.x)) / std::f64::consts::TAU;
            [within, (angle + 1.0).fract()]
        });
        assert_uniform_square(points, [16, 16], "pixel against lens");
    }
}

#[test]
fn the_lens_is_used_only_where_there_is_one() {
    let frame = tilted().frame(8, 8);
    assert_eq!(ray_through(&frame, (3.0, 4.0), None).origin, frame.eye);
    assert!(rays(&tilted(), 1).all(|(_, ray)| ray.origin == frame.eye));
}

#[test]
fn shutter_times_are_spread_evenly_over_the_exposure_for_any_seed() {
    let camera = Camera { shutter: [-1.0, 3.0], ..tilted() };
    // This tests the random shift, by one iteration of many seeds. The sequence over the iterations is tested
    // elsewhere.
    for iteration in [0, 1, 2, 1000] {
        let mut counts = vec![0; 256];
        for seed in 0..1 << 16 {
            let time = camera.shutter_time(seed, iteration);
            assert!((-1.0..3.0).contains(&time));
            counts[((time + 1.0) * 64.0) as usize] += 1;
        }
        let p = chi_square_p(&counts);
        assert!(p > SIGNIFICANCE, "iteration {iteration}: p = {p:.1e}");
    }
    let closed = Camera { shutter: [0.5, 0.5], ..tilted() };
    assert!((0..100).all(|i| closed.shutter_time(i, i as u32) == 0.5));
}
