//! The output files of a render, and the checks that they can be written.

use crate::choice::EngineChoice;
use crate::error::{Error, Field, Problem};
use crate::stream::Stream;
use files::atomic_file;
use files::image_file::{self, Format, ImageError, Tone};
use files::paths::{self, around};
use scene::Scene;
use std::path::{Path, PathBuf};

/// Upper bound of a report's bytes.
const STATS_BYTES: u64 = 1 << 12;

/// The output files of a render. All are optional, as images are also available in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// The image: `.png` or `.jpg` (sRGB), `.exr`, `.pfm`, `.hdr` or `.tif` (linear radiance).
    pub image: Option<PathBuf>,
    /// A stream that gets the image too, once the render has ended.
    pub stream: Option<Stream>,
    /// Exposure of a `.png` or `.jpg` in stops: each stop is a factor of 2 in brightness.
    pub exposure: Option<f32>,
    /// Tone curve of a `.png` or `.jpg`; if none is given, the usual one.
    pub tone: Option<Tone>,
    /// Whether the image is also written after iterations 1, 2, 4, 8, ..., with the iteration in the file name.
    pub snapshots: bool,
    /// An image of the search radius of every pixel, in scene units.
    pub radius_image: Option<PathBuf>,
    /// An image of the accumulated photon count `N` of every pixel.
    pub count_image: Option<PathBuf>,
    /// The [`crate::Report`] as JSON.
    pub stats: Option<PathBuf>,
}

/// The content of an output file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    Image,
    Radius,
    Count,
    Stats,
}

impl Content {
    /// The field with its path.
    pub(crate) fn field(self) -> Field {
        match self {
            Self::Image => Field::Image,
            Self::Radius => Field::RadiusImage,
            Self::Count => Field::CountImage,
            Self::Stats => Field::Stats,
        }
    }

    /// The most bytes that the file takes, if it is of so many pixels.
    fn room(self, path: &Path, pixels: u64, has_alpha: bool) -> u64 {
        match self {
            Self::Stats => STATS_BYTES,
            Self::Image | Self::Radius | Self::Count => {
                room_of(Format::from_path(path).ok(), pixels, has_alpha)
            }
        }
    }
}

impl Outputs {
    /// The requested files with their contents, in the order in which they are written.
    pub(crate) fn files(&self) -> impl Iterator<Item = (Content, &Path)> {
        let all = [
            (Content::Image, &self.image),
            (Content::Radius, &self.radius_image),
            (Content::Count, &self.count_image),
            (Content::Stats, &self.stats),
        ];
        all.into_iter().filter_map(|(content, path)| Some((content, path.as_deref()?)))
    }

    /// The file of the snapshot after `iteration`: `OUT-0001.png` for `OUT.png`. `None` if there is none.
    pub(crate) fn snapshot(&self, iteration: u32) -> Option<PathBuf> {
        let image = self.image.as_deref().filter(|_| self.snapshots && iteration.is_power_of_two())?;
        let stem = image.with_file_name(image.file_stem().unwrap_or_default());
        let extension = image.extension().unwrap_or_default().to_string_lossy();
        Some(around(&stem, "", &format!("-{iteration:04}.{extension}")))
    }

    /// The files of all snapshots of so many `iterations`.
    pub(crate) fn all_snapshots(&self, iterations: u32) -> impl Iterator<Item = PathBuf> {
        let doubled = |i: &u32| i.checked_mul(2);
        let numbers = std::iter::successors(Some(1), doubled).take_while(move |i| *i <= iterations);
        numbers.filter_map(|iteration| self.snapshot(iteration))
    }

    /// Checks that `engine` can produce all outputs, that they are different files and none of `inputs`, that they can
    /// be written, and that exposure and tone apply.
    pub(crate) fn check(&self, engine: EngineChoice, inputs: &[(Field, PathBuf)]) -> Result<(), Error> {
        self.check_engine(engine)?;
        let inputs: Vec<_> = inputs.iter().map(|(field, path)| (*field, path.as_path())).collect();
        let outputs: Vec<_> = self.files().map(|(content, path)| (content.field(), path)).collect();
        check_distinct(&inputs, &outputs)?;
        for (content, path) in self.files() {
            let checked = match content {
                Content::Stats => atomic_file::check(path),
                // Before its extension is looked at: a folder has none.
                _ if path.is_dir() => atomic_file::check(path),
                _ => image_file::check_writable(path),
            };
            checked.map_err(|error| Error::named(content.field(), error))?;
        }
        if let Some(stream) = &self.stream {
            let named =
                |error: ImageError| Error::named(Field::Image, ImageError { path: stream.path(), ..error });
            Format::from_path(&stream.file_name()).map_err(named)?;
        }
        self.check_shown(Field::Exposure, self.exposure.is_some())?;
        self.check_shown(Field::Tone, self.tone.is_some())?;
        match self.tone {
            Some(Tone::Reinhard { white }) if !(white > 0.0 && white.is_finite()) => {
                Err(Error::named(Field::Tone, "the white of reinhard must be a finite number above 0"))
            }
            _ => Ok(()),
        }
    }

