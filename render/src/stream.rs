//! An image that is written to a stream, such as standard output or a socket, instead of a file.

use files::atomic_file::{FileError, reason};
use std::fmt;
use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Where an image goes that is written to a stream. It is encoded as a whole first, in a temporary file, so that the
/// stream gets all of it or nothing.
#[derive(Clone)]
pub struct Stream {
    name: String,
    extension: String,
    sink: Arc<Mutex<dyn Write + Send>>,
}

impl Stream {
    /// Writes the image to `sink`, in the format of a file with this `extension`, such as `png`. Messages call the sink
    /// `name`.
    pub fn new(name: &str, extension: &str, sink: impl Write + Send + 'static) -> Self {
        Self { name: name.into(), extension: extension.into(), sink: Arc::new(Mutex::new(sink)) }
    }

    /// What messages call it, in the place of a path.
    pub(crate) fn path(&self) -> PathBuf {
        PathBuf::from(&self.name)
    }

    /// The name of a file of its format.
    pub(crate) fn file_name(&self) -> PathBuf {
        PathBuf::from(format!("image.{}", self.extension))
    }

    /// Sends what `write` writes to a file. That the other end of a pipe was closed is no error: its reader has seen enough.
    pub(crate) fn send(&self, write: impl FnOnce(&Path) -> Result<(), FileError>) -> Result<(), FileError> {
        let failed =
            |e: io::Error| FileError::new(&self.path(), format!("cannot be written: {}", reason(&e)));
        let folder = tempfile::tempdir().map_err(failed)?;
        let file = folder.path().join(self.file_name());
        write(&file)?;
        let mut file = File::open(file).map_err(failed)?;
        let mut sink = self.sink.lock().unwrap_or_else(PoisonError::into_inner);
        match io::copy(&mut file, &mut *sink).and_then(|_| sink.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(failed(error)),
            _ => Ok(()),
        }
    }
}

impl fmt::Debug for Stream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Stream")
            .field("name", &self.name)
            .field("extension", &self.extension)
            .finish_non_exhaustive()
    }
}

/// Streams are equal if they write to the same sink, in the same format.
impl PartialEq for Stream {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.sink, &other.sink) && self.extension == other.extension
    }
}
