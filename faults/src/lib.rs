//! The switch of faults that `scripts/faults` puts into a copy of the workspace: all are compiled at once, and the
//! environment variable `SPPM_FAULT` names the one that is in force. The sources themselves hold none of this.
//! `SPPM_FAULTS_REACHED` names a folder in which each fault that a program could have met leaves an empty file.

#![forbid(unsafe_code)]

mod names;

use std::fs::File;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

struct Asked {
    /// The number of the fault in force; that of no fault, if none is.
    in_force: u32,
    /// The folder of faults that are reached, and which are known to be.
    reached: Option<(PathBuf, Vec<AtomicBool>)>,
}

static ASKED: LazyLock<Asked> = LazyLock::new(|| {
    let number = |name: String| {
        let number = names::NAMES.iter().position(|known| *known == name);
        number.unwrap_or_else(|| panic!("SPPM_FAULT: there is no fault `{name}`")) as u32
    };
    let known = || names::NAMES.iter().map(|_| AtomicBool::new(false)).collect();
    Asked {
        in_force: std::env::var("SPPM_FAULT").map_or(u32::MAX, number),
        reached: std::env::var_os("SPPM_FAULTS_REACHED").map(|folder| (folder.into(), known())),
    }
});

/// Whether fault `number` is in force.
#[inline(always)]
pub fn is(number: u32) -> bool {
    let asked = &*ASKED;
    if asked.reached.is_some() {
        note(number);
    }
    asked.in_force == number
}

#[cold]
fn note(number: u32) {
    let Some((folder, known)) = &ASKED.reached else { return };
    if !known[number as usize].load(Ordering::Relaxed) && !known[number as usize].swap(true, Ordering::Relaxed) {
        // A program that may write no file leaves nothing. Its tests then seem not to reach the fault.
        let _ = File::create(folder.join(number.to_string()));
    }
}
