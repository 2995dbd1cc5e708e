//! The settings of a render, with bounds that keep its memory reasonable and its integers from overflowing.

use crate::filter::Filter;
use crate::radius_schedule::RadiusSchedule;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The parameters of a render. Together with the scene they determine every bit of the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Width of the image in pixels.
    pub width: u32,
    /// Height of the image in pixels.
    pub height: u32,
    /// Iterations of SPPM; for the path tracer, samples per pixel.
    pub iterations: u32,
    /// Photons that leave the lights in each iteration.
    pub photons_per_iteration: u32,
    /// The maximal number of path segments from the eye to the first diffuse hit, and again from there to the light.
    pub max_depth: u32,
    /// Radius of the first iteration's density estimate, in scene units.
    pub initial_radius: f32,
    /// Seed of every random stream.
    pub seed: u64,
    /// How a pixel averages the light around it.
    #[serde(default)]
    pub filter: Filter,
    /// How the search radius shrinks; nothing to the path tracer.
    #[serde(default)]
    pub radius_schedule: RadiusSchedule,
    /// Iterations of each of the eight small renders by which the first radius of every pixel is chosen, from
    /// `initial_radius` down to an eighth of it ([`FirstRadii`](crate::FirstRadii)). If 0, all pixels begin with
    /// `initial_radius`; nothing to the path tracer.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius_pilots: u32,
    /// While a pixel has gathered no photon, its radius is at most so many times as far as the nearest other sphere is from
    /// what it sees, but no less than an eighth of `initial_radius`, and a third where that sphere is a wall around it
    /// ([`Clearance`](crate::Clearance)). If 0, radii have no such limit; nothing to the path tracer.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub radius_clearance: f32,
    /// Shadow rays that each path from the eye sends from its first diffuse surface: direct light there is their mean. More
    /// of them lessen the noise of direct light, for the time that they take.
    #[serde(default = "one")]
    pub light_samples: u32,
    /// Rays by which a pixel sees lamps in place of its path if it shows the rim of one ([`Rims`](crate::Rims)), or if its path first
    /// meets a mirror or glass: their mean lessens the noise of lamps that look smaller than a pixel. If 1, the path itself sees
    /// them.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub glint_samples: u32,
}

