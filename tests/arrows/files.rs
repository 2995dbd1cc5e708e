//! Imports between the files of a crate: they must not form cycles.

use crate::crates::metadata;
use crate::cycles::cycles;
use crate::imports::{Import, Source};
use std::collections::BTreeSet;
use std::fs::read_to_string;
use std::path::Path;

/// All imports between the files in a folder `src`, of its library and its program, with paths relative to the folder.
pub(crate) fn imports(src: &Path) -> BTreeSet<Import> {
    let plain = |name: &str| {
        let name = Path::new(name).strip_prefix(src).expect("a file of the folder");
        name.display().to_string().replace('\\', "/")
    };
    let mut all = BTreeSet::new();
    for root in ["lib.rs", "main.rs"].map(|root| src.join(root)).iter().filter(|root| root.exists()) {
        let found = Source::read(root, &|file| read_to_string(file).ok()).imports();
        all.extend(found.into_iter().map(|i| Import {
            from: plain(&i.from),
            to: plain(&i.to),
            path: i.path,
        }));
    }
    all
}

/// Describes the cycles among imports: the files of each, and their imports.
fn circles(imports: &BTreeSet<Import>) -> Vec<String> {
    let edges = imports.iter().map(|import| (import.from.clone(), import.to.clone())).collect();
    let tell = |files: BTreeSet<String>| {
        let mut text = format!("in a circle: {}\n", files.iter().cloned().collect::<Vec<_>>().join(", "));
        for Import { from, to, path } in imports {
            if files.contains(from) && files.contains(to) {
                text.extend(["    ", from, " -> ", to, " by ", path, "\n"]);
            }
        }
        text
    };
    cycles(&edges).into_iter().map(tell).collect()
}

#[test]
fn imports_in_a_crate_form_no_cycles() {
    let metadata = metadata();
    let mut told = String::new();
    for package in metadata["packages"].as_array().expect("packages") {
        let name = package["name"].as_str().expect("a name");
        let manifest = Path::new(package["manifest_path"].as_str().expect("a manifest"));
        let imports = imports(&manifest.with_file_name("src"));
        assert!(!imports.is_empty(), "{name} was misread");
        for circle in circles(&imports) {
            told.extend([name, ": ", &circle]);
        }
    }
    assert!(told.is_empty(), "{told}");
}

#[test]
fn a_cycle_is_reported_with_its_imports() {
    let import = |from: &str, to: &str| Import {
        from: from.to_owned(),
        to: to.to_owned(),
        path: format!("crate::{to}"),
    };
    let imports = BTreeSet::from([import("a", "b"), import("b", "c"), import("c", "a"), import("c", "d")]);
    let told =
        "in a circle: a, b, c\n    a -> b by crate::b\n    b -> c by crate::c\n    c -> a by crate::a\n";
    assert_eq!(circles(&imports), [told]);
    let open = imports.into_iter().filter(|import| import.from != "c").collect();
    assert_eq!(circles(&open), [""; 0]);
}

/// A module that imports from its parent through a re-export and inside a macro, while its parent imports from it.
#[test]
fn a_cycle_in_source_text_is_found() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use a::top;"),
        ("a/mod.rs", "mod child; pub use child::Child; pub fn top() {}"),
        ("a/child.rs", "pub struct Child; fn f() { println!(\"{:?}\", crate::top()); }"),
        ("b.rs", "use crate::a::Child;"),
    ];
    let imports = crate::imports::tests::imports_of(&files);
    let import = |told: &String| {
        let (from, rest) = told.split_once(" -> ").unwrap();
        let (to, path) = rest.split_once(" by ").unwrap();
        Import { from: from.to_owned(), to: to.to_owned(), path: path.to_owned() }
    };
    let told = circles(&imports.iter().map(import).collect());
    assert_eq!(told.len(), 1);
    assert!(told[0].starts_with("in a circle: a/child.rs, a/mod.rs\n"), "{told:?}");
}
