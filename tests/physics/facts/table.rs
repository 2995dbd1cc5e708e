//! The table of facts, made from the names of their tests: every fact is held from every end, and docs/proof.md says so.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use syn::{Item, ItemFn};

/// From where a fact is held: what its tests' names begin with, and the heading of its column.
const ENDS: [(&str, &str); 3] = [("eye_", "Eye"), ("photons_", "Photons"), ("direct_", "Direct light")];

/// Files of the folder that are no facts.
const OTHERS: [&str; 3] = ["mod", "closed_form", "table"];

/// The tests of a source file.
fn tests_of(path: &Path) -> Vec<String> {
    let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
    let is_test = |f: &ItemFn| f.attrs.iter().any(|a| a.path().is_ident("test"));
    let name = |item| match item {
        Item::Fn(f) if is_test(&f) => Some(f.sig.ident.to_string()),
        _ => None,
    };
    file.items.into_iter().filter_map(name).collect()
}

/// The tests of every fact.
fn facts() -> BTreeMap<String, Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/physics/facts");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let facts = files.map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), tests_of(&path)));
    facts.filter(|(name, _)| !OTHERS.contains(&name.as_str())).collect()
}

#[test]
fn every_fact_is_held_from_every_end_and_the_table_says_so() {
    let mut table = String::from("| Fact |");
    for (_, heading) in ENDS {
        let _ = write!(table, " {heading} |");
    }
    table.push_str("\n|---|---|---|---|\n");
    for (fact, tests) in facts() {
        let _ = write!(table, "| {} |", fact.replace('_', " "));
        for (prefix, _) in ENDS {
            let cell: Vec<_> = tests.iter().filter(|test| test.starts_with(prefix)).collect();
            assert!(!cell.is_empty(), "tests/physics/facts/{fact}.rs has no test that begins with {prefix}");
            let cell: Vec<_> = cell.iter().map(|test| format!("`{test}`")).collect();
            let _ = write!(table, " {} |", cell.join(", "));
        }
        let odd = tests.iter().find(|test| !ENDS.iter().any(|(prefix, _)| test.starts_with(prefix)));
        assert_eq!(odd, None, "tests/physics/facts/{fact}.rs: from which end?");
        table.push('\n');
    }
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/proof.md")).unwrap();
    assert!(page.contains(&table), "docs/proof.md does not hold the table of facts:\n{table}");
}