    /// Checks that the image's format has alpha, if the background of `scene` is transparent.
    pub(crate) fn check_alpha(&self, scene: &Scene) -> Result<(), Error> {
        let streamed = self.stream.iter().map(|stream| (stream.path(), stream.file_name()));
        let images = self.image.iter().map(|image| (image.clone(), image.clone())).chain(streamed);
        for (path, name) in images.filter(|_| scene.transparent_background) {
            if let Some(format) = Format::from_path(&name).ok().filter(|format| !format.has_alpha()) {
                let (path, format) = (path.display(), format.name());
                let problem = format!(
                    "{path}: {format} files have no alpha, and the scene's background is transparent; name a .png, .exr or \
                     .tif file, or give it a background"
                );
                return Err(Error::named(Field::Image, problem));
            }
        }
        Ok(())
    }

    /// Whether there are images that tell of photons.
    pub(crate) fn show_photons(&self) -> bool {
        self.radius_image.is_some() || self.count_image.is_some()
    }

    fn check_engine(&self, engine: EngineChoice) -> Result<(), Error> {
        let of_photons = |content| matches!(content, Content::Radius | Content::Count);
        match self.files().find(|(content, _)| of_photons(*content)) {
            Some((content, _)) if !engine.method().has_photons() => {
                let field = content.field();
                let problem = Problem::of(field).text(": ").field(engine.method_field());
                let rest = format!(" {} has no photons; leave out one of the two", engine.method().name());
                Err(Error::input(field, problem.text(rest)))
            }
            _ => Ok(()),
        }
    }

    /// The tone curve of the image; `None` if its format holds radiance.
    pub(crate) fn shown_tone(&self) -> Option<Tone> {
        let streamed = self.stream.as_ref().map(Stream::file_name);
        let mut images = self.image.iter().chain(&streamed);
        images.any(|image| is_exposed(image)).then(|| self.tone.unwrap_or_default())
    }

    /// Rejects exposure and tone, if they are given, for formats that hold radiance.
    fn check_shown(&self, field: Field, is_given: bool) -> Result<(), Error> {
        let image = self.image.iter().map(|image| (image.clone(), is_exposed(image)));
        let streamed = self.stream.iter().map(|stream| (stream.path(), is_exposed(&stream.file_name())));
        match image.chain(streamed).find(|(_, is_exposed)| is_given && !is_exposed) {
            Some((path, _)) => {
                let path = path.display();
                let problem =
                    format!("{path} holds linear radiance; only .png and .jpg are exposed and toned");
                Err(Error::named(field, problem))
            }
            None => Ok(()),
        }
    }

    /// Checks that the disk has room for images of `scene`.
    pub(crate) fn check_room(&self, scene: &Scene) -> Result<(), Error> {
        let pixels = scene.settings.pixels() as u64;
        for (content, path) in self.files() {
            let bytes = content.room(path, pixels, scene.transparent_background);
            let checked = atomic_file::check_room(path, bytes);
            checked.map_err(|error| Error::named(content.field(), error))?;
        }
        Ok(())
    }
}

/// The most bytes that an image of so many pixels takes as they are, without what compression saves.
fn room_of(format: Option<Format>, pixels: u64, has_alpha: bool) -> u64 {
    let alpha = u64::from(has_alpha);
    pixels
        * match format {
            Some(Format::Png | Format::Jpeg) => 3 + alpha,
            Some(Format::Hdr) => 4,
            _ => 4 * (3 + alpha),
        }
}

/// Whether exposure and tone apply to the image file: to PNG and JPEG, as the other formats store radiance.
pub fn is_exposed(image: &Path) -> bool {
    Format::from_path(image).is_ok_and(Format::is_exposed)
}

