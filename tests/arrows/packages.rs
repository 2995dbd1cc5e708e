//! Packages are complete: what a crate includes at compile time is in its own folder, and `cargo package --workspace` can
//! resolve what crates of the workspace need of each other.

use crate::crates::metadata;
use serde_json::{Value, json};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The source files below `folder`, but for modules of tests, which packages need not build.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
    found
}

/// The first string after each `include_str!` and `include_bytes!` of a text.
fn included(text: &str) -> Vec<&str> {
    let calls = text.split("include_").skip(1);
    let calls = calls.filter(|call| call.starts_with("str!(") || call.starts_with("bytes!("));
    calls.filter_map(|call| call.split('"').nth(1)).collect()
}

/// How many folders a relative path climbs above its beginning.
fn climbs(path: &Path) -> usize {
    path.components().filter(|part| *part == Component::ParentDir).count()
}

/// What is included from outside of the crate in `folder`.
fn strangers(folder: &Path) -> Vec<String> {
    let mut strangers = Vec::new();
    for path in sources(&folder.join("src")) {
        let depth = path.strip_prefix(folder).unwrap().components().count() - 1;
        let text = fs::read_to_string(&path).unwrap();
        let outside = included(&text).into_iter().filter(|included| climbs(Path::new(included)) > depth);
        strangers.extend(outside.map(|included| format!("{}: {included}", path.display())));
    }
    strangers
}

fn packages(metadata: &Value) -> &[Value] {
    metadata["packages"].as_array().unwrap()
}

#[test]
fn crates_include_their_own_files_alone() {
    let metadata = metadata();
    for package in packages(&metadata) {
        let manifest = Path::new(package["manifest_path"].as_str().unwrap());
        assert_eq!(strangers(manifest.parent().unwrap()), [""; 0]);
    }
    let scenes = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("files/src"));
    let texts: Vec<String> = scenes.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    assert!(texts.iter().any(|text| included(text) == ["../scenes/"]), "the built-in scenes were not seen");
}

/// Cargo resolves a crate of the workspace by its version, and leaves out crates that are never published.
#[test]
fn crates_of_the_workspace_name_each_others_versions() {
    let metadata = metadata();
    for package in packages(&metadata) {
        let name = &package["name"];
        assert!(package["publish"].is_null(), "{name} has a publish key");
        for dependency in package["dependencies"].as_array().unwrap() {
            if dependency["path"].is_string() {
                assert_eq!(
                    dependency["req"],
                    format!("^{}", env!("CARGO_PKG_VERSION")),
                    "{name}: {dependency}"
                );
            }
        }
        assert_eq!(package["version"], env!("CARGO_PKG_VERSION"), "{name}");
        // What is named must exist; there is no public repository yet.
        assert!(package["repository"].is_null() && package["homepage"].is_null(), "{name}");
    }
}

/// Whether the documentation of a crate has code of Rust: what stands between fences that name no other language.
fn has_examples(folder: &Path) -> bool {
    sources(&folder.join("src")).iter().any(|path| {
        let text = fs::read_to_string(path).unwrap();
        let docs = text.lines().map(str::trim_start);
        let docs = docs.filter_map(|line| line.strip_prefix("//!").or_else(|| line.strip_prefix("///")));
        // Every second fence ends what the one before has begun.
        let mut fences = docs.filter_map(|line| line.trim_start().strip_prefix("```")).step_by(2);
        fences.any(|language| !["text", "toml"].contains(&language))
    })
}

/// Where there is none, building the crate once more to look for it takes a second of each run of the tests.
#[test]
fn documentation_is_tested_where_it_has_examples() {
    let metadata = metadata();
    for package in packages(&metadata) {
        let folder = Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap();
        let target =
            package["targets"].as_array().unwrap().iter().find(|target| target["kind"] == json!(["lib"]));
        if let Some(target) = target {
            assert_eq!(target["doctest"], has_examples(folder), "{}", package["name"]);
        }
    }
}

#[test]
fn files_from_outside_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("src/inner")).unwrap();
    let text = "const A: &str = include_str!(\"../a\"); const B: &[u8] = include_bytes!(concat!(\"../../\", \"b\"));";
    for (name, strange) in [("src/lib.rs", 1), ("src/inner/mod.rs", 0)] {
        fs::write(folder.path().join(name), text).unwrap();
        assert_eq!(strangers(folder.path()).len(), strange, "{name}");
        fs::remove_file(folder.path().join(name)).unwrap();
    }
}
