//! Images with alpha in place of the background.

use crate::images::Asks;
use exr::prelude::read_first_rgba_layer_from_file;
use render::{EngineChoice, EngineName, Every, Job, MethodName, Renderer, Save, merge};
use scene::{Camera, Film, Filter, Material, RadiusSchedule, Rgb, Rgba, Scene, Settings, Sphere, Vec3};
use std::path::Path;
use std::sync::mpsc::channel;
use tempfile::TempDir;

/// Difference of two sums of the same rounded samples in another order, relative to the brightest pixels, which are 2.
const ROUNDING: f32 = 1e-5;

const CLEAR: Material = Material::Dielectric { albedo: Rgb::ONE, ior: 1.5 };

fn ball(x: f32, radius: f32, material: u32) -> Sphere {
    Sphere { center: Vec3::X * x, velocity: Vec3::ZERO, radius, material, emission: Rgb::ZERO }
}

/// Balls before an eye at (0, 0, 10) that looks at the origin.
fn scene_of(spheres: Vec<Sphere>, materials: Vec<Material>, settings: Settings) -> Scene {
    let camera = Camera {
        eye: Vec3::Z * 10.0,
        direction: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov_degrees: 30.0,
        ..Camera::default()
    };
    let scene = Scene {
        name: "balls".into(),
        camera,
        materials,
        spheres: spheres.into(),
        background: Rgb::new(0.5, 1.0, 2.0),
        transparent_background: true,
        settings,
        imports: Vec::new(),
    };
    scene.with_sky()
}

/// A matte ball, one of glass, a mirror, and a lamp within the picture.
fn balls() -> Scene {
    let materials = vec![
        Material::Diffuse { albedo: Rgb::splat(0.7) },
        CLEAR,
        Material::Specular { albedo: Rgb::splat(0.9) },
    ];
    let lamp = Sphere { center: Vec3::new(0.0, 2.0, -3.0), emission: Rgb::splat(5.0), ..ball(0.0, 0.4, 0) };
    let settings = Settings {
        width: 48,
        height: 32,
        iterations: 6,
        photons_per_iteration: 2000,
        max_depth: 8,
        initial_radius: 0.3,
        ..Settings::default()
    };
    scene_of(vec![ball(-2.0, 0.9, 0), ball(0.0, 0.9, 1), ball(2.0, 0.9, 2), lamp], materials, settings)
}

fn choice(method: MethodName, engine: EngineName) -> EngineChoice {
    EngineChoice::new(Renderer { method, engine }, None).unwrap()
}

fn job(scene: Scene, engine: EngineChoice, image: &Path) -> Job {
    let mut job = Job::new(scene);
    (job.engine, job.threads, job.outputs.image) = (engine, Some(2), Some(image.into()));
    job
}

/// The image with alpha that a job writes to an EXR file, and the image without.
fn rendered(scene: Scene, engine: EngineChoice) -> (Vec<Rgba>, Film) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.exr");
    let outcome = job(scene, engine, &path).start(()).unwrap().wait().unwrap();
    assert!(outcome.failed.is_empty(), "{:?}", outcome.failed);
    (read(&path), outcome.last.unwrap().film.clone())
}

/// The pixels of an EXR file with alpha.
fn read(path: &Path) -> Vec<Rgba> {
    let rows = |size: exr::prelude::Vec2<usize>, _: &_| (size.width(), vec![]);
    let push = |(_, pixels): &mut (usize, Vec<Rgba>), _, (r, g, b, alpha): (f32, f32, f32, f32)| {
        pixels.push(Rgba { color: Rgb::new(r, g, b), alpha });
    };
    read_first_rgba_layer_from_file(path, rows, push).unwrap().layer_data.channel_data.pixels.1
}

fn bits(pixels: &[Rgba]) -> Vec<[u32; 4]> {
    let samples = |p: &Rgba| [p.color.x, p.color.y, p.color.z, p.alpha].map(f32::to_bits);
    pixels.iter().map(samples).collect()
}

