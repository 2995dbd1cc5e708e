//! The command `info`: prints how an image was made, or what a checkpoint holds.

use crate::terminal::busy::Busy;
use crate::terminal::error::Error;
use crate::terminal::radii::own_radii;
use crate::terminal::text::{complain, print};
use clap::{Args as ClapArgs, ValueHint};
use files::atomic_file::FileError;
use files::checkpoint::Loaded;
use files::image_file::{self, ImageReader, Tone};
use files::scene_file;
use render::{LanesName, Made, Metadata, Note, Renderer};
use scene::settings::MAX_ITERATIONS;
use scene::text::one_line;
use scene::{Filter, Iterations, RadiusSchedule, RowReader, Settings, TRANSPORT};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Tell what made an image, or what a checkpoint holds
///
/// Prints version, scene, settings, engine and iterations as they are written into .png and .exr images and into
/// checkpoints. Of other images it tells the format, the size and the layers.
#[derive(Debug, ClapArgs)]
#[command(
    after_long_help = "Examples:\n  sppm info cornell.png\n  sppm info cornell.png --scene > again.toml"
)]
pub(crate) struct InfoArgs {
    /// An image, or a checkpoint
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,

    /// Print one JSON object
    #[arg(long, conflicts_with = "scene")]
    json: bool,

    /// Print the scene file, with the settings of the render
    #[arg(long)]
    scene: bool,
}

/// What the command prints.
#[derive(Serialize)]
struct Info {
    /// `image` or `checkpoint`.
    kind: &'static str,
    version: String,
    scene: String,
    scene_digest: String,
    settings: Settings,
    /// Version of the light transport.
    transport: u32,
    /// The iterations in it, unless they are the first ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    which: Option<Iterations>,
    /// The iterations asked for, of a part.
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<[u32; 2]>,
    /// Whole iterations done; `settings.iterations` is the number asked for.
    iterations: u32,
    photons: u64,
    #[serde(flatten)]
    renderer: Renderer,
    lanes: Option<LanesName>,
    exposure: Option<f32>,
    tone: Option<Tone>,
    estimated_error: Option<f64>,
    #[serde(skip)]
    scene_file: Option<String>,
    #[serde(skip)]
    fault: Option<String>,
}

/// Runs the command.
pub(crate) fn run(args: &InfoArgs) -> Result<(), Error> {
    let busy = Busy::with(format!("reading {}", one_line(&args.file.to_string_lossy())));
    let info = match Made::read(&args.file) {
        Ok(Made::Image(metadata)) => of_image(*metadata),
        Ok(Made::Checkpoint(loaded)) => of_checkpoint(&loaded, args.scene),
        Err(error) => {
            let other = match Picture::read(&args.file) {
                Ok(picture) if !args.scene => picture,
                // Why an image cannot be read tells more than that it does not say what made it.
                Err(problem) if image_file::read_note(&args.file).is_ok() => {
                    return Err(Error::BadInput(problem));
                }
                _ => return Err(error.into()),
            };
            drop(busy);
            return print((if args.json { json(&other)? } else { other.to_text() }).as_bytes());
        }
    };
    drop(busy);
    if let Some(fault) = &info.fault {
        complain(&format!("warning: {fault}; this is the older generation"));
    }
    if args.scene {
        let path = args.file.display();
        let too_large = || Error::Failed(format!("{path}: its scene is too large to stand in it"));
        return print(info.scene_file.ok_or_else(too_large)?.as_bytes());
    }
    if args.json {
        return print(json(&info)?.as_bytes());
    }
    print(info.to_text().as_bytes())
}

fn json(info: &impl Serialize) -> Result<String, Error> {
    let failed = |error| Error::Failed(format!("cannot make JSON: {error}"));
    Ok(serde_json::to_string_pretty(info).map_err(failed)? + "\n")
}

/// What is known of an image that does not say what made it.
#[derive(Serialize)]
struct Picture {
    /// `image`.
    kind: &'static str,
    format: &'static str,
    /// Such as `8 bits of sRGB`.
    samples: String,
    width: u32,
    height: u32,
    /// The names of an EXR file's layers.
    layers: Vec<String>,
}

impl Picture {
    /// # Errors
    /// If the file is no image that can be read.
    fn read(path: &Path) -> Result<Self, String> {
        let told = |error: FileError| error.to_string();
        let layers = image_file::layer_names(path).map_err(told)?;
        let image = ImageReader::open(path, layers.first().map(String::as_str)).map_err(told)?;
        let ([width, height], format) = (image.size(), image.format().name());
        Ok(Self { kind: "image", format, samples: image.samples().to_string(), width, height, layers })
    }

