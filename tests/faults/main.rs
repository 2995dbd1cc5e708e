//! Checks the table of faults, `faults/faults.toml`: `scripts/faults` can only put in what fits the sources.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::Path;
use toml::Table;

#[test]
fn every_fault_has_a_name_and_a_place_of_its_own() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table: Table = fs::read_to_string(root.join("faults/faults.toml")).unwrap().parse().unwrap();
    let mut names = HashSet::new();
    let mut places: HashMap<&str, HashSet<[usize; 2]>> = HashMap::new();
    for fault in table["fault"].as_array().unwrap() {
        let text = |name: &str| fault[name].as_str().unwrap();
        let (name, file, find) = (text("name"), text("file"), text("find"));
        assert!(names.insert(name), "there are two faults `{name}`");
        let source =
            fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{name}: {file}: {error}"));
        let found: Vec<usize> = source.match_indices(find).map(|(at, _)| at).collect();
        let [start] = found[..] else { panic!("{name}: {} times in {file}: {find}", found.len()) };
        places.entry(file).or_default().insert([start, start + find.len()]);
        assert_ne!(text("replace"), find, "{name}");
        assert!(
            table["suites"].get(text("kind")).is_some(),
            "{name}: there are no suites for {}",
            text("kind")
        );
    }
    assert!(names.len() > 100);
    // Faults at the same place are alternatives; those that share a part of it could not be put in together.
    for (file, places) in places {
        let mut places: Vec<_> = places.into_iter().collect();
        places.sort_unstable();
        for pair in places.windows(2) {
            assert!(pair[0][1] <= pair[1][0], "two faults overlap in {file} at bytes {pair:?}");
        }
    }
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
