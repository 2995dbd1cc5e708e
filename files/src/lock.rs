//! Locks files that are going to be replaced, so that of two processes only one works towards the same file.
//!
//! `FILE` is locked through `.sppm-FILE.lock` in the same folder. The operating system releases a lock when the process
//! that holds it ends, however it ends, so a lock file that a killed process leaves behind locks nothing.

use crate::atomic_file::{FileError, reason};
use crate::paths;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

/// How often the id of the process that holds a lock is looked for, as it is written just after the lock is taken.
const LOOKS_FOR_HOLDER: u32 = 10;
const BETWEEN_LOOKS: Duration = Duration::from_millis(10);

/// The exclusive right to replace a file; released when dropped.
#[derive(Debug)]
pub struct Lock {
    /// The lock file.
    path: PathBuf,
    file: File,
    uncertain: Option<FileError>,
}

impl Lock {
    /// Locks the file `path`, which need not exist. Its folder must. Of several names by which symbolic links lead to a
    /// file, each locks the same. Hard links to a file are different files, as replacing one does not change the others.
    ///
    /// # Errors
    /// If the file is locked, by another process or by this one, or if no lock file can be made in its folder.
    pub fn take(path: &Path) -> Result<Self, FileError> {
        Self::take_by(path, File::try_lock)
    }

    /// [`Self::take`] by the given system call.
    fn take_by(path: &Path, try_lock: impl Fn(&File) -> Result<(), TryLockError>) -> Result<Self, FileError> {
        let at = lock_file(path);
        let failed = |e: io::Error| FileError::new(path, format!("cannot be locked: {}", reason(&e)));
        loop {
            let mut file = open(&at).map_err(failed)?;
            let uncertain = match try_lock(&file) {
                Ok(()) => None,
                Err(TryLockError::WouldBlock) => return Err(in_use(path, &mut file)),
                Err(TryLockError::Error(error)) => Some(failed(error)),
            };
            // The last holder may have removed the file after we opened it and before we locked it.
            if is_still(&file, &at) {
                note_holder(&mut file);
                return Ok(Self { path: at, file, uncertain });
            }
        }
    }

    /// Whether this is the lock of the file `path`.
    pub fn is_of(&self, path: &Path) -> bool {
        self.path == lock_file(path)
    }

    /// Why it is not known that nobody else holds the lock, if the file system has no locks.
    pub fn uncertain(&self) -> Option<&FileError> {
        self.uncertain.as_ref()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if is_still(&self.file, &self.path) {
            let _ = fs::remove_file(&self.path); // a lock file that stays does no harm
        }
    }
}

fn lock_file(path: &Path) -> PathBuf {
    paths::around(&paths::identity(path), ".sppm-", ".lock")
}

/// Opens or creates a lock file. One that belongs to another user may not be written, but locked all the same.
fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    keep_to_files(&mut options);
    let file = match options.open(path) {
        Err(error) if error.kind() == ErrorKind::PermissionDenied && path.exists() => {
            options.write(false).create(false).open(path)
        }
        other => other,
    }?;
    if file.metadata()?.is_file() { Ok(file) } else { Err(io::Error::other("the lock is no regular file")) }
}

/// Neither follows a link that somebody else has put in the place of a lock file, nor waits for the other end of a pipe.
#[cfg(unix)]
fn keep_to_files(options: &mut OpenOptions) {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt as _;
    options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32);
}

#[cfg(not(unix))]
fn keep_to_files(_: &mut OpenOptions) {}

/// The error for a file that somebody else has locked through `lock`.
fn in_use(path: &Path, lock: &mut File) -> FileError {
    let mut holder = None;
    for look in 0..LOOKS_FOR_HOLDER {
        let mut text = String::new();
        // The process id is only for the message.
        let _ = lock.rewind().and_then(|()| lock.take(20).read_to_string(&mut text));
        holder = text.trim().parse::<u32>().ok();
        if holder.is_some() || look + 1 == LOOKS_FOR_HOLDER {
            break;
        }
        sleep(BETWEEN_LOOKS);
    }
    let who = holder.map_or(String::new(), |id| format!(", process {id}"));
    FileError::new(path, format!("is in use by another render{who}; wait for it, or name another file"))
}

