//! Checkpoints: bytes are refused in one line, or hold a render that an engine goes on from.

#![no_main]

use libfuzzer_sys::fuzz_target;
use scene::Engine;
use scene::checkpoint::Checkpoint;
use std::io::Cursor;

/// Larger images take long and show no more.
const MOST_PIXELS: usize = 1 << 12;

fuzz_target!(|bytes: &[u8]| {
    match Checkpoint::read(&mut Cursor::new(bytes), bytes.len() as u64) {
        Ok(checkpoint) => {
            let settings = checkpoint.scene.settings;
            if settings.pixels() <= MOST_PIXELS && checkpoint.account.sums == scene::Sums::Photons {
                let mut engine = fast::Sppm::new(&checkpoint.scene, &settings);
                checkpoint.restore(&mut Cursor::new(bytes), &mut engine).unwrap();
                assert_eq!(engine.iterations(), checkpoint.account.iterations);
            }
        }
        Err(damage) => {
            let line = damage.to_string();
            assert!(!line.is_empty() && !line.chars().any(char::is_control), "{line:?}");
        }
    }
});
