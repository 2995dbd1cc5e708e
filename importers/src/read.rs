//! Reads files of all formats.

use crate::detect::format_of;
use crate::error::{Error, Fault, no_such_frame};
use crate::format::Format;
use crate::particles::Particles;
use crate::request::{Frame, Request};
use crate::text::{Position, Source, Text};
use crate::unit::Unit;
use crate::{delimited, dump, gro, gsd, mmcif, npy, npz, pdb, ply, xyz};
use std::fs::{self, File};
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

/// Reads the particles of one frame of a file.
///
/// The format is told by the name and, where that is doubtful, by the content. Uses the threads of the current rayon
/// pool.
///
/// # Errors
/// If the file cannot be read, is in no format of [`Format`], is damaged, has no such frame, or does not fit the memory.
pub fn read(path: &Path, request: &Request) -> Result<Particles, Error> {
    let name = path.display().to_string();
    let read = || {
        let mut file = open(path)?;
        let format = format_of(path, &mut file)?;
        frame_of(&mut file, format, request)
    };
    read().map_err(|fault: Fault| fault.named(&name))
}

/// Like [`read`], from an input that is in memory or open already. `name` stands in errors.
///
/// # Errors
/// Like [`read`].
pub fn read_from(
    name: &str,
    mut input: impl Read + Seek,
    format: Format,
    request: &Request,
) -> Result<Particles, Error> {
    frame_of(&mut input, format, request).map_err(|fault| fault.named(name))
}

/// The number of frames of a file. Reads all of a text file, quickly.
///
/// # Errors
/// Like [`read`].
pub fn frames(path: &Path) -> Result<usize, Error> {
    Trajectory::open(path).map(|trajectory| trajectory.frames())
}

/// A file of several frames with an index of where they start, so that each is found at once. (In compressed files all
/// that is before a frame has to be decompressed again.)
#[derive(Debug)]
pub struct Trajectory {
    path: PathBuf,
    format: Format,
    frames: usize,
    /// Where frames start, of formats in which they follow each other.
    starts: Vec<Position>,
}

impl Trajectory {
    /// Opens a file and looks where its frames start.
    ///
    /// # Errors
    /// Like [`read`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let open = || {
            let mut file = open(path)?;
            let format = format_of(path, &mut file)?;
            let mut starts = Vec::new();
            let frames = match reader(format) {
                Reader::Sequence(sequence) => {
                    sequence.scan(&mut file, |start| starts.push(start))?;
                    starts.len()
                }
                Reader::Whole(whole) => (whole.frames)(&mut file)?,
                Reader::Single(_) => 1,
            };
            Ok(Self { path: path.to_owned(), format, frames, starts })
        };
        open().map_err(|fault: Fault| fault.named(&path.display().to_string()))
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// Like [`read`].
    pub fn read(&self, request: &Request) -> Result<Particles, Error> {
        let number = match request.frame {
            Frame::Number(number) => number,
            Frame::Last => self.frames.saturating_sub(1),
        };
        let read = || {
            if number >= self.frames {
                return Err(no_such_frame(number, self.frames));
            }
            let mut file = open(&self.path)?;
            match reader(self.format) {
                Reader::Sequence(sequence) => {
                    let mut text = Text::new(&mut file, self.starts[number])?;
                    let particles = (sequence.read)(&mut text, request)?;
                    Ok(numbered(sequence.with_unit(particles, &mut file)?, number))
                }
                _ => frame_of(
                    &mut file,
                    self.format,
                    &Request { frame: Frame::Number(number), ..request.clone() },
                ),
            }
        };
        read().map_err(|fault| fault.named(&self.path.display().to_string()))
    }
}

/// How frames of a format are found.
enum Reader {
    /// They follow each other, each with its own header.
    Sequence(Sequence),
    /// The file has to be read as a whole.
    Whole(Whole),
    /// The file has one frame.
    Single(fn(&mut dyn Source, &Request) -> Result<Particles, Fault>),
}

struct Sequence {
    /// Skips a frame; `false` if there is none.
    skip: fn(&mut Text) -> Result<bool, Fault>,
    /// Reads a frame.
    read: fn(&mut Text, &Request) -> Result<Particles, Fault>,
    /// The unit of all frames, of formats in which the first frame states it.
    unit: Option<fn(&mut Text) -> Unit>,
}

