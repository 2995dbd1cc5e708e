//! Reads materials: `[materials.NAME]`, or inline in a sphere.

use super::error::{Fault, quote, suggestion};
use super::reader::{Field, Number, Section, Subject, type_of};
use scene::Material;
use scene::check::MAX_IOR;
use std::borrow::Cow;
use toml::de::{DeTable, DeValue};

const TYPES: [&str; 3] = ["diffuse", "specular", "dielectric"];
const EXAMPLE: &str = "for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }";

/// The materials of a scene. Those with a name come first, sorted by it.
#[derive(Default)]
pub(super) struct Materials<'t> {
    pub(super) list: Vec<Material>,
    names: Vec<Cow<'t, str>>,
}

/// Materials by name, in the order of the file.
#[derive(Default)]
pub(super) struct Named<'t>(Vec<(Cow<'t, str>, Material)>);

impl<'t> Named<'t> {
    /// Reads the tables in the field `materials` of `root`, if it has one.
    pub(super) fn read(&mut self, root: &DeTable<'t>) -> Result<(), Fault> {
        let Some((key, value)) = root.get_key_value("materials") else { return Ok(()) };
        let Some(table) = value.get_ref().as_table() else {
            let found = type_of(value.get_ref());
            return Err(Fault::new(
                value.span().start,
                format!("{} must be a table for each material, [materials.NAME], not {found}", key.get_ref()),
            ));
        };
        for (name, value) in table {
            let (subject, at) = (Subject::Material(name.get_ref()), value.span().start);
            let Some(table) = value.get_ref().as_table() else {
                let found = type_of(value.get_ref());
                return Err(Fault::new(at, format!("{subject} must be a table, {EXAMPLE}, not {found}")));
            };
            self.0.push((name.get_ref().clone(), material(subject, at, table)?));
        }
        Ok(())
    }

    /// Sorts the materials by name. If a name is given twice, returns it.
    pub(super) fn sort(mut self) -> Result<Materials<'t>, Cow<'t, str>> {
        self.0.sort_by(|a, b| a.0.cmp(&b.0));
        if let Some(i) = self.0.windows(2).position(|pair| pair[0].0 == pair[1].0) {
            return Err(self.0.swap_remove(i).0);
        }
        let (names, list) = self.0.into_iter().unzip();
        Ok(Materials { list, names })
    }
}

impl Materials<'_> {
    /// The index of the material that a sphere's field `material` names or defines inline.
    pub(super) fn resolve(&mut self, field: Field<'_>) -> Result<u32, Fault> {
        match (field.value, field.subject) {
            (DeValue::String(name), _) => {
                let found = self.names.binary_search_by(|there| there.as_ref().cmp(name));
                found.map(|i| i as u32).map_err(|_| self.unknown(field, name))
            }
            (DeValue::Table(table), Subject::Sphere(i, name)) => {
                Ok(self.add(material(Subject::MaterialOf(i, name), field.at, table)?))
            }
            (other, subject) => {
                let found = type_of(other);
                let message =
                    format!("material of {subject} must be a name or a table, {EXAMPLE}, not {found}");
                Err(Fault::new(field.at, message))
            }
        }
    }

    fn add(&mut self, material: Material) -> u32 {
        self.list.push(material);
        self.list.len() as u32 - 1
    }

    fn unknown(&self, field: Field<'_>, name: &str) -> Fault {
        let names = self.names.iter().map(AsRef::as_ref);
        let right = if TYPES.contains(&name) {
            format!("; a type alone is none, write {{ type = {}, albedo = [...] }}", quote(name))
        } else if self.names.is_empty() {
            format!("; write [materials.NAME] and use that name, or write the material here, {EXAMPLE}")
        } else {
            let some: Vec<String> = names.clone().take(8).map(quote).collect();
            let more = if self.names.len() > some.len() { ", ..." } else { "" };
            format!("{}; there is {}{more}", suggestion(name, names), some.join(", "))
        };
        Fault::new(field.at, format!("unknown material {} of {}{right}", quote(name), field.subject))
    }
}

fn material(subject: Subject<'_>, at: usize, table: &DeTable<'_>) -> Result<Material, Fault> {
    let section = Section::new(subject, at, table, &["type", "albedo", "ior"])?;
    let kind = section.require("type", "type = \"diffuse\", \"specular\" or \"dielectric\"")?;
    let name = kind.text()?;
    if !TYPES.contains(&name) {
        let guess = suggestion(name, TYPES);
        return Err(kind.fault(format_args!("is unknown{guess}; the types are {}", TYPES.join(", "))));
    }
    let albedo = section.require("albedo", "albedo = [red, green, blue]")?.rgb(reflectance)?;
    if name == "dielectric" {
        let ior = section.require("ior", "ior = 1.5, say")?.number()?;
        let problem = format_args!("must be a number from 1 to {MAX_IOR}; glass has 1.5");
        let ior = ior.check(|v| (1.0..=MAX_IOR).contains(&v), problem)?;
        return Ok(Material::Dielectric { albedo, ior });
    }
    if let Some(ior) = section.get("ior") {
        return Err(
            ior.fault(format_args!("has no meaning for type {}, only for \"dielectric\"", quote(name)))
        );
    }
    Ok(if name == "diffuse" { Material::Diffuse { albedo } } else { Material::Specular { albedo } })
}

fn reflectance(channel: Number<'_>) -> Result<f32, Fault> {
    channel.check(|v| (0.0..=1.0).contains(&v), "is outside [0, 1]")
}
