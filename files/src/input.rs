//! Opens input files: regular files alone, so that no reader ever waits for the other end of a pipe.

use crate::atomic_file::reason;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

/// Opens the file `path` and returns it with its length in bytes. `expected` ends the message for what is no file.
///
/// # Errors
/// If it does not exist, is no regular file, or cannot be read. The message continues the path.
pub fn open(path: &Path, expected: &str) -> Result<(File, u64), String> {
    let unreadable = |error: io::Error| match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        _ => format!("cannot be read: {}", reason(&error)),
    };
    // Before opening, because opening a device may have effects; and after, because the path may lead elsewhere by then.
    check(&fs::metadata(path).map_err(unreadable)?, expected)?;
    let file = open_at_once(path).map_err(unreadable)?;
    let status = file.metadata().map_err(unreadable)?;
    check(&status, expected)?;
    Ok((file, status.len()))
}

fn check(status: &Metadata, expected: &str) -> Result<(), String> {
    if status.is_dir() {
        Err(format!("this is a directory; {expected}"))
    } else if status.is_file() {
        Ok(())
    } else {
        Err(format!("this is a pipe or a device; {expected}"))
    }
}

/// Opens a file without waiting for anybody.
#[cfg(unix)]
fn open_at_once(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt as _;
    OpenOptions::new().read(true).custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32).open(path)
}

#[cfg(not(unix))]
fn open_at_once(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(path: &Path) -> String {
        open(path, "name a file").map(drop).unwrap_err()
    }

    #[test]
    fn only_regular_files_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        assert_eq!(problem(&path), "there is no such file");
        assert_eq!(problem(folder.path()), "this is a directory; name a file");
        fs::write(&path, "text").unwrap();
        assert_eq!(open(&path, "").unwrap().1, 4);
        // A file is no folder in which another could be missing.
        #[cfg(unix)]
        assert!(problem(&path.join("b")).starts_with("cannot be read: "), "{}", problem(&path.join("b")));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_the_file_that_it_leads_to() {
        let folder = tempfile::tempdir().unwrap();
        let [path, link, lost] = ["a", "link", "lost"].map(|name| folder.path().join(name));
        fs::write(&path, "text").unwrap();
        std::os::unix::fs::symlink("a", &link).unwrap();
        std::os::unix::fs::symlink("none", &lost).unwrap();
        assert_eq!(open(&link, "").unwrap().1, 4);
        assert_eq!(problem(&lost), "there is no such file");
    }

    /// Opening a pipe by itself would wait for a writer for ever.
    #[cfg(unix)]
    #[test]
    fn a_pipe_is_refused_at_once() {
        use rustix::fs::{CWD, FileType, Mode, mknodat};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        mknodat(CWD, &path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        assert_eq!(problem(&path), "this is a pipe or a device; name a file");
        assert_eq!(problem(Path::new("/dev/null")), "this is a pipe or a device; name a file");
        open_at_once(&path).unwrap(); // if a pipe takes the place of a file in between
    }
}
