//! What rays hit.

use crate::columns::{rows, values, vectors};
use crate::errors::InputError;
use crate::options::choose;
use crate::scene::Scene;
use crate::work::work_on;
use files::npy;
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use render::Renderer;
use scene::{Ray, Vec3};

/// Distances, spheres (-1 for a miss) and normals.
type Hits<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray2<f32>>);

/// The nearest hit of each ray, given by origins and directions, at the shutter time `time`, else when the shutter opens.
#[pyfunction]
pub(crate) fn trace<'py>(
    py: Python<'py>,
    scene: &Scene,
    rays: (PyReadonlyArray2<f32>, PyReadonlyArray2<f32>),
    time: Option<f32>,
    engine: &str,
    lanes: Option<&str>,
    threads: Option<usize>,
) -> PyResult<Hits<'py>> {
    let (origins, directions) = (vectors(&rays.0)?, vectors(&rays.1)?);
    let engine = choose(None, Some(engine), lanes, None, Renderer::default())?;
    let scene = scene.with_sky(py)?;
    let [open, close] = scene.camera.shutter;
    let time = time.unwrap_or(open);
    if !(open..=close).contains(&time) {
        let problem = format!("time: {time} is not while the shutter is open, {open} to {close}");
        return Err(InputError::new_err(problem));
    }
    let traced = work_on(py, threads, || {
        let pairs = origins.iter().zip(directions).enumerate();
        let rays: Result<Vec<Ray>, String> =
            pairs.map(|(i, (origin, direction))| ray(i, *origin, *direction)).collect();
        let hits = render::trace(engine, &scene.at(time), &rays?);
        let sphere = |(t, sphere): (f32, u32)| if t < f32::INFINITY { sphere as i32 } else { -1 };
        let distances: Vec<f32> = hits.iter().map(|hit| hit.0).collect();
        let spheres: Vec<i32> = hits.iter().map(|hit| sphere((hit.0, hit.1))).collect();
        let normals: Vec<[f32; 3]> = hits.iter().map(|hit| hit.2.to_array()).collect();
        Ok::<_, String>((distances, spheres, normals))
    })?;
    let (distances, spheres, normals) = traced.map_err(InputError::new_err)?;
    Ok((values(py, distances)?, values(py, spheres)?, rows(py, normals)?))
}

fn ray(index: usize, origin: [f32; 3], direction: [f32; 3]) -> Result<Ray, String> {
    let ray = npy::ray(Vec3::from_array(origin), Vec3::from_array(direction));
    ray.map_err(|problem| format!("ray [{index}] {problem}"))
}
