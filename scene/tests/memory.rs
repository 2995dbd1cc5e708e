//! Memory that the choice of first radii takes, counted.

use peak_alloc::PeakAlloc;
use scene::first_radii::{FirstRadii, bytes_at_most};
use scene::{Film, Rgb, Settings, Stop};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What is told may be so many times what is taken: a limit is to be kept, but not to keep anybody from what fits.
const TOLD_AT_MOST: f64 = 1.25;

#[test]
fn the_choice_of_first_radii_takes_what_is_told() {
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
