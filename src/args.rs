//! The command line: commands, options and the help that teaches them.

mod lasting;

pub(crate) use lasting::{CheckpointArgs, EngineArgs, GoalArgs, InfoArgs, MessageArgs, ResumeArgs};

use crate::commands::compare::CompareArgs;
use crate::commands::ladder::LadderArgs;
use crate::commands::verify::VerifyArgs;
use crate::engines::{LanesName, TracerName};
use crate::export::Format;
use crate::threads::MAX_THREADS;
use crate::tune_command::args::TuneArgs;
use crate::values::{amount, number, whole};
use clap::{Args as ClapArgs, Parser, Subcommand, ValueHint};
use clap_complete::Shell;
use scene::settings::{BYTES_PER_PIXEL, MAX_DEPTH, MAX_ITERATIONS, MAX_PHOTONS, MAX_SIDE, RADIUS_RANGE};
use std::ffi::OsString;
use std::path::PathBuf;

/// Render scenes of spheres with full global illumination, caustics and all
///
/// sppm renders by stochastic progressive photon mapping (Hachisuka and Jensen 2009). Every iteration sends one
/// ray per pixel from the eye and a batch of photons from the lights; photons that land near what a pixel sees add
/// to its radiance. As iterations go by the search radius of each pixel shrinks, and the image converges.
///
/// An image is a function of scene, settings and seed: the same on any machine, with any number of threads.
#[derive(Debug, Parser)]
#[command(name = "sppm", version, after_long_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub command: Command,
}

/// What a photon would take if it were kept: where it lands, where it came from, and its flux, three floats each.
const BYTES_PER_PHOTON: u64 = 36;

const EXAMPLES: &str = "\
Examples:
  sppm render cornell                      cornell.png, by the scene's own settings
  sppm render cornell -o box.exr -n 64     linear radiance, 64 iterations
  sppm scenes                              what can be rendered by name
  sppm scenes cornell > mine.toml          a scene file to start from
  sppm render mine.toml
  sppm resume cornell.png.sppm             go on with a render that was interrupted
  sppm compare box.exr truth.exr --max-flip 0.05

Exit codes: 0 done; 1 failed while running, or the answer is no; 2 bad input; 130 ended by Ctrl-C, 143 by
SIGTERM, 129 by SIGHUP.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Render(RenderArgs),
    Resume(ResumeArgs),
    Info(InfoArgs),
    Scenes(ScenesArgs),
    Compare(CompareArgs),
    Verify(VerifyArgs),
    Trace(TraceArgs),
    Export(ExportArgs),
    Ladder(LadderArgs),
    Tune(TuneArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
}

/// Render a scene to an image file
///
/// Ctrl-C (SIGTERM, SIGHUP) writes a checkpoint and the image as it stands after the last whole iteration, says so, and
/// exits with 130 (143, 129); a second one exits at once, and tears no file.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = RENDER_EXAMPLES)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub source: SourceArgs,

    #[command(flatten)]
    pub outputs: OutputArgs,

    #[command(flatten)]
    pub settings: SettingsArgs,

    #[command(flatten)]
    pub goals: GoalArgs,

    #[command(flatten)]
    pub checkpoints: CheckpointArgs,

    #[command(flatten)]
    pub engine: EngineArgs,

    #[command(flatten)]
    pub messages: MessageArgs,
}

/// What is rendered: a scene, or what was rendered before.
#[derive(Debug, ClapArgs)]
pub(crate) struct SourceArgs {
    /// A built-in scene (see `sppm scenes`), or a scene file ending in .toml
    #[arg(value_name = "SCENE", required_unless_present = "like")]
    pub scene: Option<OsString>,

    /// Repeat the render that wrote FILE, an image or a checkpoint: its scene, settings, engine and exposure, but for
    /// what other options say
    ///
    /// A scene of more than a mebibyte is not in the file; then SCENE must be given too, and is checked to be the same.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub like: Option<PathBuf>,
}

