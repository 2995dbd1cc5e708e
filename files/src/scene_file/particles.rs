//! Reads `[[particles]]`: files of particles, and how spheres are made of them.

use super::error::{Fault, quote};
use super::reader::{Field, Section, Subject, type_of};
use crate::particles::{self, Problem};
use figure::{Recipe, Rule, Selection, stage};
use scene::Scene;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Where files are searched, how much memory each may take, and the size of the image.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) folders: &'a [&'a Path],
    pub(super) most: u64,
    /// Width and height, where they are other than the file's.
    pub(super) size: [Option<u32>; 2],
}

impl<'a> Place<'a> {
    /// In these folders, and as much as is needed.
    pub(super) fn of(folders: &'a [&'a Path]) -> Self {
        Self { folders, most: u64::MAX, size: [None; 2] }
    }
}

/// What the files hold together.
#[derive(Default)]
pub(super) struct Found {
    /// Whether the first of them is moved so that its centre is the origin of the scene, unless it states another.
    pub(super) is_centered: bool,
    /// The origin of all, if they are moved.
    pub(super) origin: Option<[f64; 3]>,
    /// Whether one of them has a periodic cell that is shown.
    pub(super) has_cell: bool,
    /// What the user should know of them.
    pub(super) notes: Vec<Fault>,
}

const KEYS: [&str; 10] =
    ["file", "digest", "frame", "unit", "origin", "wrap", "cut", "bonds", "cell", "style"];
const SUBJECT: &str = "[[particles]]";
const RULE: &str = "[[particles.style]]";

/// Appends the spheres of all files that `root` names to `scene`.
pub(super) fn read(
    root: &Section<'_>,
    place: Place<'_>,
    scene: &mut Scene,
    found: &mut Found,
) -> Result<(), Fault> {
    let Some(field) = root.get("particles") else { return Ok(()) };
    for value in elements(field, SUBJECT)? {
        let at = value.span().start;
        let section = Section::new(Subject::Other(SUBJECT), at, table(value, SUBJECT)?, &KEYS)?;
        one(&section, place, scene, found)?;
    }
    Ok(())
}

fn one(section: &Section<'_>, place: Place<'_>, scene: &mut Scene, found: &mut Found) -> Result<(), Fault> {
    let named = section.require("file", "file = \"water.pdb\", say")?;
    let mut recipe = recipe(section)?;
    let file = find(Path::new(named.text()?), place.folders);
    let digest = section.get("digest").map(|field| field.text()).transpose()?;
    let told = |problem| match problem {
        Problem::Read(problem) | Problem::Stage(problem) => Fault::new(named.at, problem),
        Problem::Changed(problem) => Fault::new(section.get("digest").map_or(named.at, |d| d.at), problem),
        Problem::Recipe(refusal) => Fault::new(place_of(section, &refusal), refusal.to_string()),
    };
    let source = particles::read_unchanged(&file, digest, &recipe, place.most).map_err(told)?;
    if found.is_centered {
        if section.get("origin").is_none() {
            recipe.origin = found.origin.unwrap_or_else(|| stage::origin(&source.particles));
        }
        found.origin.get_or_insert(recipe.origin);
    }
    let (has_cell, notes) = particles::append(scene, source, &file, &recipe).map_err(told)?;
    found.has_cell |= has_cell;
    found.notes.extend(notes.into_iter().map(|note| Fault::new(named.at, note)));
    Ok(())
}

/// The first of the places where the file may be that has it: its path in each of the folders, then its name alone.
fn find(file: &Path, folders: &[&Path]) -> PathBuf {
    let name = file.file_name().map_or(file, Path::new);
    let all = [file, name].into_iter().flat_map(|file| folders.iter().map(move |folder| folder.join(file)));
    all.clone().find(|path| path.is_file()).or_else(|| all.clone().next()).unwrap_or_else(|| file.into())
}

fn recipe(section: &Section<'_>) -> Result<Recipe, Fault> {
    let mut recipe = Recipe::default();
    for key in Recipe::KEYS {
        if let Some(field) = section.get(key) {
            let problem = |problem: String| Fault::new(field.at, format!("{key} of {SUBJECT}: {problem}"));
            recipe.set(key, &text(field)?).map_err(problem)?;
        }
    }
    if let Some(field) = section.get("origin") {
        recipe.origin = origin(field)?;
    }
    if let Some(field) = section.get("cut") {
        recipe.cut = cuts(field)?;
    }
    if let Some(field) = section.get("style") {
        for value in elements(field, RULE)? {
            recipe.style.push(rule(value)?);
        }
    }
    Ok(recipe)
}

