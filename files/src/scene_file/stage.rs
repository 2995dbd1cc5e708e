//! Reads the section `[stage]` of a scene file: camera, lamps and settings that follow from the spheres.

use super::error::Fault;
use super::reader::{Field, Section};
use super::settings::named;
use crate::particles;
use figure::stage::{self, Background, Light, Stage, View};
use scene::{Scene, Settings};

const KEYS: [&str; 5] = ["view", "zoom", "light", "ground", "background"];
const ZOOMS: [f32; 2] = [0.1, 1000.0];

pub(super) fn section(field: Field<'_>) -> Result<Section<'_>, Fault> {
    field.section("[stage]", &KEYS)
}

/// The settings of a stage on which nothing is seen yet: the size of its image.
pub(super) fn size_alone() -> Settings {
    let [width, height] = Stage::default().size;
    Settings { width, height, ..Settings::default() }
}

/// Puts `scene`, which has no sky yet, on the stage, for an image of this `size`. Returns the settings of the stage; those of the
/// scene are left as they are.
pub(super) fn set(
    section: &Section<'_>,
    scene: &mut Scene,
    has_cell: bool,
    size: [u32; 2],
) -> Result<Settings, Fault> {
    if scene.spheres.is_empty() {
        return Err(Fault::new(
            section.at,
            "there is nothing on the [stage]; add [[particles]] or a [[sphere]]",
        ));
    }
    let set = stage::set(&scene.spheres, &scene.materials, has_cell, &wanted(section, size)?);
    let set = set.map_err(|problem| Fault::new(section.at, format!("[stage]: {problem}")))?;
    Ok(particles::set_up(scene, set))
}

fn wanted(section: &Section<'_>, size: [u32; 2]) -> Result<Stage, Fault> {
    let usual = Stage::default();
    let [low, high] = ZOOMS;
    let range = format!("is outside [{low}, {high}]");
    let zoom = |field: Field<'_>| field.number()?.check(|zoom| (low..=high).contains(&zoom), &range);
    let background = |field: Field<'_>| {
        Background::parse(field.text()?)
            .map_err(|problem| Fault::new(field.at, format!("background of [stage]: {problem}")))
    };
    Ok(Stage {
        view: section.get("view").map(|field| named(&field, "views", View::ALL, View::name)).transpose()?,
        zoom: section.or("zoom", usual.zoom as f32, zoom)?.into(),
        light: section.or("light", usual.light, |field| named(&field, "lights", Light::ALL, Light::name))?,
        ground: section.or("ground", usual.ground, |field| field.truth())?,
        background: section.or("background", usual.background, background)?,
        size,
    })
}