/// The files that a render writes.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// The image to write: .png (sRGB), .exr or .pfm (linear floats) [default: the scene's name, .png]
    ///
    /// Files are written beside their place and then renamed into it, so that nobody ever sees half an image.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Make a .png brighter or darker by so many stops, each a factor of 2
    #[arg(long, value_name = "E", value_parser = number(-100.0, 100.0), allow_hyphen_values = true)]
    pub exposure: Option<f32>,

    /// Also write the image after 1, 2, 4, 8, ... iterations, as OUT-0001.png and so on
    #[arg(long)]
    pub snapshots: bool,

    /// Write the last search radius of every pixel, in scene units (as .exr or .pfm; in a .png the largest is white)
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

const RENDER_EXAMPLES: &str = "\
Examples:
  sppm render cornell
  sppm render mirror -o mirror.exr --width 1024 --height 768 --iterations 200
  sppm render surgery --depth 64 --radius 1 --photons 1000000 --stats surgery.json
  sppm render cornell --engine path --iterations 1024 -o truth.exr
  sppm render surgery --time 10m --until-error 0.02
  sppm render --like mirror.exr -o again.exr

What settings do:
  More iterations remove noise and bias both. A smaller first radius means less blur and more noise.
  A depth of 5, the paper's, is quick and makes closed rooms 6 to 13 % too dark; 64 is as good as all of it.
  Lengths are in the scene's own unit; radiance is linear, in W sr^-1 m^-2 per channel.";

/// What is rendered.
#[derive(Debug, ClapArgs)]
pub(crate) struct SceneArg {
    /// A built-in scene (see `sppm scenes`), or a scene file ending in .toml
    #[arg(value_name = "SCENE")]
    pub name: OsString,
}

/// What overrides the scene's own settings.
#[derive(Debug, Default, ClapArgs)]
#[command(next_help_heading = "Settings (each defaults to the scene's own)")]
pub(crate) struct SettingsArgs {
    /// Width of the image, in pixels
    #[arg(long, value_name = "W", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub width: Option<u32>,

    /// Height of the image, in pixels
    #[arg(long, value_name = "H", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub height: Option<u32>,

    /// Iterations; for the path tracer, samples per pixel
    #[arg(short = 'n', long, value_name = "N", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<u32>(1, MAX_ITERATIONS.into()))]
    pub iterations: Option<u32>,

    /// Photons that leave the lights in each iteration
    ///
    /// More of them smooth indirect light and caustics; direct light only takes more iterations.
    #[arg(long, value_name = "L", value_parser = amount(MAX_PHOTONS, BYTES_PER_PHOTON), allow_hyphen_values = true)]
    pub photons: Option<u32>,

    /// Most segments of a path: from the eye to the first diffuse hit, and from there to the light
    ///
    /// A glass ball before the eye takes 3 of the first, light that comes through another 3 of the second.
    #[arg(long, value_name = "D", value_parser = whole::<u32>(1, MAX_DEPTH.into()), allow_hyphen_values = true)]
    pub depth: Option<u32>,

    /// Search radius of the first iteration, in scene units
    ///
    /// Photons count within it, so indirect light is blurred over it. It shrinks as photons come, slowly: to a half
    /// after some 25 iterations, to a third after 300. A hundredth of the width of what is seen is a good start.
    #[arg(long, value_name = "R", value_parser = number(RADIUS_RANGE[0], RADIUS_RANGE[1]), allow_hyphen_values = true)]
    pub radius: Option<f32>,

    /// Seed of all random numbers: the same seed gives the same bytes, another seed other noise
    #[arg(long, value_name = "S", value_parser = whole::<u64>(0, u64::MAX), allow_hyphen_values = true)]
    pub seed: Option<u64>,
}

/// What the image does not depend on.
#[derive(Debug, ClapArgs)]
pub(crate) struct MachineArgs {
    /// Threads that work [default: one per core]; the image does not depend on it
    #[arg(long, value_name = "T", help_heading = "Machine", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<usize>(1, MAX_THREADS))]
    pub threads: Option<usize>,
}

/// List the built-in scenes, or print one as a scene file to start from
#[derive(Debug, ClapArgs)]
#[command(after_long_help = "Example:\n  sppm scenes cornell > mine.toml && sppm render mine.toml")]
pub(crate) struct ScenesArgs {
    /// The scene whose file to print; without a name, all are listed
    #[arg(value_name = "NAME")]
    pub name: Option<OsString>,
}

