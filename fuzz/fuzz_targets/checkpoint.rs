//! Fuzzes checkpoints: each gives a one-line error or can be loaded by an engine.
//!
//! Random changes practically never give a valid checksum, so each input is also tried with its checksums corrected.

#![no_main]

use libfuzzer_sys::fuzz_target;
use files::checkpoint::{Checkpoint, Damage};
use std::io::Cursor;
use std::ops::Range;

/// Larger images are skipped, as they would only be slower.
const MOST_PIXELS: usize = 1 << 16;

/// Bytes of the header. The last four are its checksum, and the eight before those the length of the file.
const HEADER: usize = 24;
const LENGTH: Range<usize> = 12..20;
/// Bytes of a section's name and length, which precede its content; the checksum follows the content.
const FRAME: usize = 12;
const CHECKSUM: usize = 4;
const SECTIONS: [&[u8; 4]; 9] =
    [b"SCEN", b"MATL", b"BALL", b"GLOW", b"MOVE", b"RNDR", b"NOTE", b"SUMS", b"PAST"];
/// The text before the scene's digest in the account.
const DIGEST: &[u8] = b"\"scene\":\"";

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    let Some(mended) = mended(bytes, None) else { return };
    read(&mended);
    let length = mended.len() as u64;
    if let Err(Damage::OtherScene { ours, .. }) = Checkpoint::read(&mut Cursor::new(&mended), length) {
        read(&self::mended(bytes, Some(&ours)).unwrap_or_default());
    }
});

fn read(bytes: &[u8]) {
    let (mut input, length) = (Cursor::new(bytes), bytes.len() as u64);
    match Checkpoint::read(&mut input, length) {
        Ok(checkpoint) if checkpoint.scene.settings.pixels() <= MOST_PIXELS => {
            let settings = checkpoint.scene.settings;
            let mut engine = reference::Sppm::new(&checkpoint.scene, &settings);
            // A valid checkpoint may be one of the path tracer, which this engine rejects.
            let _ = checkpoint.restore(&mut input, &mut engine);
        }
        Ok(_) => {}
        Err(damage) => {
            let line = damage.to_string();
            assert!(!line.is_empty() && !line.contains('\n'), "{line:?}");
        }
    }
}

/// The same sections with corrected names, lengths and checksums, and with this digest of the scene.
fn mended(bytes: &[u8], digest: Option<&str>) -> Option<Vec<u8>> {
    let mut bytes = bytes.to_vec();
    let header = bytes.get_mut(..HEADER)?;
    header[..12].copy_from_slice(b"\x89SPPM\r\n\x1a\x02\0\0\0");
    let mut at = HEADER;
    for name in SECTIONS {
        let Some(left) = (bytes.len() - at).checked_sub(FRAME + CHECKSUM) else { break };
        let stated = u64::from_le_bytes(bytes[at + 4..at + FRAME].try_into().unwrap());
        // The last section ends at the end of the file.
        let length = usize::try_from(stated).map_or(left, |stated| stated.min(left));
        bytes[at..at + 4].copy_from_slice(name);
        bytes[at + 4..at + FRAME].copy_from_slice(&(length as u64).to_le_bytes());
        let content = &mut bytes[at + FRAME..][..length];
        if name == b"RNDR" {
            put_digest(content, digest.unwrap_or_default());
        }
        let end = at + FRAME + length;
        let checksum = crc32fast::hash(&bytes[at..end]);
        bytes[end..end + CHECKSUM].copy_from_slice(&checksum.to_le_bytes());
        at = end + CHECKSUM;
    }
    bytes.truncate(at);
    bytes[LENGTH].copy_from_slice(&(at as u64).to_le_bytes());
    let checksum = crc32fast::hash(&bytes[..HEADER - CHECKSUM]);
    bytes[HEADER - CHECKSUM..HEADER].copy_from_slice(&checksum.to_le_bytes());
    Some(bytes)
}

fn put_digest(account: &mut [u8], digest: &str) {
    let Some(at) = account.windows(DIGEST.len()).position(|window| window == DIGEST) else { return };
    if let Some(place) = account.get_mut(at + DIGEST.len()..).and_then(|rest| rest.get_mut(..digest.len())) {
        place.copy_from_slice(digest.as_bytes());
    }
}
