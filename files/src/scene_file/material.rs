//! Reads materials: `[materials.NAME]`, or inline in a sphere.

use super::error::{Fault, quote, suggestion};
use super::reader::{Field, Number, Section, Subject, type_of};
use scene::Material;
use std::collections::BTreeMap;
use toml::de::DeValue;

/// Greatest index of refraction: far beyond any real material (germanium has 4), yet small enough that the products of
/// squared indices along a path stay in the range of `f32`.
const MAX_IOR: f32 = 100.0;

const TYPES: [&str; 3] = ["diffuse", "specular", "dielectric"];
const EXAMPLE: &str = "for example { type = \"diffuse\", albedo = [0.5, 0.5, 0.5] }";

/// The materials read so far, and the indices of those that have a name.
#[derive(Default)]
pub(super) struct Materials<'a> {
    pub(super) list: Vec<Material>,
    names: BTreeMap<&'a str, u32>,
}

impl<'a> Materials<'a> {
    /// Reads the tables in `[materials]`.
    pub(super) fn read(field: Field<'a>) -> Result<Self, Fault> {
        let Some(table) = field.value.as_table() else {
            let found = type_of(field.value);
            return Err(Fault::new(
                field.at,
                format!("materials must be a table for each material, [materials.NAME], not {found}"),
            ));
        };
        let mut materials = Self::default();
        let keys: Vec<&str> = table.keys().map(|k| k.get_ref().as_ref()).collect();
        for (name, value) in Section::new(Subject::Materials, field.at, table, &keys)?.entries() {
            let (subject, at) = (Subject::Material(name), value.span().start);
            let Some(table) = value.get_ref().as_table() else {
                let found = type_of(value.get_ref());
                return Err(Fault::new(at, format!("{subject} must be a table, {EXAMPLE}, not {found}")));
            };
            let id = materials.add(material(subject, at, table)?);
            materials.names.insert(name, id);
        }
        Ok(materials)
    }

    /// The index of the material that a sphere's field `material` names or defines inline.
    pub(super) fn resolve(&mut self, field: Field<'a>) -> Result<u32, Fault> {
        match (field.value, field.subject) {
            (DeValue::String(name), _) => {
                self.names.get(name.as_ref()).copied().ok_or_else(|| self.unknown(field, name))
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
        let names = self.names.keys().copied();
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

fn material<'a>(
    subject: Subject<'a>,
    at: usize,
    table: &'a toml::de::DeTable<'a>,
) -> Result<Material, Fault> {
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
        let ior =
            ior.check(|v| (1.0..=MAX_IOR).contains(&v), "must be a number from 1 to 100; glass has 1.5")?;
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
