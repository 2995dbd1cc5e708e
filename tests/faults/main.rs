//! Checks the table of faults, `faults/faults.toml`: `scripts/faults` can only put in what fits the sources.

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use toml::Table;

#[test]
fn every_fault_has_a_name_of_its_own_and_stands_once_in_its_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table: Table = fs::read_to_string(root.join("faults/faults.toml")).unwrap().parse().unwrap();
    let mut names = HashSet::new();
    for fault in table["fault"].as_array().unwrap() {
        let text = |name: &str| fault[name].as_str().unwrap();
        let (name, file, find) = (text("name"), text("file"), text("find"));
        assert!(names.insert(name), "there are two faults `{name}`");
        let source =
            fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{name}: {file}: {error}"));
        assert_eq!(source.matches(find).count(), 1, "{name}: in {file}: {find}");
        assert_ne!(text("replace"), find, "{name}");
        assert!(
            table["suites"].get(text("kind")).is_some(),
            "{name}: there are no suites for {}",
            text("kind")
        );
    }
    assert!(names.len() > 100);
}
