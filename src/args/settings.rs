//! Options that override the settings stored in a scene.

use super::fields::name;
use super::values::{Given, amount, number, number_or_zero, or_auto, whole};
use crate::terminal::error::Error;
use clap::Args as ClapArgs;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use render::Field;
use scene::settings::{
    BYTES_PER_PIXEL, MAX_DEPTH, MAX_GLINT_SAMPLES, MAX_ITERATIONS, MAX_LIGHT_SAMPLES, MAX_PHOTONS,
    MAX_RADIUS_PILOTS, MAX_SIDE, RADIUS_CLEARANCE_RANGE, RADIUS_RANGE, SettingsError,
};
use scene::{Automatic, Filter, Quality, RadiusSchedule, Settings};

/// Bytes that a stored photon would take: position, incoming direction and flux, three floats each.
const BYTES_PER_PHOTON: u64 = 36;

/// What overrides the scene's own settings.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Settings (each defaults to the scene's own; most may be auto)")]
pub(crate) struct SettingsArgs {
    /// Width of the image, in pixels
    #[arg(long, value_name = "W", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub width: Option<u32>,

    /// Height of the image, in pixels
    #[arg(long, value_name = "H", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub height: Option<u32>,

    /// Iterations; for the path tracer, samples per pixel
    #[arg(short = 'n', long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = or_auto(whole::<u32>(1, MAX_ITERATIONS.into())))]
    pub iterations: Option<Given<u32>>,

    /// Photons that leave the lights in each iteration
    ///
    /// More of them smooth indirect light and caustics; direct light only takes more iterations.
    #[arg(long, value_name = "L", allow_hyphen_values = true)]
    #[arg(value_parser = or_auto(amount(MAX_PHOTONS, BYTES_PER_PHOTON)))]
    pub photons: Option<Given<u32>>,

    /// Most segments of a path: from the eye to the first diffuse hit, and from there to the light
    ///
    /// A glass ball before the eye takes 3 of the first, light that comes through another 3 of the second.
    #[arg(long, value_name = "D", value_parser = or_auto(whole::<u32>(1, MAX_DEPTH.into())), allow_hyphen_values = true)]
    pub depth: Option<Given<u32>>,

    /// Search radius of the first iteration, in scene units
    ///
    /// Photons count within it, so indirect light is blurred over it. It shrinks as photons come, slowly: to a half
    /// after some 25 iterations, to a third after 300. A hundredth of the width of what is seen is a good start.
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    #[arg(value_parser = or_auto(number(RADIUS_RANGE[0], RADIUS_RANGE[1])))]
    pub radius: Option<Given<f32>>,

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

    /// Give each pixel a first radius of its own, from --radius down to an eighth of it: by small renders of so many
    /// iterations each, eight in all; 0 for one radius everywhere
    ///
    /// Narrow at the rims of caustics, in corners and where balls touch the ground, wide where light is even.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = or_auto(whole::<u32>(0, MAX_RADIUS_PILOTS.into())))]
    pub radius_pilots: Option<Given<u32>>,

    /// Limit the first radius of each pixel to so many times the distance from what it sees to the nearest other sphere,
    /// but to no less than an eighth of --radius, and a third where that sphere is a wall around it; 0 for no limit
    ///
    /// Narrow where balls touch the ground, in corners and below balls of glass, where light changes fast.
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    #[arg(value_parser = or_auto(number_or_zero(RADIUS_CLEARANCE_RANGE)))]
    pub radius_clearance: Option<Given<f32>>,

