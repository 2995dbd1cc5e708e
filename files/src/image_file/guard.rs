//! Turns panics of decoders into errors. Those of JPEG and TIFF index out of bounds on some damaged files.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is expected, and hence not reported.
    static EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `decode`, which must not touch anything that outlives an error.
pub(super) fn guarded<T>(format: &str, decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !EXPECTED.get() {
                usual(info);
            }
        }));
    });
    EXPECTED.set(true);
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    EXPECTED.set(false);
    result.unwrap_or_else(|_| Err(format!("is no {format} file that can be read: it is damaged")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_and_others_stay_panics() {
        assert_eq!(guarded("JPEG", || Ok(7)), Ok(7));
        let nothing: [u8; 0] = [];
        let line = guarded("JPEG", || Ok(nothing[std::hint::black_box(3)])).unwrap_err();
        assert_eq!(line, "is no JPEG file that can be read: it is damaged");
        assert!(panic::catch_unwind(|| panic!("of a test that expects it")).is_err());
    }
}
