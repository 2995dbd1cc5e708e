//! Particles and a recipe become spheres of a scene.

use crate::color::{Screen, WHITE};
use crate::neighbours::nearest;
use crate::overlap::overlaps;
use crate::paint::paint;
use crate::recipe::{Bonds, Recipe};
use crate::rods::{self, Ends};
use crate::rule::{Finish, Paint, Radius, Rule};
use crate::selection::Selection;
use crate::table::Table;
use crate::units::per_angstrom;
use crate::vector::single;
use glam::{DVec3, Vec3};
use importers::Particles;
use importers::elements::{Element, element};
use rayon::slice::ParallelSliceMut as _;
use scene::check::LIMIT;
use scene::settings::RADIUS_RANGE;
use scene::{Material, Rgb, Sphere};
use std::borrow::Cow;
use std::collections::BTreeMap;
use thiserror::Error;

/// What particles become.
#[derive(Clone, Debug, PartialEq)]
pub struct Balls {
    /// The spheres, sorted: they do not depend on the order of the particles.
    pub spheres: Vec<Sphere>,
    /// Their materials, each once.
    pub materials: Vec<Material>,
    /// What the user should know: sentences without a full stop.
    pub notes: Vec<String>,
}

/// Why a recipe does not suit a file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{key}: {problem}")]
pub struct Refusal {
    /// The rule of the style at fault, from 0; `None` if it is the recipe itself.
    pub rule: Option<usize>,
    /// The key at fault.
    pub key: &'static str,
    /// What is wrong, and what would be right.
    pub problem: String,
}

/// Radius in angstrom of an atom whose element is not known, by both tables.
const UNKNOWN_RADIUS: f64 = 1.5;
/// Share of the van der Waals radius that atoms have between bonds.
const BETWEEN_BONDS: f64 = 0.25;

/// What the surface of a ball is, with its colour. Ordered, so that materials do not depend on the order of particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Surface {
    kind: u8,
    /// The number that belongs to the kind, by its bits.
    number: u32,
    color: Screen,
}

/// Room for the lamps and ground of a stage and for the sky, so that millions of spheres need not be moved for them.
const OTHERS: usize = 8;

/// A ball before the spheres are sorted; its surface is an index.
#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    radius: f32,
    surface: u32,
}

/// The state of all particles while rules are applied.
struct State {
    radii: Vec<f32>,
    colors: Vec<Screen>,
    finishes: Vec<Finish>,
    hidden: Vec<bool>,
    /// The particles that cuts keep; rules are for these alone.
    kept: Vec<u32>,
}

/// The spheres of `particles` by `recipe`.
///
/// # Errors
/// If the recipe does not suit the file, or if a length is out of the range of scenes.
pub fn balls(mut particles: Particles, recipe: &Recipe) -> Result<Balls, Refusal> {
    if recipe.wrap {
        if !particles.cell.is_some_and(|cell| cell.periodic.contains(&true)) {
            return Err(Refusal::of("wrap", "the file has no periodic cell"));
        }
        particles.wrap();
    }
    let mut state = State::new(&particles);
    state.cut(&particles, recipe)?;
    let unit = per_angstrom(&particles, recipe.unit);
    for (i, rule) in rules(&particles, recipe) {
        state.apply(&particles, &rule, unit).map_err(|(key, problem)| Refusal { rule: i, key, problem })?;
    }
    let mut notes = state.drop_without_radius();
    let mut pile = Pile::new(recipe.origin, state.hidden.iter().filter(|hidden| !**hidden).count());
    for i in (0..particles.len()).filter(|&i| !state.hidden[i]) {
        pile.add(particles.positions[i], state.radii[i], state.finishes[i], state.colors[i]);
    }
    if pile.balls.is_empty() {
        if particles.is_empty() {
            return Err(Refusal::of("file", "there is no particle in it"));
        }
        let key = if recipe.cut.is_empty() { "style" } else { "cut" };
        return Err(Refusal::of(key, "no particle is left to be shown"));
    }
    notes.extend(pile.add_bonds(&particles, recipe, &state));
    if recipe.cell {
        let cell = particles.cell.as_ref().ok_or_else(|| Refusal::of("cell", "the file has no cell"))?;
        rods::edges(cell, |p, radius| pile.add(p, radius, Finish::Matte, rods::CELL_COLOR));
    }
    // The spheres need the room.
    drop((particles, state));
    check(&pile.balls).map_err(|problem| Refusal::of("file", problem))?;
    let (spheres, materials) = pile.surfaces.spheres(pile.balls);
    let is_glass = |s: &&Sphere| !materials[s.material as usize].is_opaque();
    notes.extend(overlaps(spheres.iter().filter(is_glass)).then(|| OVERLAP.into()));
    Ok(Balls { spheres, materials, notes })
}

