//! Imports between the folders of the command: `commands` may import from `args` and `terminal`, and `args` from
//! `terminal`, but not the other way round. Folders that do not exist yet break no rule.

use crate::files::imports;
use crate::imports::Import;
use std::collections::BTreeSet;
use std::path::Path;

/// Folders (or files of the same name), with the folders that they must not import from.
const NEVER: [(&str, &[&str]); 2] = [("terminal", &["args", "commands"]), ("args", &["commands"])];

/// The forbidden imports.
fn forbidden(imports: &BTreeSet<Import>) -> Vec<String> {
    let folder = |file: &str| file.split('/').next().unwrap_or(file).trim_end_matches(".rs").to_owned();
    let is_forbidden = |import: &&Import| {
        let (from, to) = (folder(&import.from), folder(&import.to));
        NEVER.iter().any(|(never, others)| from == *never && others.contains(&to.as_str()))
    };
    let tell = |Import { from, to, path }: &Import| format!("{from} -> {to} by {path}");
    imports.iter().filter(is_forbidden).map(tell).collect()
}

#[test]
fn folders_of_the_command_import_only_downwards() {
    let imports = imports(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert_eq!(forbidden(&imports), [""; 0]);
}

#[test]
fn imports_upwards_are_reported() {
    let import = |from: &str, to: &str| Import { from: from.into(), to: to.into(), path: "crate::x".into() };
    let upwards = [
        import("args.rs", "commands/render.rs"),
        import("args/shared.rs", "commands/mod.rs"),
        import("terminal/bar.rs", "args/shared.rs"),
        import("terminal/bar.rs", "commands/render.rs"),
    ];
    let downwards = [
        import("commands/render.rs", "args/shared.rs"),
        import("commands/render.rs", "terminal/bar.rs"),
        import("args/shared.rs", "terminal/text.rs"),
        import("args/shared.rs", "args/values.rs"),
    ];
    assert_eq!(forbidden(&downwards.into()), [""; 0]);
    assert_eq!(forbidden(&upwards.clone().into()).len(), upwards.len());
}
