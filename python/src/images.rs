//! Image files.

use crate::columns::{elements, picture, vectors};
use crate::errors::{FileError, InputError};
use crate::work::{work, work_on};
use files::image_file::{self, Encoding, ImageReader, Tone};
use numpy::ndarray::Array3;
use numpy::{PyArray3, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use render::Metadata;
use scene::srgb::encode_byte;
use scene::{Picture, Rgb, RowReader as _};
use std::path::PathBuf;

/// The name of a tone curve, and the white of Reinhard's.
type ToneTuple = (String, f32);

/// Writes an image, with the metadata in `note`. Pictures have the tone `usual` if no `tone` is given.
#[pyfunction]
pub(crate) fn write_image(
    py: Python,
    path: PathBuf,
    radiance: PyReadonlyArray3<f32>,
    note: Option<String>,
    exposure: Option<f32>,
    tone: Option<ToneTuple>,
    usual: Option<ToneTuple>,
) -> PyResult<()> {
    let is_exposed = render::is_exposed(&path);
    for (name, is_given) in [("exposure", exposure.is_some()), ("tone", tone.is_some())] {
        if is_given && !is_exposed {
            let path = path.display();
            let problem =
                format!("{name}: {path} holds linear radiance; only .png and .jpg are exposed and toned");
            return Err(InputError::new_err(problem));
        }
    }
    let tone = tone.or(usual).map_or(Ok(Tone::default()), curve)?;
    let made = note.as_deref().and_then(Metadata::from_note);
    let seed = made.as_ref().map_or(0, |metadata| metadata.settings.seed);
    let note = made.map(|made| Metadata { exposure, tone: is_exposed.then_some(tone), ..made }.to_note());
    let [height, width] = [radiance.shape()[0], radiance.shape()[1]];
    let pixels = vectors(&radiance)?;
    let written = work_on(py, None, || {
        let encoding = Encoding { exposure: exposure.unwrap_or(0.0), tone, seed, note: note.as_deref() };
        let pixel = |x: u32, y: u32| Rgb::from_array(pixels[y as usize * width + x as usize]);
        let picture = Picture { width: width as u32, height: height as u32, pixel: &pixel };
        image_file::write_picture(&path, &picture, &encoding)
    })?;
    written.map_err(|error| FileError::new_err(error.to_string()))
}

fn curve((name, white): ToneTuple) -> PyResult<Tone> {
    Tone::named(&name, white).ok_or_else(|| {
        let names = Tone::NAMES.map(|name| format!("{name:?}")).join(", ");
        InputError::new_err(format!("tone {name:?}: there is no such; it is one of {names}"))
    })
}

/// Writes an image of one value per pixel, the layer `name`.
#[pyfunction]
pub(crate) fn write_plane(
    py: Python,
    path: PathBuf,
    values: PyReadonlyArray2<f32>,
    name: &str,
    note: Option<String>,
) -> PyResult<()> {
    let [height, width] = [values.shape()[0], values.shape()[1]];
    let values = elements(&values)?;
    let written = work_on(py, None, || {
        let encoding = Encoding { note: note.as_deref(), ..Encoding::default() };
        let value = |x: u32, y: u32| values[y as usize * width + x as usize];
        let picture = Picture { width: width as u32, height: height as u32, pixel: &value };
        image_file::write_values(&path, &picture, name, &encoding)
    })?;
    written.map_err(|error| FileError::new_err(error.to_string()))
}

/// Reads an image, or one of its layers; also the note in it, if it is metadata of a render.
#[pyfunction]
pub(crate) fn read_image(
    py: Python<'_>,
    path: PathBuf,
    layer: Option<String>,
) -> PyResult<(Bound<'_, PyArray3<f32>>, Option<String>)> {
    let read = work_on(py, None, || {
        let mut reader = ImageReader::open(&path, layer.as_deref()).map_err(|error| error.to_string())?;
        let size = reader.size();
        let mut pixels = vec![Rgb::ZERO; size[0] as usize * size[1] as usize];
        reader.read(&mut pixels)?;
        let note = image_file::read_note(&path).map_err(|error| error.to_string())?;
        Ok::<_, String>((size, pixels, note.filter(|note| Metadata::from_note(note).is_some())))
    })?;
    let (size, pixels, note) = read.map_err(FileError::new_err)?;
    Ok((picture(py, size, pixels)?, note))
}

/// The picture that a screen shows of linear radiance: 8 bits of sRGB.
#[pyfunction]
pub(crate) fn srgb<'py>(
    py: Python<'py>,
    radiance: PyReadonlyArray3<f32>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let shape = [0, 1, 2].map(|side| radiance.shape()[side]);
    let values = elements(&radiance)?;
    let codes = work(py, || values.iter().map(|&v| encode_byte(v.into())).collect::<Vec<u8>>())?;
    let array =
        Array3::from_shape_vec(shape, codes).map_err(|error| InputError::new_err(error.to_string()))?;
    Ok(PyArray3::from_owned_array(py, array))
}
