//! How often pictures are shown, and how small they are while the camera moves.

use scene::Settings;
use std::time::{Duration, Instant};

/// While the camera moves, a picture is to take about this long.
const TARGET: f64 = 1.0 / 30.0;
/// The long side of a picture is at least this many pixels, however slow the scene.
const LEAST_SIDE: f64 = 128.0;
/// Photons of a picture while the camera moves, at most and at least.
const PREVIEW_PHOTONS: [u32; 2] = [1_000, 20_000];
/// The search radius is widened by at most this, to smooth the light of fewer photons.
const MOST_WIDENING: f32 = 3.0;

/// The time from one picture to the next, when the camera has been at rest for `rest`.
fn interval(rest: Duration) -> Duration {
    let milliseconds = match rest.as_secs_f64() {
        seconds if seconds < 1.0 => 100,
        seconds if seconds < 5.0 => 250,
        seconds if seconds < 15.0 => 500,
        seconds if seconds < 60.0 => 1000,
        _ => 2000,
    };
    Duration::from_millis(milliseconds)
}

/// When the next picture is due, by what pictures cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Schedule {
    began: Instant,
    shown: Option<Instant>,
    cost: Duration,
    /// Pictures take at most this share of the time,
    share: f64,
    /// after so much time.
    free: Duration,
}

impl Schedule {
    /// A schedule that begins now. Pictures take at most this `share` of the time, after the time that is `free`.
    pub(crate) fn new(share: f64, free: Duration) -> Self {
        Self { began: Instant::now(), shown: None, cost: Duration::ZERO, share, free }
    }

    /// Whether a picture is due.
    pub(crate) fn is_due(&self) -> bool {
        let rest = self.began.elapsed();
        let least = if rest < self.free { Duration::ZERO } else { self.cost.div_f64(self.share) };
        self.shown.is_none_or(|at| at.elapsed() >= interval(rest).max(least))
    }

    /// Shows a picture by `show`, and notes what it costs.
    pub(crate) fn show<T>(&mut self, show: impl FnOnce() -> T) -> T {
        let began = Instant::now();
        let shown = show();
        (self.shown, self.cost) = (Some(Instant::now()), began.elapsed());
        shown
    }
}

/// The factor by which pictures are smaller while the camera moves. It follows the time that they take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Divisor(f64);

impl Default for Divisor {
    fn default() -> Self {
        Self(4.0)
    }
}

impl Divisor {
    /// Learns from a picture that took so long, to be rendered or else to be sent and drawn: a page draws one while the next is
    /// rendered.
    pub(crate) fn learn(&mut self, taken: Duration) {
        // The time is about proportional to the number of pixels. Half a step at a time keeps the size from jumping.
        let wanted = self.0 * (taken.as_secs_f64() / TARGET).sqrt();
        self.0 = (0.5 * (self.0 + wanted)).clamp(1.0, 64.0);
    }

    /// The settings of a picture of reduced size.
    pub(crate) fn reduce(self, whole: &Settings) -> Settings {
        let long = f64::from(whole.width.max(whole.height));
        let divisor = self.0.min(long / LEAST_SIDE).max(1.0);
        // Sizes are whole eighths of the image where that is possible, as they should not change with every picture.
        let divisor = 8.0 / (8.0 / divisor).round().clamp(1.0, 8.0);
        let divisor = divisor.min(long / LEAST_SIDE).max(1.0);
        let side = |side: u32| ((f64::from(side) / divisor).round() as u32).max(1);
        let share = (f64::from(whole.photons_per_iteration) / (divisor * divisor)) as u32;
        let [least, most] = PREVIEW_PHOTONS;
        let photons = share.clamp(least, most).min(whole.photons_per_iteration);
        let thinning = (whole.photons_per_iteration as f32 / photons as f32).sqrt();
        let initial_radius = whole.initial_radius * thinning.min(MOST_WIDENING);
        let (width, height) = (side(whole.width), side(whole.height));
        let reduced = Settings { width, height, photons_per_iteration: photons, initial_radius, ..*whole };
        if reduced.validate().is_ok() { reduced } else { *whole }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_scenes_get_smaller_pictures_and_quick_ones_larger() {
        let whole = Settings::default();
        let mut divisor = Divisor::default();
        for _ in 0..20 {
            divisor.learn(Duration::from_secs(1));
        }
        let small = divisor.reduce(&whole);
        assert_eq!((small.width, small.height), (128, 96));
        for _ in 0..20 {
            divisor.learn(Duration::from_millis(1));
        }
        let large = divisor.reduce(&whole);
        assert_eq!((large.width, large.height), (512, 384));
        assert!(large.photons_per_iteration <= 20_000);
    }

    /// Half the side is a quarter of the pixels: of as many photons for each, and as many of them at each visible point.
    #[test]
    fn small_pictures_have_photons_by_their_area_and_radii_for_these() {
        let whole = Settings { photons_per_iteration: 40_000, initial_radius: 1.5, ..Settings::default() };
        let half = Divisor(2.0).reduce(&whole);
        assert_eq!((half.width, half.height), (whole.width / 2, whole.height / 2));
        assert_eq!((half.photons_per_iteration, half.initial_radius), (10_000, 3.0));
        let most = Settings { photons_per_iteration: 1 << 24, ..whole };
        let quarter = Divisor(4.0).reduce(&most);
        assert_eq!((quarter.photons_per_iteration, quarter.initial_radius), (20_000, 1.5 * MOST_WIDENING));
        assert_eq!(
            Divisor(1.0).reduce(&Settings { photons_per_iteration: 9000, ..whole }).initial_radius,
            1.5
        );
    }

    #[test]
    fn no_image_is_too_small_or_too_narrow() {
        for (width, height) in [(1, 1), (100, 3), (1, 5000), (1 << 20, 1)] {
            let whole = Settings { width, height, photons_per_iteration: 5, ..Settings::default() };
            let reduced = Divisor(64.0).reduce(&whole);
            assert!(reduced.validate().is_ok());
            assert!(reduced.width <= width && reduced.height <= height, "{reduced:?}");
            assert!(reduced.width.max(reduced.height) >= width.max(height).min(128));
            assert_eq!(reduced.photons_per_iteration, 5);
        }
    }

    #[test]
    fn costly_pictures_are_rarer_after_a_second() {
        let mut schedule = Schedule::new(0.01, Duration::from_secs(1));
        assert!(schedule.is_due());
        schedule.show(|| ());
        assert!(!schedule.is_due());
        let ago = |seconds| Instant::now().checked_sub(Duration::from_secs(seconds)).unwrap();
        (schedule.cost, schedule.shown) = (Duration::from_millis(50), Some(ago(3)));
        assert!(schedule.is_due());
        schedule.began = ago(4);
        assert!(!schedule.is_due());
        schedule.shown = Some(ago(6));
        assert!(schedule.is_due());
    }

    #[test]
    fn pictures_become_rarer() {
        let at = |seconds| interval(Duration::from_secs(seconds)).as_millis();
        assert_eq!([0, 1, 5, 15, 60, 10_000].map(at), [100, 250, 500, 1000, 2000, 2000]);
    }
}
