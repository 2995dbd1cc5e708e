//! Reads the section `[settings]` of a scene file, which options of the command line override.

use super::error::{Fault, suggestion};
use super::reader::{Field, Section, Subject, type_of};
use super::sphere::positive;
use scene::settings::{
    MAX_DEPTH, MAX_GLINT_SAMPLES, MAX_ITERATIONS, MAX_LIGHT_SAMPLES, MAX_PHOTONS, MAX_RADIUS_PILOTS,
    MAX_SIDE, RADIUS_CLEARANCE_RANGE,
};
use scene::{Automatic, Filter, Quality, RadiusSchedule, Settings};

const KEYS: [&str; 14] = [
    "width",
    "height",
    "iterations",
    "photons_per_iteration",
    "max_depth",
    "initial_radius",
    "seed",
    "filter",
    "radius_schedule",
    "radius_pilots",
    "radius_clearance",
    "light_samples",
    "glint_samples",
    "quality",
];

/// In place of a number: the setting is chosen from the scene.
const AUTO: &str = "auto";

/// What a scene file says of settings.
#[derive(Clone, Copy)]
pub(super) struct Stated {
    pub(super) settings: Settings,
    /// The settings that are left to be chosen; their numbers in `settings` are the paper's.
    pub(super) automatic: Automatic,
}

/// The settings where a file states none.
#[derive(Clone, Copy)]
pub(super) enum Usual {
    /// The paper's, or chosen from the scene.
    Paper,
    /// Those of a stage.
    Staged(Settings),
}

impl Usual {
    fn settings(self) -> Settings {
        match self {
            Self::Paper => Settings::default(),
            Self::Staged(settings) => settings,
        }
    }

    /// Those that are chosen if a file says nothing.
    fn automatic(self) -> Automatic {
        match self {
            Self::Paper => Automatic::all(Quality::default()),
            Self::Staged(_) => Automatic::default(),
        }
    }
}

/// What the scene `root` says of settings.
pub(super) fn stated(root: &Section<'_>, usual: Usual) -> Result<Stated, Fault> {
    let unsaid = Stated { settings: usual.settings(), automatic: usual.automatic() };
    root.or("settings", unsaid, |field| settings(field, usual))
}

fn settings(field: Field<'_>, usual: Usual) -> Result<Stated, Fault> {
    let Some(table) = field.value.as_table() else {
        let found = type_of(field.value);
        return Err(Fault::new(field.at, format!("settings must be a table, [settings], not {found}")));
    };
    let section = Section::new(Subject::Settings, field.at, table, &KEYS)?;
    let whole =
        |key, default, most: u32| section.or(key, default, |field| Ok(field.whole(1, most.into())? as u32));
    let choosable = |key, default, most: u32| {
        section.or(key, default, |field| {
            if is_auto(&field) { Ok(default) } else { Ok(field.whole(1, most.into())? as u32) }
        })
    };
    let default = usual.settings();
    let settings = Settings {
        width: whole("width", default.width, MAX_SIDE)?,
        height: whole("height", default.height, MAX_SIDE)?,
        iterations: choosable("iterations", default.iterations, MAX_ITERATIONS)?,
        photons_per_iteration: choosable(
            "photons_per_iteration",
            default.photons_per_iteration,
            MAX_PHOTONS,
        )?,
        max_depth: choosable("max_depth", default.max_depth, MAX_DEPTH)?,
        initial_radius: section.or("initial_radius", default.initial_radius, |field| {
            if is_auto(&field) { Ok(default.initial_radius) } else { positive(field.number()?) }
        })?,
        seed: section.or("seed", default.seed, |field| field.whole(0, u64::MAX))?,
        filter: section.or("filter", default.filter, filter)?,
        radius_schedule: section.or("radius_schedule", default.radius_schedule, radius_schedule)?,
        radius_pilots: section.or("radius_pilots", default.radius_pilots, |field| {
            if is_auto(&field) {
                Ok(default.radius_pilots)
            } else {
                Ok(field.whole(0, MAX_RADIUS_PILOTS.into())? as u32)
            }
        })?,
        radius_clearance: section.or("radius_clearance", default.radius_clearance, |field| {
            if is_auto(&field) { Ok(default.radius_clearance) } else { clearance(field) }
        })?,
        light_samples: whole("light_samples", default.light_samples, MAX_LIGHT_SAMPLES)?,
        glint_samples: choosable("glint_samples", default.glint_samples, MAX_GLINT_SAMPLES)?,
    };
    settings.validate().map_err(|e| Fault::new(place(&section, e.option), e.to_string()))?;
    Ok(Stated { settings, automatic: automatic(&section, usual)? })
}

