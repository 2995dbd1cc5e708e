//! Options that override the settings stored in a scene.

use super::values::{amount, number, whole};
use crate::terminal::error::Error;
use clap::Args as ClapArgs;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use scene::settings::{
    BYTES_PER_PIXEL, MAX_DEPTH, MAX_ITERATIONS, MAX_PHOTONS, MAX_SIDE, RADIUS_RANGE, SettingsError,
};
use scene::{Filter, RadiusSchedule, Settings};

/// Bytes that a stored photon would take: position, incoming direction and flux, three floats each.
const BYTES_PER_PHOTON: u64 = 36;

/// What overrides the scene's own settings.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Settings (each defaults to the scene's own)")]
pub(crate) struct SettingsArgs {
    /// Width of the image, in pixels
    #[arg(long, value_name = "W", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub width: Option<u32>,

    /// Height of the image, in pixels
    #[arg(long, value_name = "H", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub height: Option<u32>,

    /// Iterations; for the path tracer, samples per pixel
    #[arg(short = 'n', long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<u32>(1, MAX_ITERATIONS.into()))]
    pub iterations: Option<u32>,

    /// Photons that leave the lights in each iteration
    ///
    /// More of them smooth indirect light and caustics; direct light only takes more iterations.
    #[arg(long, value_name = "L", value_parser = amount(MAX_PHOTONS, BYTES_PER_PHOTON), allow_hyphen_values = true)]
    pub photons: Option<u32>,

    /// Most segments of a path: from the eye to the first diffuse hit, and from there to the light
    ///
    /// A glass ball before the eye takes 3 of the first, light that comes through another 3 of the second.
    #[arg(long, value_name = "D", value_parser = whole::<u32>(1, MAX_DEPTH.into()), allow_hyphen_values = true)]
    pub depth: Option<u32>,

    /// Search radius of the first iteration, in scene units
    ///
    /// Photons count within it, so indirect light is blurred over it. It shrinks as photons come, slowly: to a half
    /// after some 25 iterations, to a third after 300. A hundredth of the width of what is seen is a good start.
    #[arg(long, value_name = "R", value_parser = number(RADIUS_RANGE[0], RADIUS_RANGE[1]), allow_hyphen_values = true)]
    pub radius: Option<f32>,

    /// Seed of all random numbers: the same seed gives the same bytes, another seed other noise
    #[arg(long, value_name = "S", value_parser = whole::<u64>(0, u64::MAX), allow_hyphen_values = true)]
    pub seed: Option<u64>,

    /// How a pixel averages the light around it: `box` takes its own square alone, `gaussian` is smooth, `mitchell` is
    /// smooth and sharp
    #[arg(long, value_name = "FILTER", value_parser = filters())]
    pub filter: Option<Filter>,

    /// How the radius shrinks: `per-pixel` by the photons that each pixel counts, `global` by the number of the iteration
    ///
    /// With global radii iterations are independent: parts of a render, from any machines, add up to its image, bit for bit.
    #[arg(long, value_name = "SCHEDULE", value_parser = schedules())]
    pub radius_schedule: Option<RadiusSchedule>,
}

/// Parses the name of a filter.
fn filters() -> impl TypedValueParser<Value = Filter> {
    let found =
        |name: String| Filter::ALL.into_iter().find(|filter| filter.name() == name).unwrap_or_default();
    PossibleValuesParser::new(Filter::ALL.map(Filter::name)).map(found)
}

/// Parses the name of a radius schedule.
fn schedules() -> impl TypedValueParser<Value = RadiusSchedule> {
    let all = RadiusSchedule::ALL;
    let found =
        move |name: String| all.into_iter().find(|schedule| schedule.name() == name).unwrap_or_default();
    PossibleValuesParser::new(all.map(RadiusSchedule::name)).map(found)
}

impl SettingsArgs {
    /// The scene's `own` settings, overridden by those given on the command line.
    pub(crate) fn apply(&self, own: &Settings) -> Result<Settings, Error> {
        let settings = Settings {
            width: self.width.unwrap_or(own.width),
            height: self.height.unwrap_or(own.height),
            iterations: self.iterations.unwrap_or(own.iterations),
            photons_per_iteration: self.photons.unwrap_or(own.photons_per_iteration),
            max_depth: self.depth.unwrap_or(own.max_depth),
            initial_radius: self.radius.unwrap_or(own.initial_radius),
            seed: self.seed.unwrap_or(own.seed),
            filter: self.filter.unwrap_or(own.filter),
            radius_schedule: self.radius_schedule.unwrap_or(own.radius_schedule),
        };
        settings.validate().map_err(|error| Error::BadInput(self.blame(&error)))?;
        Ok(settings)
    }

    /// Describes `error` in terms of the options given. The scene's own settings are in bounds, as its file was checked
    /// when it was read. So if the setting at fault was not given as an option, its partner was: the other setting in
    /// a bound on their product.
    fn blame(&self, error: &SettingsError) -> String {
        let SettingsError { option, problem } = error;
        let options = [
            ("width", "--width", self.width.is_some(), "--height"),
            ("height", "--height", self.height.is_some(), "--width"),
            ("photons_per_iteration", "--photons", self.photons.is_some(), "--depth"),
        ];
        match options.into_iter().find(|(field, ..)| field == option) {
            Some((_, name, true, _)) => format!("{name} {problem}"),
            Some((_, _, false, partner)) => format!("{partner}: {option} {problem}"),
            None => error.to_string(),
        }
    }
}