impl Refusal {
    /// A refusal of `key` of the recipe itself.
    fn of(key: &'static str, problem: impl Into<String>) -> Self {
        Self { rule: None, key, problem: problem.into() }
    }
}

/// Balls as they are made.
struct Pile {
    origin: [f64; 3],
    balls: Vec<Ball>,
    surfaces: Surfaces,
}

impl Pile {
    /// No balls, with room for `count`.
    fn new(origin: [f64; 3], count: usize) -> Self {
        Self { origin, balls: Vec::with_capacity(count), surfaces: Surfaces::default() }
    }

    /// Adds a ball at this position in the file.
    fn add(&mut self, position: [f64; 3], radius: f32, finish: Finish, color: Screen) {
        let center = DVec3::from_array(position) - DVec3::from_array(self.origin);
        let surface = self.surfaces.index(finish, color);
        self.balls.push(Ball { center: single(center), radius, surface });
    }

    /// Adds the bonds that `recipe` asks for; each half looks as its atom does. Returns a note if there are none.
    fn add_bonds(&mut self, particles: &Particles, recipe: &Recipe, state: &State) -> Option<String> {
        let bonds = match recipe.bonds? {
            Bonds::File => Cow::Borrowed(&particles.bonds),
            Bonds::Distance => Cow::Owned(importers::bonds::by_distance(particles)),
        };
        for pair in bonds.iter().map(|pair| pair.map(|i| i as usize)) {
            if pair.iter().any(|&i| state.hidden[i]) {
                continue;
            }
            let ends = Ends::new(particles, pair, pair.map(|i| state.radii[i]));
            for (i, sign) in pair.into_iter().zip([1.0, -1.0]) {
                ends.half(particles.positions[i], sign, state.radii[i], |p, radius| {
                    self.add(p, radius, state.finishes[i], state.colors[i]);
                });
            }
        }
        bonds.is_empty().then(|| "there are no bonds to draw".into())
    }
}

/// The rules of `recipe` with their places, after those that hold if it says nothing.
fn rules<'a>(particles: &Particles, recipe: &'a Recipe) -> Vec<(Option<usize>, Cow<'a, Rule>)> {
    let first = recipe.style.first().filter(|rule| rule.only.is_none());
    let mut usual = Rule::default();
    if first.is_none_or(|rule| rule.radius.is_none()) {
        let has_elements = particles.elements.is_some();
        usual.radius = Some(match particles.radii {
            Some(_) => Radius::Column("radius".into()),
            None if has_elements => Radius::VanDerWaals,
            None => Radius::Touch,
        });
        usual.scale =
            (recipe.bonds.is_some() && particles.radii.is_none() && has_elements).then_some(BETWEEN_BONDS);
    }
    if first.is_none_or(|rule| rule.color.is_none()) {
        usual.color = if particles.colors.is_some() {
            Some(Paint::File)
        } else if particles.elements.is_some() {
            Some(Paint::Jmol)
        } else {
            particles.types.as_ref().map(|_| Paint::Column("type".into()))
        };
    }
    let own = recipe.style.iter().enumerate().map(|(i, rule)| (Some(i), Cow::Borrowed(rule)));
    [(None, Cow::Owned(usual))].into_iter().chain(own).collect()
}

impl State {
    fn new(particles: &Particles) -> Self {
        let count = particles.len();
        // The file's own radii can be selected by before a rule has set any.
        let radii = particles.radii.clone().unwrap_or_else(|| vec![0.0; count]);
        Self {
            radii,
            colors: vec![USUAL; count],
            finishes: vec![Finish::Matte; count],
            hidden: vec![false; count],
            kept: (0..count as u32).collect(),
        }
    }

