//! Molecules and particles: read from files as arrays, and made spheres of scenes.

use crate::columns::{elements, rows, values, vectors};
use crate::errors::{FileError, InputError};
use crate::scene::Scene;
use crate::values::named;
use crate::work::{work, work_until_interrupted};
use figure::stage::{Background, Light, Stage, View};
use figure::{Recipe, Refusal, Rule, Selection, balls};
use files::particles::{self, Problem, Staged};
use importers::elements::by_symbol;
use importers::{Cell, Format, Labels, Particles, Properties, Property, Request, Unit, read};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scene::Stop;
use std::path::PathBuf;

/// Texts, and the index of its text for each particle.
type LabelsTuple<'py> = (Vec<String>, PyReadonlyArray1<'py, u16>);
/// Origin, vectors, and along which it repeats.
type CellTuple = ([f64; 3], [[f64; 3]; 3], [bool; 3]);
/// Keys and what they are set to.
type Entries = Vec<(String, String)>;

/// The columns of particles.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Columns<'py> {
    title: String,
    /// The unit of lengths; `None` if it is not known.
    unit: Option<String>,
    positions: PyReadonlyArray2<'py, f64>,
    elements: Option<PyReadonlyArray1<'py, u8>>,
    types: Option<LabelsTuple<'py>>,
    radii: Option<PyReadonlyArray1<'py, f32>>,
    colors: Option<PyReadonlyArray2<'py, f32>>,
    names: Option<LabelsTuple<'py>>,
    residues: Option<LabelsTuple<'py>>,
    residue_numbers: Option<PyReadonlyArray1<'py, i32>>,
    chains: Option<LabelsTuple<'py>>,
    molecules: Option<PyReadonlyArray1<'py, u32>>,
    ids: Option<PyReadonlyArray1<'py, u64>>,
    properties: Vec<(String, PyReadonlyArray1<'py, f32>)>,
    bonds: PyReadonlyArray2<'py, u32>,
    cell: Option<CellTuple>,
}

impl Columns<'_> {
    fn particles(&self) -> PyResult<Particles> {
        let (positions, bonds) = (vectors(&self.positions)?.to_vec(), vectors(&self.bonds)?.to_vec());
        let colors = self.colors.as_ref().map(|colors| vectors(colors).map(<[_]>::to_vec)).transpose()?;
        let properties = self.properties.iter().map(|(name, values)| {
            Ok::<_, PyErr>(Property { name: name.clone(), values: elements(values)?.to_vec() })
        });
        let particles = Particles {
            title: self.title.clone(),
            unit: self.unit.as_deref().map_or(Ok(Unit::Unknown), unit)?,
            positions,
            elements: column(self.elements.as_ref())?,
            types: labels(self.types.as_ref())?,
            radii: column(self.radii.as_ref())?,
            colors,
            names: labels(self.names.as_ref())?,
            residues: labels(self.residues.as_ref())?,
            residue_numbers: column(self.residue_numbers.as_ref())?,
            chains: labels(self.chains.as_ref())?,
            molecules: column(self.molecules.as_ref())?,
            ids: column(self.ids.as_ref())?,
            available: self.properties.iter().map(|(name, _)| name.clone()).collect(),
            properties: properties.collect::<Result<_, _>>()?,
            bonds,
            cell: self.cell.map(|(origin, vectors, periodic)| Cell { origin, vectors, periodic }),
            ..Particles::new(Format::Npy)
        };
        Ok(particles)
    }
}

fn column<T: numpy::Element + Copy>(array: Option<&PyReadonlyArray1<T>>) -> PyResult<Option<Vec<T>>> {
    array.map(|array| elements(array).map(<[T]>::to_vec)).transpose()
}

fn labels(given: Option<&LabelsTuple>) -> PyResult<Option<Labels>> {
    let labels = given.map(|(names, index)| {
        Ok::<_, PyErr>(Labels { names: names.clone(), index: elements(index)?.to_vec() })
    });
    labels.transpose()
}

fn unit(name: &str) -> PyResult<Unit> {
    named("unit", name, [Unit::Angstrom, Unit::Nanometre, Unit::Metre], unit_name)
}

fn unit_name(unit: Unit) -> &'static str {
    match unit {
        Unit::Angstrom => "angstrom",
        Unit::Nanometre => "nanometre",
        Unit::Metre => "metre",
        Unit::Unknown => "unknown",
    }
}

/// Checks the values of columns.
#[pyfunction]
pub(crate) fn check_particles(py: Python, columns: Columns) -> PyResult<()> {
    let particles = columns.particles()?;
    work(py, || particles.check())?.map_err(InputError::new_err)
}

