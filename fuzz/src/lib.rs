//! The checks that fuzz targets share.

use files::image_file::{Format, decode_bytes};
use importers::{Frame, Particles, Properties, Request, read_from};
use std::io::Cursor;

/// Checks that decoding `bytes` gives a one-line error or an image with all of its pixels.
pub fn read(format: Format, bytes: &[u8]) {
    match decode_bytes(format, bytes) {
        Ok(film) => {
            assert!(film.width > 0 && film.height > 0);
            assert_eq!(film.pixels.len() as u64, u64::from(film.width) * u64::from(film.height));
        }
        Err(problem) => assert!(!problem.is_empty() && !problem.contains('\n'), "{problem:?}"),
    }
}

/// Bytes that the particles of a fuzzed file may take.
const MEMORY: u64 = 64 << 20;

/// Checks that reading `bytes` gives a one-line error or columns of equal length, whichever frame is asked for.
pub fn read_particles(format: importers::Format, bytes: &[u8]) {
    for frame in [Frame::Number(0), Frame::Number(1), Frame::Last] {
        let request = Request { frame, properties: Properties::All, memory: MEMORY };
        match read_from("a", Cursor::new(bytes), format, &request) {
            Ok(particles) => check(&particles),
            Err(error) => {
                let line = error.to_string();
                assert!(!line.is_empty() && !line.contains(char::is_control), "{line:?}");
            }
        }
    }
}

fn check(particles: &Particles) {
    let count = particles.len();
    assert!(particles.positions.iter().flatten().all(|number| number.abs() <= Particles::FARTHEST));
    let labels = [&particles.types, &particles.names, &particles.residues, &particles.chains];
    for labels in labels.into_iter().flatten() {
        assert_eq!(labels.index.len(), count);
        assert!(labels.index.iter().all(|&index| usize::from(index) < labels.names.len()));
    }
    let lengths = [
        particles.elements.as_ref().map(Vec::len),
        particles.radii.as_ref().map(Vec::len),
        particles.colors.as_ref().map(Vec::len),
        particles.ids.as_ref().map(Vec::len),
    ];
    assert!(lengths.into_iter().flatten().all(|length| length == count));
    assert!(particles.properties.iter().all(|property| property.values.len() == count));
    assert!(particles.radii.iter().flatten().all(|radius| radius.is_finite() && *radius >= 0.0));
    assert!(particles.bonds.iter().all(|[a, b]| a < b && (*b as usize) < count));
    if let Some(cell) = particles.cell {
        assert!(cell.volume() > 0.0);
        assert!(particles.positions.iter().all(|position| !cell.wrap(*position)[0].is_nan()));
    }
}
