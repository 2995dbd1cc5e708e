//! Reads the section `[camera]` of a scene file.

use super::error::Fault;
use super::reader::{Field, Section, Subject, type_of};
use scene::check::is_parallel;
use scene::{Camera, Vec3};

const KEYS: [&str; 8] = [
    "eye",
    "target",
    "direction",
    "up",
    "vertical_fov_degrees",
    "aperture_radius",
    "focus_distance",
    "shutter",
];

/// The section `[camera]` in `field`.
pub(super) fn section(field: Field<'_>) -> Result<Section<'_>, Fault> {
    match field.value.as_table() {
        Some(table) => Section::new(Subject::Camera, field.at, table, &KEYS),
        None => Err(Fault::new(
            field.at,
            format!("camera must be a table, [camera], not {}", type_of(field.value)),
        )),
    }
}

pub(super) fn camera(section: &Section<'_>) -> Result<Camera, Fault> {
    let eye = section.require("eye", "eye = [x, y, z]")?.vector()?;
    let view = view(section)?;
    let (direction, distance) = direction(view, eye)?;
    let up = section.or("up", Vec3::Y, |field| field.vector())?;
    check_up(section, view, up, direction)?;
    let fov = section.require("vertical_fov_degrees", "vertical_fov_degrees = 30, say")?.number()?;
    let vertical_fov_degrees = fov.check(|v| v > 0.0 && v < 180.0, "is outside (0, 180)")?;
    let aperture_radius = section.or("aperture_radius", 0.0, |field| {
        field.number()?.check(|v| v >= 0.0, "must be a finite number, at least 0; 0 is a pinhole")
    })?;
    let shutter = section.or("shutter", [0.0; 2], shutter)?;
    let focus_distance = focus_distance(section, distance, aperture_radius)?;
    Ok(Camera { eye, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter })
}

/// The field `target` or `direction`; exactly one of them must be given.
fn view<'a>(section: &Section<'a>) -> Result<Field<'a>, Fault> {
    match (section.get("target"), section.get("direction")) {
        (Some(view), None) | (None, Some(view)) => Ok(view),
        (None, None) => section.require("target", "target = [x, y, z], or direction = [x, y, z]"),
        (Some(target), Some(direction)) => Err(Fault::new(
            target.at.max(direction.at),
            "[camera] has both target and direction; it must have one of them",
        )),
    }
}

/// The viewing direction, and the distance to the target if one is given.
fn direction(view: Field<'_>, eye: Vec3) -> Result<(Vec3, Option<f32>), Fault> {
    let given = view.vector()?;
    if view.key == "direction" {
        return match given {
            Vec3::ZERO => Err(Fault::new(view.at, "direction of [camera] is zero; it must point somewhere")),
            direction => Ok((direction, None)),
        };
    }
    match given - eye {
        Vec3::ZERO => Err(Fault::new(view.at, "target of [camera] is where eye is; it must be elsewhere")),
        direction => Ok((direction, Some(direction.as_dvec3().length() as f32))),
    }
}

fn check_up(section: &Section<'_>, view: Field<'_>, up: Vec3, direction: Vec3) -> Result<(), Fault> {
    let given = section.get("up");
    let at = given.map_or(view.at, |field| field.at);
    if up == Vec3::ZERO {
        return Err(Fault::new(at, "up of [camera] is zero; it must point somewhere"));
    }
    if !is_parallel(up, direction) {
        return Ok(());
    }
    let which = if given.is_some() { "up" } else { "up (by default [0, 1, 0])" };
    Err(Fault::new(
        at,
        format!("{which} of [camera] is parallel to the viewing direction; take another, say [0, 0, 1]"),
    ))
}

fn shutter(field: Field<'_>) -> Result<[f32; 2], Fault> {
    let [open, close] = field.numbers("[open, close]")?;
    let begin = open.finite()?;
    close.finite()?;
    let end = close.check(|v| v >= begin, format_args!("closes before the shutter opens at {begin}"))?;
    Ok([begin, end])
}

fn focus_distance(section: &Section<'_>, to_target: Option<f32>, aperture: f32) -> Result<f32, Fault> {
    let lens = section.get("aperture_radius").filter(|_| aperture > 0.0);
    match (section.get("focus_distance"), to_target, lens) {
        (Some(field), _, _) => {
            field.number()?.check(|v| v > 0.0, "must be a finite number above 0, the distance from the eye")
        }
        (None, Some(distance), _) => Ok(distance),
        (None, None, Some(lens)) => Err(Fault::new(
            lens.at,
            "[camera] has an aperture_radius but no focus_distance; add focus_distance = 100, say, or a target",
        )),
        // A pinhole has everything in focus.
        (None, None, None) => Ok(1.0),
    }
}
