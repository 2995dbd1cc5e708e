//! Temporary files that become the target once they are complete.
//!
//! On Linux they have no name until then (`O_TMPFILE`), so a killed process leaves nothing behind. Elsewhere they have
//! a temporary name.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;
use tempfile::{Builder, TempPath};

/// Where a temporary file is.
pub(super) enum Place {
    /// It has no name; it disappears when its last handle is closed.
    #[cfg(target_os = "linux")]
    Nameless,
    /// Beside its target, under a temporary name; removed when dropped.
    Named(TempPath),
}

/// Creates an empty temporary file in `folder`. It must be the target's folder, as renames between file systems are
/// not atomic.
pub(super) fn create(folder: &Path) -> io::Result<(File, Place)> {
    #[cfg(target_os = "linux")]
    if let Some(file) = nameless(folder) {
        return Ok((file, Place::Nameless));
    }
    // Opened by `OpenOptions`, because `tempfile` itself would create files that only their owner may read.
    let open = |p: &Path| OpenOptions::new().write(true).create_new(true).open(p);
    let (file, path) = builder(&mut Builder::new()).make_in(folder, open)?.into_parts();
    Ok((file, Place::Named(path)))
}

impl Place {
    /// Replaces `target`, a file in `folder`, with the temporary `file`.
    pub(super) fn persist(self, file: &File, folder: &Path, target: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Nameless => rename_new(folder, target, |p| give_name(file, p)),
            Self::Named(path) => {
                let _ = (file, folder);
                path.persist(target).map_err(|e| e.error)
            }
        }
    }
}

/// Lets `make` create a file under a temporary name in `folder`, then renames it to `target`.
pub(super) fn rename_new(
    folder: &Path,
    target: &Path,
    make: impl FnMut(&Path) -> io::Result<()>,
) -> io::Result<()> {
    let ((), path) = builder(&mut Builder::new()).make_in(folder, make)?.into_parts();
    let made = path.to_path_buf();
    path.persist(target).map_err(|e| e.error)?;
    // If both names are hard links to the same file, the rename does nothing and the temporary name remains.
    match fs::remove_file(made) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

fn builder<'a, 'b>(builder: &'a mut Builder<'b, 'b>) -> &'a mut Builder<'b, 'b> {
    builder.prefix(".sppm-").suffix(".part")
}

/// A file without a name, if the file system supports it and the file can be named later through `/proc`.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags};
    let mode = Mode::from_raw_mode(0o666); // reduced by the umask
    let file =
        File::from(rustix::fs::open(folder, OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC, mode).ok()?);
    link_of(&file).exists().then_some(file)
}

#[cfg(target_os = "linux")]
fn give_name(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD};
    Ok(rustix::fs::linkat(CWD, link_of(file), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(target_os = "linux")]
fn link_of(file: &File) -> std::path::PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

/// Reserves `bytes` bytes for `file`. Succeeds where the file system or the operating system cannot reserve space.
pub(super) fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{FallocateFlags, fallocate};
        use rustix::io::Errno;
        let reserved = fallocate(file, FallocateFlags::empty(), 0, bytes.max(1));
        if let Err(e @ (Errno::NOSPC | Errno::DQUOT | Errno::FBIG)) = reserved {
            return Err(e.into());
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (file, bytes);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a killed process may leave is told by its name.
    #[test]
    fn temporary_names_say_whose_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let made = builder(&mut Builder::new()).tempfile_in(folder.path()).unwrap();
        let name = made.path().file_name().unwrap().to_string_lossy();
        assert!(name.strip_prefix(".sppm-").and_then(|rest| rest.strip_suffix(".part")).is_some(), "{name}");
    }

    #[test]
    fn files_are_renamed_once_they_are_made() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        rename_new(folder.path(), &target, |path| fs::write(path, "new")).unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert!(rename_new(folder.path(), &target, |_| Err(io::ErrorKind::StorageFull.into())).is_err());
        // Of two names of one file, the rename does nothing.
        rename_new(folder.path(), &target, |path| fs::hard_link(&target, path)).unwrap();
        let left: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["a"]);
    }
}