    /// Hides for good what the cuts of `recipe` do not keep.
    fn cut(&mut self, particles: &Particles, recipe: &Recipe) -> Result<(), Refusal> {
        let table = Table { particles, radii: &self.radii };
        for cut in &recipe.cut {
            let test = cut.bind(&table);
            let test = test.map_err(|error| Refusal::of("cut", format!("{error} in `{cut}`")))?;
            self.kept.retain(|&i| test.holds(i as usize));
        }
        if !recipe.cut.is_empty() {
            self.hidden.fill(true);
            self.kept.iter().for_each(|&i| self.hidden[i as usize] = false);
        }
        Ok(())
    }

    /// Applies a rule; an error is a key and what is wrong with it.
    fn apply(&mut self, particles: &Particles, rule: &Rule, unit: f64) -> Result<(), (&'static str, String)> {
        let table = Table { particles, radii: &self.radii };
        let chosen = chosen(&self.kept, &table, rule.only.as_ref()).map_err(|problem| ("where", problem))?;
        if let Some(color) = &rule.color {
            paint(&table, rule, color, &chosen, &mut self.colors).map_err(|problem| ("color", problem))?;
        } else if rule.map.is_some() || rule.range.is_some() {
            let key = if rule.map.is_some() { "map" } else { "range" };
            return Err((key, "this is for a color by a column of numbers, which the rule must name".into()));
        }
        let of = match &rule.radius {
            Some(radius) => radius_of(&table, radius, unit).map_err(|problem| ("radius", problem))?,
            None => Box::new(|i| f64::from(self.radii[i])),
        };
        let chosen = || chosen.iter().map(|&i| i as usize);
        let radii: Vec<f32> = chosen().map(|i| (of(i) * rule.scale.unwrap_or(1.0)) as f32).collect();
        drop(of);
        for (i, radius) in chosen().zip(radii) {
            self.radii[i] = radius;
            self.finishes[i] = rule.material.unwrap_or(self.finishes[i]);
            self.hidden[i] = rule.hide.unwrap_or(self.hidden[i]);
        }
        Ok(())
    }

    /// Hides particles without a radius, and says so.
    fn drop_without_radius(&mut self) -> Vec<String> {
        let mut count = 0_u64;
        for (hidden, radius) in self.hidden.iter_mut().zip(&self.radii) {
            let has_none = radius.is_nan() || *radius <= 0.0;
            count += u64::from(has_none && !*hidden);
            *hidden |= has_none;
        }
        let particles = scene::text::counted(count, "particle");
        if count == 0 {
            Vec::new()
        } else {
            let are = if count == 1 { "is" } else { "are" };
            vec![format!("{particles} without a radius above 0 {are} not shown")]
        }
    }
}

/// The particles of `kept` that a rule is for. Hidden ones are among them, as a rule may show them again.
fn chosen<'a>(
    kept: &'a [u32],
    table: &Table<'_>,
    only: Option<&Selection>,
) -> Result<Cow<'a, [u32]>, String> {
    let Some(only) = only else { return Ok(kept.into()) };
    let test = only.bind(table).map_err(|error| error.to_string())?;
    Ok(kept.iter().copied().filter(|&i| test.holds(i as usize)).collect())
}

/// The colour of particles of which nothing is known.
const USUAL: Screen = Screen([110, 150, 190]);

/// The radius of each particle, in the unit of the file; `unit` is an angstrom in it.
fn radius_of<'a>(
    table: &'a Table<'_>,
    radius: &'a Radius,
    unit: f64,
) -> Result<Box<dyn Fn(usize) -> f64 + 'a>, String> {
    use crate::columns::{Column, Columns as _, unknown};
    let particles = table.particles;
    let of_elements = |of: fn(&Element) -> Option<f32>| -> Result<Box<dyn Fn(usize) -> f64>, String> {
        let missing = "the file has no elements; take touch, a length or the name of a column";
        let elements = particles.elements.as_ref().ok_or(missing)?;
        Ok(Box::new(move |i| unit * element(elements[i]).and_then(of).map_or(UNKNOWN_RADIUS, f64::from)))
    };
    match radius {
        Radius::VanDerWaals => of_elements(van_der_waals),
        Radius::Covalent => of_elements(covalent),
        Radius::Constant(length) => Ok(Box::new(|_| *length)),
        Radius::Touch => {
            // A particle alone, or all in one place: any radius will do.
            let half = nearest(&particles.positions).map_or(unit, |distance| 0.5 * distance);
            Ok(Box::new(move |_| half))
        }
        Radius::Column(name) => match table.column(name) {
            Some(Column::Number(value)) => Ok(value),
            Some(Column::Text { .. }) => Err(format!("`{name}` is a text, and no radius")),
            None => Err(unknown(table, name)),
        },
    }
}