struct Whole {
    frames: fn(&mut dyn Source) -> Result<usize, Fault>,
    /// Reads a frame by its number.
    read: fn(&mut dyn Source, usize, &Request) -> Result<Particles, Fault>,
}

fn reader(format: Format) -> Reader {
    match format {
        Format::Xyz => Reader::Sequence(Sequence { skip: xyz::skip, read: xyz::read, unit: None }),
        Format::Gro => Reader::Sequence(Sequence { skip: gro::skip, read: gro::read, unit: None }),
        Format::Dump => {
            Reader::Sequence(Sequence { skip: dump::skip, read: dump::read, unit: Some(dump::unit) })
        }
        Format::Pdb => Reader::Whole(Whole { frames: pdb::frames, read: pdb::read }),
        Format::Mmcif => Reader::Whole(Whole { frames: mmcif::frames, read: mmcif::read }),
        Format::Ply => Reader::Single(ply::read),
        Format::Csv => Reader::Single(delimited::read),
        Format::Npy => Reader::Whole(Whole { frames: npy::frames, read: npy::read }),
        Format::Npz => Reader::Single(npz::read),
        Format::Gsd => Reader::Whole(Whole { frames: gsd::frames, read: gsd::read }),
    }
}

impl Sequence {
    /// Calls `found` with where each frame starts.
    fn scan(&self, source: &mut dyn Source, mut found: impl FnMut(Position)) -> Result<(), Fault> {
        let mut text = Text::new(source, Position::START)?;
        while text.skip_blank()? {
            let start = text.position();
            (self.skip)(&mut text)?;
            found(start);
        }
        Ok(())
    }

    fn frame(&self, source: &mut dyn Source, request: &Request) -> Result<Particles, Fault> {
        let (start, number) = match request.frame {
            Frame::Number(number) => (Position::START, number),
            Frame::Last => {
                let (mut last, mut count) = (Position::START, 0);
                self.scan(source, |start| (last, count) = (start, count + 1))?;
                (last, count.max(1) - 1)
            }
        };
        let mut text = Text::new(source, start)?;
        if request.frame != Frame::Last {
            for before in 0..number {
                if !(self.skip)(&mut text)? {
                    return Err(no_such_frame(number, before));
                }
            }
        }
        if !text.skip_blank()? {
            return Err(no_such_frame(number, number));
        }
        let particles = (self.read)(&mut text, request)?;
        Ok(numbered(self.with_unit(particles, source)?, number))
    }

    /// The particles of a frame of `source`, in the unit that its first frame states if they state none.
    fn with_unit(&self, particles: Particles, source: &mut dyn Source) -> Result<Particles, Fault> {
        match self.unit {
            Some(unit) if particles.unit == Unit::Unknown => {
                Ok(Particles { unit: unit(&mut Text::new(source, Position::START)?), ..particles })
            }
            _ => Ok(particles),
        }
    }
}

fn frame_of(source: &mut dyn Source, format: Format, request: &Request) -> Result<Particles, Fault> {
    match reader(format) {
        Reader::Sequence(sequence) => sequence.frame(source, request),
        Reader::Whole(whole) => {
            let number = match request.frame {
                Frame::Number(number) => number,
                Frame::Last => (whole.frames)(source)?.saturating_sub(1),
            };
            Ok(numbered((whole.read)(source, number, request)?, number))
        }
        Reader::Single(read) => match request.frame {
            Frame::Number(0) | Frame::Last => read(source, request),
            Frame::Number(number) => Err(no_such_frame(number, 1)),
        },
    }
}

fn numbered(particles: Particles, frame: usize) -> Particles {
    Particles { frame, ..particles }
}

/// Opens a regular file: no reader waits for the other end of a pipe.
fn open(path: &Path) -> Result<File, Fault> {
    let status = fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Fault::file("there is no such file"),
        _ => Fault::unread(&error),
    })?;
    if !status.is_file() {
        let what = if status.is_dir() { "a directory" } else { "a pipe or a device" };
        return Err(Fault::file(format!("this is {what}; name a file")));
    }
    File::open(path).map_err(|error| Fault::unread(&error))
}
