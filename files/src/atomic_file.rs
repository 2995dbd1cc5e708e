//! Atomic file replacement: a file is written next to its target, synced, and renamed over it.
//!
//! A reader sees either the old file or the complete new one. If a write fails, the old file stays and no temporary
//! file is left behind.

mod temporary;

use crate::paths;
use scene::text::mebibytes;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use temporary::Place;
use thiserror::Error;

/// A file that cannot be read or written. Displays as one line that starts with the path.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}: {}", shown(.path), one_line(.problem))]
pub struct FileError {
    /// The file as the caller named it.
    pub path: PathBuf,
    /// What is wrong and how to fix it; reads as a continuation of the path.
    pub problem: String,
}

impl FileError {
    /// An error about the file `path`.
    pub fn new(path: &Path, problem: impl Into<String>) -> Self {
        Self { path: path.to_owned(), problem: problem.into() }
    }
}

/// The buffered, seekable file that `fill` writes to.
pub type Output = BufWriter<File>;

/// Replaces the file `path` with what `fill` writes.
///
/// A new file gets the default permissions (by the umask); a replaced file keeps its own. If `path` is a symbolic
/// link, the link stays and the file that it points to is replaced or created.
///
/// # Errors
/// If [`check`] fails, or on an error of `fill` or the file system. The target is then unchanged.
pub fn replace(path: &Path, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), FileError> {
    replace_and_keep(path, None, fill)
}

/// Like [`replace`], but keeps the old file, if there is one, as `previous` in the same folder.
///
/// At least one of the two files exists at any time. On file systems without hard links, `path` is missing for a
/// moment.
///
/// # Errors
/// Like [`replace`].
pub fn replace_and_keep(
    path: &Path,
    previous: Option<&Path>,
    fill: impl FnOnce(&mut Output) -> io::Result<()>,
) -> Result<(), FileError> {
    let target = Target::find(path)?;
    let (file, place) = target.temporary(path)?;
    let failed = |e: io::Error| FileError::new(path, format!("cannot be written: {}", reason(&e)));
    if let Some(permissions) = &target.permissions {
        file.set_permissions(permissions.clone()).map_err(failed)?;
    }
    let mut output = BufWriter::new(file);
    fill(&mut output).map_err(failed)?;
    let mut file = output.into_inner().map_err(|e| failed(e.into_error()))?;
    file.flush().and_then(|()| file.sync_all()).map_err(failed)?;
    if let (Some(previous), Some(_)) = (previous, &target.permissions) {
        let linked = temporary::rename_new(&target.folder, previous, |new| fs::hard_link(&target.file, new));
        linked.or_else(|_| fs::rename(&target.file, previous)).map_err(failed)?;
    }
    place.persist(&file, &target.folder, &target.file).map_err(failed)?;
    sync_folder(&target.folder).map_err(failed)
}

/// Saves the content of `path`, which could not be written, under another name: in the same folder or, failing that,
/// in the temporary folder. Never overwrites a file. Returns the path, if one of the two could be written.
pub fn rescue(path: &Path, write: impl Fn(&Path) -> Result<(), FileError>) -> Option<PathBuf> {
    let stem = path.file_stem().unwrap_or(OsStr::new("image"));
    let extension = path.extension().unwrap_or(OsStr::new("json")).to_string_lossy();
    let suffix = format!("-rescued-{}.{extension}", std::process::id());
    [path.with_file_name(stem), std::env::temp_dir().join(stem)]
        .map(|whole| paths::around(&whole, "", &suffix))
        .into_iter()
        .find(|refuge| !refuge.exists() && write(refuge).is_ok())
}

/// Like [`check`], and also checks that the disk has room for `bytes` bytes.
///
/// # Errors
/// If there is too little room on the disk, in a quota or within the process's file size limit, or if [`check`] fails.
pub fn check_room(path: &Path, bytes: u64) -> Result<(), FileError> {
    let (file, _place) = Target::find(path)?.temporary(path)?;
    temporary::reserve(&file, bytes).map_err(|e| {
        FileError::new(path, format!("there is no room for its {}: {}", mebibytes(bytes), reason(&e)))
    })
}

