//! Cameras, settings and materials as tuples, in the order of the fields of the package's classes.

use crate::errors::InputError;
use pyo3::PyResult;
use scene::{Camera, Filter, Material, RadiusSchedule, Rgb, Settings, Vec3};

/// Eye, direction, up, `vertical_fov_degrees`, `aperture_radius`, `focus_distance`, shutter.
pub(crate) type CameraTuple = ([f32; 3], [f32; 3], [f32; 3], f32, f32, f32, [f32; 2]);
/// Width, height, iterations, `photons_per_iteration`, `max_depth`, `initial_radius`, seed, filter, radius
/// schedule, `radius_pilots`, `radius_clearance`, and `light_samples` with `glint_samples`.
pub(crate) type SettingsTuple = (u32, u32, u32, u32, u32, f32, u64, String, String, u32, f32, [u32; 2]);
/// Type, albedo, ior (for dielectrics).
pub(crate) type MaterialTuple = (String, [f32; 3], Option<f32>);

pub(crate) fn camera(values: CameraTuple) -> Camera {
    let (eye, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter) = values;
    let [eye, direction, up] = [eye, direction, up].map(Vec3::from_array);
    Camera { eye, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter }
}

pub(crate) fn of_camera(camera: &Camera) -> CameraTuple {
    let Camera { eye, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter } =
        *camera;
    let [eye, direction, up] = [eye, direction, up].map(|v| v.to_array());
    (eye, direction, up, vertical_fov_degrees, aperture_radius, focus_distance, shutter)
}

/// # Errors
/// If there is no such filter or schedule.
pub(crate) fn settings(values: SettingsTuple) -> PyResult<Settings> {
    let (
        width,
        height,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        seed,
        filter,
        schedule,
        radius_pilots,
        radius_clearance,
        [light_samples, glint_samples],
    ) = values;
    let filter = named("filter", &filter, Filter::ALL, Filter::name)?;
    let radius_schedule = named("radius_schedule", &schedule, RadiusSchedule::ALL, RadiusSchedule::name)?;
    Ok(Settings {
        width,
        height,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        seed,
        filter,
        radius_schedule,
        radius_pilots,
        radius_clearance,
        light_samples,
        glint_samples,
    })
}

pub(crate) fn of_settings(settings: &Settings) -> SettingsTuple {
    let Settings {
        width,
        height,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        seed,
        filter,
        radius_schedule,
        radius_pilots,
        radius_clearance,
        light_samples,
        glint_samples,
    } = *settings;
    let (filter, schedule) = (filter.name().into(), radius_schedule.name().into());
    (
        width,
        height,
        iterations,
        photons_per_iteration,
        max_depth,
        initial_radius,
        seed,
        filter,
        schedule,
        radius_pilots,
        radius_clearance,
        [light_samples, glint_samples],
    )
}

/// # Errors
/// If there is no such type.
pub(crate) fn material((kind, albedo, ior): MaterialTuple) -> PyResult<Material> {
    let albedo = Rgb::from_array(albedo);
    match (kind.as_str(), ior) {
        ("diffuse", None) => Ok(Material::Diffuse { albedo }),
        ("specular", None) => Ok(Material::Specular { albedo }),
        ("dielectric", Some(ior)) => Ok(Material::Dielectric { albedo, ior }),
        _ => Err(InputError::new_err(format!("there is no material of type {kind:?}"))),
    }
}

pub(crate) fn of_material(material: &Material) -> MaterialTuple {
    let (kind, ior) = match *material {
        Material::Diffuse { .. } => ("diffuse", None),
        Material::Specular { .. } => ("specular", None),
        Material::Dielectric { ior, .. } => ("dielectric", Some(ior)),
    };
    (kind.into(), material.albedo().to_array(), ior)
}

/// The one of `all` whose name is `given`, for the argument `argument`.
///
/// # Errors
/// If there is none; the message lists all names.
pub(crate) fn named<T: Copy, const N: usize>(
    argument: &str,
    given: &str,
    all: [T; N],
    name: impl Fn(T) -> &'static str,
) -> PyResult<T> {
    all.into_iter().find(|&one| name(one) == given).ok_or_else(|| {
        let names = all.map(|one| format!("{:?}", name(one))).join(", ");
        InputError::new_err(format!("{argument} {given:?}: there is no such; it is one of {names}"))
    })
}
