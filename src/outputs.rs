//! The files that a render writes: checked before it begins, and not lost lightly when it is over.

use crate::args::OutputArgs;
use crate::checkpoints::{self, Note};
use crate::engines::EngineName;
use crate::error::Error;
use crate::metadata::Metadata;
use crate::report::Report;
use crate::text;
use files::atomic_file::{self, FileError};
use files::image_file::{self, Encoding, Format};
use scene::{Picture, Probe, Resumable, Settings};
use std::cell::Cell;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
    exposure: Option<f32>,
    snapshots: bool,
    /// Time spent writing.
    writing: Cell<Duration>,
}

impl Outputs {
    /// What `args` ask for, and else `usual`, if it can be had: files of different names, none of them one of
    /// `inputs`, in folders that may be written to.
    pub(crate) fn new(
        args: &OutputArgs,
        usual: Note,
        image: PathBuf,
        engine: EngineName,
        inputs: &[Named],
    ) -> Result<Self, Error> {
        let wanted = [
            (Content::Image, args.output.clone().or(usual.image).or(Some(image))),
            (Content::Radius, args.radius_image.clone().or(usual.radius_image)),
            (Content::Count, args.count_image.clone().or(usual.count_image)),
            (Content::Stats, args.stats.clone().or(usual.stats)),
        ];
        let files = wanted.into_iter().filter_map(|(content, path)| Some((content, path?))).collect();
        let snapshots = args.snapshots || usual.snapshots;
        let exposure = args.exposure.or(usual.exposure).filter(|&stops| stops != 0.0);
        let mut outputs = Self { files, exposure, snapshots, writing: Cell::default() };
        outputs.check_engine(engine)?;
        check_distinct(inputs, &outputs.named())?;
        outputs.check_files()?;
        outputs.check_exposure(args)?;
        Ok(outputs)
    }

    /// The image.
    pub(crate) fn image(&self) -> &Path {
        &self.files[0].1
    }

    /// In stops, if the image is exposed.
    pub(crate) fn exposure(&self) -> Option<f32> {
        self.exposure
    }

    /// Time spent developing and writing so far.
    pub(crate) fn writing(&self) -> Duration {
        self.writing.get()
    }

    /// Adds where things go to what a checkpoint at `store` notes.
    pub(crate) fn note(&self, store: &Path, note: &mut Note) {
        for (content, path) in &self.files {
            let place = match content {
                Content::Image => &mut note.image,
                Content::Radius => &mut note.radius_image,
                Content::Count => &mut note.count_image,
                Content::Stats => &mut note.stats,
            };
            *place = checkpoints::noted(path, store);
        }
        (note.exposure, note.snapshots) = (self.exposure, self.snapshots);
    }