#[test]
fn over_its_background_an_image_is_as_without_alpha() {
    for method in MethodName::ALL {
        let scene = balls();
        let background = scene.background;
        let (pixels, film) = rendered(scene, choice(method, EngineName::Fast));
        for (Rgba { color, alpha }, whole) in pixels.iter().zip(&film.pixels) {
            let over = *color + background * (1.0 - alpha);
            assert!((over - *whole).abs().max_element() < ROUNDING, "{color} {alpha}: {over}, not {whole}");
            assert!(color.min_element() >= 0.0 && (0.0..=1.0).contains(alpha), "{color} {alpha}");
        }
        // In a corner there is nothing, and the middle of the matte ball and of the mirror are whole.
        let at = |x: usize| pixels[16 * 48 + x];
        assert_eq!(pixels[0], Rgba { color: Rgb::ZERO, alpha: 0.0 });
        assert!([12, 36].iter().all(|x| at(*x).alpha == 1.0 && at(*x).color.min_element() > 0.1));
        // Glass shows what is behind it.
        assert!(at(24).alpha < 0.1, "{:?}", at(24));
    }
}

/// An observer gets them with the whole image, which shows the background.
#[test]
fn an_observer_gets_the_pixels_of_the_file() {
    let (sender, images) = channel();
    let (pixels, film) = rendered(balls(), EngineChoice::default());
    Job::new(balls()).start(Asks::new(2, sender)).unwrap().wait().unwrap();
    let images: Vec<_> = images.iter().collect();
    let [early, last] = images.as_slice() else { panic!("{} images", images.len()) };
    assert!(last.film == film && last.transparent.as_deref().map(bits) == Some(bits(&pixels)));
    let mut scene = balls();
    scene.settings.iterations = 2;
    let (pixels, _) = rendered(scene, EngineChoice::default());
    assert!(early.transparent.as_deref().map(bits) == Some(bits(&pixels)));
}

/// As of a render that ends there, and not of the iteration before.
#[test]
fn snapshots_have_the_alpha_of_their_iteration() {
    let folder = TempDir::new().unwrap();
    let of = |iterations| {
        let scene = balls();
        Scene { settings: Settings { iterations, ..scene.settings }, ..scene }
    };
    let mut job = job(of(2), EngineChoice::default(), &folder.path().join("image.exr"));
    job.outputs.snapshots = true;
    job.start(()).unwrap().wait().unwrap();
    for iterations in [1, 2] {
        let snapshot = bits(&read(&folder.path().join(format!("image-000{iterations}.exr"))));
        assert!(snapshot == bits(&rendered(of(iterations), EngineChoice::default()).0), "after {iterations}");
    }
}

#[test]
fn engines_agree_on_alpha_bit_by_bit() {
    for method in MethodName::ALL {
        for filter in [Filter::Box, Filter::Mitchell] {
            let mut scene = balls();
            scene.settings = Settings { filter, iterations: 3, ..scene.settings };
            let [fast, reference] = [EngineName::Fast, EngineName::Reference]
                .map(|engine| bits(&rendered(scene.clone(), choice(method, engine)).0));
            assert!(fast == reference, "{method:?} {filter:?}");
        }
    }
}

/// The silhouette of a sphere of radius r at distance d is a cone whose sine is r/d: a disc of radius r / sqrt(d^2 - r^2) at
/// distance 1.
#[test]
fn alpha_is_the_share_of_a_pixel_that_a_disc_covers() {
    const STEPS: u32 = 64;
    /// Stratified samples of an edge miss its share by less than those at random, whose standard deviation is at most a half
    /// over the root of their number; this is four of them.
    const NOISE: f64 = 4.0 * 0.5 / 16.0;
    let settings = Settings { width: 40, height: 40, iterations: 256, ..Settings::default() };
    let scene = scene_of(vec![ball(0.0, 2.0, 0)], vec![Material::Diffuse { albedo: Rgb::ONE }], settings);
    let (pixels, _) = rendered(scene, choice(MethodName::Path, EngineName::Fast));
    let half = (15.0_f64).to_radians().tan();
    let radius = 2.0 / (100.0 - 4.0_f64).sqrt() * 20.0 / half;
    let share = |x: u32, y: u32| {
        let place =
            |pixel: u32, step: u32| f64::from(pixel) + (f64::from(step) + 0.5) / f64::from(STEPS) - 20.0;
        let inside = |i: &u32| place(x, i % STEPS).hypot(place(y, i / STEPS)) < radius;
        (0..STEPS * STEPS).filter(inside).count() as f64 / f64::from(STEPS * STEPS)
    };
    let mut area = 0.0;
    for (number, Rgba { alpha, .. }) in (0..).zip(&pixels) {
        let exact = share(number % 40, number / 40);
        let alpha = f64::from(*alpha);
        assert!((alpha - exact).abs() < NOISE, "pixel {number}: {alpha} instead of {exact}");
        assert!((exact > 0.0 && exact < 1.0) || alpha == exact, "pixel {number}: {alpha} instead of {exact}");
        area += alpha;
    }
    // Errors of some hundred edges cancel.
    let exact = std::f64::consts::PI * radius * radius;
    assert!((area / exact - 1.0).abs() < 0.002, "{area} instead of {exact}");
}