/// Bondi's radius, or that of crystals for an element without one.
fn van_der_waals(element: &Element) -> Option<f32> {
    element.van_der_waals.or(element.alvarez)
}

fn covalent(element: &Element) -> Option<f32> {
    element.covalent
}

/// Checks that all balls are in the range of scenes.
fn check(all: &[Ball]) -> Result<(), String> {
    let [low, high] = RADIUS_RANGE;
    if let Some(ball) = all.iter().find(|ball| !(low..=high).contains(&ball.radius)) {
        let radius = ball.radius;
        return Err(format!(
            "a radius is {radius:e}; it must be from {low:e} to {high:e}, set it by `radius`"
        ));
    }
    let is_far = |ball: &Ball| f64::from(ball.center.abs().max_element()) > LIMIT;
    if all.iter().any(is_far) {
        return Err(format!("a particle is farther than {LIMIT:e} from the origin; take another unit"));
    }
    Ok(())
}

/// The surfaces of balls, each once.
#[derive(Default)]
struct Surfaces {
    places: BTreeMap<Surface, u32>,
    last: Option<(Surface, u32)>,
}

impl Surfaces {
    fn index(&mut self, finish: Finish, color: Screen) -> u32 {
        let surface = Surface::new(finish, color);
        if let Some((last, index)) = self.last
            && last == surface
        {
            return index;
        }
        let next = self.places.len() as u32;
        let index = *self.places.entry(surface).or_insert(next);
        self.last = Some((surface, index));
        index
    }

    /// The spheres of `balls`, sorted and each once, and their materials in the order of the surfaces.
    fn spheres(self, mut balls: Vec<Ball>) -> (Vec<Sphere>, Vec<Material>) {
        let mut ranks = vec![0; self.places.len()];
        for (rank, index) in self.places.values().enumerate() {
            ranks[*index as usize] = rank as u32;
        }
        for ball in &mut balls {
            ball.surface = ranks[ball.surface as usize];
        }
        let key = |ball: &Ball| (ball.center.to_array(), ball.radius, ball.surface);
        balls.par_sort_unstable_by(|a, b| {
            let ((p, r, s), (q, t, u)) = (key(a), key(b));
            let places = p.iter().zip(&q).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
            places.unwrap_or_else(|| r.total_cmp(&t).then(s.cmp(&u)))
        });
        balls.dedup_by_key(|ball| key(ball));
        let surfaces: Vec<Surface> = self.places.into_keys().collect();
        let sphere = |ball: &Ball| Sphere {
            center: ball.center,
            velocity: Vec3::ZERO,
            radius: ball.radius,
            material: ball.surface,
            emission: surfaces[ball.surface as usize].emission(),
        };
        let mut spheres = Vec::with_capacity(balls.len() + OTHERS);
        spheres.extend(balls.iter().map(sphere));
        (spheres, surfaces.into_iter().map(Surface::material).collect())
    }
}

impl Surface {
    fn new(finish: Finish, color: Screen) -> Self {
        let (kind, number) = match finish {
            Finish::Matte => (0, 0.0),
            Finish::Mirror => (1, 0.0),
            Finish::Glass(ior) => (2, ior),
            Finish::Light(radiance) => (3, radiance),
        };
        Self { kind, number: f32::to_bits(number), color }
    }

    fn material(self) -> Material {
        let albedo = self.color.linear();
        match self.kind {
            0 => Material::Diffuse { albedo: albedo * WHITE },
            1 => Material::Specular { albedo },
            2 => Material::Dielectric { albedo, ior: f32::from_bits(self.number) },
            _ => Material::Diffuse { albedo: Rgb::ZERO },
        }
    }

    fn emission(self) -> Rgb {
        if self.kind == 3 { self.color.linear() * f32::from_bits(self.number) } else { Rgb::ZERO }
    }
}

/// The note if balls of glass overlap: there each is drawn as if it were alone, with its own surface within the other.
const OVERLAP: &str = "balls of glass overlap: light passes the surface of each within the other, as it does in no real glass; \
    a smaller radius or scale parts them";
