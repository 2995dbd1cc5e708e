//! Metrics of two images.

use crate::columns::{picture, vectors};
use crate::errors::InputError;
use crate::work::work_on;
use ::compare::Metrics;
use numpy::{PyArray3, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use scene::{Film, FilmRows, Rgb};

fn film(radiance: &PyReadonlyArray3<f32>) -> PyResult<Film> {
    let [height, width] = [radiance.shape()[0], radiance.shape()[1]].map(|side| side as u32);
    let pixels = vectors(radiance)?.iter().map(|&pixel| Rgb::from_array(pixel)).collect();
    Ok(Film { width, height, pixels })
}

/// The metrics of `a`, judged against `b`, as JSON.
#[pyfunction]
pub(crate) fn compare(
    py: Python,
    a: PyReadonlyArray3<f32>,
    b: PyReadonlyArray3<f32>,
    hdr_flip: bool,
) -> PyResult<String> {
    let (a, b) = (film(&a)?, film(&b)?);
    let metrics = work_on(py, None, || {
        Metrics::of_rows(&mut FilmRows::new(&a), &mut FilmRows::new(&b), hdr_flip, &mut |_, _| {})
    })?;
    let metrics = metrics.map_err(|error| InputError::new_err(error.to_string()))?;
    serde_json::to_string(&metrics).map_err(|error| InputError::new_err(error.to_string()))
}

/// The difference of two images in false colours, and the difference that its brightest colour stands for.
#[pyfunction]
pub(crate) fn difference_image<'py>(
    py: Python<'py>,
    a: PyReadonlyArray3<f32>,
    b: PyReadonlyArray3<f32>,
) -> PyResult<(Bound<'py, PyArray3<f32>>, f32)> {
    let (a, b) = (film(&a)?, film(&b)?);
    let image = work_on(py, None, || ::compare::difference_image(&a, &b))?;
    let image = image.map_err(|error| InputError::new_err(error.to_string()))?;
    Ok((picture(py, [image.film.width, image.film.height], image.film.pixels)?, image.scale))
}
