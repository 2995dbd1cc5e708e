//! Checks the table of faults, `faults/faults.toml`: `scripts/faults` can only put in what fits the sources.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::path::Path;
use toml::Table;

/// What is put in at each place of a file.
type Places = BTreeMap<[usize; 2], Vec<String>>;

#[test]
fn every_fault_has_a_name_and_a_place_of_its_own() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let table: Table = fs::read_to_string(root.join("faults/faults.toml")).unwrap().parse().unwrap();
    let mut names = HashSet::new();
    let mut files: HashMap<&str, (String, Places)> = HashMap::new();
    for fault in table["fault"].as_array().unwrap() {
        let text = |name: &str| fault[name].as_str().unwrap();
        let (name, file, find, replace) = (text("name"), text("file"), text("find"), text("replace"));
        assert!(names.insert(name), "there are two faults `{name}`");
        let (source, places) = files.entry(file).or_insert_with(|| {
            let source = fs::read_to_string(root.join(file));
            (source.unwrap_or_else(|error| panic!("{name}: {file}: {error}")), Places::new())
        });
        let found: Vec<usize> = source.match_indices(find).map(|(at, _)| at).collect();
        let [start] = found[..] else { panic!("{name}: {} times in {file}: {find}", found.len()) };
        let others = places.entry([start, start + find.len()]).or_default();
        assert!(
            others.is_empty() || !replace.contains(SWITCH),
            "{name}: stands where another does, so it must be an expression, without {SWITCH}"
        );
        others.push(replace.to_owned());
        assert_ne!(replace, find, "{name}");
        assert!(
            table["suites"].get(text("kind")).is_some(),
            "{name}: there are no suites for {}",
            text("kind")
        );
    }
    assert!(names.len() > 100);
    for (file, (source, places)) in files {
        // Faults at the same place are alternatives; those that share a part of it could not be put in together.
        for ([_, end], [start, _]) in places.keys().zip(places.keys().skip(1)) {
            assert!(end <= start, "two faults overlap in {file} at bytes {start} to {end}");
        }
        let is_rust = Path::new(file).extension().is_some_and(|extension| extension == "rs");
        if is_rust && let Err(error) = syn::parse_file(&with_faults(&source, &places)) {
            panic!("{file} is no Rust with its faults: {error}");
        }
    }
}

/// What stands in a fault for the condition that it is in force.
const SWITCH: &str = "FAULT";

/// The source with its faults, as `scripts/faults` puts them in.
fn with_faults(source: &str, places: &Places) -> String {
    let mut text = source.to_owned();
    for (&[start, end], faults) in places.iter().rev() {
        let instead = faults.iter().fold(source[start..end].to_owned(), |instead, fault| {
            if fault.contains(SWITCH) {
                fault.replace(SWITCH, "is_in_force()")
            } else {
                format!("(if is_in_force() {{ {fault} }} else {{ {instead} }})")
            }
        });
        text.replace_range(start..end, &instead);
    }
    text
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