/// Checks that no output is also an input or another output.
pub(crate) fn check_distinct(inputs: &[(Field, &Path)], outputs: &[(Field, &Path)]) -> Result<(), Error> {
    let [all_inputs, all_outputs] =
        [inputs, outputs].map(|named| named.iter().map(|(_, path)| *path).collect::<Vec<_>>());
    let Some((index, other)) = paths::first_clash(&all_inputs, &all_outputs) else { return Ok(()) };
    let (field, path) = outputs[index];
    let (other, _) = inputs.iter().chain(outputs).nth(other).copied().unwrap_or((Field::Scene, path));
    let problem = Problem::of(field).text(format_args!(": {} is also ", path.display()));
    Err(Error::input(field, problem.field(other).text("; name another file")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_for_the_samples_of_every_pixel() {
        for (format, of_colors, with_alpha) in
            [(Format::Png, 3, 4), (Format::Exr, 12, 16), (Format::Tiff, 12, 16)]
        {
            assert_eq!(room_of(Some(format), 1000, false), 1000 * of_colors, "{format:?}");
            assert_eq!(room_of(Some(format), 1000, true), 1000 * with_alpha, "{format:?}");
        }
        assert_eq!(room_of(Some(Format::Jpeg), 1000, false), 3000);
        assert_eq!(room_of(Some(Format::Hdr), 1000, false), 4000);
        assert_eq!(room_of(Some(Format::Pfm), 1000, false), 12_000);
    }

    fn outputs(image: &str) -> Outputs {
        Outputs { image: Some(image.into()), snapshots: true, ..Outputs::default() }
    }

    #[test]
    fn snapshots_are_of_powers_of_two_and_numbered() {
        let outputs = outputs("a/b.c.png");
        assert_eq!(outputs.snapshot(1), Some("a/b.c-0001.png".into()));
        assert_eq!(outputs.snapshot(4096), Some("a/b.c-4096.png".into()));
        assert_eq!(outputs.snapshot(65536), Some("a/b.c-65536.png".into()));
        assert_eq!([outputs.snapshot(3), outputs.snapshot(6)], [None, None]);
        assert_eq!(Outputs { snapshots: false, ..outputs.clone() }.snapshot(1), None);
        assert_eq!(Outputs { image: None, ..outputs.clone() }.snapshot(1), None);
        let all = |iterations| outputs.all_snapshots(iterations).count();
        assert_eq!([all(0), all(1), all(2), all(3), all(4), all(u32::MAX)], [0, 1, 2, 2, 3, 32]);
    }

    #[test]
    fn files_are_written_in_their_order() {
        let [image, radius, count, stats] = ["a.png", "b.exr", "c.exr", "d.json"].map(PathBuf::from);
        let all = Outputs {
            image: Some(image.clone()),
            radius_image: Some(radius.clone()),
            count_image: Some(count.clone()),
            stats: Some(stats.clone()),
            ..Outputs::default()
        };
        let found: Vec<_> = all.files().map(|(content, path)| (content.field(), path.to_owned())).collect();
        let fields = [Field::Image, Field::RadiusImage, Field::CountImage, Field::Stats];
        let expected: Vec<_> = fields.into_iter().zip([image, radius, count, stats]).collect();
        assert_eq!(found, expected);
        assert_eq!(Outputs::default().files().count(), 0);
    }

    #[test]
    fn what_holds_radiance_has_no_curve() {
        let tone = Some(Tone::Clamp);
        for (image, is_shown) in
            [("a.png", true), ("a.jpg", true), ("a.exr", false), ("a.tif", false), ("a", false)]
        {
            assert_eq!(outputs(image).shown_tone(), is_shown.then(Tone::default), "{image}");
            let toned = Outputs { tone, ..outputs(image) };
            assert_eq!(toned.shown_tone(), tone.filter(|_| is_shown), "{image}");
            assert_eq!(toned.check_shown(Field::Tone, true).is_ok(), is_shown, "{image}");
            assert!(toned.check_shown(Field::Tone, false).is_ok(), "{image}");
        }
        let stream = |extension| Some(Stream::new("a socket", extension, Vec::new()));
        let streamed = Outputs { image: None, stream: stream("exr"), ..outputs("a") };
        assert_eq!(streamed.shown_tone(), None);
        assert!(streamed.check_shown(Field::Exposure, true).is_err());
        let streamed = Outputs { stream: stream("png"), ..streamed };
        assert_eq!(streamed.shown_tone(), Some(Tone::default()));
        assert!(streamed.check_shown(Field::Exposure, true).is_ok());
    }

    /// A stream has a format like a file, which is told under the name of the stream before the render starts.
    #[test]
    fn a_stream_of_no_format_is_refused() {
        let of = |extension| {
            let stream = Some(Stream::new("a socket", extension, Vec::new()));
            let outputs = Outputs { stream, ..Outputs::default() };
            outputs.check(EngineChoice::default(), &[]).map_err(|error| error.to_string())
        };
        assert_eq!([of("png"), of("EXR")], [Ok(()), Ok(())]);
        for (extension, has) in [("gif", "has the extension .gif"), ("webp", "would be WebP")] {
            let said = of(extension).unwrap_err();
            assert!(said.starts_with(&format!("image: a socket: {has}")), "{said}");
        }
    }

    /// Whichever of two images holds radiance is named.
    #[test]
    fn exposure_must_apply_to_the_file_and_to_the_stream() {
        let of = |image: &str, extension| {
            let stream = Some(Stream::new("a socket", extension, Vec::new()));
            let both = Outputs { stream, ..outputs(image) };
            both.check_shown(Field::Exposure, true).map_err(|error| error.to_string())
        };
        assert_eq!(of("a.png", "jpg"), Ok(()));
        for (image, extension, named) in [("a.exr", "png", "a.exr"), ("a.png", "exr", "a socket")] {
            let said = of(image, extension).unwrap_err();
            assert!(said.starts_with(&format!("exposure: {named} holds linear radiance")), "{said}");
        }
    }

    #[test]
    fn a_white_is_a_finite_number_above_0() {
        let of = |white| {
            let folder = tempfile::tempdir().unwrap();
            let image = Some(folder.path().join("a.png"));
            let outputs = Outputs { image, tone: Some(Tone::Reinhard { white }), ..Outputs::default() };
            outputs.check(EngineChoice::default(), &[]).map_err(|error| error.to_string())
        };
        assert_eq!(of(1e-6), Ok(()));
        for white in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(of(white), Err("tone: the white of reinhard must be a finite number above 0".into()));
        }
    }

    #[test]
    fn only_formats_with_alpha_take_a_transparent_background() {
        let mut scene = files::builtin::scene("cornell").unwrap();
        for (image, has_alpha) in
            [("a.png", true), ("a.exr", true), ("a.tif", true), ("a.jpg", false), ("a.pfm", false)]
        {
            scene.transparent_background = true;
            assert_eq!(outputs(image).check_alpha(&scene).is_ok(), has_alpha, "{image}");
            scene.transparent_background = false;
            assert!(outputs(image).check_alpha(&scene).is_ok(), "{image}");
        }
        scene.transparent_background = true;
        let stream = Some(Stream::new("a socket", "pfm", Vec::new()));
        let problem = Outputs { stream, ..outputs("a.png") }.check_alpha(&scene).unwrap_err().to_string();
        assert!(problem.starts_with("image: a socket: PFM files have no alpha"), "{problem}");
    }

    #[test]
    fn files_that_clash_are_named_by_their_fields() {
        let (scene, image) = (Path::new("/a/b.toml"), Path::new("/a/b.png"));
        let check = |outputs: &[(Field, &Path)]| {
            check_distinct(&[(Field::Scene, scene)], outputs).map_err(|error| error.to_string())
        };
        assert_eq!(check(&[(Field::Image, image), (Field::Stats, Path::new("/a/c"))]), Ok(()));
        let told = |field, path, other| Err(format!("{field}: {path} is also {other}; name another file"));
        assert_eq!(
            check(&[(Field::Image, image), (Field::Stats, scene)]),
            told("stats", "/a/b.toml", "scene")
        );
        let twice = [(Field::Image, image), (Field::RadiusImage, image)];
        assert_eq!(check(&twice), told("radius_image", "/a/b.png", "image"));
    }

    #[test]
    fn a_folder_is_no_file_whatever_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(&path).unwrap();
            let outputs = Outputs { image: Some(path), ..Outputs::default() };
            outputs.check(EngineChoice::default(), &[]).unwrap_err().to_string()
        };
        for name in ["a.png", "a", "a.txt"] {
            assert!(of(name).ends_with("is a folder; name a file in it"), "{}", of(name));
        }
    }

    #[test]
    fn a_report_takes_as_much_room_whatever_the_pixels() {
        let room = |content: Content, path: &str, pixels| content.room(Path::new(path), pixels, true);
        assert_eq!(
            [room(Content::Stats, "a.json", 1), room(Content::Stats, "a.png", 1 << 20)],
            [STATS_BYTES; 2]
        );
        assert_eq!(room(Content::Image, "a.png", 1000), 4000);
        assert_eq!([room(Content::Radius, "a.exr", 1000), room(Content::Count, "a.tif", 1000)], [16_000; 2]);
    }
}
