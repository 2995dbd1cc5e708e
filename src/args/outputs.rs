//! Options for the files that a render writes.

use super::frames::numbered;
use super::values::number;
use crate::terminal::error::Error;
use clap::Args as ClapArgs;
use files::image_file::{Tone, USUAL_WHITE};
use render::{Outputs, Stream};
use std::ffi::OsStr;
use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};

/// The files that a render writes.
#[derive(Clone, Debug, Default, ClapArgs)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// The image to write: .png or .jpg (sRGB), .exr, .pfm, .tif or .hdr (linear) [default: the scene's name, .png]
    ///
    /// `-` is standard output, in PNG; `exr:-` or `pfm:-` is standard output in another format. It gets the image once the
    /// render is over. All messages go to standard error, and there is no checkpoint unless --checkpoint names one.
    ///
    /// Only .png and .exr hold what `sppm info` and --like read. A .hdr holds 8 bits per channel with a common exponent.
    /// Of a range of frames each gets a file of its own: `{frame}` stands for its number, as in frame-{frame}.png.
    ///
    /// Files are written beside their place and then renamed into it, so that nobody ever sees half an image.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Make a .png or .jpg brighter or darker by so many stops, each a factor of 2
    #[arg(long, value_name = "E", value_parser = number(-100.0, 100.0), allow_hyphen_values = true)]
    pub exposure: Option<f32>,

    /// How a .png or .jpg shows bright light: `agx` and `aces` as film does, `reinhard` with its colours, `clamp` not at all
    ///
    /// `clamp` cuts off what is brighter than 1, and is exact below: for measurements, though .exr and .pfm are better. Codes
    /// of the others are dithered, by the seed. `sppm render --like` repeats the curve. docs/images.md has the formulas.
    #[arg(long, value_name = "CURVE", value_parser = Tone::NAMES)]
    pub tone: Option<String>,

    /// With --tone reinhard: the least luminance that is white, after the exposure [default: 4]
    #[arg(long, value_name = "W", value_parser = number(1e-6, 1e6), allow_hyphen_values = true)]
    pub white: Option<f32>,

    /// Also write the image after 1, 2, 4, 8, ... iterations, as OUT-0001.png and so on
    #[arg(long)]
    pub snapshots: bool,

    /// Write the last search radius of every pixel, in scene units (in a .png or .jpg the largest is white)
    #[arg(long, value_name = "FILE")]
    pub radius_image: Option<PathBuf>,

    /// Write N of every pixel: the photons it has counted, weighted by 2/3
    ///
    /// 2/3 is the method's alpha, the share of new photons that is kept while the radius shrinks.
    #[arg(long, value_name = "FILE")]
    pub count_image: Option<PathBuf>,

    /// Write settings, seconds per pass and counted work as one JSON object
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
}

impl OutputArgs {
    /// Output paths from the command line, else from `usual`. An image that neither names is written to `image`.
    pub(crate) fn or(&self, usual: Outputs, image: PathBuf) -> Result<Outputs, Error> {
        self.check_others()?;
        let extension = self.output.as_deref().and_then(streamed);
        let stream = extension.map(|extension| self.stream(extension)).transpose()?;
        let image = self.output.clone().or(usual.image).unwrap_or(image);
        // An exposure given for a format without one is refused later; one from `usual` is dropped.
        let shown = extension.map_or(image.clone(), |extension| format!("image.{extension}").into());
        let is_exposed = render::is_exposed(&shown);
        let usual_exposure = usual.exposure.filter(|_| is_exposed);
        let usual_tone = usual.tone.filter(|_| is_exposed);
        Ok(Outputs {
            exposure: self.exposure.or(usual_exposure).filter(|&stops| stops != 0.0),
            tone: self.tone(usual_tone)?,
            image: stream.is_none().then_some(image),
            stream,
            snapshots: self.snapshots || usual.snapshots,
            radius_image: self.radius_image.clone().or(usual.radius_image),
            count_image: self.count_image.clone().or(usual.count_image),
            stats: self.stats.clone().or(usual.stats),
        })
    }

    /// Whether the image goes to standard output.
    pub(crate) fn is_streamed(&self) -> bool {
        self.output.as_deref().and_then(streamed).is_some()
    }

