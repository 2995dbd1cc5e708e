//! Arrays of the spheres of a scene: a row per sphere.

use crate::errors::{InputError, SceneError};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{Element, PyArray, PyArray1, PyReadonlyArray, ndarray};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use scene::{Rgb, Sphere, Vec3};

/// The elements of a C-contiguous array.
///
/// # Errors
/// If it is not C-contiguous.
pub(crate) fn elements<'a, T: Element, D: ndarray::Dimension>(
    array: &'a PyReadonlyArray<T, D>,
) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| InputError::new_err("the array is not C-contiguous"))
}

/// The vectors in an array of shape (n, N), or (h, w, N).
///
/// # Errors
/// If it is not C-contiguous, or its last side is not N.
pub(crate) fn vectors<'a, T: Element, D: ndarray::Dimension, const N: usize>(
    array: &'a PyReadonlyArray<T, D>,
) -> PyResult<&'a [[T; N]]> {
    let (vectors, rest) = elements(array)?.as_chunks();
    if rest.is_empty() { Ok(vectors) } else { Err(InputError::new_err(format!("the last side is not {N}"))) }
}

/// An array that owns `values` and is read-only.
pub(crate) fn values<T: Element>(
    py: Python<'_>,
    values: Vec<T>,
) -> PyResult<Bound<'_, PyArray<T, ndarray::Ix1>>> {
    frozen(PyArray1::from_owned_array(py, Array1::from_vec(values)))
}

/// A read-only array of shape (n, N) that owns `rows`.
pub(crate) fn rows<T: Element, const N: usize>(
    py: Python<'_>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'_, PyArray<T, ndarray::Ix2>>> {
    let array = Array2::from_shape_vec((rows.len(), N), rows.into_flattened());
    frozen(PyArray::from_owned_array(py, array.map_err(shape_error)?))
}

/// A read-only array of shape (h, w) that owns `values`.
pub(crate) fn plane(
    py: Python<'_>,
    size: [u32; 2],
    values: Vec<f32>,
) -> PyResult<Bound<'_, PyArray<f32, ndarray::Ix2>>> {
    let [width, height] = size.map(|side| side as usize);
    let array = Array2::from_shape_vec((height, width), values);
    frozen(PyArray::from_owned_array(py, array.map_err(shape_error)?))
}

/// A read-only array of shape (h, w, 3) that owns `pixels`.
pub(crate) fn picture(
    py: Python<'_>,
    size: [u32; 2],
    pixels: Vec<Rgb>,
) -> PyResult<Bound<'_, PyArray<f32, ndarray::Ix3>>> {
    let [width, height] = size.map(|side| side as usize);
    // In place: a colour and an array have the same size and alignment.
    let numbers = pixels.into_iter().map(|pixel| pixel.to_array()).collect::<Vec<_>>().into_flattened();
    let array = Array3::from_shape_vec((height, width, 3), numbers);
    frozen(PyArray::from_owned_array(py, array.map_err(shape_error)?))
}

fn shape_error(error: ndarray::ShapeError) -> PyErr {
    InputError::new_err(error.to_string())
}

fn frozen<T: Element, D: ndarray::Dimension>(
    array: Bound<'_, PyArray<T, D>>,
) -> PyResult<Bound<'_, PyArray<T, D>>> {
    array.call_method("setflags", (), Some(&[("write", false)].into_py_dict(array.py())?))?;
    Ok(array)
}

/// A value of spheres that is a vector.
#[derive(Clone, Copy)]
pub(crate) enum Vector {
    Center,
    Velocity,
    Emission,
}

impl Vector {
    /// # Errors
    /// If there is none of this name.
    pub(crate) fn named(name: &str) -> PyResult<Self> {
        match name {
            "center" => Ok(Self::Center),
            "velocity" => Ok(Self::Velocity),
            "emission" => Ok(Self::Emission),
            _ => Err(SceneError::new_err(format!("spheres have no vector {name:?}"))),
        }
    }

    pub(crate) fn get(self, sphere: &Sphere) -> [f32; 3] {
        match self {
            Self::Center => sphere.center,
            Self::Velocity => sphere.velocity,
            Self::Emission => sphere.emission,
        }
        .to_array()
    }

    pub(crate) fn set(self, sphere: &mut Sphere, vector: [f32; 3]) {
        let vector = Vec3::from_array(vector);
        match self {
            Self::Center => sphere.center = vector,
            Self::Velocity => sphere.velocity = vector,
            Self::Emission => sphere.emission = vector,
        }
    }
}
