//! Dependencies between crates: each may depend only on those that a table permits.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Each crate, with the crates of this workspace that it may depend on. Crates that do not exist yet are planned.
const PERMITTED: &[(&str, &[&str])] = &[
    // Common data types, and the interface of engines.
    ("scene", &[]),
    // Vectors; all unsafe code.
    ("lanes", &[]),
    // File formats: scenes, images, checkpoints, exports.
    ("files", &["scene", "importers", "figure"]),
    // The engines share no code besides `scene`, so that an error in a common helper cannot hide in both.
    ("reference", &["scene"]),
    ("fast", &["scene", "lanes"]),
    // Metrics.
    ("compare", &["scene"]),
    // Running renders, for all front ends.
    ("render", &["scene", "files", "reference", "fast"]),
    // Molecules and particles as scenes.
    ("importers", &["scene"]),
    // Styles of particles, and a stage to show them on.
    ("figure", &["scene", "importers"]),
    // Front ends.
    ("view", &["scene", "files", "render"]),
    ("python", &["scene", "files", "render", "importers", "figure", "compare", "view"]),
    // Line plots as SVG files.
    ("plots", &["files"]),
    // The paper's stages. Depends on `fast` to measure it for comparison.
    ("ladder", &["scene", "files", "lanes", "fast", "compare", "plots"]),
    ("tuner", &["scene", "files", "fast", "compare", "render", "plots"]),
    // The command: everything except the Python module.
    (
        "sppm",
        &[
            "scene",
            "lanes",
            "files",
            "reference",
            "fast",
            "compare",
            "render",
            "importers",
            "figure",
            "view",
            "ladder",
            "tuner",
        ],
    ),
];

/// Additional crates that the tests of a crate may use: the engines' tests use the built-in scenes of `files`. Tests that
/// compare the engines are in the root package, which depends on both.
const PERMITTED_TO_TESTS: &[(&str, &[&str])] = &[("reference", &["files"]), ("fast", &["files"])];

/// The dependencies that the tables do not permit, as "fast -> reference" or "fast is not in the table".
fn violations(arrows: &BTreeMap<String, BTreeSet<String>>, tables: &[&[(&str, &[&str])]]) -> Vec<String> {
    let mut all = Vec::new();
    for (from, to) in arrows {
        let mut rows = tables.iter().flat_map(|table| table.iter()).filter(|row| row.0 == from).peekable();
        if rows.peek().is_none() {
            all.push(format!("{from} is not in the table"));
            continue;
        }
        let permitted: BTreeSet<&str> = rows.flat_map(|row| row.1.iter().copied()).collect();
        let wrong = to.iter().filter(|to| !permitted.contains(to.as_str()));
        all.extend(wrong.map(|to| format!("{from} -> {to}")));
    }
    all
}

/// The dependencies of each crate on others of the workspace, by the output of `cargo metadata`: first those of its
/// library and programs, then those of its tests.
fn arrows(metadata: &Value) -> [BTreeMap<String, BTreeSet<String>>; 2] {
    let packages = metadata["packages"].as_array().expect("packages");
    let ours: BTreeSet<&str> = packages.iter().filter_map(|package| package["name"].as_str()).collect();
    let mut all = [BTreeMap::new(), BTreeMap::new()];
    for package in packages {
        let name = package["name"].as_str().expect("a name").to_owned();
        for arrows in &mut all {
            arrows.insert(name.clone(), BTreeSet::new());
        }
        for dependency in package["dependencies"].as_array().expect("dependencies") {
            let to = dependency["name"].as_str().expect("a name");
            if ours.contains(to) {
                // Build scripts count as the crate itself.
                let for_tests = dependency["kind"].as_str() == Some("dev");
                all[usize::from(for_tests)].entry(name.clone()).or_default().insert(to.to_owned());
            }
        }
    }
    all
}

/// The output of `cargo metadata` for this workspace.
pub(crate) fn metadata() -> Value {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo metadata runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON")
}

#[test]
fn crates_depend_on_those_that_the_table_permits() {
    let [normal, of_tests] = arrows(&metadata());
    assert!(normal.contains_key("fast") && normal["fast"].contains("lanes"), "the metadata was misread");
    assert_eq!(violations(&normal, &[PERMITTED]), [""; 0]);
    assert_eq!(violations(&of_tests, &[PERMITTED, PERMITTED_TO_TESTS]), [""; 0], "in [dev-dependencies]");
}

#[test]
fn dependencies_and_crates_that_are_not_in_the_table_are_reported() {
    let packages = r#"{"packages": [
        {"name": "scene", "dependencies": [{"name": "glam", "kind": null}]},
        {"name": "reference", "dependencies": [{"name": "scene", "kind": null}]},
        {"name": "fast", "dependencies": [
            {"name": "scene", "kind": null},
            {"name": "reference", "kind": "dev"},
            {"name": "other", "kind": "build"}
        ]},
        {"name": "other", "dependencies": []}
    ]}"#;
    let [normal, of_tests] = arrows(&serde_json::from_str(packages).unwrap());
    assert_eq!(violations(&normal, &[PERMITTED]), ["fast -> other", "other is not in the table"]);
    assert_eq!(violations(&of_tests, &[PERMITTED]), ["fast -> reference", "other is not in the table"]);
    let extra: &[(&str, &[&str])] = &[("fast", &["reference"]), ("other", &[])];
    assert_eq!(violations(&of_tests, &[PERMITTED, extra]), [""; 0]);
}

#[test]
fn the_table_itself_has_no_cycle() {
    let edges =
        PERMITTED.iter().flat_map(|(from, to)| to.iter().map(|to| (from.to_string(), to.to_string())));
    assert_eq!(crate::cycles::cycles(&edges.collect()), Vec::<BTreeSet<String>>::new());
}
