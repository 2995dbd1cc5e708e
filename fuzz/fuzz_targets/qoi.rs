//! Fuzzes the reader of QOI files.

#![no_main]

use libfuzzer_sys::fuzz_target;
use files::image_file::Format;

fuzz_target!(|bytes: &[u8]| sppm_fuzz::read(Format::Qoi, bytes));
