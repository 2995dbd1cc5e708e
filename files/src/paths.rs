//! Where paths lead, whether two lead to the same file, and the names of files that accompany another.

use sha2::{Digest as _, Sha256};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The longest file name that all common file systems allow, in bytes.
const LONGEST_NAME: usize = 255;
/// A path with more symbolic links in a row than this is taken for a circle, as by Linux.
const MOST_LINKS: usize = 40;

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

/// `path` with symbolic links and `..` resolved, so that two paths to the same file compare equal. The file need not
/// exist.
pub fn identity(path: &Path) -> PathBuf {
    if let Ok(file) = fs::canonicalize(path) {
        return file;
    }
    let path = follow(path).unwrap_or_else(|_| path.to_owned());
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (fs::canonicalize(folder), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path,
    }
}

/// The path that `path` leads to if it is a symbolic link, or a link to a link, whether or not there is a file yet; else
/// `path` itself.
///
/// # Errors
/// If links lead in a circle.
pub fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&at) {
            Ok(target) => at = at.parent().unwrap_or(Path::new("")).join(target),
            Err(_) => return Ok(at),
        }
    }
    Err(io::Error::other("its symbolic links lead in a circle"))
}

/// `path` with `prefix` before its file name and `suffix` after it. A name that would be too long for the file system is
/// cut, and told apart by a hash of the whole name.
pub fn around(path: &Path, prefix: &str, suffix: &str) -> PathBuf {
    let name = path.file_name().unwrap_or_default();
    let room = LONGEST_NAME.saturating_sub(prefix.len() + suffix.len());
    if name.len() <= room {
        let mut whole = std::ffi::OsString::from(prefix);
        whole.push(name);
        whole.push(suffix);
        return path.with_file_name(whole);
    }
    let digest = Sha256::digest(name.as_encoded_bytes());
    let hash = digest.iter().take(8).fold(0_u64, |hash, byte| hash << 8 | u64::from(*byte));
    let hash = format!("-{hash:016x}");
    let name = name.to_string_lossy();
    let start = &name[..name.floor_char_boundary(room.saturating_sub(hash.len()))];
    path.with_file_name(format!("{prefix}{start}{hash}{suffix}"))
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

    #[cfg(unix)]
    #[test]
    fn links_are_followed_to_files_that_do_not_exist_yet() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let [to_be, near, far, circle] =
            ["to be", "near", "far", "circle"].map(|name| folder.path().join(name));
        symlink("to be", &near).unwrap();
        symlink("./near", &far).unwrap();
        symlink("circle", &circle).unwrap();
        assert_eq!(identity(&far), identity(&to_be));
        assert_eq!(first_clash(&[&near], &[&far]), Some((0, 0)));
        assert_eq!(follow(&to_be).unwrap(), to_be);
        assert!(follow(&circle).is_err());
        identity(&circle); // ends
    }

    /// Whether or not the file is there: an output mostly is not, before it is written.
    #[cfg(unix)]
    #[test]
    fn ways_through_other_folders_lead_to_the_same_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("real/sub")).unwrap();
        std::os::unix::fs::symlink("real", at("link")).unwrap();
        for exists in [false, true] {
            if exists {
                fs::write(at("real/a"), "").unwrap();
            }
            let file = at("real/a");
            for way in ["link/a", "real/sub/../a", "link/sub/../a"] {
                assert_eq!(identity(&at(way)), identity(&file), "{way}");
                assert_eq!(first_clash(&[&file], &[&at(way)]), Some((0, 0)), "{way}");
            }
            assert_eq!(first_clash(&[&file], &[&at("a"), &at("real/sub/a")]), None);
        }
    }

    #[test]
    fn long_names_are_cut_and_still_told_apart() {
        let long = |last: &str| Path::new("folder").join("\u{e4}".repeat(120) + last);
        let cut = around(&long("1234567890.png"), "", ".sppm");
        let name = cut.file_name().unwrap().to_str().unwrap();
        assert!(name.len() <= LONGEST_NAME && cut.extension() == Some("sppm".as_ref()), "{name}");
        assert_eq!(cut.parent(), Some(Path::new("folder")));
        assert_eq!(cut, around(&long("1234567890.png"), "", ".sppm"));
        assert_ne!(cut, around(&long("1234567891.png"), "", ".sppm"));
        assert!(around(&cut, ".sppm-", ".lock").file_name().unwrap().len() <= LONGEST_NAME);
        assert_eq!(around(Path::new("a/b.png"), "", ".sppm"), Path::new("a/b.png.sppm"));
        assert_eq!(around(Path::new("a/b.png"), ".sppm-", ".lock"), Path::new("a/.sppm-b.png.lock"));
        // What just has room is whole.
        let (full, more) = ("n".repeat(LONGEST_NAME - 5), "n".repeat(LONGEST_NAME - 4));
        assert_eq!(around(Path::new(&full), "", ".sppm"), Path::new(&format!("{full}.sppm")));
        assert_eq!(around(Path::new(&more), "", ".sppm").as_os_str().len(), LONGEST_NAME);
    }
}