/// Checks in advance whether [`replace`] can write to `path`.
///
/// # Errors
/// If `path` names a folder, a device, a pipe, a read-only file or a circle of links, or if no file can be created in its
/// folder.
pub fn check(path: &Path) -> Result<(), FileError> {
    Target::find(path)?.temporary(path).map(drop)
}

/// The message of an I/O error, or of an error that quotes one, without the error number that Rust appends.
pub fn reason(error: &impl ToString) -> String {
    let mut text = error.to_string();
    while let Some(start) = text.find(" (os error ") {
        let Some(length) = text[start..].find(')') else { break };
        text.replace_range(start..=start + length, "");
    }
    text
}

/// The path for messages, on one line.
fn shown(path: &Path) -> String {
    one_line(&path.display().to_string())
}

/// The text, escaped if it contains control characters such as line breaks.
fn one_line(text: &str) -> String {
    if text.chars().any(char::is_control) { text.escape_debug().to_string() } else { text.to_owned() }
}

/// The file to be written.
struct Target {
    /// Its path, with symbolic links resolved.
    file: PathBuf,
    folder: PathBuf,
    /// Permissions of the file to be replaced, if it exists.
    permissions: Option<fs::Permissions>,
}

impl Target {
    fn find(path: &Path) -> Result<Self, FileError> {
        let error = |problem: String| Err(FileError::new(path, problem));
        if path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
            return error("names a folder; name a file in it".into());
        }
        let file = resolve(path)?;
        let folder = match file.parent() {
            Some(parent) if parent != Path::new("") => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        match fs::metadata(&folder) {
            Ok(m) if m.is_dir() => {}
            Ok(_) => return error(format!("{} is not a folder", shown(&folder))),
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                return error(format!("the folder {} does not exist; make it first", shown(&folder)));
            }
            Err(e) => {
                return error(format!("the folder {} cannot be used: {}", shown(&folder), reason(&e)));
            }
        }
        let permissions = match fs::metadata(&file) {
            Ok(m) if m.is_dir() => return error("is a folder; name a file in it".into()),
            Ok(m) if !m.is_file() => {
                return error("is a device or a pipe; name a file, which can be replaced as a whole".into());
            }
            Ok(m) if m.permissions().readonly() => {
                return error("is read-only; make it writable, or name another file".into());
            }
            Ok(m) => Some(m.permissions()),
            Err(e) if e.kind() == io::ErrorKind::NotFound => None,
            Err(e) => return error(format!("cannot be written: {}", reason(&e))),
        };
        Ok(Self { file, folder, permissions })
    }

    /// An empty file in the target's folder.
    fn temporary(&self, path: &Path) -> Result<(File, Place), FileError> {
        temporary::create(&self.folder).map_err(|e| {
            let folder = shown(&self.folder);
            FileError::new(path, format!("no file can be made in the folder {folder}: {}", reason(&e)))
        })
    }
}

/// `path` with a symbolic link resolved.
fn resolve(path: &Path) -> Result<PathBuf, FileError> {
    let followed = match fs::metadata(path) {
        Ok(status) if !status.is_file() => return Ok(path.to_owned()), // the link to a pipe leads to no path
        _ => paths::follow(path),
    };
    followed
        .map_err(|e| FileError::new(path, format!("cannot be followed: {}; name another file", reason(&e))))
}