/// Writes the id of this process into its lock file. It is only for messages, so failures are ignored.
fn note_holder(lock: &mut File) {
    let text = format!("{}\n", std::process::id());
    let _ = lock.write_all(text.as_bytes()).and_then(|()| lock.set_len(text.len() as u64));
}

/// Whether `path` still refers to the open `file`.
#[cfg(unix)]
fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |m: fs::Metadata| (m.dev(), m.ino());
    let (ours, there) = (file.metadata().map(identity), fs::symlink_metadata(path).map(identity));
    matches!((ours, there), (Ok(ours), Ok(there)) if ours == there)
}

#[cfg(not(unix))]
fn is_still(_: &File, _: &Path) -> bool {
    true // elsewhere an open file cannot be removed
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn names(folder: &TempDir) -> Vec<String> {
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(name).collect();
        names.sort();
        names
    }

    #[test]
    fn only_one_holds_the_lock() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.png");
        let lock = Lock::take(&path).unwrap();
        assert!(lock.is_of(&folder.path().join("./a.png")) && lock.uncertain().is_none());
        let line = Lock::take(&path).unwrap_err().to_string();
        let words = format!("is in use by another render, process {};", std::process::id());
        assert!(line.contains("a.png: ") && line.contains(&words), "{line}");
        Lock::take(&folder.path().join("b.png")).unwrap();
        drop(lock);
        assert_eq!(names(&folder), [""; 0]);
        Lock::take(&path).unwrap();
    }

    #[test]
    fn what_a_killed_process_leaves_locks_nothing() {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join(".sppm-a.png.lock"), "4711471147").unwrap();
        let lock = Lock::take(&folder.path().join("a.png")).unwrap();
        let holder = fs::read_to_string(&lock.path).unwrap();
        assert_eq!(holder, format!("{}\n", std::process::id()));
    }

    /// As on a file system without locks.
    #[test]
    fn where_nothing_can_be_locked_that_is_told() {
        let folder = TempDir::new().unwrap();
        let none = |_: &File| Err(TryLockError::Error(ErrorKind::Unsupported.into()));
        let lock = Lock::take_by(&folder.path().join("a.png"), none).unwrap();
        let line = lock.uncertain().unwrap().to_string();
        assert!(line.contains("a.png: cannot be locked: "), "{line}");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_file_lock_the_same_and_hard_links_do_not() {
        use std::os::unix::fs::symlink;
        let folder = TempDir::new().unwrap();
        let [file, link, far, hard] =
            ["a.png", "b.png", "c.png", "d.png"].map(|name| folder.path().join(name));
        symlink("a.png", &link).unwrap();
        symlink("b.png", &far).unwrap();
        for exists in [false, true] {
            if exists {
                fs::write(&file, "old").unwrap();
                fs::hard_link(&file, &hard).unwrap();
            }
            let _lock = Lock::take(&far).unwrap();
            for path in [&file, &link, &far] {
                assert!(Lock::take(path).is_err(), "{}", path.display());
            }
            Lock::take(&hard).unwrap();
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_stands_in_the_place_of_a_lock_is_left_alone() {
        use std::os::unix::fs::symlink;
        let folder = TempDir::new().unwrap();
        let (path, lock) = (folder.path().join("a.png"), folder.path().join(".sppm-a.png.lock"));
        fs::write(folder.path().join("precious"), "text").unwrap();
        symlink("precious", &lock).unwrap();
        assert!(Lock::take(&path).unwrap_err().problem.starts_with("cannot be locked: "));
        fs::remove_file(&lock).unwrap();
        fs::create_dir(&lock).unwrap();
        assert!(Lock::take(&path).unwrap_err().problem.starts_with("cannot be locked: "));
        assert_eq!(names(&folder), [".sppm-a.png.lock", "precious"]);
        assert_eq!(fs::read_to_string(folder.path().join("precious")).unwrap(), "text");
    }

    /// Locking one would wait for nobody, and would not keep anybody else away.
    #[cfg(unix)]
    #[test]
    fn a_pipe_is_no_lock() {
        use rustix::fs::{CWD, FileType, Mode, mknodat};
        let folder = TempDir::new().unwrap();
        let at = folder.path().join(".sppm-a.png.lock");
        mknodat(CWD, &at, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let error = Lock::take(&folder.path().join("a.png")).unwrap_err();
        assert_eq!(error.problem, "cannot be locked: the lock is no regular file");
        assert_eq!(names(&folder), [".sppm-a.png.lock"]);
    }

    /// It writes its id just after it has taken the lock, and may be killed or suspended in between.
    #[test]
    fn a_process_that_has_not_written_its_id_is_not_named() {
        let folder = TempDir::new().unwrap();
        let at = folder.path().join(".sppm-a.png.lock");
        for (text, who) in [("", ""), ("none\n", ""), ("47\n", ", process 47")] {
            fs::write(&at, text).unwrap();
            let holder = File::open(&at).unwrap();
            holder.lock().unwrap();
            let error = Lock::take(&folder.path().join("a.png")).unwrap_err();
            let told = format!("is in use by another render{who}; wait for it, or name another file");
            assert_eq!(error.problem, told, "{text:?}");
        }
    }

    /// Whose lock file was removed, by whoever tidied up, does not remove that of the next.
    #[cfg(unix)]
    #[test]
    fn who_has_lost_its_lock_leaves_that_of_others() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.png");
        let lost = Lock::take(&path).unwrap();
        fs::remove_file(&lost.path).unwrap();
        let lock = Lock::take(&path).unwrap();
        drop(lost);
        assert_eq!(names(&folder), [".sppm-a.png.lock"]);
        assert!(Lock::take(&path).is_err());
        drop(lock);
        assert_eq!(names(&folder), [""; 0]);
    }

    /// The last holder may remove the file just before we lock it: then it is no lock that others would find.
    #[cfg(unix)]
    #[test]
    fn a_lock_is_taken_through_a_file_that_is_there() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.png");
        let is_first = std::cell::Cell::new(true);
        let late = |file: &File| {
            if is_first.replace(false) {
                fs::remove_file(folder.path().join(".sppm-a.png.lock")).unwrap();
            }
            file.try_lock()
        };
        let _lock = Lock::take_by(&path, late).unwrap();
        assert_eq!(names(&folder), [".sppm-a.png.lock"]);
        assert!(Lock::take(&path).is_err());
    }

    /// A lock file that was removed, and one that stands in its place, are others.
    #[cfg(unix)]
    #[test]
    fn a_file_is_what_it_was_unless_it_was_replaced() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a");
        let file = File::create(&path).unwrap();
        assert!(is_still(&file, &path));
        fs::rename(&path, folder.path().join("b")).unwrap();
        assert!(!is_still(&file, &path));
        fs::write(&path, "").unwrap();
        assert!(!is_still(&file, &path));
        // A link to the same file is another thing, which may change.
        fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink(folder.path().join("b"), &path).unwrap();
        assert!(!is_still(&file, &path));
    }

    #[test]
    fn a_folder_is_no_lock() {
        let folder = TempDir::new().unwrap();
        assert_eq!(open(folder.path()).unwrap_err().kind(), ErrorKind::IsADirectory);
        assert_eq!(open(&folder.path().join("a/b")).unwrap_err().kind(), ErrorKind::NotFound);
        assert!(open(&folder.path().join("a")).is_ok());
    }
}
