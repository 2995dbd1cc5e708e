//! Reads the section `[settings]` of a scene file, which options of the command line override.

use super::error::{Fault, suggestion};
use super::reader::{Field, Section, Subject, type_of};
use super::sphere::positive;
use scene::settings::{MAX_DEPTH, MAX_ITERATIONS, MAX_PHOTONS, MAX_SIDE};
use scene::{Filter, RadiusSchedule, Settings};

const KEYS: [&str; 9] = [
    "width",
    "height",
    "iterations",
    "photons_per_iteration",
    "max_depth",
    "initial_radius",
    "seed",
    "filter",
    "radius_schedule",
];

pub(super) fn settings(field: Field<'_>) -> Result<Settings, Fault> {
    let Some(table) = field.value.as_table() else {
        let found = type_of(field.value);
        return Err(Fault::new(field.at, format!("settings must be a table, [settings], not {found}")));
    };
    let section = Section::new(Subject::Settings, field.at, table, &KEYS)?;
    let whole =
        |key, default, most: u32| section.or(key, default, |field| Ok(field.whole(1, most.into())? as u32));
    let default = Settings::default();
    let settings = Settings {
        width: whole("width", default.width, MAX_SIDE)?,
        height: whole("height", default.height, MAX_SIDE)?,
        iterations: whole("iterations", default.iterations, MAX_ITERATIONS)?,
        photons_per_iteration: whole("photons_per_iteration", default.photons_per_iteration, MAX_PHOTONS)?,
        max_depth: whole("max_depth", default.max_depth, MAX_DEPTH)?,
        initial_radius: section
            .or("initial_radius", default.initial_radius, |field| positive(field.number()?))?,
        seed: section.or("seed", default.seed, |field| field.whole(0, u64::MAX))?,
        filter: section.or("filter", default.filter, filter)?,
        radius_schedule: section.or("radius_schedule", default.radius_schedule, radius_schedule)?,
    };
    settings.validate().map_err(|e| Fault::new(place(&section, e.option), e.to_string()))?;
    Ok(settings)
}

fn filter(field: Field<'_>) -> Result<Filter, Fault> {
    named(&field, "filters", Filter::ALL, Filter::name)
}

fn radius_schedule(field: Field<'_>) -> Result<RadiusSchedule, Fault> {
    named(&field, "schedules", RadiusSchedule::ALL, RadiusSchedule::name)
}

/// The one of `all` that has the name in a field; `what` they are called together.
fn named<T: Copy, const N: usize>(
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