    /// The files that one frame of a trajectory gets.
    pub(crate) fn of_frame(&self, number: usize) -> Self {
        let of_frame = |path: &Option<PathBuf>| path.as_deref().map(|path| numbered(path, number));
        Self {
            output: of_frame(&self.output),
            radius_image: of_frame(&self.radius_image),
            count_image: of_frame(&self.count_image),
            stats: of_frame(&self.stats),
            ..self.clone()
        }
    }

    /// The tone curve, if one is asked for here or else by `usual`.
    fn tone(&self, usual: Option<Tone>) -> Result<Option<Tone>, Error> {
        let usual_white = if let Some(Tone::Reinhard { white }) = usual { white } else { USUAL_WHITE };
        let white = self.white.unwrap_or(usual_white);
        let name = self.tone.as_deref().or(usual.map(Tone::name));
        let tone = name.and_then(|name| Tone::named(name, white));
        match (self.white, tone) {
            (None, _) | (_, Some(Tone::Reinhard { .. })) => Ok(tone),
            _ => {
                let problem = "--white: only the curve reinhard has a white; ask for it by --tone reinhard, or make the \
                    image brighter or darker by --exposure";
                Err(Error::BadInput(problem.into()))
            }
        }
    }

    /// Standard output, for an image in the format of this `extension`.
    fn stream(&self, extension: &str) -> Result<Stream, Error> {
        let out = io::stdout();
        if out.is_terminal() {
            let problem =
                "--output: standard output is a terminal, which shows no image; redirect it, as by `> image.";
            return Err(Error::BadInput(format!("{problem}{extension}`")));
        }
        if self.snapshots {
            let problem = "--snapshots: their names are made from that of --output; name a file there";
            return Err(Error::BadInput(problem.into()));
        }
        Ok(Stream::new("standard output", extension, out))
    }

    /// Refuses standard output for what is no image.
    fn check_others(&self) -> Result<(), Error> {
        let others = [
            ("--radius-image", &self.radius_image),
            ("--count-image", &self.count_image),
            ("--stats", &self.stats),
        ];
        match others.into_iter().find(|(_, path)| path.as_deref().and_then(streamed).is_some()) {
            Some((option, _)) => {
                let problem = "standard output takes the image alone, by --output; name a file";
                Err(Error::BadInput(format!("{option}: {problem}")))
            }
            None => Ok(()),
        }
    }
}

/// The extension of the format, if `output` is standard output: `-` is in PNG, `exr:-` in another format.
fn streamed(output: &Path) -> Option<&str> {
    match output.to_str()? {
        "-" => Some("png"),
        output => output.strip_suffix(":-"),
    }
}

/// The default image file for a scene file with the stem `stem`.
pub(crate) fn default_name(stem: &OsStr) -> PathBuf {
    let mut name = stem.to_owned();
    name.push(".png");
    name.into()
}

