//! The check that all fuzz targets for image files share.

use files::image_file::{Format, decode_bytes};

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
