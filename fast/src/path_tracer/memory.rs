//! How much memory the path tracer will take.

use crate::pixels::slots;
use crate::prepared::bytes_of_spheres;
use scene::Settings;

/// What a thread holds: a batch of paths.
const BYTES_PER_THREAD: u64 = 1 << 19;
/// What a slot holds: sums and a sample.
const BYTES_PER_SLOT: u64 = 3 * (8 + 4);

/// See `PathTracer::bytes_at_most`.
pub(super) fn bytes_at_most(settings: &Settings, spheres: usize, threads: usize) -> u64 {
    slots(settings) as u64 * BYTES_PER_SLOT + threads as u64 * BYTES_PER_THREAD + bytes_of_spheres(spheres)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path_tracer::PathTracer;
    use crate::prepared::BYTES_PER_SPHERE;
    use scene::Engine;

    /// The room for pixels is exactly what the engine holds, slots outside of the image included.
    #[test]
    fn pixels_take_what_the_engine_says() {
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 20, height: 9, max_depth: 1, ..scene.settings };
        let mut engine = PathTracer::new(&scene, &settings);
        engine.iterate();
        assert_eq!(engine.stats().bytes, 24 * 16 * 36);
        assert_eq!(bytes_at_most(&settings, 0, 0), engine.stats().bytes);
        assert_eq!(bytes_at_most(&settings, 0, 3), engine.stats().bytes + 3 * BYTES_PER_THREAD);
        assert_eq!(bytes_at_most(&settings, 7, 0), engine.stats().bytes + 7 * BYTES_PER_SPHERE);
    }
}
