//! Reads `[[sphere]]`, the only kind of shape.

use super::error::Fault;
use super::material::Materials;
use super::reader::{Field, Number, Section, Subject, type_of};
use scene::check::LIMIT;
use scene::settings::RADIUS_RANGE;
use scene::{Rgb, Sphere, Vec3};
use toml::Spanned;
use toml::de::{DeArray, DeValue};

const KEYS: [&str; 6] = ["name", "center", "radius", "material", "emission", "velocity"];

/// The array in the field `sphere`, not parsed yet.
pub(super) fn array(field: Field<'_>) -> Result<&DeArray<'_>, Fault> {
    let fault =
        |problem| Fault::new(field.at, format!("sphere {problem}; head every sphere with [[sphere]]"));
    match field.value {
        DeValue::Array(spheres) if spheres.is_empty() => Err(fault("is empty".into())),
        DeValue::Array(spheres) => Ok(spheres),
        DeValue::Table(_) => Err(fault("must be an array of tables, not one table".into())),
        other => Err(fault(format!("must be an array of tables, not {}", type_of(other)))),
    }
}

/// The section of sphere `i`.
pub(super) fn section<'a>(i: usize, value: &'a Spanned<DeValue<'a>>) -> Result<Section<'a>, Fault> {
    let at = value.span().start;
    let Some(table) = value.get_ref().as_table() else {
        let (subject, found) = (Subject::Sphere(i, None), type_of(value.get_ref()));
        return Err(Fault::new(at, format!("{subject} must be a table, [[sphere]], not {found}")));
    };
    let name = table.get("name").and_then(|value| value.get_ref().as_str());
    Section::new(Subject::Sphere(i, name), at, table, &KEYS)
}

pub(super) fn sphere(section: &Section<'_>, materials: &mut Materials<'_>) -> Result<Sphere, Fault> {
    section.or("name", "", name)?;
    Ok(Sphere {
        center: section.require("center", "center = [x, y, z]")?.vector()?,
        radius: positive(section.require("radius", "radius = 1, say")?.number()?)?,
        material: materials.resolve(section.require("material", "material = \"NAME\"")?)?,
        emission: section.or("emission", Rgb::ZERO, |field| field.rgb(radiance))?,
        velocity: section.or("velocity", Vec3::ZERO, |field| field.vector())?,
    })
}

/// The name of the scene or of a sphere.
pub(super) fn name(field: Field<'_>) -> Result<&str, Fault> {
    let text = field.text()?;
    if text.chars().any(char::is_control) {
        return Err(field.fault("has a control character or line break; a name is one line of text"));
    }
    Ok(text)
}

/// A channel of an emission or of the background.
pub(super) fn radiance(channel: Number<'_>) -> Result<f32, Fault> {
    channel.check(|v| v >= 0.0, format_args!("is outside [0, {LIMIT:e}]"))
}

/// A radius in the valid range.
pub(super) fn positive(radius: Number<'_>) -> Result<f32, Fault> {
    let [low, high] = RADIUS_RANGE;
    radius.check(|v| (low..=high).contains(&v), format_args!("must be above 0 (from {low:e} to {high:e})"))
}
