//! How much memory the path tracer will take.

use crate::eye;
use crate::pixels::slots;
use crate::prepared::bytes_of_spheres;
use scene::Settings;

/// What a thread holds: a batch of paths.
const BYTES_PER_THREAD: u64 = 1 << 19;
/// What a thread holds of the lamps that the pixels of the largest work item see by several rays: 40 bytes for each.
const BYTES_OF_GLINTS: u64 = 40 << 14;
/// What a slot holds: sums and a sample.
const BYTES_PER_SLOT: u64 = 3 * (8 + 4);

/// See `PathTracer::bytes_at_most`.
pub(super) fn bytes_at_most(settings: &Settings, spheres: usize, threads: usize) -> u64 {
    let glints = if settings.glint_samples > 1 { BYTES_OF_GLINTS } else { 0 };
    slots(settings) as u64 * BYTES_PER_SLOT
        + threads as u64 * (BYTES_PER_THREAD + glints)
        + bytes_of_spheres(spheres)
        + eye::bytes_at_most(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glints::BYTES_PER_PIXEL;
    use crate::parameters::Parameters;
    use crate::prepared::BYTES_PER_SPHERE;

    /// The room for pixels includes slots outside of the image, in whole tiles.
    #[test]
    fn each_thing_takes_its_own_bytes() {
        let settings = Settings { width: 20, height: 9, max_depth: 1, ..Settings::default() };
        let pixels = 24 * 16 * 36;
        assert_eq!(bytes_at_most(&settings, 0, 0), pixels);
        assert_eq!(bytes_at_most(&settings, 0, 3), pixels + 3 * BYTES_PER_THREAD);
        let several = Settings { glint_samples: 2, ..settings };
        // Two bits for each pixel, in words of 64: 180 pixels, and six tiles.
        assert_eq!(bytes_at_most(&several, 0, 0), pixels + 8 * (3 + 6));
        let threads = bytes_at_most(&several, 0, 3) - bytes_at_most(&several, 0, 0);
        assert_eq!(threads, 3 * (BYTES_PER_THREAD + BYTES_OF_GLINTS));
        let most = Parameters::ALL.iter().find(|p| p.name == "pixels_per_job").unwrap().most as u64;
        assert!(BYTES_OF_GLINTS >= most * BYTES_PER_PIXEL);
        assert_eq!(bytes_at_most(&settings, 7, 0), pixels + 7 * BYTES_PER_SPHERE);
    }
}
