//! Fuzzes the reader of XYZ files.

#![no_main]

use importers::Format;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| sppm_fuzz::read_particles(Format::Xyz, bytes));