    fn to_text(&self) -> String {
        let Self { kind, format, samples, width, height, layers } = self;
        let mut text = format!(
            "file       {kind}\nformat     {format}, {samples}\nsize       {width} x {height} pixels\n"
        );
        if !layers.is_empty() {
            text.extend(["layers     ", &one_line(&layers.join(", ")), "\n"]);
        }
        text + "made       not told: only .png and .exr images by sppm say what made them\n"
    }
}

fn of_image(metadata: Metadata) -> Info {
    Info {
        kind: "image",
        version: metadata.version,
        scene: metadata.scene,
        scene_digest: metadata.scene_digest,
        settings: metadata.settings,
        transport: metadata.transport,
        iterations: metadata.settings.iterations,
        which: metadata.which,
        part: None,
        photons: metadata.photons,
        renderer: metadata.renderer,
        lanes: metadata.lanes,
        exposure: metadata.exposure,
        tone: metadata.tone,
        estimated_error: metadata.estimated_error,
        scene_file: metadata.scene_file,
        fault: None,
    }
}

/// The scene file is made only if `has_scene_file`, as it may be long.
fn of_checkpoint(loaded: &Loaded, has_scene_file: bool) -> Info {
    let note = Note::of(loaded);
    let checkpoint = &loaded.checkpoint;
    let account = &checkpoint.account;
    Info {
        kind: "checkpoint",
        version: account.version.clone(),
        scene: checkpoint.scene.name.clone(),
        scene_digest: account.scene.clone(),
        settings: checkpoint.scene.settings,
        transport: account.transport,
        iterations: account.iterations,
        which: account.which.clone(),
        part: note.range,
        photons: account.stats.photons,
        renderer: note.renderer_of(account.sums),
        lanes: None,
        exposure: note.exposure,
        tone: note.tone,
        estimated_error: None,
        scene_file: has_scene_file
            .then(|| scene_file::to_text(&checkpoint.scene, &checkpoint.scene.settings)),
        fault: loaded.fallback.as_ref().map(ToString::to_string),
    }
}

/// The version of a file's light transport, if it is not that of this program.
fn transport(version: u32) -> String {
    if version == TRANSPORT { String::new() } else { format!("{version}; this program computes {TRANSPORT}") }
}