fn is_auto(field: &Field<'_>) -> bool {
    field.value.as_str() == Some(AUTO)
}

/// The settings that are left to be chosen: those that are `"auto"`; and where no number is stated, or a quality is, those
/// that are not stated. On a stage they are its own, unless a quality is stated.
fn automatic(section: &Section<'_>, usual: Usual) -> Result<Automatic, Fault> {
    let quality = section.get("quality").map(quality).transpose()?;
    let keys = ["iterations", "photons_per_iteration", "max_depth", "initial_radius"];
    let [iterations, photons_per_iteration, max_depth, initial_radius] = keys.map(|key| section.get(key));
    let is_number = |field: &Option<Field<'_>>| field.is_some_and(|field| !is_auto(&field));
    let is_left = matches!(usual, Usual::Paper) && !keys.iter().any(|key| is_number(&section.get(key)));
    let unstated = Automatic::all(quality.unwrap_or_default());
    let others = unstated.any() && (quality.is_some() || is_left);
    let is_chosen = |field: Option<Field<'_>>| field.map_or(others, |field| is_auto(&field));
    // Pilots and clearance choose from the first radius down, so by themselves they go with it. Whoever states a radius chooses
    // by hand, so rays that see lamps go with it too.
    let of_radius = |key| section.get(key).map_or(is_chosen(initial_radius), |field| is_auto(&field));
    let chosen = Automatic {
        iterations: is_chosen(iterations),
        photons_per_iteration: is_chosen(photons_per_iteration),
        max_depth: is_chosen(max_depth),
        initial_radius: is_chosen(initial_radius),
        radius_pilots: of_radius("radius_pilots"),
        radius_clearance: of_radius("radius_clearance"),
        glint_samples: of_radius("glint_samples"),
        method: others,
        ..unstated
    };
    Ok(Automatic { method: chosen.leaves_method_open(RadiusSchedule::PerPixel), ..chosen })
}

fn quality(field: Field<'_>) -> Result<Quality, Fault> {
    named(&field, "qualities", Quality::ALL, Quality::name)
}

fn filter(field: Field<'_>) -> Result<Filter, Fault> {
    named(&field, "filters", Filter::ALL, Filter::name)
}

fn radius_schedule(field: Field<'_>) -> Result<RadiusSchedule, Fault> {
    named(&field, "schedules", RadiusSchedule::ALL, RadiusSchedule::name)
}

fn clearance(field: Field<'_>) -> Result<f32, Fault> {
    let [low, high] = RADIUS_CLEARANCE_RANGE;
    let is_valid = |value| value == 0.0 || (low..=high).contains(&value);
    field.number()?.check(is_valid, format_args!("must be 0, or from {low} to {high}"))
}

/// The one of `all` that has the name in a field; `what` they are called together.
pub(super) fn named<T: Copy, const N: usize>(
    field: &Field<'_>,
    what: &str,
    all: [T; N],
    name_of: fn(T) -> &'static str,
) -> Result<T, Fault> {
    let (name, names) = (field.text()?, all.map(name_of));
    let problem = || {
        let guess = suggestion(name, names);
        field.fault(format_args!("is unknown{guess}; the {what} are {}", names.join(", ")))
    };
    all.into_iter().find(|one| name_of(*one) == name).ok_or_else(problem)
}

/// The position of `option` in the file, or else of the setting whose product with it is too large.
fn place(section: &Section<'_>, option: &'static str) -> usize {
    let partner = match option {
        "width" => "height",
        "photons_per_iteration" => "max_depth",
        other => other,
    };
    section.get(option).or_else(|| section.get(partner)).map_or(section.at, |field| field.at)
}
