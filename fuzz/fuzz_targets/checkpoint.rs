//! Checkpoints, broken and whole: refused in one line, or taken up by an engine.

#![no_main]

use libfuzzer_sys::fuzz_target;
use scene::checkpoint::Checkpoint;
use std::io::Cursor;

/// Larger images would only be slower.
const MOST_PIXELS: usize = 1 << 16;

fuzz_target!(|bytes: &[u8]| {
    let (mut input, length) = (Cursor::new(bytes), bytes.len() as u64);
    match Checkpoint::read(&mut input, length) {
        Ok(checkpoint) if checkpoint.scene.settings.pixels() <= MOST_PIXELS => {
            let settings = checkpoint.scene.settings;
            let mut engine = reference::Sppm::new(&checkpoint.scene, &settings);
            // What was read as whole may be of the path tracer, and is then refused.
            let _ = checkpoint.restore(&mut input, &mut engine);
        }
        Ok(_) => {}
        Err(damage) => {
            let line = damage.to_string();
            assert!(!line.is_empty() && !line.contains('\n'), "{line:?}");
        }
    }
});
