//! The switch of faults that `scripts/faults` puts into a copy of the workspace: all are compiled at once, and the
//! environment variable `SPPM_FAULT` names the one that is in force. The sources themselves hold none of this.

#![forbid(unsafe_code)]

mod names;

use std::sync::LazyLock;

/// The number of the fault in force; that of no fault, if none is.
static IN_FORCE: LazyLock<u32> = LazyLock::new(|| {
    let Ok(name) = std::env::var("SPPM_FAULT") else { return u32::MAX };
    let number = names::NAMES.iter().position(|known| *known == name);
    number.unwrap_or_else(|| panic!("SPPM_FAULT: there is no fault `{name}`")) as u32
});

/// Whether fault `number` is in force.
#[inline(always)]
pub fn is(number: u32) -> bool {
    *IN_FORCE == number
}