/// The atomic numbers of symbols of elements; 0 for an empty one.
#[pyfunction]
pub(crate) fn atomic_numbers(symbols: Vec<String>) -> PyResult<Vec<u16>> {
    let number = |symbol: &String| match by_symbol(symbol) {
        None if !symbol.is_empty() => {
            Err(of_key("elements", &format!("{symbol:?} is no symbol of an element")))
        }
        number => Ok(number.map_or(0, u16::from)),
    };
    symbols.iter().map(number).collect()
}

/// Reads a frame of a file, with all properties or those named, in at most so many bytes; returns its columns.
#[pyfunction]
pub(crate) fn read_particles(
    py: Python<'_>,
    path: PathBuf,
    frame: String,
    properties: Option<Vec<String>>,
    memory: u64,
) -> PyResult<Bound<'_, PyDict>> {
    let frame = figure::recipe::parse_frame(&frame).map_err(|problem| of_key("frame", &problem))?;
    let properties = properties.map_or(Properties::All, Properties::Named);
    let request = Request { frame, properties, memory };
    let found = work_until_interrupted(py, &Stop::new(), move || read(&path, &request))?;
    columns(py, found.map_err(|error| FileError::new_err(error.to_string()))?)
}

/// The number of frames of a file.
#[pyfunction]
pub(crate) fn count_frames(py: Python, path: PathBuf) -> PyResult<usize> {
    let counted = work_until_interrupted(py, &Stop::new(), move || importers::frames(&path))?;
    counted.map_err(|error| FileError::new_err(error.to_string()))
}

/// The columns of `particles`, which move into the arrays.
fn columns(py: Python<'_>, particles: Particles) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    let labels = |labels: Option<Labels>| {
        labels.map(|Labels { names, index }| Ok::<_, PyErr>((names, values(py, index)?))).transpose()
    };
    let unit = Some(particles.unit).filter(|unit| *unit != Unit::Unknown).map(unit_name);
    let properties = particles.properties.into_iter();
    let properties =
        properties.map(|Property { name, values: all }| Ok::<_, PyErr>((name, values(py, all)?)));
    let cell = particles.cell.map(|Cell { origin, vectors, periodic }| (origin, vectors, periodic));
    all.set_item("title", particles.title)?;
    all.set_item("unit", unit)?;
    all.set_item("positions", rows(py, particles.positions)?)?;
    all.set_item("elements", particles.elements.map(|all| values(py, all)).transpose()?)?;
    all.set_item("types", labels(particles.types)?)?;
    all.set_item("radii", particles.radii.map(|all| values(py, all)).transpose()?)?;
    all.set_item("colors", particles.colors.map(|all| rows(py, all)).transpose()?)?;
    all.set_item("names", labels(particles.names)?)?;
    all.set_item("residues", labels(particles.residues)?)?;
    all.set_item("residue_numbers", particles.residue_numbers.map(|all| values(py, all)).transpose()?)?;
    all.set_item("chains", labels(particles.chains)?)?;
    all.set_item("molecules", particles.molecules.map(|all| values(py, all)).transpose()?)?;
    all.set_item("ids", particles.ids.map(|all| values(py, all)).transpose()?)?;
    all.set_item("properties", properties.collect::<Result<Vec<_>, _>>()?)?;
    all.set_item("bonds", rows(py, particles.bonds)?)?;
    all.set_item("cell", cell)?;
    Ok(all)
}

/// A file of particles, or their columns.
#[allow(clippy::large_enum_variant)] // there is one at a time
#[derive(FromPyObject)]
pub(crate) enum Source<'py> {
    /// A file.
    #[pyo3(transparent)]
    File(PathBuf),
    /// Columns.
    #[pyo3(transparent)]
    Columns(Columns<'py>),
}

/// What makes spheres of particles: texts as scene files have them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Style {
    keys: Entries,
    origin: [f64; 3],
    cut: Vec<String>,
    /// The style of all particles.
    base: Entries,
    /// Rules for some.
    rules: Vec<RuleText>,
}

/// A rule of a style.
#[derive(FromPyObject)]
pub(crate) enum RuleText {
    /// As on the command line.
    #[pyo3(transparent)]
    Line(String),
    /// As in scene files.
    #[pyo3(transparent)]
    Entries(Entries),
}

impl Style {
    fn recipe(&self) -> PyResult<Recipe> {
        let mut recipe = Recipe { origin: self.origin, ..Recipe::default() };
        for (key, text) in &self.keys {
            recipe.set(key, text).map_err(|problem| of_key(key, &problem))?;
        }
        for text in &self.cut {
            let cut =
                Selection::parse(text).map_err(|error| of_key("cut", &format!("{error} of '{text}'")))?;
            recipe.cut.push(cut);
        }
        if !self.base.is_empty() {
            recipe.style.push(rule(&self.base).map_err(InputError::new_err)?);
        }
        for (i, text) in self.rules.iter().enumerate() {
            let parsed = match text {
                RuleText::Line(line) => Rule::parse(line),
                RuleText::Entries(entries) => rule(entries),
            };
            let rule = parsed.map_err(|problem| InputError::new_err(format!("style [{i}]: {problem}")))?;
            recipe.style.push(rule);
        }
        Ok(recipe)
    }
}