/// Tell what rays hit, from and into npy files
///
/// IN.npy holds an array of float32 of shape (N, 6): per ray its origin and its direction. A direction may have any
/// length but zero. Rays start in free space: one that starts behind an opaque surface (in a ball, or outside of
/// the room) meets that surface at distance 0 or passes it.
///
/// OUT.npy gets N records: t (float32), the distance in scene units (not in lengths of the direction), infinite for a
/// miss; sphere (int32), the place of the sphere in the scene file, from 0, or -1 for a miss (a background counts as
/// one more sphere, the last); and normal (3 of float32), of unit length on the side that the ray comes from, or zero.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = TRACE_EXAMPLES)]
pub(crate) struct TraceArgs {
    #[command(flatten)]
    pub scene: SceneArg,

    /// The rays to trace
    #[arg(long, value_name = "IN.npy")]
    pub rays: PathBuf,

    /// The file to write
    #[arg(long, value_name = "OUT.npy")]
    pub hits: PathBuf,

    /// When, in shutter time [default: when the shutter opens]
    #[arg(long, value_name = "T", value_parser = number(-1e15, 1e15), allow_hyphen_values = true)]
    pub time: Option<f32>,

    /// Whose intersections; both give the same bits
    #[arg(long, value_enum, default_value = "fast", help_heading = "Machine")]
    pub engine: TracerName,

    /// The vectors that the fast engine runs on [default: auto]
    #[arg(long, value_enum, value_name = "LANES", help_heading = "Machine")]
    pub lanes: Option<LanesName>,

    #[command(flatten)]
    pub machine: MachineArgs,
}

const TRACE_EXAMPLES: &str = "\
Example:
  python -c 'import numpy; numpy.save(\"rays.npy\", numpy.float32([[50, 50, 200, 0, 0, -1]]))'
  sppm trace cornell --rays rays.npy --hits hits.npy
  python -c 'import numpy; print(numpy.load(\"hits.npy\")[\"t\"])'";

/// Write a scene in the format of another renderer
///
/// The file asks that renderer for a path tracer of unlimited depth, which converges to the same image as sppm does
/// with a large --depth. What the format cannot express is refused, or, where the image differs but little, told in
/// the file and on standard error.
#[derive(Debug, ClapArgs)]
#[command(after_long_help = EXPORT_EXAMPLES)]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    pub scene: SceneArg,

    /// The renderer to write for
    #[arg(long, value_enum)]
    pub format: Format,

    /// The file to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Freeze the scene at this instant, in shutter time
    #[arg(long, value_name = "T", value_parser = number(-1e15, 1e15), allow_hyphen_values = true)]
    pub time: Option<f32>,

    /// Width of the image, in pixels [default: the scene's own]
    #[arg(long, value_name = "W", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub width: Option<u32>,

    /// Height of the image, in pixels [default: the scene's own]
    #[arg(long, value_name = "H", value_parser = amount(MAX_SIDE, BYTES_PER_PIXEL), allow_hyphen_values = true)]
    pub height: Option<u32>,

    /// Samples per pixel
    #[arg(long, value_name = "N", default_value = "256", allow_hyphen_values = true)]
    #[arg(value_parser = whole::<u32>(1, MAX_ITERATIONS.into()))]
    pub samples: u32,
}

const EXPORT_EXAMPLES: &str = "\
Examples:
  sppm export cornell --format mitsuba -o cornell.xml && mitsuba -m scalar_rgb cornell.xml
  sppm export motion --format mitsuba --time 0.5 -o motion.xml
  sppm export surgery --format pbrt -o surgery.pbrt";

/// Print a script that completes commands and options in a shell
#[derive(Debug, ClapArgs)]
#[command(
    after_long_help = "Example:\n  sppm completions bash > ~/.local/share/bash-completion/completions/sppm"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub shell: Shell,
}

/// Print the manual page, or write those of all commands into a folder
#[derive(Debug, ClapArgs)]
#[command(after_long_help = "Examples:\n  sppm man | man -l -\n  sppm man ~/.local/share/man/man1")]
pub(crate) struct ManArgs {
    /// The folder to write the pages into
    #[arg(value_name = "DIR")]
    pub folder: Option<PathBuf>,
}