    /// Every file by the option that asks for it.
    pub(crate) fn named(&self) -> Vec<Named<'_>> {
        self.files.iter().map(|(content, path)| (content.option(), path.as_path())).collect()
    }

    fn check_engine(&self, engine: EngineName) -> Result<(), Error> {
        let of_photons = |content| matches!(content, Content::Radius | Content::Count);
        match self.files.iter().find(|(content, _)| of_photons(*content)) {
            Some((content, _)) if !engine.has_photons() => {
                let (option, engine) = (content.option(), engine.name());
                Err(Error::BadInput(format!(
                    "{option}: --engine {engine} has no photons; leave out one of the two"
                )))
            }
            _ => Ok(()),
        }
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

    /// Only PNG is exposed: what was asked for otherwise is refused, what was usual is forgotten.
    fn check_exposure(&mut self, args: &OutputArgs) -> Result<(), Error> {
        if Format::from_path(self.image()) == Ok(Format::Png) {
            return Ok(());
        }
        if args.exposure.is_some() {
            let image = self.image().display();
            return Err(Error::BadInput(format!(
                "--exposure: {image} holds linear radiance; only .png is exposed"
            )));
        }
        self.exposure = None;
        Ok(())
    }

    /// Refuses a disk without room for images of so many pixels.
    pub(crate) fn check_room(&self, pixels: u64) -> Result<(), Error> {
        for (content, path) in &self.files {
            let bytes = match (content, Format::from_path(path)) {
                (Content::Stats, _) => 1 << 12,
                (_, Ok(Format::Png)) => 3 * pixels,
                _ => 12 * pixels,
            };
            let checked = atomic_file::check_room(path, bytes);
            checked.map_err(|error| Error::BadInput(format!("{}: {error}", content.option())))?;
        }
        Ok(())
    }

    /// Writes all that is there before the end: the images. Gives what could not be written.
    pub(crate) fn refresh(&self, shown: &Shown) -> Vec<FileError> {
        let images = self.files.iter().filter(|(content, _)| *content != Content::Stats);
        images.filter_map(|(content, path)| self.write_one(*content, path, shown, None).err()).collect()
    }

    /// Writes the image after an iteration that is to be kept, if this is one.
    pub(crate) fn snapshot<'a>(
        &self,
        iteration: u32,
        show: impl FnOnce() -> Result<Shown<'a>, Error>,
    ) -> Result<(), Error> {
        if !(self.snapshots && iteration.is_power_of_two()) {
            return Ok(());
        }
        let path = numbered(self.image(), iteration);
        let written = self.write_one(Content::Image, &path, &show()?, None);
        written.map_err(|error| Error::Failed(error.to_string()))
    }

    /// Writes everything, and tells what was written. What cannot be written where it should be is written where
    /// it can be, and the error says where.
    pub(crate) fn write(&self, shown: &Shown, report: &Report) -> Result<String, Error> {
        let mut written = Vec::new();
        let mut problems = Vec::new();
        for (content, path) in &self.files {
            let write = |path: &Path| self.write_one(*content, path, shown, Some(report));
            match write(path) {
                Ok(()) => written.push(path.display()),
                Err(error) => problems.push(match rescue(path, write) {
                    Some(refuge) => format!("{error}; it is in {} instead", refuge.display()),
                    None => error.to_string(),
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
        shown: &Shown,
        report: Option<&Report>,
    ) -> Result<(), FileError> {
        let began = Instant::now();
        let encoding = Encoding { exposure: self.exposure.unwrap_or(0.0), note: Some(&shown.note) };
        let values = |name, value: fn(Probe) -> f32| {
            let pixel = |x, y| value(shown.engine.probe(x, y));
            image_file::write_values(path, &shown.picture(&pixel), name, &encoding)
        };
        let written = match content {
            Content::Image => {
                let pixel = |x, y| shown.engine.probe(x, y).radiance;
                image_file::write_picture(path, &shown.picture(&pixel), &encoding)
            }
            Content::Radius => values("radius", |probe| probe.radius),
            Content::Count => values("count", |probe| probe.count),
            Content::Stats => report.map_or(Ok(()), |report| {
                let report = Report { write_seconds: self.writing().as_secs_f64(), ..report.clone() };
                atomic_file::replace(path, |out| report.write(out))
            }),
        };
        self.writing.set(self.writing() + began.elapsed());
        written
    }
}

/// A render as it stands. Its pixels are developed as they are written.
pub(crate) struct Shown<'a> {
    engine: &'a dyn Resumable,
    /// What is written into the images beside the pixels.
    note: String,
}

impl<'a> Shown<'a> {
    /// The render of `engine`, whose images say `metadata`.
    pub(crate) fn of(engine: &'a dyn Resumable, metadata: &Metadata) -> Result<Self, Error> {
        Ok(Self { engine, note: metadata.to_note()? })
    }

    fn picture<'b, T>(&self, pixel: &'b (dyn Fn(u32, u32) -> T + Sync)) -> Picture<'b, T> {
        let Settings { width, height, .. } = *self.engine.settings();
        Picture { width, height, pixel }
    }
}

/// `OUT-0001.png` for `OUT.png`.
fn numbered(image: &Path, iteration: u32) -> PathBuf {
    let mut name = image.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{iteration:04}."));
    name.push(image.extension().unwrap_or_default());
    image.with_file_name(name)
}

/// The image of a scene whose name is `stem`.
pub(crate) fn default_name(stem: &OsStr) -> PathBuf {
    let mut name = stem.to_owned();
    name.push(".png");
    name.into()
}

/// A file and what it is to the command.
pub(crate) type Named<'a> = (&'a str, &'a Path);

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
pub(crate) fn rescue(path: &Path, write: impl Fn(&Path) -> Result<(), FileError>) -> Option<PathBuf> {
    let mut name = path.file_stem().unwrap_or(OsStr::new("image")).to_owned();
    name.push(format!("-rescued-{}.", std::process::id()));
    name.push(path.extension().unwrap_or(OsStr::new("json")));
    [path.with_file_name(&name), std::env::temp_dir().join(&name)]
        .into_iter()
        .find(|refuge| !refuge.exists() && write(refuge).is_ok())
}
