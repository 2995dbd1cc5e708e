//! Writes the output files of a render. Pixels are developed while they are written, without an image in memory.

use crate::backdrop::Backdrop;
use crate::metadata::Metadata;
use crate::outcome::Unwritten;
use crate::outputs::{Content, Outputs};
use crate::report::Report;
use files::atomic_file::{self, FileError, rescue};
use files::image_file::{self, Encoding};
use scene::film::{Pixels, Tile};
use scene::{Picture, Probe, Resumable, Rgb, Settings};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Writes the output files of a render and measures the time that takes.
#[derive(Debug)]
pub(crate) struct Writer {
    outputs: Outputs,
    writing: Cell<Duration>,
}

/// The state of a render, and what is told of it in its images.
pub(crate) struct Shown<'a> {
    pub(crate) engine: &'a dyn Resumable,
    /// If the background is transparent.
    pub(crate) backdrop: Option<&'a Backdrop<'a>>,
    pub(crate) metadata: Metadata,
}

impl Shown<'_> {
    fn picture<'b, T>(&self, pixel: &'b dyn Pixels<T>) -> Picture<'b, T> {
        let Settings { width, height, .. } = *self.engine.settings();
        Picture { width, height, pixel }
    }
}

/// The radiance of an engine's pixels.
struct Radiance<'a>(&'a dyn Resumable);

impl Pixels<Rgb> for Radiance<'_> {
    fn at(&self, x: u32, y: u32) -> Rgb {
        self.0.radiance(x, y)
    }

    fn tile(&self, left: u32, top: u32) -> Tile<Rgb> {
        self.0.radiance_of_tile(left, top)
    }
}

impl Writer {
    pub(crate) fn new(outputs: Outputs) -> Self {
        Self { outputs, writing: Cell::default() }
    }

    pub(crate) fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Time spent developing and writing so far.
    pub(crate) fn writing(&self) -> Duration {
        self.writing.get()
    }

    /// Writes the images of a render in progress. Returns the errors.
    pub(crate) fn refresh(&self, shown: &Shown) -> Vec<FileError> {
        let images = self.outputs.files().filter(|(content, _)| *content != Content::Stats);
        images.filter_map(|(content, path)| self.write_one(content, path, shown, None).err()).collect()
    }

    /// Writes the snapshot after `iteration`, if snapshots are requested and it is a power of two.
    pub(crate) fn snapshot<'a>(
        &self,
        iteration: u32,
        show: impl FnOnce() -> Shown<'a>,
    ) -> Result<(), FileError> {
        match self.outputs.snapshot(iteration) {
            Some(path) => self.write_one(Content::Image, &path, &show(), None),
            None => Ok(()),
        }
    }

    /// Writes all outputs. A file that cannot be written is saved elsewhere if possible. Returns the files that were
    /// written and those that were not.
    pub(crate) fn write(&self, shown: &Shown, report: &Report) -> (Vec<PathBuf>, Vec<Unwritten>) {
        let (mut written, mut failed) = (Vec::new(), Vec::new());
        for (content, path) in self.outputs.files() {
            let write = |path: &Path| self.write_one(content, path, shown, Some(report));
            match write(path) {
                Ok(()) => written.push(path.to_owned()),
                Err(error) => failed.push(Unwritten { error, refuge: rescue(path, write) }),
            }
        }
        if let Some(stream) = &self.outputs.stream {
            let write = |path: &Path| self.write_one(Content::Image, path, shown, None);
            match stream.send(write) {
                Ok(()) => written.push(stream.path()),
                Err(error) => failed.push(Unwritten { error, refuge: rescue(&stream.file_name(), write) }),
            }
        }
        (written, failed)
    }

    /// Writes the image alone, to `path`.
    pub(crate) fn image(&self, path: &Path, shown: &Shown) -> Result<(), FileError> {
        self.write_one(Content::Image, path, shown, None)
    }

    fn write_one(
        &self,
        content: Content,
        path: &Path,
        shown: &Shown,
        report: Option<&Report>,
    ) -> Result<(), FileError> {
        let began = Instant::now();
        let note = match content {
            Content::Image | Content::Stats => shown.metadata.to_note(),
            // Their greatest value is white, whatever exposure and curve the image has.
            Content::Radius | Content::Count => {
                Metadata { exposure: None, tone: None, ..shown.metadata.clone() }.to_note()
            }
        };
        let encoding = Encoding {
            exposure: self.outputs.exposure.unwrap_or(0.0),
            tone: self.outputs.tone.unwrap_or_default(),
            seed: shown.engine.settings().seed,
            note: Some(&note),
        };
        let values = |name, value: fn(Probe) -> f32| {
            let pixel = |x, y| value(shown.engine.probe(x, y));
            image_file::write_values(path, &shown.picture(&pixel), name, &encoding)
        };
        let written = match content {
            Content::Image => {
                let pixel = Radiance(shown.engine);
                match shown.backdrop {
                    None => image_file::write_picture(path, &shown.picture(&pixel), &encoding),
                    Some(backdrop) => {
                        let pixel = |x: u32, y: u32| backdrop.pixel(pixel.at(x, y), x, y);
                        image_file::write_transparent(path, &shown.picture(&pixel), &encoding)
                    }
                }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::EngineChoice;
    use files::image_file::Tone;

    fn metadata(engine: &dyn Resumable, scene: &scene::Scene) -> Metadata {
        Metadata::of(engine, scene, &files::scene_file::digest(scene), EngineChoice::default())
    }

    /// An image of radii or counts is neither exposed nor toned, and does not say that it is.
    #[test]
    fn only_the_image_tells_exposure_and_tone() {
        let folder = tempfile::tempdir().unwrap();
        let scene = files::builtin::scene("cornell").unwrap();
        let engine = fast::Sppm::new(&scene, &Settings { width: 3, height: 2, ..scene.settings });
        let (exposure, tone) = (Some(1.5), Some(Tone::Aces));
        let metadata = Metadata { exposure, tone, ..metadata(&engine, &scene) };
        let shown = Shown { engine: &engine, backdrop: None, metadata: metadata.clone() };
        let [image, radius, count] = ["a.png", "r.png", "n.exr"].map(|name| folder.path().join(name));
        let outputs = Outputs {
            image: Some(image.clone()),
            radius_image: Some(radius.clone()),
            count_image: Some(count.clone()),
            ..Outputs::default()
        };
        assert!(Writer::new(outputs).refresh(&shown).is_empty());
        let told = |path: &Path| Metadata::from_note(&image_file::read_note(path).unwrap().unwrap()).unwrap();
        assert_eq!(told(&image), metadata);
        let plain = Metadata { exposure: None, tone: None, ..metadata };
        assert_eq!([told(&radius), told(&count)], [plain.clone(), plain]);
    }

    /// The time told is of all files together.
    #[test]
    fn each_file_adds_to_the_time_of_writing() {
        let folder = tempfile::tempdir().unwrap();
        let scene = files::builtin::scene("cornell").unwrap();
        let settings = Settings { width: 9, height: 8, ..scene.settings };
        let engine = fast::Sppm::new(&scene, &settings);
        let shown = Shown { engine: &engine, backdrop: None, metadata: metadata(&engine, &scene) };
        let writer = Writer::new(Outputs { image: Some(folder.path().join("a.pfm")), ..Outputs::default() });
        let mut before = Duration::ZERO;
        for _ in 0..12 {
            assert!(writer.refresh(&shown).is_empty());
            assert!(writer.writing() > before);
            before = writer.writing();
        }
    }
}