    /// Send so many shadow rays from the first diffuse surface of each path from the eye, up to 16: less noise of direct
    /// light, for the time that they take
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, MAX_LIGHT_SAMPLES.into()), allow_hyphen_values = true)]
    pub light_samples: Option<u32>,

    /// See lamps by so many rays, up to 64, through each pixel that shows the rim of one, or a mirror or glass first: fewer
    /// sparks where lamps look smaller than a pixel
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = or_auto(whole::<u32>(1, MAX_GLINT_SAMPLES.into())))]
    pub glint_samples: Option<Given<u32>>,
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
    /// The scene's `own` settings, overridden by those given on the command line. Those that are `auto` are as in `own`.
    pub(crate) fn apply(&self, own: &Settings) -> Result<Settings, Error> {
        let settings = Settings {
            width: self.width.unwrap_or(own.width),
            height: self.height.unwrap_or(own.height),
            iterations: Given::number_or(self.iterations, own.iterations),
            photons_per_iteration: Given::number_or(self.photons, own.photons_per_iteration),
            max_depth: Given::number_or(self.depth, own.max_depth),
            initial_radius: Given::number_or(self.radius, own.initial_radius),
            seed: self.seed.unwrap_or(own.seed),
            filter: self.filter.unwrap_or(own.filter),
            radius_schedule: self.radius_schedule.unwrap_or(own.radius_schedule),
            radius_pilots: Given::number_or(self.radius_pilots, own.radius_pilots),
            radius_clearance: Given::number_or(self.radius_clearance, own.radius_clearance),
            light_samples: self.light_samples.unwrap_or(own.light_samples),
            glint_samples: Given::number_or(self.glint_samples, own.glint_samples),
        };
        settings.validate().map_err(|error| Error::BadInput(self.blame(&error)))?;
        Ok(settings)
    }

    /// As [`Self::apply`], for commands that choose no settings.
    pub(crate) fn apply_numbers(&self, own: &Settings) -> Result<Settings, Error> {
        let options = [
            ("-n", Given::is_chosen(self.iterations.as_ref(), false)),
            ("--photons", Given::is_chosen(self.photons.as_ref(), false)),
            ("--depth", Given::is_chosen(self.depth.as_ref(), false)),
            ("--radius", Given::is_chosen(self.radius.as_ref(), false)),
            ("--radius-pilots", Given::is_chosen(self.radius_pilots.as_ref(), false)),
            ("--radius-clearance", Given::is_chosen(self.radius_clearance.as_ref(), false)),
            ("--glint-samples", Given::is_chosen(self.glint_samples.as_ref(), false)),
        ];
        match options.into_iter().find(|(_, is_chosen)| *is_chosen) {
            Some((name, _)) => Err(Error::BadInput(format!(
                "{name} auto: only `sppm render` chooses settings; give a number"
            ))),
            None => self.apply(own),
        }
    }

    /// What is to be chosen: what is `auto`, and of what is not given, what `own` says.
    pub(crate) fn automatic(&self, own: Automatic) -> Automatic {
        Automatic {
            quality: own.quality,
            method: own.method,
            iterations: Given::is_chosen(self.iterations.as_ref(), own.iterations),
            photons_per_iteration: Given::is_chosen(self.photons.as_ref(), own.photons_per_iteration),
            max_depth: Given::is_chosen(self.depth.as_ref(), own.max_depth),
            initial_radius: Given::is_chosen(self.radius.as_ref(), own.initial_radius),
            // Pilots and clearance choose from the first radius down, so by themselves they go with it.
            radius_pilots: Given::is_chosen(
                self.radius_pilots.as_ref(),
                Given::is_chosen(self.radius.as_ref(), own.radius_pilots),
            ),
            radius_clearance: Given::is_chosen(
                self.radius_clearance.as_ref(),
                Given::is_chosen(self.radius.as_ref(), own.radius_clearance),
            ),
            // Whoever gives a radius chooses by hand.
            glint_samples: Given::is_chosen(
                self.glint_samples.as_ref(),
                Given::is_chosen(self.radius.as_ref(), own.glint_samples),
            ),
        }
    }

    /// The number of iterations, if one is given.
    pub(crate) fn given_iterations(&self) -> Option<u32> {
        match self.iterations {
            Some(Given::Number(number)) => Some(number),
            Some(Given::Auto) | None => None,
        }
    }

    /// Describes `error` in terms of the options given; settings of the scene keep their names.
    fn blame(&self, error: &SettingsError) -> String {
        let is_given = |setting| match setting {
            "width" => self.width.is_some(),
            "height" => self.height.is_some(),
            "photons_per_iteration" => self.photons.is_some(),
            "max_depth" => self.depth.is_some(),
            "initial_radius" => self.radius.is_some(),
            "radius_schedule" => self.radius_schedule.is_some(),
            "radius_pilots" => self.radius_pilots.is_some(),
            "radius_clearance" => self.radius_clearance.is_some(),
            "glint_samples" => self.glint_samples.is_some(),
            _ => false,
        };
        error.say(|setting| {
            if is_given(setting) { name(Field::Setting(setting)).into_owned() } else { setting.to_owned() }
        })
    }
}

