//! Image files.

use crate::columns::{elements, picture, vectors};
use crate::errors::{FileError, InputError};
use crate::work::work_on;
use files::image_file::{self, Encoding, Format, ImageError, ImageReader, Tone};
use numpy::ndarray::Array3;
use numpy::{PyArray3, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use render::Metadata;
use scene::{Picture, Rgb, Rgba, RowReader as _};
use std::path::{Path, PathBuf};

/// The name of a tone curve, and the white of Reinhard's.
type ToneTuple = (String, f32);
/// Colours, and alpha if the image has it.
type PixelsTuple<'py> = (PyReadonlyArray3<'py, f32>, Option<PyReadonlyArray2<'py, f32>>);

/// The pixels of an image in arrays.
struct Pixels<'a> {
    width: u32,
    height: u32,
    colors: &'a [[f32; 3]],
    alphas: Option<&'a [f32]>,
}

impl<'a> Pixels<'a> {
    fn of((colors, alphas): &'a PixelsTuple) -> PyResult<Self> {
        let [height, width] = [colors.shape()[0], colors.shape()[1]];
        if alphas.as_ref().is_some_and(|alphas| alphas.shape() != [height, width]) {
            return Err(InputError::new_err("alpha is of another size than the image"));
        }
        let alphas = alphas.as_ref().map(elements).transpose()?;
        Ok(Self { width: width as u32, height: height as u32, colors: vectors(colors)?, alphas })
    }

    fn place(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    fn color(&self, x: u32, y: u32) -> Rgb {
        Rgb::from_array(self.colors[self.place(x, y)])
    }

    /// The pixel of an image whose alphas are `alphas`.
    fn rgba(&self, alphas: &[f32], x: u32, y: u32) -> Rgba {
        Rgba { color: self.color(x, y), alpha: alphas[self.place(x, y)] }
    }

    fn picture<'b, T>(&self, pixel: &'b dyn scene::film::Pixels<T>) -> Picture<'b, T> {
        Picture { width: self.width, height: self.height, pixel }
    }

    fn write(&self, path: &Path, encoding: &Encoding) -> Result<(), ImageError> {
        match self.alphas {
            None => image_file::write_picture(path, &self.picture(&|x, y| self.color(x, y)), encoding),
            Some(alphas) => {
                let picture = |x, y| self.rgba(alphas, x, y);
                image_file::write_transparent(path, &self.picture(&picture), encoding)
            }
        }
    }

    /// The codes that a PNG file holds, and how many there are of a pixel.
    fn codes(&self, encoding: &Encoding) -> (Vec<u8>, usize) {
        match self.alphas {
            None => {
                let picture = |x, y| self.color(x, y);
                (image_file::codes(&self.picture(&picture), encoding).into_flattened(), 3)
            }
            Some(alphas) => {
                let picture = |x, y| self.rgba(alphas, x, y);
                (image_file::codes_with_alpha(&self.picture(&picture), encoding).into_flattened(), 4)
            }
        }
    }
}

/// Writes an image, with the metadata in `note`. Pictures have the tone `usual` if no `tone` is given.
#[pyfunction]
pub(crate) fn write_image(
    py: Python,
    path: PathBuf,
    pixels: PixelsTuple,
    note: Option<String>,
    exposure: Option<f32>,
    tone: Option<ToneTuple>,
    usual: Option<ToneTuple>,
) -> PyResult<()> {
    let pixels = Pixels::of(&pixels)?;
    check_format(&path, exposure.is_some(), tone.is_some(), pixels.alphas.is_some())?;
    let tone = tone.or(usual).map_or(Ok(Tone::default()), curve)?;
    let made = note.as_deref().and_then(Metadata::from_note);
    let seed = seed(made.as_ref());
    let shown_tone = render::is_exposed(&path).then_some(tone);
    let note = made.map(|made| Metadata { exposure, tone: shown_tone, ..made }.to_note());
    let written = work_on(py, None, || {
        let encoding = Encoding { exposure: exposure.unwrap_or(0.0), tone, seed, note: note.as_deref() };
        pixels.write(&path, &encoding)
    })?;
    written.map_err(|error| FileError::new_err(error.to_string()))
}

/// The codes of sRGB, of shape (height, width, 3), or 4 with alpha, that a PNG file holds which [`write_image`] writes.
#[pyfunction]
pub(crate) fn codes<'py>(
    py: Python<'py>,
    pixels: PixelsTuple,
    note: Option<String>,
    exposure: Option<f32>,
    tone: Option<ToneTuple>,
    usual: Option<ToneTuple>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let pixels = Pixels::of(&pixels)?;
    let tone = tone.or(usual).map_or(Ok(Tone::default()), curve)?;
    let seed = seed(note.as_deref().and_then(Metadata::from_note).as_ref());
    let encoding = Encoding { exposure: exposure.unwrap_or(0.0), tone, seed, note: None };
    let (codes, per_pixel) = work_on(py, None, || pixels.codes(&encoding))?;
    let shape = [pixels.height as usize, pixels.width as usize, per_pixel];
    let array =
        Array3::from_shape_vec(shape, codes).map_err(|error| InputError::new_err(error.to_string()))?;
    Ok(PyArray3::from_owned_array(py, array))
}

/// Checks that files of this format have what is asked for: exposure, a tone curve, alpha.
fn check_format(path: &Path, has_exposure: bool, has_tone: bool, has_alpha: bool) -> PyResult<()> {
    let (shown, is_exposed) = (path.display(), render::is_exposed(path));
    for (name, is_given) in [("exposure", has_exposure), ("tone", has_tone)] {
        if is_given && !is_exposed {
            let problem =
                format!("{name}: {shown} holds linear radiance; only .png and .jpg are exposed and toned");
            return Err(InputError::new_err(problem));
        }
    }
    match Format::from_path(path) {
        Ok(format) if has_alpha && !format.has_alpha() => Err(InputError::new_err(format!(
            "{shown}: {} files have no alpha, and the film has; name a .png, .exr or .tif file, or save \
             sppm.Film(film.radiance), which is over black",
            format.name()
        ))),
        _ => Ok(()),
    }
}

/// The seed of the dithering.
fn seed(made: Option<&Metadata>) -> u64 {
    made.map_or(0, |metadata| metadata.settings.seed)
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
