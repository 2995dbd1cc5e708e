//! The files that a render writes: checked before it begins, and not lost lightly when it is over.

use crate::args::RenderArgs;
use crate::error::Error;
use crate::report::Report;
use crate::scenes::Opened;
use crate::session::Snapshot;
use crate::text;
use scene::Plane;
use scene::atomic_file::{self, FileError};
use scene::image_file::{self, Encoding, Format};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// What there is to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Image,
    Radius,
    Count,
    Stats,
}

impl Content {
    /// The option that asks for it.
    fn option(self) -> &'static str {
        match self {
            Self::Image => "--output",
            Self::Radius => "--radius-image",
            Self::Count => "--count-image",
            Self::Stats => "--stats",
        }
    }
}

/// All the files of a render.
pub(crate) struct Outputs {
    files: Vec<(Content, PathBuf)>,
    encoding: Encoding,
}

impl Outputs {
    /// What `args` asks for, if it can be had: files of different names, in folders that may be written to, and
    /// none of them the scene's own.
    pub(crate) fn new(args: &RenderArgs, opened: &Opened) -> Result<Self, Error> {
        let image = args.output.clone().unwrap_or_else(|| default_name(&opened.stem));
        let wanted = [
            (Content::Image, Some(image)),
            (Content::Radius, args.radius_image.clone()),
            (Content::Count, args.count_image.clone()),
            (Content::Stats, args.stats.clone()),
        ];
        let files = wanted.into_iter().filter_map(|(content, path)| Some((content, path?))).collect();
        let outputs = Self { files, encoding: Encoding { exposure: args.exposure.unwrap_or(0.0) } };
        outputs.check_engine(args)?;
        outputs.check_names(opened.file.as_deref())?;
        outputs.check_files()?;
        outputs.check_exposure(args)?;
        Ok(outputs)
    }

    fn check_engine(&self, args: &RenderArgs) -> Result<(), Error> {
        let of_photons = |content| matches!(content, Content::Radius | Content::Count);
        match self.files.iter().find(|(content, _)| of_photons(*content)) {
            Some((content, _)) if !args.engine.has_photons() => {
                let (option, engine) = (content.option(), args.engine.name());
                Err(Error::BadInput(format!(
                    "{option}: --engine {engine} has no photons; leave out one of the two"
                )))
            }
            _ => Ok(()),
        }
    }

    fn check_names(&self, scene_file: Option<&Path>) -> Result<(), Error> {
        let scene_file = scene_file.map(|path| ("the scene", path));
        let outputs: Vec<_> =
            self.files.iter().map(|(content, path)| (content.option(), path.as_path())).collect();
        check_distinct(scene_file.as_slice(), &outputs)
    }

    fn check_files(&self) -> Result<(), Error> {
        for (content, path) in &self.files {
            let checked = match content {
                Content::Stats => atomic_file::check(path),
                _ => image_file::check_writable(path),
            };
            checked.map_err(|error| Error::BadInput(format!("{}: {error}", content.option())))?;
        }
        Ok(())
    }

    fn check_exposure(&self, args: &RenderArgs) -> Result<(), Error> {
        let (_, image) = &self.files[0];
        match Format::from_path(image) {
            Ok(Format::Png) => Ok(()),
            _ if args.exposure.is_none() => Ok(()),
            _ => Err(Error::BadInput(format!(
                "--exposure: {} holds linear radiance; only .png is exposed",
                image.display()
            ))),
        }
    }

    /// Writes everything, and tells what was written. What cannot be written where it should be is written where
    /// it can be, and the error says where.
    pub(crate) fn write(&self, snapshot: &Snapshot, report: &Report) -> Result<String, Error> {
        let mut written = Vec::new();
        let mut problems = Vec::new();
        for (content, path) in &self.files {
            let write = |path: &Path| self.write_one(*content, path, snapshot, report);
            match write(path) {
                Ok(()) => written.push(path.display()),
                Err(error) => problems.push(match rescue(path, write) {
                    Some(refuge) => format!("{error}; it is in {} instead", refuge.display()),
                    None => format!("{error}; it is lost"),
                }),
            }
        }
        match (problems.is_empty(), written.is_empty()) {
            (true, _) => Ok(text::list(&written)),
            (false, true) => Err(Error::Failed(problems.join("; "))),
            (false, false) => {
                Err(Error::Failed(format!("{}; wrote {}", problems.join("; "), text::list(&written))))
            }
        }
    }

    fn write_one(
        &self,
        content: Content,
        path: &Path,
        snapshot: &Snapshot,
        report: &Report,
    ) -> Result<(), FileError> {
        let plane = |plane: &Option<Plane>, name| match plane {
            Some(plane) => image_file::write_plane(path, plane, name),
            None => Ok(()), // never so: the engine was asked before whether it has photons
        };
        match content {
            Content::Image => image_file::write(path, &snapshot.film, &self.encoding),
            Content::Radius => plane(&snapshot.radius, "radius"),
            Content::Count => plane(&snapshot.count, "count"),
            Content::Stats => atomic_file::replace(path, |out| report.write(out)),
        }
    }
}

fn default_name(stem: &OsStr) -> PathBuf {
    let mut name = stem.to_owned();
    name.push(".png");
    name.into()
}

/// A file and what it is to the command.
type Named<'a> = (&'a str, &'a Path);

/// Checks that no output is also an input or another output.
pub(crate) fn check_distinct(inputs: &[Named], outputs: &[Named]) -> Result<(), Error> {
    let mut taken: Vec<(&str, PathBuf)> = inputs.iter().map(|(what, path)| (*what, identity(path))).collect();
    for (what, path) in outputs {
        let file = identity(path);
        if let Some((other, _)) = taken.iter().find(|(_, other)| *other == file) {
            return Err(Error::BadInput(format!(
                "{what}: {} is also {other}; name another file",
                path.display()
            )));
        }
        taken.push((what, file));
    }
    Ok(())
}

/// `path` without links and detours, so that two names of one file are seen to be so.
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

/// Writes what should have become `path` beside it or, failing that, into the folder for temporary files; tells
/// where. Overwrites nothing.
fn rescue(path: &Path, write: impl Fn(&Path) -> Result<(), FileError>) -> Option<PathBuf> {
    let mut name = path.file_stem().unwrap_or(OsStr::new("image")).to_owned();
    name.push(format!("-rescued-{}.", std::process::id()));
    name.push(path.extension().unwrap_or(OsStr::new("json")));
    [path.with_file_name(&name), std::env::temp_dir().join(&name)]
        .into_iter()
        .find(|refuge| !refuge.exists() && write(refuge).is_ok())
}