/// How good the picture is to be.
#[derive(Debug, Default, ClapArgs)]
pub(crate) struct QualityArgs {
    /// Choose method, iterations, photons, radius and depth from the scene, for a picture that shows what is where (`draft`),
    /// looks finished (`good`), or has hardly any noise that can be seen (`final`) [default: good, if the scene's file states
    /// no numbers]
    ///
    /// What is given by --method, -n, --photons, --radius or --depth is not chosen; photons and radius mean `--method sppm`.
    /// `paper` chooses nothing: it takes the settings of the paper, 6 iterations of 200000 photons, radius 2 and depth 5. What
    /// was chosen is told, and recorded in the image, so that `--like` repeats it.
    #[arg(long, value_name = "QUALITY", value_parser = qualities(), help_heading = "Quality")]
    pub quality: Option<Quality>,
}

/// Parses the name of a quality.
fn qualities() -> impl TypedValueParser<Value = Quality> {
    let found =
        |name: String| Quality::ALL.into_iter().find(|quality| quality.name() == name).unwrap_or_default();
    PossibleValuesParser::new(Quality::ALL.map(Quality::name)).map(found)
}

impl QualityArgs {
    /// The settings of a scene, which states `own` and leaves `automatic` to be chosen, at the quality given.
    pub(crate) fn apply(&self, own: &Settings, automatic: Automatic) -> (Settings, Automatic) {
        match self.quality {
            None => (*own, automatic),
            Some(Quality::Paper) => (own.with_papers(), Automatic::all(Quality::Paper)),
            Some(quality) => (*own, Automatic::all(quality)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    fn of(words: &[&str]) -> SettingsArgs {
        of_render(&[&["cornell"], words].concat()).settings
    }

    fn own() -> Settings {
        Settings { width: 40, height: 30, radius_pilots: 2, radius_clearance: 0.5, ..Settings::default() }
    }

    #[test]
    fn each_option_sets_its_setting_and_no_other() {
        let own = own();
        let apply = |words: &[&str]| of(words).apply(&own).unwrap();
        assert_eq!(apply(&[]), own);
        for (words, expected) in [
            (["--width", "7"], Settings { width: 7, ..own }),
            (["--height", "7"], Settings { height: 7, ..own }),
            (["-n", "7"], Settings { iterations: 7, ..own }),
            (["--iterations", "7"], Settings { iterations: 7, ..own }),
            (["--photons", "7"], Settings { photons_per_iteration: 7, ..own }),
            (["--depth", "7"], Settings { max_depth: 7, ..own }),
            (["--radius", "7"], Settings { initial_radius: 7.0, ..own }),
            (["--seed", "7"], Settings { seed: 7, ..own }),
            (["--radius-pilots", "7"], Settings { radius_pilots: 7, ..own }),
            (["--radius-clearance", "0.25"], Settings { radius_clearance: 0.25, ..own }),
            (["--light-samples", "7"], Settings { light_samples: 7, ..own }),
            (["--glint-samples", "9"], Settings { glint_samples: 9, ..own }),
        ] {
            assert_eq!(apply(&words), expected, "{words:?}");
            assert_eq!(of(&words).apply_numbers(&own).unwrap(), expected, "{words:?}");
        }
        for filter in Filter::ALL {
            assert_eq!(apply(&["--filter", filter.name()]), Settings { filter, ..own });
        }
        let single = Settings { radius_pilots: 0, radius_clearance: 0.0, ..own };
        for radius_schedule in RadiusSchedule::ALL {
            let words = ["--radius-schedule", radius_schedule.name()];
            assert_eq!(of(&words).apply(&single).unwrap(), Settings { radius_schedule, ..single });
        }
    }

    /// What is `auto` is chosen, and what is a number is not, whatever the scene says.
    #[test]
    fn options_say_what_is_chosen() {
        let none = Automatic { quality: Quality::Final, ..Automatic::default() };
        let all = Automatic::all(Quality::Final);
        let chosen = |words: &[&str], own| of(words).automatic(own);
        assert_eq!((chosen(&[], none), chosen(&[], all)), (none, all));
        for (option, given, left) in [
            ("-n", Automatic { iterations: true, ..none }, Automatic { iterations: false, ..all }),
            (
                "--photons",
                Automatic { photons_per_iteration: true, ..none },
                Automatic { photons_per_iteration: false, ..all },
            ),
            ("--depth", Automatic { max_depth: true, ..none }, Automatic { max_depth: false, ..all }),
            (
                "--radius",
                Automatic {
                    initial_radius: true,
                    radius_pilots: true,
                    radius_clearance: true,
                    glint_samples: true,
                    ..none
                },
                Automatic {
                    initial_radius: false,
                    radius_pilots: false,
                    radius_clearance: false,
                    glint_samples: false,
                    ..all
                },
            ),
            (
                "--radius-pilots",
                Automatic { radius_pilots: true, ..none },
                Automatic { radius_pilots: false, ..all },
            ),
            (
                "--radius-clearance",
                Automatic { radius_clearance: true, ..none },
                Automatic { radius_clearance: false, ..all },
            ),
            (
                "--glint-samples",
                Automatic { glint_samples: true, ..none },
                Automatic { glint_samples: false, ..all },
            ),
        ] {
            assert_eq!(chosen(&[option, "auto"], none), given, "{option}");
            assert_eq!(chosen(&[option, "2"], all), left, "{option}");
            let problem = of(&[option, "auto"]).apply_numbers(&own()).unwrap_err().to_string();
            assert_eq!(problem, format!("{option} auto: only `sppm render` chooses settings; give a number"));
        }
        assert_eq!(of(&["-n", "7"]).given_iterations(), Some(7));
        assert_eq!([of(&["-n", "auto"]), of(&[])].map(|args| args.given_iterations()), [None, None]);
    }

    /// What was given is named as an option, and what the scene states as there.
    #[test]
    fn the_option_that_was_given_is_blamed() {
        let said = |words: &[&str], own: Settings| of(words).apply(&own).unwrap_err().to_string();
        let starts = |words: &[&str], own: Settings, start: &str| {
            let said = said(words, own);
            assert!(said.starts_with(start), "{said}");
        };
        let own = Settings { radius_pilots: 0, radius_clearance: 0.0, ..own() };
        starts(
            &["--height", "65536"],
            Settings { width: 1 << 16, ..own },
            "width 65536 x --height 65536 is ",
        );
        starts(
            &["--width", "65536"],
            Settings { height: 1 << 16, ..own },
            "--width 65536 x height 65536 is ",
        );
        let (photons, depth) = (MAX_PHOTONS.to_string(), MAX_DEPTH.to_string());
        let deep = Settings { max_depth: MAX_DEPTH, photons_per_iteration: 1, ..own };
        let end = format!("{photons} x max_depth {depth} must stay below ");
        starts(&["--photons", &photons], deep, &format!("--photons {end}"));
        let many = Settings { max_depth: 1, photons_per_iteration: MAX_PHOTONS, ..own };
        let start = format!("photons_per_iteration {photons} x --depth {depth} must stay below ");
        starts(&["--depth", &depth], many, &start);
        let global = Settings { radius_schedule: RadiusSchedule::Global, ..own };
        let same = "all pixels have the same radius; it must be 0, or";
        assert_eq!(
            said(&["--radius-pilots", "2"], global),
            format!("--radius-pilots is 2, but with radius_schedule global {same} radius_schedule per-pixel")
        );
        assert_eq!(
            said(&["--radius-clearance", "2", "--radius-schedule", "global"], own),
            format!(
                "--radius-clearance is 2, but with --radius-schedule global {same} --radius-schedule per-pixel"
            )
        );
        let piloted = Settings { radius_pilots: 1, ..own };
        starts(&["--radius", "1e-15"], piloted, "radius_pilots needs --radius to be at least 8e-15, not 0.");
    }

    #[test]
    fn a_quality_chooses_all_and_that_of_the_paper_nothing() {
        let (own, automatic) = (own(), Automatic { max_depth: true, ..Automatic::default() });
        let of = |quality| QualityArgs { quality }.apply(&own, automatic);
        assert_eq!(of(None), (own, automatic));
        assert_eq!(of(Some(Quality::Paper)), (own.with_papers(), Automatic::all(Quality::Paper)));
        assert_eq!(of(Some(Quality::Draft)), (own, Automatic::all(Quality::Draft)));
        // Whatever the file states.
        let stated = QualityArgs { quality: Some(Quality::Final) }.apply(&own, Automatic::default());
        assert_eq!(stated, (own, Automatic::all(Quality::Final)));
        for quality in Quality::ALL {
            assert_eq!(of_render(&["cornell", "--quality", quality.name()]).quality.quality, Some(quality));
        }
    }
}
