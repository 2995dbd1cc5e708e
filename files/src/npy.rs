//! The `NumPy` files of the command `trace`: reads rays, writes hits.

use crate::atomic_file::{self, FileError, reason};
use crate::input;
use npyz::{DType, NpyFile, Order, WriterBuilder as _};
use scene::ray::{NO_SPHERE, SphereId};
use scene::text::counted;
use scene::{Ray, Vec3};
use std::io::{self, BufReader, ErrorKind};
use std::path::Path;

/// Numbers per ray: origin and direction.
const COLUMNS: usize = 6;
/// A direction whose squared length is this close to 1 is used unchanged: rounding a unit vector's components to `f32`
/// can leave it that far off.
const UNIT_TOLERANCE: f64 = 1e-6;

/// A row of the file of hits.
#[derive(Clone, Copy, Debug, npyz::Serialize, npyz::AutoSerialize)]
struct Row {
    t: f32,
    sphere: i32,
    normal: [f32; 3],
}

/// Reads an array of rays.
///
/// # Errors
/// If the file is not an array of float32 of shape (N, 6), or if a ray is not finite or has a zero direction.
pub fn read(path: &Path) -> Result<Vec<Ray>, FileError> {
    let fail = |problem: String| FileError::new(path, problem);
    let (file, length) = input::open(path, "name a .npy file").map_err(fail)?;
    let array = NpyFile::new(BufReader::new(file)).map_err(|error| {
        // The reader of headers shows the place in further lines.
        let reason = reason(&error);
        let first = reason.lines().next().unwrap_or_default().trim_end();
        fail(format!("is no .npy file that can be read: {first}; write one by numpy.save"))
    })?;
    check_header(&array, length).map_err(fail)?;
    let (rows, order) = (array.shape()[0] as usize, array.order());
    let numbers: Vec<f32> = array.into_vec().map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => fail(too_short(rows as u64, length)),
        _ => fail(format!("cannot be read: {}", reason(&error))),
    })?;
    let number = |row: usize, column: usize| match order {
        Order::C => numbers[row * COLUMNS + column],
        Order::Fortran => numbers[column * rows + row],
    };
    let ray = |row| {
        let [x, y, z, dx, dy, dz] = std::array::from_fn(|column| number(row, column));
        ray(Vec3::new(x, y, z), Vec3::new(dx, dy, dz)).map_err(|problem| fail(format!("ray {row} {problem}")))
    };
    (0..rows).map(ray).collect()
}

fn check_header<R: io::Read>(array: &NpyFile<R>, bytes: u64) -> Result<(), String> {
    let wanted = format!("rays are float32 of shape (N, {COLUMNS}), origin and direction");
    if !matches!(array.dtype(), DType::Plain(plain) if matches!(plain.to_string().as_str(), "<f4" | ">f4")) {
        return Err(format!("is of dtype {}; {wanted}: use rays.astype(\"f4\")", array.dtype().descr()));
    }
    let shape = array.shape();
    let &[rows, columns] = shape else {
        return Err(format!("has {}; {wanted}", counted(shape.len() as u64, "dimension")));
    };
    if columns != COLUMNS as u64 {
        return Err(format!("is of shape ({rows}, {columns}); {wanted}"));
    }
    let size = rows.checked_mul((COLUMNS * size_of::<f32>()) as u64);
    if size.is_none_or(|size| size > bytes) {
        return Err(too_short(rows, bytes));
    }
    Ok(())
}

fn too_short(rows: u64, bytes: u64) -> String {
    format!("is too short for {}: it has {}", counted(rows, "ray"), counted(bytes, "byte"))
}

/// A ray, with its direction normalised unless it is a unit vector already.
///
/// # Errors
/// If a number is not finite, or the direction is zero. The message continues the name of the ray.
pub fn ray(origin: Vec3, direction: Vec3) -> Result<Ray, String> {
    if !(origin.is_finite() && direction.is_finite()) {
        return Err("is not finite".into());
    }
    let exact = direction.as_dvec3();
    let length_squared = exact.dot(exact);
    if length_squared == 0.0 {
        return Err("has a direction of length 0".into());
    }
    let is_unit = (length_squared - 1.0).abs() <= UNIT_TOLERANCE;
    let direction = if is_unit { direction } else { (exact / length_squared.sqrt()).as_vec3() };
    Ok(Ray { origin, direction, leaves: NO_SPHERE })
}