impl Info {
    fn to_text(&self) -> String {
        let Settings {
            width,
            height,
            iterations,
            photons_per_iteration,
            max_depth,
            initial_radius,
            seed,
            filter,
            radius_schedule,
            radius_pilots: _,
            radius_clearance: _,
            light_samples,
            glint_samples,
        } = self.settings;
        let is_usual = radius_schedule == RadiusSchedule::PerPixel;
        let schedule = if is_usual { String::new() } else { format!(", {radius_schedule}") };
        let own = own_radii(&self.settings).map_or(String::new(), |own| format!(" {own}"));
        let of = match iterations {
            MAX_ITERATIONS => " of as many as it takes".into(),
            all if all != self.iterations => format!(" of {all}"),
            _ => String::new(),
        };
        let which = self.which.as_ref().map_or(String::new(), |which| format!(": {which}"));
        let part = self.part.map_or(String::new(), |[start, end]| format!("iterations {start}..{end}"));
        let lanes = self.lanes.map_or(String::new(), |lanes| format!(" on {} lanes", lanes.name()));
        let optional = |value: Option<String>| value.unwrap_or_default();
        let rows = [
            ("file", self.kind.into()),
            ("version", format!("sppm {}", self.version)),
            ("scene", self.scene.clone()),
            ("digest", self.scene_digest.clone()),
            ("size", format!("{width} x {height} pixels")),
            ("iterations", format!("{}{of}{which}", self.iterations)),
            ("part", part),
            ("photons", format!("{} ({photons_per_iteration} per iteration)", self.photons)),
            ("depth", max_depth.to_string()),
            ("radius", format!("{initial_radius}{schedule}{own}")),
            ("glints", if glint_samples == 1 { String::new() } else { format!("{glint_samples} samples") }),
            ("light", if light_samples == 1 { String::new() } else { format!("{light_samples} samples") }),
            ("seed", seed.to_string()),
            ("filter", if filter == Filter::Box { String::new() } else { filter.to_string() }),
            ("method", self.renderer.method.name().into()),
            ("engine", format!("{}{lanes}", self.renderer.engine.name())),
            ("transport", transport(self.transport)),
            ("exposure", optional(self.exposure.map(|stops| format!("{stops} stops")))),
            ("tone", optional(self.tone.map(|tone| tone.to_string()))),
            ("error", optional(self.estimated_error.map(|error| format!("about {error:.3e}, relative")))),
        ];
        let mut text = String::new();
        for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
            let _ = writeln!(text, "{name:<11}{}", one_line(value)); // writing to a String cannot fail
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info() -> Info {
        Info {
            kind: "checkpoint",
            version: "1".into(),
            scene: "cornell".into(),
            scene_digest: "d".into(),
            settings: Settings { iterations: 6, ..Settings::default() },
            transport: TRANSPORT,
            which: None,
            part: None,
            iterations: 6,
            photons: 12,
            renderer: Renderer::default(),
            lanes: None,
            exposure: None,
            tone: None,
            estimated_error: None,
            scene_file: None,
            fault: None,
        }
    }

    /// The value in the row of this name.
    fn told(info: &Info, name: &str) -> Option<String> {
        let text = info.to_text();
        let row = text.lines().find(|row| row.split_whitespace().next() == Some(name));
        row.map(|row| row[11..].to_owned())
    }

    #[test]
    fn iterations_are_told_with_how_many_there_are_to_be() {
        let of = |done, all| {
            let settings = Settings { iterations: all, ..info().settings };
            told(&Info { settings, iterations: done, ..info() }, "iterations").unwrap()
        };
        assert_eq!([of(6, 6), of(5, 6)], ["6", "5 of 6"]);
        assert_eq!(of(5, MAX_ITERATIONS), "5 of as many as it takes");
        assert_eq!(of(MAX_ITERATIONS - 1, MAX_ITERATIONS - 1), (MAX_ITERATIONS - 1).to_string());
    }

    #[test]
    fn what_is_usual_is_not_told() {
        let rows = ["part", "light", "filter", "transport", "exposure", "tone", "error"];
        assert_eq!(rows.map(|row| told(&info(), row)), rows.map(|_| None));
        let settings =
            Settings { light_samples: 4, filter: Filter::Gaussian, radius_pilots: 2, ..info().settings };
        let other = Info {
            settings: Settings { radius_schedule: RadiusSchedule::Global, ..settings },
            transport: TRANSPORT - 1,
            part: Some([3, 5]),
            lanes: Some(LanesName::Avx2),
            exposure: Some(-1.5),
            estimated_error: Some(0.0123),
            ..info()
        };
        let found =
            ["part", "light", "filter", "exposure", "error", "engine"].map(|row| told(&other, row).unwrap());
        let expected = [
            "iterations 3..5",
            "4 samples",
            "gaussian",
            "-1.5 stops",
            "about 1.230e-2, relative",
            "fast on avx2 lanes",
        ];
        assert_eq!(found, expected);
        let radius = told(&other, "radius").unwrap();
        assert!(radius.ends_with(", global at most, by pilots of 2 iterations"), "{radius}");
        let earlier = format!("{}; this program computes {TRANSPORT}", TRANSPORT - 1);
        assert_eq!(told(&other, "transport"), Some(earlier));
    }

    /// Names may be a stranger's: no line break in one begins a row, and nothing in it reaches the terminal as a command.
    #[test]
    fn a_value_is_one_row_whatever_it_holds() {
        let odd = Info { scene: "a\nseed       7\u{1b}[2J".into(), ..info() };
        assert_eq!(told(&odd, "scene").as_deref(), Some("a\\nseed       7\\u{1b}[2J"));
        assert_eq!(odd.to_text().lines().count(), info().to_text().lines().count());
    }

    #[test]
    fn layers_are_told_if_there_are_any() {
        let of = |layers: &[&str]| {
            let layers = layers.iter().map(|layer| (*layer).to_owned()).collect();
            let samples = "floats".into();
            Picture { kind: "image", format: "EXR", samples, width: 3, height: 2, layers }.to_text()
        };
        assert!(of(&["left", "right"]).contains("\nlayers     left, right\n"));
        assert!(of(&["left\nright", "b"]).contains("\nlayers     left\\nright, b\n"));
        assert!(!of(&[]).contains("layers"));
        assert!(of(&[]).contains("\nsize       3 x 2 pixels\n"));
    }
}
