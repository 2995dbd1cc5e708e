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

/// `scripts/faults` looks suites up by their names when it has built them, which takes minutes.
#[test]
fn every_suite_is_one_of_a_package_that_is_built() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let script = fs::read_to_string(root.join("scripts/switched.py")).unwrap();
    let line = script.lines().find_map(|line| line.strip_prefix("PACKAGES = \"")).unwrap();
    let packages: Vec<&str> = line.split('"').next().unwrap().split_whitespace().collect();
    let folder = |package: &str| root.join(if package == "sppm" { "" } else { package });
    let mut names = HashSet::new();
    for file in ["faults/faults.toml", "faults/mutants.toml"] {
        let table: Table = fs::read_to_string(root.join(file)).unwrap().parse().unwrap();
        let suites = table["suites"].as_table().unwrap().values().flat_map(|some| some.as_array().unwrap());
        // After a colon, which of its tests.
        names.extend(suites.map(|suite| suite.as_str().unwrap().split(':').next().unwrap().to_owned()));
    }
    assert!(names.len() > 10);
    for name in names {
        let is_built = match name.split_once(", ") {
            Some((package, "unit tests")) => packages.contains(&package),
            Some(_) => false,
            None => packages.iter().any(|package| {
                let tests = folder(package).join("tests");
                tests.join(format!("{name}.rs")).exists() || tests.join(&name).join("main.rs").exists()
            }),
        };
        assert!(is_built || name == "python", "there is no suite `{name}` in {packages:?}");
    }
}
