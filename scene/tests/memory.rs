//! Memory that the choice of first radii takes, and their limit by clearance, counted.

use peak_alloc::PeakAlloc;
use scene::clearance::{self, Clearance};
use scene::first_radii::{FirstRadii, bytes_at_most};
use scene::{Film, Rgb, Settings, Sphere, Stop, Vec3};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What is told may be so many times what is taken: a limit is to be kept, but not to keep anybody from what fits.
const TOLD_AT_MOST: f64 = 1.25;

/// One test, as memory is that of the whole process.
#[test]
fn first_radii_take_what_is_told() {
    pilots_take_what_is_told();
    clearance_takes_what_is_told();
}

fn pilots_take_what_is_told() {
    for (width, height) in [(1000, 750), (200, 150), (4000, 40)] {
        let settings = Settings { width, height, radius_pilots: 3, ..Settings::default() };
        let pilot = |pilot: &Settings, _: &Stop| {
            let pixel = |x: u32, y: u32| Rgb::splat(1.0 + (x * y % 7) as f32 * pilot.initial_radius);
            Some(Film::from_fn(pilot.width, pilot.height, pixel))
        };
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        assert!(FirstRadii::choose(&settings, &Stop::new(), pilot).is_some());
        let (taken, told) = (MEMORY.peak_usage() - before, bytes_at_most(&settings));
        let times = told as f64 / taken as f64;
        assert!(
            (1.0..TOLD_AT_MOST).contains(&times),
            "{width} x {height}: {taken} bytes, and {told} are told"
        );
    }
    assert_eq!(bytes_at_most(&Settings { radius_pilots: 0, ..Settings::default() }), 0);
}

/// The hierarchy of all spheres, which the first pixel that asks makes.
fn clearance_takes_what_is_told() {
    let spheres: Vec<Sphere> = (0..50_000)
        .map(|k| Sphere {
            center: Vec3::new((k % 37) as f32, (k / 37 % 41) as f32, (k / (37 * 41)) as f32),
            velocity: Vec3::ZERO,
            radius: 0.3,
            material: 0,
            emission: Rgb::ZERO,
        })
        .collect();
    let settings = Settings { radius_clearance: 0.7, ..Settings::default() };
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let clearance = Clearance::new(&settings).unwrap();
    assert!(clearance.limited(&spheres, (Vec3::splat(0.3), 0), 4.0) < 4.0);
    let (taken, told) = (MEMORY.peak_usage() - before, clearance::bytes_at_most(&settings, spheres.len()));
    let times = told as f64 / taken as f64;
    assert!((1.0..TOLD_AT_MOST).contains(&times), "{taken} bytes, and {told} are told");
}
