//! Files on their way: without a name until they are whole, where the system can do that, so that a process that is
//! killed leaves nothing behind; else with a temporary one.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;
use tempfile::{Builder, TempPath};

/// Where a file on its way is.
pub(super) enum Place {
    /// Nowhere yet: it goes with the last handle to it.
    #[cfg(target_os = "linux")]
    Nameless,
    /// Beside its target; removed when dropped.
    Named(TempPath),
}

/// Makes an empty file in `folder`, as only there a rename is atomic.
pub(super) fn create(folder: &Path) -> io::Result<(File, Place)> {
    #[cfg(target_os = "linux")]
    if let Some(file) = nameless(folder) {
        return Ok((file, Place::Nameless));
    }
    // Opened by `OpenOptions`, as the crate's own way makes files that only their owner may read.
    let open = |p: &Path| OpenOptions::new().write(true).create_new(true).open(p);
    let (file, path) = builder(&mut Builder::new()).make_in(folder, open)?.into_parts();
    Ok((file, Place::Named(path)))
}

impl Place {
    /// Puts `file`, which is here, in the place of `target`, a file in `folder`.
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

/// Puts the file that `make` makes in `folder` in the place of `target`.
pub(super) fn rename_new(
    folder: &Path,
    target: &Path,
    make: impl FnMut(&Path) -> io::Result<()>,
) -> io::Result<()> {
    let ((), path) = builder(&mut Builder::new()).make_in(folder, make)?.into_parts();
    let made = path.to_path_buf();
    path.persist(target).map_err(|e| e.error)?;
    // A rename does nothing if both are names of one file.
    match fs::remove_file(made) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

fn builder<'a, 'b>(builder: &'a mut Builder<'b, 'b>) -> &'a mut Builder<'b, 'b> {
    builder.prefix(".sppm-").suffix(".part")
}

/// A file without a name, if the file system knows such and there is a way to name it later.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags};
    let mode = Mode::from_raw_mode(0o666); // what the umask leaves of it
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

/// Asks the file system for `bytes` bytes of `file`. Those that cannot promise (and systems that cannot be asked)
/// count as willing.
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