fn one() -> u32 {
    1
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_zero(number: &u32) -> bool {
    *number == 0
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_one(number: &u32) -> bool {
    *number == 1
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_nothing(number: &f32) -> bool {
    *number == 0.0
}

impl Default for Settings {
    /// The settings of the paper (section 4).
    fn default() -> Self {
        Self {
            width: 512,
            height: 384,
            iterations: 6,
            photons_per_iteration: 200_000,
            max_depth: 5,
            initial_radius: 2.0,
            seed: 1,
            filter: Filter::Box,
            radius_schedule: RadiusSchedule::PerPixel,
            radius_pilots: 0,
            radius_clearance: 0.0,
            light_samples: 1,
            glint_samples: 1,
        }
    }
}

/// Most pixels of an image.
pub const MAX_PIXELS: u64 = 1 << 28;
/// Most pixels of a side.
pub const MAX_SIDE: u32 = 1 << 20;
/// Most iterations: iteration numbers enter the random keys as 32 bits.
pub const MAX_ITERATIONS: u32 = 1 << 30;
/// Most photons of an iteration.
pub const MAX_PHOTONS: u32 = 1 << 28;
/// Most iterations of a small render by which radii are chosen.
pub const MAX_RADIUS_PILOTS: u32 = 1 << 12;
/// The range of [`Settings::radius_clearance`], if it is not 0.
pub const RADIUS_CLEARANCE_RANGE: [f32; 2] = [1e-3, 1e3];
/// Most shadow rays from a point.
pub const MAX_LIGHT_SAMPLES: u32 = 16;
/// Most rays through a pixel that see lamps.
pub const MAX_GLINT_SAMPLES: u32 = 64;
/// Most segments of a path.
pub const MAX_DEPTH: u32 = 1 << 12;
/// `photons_per_iteration * max_depth` stays below this, so that a count of photons fits an `i32`, and a sum of fluxes
/// in units of [`crate::film::FLUX_ONE`] is exact as an `f64`: 2^31 * 2^21 < 2^53.
pub const MAX_DEPOSITS: u64 = 1 << 31;
/// The range of radii. Beyond it the square of a radius would be a subnormal or infinite `f32`.
pub const RADIUS_RANGE: [f32; 2] = [1e-15, 1e15];

/// How many times as large as the smallest first radius the largest is, if pilots or clearance choose them.
pub const RADIUS_RATIO: f32 = 8.0;

/// Bytes that a render holds per pixel: film, visible point, sums and index. It is used in messages; a test of the
/// command checks it.
pub const BYTES_PER_PIXEL: u64 = 256;

/// A setting out of bounds. Settings have their names in scene files, unless a front end says them by its own
/// ([`SettingsError::say`]).
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", self.say(str::to_owned))]
pub struct SettingsError {
    /// Name of the field of [`Settings`] at fault.
    pub option: &'static str,
    /// What is wrong and what would be right, as the rest of a sentence that begins with the name.
    pub problem: Vec<Piece>,
}

/// A piece of what is said of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// Words.
    Text(String),
    /// The name of a setting, as that of a field of [`Settings`].
    Setting(&'static str),
}

impl SettingsError {
    fn text(mut self, text: impl Into<String>) -> Self {
        self.problem.push(Piece::Text(text.into()));
        self
    }

    fn setting(mut self, name: &'static str) -> Self {
        self.problem.push(Piece::Setting(name));
        self
    }

    /// The sentence, with the names of settings given by `name`.
    pub fn say(&self, name: impl Fn(&'static str) -> String) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Setting(setting) => name(setting),
        };
        name(self.option) + " " + &self.problem.iter().map(piece).collect::<String>()
    }
}

impl Settings {
    /// Checks every bound.
    ///
    /// # Errors
    /// Names the first field out of bounds; for image sizes, also the memory that they would need.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let whole = |option, value: u32, most: u32| match value {
            0 => Err(error(option, "is 0; it must be at least 1")),
            v if v > most => Err(error(option, format!("is {v}; it must be at most {most}"))),
            _ => Ok(()),
        };
        whole("width", self.width, MAX_SIDE)?;
        whole("height", self.height, MAX_SIDE)?;
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > MAX_PIXELS {
            let need = gibibytes(pixels * BYTES_PER_PIXEL);
            let (w, h) = (self.width, self.height);
            return Err(error("width", format!("{w} x ")).setting("height").text(format!(
                " {h} is {pixels} pixels and would need {need}; at most {MAX_PIXELS} pixels are rendered"
            )));
        }
        whole("iterations", self.iterations, MAX_ITERATIONS)?;
        whole("photons_per_iteration", self.photons_per_iteration, MAX_PHOTONS)?;
        whole("max_depth", self.max_depth, MAX_DEPTH)?;
        whole("light_samples", self.light_samples, MAX_LIGHT_SAMPLES)?;
        whole("glint_samples", self.glint_samples, MAX_GLINT_SAMPLES)?;
        if self.max_deposits() >= MAX_DEPOSITS {
            let (l, d) = (self.photons_per_iteration, self.max_depth);
            return Err(error("photons_per_iteration", format!("{l} x ")).setting("max_depth").text(
                format!(
                    " {d} must stay below {MAX_DEPOSITS} photon segments; ask for more iterations instead"
                ),
            ));
        }
        let [low, high] = RADIUS_RANGE;
        if !(low..=high).contains(&self.initial_radius) {
            let r = self.initial_radius;
            return Err(error("initial_radius", format!("is {r}; it must be from {low:e} to {high:e}")));
        }
        self.validate_first_radii()
    }

    /// The bounds of what gives pixels first radii of their own.
    fn validate_first_radii(&self) -> Result<(), SettingsError> {
        let (pilots, clearance) = (self.radius_pilots, self.radius_clearance);
        if pilots > MAX_RADIUS_PILOTS {
            return Err(error(
                "radius_pilots",
                format!("is {pilots}; it must be at most {MAX_RADIUS_PILOTS}"),
            ));
        }
        let [low, high] = RADIUS_CLEARANCE_RANGE;
        if clearance != 0.0 && !(low..=high).contains(&clearance) {
            let problem = format!("is {clearance}; it must be 0, or from {low} to {high}");
            return Err(error("radius_clearance", problem));
        }
        let by_pilots = (pilots > 0).then(|| ("radius_pilots", pilots.to_string()));
        let by_clearance = (clearance > 0.0).then(|| ("radius_clearance", clearance.to_string()));
        let Some((option, value)) = by_pilots.or(by_clearance) else { return Ok(()) };
        if self.radius_schedule == RadiusSchedule::Global {
            return Err(error(option, format!("is {value}, but with "))
                .setting("radius_schedule")
                .text(" global all pixels have the same radius; it must be 0, or ")
                .setting("radius_schedule")
                .text(" per-pixel"));
        }
        let (r, least) = (self.initial_radius, RADIUS_RANGE[0] * RADIUS_RATIO);
        if r < least {
            let rest = format!(" to be at least {least:e}, not {r}; or it must be 0");
            return Err(error(option, "needs ").setting("initial_radius").text(rest));
        }
        Ok(())
    }

    /// The same with the paper's iterations, photons, depth and radius, one for all pixels: [`Quality::Paper`](crate::Quality::Paper).
    #[must_use]
    pub fn with_papers(self) -> Self {
        Self {
            width: self.width,
            height: self.height,
            seed: self.seed,
            filter: self.filter,
            radius_schedule: self.radius_schedule,
            light_samples: self.light_samples,
            ..Self::default()
        }
    }

    /// Pixels of the image.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Width and height of an image of the same shape that has at most so many pixels, and no more than this one.
    pub fn size_within(&self, pixels: u64) -> (u32, u32) {
        let scale = (pixels as f64 / self.pixels() as f64).min(1.0).sqrt();
        let side = |side: u32| ((f64::from(side) * scale) as u32).max(1);
        (side(self.width), side(self.height))
    }

    /// An upper bound on the photons that one iteration deposits.
    pub fn max_deposits(&self) -> u64 {
        u64::from(self.photons_per_iteration) * u64::from(self.max_depth)
    }
}

fn error(option: &'static str, problem: impl Into<String>) -> SettingsError {
    SettingsError { option, problem: Vec::new() }.text(problem)
}

fn gibibytes(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts that valid settings, changed by `change`, are refused for the option `refused`, or accepted if `None`.
    fn assert_verdict(change: impl FnOnce(&mut Settings), refused: Option<&str>) {
        let mut settings = Settings { width: 1, height: 1, photons_per_iteration: 1, ..Settings::default() };
        change(&mut settings);
        let verdict = settings.validate();
        assert_eq!(verdict.err().map(|error| error.option), refused, "{settings:?}");
    }

    #[test]
    fn each_bound_holds_to_the_last_step() {
        type Field = fn(&mut Settings) -> &mut u32;
        let fields: [(&str, Field, u32); 7] = [
            ("width", |s| &mut s.width, MAX_SIDE),
            ("height", |s| &mut s.height, MAX_SIDE),
            ("iterations", |s| &mut s.iterations, MAX_ITERATIONS),
            ("photons_per_iteration", |s| &mut s.photons_per_iteration, MAX_PHOTONS),
            ("max_depth", |s| &mut s.max_depth, MAX_DEPTH),
            ("light_samples", |s| &mut s.light_samples, MAX_LIGHT_SAMPLES),
            ("glint_samples", |s| &mut s.glint_samples, MAX_GLINT_SAMPLES),
        ];
        for (name, field, most) in fields {
            assert_verdict(|s| *field(s) = 0, Some(name));
            assert_verdict(|s| *field(s) = 1, None);
            assert_verdict(|s| *field(s) = most, None);
            assert_verdict(|s| *field(s) = most + 1, Some(name));
        }
    }

    #[test]
    fn pixels_and_photon_segments_have_bounds_of_their_own() {
        let size = |width, height| move |s: &mut Settings| (s.width, s.height) = (width, height);
        assert_verdict(size(1 << 14, 1 << 14), None);
        assert_verdict(size((1 << 14) + 1, 1 << 14), Some("width"));
        assert_verdict(size(1 << 8, 1 << 20), None);
        assert_verdict(size((1 << 8) + 1, 1 << 20), Some("width"));
        let paths = |photons, depth| {
            move |s: &mut Settings| (s.photons_per_iteration, s.max_depth) = (photons, depth)
        };
        assert_verdict(paths(1 << 28, 7), None);
        assert_verdict(paths(1 << 28, 8), Some("photons_per_iteration"));
        assert_verdict(paths(1 << 19, 1 << 12), Some("photons_per_iteration"));
        assert_verdict(paths((1 << 19) - 1, 1 << 12), None);
    }

    #[test]
    fn radii_are_those_whose_squares_are_normal() {
        let [low, high] = RADIUS_RANGE;
        assert!([low, high].into_iter().all(|radius| (radius * radius).is_normal()));
        let of = |radius| move |s: &mut Settings| s.initial_radius = radius;
        for radius in [low, 1.0, high] {
            assert_verdict(of(radius), None);
        }
        for radius in [low.next_down(), high.next_up(), 0.0, -1.0, f32::INFINITY, f32::NAN] {
            assert_verdict(of(radius), Some("initial_radius"));
        }
    }

    #[test]
    fn clearance_is_nothing_or_within_its_range() {
        let of = |radius_clearance| move |s: &mut Settings| s.radius_clearance = radius_clearance;
        let [low, high] = RADIUS_CLEARANCE_RANGE;
        for clearance in [0.0, low, 1.0, high] {
            assert_verdict(of(clearance), None);
        }
        for clearance in [low.next_down(), high.next_up(), -1.0, f32::INFINITY, f32::NAN] {
            assert_verdict(of(clearance), Some("radius_clearance"));
        }
    }

    /// A first radius of each pixel's own, by pilots or clearance, is not that of all, and may be an eighth of the largest.
    #[test]
    fn radii_of_their_own_need_a_schedule_and_room_below_the_largest() {
        type Change = fn(&mut Settings);
        let least = RADIUS_RANGE[0] * RADIUS_RATIO;
        let ways: [(Change, &str); 2] =
            [(|s| s.radius_pilots = 1, "radius_pilots"), (|s| s.radius_clearance = 1.0, "radius_clearance")];
        for (way, option) in ways {
            let with = |radius_schedule, initial_radius| {
                move |s: &mut Settings| {
                    way(s);
                    (s.radius_schedule, s.initial_radius) = (radius_schedule, initial_radius);
                }
            };
            assert_verdict(with(RadiusSchedule::PerPixel, least), None);
            assert_verdict(with(RadiusSchedule::PerPixel, least.next_down()), Some(option));
            assert_verdict(with(RadiusSchedule::Global, 1.0), Some(option));
        }
    }

    /// Size, seed, filter, schedule and light samples stay.
    #[test]
    fn the_papers_settings_are_those_of_the_method() {
        let usual = Settings::default();
        let own = Settings {
            width: 7,
            height: 5,
            iterations: 77,
            photons_per_iteration: 78,
            max_depth: 79,
            initial_radius: 80.0,
            seed: 9,
            filter: Filter::Gaussian,
            radius_schedule: RadiusSchedule::Global,
            radius_pilots: 3,
            radius_clearance: 0.5,
            light_samples: 2,
            glint_samples: 4,
        };
        let Settings { width, height, seed, filter, radius_schedule, light_samples, .. } = own;
        let expected = Settings { width, height, seed, filter, radius_schedule, light_samples, ..usual };
        assert_eq!((own.with_papers(), usual.with_papers()), (expected, usual));
        assert_eq!((own.pixels(), own.max_deposits()), (35, 78 * 79));
    }

    /// With the value and its bound, and settings by the names that the caller has for them.
    #[test]
    fn what_is_out_of_bounds_is_told_with_the_bound() {
        type Change = fn(&mut Settings);
        let told = |change: Change| {
            let mut settings = Settings::default();
            change(&mut settings);
            settings.validate().unwrap_err()
        };
        let changes: [(Change, &str); 11] = [
            (|s| s.width = 0, "width is 0; it must be at least 1"),
            (|s| s.height = MAX_SIDE + 1, "height is 1048577; it must be at most 1048576"),
            (
                |s| (s.width, s.height) = (1 << 15, 1 << 14),
                "width 32768 x height 16384 is 536870912 pixels and would need 128.0 GiB; at most 268435456 pixels \
                are rendered",
            ),
            (
                |s| s.iterations = MAX_ITERATIONS + 1,
                "iterations is 1073741825; it must be at most 1073741824",
            ),
            (|s| s.glint_samples = 65, "glint_samples is 65; it must be at most 64"),
            (
                |s| (s.photons_per_iteration, s.max_depth) = (1 << 28, 8),
                "photons_per_iteration 268435456 x max_depth 8 must stay below 2147483648 photon segments; ask for \
                more iterations instead",
            ),
            (|s| s.initial_radius = -1.0, "initial_radius is -1; it must be from 1e-15 to 1e15"),
            (|s| s.radius_pilots = 4097, "radius_pilots is 4097; it must be at most 4096"),
            (
                |s| s.radius_clearance = 2000.0,
                "radius_clearance is 2000; it must be 0, or from 0.001 to 1000",
            ),
            (
                |s| (s.radius_pilots, s.radius_schedule) = (3, RadiusSchedule::Global),
                "radius_pilots is 3, but with radius_schedule global all pixels have the same radius; it must be 0, \
                or radius_schedule per-pixel",
            ),
            (
                |s| (s.radius_clearance, s.initial_radius) = (0.5, 5e-15),
                "radius_clearance needs initial_radius to be at least 8e-15, not 0.000000000000005; or it must be 0",
            ),
        ];
        for (change, sentence) in changes {
            assert_eq!(told(change).to_string(), sentence);
        }
        let by_options = |change| told(change).say(|name| format!("--{}", name.replace('_', "-")));
        assert_eq!(
            by_options(|s| (s.radius_clearance, s.radius_schedule) = (0.5, RadiusSchedule::Global)),
            "--radius-clearance is 0.5, but with --radius-schedule global all pixels have the same radius; it must \
            be 0, or --radius-schedule per-pixel"
        );
        assert!(
            by_options(|s| (s.photons_per_iteration, s.max_depth) = (1 << 28, 8))
                .starts_with("--photons-per-iteration 268435456 x --max-depth 8 must stay below")
        );
    }

    /// Section 4 of the paper; and no choice of what came after it.
    #[test]
    fn the_settings_are_those_of_the_paper_if_nothing_is_said() {
        let expected = Settings {
            width: 512,
            height: 384,
            iterations: 6,
            photons_per_iteration: 200_000,
            max_depth: 5,
            initial_radius: 2.0,
            seed: 1,
            filter: Filter::Box,
            radius_schedule: RadiusSchedule::PerPixel,
            radius_pilots: 0,
            radius_clearance: 0.0,
            light_samples: 1,
            glint_samples: 1,
        };
        assert_eq!(Settings::default(), expected);
    }

    /// Files of older versions lack what was added since: it is as it was before there was a choice.
    #[test]
    fn what_a_file_leaves_out_is_that_of_the_paper() {
        use serde::de::value::{Error, MapDeserializer};
        let of_paper = [
            ("width", 512_u32),
            ("height", 384),
            ("iterations", 6),
            ("photons_per_iteration", 200_000),
            ("max_depth", 5),
            ("initial_radius", 2),
            ("seed", 1),
        ];
        let read = Settings::deserialize(MapDeserializer::<_, Error>::new(of_paper.into_iter()));
        assert_eq!(read, Ok(Settings::default()));
    }

    /// No side vanishes, and none grows.
    #[test]
    fn sizes_within_are_of_the_same_shape() {
        let of = |(width, height): (u32, u32), pixels: u64| {
            Settings { width, height, ..Settings::default() }.size_within(pixels)
        };
        let size = (64, 48);
        assert_eq!([of(size, 1 << 20), of(size, 64 * 48), of(size, 32 * 24)], [size, size, (32, 24)]);
        assert_eq!((of(size, 767), of((100, 1), 1), of((1, 100), 1)), ((31, 23), (10, 1), (1, 10)));
        for size in [(640, 480), (1920, 1080), (333, 777)] {
            for pixels in [1, 10, 1000, 49_152] {
                let (width, height) = of(size, pixels);
                assert!(u64::from(width * height) <= pixels, "{width} x {height} for {pixels}");
            }
        }
    }
}
