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

#[cfg(test)]
mod tests {
    use super::*;

    /// What a caller writes to.
    #[derive(Clone, Default)]
    struct Sink(Arc<Mutex<Vec<u8>>>);

    impl Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn streams_are_equal_that_write_the_same_to_the_same() {
        let stream = Stream::new("a socket", "png", Sink::default());
        assert_eq!(stream, stream.clone());
        assert_ne!(stream, Stream::new("a socket", "png", Sink::default()));
        let other_format = Stream { extension: "exr".into(), ..stream.clone() };
        assert_ne!(stream, other_format);
    }

    #[test]
    fn a_stream_gets_all_of_an_image_or_nothing() {
        let sink = Sink::default();
        let stream = Stream::new("a socket", "png", sink.clone());
        let write = |path: &Path| {
            assert_eq!(path.file_name(), Some("image.png".as_ref()));
            std::fs::write(path, "whole").map_err(|e| FileError::new(path, e.to_string()))
        };
        let fail = |path: &Path| write(path).and(Err(FileError::new(path, "is half")));
        assert!(stream.send(fail).is_err() && sink.0.lock().unwrap().is_empty());
        stream.send(write).unwrap();
        assert_eq!(*sink.0.lock().unwrap(), b"whole");
    }

    /// What a sink keeps back is sent on too: nobody else will do so while the caller holds the stream.
    #[test]
    fn a_stream_is_flushed_behind_the_image() {
        let sink = Sink::default();
        let stream = Stream::new("a pipe", "png", io::BufWriter::new(sink.clone()));
        let write =
            |path: &Path| std::fs::write(path, "whole").map_err(|e| FileError::new(path, e.to_string()));
        stream.send(write).unwrap();
        assert_eq!(*sink.0.lock().unwrap(), b"whole");
        // So a full disk is told that shows when the rest is written out.
        let full = Stream::new("a pipe", "png", io::BufWriter::new(Broken(ErrorKind::StorageFull)));
        let line = full.send(write).unwrap_err().to_string();
        assert!(line.starts_with("a pipe: cannot be written: "), "{line}");
    }

    /// A sink that can write no more.
    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_has_gone_is_no_error_and_all_else_is() {
        let send = |kind| {
            let write =
                |path: &Path| std::fs::write(path, "whole").map_err(|e| FileError::new(path, e.to_string()));
            Stream::new("a socket", "png", Broken(kind)).send(write)
        };
        assert_eq!(send(ErrorKind::BrokenPipe), Ok(()));
        let line = send(ErrorKind::StorageFull).unwrap_err().to_string();
        assert!(line.starts_with("a socket: cannot be written: "), "{line}");
    }
}