fn rule(value: &Spanned<DeValue<'_>>) -> Result<Rule, Fault> {
    let section = Section::new(Subject::Other(RULE), value.span().start, table(value, RULE)?, &Rule::KEYS)?;
    let mut rule = Rule::default();
    for key in Rule::KEYS {
        if let Some(field) = section.get(key) {
            let problem = |problem: String| Fault::new(field.at, format!("{key} of {RULE}: {problem}"));
            rule.set(key, &text(field)?).map_err(problem)?;
        }
    }
    Ok(rule)
}

/// The value as the text that it would be on the command line.
fn text(field: Field<'_>) -> Result<String, Fault> {
    match field.value {
        DeValue::String(text) => Ok(text.to_string()),
        // Those who read the text know decimal digits alone.
        DeValue::Integer(number) => {
            let whole = i128::from_str_radix(number.as_str(), number.radix());
            Ok(whole.map_or_else(|_| number.to_string(), |whole| whole.to_string()))
        }
        DeValue::Float(number) => Ok(number.as_str().into()),
        DeValue::Boolean(truth) => Ok(truth.to_string()),
        other => {
            Err(field.fault(format_args!("must be a text, a number, true or false, not {}", type_of(other))))
        }
    }
}

/// Three numbers in double precision, unlike all others of a scene.
fn origin(field: Field<'_>) -> Result<[f64; 3], Fault> {
    const RIGHT: &str = "must be three finite numbers, [x, y, z]";
    let array = field.value.as_array().filter(|array| array.len() == 3);
    let array = array.ok_or_else(|| field.fault(RIGHT))?;
    let mut origin = [0.0; 3];
    for (number, value) in origin.iter_mut().zip(array.iter()) {
        let element = Field { at: value.span().start, value: value.get_ref(), ..field };
        *number = element.float()?;
        if !number.is_finite() {
            return Err(element.fault(RIGHT));
        }
    }
    Ok(origin)
}

/// A selection, or an array of them.
fn cuts(field: Field<'_>) -> Result<Vec<Selection>, Fault> {
    let cut = |field: Field<'_>| {
        let problem = |error| Fault::new(field.at, format!("cut of {SUBJECT}: {error}"));
        Selection::parse(field.text()?).map_err(problem)
    };
    match field.value.as_array() {
        Some(array) => {
            let element = |value: &Spanned<DeValue<'_>>| {
                cut(Field { at: value.span().start, value: value.get_ref(), ..field })
            };
            array.iter().map(element).collect()
        }
        None => Ok(vec![cut(field)?]),
    }
}

/// The tables of an array; messages call each `name`.
fn elements<'a>(field: Field<'a>, name: &str) -> Result<&'a DeArray<'a>, Fault> {
    let wrong = || {
        let message = format!("{} must be an array of tables; head each with {name}", quote(field.key));
        Fault::new(field.at, message)
    };
    field.value.as_array().ok_or_else(wrong)
}

fn table<'a>(value: &'a Spanned<DeValue<'a>>, name: &str) -> Result<&'a DeTable<'a>, Fault> {
    let wrong = || {
        let found = type_of(value.get_ref());
        Fault::new(value.span().start, format!("{name} must be a table, not {found}"))
    };
    value.get_ref().as_table().ok_or_else(wrong)
}

/// Where in the text a recipe says what does not suit its file.
fn place_of(section: &Section<'_>, refusal: &figure::Refusal) -> usize {
    let of_key = || section.get(refusal.key).map(|field| field.at);
    let of_rule = |rule: usize| {
        let array = section.get("style")?.value.as_array()?;
        let value = array.get(rule)?;
        let key = value.get_ref().as_table()?.get(refusal.key);
        Some(key.map_or(value.span().start, |value| value.span().start))
    };
    refusal.rule.map_or_else(of_key, of_rule).unwrap_or(section.at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// Where several places have the file, the path that was stated comes before the name, and the folders come in order.
    #[test]
    fn the_stated_path_comes_before_the_name_alone() {
        let folder = tempfile::tempdir().unwrap();
        let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
        let places =
            [first.join("sub/a.xyz"), second.join("sub/a.xyz"), first.join("a.xyz"), second.join("a.xyz")];
        for place in &places {
            fs::create_dir_all(place.parent().unwrap()).unwrap();
            fs::write(place, "").unwrap();
        }
        let found = || find(Path::new("sub/a.xyz"), &[&first, &second]);
        for place in &places {
            assert_eq!(found(), *place);
            fs::remove_file(place).unwrap();
        }
        // In none of them: the first is told to be missing.
        assert_eq!(found(), places[0]);
    }
}