fn rule(entries: &Entries) -> Result<Rule, String> {
    let mut rule = Rule::default();
    for (key, text) in entries {
        rule.set(key, text).map_err(|problem| format!("{key}: {problem}"))?;
    }
    Ok(rule)
}

fn of_key(key: &str, problem: &str) -> PyErr {
    InputError::new_err(format!("{key}: {problem}"))
}

/// The exception for what does not suit; the style has a rule for all particles before the others if it `has_base`.
fn of_problem(problem: &Problem, has_base: bool) -> PyErr {
    match problem {
        Problem::Recipe(Refusal { rule, key, problem }) => {
            match rule.map(|rule| rule.checked_sub(usize::from(has_base))) {
                Some(Some(rule)) => InputError::new_err(format!("style [{rule}]: {key}: {problem}")),
                _ if *key == "file" => InputError::new_err(problem.clone()),
                _ => of_key(key, problem),
            }
        }
        Problem::Stage(problem) => InputError::new_err(problem.clone()),
        Problem::Read(problem) | Problem::Changed(problem) => FileError::new_err(problem.clone()),
    }
}

/// Camera, lamps and background around particles.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct StageOptions {
    view: Option<String>,
    zoom: f64,
    light: String,
    ground: bool,
    background: Option<String>,
    size: [u32; 2],
}

impl StageOptions {
    fn stage(&self) -> PyResult<Stage> {
        let background = self.background.as_deref().map(Background::parse).transpose();
        let background = background.map_err(|problem| of_key("background", &problem))?.unwrap_or_default();
        Ok(Stage {
            view: self.view.as_deref().map(|name| named("view", name, View::ALL, View::name)).transpose()?,
            zoom: self.zoom,
            light: named("light", &self.light, Light::ALL, Light::name)?,
            ground: self.ground,
            background,
            size: self.size,
        })
    }
}

/// The particles of a source: columns, or what `recipe` needs of a file in at most so many bytes.
fn particles_of(
    source: Source,
    recipe: &Recipe,
    memory: u64,
) -> PyResult<impl FnOnce() -> Result<Particles, Problem> + Send + 'static> {
    let request = recipe.request(memory);
    let (file, columns) = match source {
        Source::File(path) => (path, None),
        Source::Columns(columns) => (PathBuf::new(), Some(columns.particles()?)),
    };
    let from_file = move || read(&file, &request).map_err(|error| Problem::Read(error.to_string()));
    Ok(move || columns.map_or_else(from_file, Ok))
}

/// A scene that shows particles: with camera, lamps and settings. Returns notes too.
#[pyfunction]
pub(crate) fn stage_particles(
    py: Python,
    source: Source,
    style: Style,
    stage: StageOptions,
    name: Option<String>,
    memory: u64,
) -> PyResult<(Scene, Vec<String>)> {
    let (recipe, stage) = (style.recipe()?, stage.stage()?);
    let file = if let Source::File(path) = &source { Some(path.clone()) } else { None };
    let name = name.unwrap_or_else(|| file.as_deref().map_or("particles".into(), particles::stem));
    let particles = particles_of(source, &recipe, memory)?;
    let staged = work_until_interrupted(py, &Stop::new(), move || {
        particles::staged_in_memory(particles()?, &name, &recipe, &stage)
    })?;
    let has_base = !style.base.is_empty();
    let Staged { scene, notes } = staged.map_err(|problem| of_problem(&problem, has_base))?;
    Ok((Scene::stage(scene, file), notes))
}

/// Adds the spheres of particles to a scene; returns the first, the one after the last, and notes.
#[pyfunction]
pub(crate) fn add_particles(
    py: Python,
    scene: &Scene,
    source: Source,
    style: Style,
    memory: u64,
) -> PyResult<(usize, usize, Vec<String>)> {
    let recipe = style.recipe()?;
    let particles = particles_of(source, &recipe, memory)?;
    let made = work_until_interrupted(py, &Stop::new(), move || {
        balls(particles()?, &recipe).map_err(Problem::Recipe)
    })?;
    let mut made = made.map_err(|problem| of_problem(&problem, !style.base.is_empty()))?;
    let notes = std::mem::take(&mut made.notes);
    let (added, _) = scene.edit(py, |scene| particles::join(scene, made))?;
    Ok((added.start, added.end, notes))
}
