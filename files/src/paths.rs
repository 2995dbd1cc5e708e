//! Detects paths that refer to the same file.

use std::fs;
use std::path::{Path, PathBuf};

/// Finds the first of `outputs` that is the same file as an input or an earlier output. Returns its index in `outputs`,
/// and the index of the other path in the inputs followed by the outputs.
pub fn first_clash(inputs: &[&Path], outputs: &[&Path]) -> Option<(usize, usize)> {
    let mut taken: Vec<PathBuf> = inputs.iter().map(|path| identity(path)).collect();
    for (index, path) in outputs.iter().enumerate() {
        let file = identity(path);
        if let Some(other) = taken.iter().position(|other| *other == file) {
            return Some((index, other));
        }
        taken.push(file);
    }
    None
}

/// `path` with symbolic links and `..` resolved, so that two paths to the same file compare equal.
fn identity(path: &Path) -> PathBuf {
    if let Ok(file) = fs::canonicalize(path) {
        return file;
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (fs::canonicalize(folder), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_by_two_names_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let [a, detour, b] = ["a", "./a", "b"].map(|name| folder.path().join(name));
        assert_eq!(first_clash(&[&a], &[&b, &detour]), Some((1, 0)));
        assert_eq!(first_clash(&[], &[&a, &b, &detour]), Some((2, 0)));
        assert_eq!(first_clash(&[&a], &[&b]), None);
    }
}