/// Syncs the folder, so that the rename survives a power failure.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(not(unix)) {
        return Ok(()); // other systems cannot open folders as files
    }
    match File::open(folder).and_then(|f| f.sync_all()) {
        // Some file systems cannot sync folders, and a folder may be writable without being readable.
        Err(e)
            if matches!(
                e.kind(),
                io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported | io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_the_way_of_a_file_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        let problem = |name: &str| Target::find(&at(name)).err().map(|error| error.problem);
        let shown = |name: &str| at(name).display().to_string();
        assert_eq!([problem("new"), problem("file")], [None, None]);
        assert_eq!(
            problem("a/new"),
            Some(format!("the folder {} does not exist; make it first", shown("a")))
        );
        assert_eq!(problem("file/new"), Some(format!("{} is not a folder", shown("file"))));
        let told = problem("file/a/new").unwrap();
        assert!(told.starts_with(&format!("the folder {} cannot be used: ", shown("file/a"))), "{told}");
        assert_eq!(problem("new/").as_deref(), Some("names a folder; name a file in it"));
        assert_eq!(
            Target::find(folder.path()).err().map(|error| error.problem).as_deref(),
            Some("is a folder; name a file in it")
        );
        // A name alone is in the current folder.
        assert_eq!(Target::find(Path::new("no such file")).unwrap().folder, Path::new("."));
    }

    /// Beside the file that cannot be written, or else in the temporary folder, and never over another.
    #[test]
    fn what_is_rescued_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let stem = folder.path().file_name().unwrap().to_str().unwrap(); // nobody else's
        let path = folder.path().join(format!("{stem}.png"));
        let name = format!("{stem}-rescued-{}.png", std::process::id());
        let [beside, elsewhere] = [folder.path().join(&name), std::env::temp_dir().join(&name)];
        let write = |path: &Path| fs::write(path, "new").map_err(|e| FileError::new(path, e.to_string()));
        assert_eq!(rescue(&path, write), Some(beside.clone()));
        fs::write(&beside, "old").unwrap();
        assert_eq!(rescue(&path, write), Some(elsewhere.clone()));
        assert_eq!(rescue(&path, write), None);
        fs::remove_file(elsewhere).unwrap();
        assert_eq!(fs::read_to_string(beside).unwrap(), "old");
        let full = |path: &Path| Err(FileError::new(path, "is full"));
        assert_eq!(rescue(&folder.path().join("b.png"), full), None);
    }

    /// Statistics alone may have a name without an extension.
    #[test]
    fn what_is_rescued_keeps_its_extension() {
        let write = |_: &Path| Ok(());
        for (name, extension) in [("a.tar.exr", "exr"), ("a", "json")] {
            let refuge = rescue(&Path::new("none").join(name), write).unwrap();
            assert_eq!(refuge.extension(), Some(OsStr::new(extension)), "{}", refuge.display());
        }
    }

    /// Names are shown as they are, unless that would break the line.
    #[test]
    fn errors_are_one_line_that_names_the_file() {
        let line = |path: &str, problem: &str| FileError::new(Path::new(path), problem).to_string();
        assert_eq!(line("it's \u{e4}.png", "isn't \"good\""), "it's \u{e4}.png: isn't \"good\"");
        assert_eq!(line("a\nb", "c\td"), "a\\nb: c\\td");
    }

    /// Those of the system are for programmers.
    #[test]
    fn reasons_have_no_error_numbers() {
        let text = "a: is gone (os error 2); and b: is full (os error 28)";
        assert_eq!(reason(&text), "a: is gone; and b: is full");
        assert_eq!(reason(&"cut (os error 2"), "cut (os error 2");
    }

    /// Links are always writable: the file that one leads to is what may not be replaced.
    #[cfg(unix)]
    #[test]
    fn read_only_files_are_not_replaced_by_their_name_or_by_a_link() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["kept", "link"].map(|name| folder.path().join(name));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink("kept", &link).unwrap();
        let set_mode = |mode| fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
        set_mode(0o444);
        for path in [&file, &link] {
            let error = replace(path, |output| output.write_all(b"new")).unwrap_err();
            assert_eq!(error.path, *path);
            assert_eq!(error.problem, "is read-only; make it writable, or name another file");
        }
        assert_eq!(fs::read(&file).unwrap(), b"old");
        set_mode(0o644);
        replace(&link, |output| output.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    /// Not the file that a link leads to, of which the user may not know.
    #[cfg(unix)]
    #[test]
    fn a_write_that_fails_is_told_by_the_name_that_was_given() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("real", &link).unwrap();
        let full = |_: &mut Output| Err(io::Error::from(io::ErrorKind::StorageFull));
        let error = replace(&link, full).unwrap_err();
        assert_eq!(error.path, link);
        assert!(error.problem.starts_with("cannot be written: "), "{error}");
    }
}
