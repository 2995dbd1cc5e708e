//! Says for each mutant of cargo-mutants what has to be changed in the source so that a switch puts it in force.
//!
//! `places ROOT` reads the list that `cargo mutants --list --json` prints, and writes a list of the same length: a [`Switch`]
//! per mutant. cargo-mutants tells where an operator is; what the operator joins is found here, by parsing the file.

#![forbid(unsafe_code)]

mod edits;

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::{env, fs, io};

/// A mutant, as cargo-mutants lists it.
#[derive(Deserialize)]
struct Mutant {
    file: String,
    genre: String,
    replacement: String,
    span: Span,
}

/// Where it is.
#[derive(Deserialize)]
struct Span {
    start: Position,
}

/// A line and a column, both from 1; columns are of characters.
#[derive(Deserialize, Clone, Copy, PartialEq)]
struct Position {
    line: usize,
    column: usize,
}

/// What is to be changed. All places are bytes of the file.
#[derive(Serialize, Debug, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Switch {
    /// The expression from `start` to `end` becomes `text`.
    Instead { start: usize, end: usize, text: String },
    /// `text` is inserted; in it, FAULT stands for the switch.
    Insert { at: usize, text: String },
    /// A switch cannot do it, for this reason.
    Not(&'static str),
}

fn main() {
    let root = env::args().nth(1).expect("the root of the sources");
    let mutants: Vec<Mutant> = serde_json::from_reader(io::stdin()).expect("a list of mutants");
    let mut by_file: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, mutant) in mutants.iter().enumerate() {
        by_file.entry(&mutant.file).or_default().push(number);
    }
    let mut switches: Vec<Switch> = mutants.iter().map(|_| Switch::Not("not found")).collect();
    for (file, numbers) in by_file {
        let text = fs::read_to_string(Path::new(&root).join(file)).expect("a source file");
        let some: Vec<&Mutant> = numbers.iter().map(|&number| &mutants[number]).collect();
        for (number, switch) in numbers.iter().zip(edits::of(&text, &some)) {
            switches[*number] = switch;
        }
    }
    serde_json::to_writer(io::stdout(), &switches).expect("an open output");
}