/// The default image file for a scene known only by its name, which may hold slashes.
pub(crate) fn default_name_of(scene: &str) -> PathBuf {
    default_name(OsStr::new(&scene.replace(['/', '\\'], "-")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::of_render;

    fn of(words: &[&str]) -> OutputArgs {
        of_render(&[&["cornell"], words].concat()).outputs
    }

    fn or(words: &[&str], usual: Outputs) -> Result<Outputs, String> {
        of(words).or(usual, "usual.png".into()).map_err(|error| error.to_string())
    }

    const ALL: [&str; 15] = [
        "-o",
        "a.png",
        "--exposure",
        "1.5",
        "--tone",
        "reinhard",
        "--white",
        "9",
        "--snapshots",
        "--radius-image",
        "b.exr",
        "--count-image",
        "c.exr",
        "--stats",
        "d.json",
    ];

    fn all() -> Outputs {
        Outputs {
            image: Some("a.png".into()),
            exposure: Some(1.5),
            tone: Some(Tone::Reinhard { white: 9.0 }),
            snapshots: true,
            radius_image: Some("b.exr".into()),
            count_image: Some("c.exr".into()),
            stats: Some("d.json".into()),
            stream: None,
        }
    }

    #[test]
    fn what_is_given_stands_before_what_is_usual() {
        let own = Outputs { image: Some("usual.png".into()), ..Outputs::default() };
        assert_eq!(or(&[], Outputs::default()), Ok(own));
        assert_eq!(or(&ALL, Outputs::default()), Ok(all()));
        assert_eq!(or(&[], all()), Ok(all()));
        let other = [
            "-o",
            "x.png",
            "--exposure",
            "2",
            "--tone",
            "clamp",
            "--radius-image",
            "y.exr",
            "--count-image",
            "z.exr",
            "--stats",
            "w",
        ];
        let expected = Outputs {
            image: Some("x.png".into()),
            exposure: Some(2.0),
            tone: Some(Tone::Clamp),
            radius_image: Some("y.exr".into()),
            count_image: Some("z.exr".into()),
            stats: Some("w".into()),
            ..all()
        };
        assert_eq!(or(&other, all()), Ok(expected));
    }

    /// They do not matter to an image that holds radiance, unless they are asked for, which is refused later.
    #[test]
    fn usual_exposures_and_tones_are_of_what_is_shown() {
        let radiance = or(&["-o", "a.exr"], all()).unwrap();
        assert_eq!((radiance.exposure, radiance.tone), (None, None));
        assert_eq!(or(&["-o", "a.exr", "--exposure", "2"], all()).unwrap().exposure, Some(2.0));
        let shown = Outputs { snapshots: false, ..all() };
        for (output, is_shown) in [
            ("-", true),
            ("png:-", true),
            ("jpg:-", true),
            ("jpeg:-", true),
            ("exr:-", false),
            ("hdr:-", false),
        ] {
            let streamed = or(&["-o", output], shown.clone()).unwrap();
            assert_eq!([streamed.exposure.is_some(), streamed.tone.is_some()], [is_shown; 2], "{output}");
        }
        assert_eq!(or(&["--exposure", "0"], all()).unwrap().exposure, None);
        // The usual white stays with the usual curve.
        let tone =
            |words: &[&str], usual| or(words, Outputs { tone: usual, ..all() }).map(|outputs| outputs.tone);
        let reinhard = |white| Ok(Some(Tone::Reinhard { white }));
        let usual = Some(Tone::Reinhard { white: 9.0 });
        assert_eq!(tone(&["--tone", "reinhard"], usual), reinhard(9.0));
        assert_eq!(tone(&["--white", "3"], usual), reinhard(3.0));
        assert_eq!(tone(&["--tone", "reinhard"], None), reinhard(USUAL_WHITE));
        assert_eq!(tone(&["--tone", "reinhard", "--white", "2"], Some(Tone::Clamp)), reinhard(2.0));
        for (words, usual) in [
            (&["--white", "3"][..], None),
            (&["--white", "3", "--tone", "clamp"], None),
            (&["--white", "3"], Some(Tone::Clamp)),
        ] {
            let problem = tone(words, usual).unwrap_err();
            assert!(problem.starts_with("--white: only the curve reinhard has a white"), "{problem}");
        }
    }

    /// In tests standard output is no terminal.
    #[test]
    fn a_stream_is_in_its_format_and_of_the_image_alone() {
        for (output, format) in [
            ("-", Some("png")),
            ("exr:-", Some("exr")),
            ("pfm:-", Some("pfm")),
            ("a-", None),
            ("a.png", None),
        ] {
            assert_eq!(streamed(Path::new(output)), format, "{output}");
            assert_eq!(of(&["-o", output]).is_streamed(), format.is_some(), "{output}");
        }
        for (option, words) in [
            ("--radius-image", ["--radius-image", "-"]),
            ("--count-image", ["--count-image", "exr:-"]),
            ("--stats", ["--stats", "-"]),
        ] {
            let problem = or(&words, Outputs::default()).unwrap_err();
            assert!(
                problem.starts_with(&format!("{option}: standard output takes the image alone")),
                "{problem}"
            );
        }
    }

    #[test]
    fn every_frame_has_outputs_of_its_own() {
        let frame = of(&ALL).of_frame(7);
        let paths = [&frame.output, &frame.radius_image, &frame.count_image, &frame.stats];
        let expected =
            ["a-0007.png", "b-0007.exr", "c-0007.exr", "d-0007.json"].map(|path| Some(PathBuf::from(path)));
        assert_eq!(paths.map(Clone::clone), expected);
        assert_eq!((frame.exposure, frame.white, frame.snapshots), (Some(1.5), Some(9.0), true));
        assert_eq!(of(&[]).of_frame(7).output, None);
    }

    #[test]
    fn images_are_named_by_their_scene() {
        assert_eq!(default_name("a.b".as_ref()), Path::new("a.b.png"));
        assert_eq!(default_name_of("a/b\\c d"), Path::new("a-b-c d.png"));
    }
}