/// Light passes two surfaces of a ball of smoked glass, each of which takes half of it.
#[test]
fn smoked_glass_covers_what_it_absorbs() {
    let smoked = Material::Dielectric { albedo: Rgb::splat(0.5), ior: 1.0 };
    let settings = Settings { width: 16, height: 12, iterations: 2, ..Settings::default() };
    let (pixels, _) =
        rendered(scene_of(vec![ball(0.0, 2.0, 0)], vec![smoked], settings), EngineChoice::default());
    let middle = pixels[6 * 16 + 8];
    assert!((middle.alpha - 0.75).abs() < ROUNDING && middle.color == Rgb::ZERO, "{middle:?}");
}

#[test]
fn a_background_that_nothing_sees_leaves_an_image_whole() {
    let mut scene = crate::small(2);
    scene.transparent_background = true;
    let (pixels, film) = rendered(scene, EngineChoice::default());
    for (pixel, whole) in pixels.iter().zip(film.pixels) {
        assert_eq!(*pixel, Rgba { color: whole, alpha: 1.0 });
    }
}

#[test]
fn alpha_is_the_same_after_a_pause_and_of_parts() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    for radius_schedule in RadiusSchedule::ALL {
        let of = |iterations| {
            let scene = balls();
            let settings = Settings { radius_schedule, iterations, ..scene.settings };
            Scene { settings, ..scene }
        };
        let whole = bits(&rendered(of(6), EngineChoice::default()).0);
        let mut first = job(of(2), EngineChoice::default(), &path("paused.exr"));
        let (save, every) = (path(&format!("{radius_schedule}.sppm")), Every::default());
        first.save = Some(Save { path: save.clone(), every, keep: true });
        first.start(()).unwrap().wait().unwrap();
        let mut rest = Job::resume(&save).unwrap();
        rest.scene.settings.iterations = 6;
        rest.start(()).unwrap().wait().unwrap();
        assert!(bits(&read(&path("paused.exr"))) == whole, "{radius_schedule:?}");
        // A complete render has it without another iteration.
        let mut complete = Job::resume(&save).unwrap();
        assert_eq!(complete.scene.settings.iterations, 6);
        complete.outputs.image = Some(path("complete.exr"));
        complete.start(()).unwrap().wait().unwrap();
        assert!(bits(&read(&path("complete.exr"))) == whole, "{radius_schedule:?}");
        if radius_schedule == RadiusSchedule::Global {
            let parts = [0..2, 2..6].map(|range| {
                let save = path(&format!("part{}.sppm", range.start));
                let mut part = Job::new(of(6));
                (part.range, part.save) = (Some(range), Some(Save { path: save.clone(), every, keep: true }));
                part.start(()).unwrap().wait().unwrap();
                save
            });
            merge::Merge::open(&parts).unwrap().write(&path("merged.exr")).unwrap();
            assert!(bits(&read(&path("merged.exr"))) == whole);
            let merge = merge::Merge::open(&parts).unwrap();
            let refused = merge.write(&path("merged.jpg")).unwrap_err().to_string();
            assert!(refused.contains("have no alpha") && !path("merged.jpg").exists(), "{refused}");
            // Alpha is a mean over iterations: of the first two, of the last four, and of all.
            let [first, last] = [&parts[..1], &parts[1..]].map(|part| {
                merge::Merge::open(part).unwrap().write(&path("some.exr")).unwrap();
                read(&path("some.exr"))
            });
            let all = read(&path("merged.exr"));
            for ((first, last), all) in first.iter().zip(&last).zip(&all) {
                let mean = (2.0 * first.alpha + 4.0 * last.alpha) / 6.0;
                assert!((mean - all.alpha).abs() < ROUNDING, "{mean}, not {}", all.alpha);
            }
        }
    }
}

#[test]
fn formats_without_alpha_are_refused() {
    for name in ["image.jpg", "image.pfm", "image.hdr"] {
        let error = job(balls(), EngineChoice::default(), Path::new(name)).start(()).unwrap_err().to_string();
        assert!(error.contains("have no alpha") && error.contains(name), "{error}");
    }
}