/// Writes the hit of each ray: distance, sphere and normal. A miss has an infinite distance and sphere -1.
///
/// # Errors
/// As [`atomic_file::replace`].
pub fn write(path: &Path, hits: &[(f32, SphereId, Vec3)]) -> Result<(), FileError> {
    let row = |&(t, sphere, normal): &(f32, SphereId, Vec3)| {
        let sphere = if t < f32::INFINITY { sphere as i32 } else { -1 };
        Row { t, sphere, normal: normal.to_array() }
    };
    atomic_file::replace(path, |out| {
        let shape = [hits.len() as u64];
        let options = npyz::WriteOptions::new().default_dtype().shape(&shape);
        let mut writer = options.writer(out).begin_nd()?;
        writer.extend(hits.iter().map(row))?;
        writer.finish()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_what_rays_have_hit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("hits.npy");
        let hits = [(2.5, 7, Vec3::new(0.0, 0.6, -0.8)), (f32::INFINITY, 3, Vec3::ZERO)];
        write(&path, &hits).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let row = |t: f32, sphere: i32, normal: [f32; 3]| {
            let normal = normal.into_iter().flat_map(f32::to_le_bytes);
            t.to_le_bytes().into_iter().chain(sphere.to_le_bytes()).chain(normal).collect::<Vec<u8>>()
        };
        // What hits nothing has no sphere.
        let rows = [row(2.5, 7, [0.0, 0.6, -0.8]), row(f32::INFINITY, -1, [0.0; 3])].concat();
        assert!(bytes.ends_with(&rows), "{bytes:?}");
    }

    /// Directions of any length become unit vectors along the same line; those that are, up to rounding, keep their bits.
    #[test]
    fn directions_are_of_unit_length() {
        let way = Vec3::new(0.36, -0.48, 0.8);
        for length in [1e-20, 0.3, 0.95, 0.99, 0.9999, 1.0001, 1.01, 1.04, 1.5, 7.0, 1e15] {
            let ray = ray(Vec3::ONE, way * length).unwrap();
            assert!((ray.direction - way).length() < 3e-7, "{length}: {}", ray.direction);
            assert!((ray.direction.as_dvec3().length() - 1.0).abs() < 1e-7, "{length}");
            assert_eq!(ray.origin, Vec3::ONE);
        }
        assert_eq!(ray(Vec3::ZERO, way).unwrap().direction, way);
        assert!(ray(Vec3::ZERO, Vec3::ZERO).unwrap_err().contains("length 0"));
    }

    /// Arrays of machines with the other byte order hold the same numbers.
    #[test]
    fn rays_may_be_in_either_byte_order() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rays.npy");
        let numbers = [1.5_f32, -2.0, 3.25, 0.0, 0.0, -1.0, 7.0, 8.0, 9.0, 1.0, 0.0, 0.0];
        let read_as = |order: char, bytes: fn(f32) -> [u8; 4]| {
            let text = format!("{{'descr': '{order}f4', 'fortran_order': False, 'shape': (2, 6), }}\n");
            let mut file = b"\x93NUMPY\x01\x00".to_vec();
            file.extend((text.len() as u16).to_le_bytes());
            file.extend(text.bytes().chain(numbers.into_iter().flat_map(bytes)));
            std::fs::write(&path, file).unwrap();
            let rays = read(&path).unwrap();
            rays.iter()
                .flat_map(|ray| [ray.origin.to_array(), ray.direction.to_array()])
                .flatten()
                .collect::<Vec<_>>()
        };
        assert_eq!(read_as('<', f32::to_le_bytes), numbers);
        assert_eq!(read_as('>', f32::to_be_bytes), numbers);
    }

    /// What a header announces has to be in the file, to the byte.
    #[test]
    fn rays_that_are_not_there_are_missed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rays.npy");
        let rays = |announced: u64, there: usize| {
            let mut text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({announced}, 6), }}");
            while (text.len() + 11) % 64 != 0 {
                text.push(' ');
            }
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend((text.len() as u16 + 1).to_le_bytes());
            bytes.extend(text.bytes().chain(*b"\n"));
            bytes.extend((0..there).flat_map(|_| 1.0_f32.to_le_bytes()));
            std::fs::write(&path, bytes).unwrap();
            read(&path).map(|rays| rays.len()).map_err(|error| error.problem)
        };
        assert_eq!([rays(0, 0), rays(5, 30)], [Ok(0), Ok(5)]);
        for (announced, there) in [(5, 29), (5, 6), (u64::MAX / 24, 30), (u64::MAX, 30)] {
            let problem = rays(announced, there).unwrap_err();
            assert!(problem.starts_with(&format!("is too short for {announced} rays: it has ")), "{problem}");
        }
        assert!(rays(1, 5).unwrap_err().starts_with("is too short for 1 ray: it has "));
    }
}
