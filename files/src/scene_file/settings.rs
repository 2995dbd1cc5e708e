//! Reads the section `[settings]` of a scene file, which options of the command line override.

use super::error::{Fault, suggestion};
use super::reader::{Field, Section, Subject, type_of};
use super::sphere::positive;
use scene::settings::{MAX_DEPTH, MAX_ITERATIONS, MAX_PHOTONS, MAX_SIDE};
use scene::{Filter, Settings};

const KEYS: [&str; 8] = [
    "width",
    "height",
    "iterations",
    "photons_per_iteration",
    "max_depth",
    "initial_radius",
    "seed",
    "filter",
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
    };
    settings.validate().map_err(|e| Fault::new(place(&section, e.option), e.to_string()))?;
    Ok(settings)
}

fn filter(field: Field<'_>) -> Result<Filter, Fault> {
    let name = field.text()?;
    let names = Filter::ALL.map(Filter::name);
    let found = Filter::ALL.into_iter().find(|filter| filter.name() == name);
    let problem = || {
        let guess = suggestion(name, names);
        field.fault(format_args!("is unknown{guess}; the filters are {}", names.join(", ")))
    };
    found.ok_or_else(problem)
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
